"""Find loops that several dialects of one file give, and count them once.

Loop A implies loop B if every displacement that A leaves free satisfies B. It is tested at
random displacements: the residual of B vanishes at all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from kinematics.files.urdf.loop_joints import freedoms_of_joint, perpendicular_to, unit_vector
from kinematics.files.urdf.robot_tree import pose_matrix
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import DEGREES_OF_FREEDOM
from kinematics.model.spatial.screws import exp, revolute
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import REPEATED_LOOP, UNIVERSAL_AXES_PARALLEL_SINE

Place = Callable[[str], tuple[str, list[Element | None]]]

# Random displacements at which a loop is tested.
SAMPLES = 4


class _Closure(NamedTuple):
    """A loop between two rigid bodies.

    Attributes:
        element: the loop.
        kind: its type.
        bodies: names of the rigid bodies of predecessor and successor.
        frames: poses of the frames of the loop on them (4, 4).
        n: axis (3,), in the frame on the predecessor.
        second: second axis of a universal loop (3,), in the frame on the successor.
    """

    element: Element
    kind: str
    bodies: tuple[str, str]
    frames: tuple[Array, Array]
    n: Array
    second: Array


def find_repeated(
    loops: Sequence[tuple[Element, str]], place: Place
) -> list[tuple[Element, Element]]:
    """Find loops that another loop of the same two bodies, of another dialect, implies.

    Args:
        loops: checked loops, and the dialect of each, those to prefer first.
        place: a function that gives the rigid body of a link, and the ``<origin>``s from it to
            the link.

    Returns:
        Each such loop, and the loop that implies it, which has as few freedoms or fewer.
    """
    closures = [(_closure(loop, place), dialect) for loop, dialect in loops]
    closures.sort(key=lambda pair: DEGREES_OF_FREEDOM[pair[0].kind])
    kept: list[tuple[_Closure, str]] = []
    repeated = []
    for closure, dialect in closures:
        stronger = (
            other
            for other, origin in kept
            if origin != dialect
            and set(other.bodies) == set(closure.bodies)
            and _implies(other, closure)
        )
        first = next(stronger, None)
        if first is None:
            kept.append((closure, dialect))
        else:
            repeated.append((closure.element, first.element))
    return repeated


def _closure(loop: Element, place: Place) -> _Closure:
    """Read a loop as numbers."""
    bodies, frames = [], []
    for role in ("predecessor", "successor"):
        side = loop.first(role) or loop
        body, origins = place(side.attributes["link"])
        pose = np.eye(4)
        for origin in (*origins, side.first("origin")):
            pose = pose @ pose_matrix(origin)
        bodies.append(body)
        frames.append(pose)
    axis, axis2 = loop.first("axis"), loop.first("axis2")
    n = unit_vector(axis.vector("xyz", "") if axis else [1.0, 0.0, 0.0])
    second = unit_vector(axis2.vector("xyz", "")) if axis2 else perpendicular_to(n)
    return _Closure(
        loop, loop.attributes["type"], (bodies[0], bodies[1]), (frames[0], frames[1]), n, second
    )


def _implies(closure: _Closure, other: _Closure) -> bool:
    """Return whether a loop implies another loop between the same bodies."""
    frames = (*closure.frames, *other.frames)
    size = max(float(np.abs(frame[:3, 3]).max()) for frame in frames) or 1.0
    rng = np.random.default_rng(0)
    for _ in range(SAMPLES):
        start, end = closure.frames
        X = start @ _displacement(closure, rng, size) @ np.linalg.inv(end)
        if closure.bodies != other.bodies:
            X = np.linalg.inv(X)
        M = np.linalg.inv(other.frames[0]) @ X @ other.frames[1]
        if _residual(other, M, size) > REPEATED_LOOP:
            return False
    return True


def _displacement(loop: _Closure, rng: np.random.Generator, size: float) -> Array:
    """Pose (4, 4) of the frame on the successor, in that on the predecessor, at random."""
    D = np.eye(4)
    if loop.kind == "universal":
        D = exp(revolute(loop.n, np.zeros(3)), rng.uniform(-1, 1))
        across = np.cross(loop.n, loop.second)
        aligned = np.linalg.norm(across) <= UNIVERSAL_AXES_PARALLEL_SINE
        u = perpendicular_to(loop.n) if aligned else unit_vector(across)
        # A quarter turn takes the second axis to u, at a right angle to the first.
        D = D @ exp(revolute(np.cross(loop.second, u), np.zeros(3)), np.pi / 2)
        return D @ exp(revolute(loop.second, np.zeros(3)), rng.uniform(-1, 1))
    steps = freedoms_of_joint(loop.kind, loop.n, perpendicular_to(loop.n), np.zeros(3))
    for motion, screw in steps:
        unit = size if motion == "prismatic" else 1.0
        D = D @ exp(screw, unit * rng.uniform(-1, 1))
    return D


def _residual(loop: _Closure, M: Array, size: float) -> float:
    """How far a pose (4, 4) of the successor's frame is from one that a loop allows."""
    R, d, n = M[:3, :3], M[:3, 3] / size, loop.n
    turned = np.abs(R @ n - n).max()
    parts = {
        "fixed": [np.abs(R - np.eye(3)).max(), np.abs(d).max()],
        "revolute": [turned, np.abs(d).max()],
        "continuous": [turned, np.abs(d).max()],
        "prismatic": [np.abs(R - np.eye(3)).max(), np.abs(np.cross(n, d)).max()],
        "cylindrical": [turned, np.abs(np.cross(n, d)).max()],
        "planar": [turned, abs(n @ d)],
        "spherical": [np.abs(d).max()],
        "universal": [np.abs(d).max(), abs(n @ R @ loop.second)],
    }
    # A floating joint allows every pose: it repeats no other loop, and is judged as it is.
    return float(max(parts.get(loop.kind, [np.inf])))
