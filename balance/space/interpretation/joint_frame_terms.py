"""Inertia of a body in the frame of a joint, as terms for a transfer.

A point mass on the axis, displacements along and across it, and rods: along the axis, in ±
pairs across it, and oblique to it; or rods in six directions, if that takes fewer terms.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from balance.space.inertial_parameters.multipole import NOUNS, Primitive
from balance.space.interpretation.terms import Term
from balance.space.spaces.design_space import DesignSpace
from balance.space.transfers.by_joint import Transfer
from balance.support.tolerances import AXIS_OFFSET_CLEAR, GEOMETRY_EQUAL
from kinematics.model.linkage import Joint
from kinematics.model.plane import plane_axes
from kinematics.numerics.linalg.vectors import distinct_vectors, project_out

Array = NDArray[np.float64]


def joint_frame_terms(space: DesignSpace, transfer: Transfer) -> Iterator[list[Term]]:
    """Yield ways to decompose the parameters of one body, with as many terms as parameters.

    The body is the first of the transfer. There is a way for each direction in which its
    joints turn or slide, or mass may be displaced.

    Args:
        transfer: one of its transfers.
    """
    body = transfer.bodies[0]
    joints = [space.linkage.joints[j] for j in space.linkage.positions_of(transfer.joints)]
    # Where bodies are rigidly joined, or rest, the frame of the body is used.
    point = joints[0].point if joints else space.frames[space.bodies.index(body)][:3, 3]
    place = " on the axis" if len(joints) == 1 and not space.planar else " at the centre"
    for n in _directions(space, transfer, joints):
        axes = _axes(space, n, point)
        masses = _masses(body, point, axes, place)
        if not joints:
            masses = [term._replace(name=NOUNS[term.primitives[0].kind]) for term in masses]
        if space.balance == "force":
            yield masses
        elif space.planar:
            yield [*masses, Term("rod", (_rod(body, axes[0]),))]
        else:
            yield [*masses, *_six_rods(body, *axes)]
            if joints:
                yield [*masses, *_rods_by_axis(body, *axes)]


def _directions(space: DesignSpace, transfer: Transfer, joints: list[Joint]) -> list[Array]:
    """List unit vectors along the joints and the possible displacements, without repetition.

    In a plane only those in it; its own axes if there is none.
    """
    moved = transfer.basis.reshape(len(space.bodies), len(space.labels), -1)
    count = 2 if space.planar else 3
    moved = moved[space.bodies.index(transfer.bodies[0])]
    free = moved[1 : 1 + count] @ _null_space_of_row(moved[0])
    some = [j.screw[3:] if j.kind == "prismatic" else j.screw[:3] for j in joints]
    some += list(free.T @ space.axes[:count])
    if space.planar:
        some = [project_out(a, space.axes[2]) for a in some]
    unit = [
        a / size for a in some if (size := np.linalg.norm(a)) > GEOMETRY_EQUAL * space.length
    ]
    first = distinct_vectors(
        unit, lambda few, a: np.linalg.norm(np.cross(few, a), axis=1) <= GEOMETRY_EQUAL
    )
    directions = [unit[k] for k in first]
    return directions or [space.axes[0] if space.planar else space.axes[2]]


def _null_space_of_row(row: Array) -> Array:
    """Compute combinations (n, d) that make a row of numbers (n,) vanish."""
    if not row.any():
        return np.eye(row.size)
    return np.linalg.svd(row[None])[2][1:].T


def _axes(space: DesignSpace, n: Array, point: Array) -> Array:
    """Choose axes as rows: the first along n, the second towards another joint."""
    if space.planar:
        return np.array([n, np.cross(space.axes[2], n)])
    for joint in space.linkage.joints:
        across = np.cross(n, joint.point - point)
        if np.linalg.norm(across) > AXIS_OFFSET_CLEAR * space.length:
            across /= np.linalg.norm(across)
            return np.array([n, np.cross(across, n), across])
    x, y, _ = plane_axes(n)
    return np.array([n, x, y])


def _masses(body: str, point: Array, axes: Array, place: str) -> list[Term]:
    """List the point mass and its displacements."""
    terms = [Term(f"point mass{place}", (Primitive("mass", body, 1.0, point),))]
    for k, a in enumerate(axes):
        name = f"displacement {'across' if k else 'along'} the axis"
        terms.append(Term(name, (Primitive("displacement", body, 1.0, point, a),)))
    return terms


def _rods_by_axis(body: str, n: Array, x: Array, y: Array) -> list[Term]:
    """List six independent terms of rods with the axis n among them."""
    across, oblique = "± pair of rods across the axis", "± pair of rods oblique to the axis"
    return [
        Term("rod along the axis", (_rod(body, n),)),
        Term(across, (_rod(body, x), _rod(body, y, -1.0))),
        Term(across, (_rod(body, x + y), _rod(body, x - y, -1.0))),
        Term("rod across the axis", (_rod(body, x),)),
        Term(oblique, (_rod(body, n + x), _rod(body, n - x, -1.0))),
        Term(oblique, (_rod(body, n + y), _rod(body, n - y, -1.0))),
    ]


def _six_rods(body: str, n: Array, x: Array, y: Array) -> list[Term]:
    """List rods in six directions, with equal names."""
    return [Term("rod", (_rod(body, b),)) for b in (n, x, y, n + x, n + y, x + y)]


def _rod(body: str, b: Array, value: float = 1.0) -> Primitive:
    """Make a rod along b, which may have any length."""
    return Primitive("rod", body, value, None, b / np.linalg.norm(b))
