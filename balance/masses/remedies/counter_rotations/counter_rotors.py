"""Counter-rotors on revolute joints: candidates, and the conditions with their momenta.

A counter-rotor on joint j spins against it about a parallel axis and adds the momentum
``-J n q̇_j``, a moment alone, with ``J ≥ 0``. The axis n and the rate q̇_j move with the pose.
Besides that it is a part of the rigid body that carries it, so that its mass and its place
count among the masses of that body.

The axis of a revolute joint is fixed in both of its links, so that
``n q̇_j = n nᵀ (ω_child - ω_parent)``. A counter-rotor therefore acts like the inertia
``J n nᵀ`` taken from the child and given to the parent, in every pose: its conditions are those
of the inertias of these two links, with no linkage but the given one. A rotor of gear N needs
the axial inertia ``J / N``, and is at least a thin disc: its carrier then has
``(J / N) (n nᵀ + 1) / 2`` besides a body that can be built.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_program import orthonormal_conditions
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import FIXED_RANK_RELATIVE, ROTOR_WITHOUT_MOMENTUM
from kinematics.model.chain import path
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.spatial.inertia import stack_parameters
from kinematics.numerics.array_types import Array


class RotorConditions(NamedTuple):
    """The balance conditions of a linkage with counter-rotors, in the units of a chain.

    ``bodies @ z + rotors @ J = 0`` for every balanced distribution, and for no other as far as
    ``space.sure`` says.

    Attributes:
        space: the design space of the linkage without rotors.
        joints: joints with a rotor (k,).
        bodies: conditions on the counted parameters of all bodies, orthonormal rows
            (ρ, parameters).
        rotors: conditions on the momenta J of the rotors (ρ, k).
        given: counted parameters of the masses in the file (parameters,), kg.
    """

    space: DesignSpace
    joints: tuple[str, ...]
    bodies: Array
    rotors: Array
    given: Array


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
        joint: index of the joint.
    """
    axis = linkage.joints[joint].screw[:3]
    before = path([entry.parent for entry in linkage.joints], linkage.joints[joint].parent)
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
    linkage, file = space.linkage, given_parameters(space)
    names = candidate_joints(linkage) if joints is None else tuple(joints)
    rows = orthonormal_conditions(space.scaled_basis)
    columns = [_rotor_column(space, rows, j, gear) for j in linkage.positions_of(names)]
    rotors = np.array(columns).reshape(-1, len(rows)).T
    kept = np.linalg.norm(rotors, axis=0) > ROTOR_WITHOUT_MOMENTUM
    given = to_chain(file, space.chain.frame, space.planar, False).reshape(-1)
    return RotorConditions(
        space, tuple(np.array(names)[kept].tolist()), rows, rotors[:, kept], given
    )


def link_rotor_conditions(space: DesignSpace, links: Sequence[str]) -> RotorConditions:
    """Compute the balance conditions of a planar linkage with rotors on the ground.

    A rotor that turns against the rotation θ_k of a link adds the moment ``-J θ̇_k``, as the
    inertia -J of that link would.

    Args:
        space: the planar design space of the linkage, for dynamic balance.
        links: bodies with such a rotor.
    """
    rows = orthonormal_conditions(space.scaled_basis)
    moments = rows.reshape(len(rows), -1, len(space.labels))[:, :, space.labels.index("Ezz")]
    rotors = -moments[:, [space.bodies.index(name) for name in links]]
    kept = np.linalg.norm(rotors, axis=0) > ROTOR_WITHOUT_MOMENTUM
    file = given_parameters(space)
    given = to_chain(file, space.chain.frame, space.planar, False).reshape(-1)
    names = tuple(name for name, good in zip(links, kept, strict=True) if good)
    return RotorConditions(space, names, rows, rotors[:, kept], given)


def disc_columns(conditions: RotorConditions) -> Array:
    """Compute the conditions on thin discs, or rings, on the links after joints (ρ, k).

    A disc of unit axial inertia about an axis n along that of the joint is a part of that link
    with the inertia ``(n nᵀ + 1) / 2``.

    Args:
        conditions: the conditions, for the joints that they name.
    """
    space, linkage = conditions.space, conditions.space.linkage
    by_body = conditions.bodies.reshape(len(conditions.bodies), -1, len(space.labels))
    links = [body.link for body in linkage.bodies]
    columns = []
    for j in linkage.positions_of(conditions.joints).tolist():
        n = linkage.joints[j].screw[:3]
        disc = _inertia_parameters(space, (np.outer(n, n) + np.eye(3)) / 2.0)
        columns.append(by_body[:, links.index(j)] @ disc)
    return np.array(columns).reshape(-1, len(conditions.bodies)).T


def _rotor_column(space: DesignSpace, rows: Array, joint: int, gear: float) -> Array:
    """Compute the conditions on the momentum J of one rotor (ρ,); see the module."""
    linkage = space.linkage
    by_body = rows.reshape(len(rows), -1, len(space.labels))
    n, parent = linkage.joints[joint].screw[:3], linkage.joints[joint].parent
    links = [body.link for body in linkage.bodies]
    axial = _inertia_parameters(space, np.outer(n, n))
    column = -by_body[:, links.index(joint)] @ axial
    if parent != GROUND:
        column = column + by_body[:, links.index(parent)] @ axial
    if parent != GROUND and np.isfinite(gear) and not has_fixed_axis(linkage, joint):
        disc = _inertia_parameters(space, (np.outer(n, n) + np.eye(3)) / 2.0)
        column = column + by_body[:, links.index(parent)] @ disc / gear
    return np.asarray(column)


def _inertia_parameters(space: DesignSpace, E: Array) -> Array:
    """Compute the counted parameters of an inertia tensor (3, 3) without mass."""
    if space.planar:
        n = space.axes[2]
        return np.array([0.0, 0.0, 0.0, n @ E @ n])
    return stack_parameters(0.0, np.zeros(3), E)
