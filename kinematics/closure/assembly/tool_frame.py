"""Tool coordinates as inputs (inverse kinematics), by virtual joints from the ground to a link.

A weld of the tool to the far end of prismatic and revolute joints makes one more loop; with
those joints as inputs, the joints of the robot follow from it like those of any other linkage.
(A. Campos, R. Guenther and D. Martins, "Differential kinematics of serial manipulators using
virtual chains", J. Braz. Soc. Mech. Sci. Eng. 27, 2005.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np
from numpy.typing import ArrayLike

from kinematics.closure.assembly.assemble import assemble
from kinematics.closure.joint_positions import input_chain, joint_positions
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand, expand_from
from kinematics.errors import BodyError, CoordinateError, PoseError
from kinematics.model.arrays import freeze
from kinematics.model.chain import arrange_loops, move_chain
from kinematics.model.linkage import (
    GROUND,
    Joint,
    Linkage,
    LinkPose,
    Loop,
    UnassembledLinkage,
    names_of,
)
from kinematics.model.spatial.screws import prismatic, revolute
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import project_out
from kinematics.numerics.tolerances import REMAINING_FREEDOM

# Shifts along the inertial axes; then turns about x, about the y that it carries along, and
# about the z that both carry along.
DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
# Frames in which a point may be given.
FRAMES = ("inertial", "link")
# Step of the inputs to a pose nearby, radians and characteristic lengths, times √2, √3 …
NEARBY_STEP = 0.05


def tool(
    linkage: Linkage,
    link: str,
    directions: str | Sequence[str],
    point: ArrayLike | None = None,
    *,
    frame: str = "inertial",
) -> Linkage:
    """Make the coordinates of a tool the inputs of a linkage, as inverse kinematics needs.

    Directions that are not named are held where they are, one after the other, as far as
    that leaves those named free to move; the others follow. So a robot with six joints moves
    along ``"x"`` without turning, and the tip of a five-bar along ``"x,y"`` while it turns.

    Args:
        linkage: an assembled linkage.
        link: name of the link that is the tool, with or without mass.
        directions: of `DIRECTIONS`, the new inputs in this order: ``"x,y"`` or a sequence.
            ``x``, ``y``, ``z`` are shifts along the inertial axes, in metres; ``rx``, ``ry``,
            ``rz`` are turns about moving axes, in radians.
        point: the point of the tool that moves and about which it turns (3,), metres; the
            origin of the link's frame by default.
        frame: in which frame the point is given: ``"inertial"``, at the reference pose, or
            ``"link"``, that of the link in the file, with which the point moves.

    Returns:
        The linkage with inputs ``link.x`` …. Where it has more freedom than the tool uses,
        joints of its own complete them, and a notice names these.

    Raises:
        BodyError: the link does not exist or is a tool already, or the point is not three
            finite numbers.
        CoordinateError: a direction does not exist or cannot be an input: the link cannot move
            that way, or other directions determine it.
        ValueError: the frame does not exist.

    Example:
        >>> from kinematics import load, tool
        >>> linkage = load("robot.urdf")
        >>> tool(linkage, "coupler", "x").inputs
        ('coupler.x',)
    """
    if frame not in FRAMES:
        raise ValueError(f"the frame of a point is one of {', '.join(FRAMES)}, not {frame!r}")
    carrier, at = find_carrier(linkage, link, point, frame)
    named = _direction_numbers(linkage, directions)
    held = _choose_held_directions(linkage, carrier, at, named)
    joints = (*linkage.joints, *_virtual_joints(linkage, link, at, held))
    draft = UnassembledLinkage(
        **{f.name: getattr(linkage, f.name) for f in fields(UnassembledLinkage)}
    )
    draft = replace(
        draft,
        joints=joints,
        loops=(*linkage.loops, Loop(f"{link}.tool", len(joints) - 1, carrier)),
        tree=None,
        other_poses=(),
    )
    return assemble(draft, [tool_coordinates(link)[k] for k in named])


def tool_coordinates(link: str) -> tuple[str, ...]:
    """List the names of the coordinates of a tool, in the order of `DIRECTIONS`."""
    return tuple(f"{link}.{direction}" for direction in DIRECTIONS)


def _virtual_joints(linkage: Linkage, link: str, at: Array, held: Sequence[int]) -> list[Joint]:
    """Make the chain of joints from the ground to a tool, for directions that are not held."""
    screws = [prismatic(axis) for axis in np.eye(3)]
    screws += [revolute(axis, at) for axis in np.eye(3)]
    joints: list[Joint] = []
    for k, name in enumerate(tool_coordinates(link)):
        if k not in held:
            kind = "prismatic" if k < 3 else "revolute"
            parent = len(linkage.joints) + len(joints) - 1 if joints else GROUND
            joints.append(Joint(name, kind, parent, freeze(screws[k]), freeze(at), True))
    return joints


def find_carrier(
    linkage: Linkage, link: str, point: ArrayLike | None, frame: str
) -> tuple[int, Array]:
    """Find the rigid body that carries the tool, and the tool's point (3,), inertial."""
    bodies = {body.name: LinkPose(body.link, body.frame) for body in linkage.bodies}
    moving = bodies | {n: place for n, place in linkage.places.items() if place.link != GROUND}
    if link not in moving:
        raise BodyError(linkage.source, link, "no moving link of this name", list(moving))
    if set(tool_coordinates(link)) & set(names_of(linkage.joints)):
        raise BodyError(linkage.source, link, "is a tool already; give another link")
    carrier, pose = moving[link]
    if point is None:
        return carrier, pose[:3, 3]
    at = np.asarray(point, dtype=np.float64)
    if at.shape != (3,) or not np.isfinite(at).all():
        problem = f"its point is not of three finite numbers; give metres, in the {frame} frame"
        raise BodyError(linkage.source, link, problem)
    return carrier, pose[:3, :3] @ at + pose[:3, 3] if frame == "link" else at


def _direction_numbers(linkage: Linkage, directions: str | Sequence[str]) -> list[int]:
    """Read the numbers of directions, in the order in which they are named."""
    names = directions.split(",") if isinstance(directions, str) else list(directions)
    names = [name.strip() for name in names]
    for k, name in enumerate(names):
        if name not in DIRECTIONS or name in names[:k]:
            problem = "named twice" if name in DIRECTIONS else "no direction of a tool"
            raise CoordinateError(linkage.source, [name], problem, DIRECTIONS)
    if not names:
        raise CoordinateError(linkage.source, ["tool"], "no direction is named", DIRECTIONS)
    return [DIRECTIONS.index(name) for name in names]


def _choose_held_directions(
    linkage: Linkage, link: int, at: Array, named: Sequence[int]
) -> list[int]:
    """Choose the unnamed directions that can be held, at first order at the reference pose.

    Raises:
        CoordinateError: a direction that is named depends on those before it.
    """
    rates = _tool_jacobian(linkage, link, at)
    size = float(np.abs(rates).max(initial=0.0))
    basis = np.empty((0, rates.shape[1]))
    free = [k for k in range(6) if np.abs(rates[k]).max(initial=0.0) > REMAINING_FREEDOM * size]
    held = []
    for k in (*named, *(k for k in range(6) if k not in named)):
        residual = project_out(rates[k], basis.T)
        residual_size = float(np.linalg.norm(residual))
        if residual_size > REMAINING_FREEDOM * size:
            basis = np.vstack([basis, residual / residual_size])
            if k not in named:
                held.append(k)
        elif k in named:
            problem = "the tool cannot move this way at the reference pose"
            if k in free:
                others = ", ".join(DIRECTIONS[i] for i in named[: list(named).index(k)])
                problem = f"depends on {others} at the reference pose"
                here, near = _freedoms(rates), _freedoms(_rates_nearby(linkage, link))
                if here < near:
                    problem += (
                        f", a singular one, where the tool has {here} freedoms, and {near} "
                        "nearby (a wrist is straight, or an arm stretched): leave the "
                        "direction out, or start elsewhere (--at)"
                    )
            raise CoordinateError(
                linkage.source, [DIRECTIONS[k]], problem, [DIRECTIONS[i] for i in free]
            )
    return held


def _freedoms(rates: Array) -> int:
    """Count the independent motions of the tool at first order."""
    sizes = np.linalg.svd(rates, compute_uv=False)
    return int(np.count_nonzero(sizes > REMAINING_FREEDOM * np.abs(rates).max(initial=0.0)))


def _rates_nearby(linkage: Linkage, link: int) -> Array:
    """Compute the twists of the tool at a pose nearby (6, mobility); none if it cannot be met.

    The pose is at steps of the inputs that no symmetry of a linkage shares.
    """
    chain = input_chain(linkage)
    steps = NEARBY_STEP * np.sqrt(np.arange(2.0, 2.0 + linkage.mobility))
    units = chain.units[linkage.positions_of(linkage.inputs)]
    try:
        q = joint_positions(linkage, steps * units) / chain.units
    except PoseError:
        return np.zeros((6, linkage.mobility))
    screws = forward_kinematics(chain, q).screws
    return np.asarray(expand_from(chain, screws, np.zeros((1, chain.width)), 0).T[0, 0, link].T)


def _tool_jacobian(linkage: Linkage, link: int, at: Array) -> Array:
    """Compute the Jacobian of the tool: velocity, then angular velocity (6, mobility).

    The velocity is that of the tool's point, for unit rates of the inputs, in chain units.
    """
    independent = linkage.positions_of(linkage.inputs)
    chain = move_chain(arrange_loops(linkage), independent, np.eye(linkage.mobility))
    twists = expand(chain, np.zeros((1, chain.width)), 0).T[0, 0, link].T
    point = (at - chain.frame.origin) / chain.frame.length
    velocity = twists[3:] + np.cross(twists[:3], point[:, None], axis=0)
    return np.concatenate([velocity, twists[:3]])
