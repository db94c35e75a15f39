"""Counter-rotors on revolute joints: candidates, and the conditions with their momenta.

A counter-rotor on joint j spins against it about a parallel axis and adds the momentum
``-J n q̇_j``, a moment alone, with ``J ≥ 0``. The axis n and the rate q̇_j move with the pose.
Besides that it is a part of the rigid body that carries it, so that its mass and its place
count among the masses of that body.

The conditions come from one linkage with a rotor on every candidate: a further body on a
joint that follows ``-q_j``. Its inertia ``E = J n nᵀ`` has the momentum ``J n nᵀ ω - J n q̇_j``,
where ω belongs to the carrier; the first term is that of the same inertia on the carrier, and
is taken off. A rotor of gear N needs the axial inertia ``J / N``, and is at least a thin disc:
its carrier then has ``(J / N) (n nᵀ + 1) / 2`` besides a body that can be built.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.added_masses.program import orthonormal_conditions
from balance.designs.pseudo_inertia_cone import given_parameters
from balance.inertial_parameters.conversions import to_chain
from balance.spaces.compute_space import design_space
from balance.spaces.design_space import DesignSpace
from balance.tolerances import FIXED_RANK_RELATIVE, ROTOR_WITHOUT_MOMENTUM
from kinematics.assembly.assemble import assemble
from kinematics.model.arrays import freeze
from kinematics.model.chain import path
from kinematics.model.linkage import (
    GROUND,
    Body,
    Joint,
    Linkage,
    Mimic,
    UnassembledLinkage,
)
from kinematics.spatial.inertia import parameters

__all__ = ["RotorConditions", "candidate_joints", "has_fixed_axis", "rotor_conditions"]

Array = NDArray[np.float64]


class RotorConditions(NamedTuple):
    """The balance conditions of a linkage with counter-rotors, in the units of a chain.

    ``bodies @ z + rotors @ J = 0`` for every balanced distribution. The rows of both, side by
    side, are orthonormal.

    Attributes:
        space: the design space of the linkage without rotors.
        joints: joints with a rotor (k,).
        bodies: conditions on the counted parameters of all bodies (ρ, parameters).
        rotors: conditions on the momenta J of the rotors (ρ, k).
        given: counted parameters of the masses in the file (parameters,), kg.
        length: unit of length, metres.
        sure: whether all conditions are known, so that designs are balanced.
        encloses: whether every balanced distribution fulfils them.
    """

    space: DesignSpace
    joints: tuple[str, ...]
    bodies: Array
    rotors: Array
    given: Array
    length: float
    sure: bool
    encloses: bool


def candidate_joints(linkage: Linkage) -> tuple[str, ...]:
    """List the joints that may have a counter-rotor.

    These are the revolute joints of the tree between links that carry parameters, or one such
    link and the ground. Joints of several freedoms are none, whether they are written as one
    or as several joints with massless links between them. Joints that only close a loop are
    none either: no joint of a file can follow them.
    """
    carry = {GROUND, *(body.link for body in linkage.bodies)}
    return tuple(
        joint.name
        for j, joint in enumerate(linkage.joints)
        if joint.kind == "revolute"
        and not (joint.in_loop or joint.numbered or joint.name in linkage.idle)
        and {j, joint.parent} <= carry
    )


def has_fixed_axis(linkage: Linkage, joint: int) -> bool:
    """Return whether the axis of a joint keeps its direction, so that its rotor may be fixed.

    It does where every joint before it slides or has a parallel axis.

    Args:
        linkage: the linkage.
        joint: index of the joint.
    """
    axis = linkage.joints[joint].screw[:3]
    before = path([one.parent for one in linkage.joints], linkage.joints[joint].parent)
    turns = np.array([linkage.joints[j].screw[:3] for j in before]).reshape(-1, 3)
    return not np.abs(np.cross(turns, axis)).max(initial=0.0) > FIXED_RANK_RELATIVE


def rotor_conditions(
    space: DesignSpace, joints: Sequence[str] | None = None, gear: float = np.inf
) -> RotorConditions:
    """Compute the balance conditions of a linkage with counter-rotors.

    Args:
        space: the design space of the linkage, for dynamic balance.
        joints: joints with a rotor; all candidates by default. Rotors that add no momentum,
            because their joint does not move, are left out.
        gear: turns of a rotor for one turn of its joint. Rotors of joints whose axis is fixed
            stand on the ground; the others weigh upon the link before the joint, and the more
            the smaller the gear is.
    """
    linkage = space.linkage
    names = candidate_joints(linkage) if joints is None else tuple(joints)
    at = linkage.positions_of(names).tolist()
    relations = None if space.motion is None else space.motion.relations
    wide = design_space(_with_rotors(linkage, at), relations, spatial=not space.planar)
    rows, split = orthonormal_conditions(wide.scaled_basis), len(space.basis)
    columns = [_rotor_column(space, rows, j, k, gear) for k, j in enumerate(at)]
    rotors = np.array(columns).reshape(-1, len(rows)).T
    kept = np.linalg.norm(rotors, axis=0) > ROTOR_WITHOUT_MOMENTUM
    found = _independent_rows(np.column_stack([rows[:, :split], rotors[:, kept]]))
    given = to_chain(given_parameters(space), wide.chain.frame, space.planar, False)
    return RotorConditions(
        space, tuple(np.array(names)[kept].tolist()), found[:, :split], found[:, split:],
        given.reshape(-1), wide.length, wide.sure, wide.encloses,
    )  # fmt: skip


def _with_rotors(linkage: Linkage, joints: Sequence[int]) -> Linkage:
    """Assemble the linkage with a rotor of a unit mass on each of some joints."""
    n = len(linkage.joints)
    held = [linkage.joints[j] for j in joints]
    names = [f"{joint.name} rotor" for joint in held]
    rotors = [
        Joint(name, "revolute", joint.parent, joint.screw, joint.point)
        for name, joint in zip(names, held, strict=True)
    ]
    bodies = [
        Body(name, n + k, freeze(parameters(1.0, held[k].point, np.eye(3))), freeze(np.eye(4)))
        for k, name in enumerate(names)
    ]
    kept = {one.name: getattr(linkage, one.name) for one in fields(UnassembledLinkage)}
    draft = replace(
        UnassembledLinkage(**kept),
        joints=(*linkage.joints, *rotors), bodies=(*linkage.bodies, *bodies),
        mimics=(*linkage.mimics, *(Mimic(n + k, j, -1.0) for k, j in enumerate(joints))),
        tree=None, document=None, displaced=None, other_poses=(),
    )  # fmt: skip
    return assemble(draft, linkage.inputs)


def _rotor_column(
    space: DesignSpace, rows: Array, joint: int, place: int, gear: float
) -> Array:
    """Compute the conditions on the momentum J of one rotor (ρ,); see the module."""
    linkage, count = space.linkage, len(space.labels)
    by_body = rows.reshape(len(rows), -1, count)
    n = linkage.joints[joint].screw[:3]
    axial = _inertia_parameters(space, np.outer(n, n))
    column = by_body[:, len(space.bodies) + place] @ axial
    parent = linkage.joints[joint].parent
    if parent == GROUND:
        return column
    carrier = [body.link for body in linkage.bodies].index(parent)
    column = column - by_body[:, carrier] @ axial
    if np.isfinite(gear) and not has_fixed_axis(linkage, joint):
        disc = _inertia_parameters(space, (np.outer(n, n) + np.eye(3)) / 2.0)
        column = column + by_body[:, carrier] @ disc / gear
    return column


def _inertia_parameters(space: DesignSpace, E: Array) -> Array:
    """Compute the counted parameters of an inertia tensor (3, 3) without mass."""
    if space.planar:
        n = space.axes[2]
        return np.array([0.0, 0.0, 0.0, n @ E @ n])
    return np.array([0, 0, 0, 0, E[0, 0], E[1, 1], E[2, 2], E[0, 1], E[0, 2], E[1, 2]])


def _independent_rows(rows: Array) -> Array:
    """Compute orthonormal rows that span the same space."""
    _, values, V = np.linalg.svd(rows, full_matrices=False)
    return np.asarray(V[values > FIXED_RANK_RELATIVE * values.max(initial=0.0)])
