"""Conditions of one requirement on the parameters that all of them share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from itertools import islice
from math import comb
from typing import NamedTuple

import numpy as np

from balance.space.certification.certify_space import certify
from balance.space.conditions.collect import (
    add_pose_conditions,
    collect_conditions,
    relative_tolerance,
    selected_rows_at,
)
from balance.space.conditions.fresh_momenta import FRESH_STEP_LENGTH
from balance.space.conditions.order_kernels import generic_directions
from balance.space.conditions.rank import Conditions
from balance.space.decoupled.decoupling import decoupling
from balance.space.momentum.regressor import (
    RegressorSeries,
    parameters_per_body,
    rows_at,
    select_rows,
)
from balance.space.requirements.components import chain_rows, exact_rows
from balance.space.requirements.curves import (
    Place,
    places_on_path,
    places_on_surface,
    read_surface,
)
from balance.space.requirements.requirement import Requirement
from balance.space.spaces.compute_space import design_space
from balance.space.transfers.serial_part import serial_transfers
from kinematics.closure.assembly.assemble import moving_chain
from kinematics.closure.continuation import continue_along
from kinematics.closure.joint_positions import joint_positions
from kinematics.closure.newton import (
    Pose,
    forward_kinematics,
    radius_of_convergence,
)
from kinematics.closure.series import expand, expand_from
from kinematics.errors import (
    LinkageError,
    MotionError,
    PoseError,
    UnreachedError,
    UsageError,
)
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.model.plane import flatten
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import complement

# Highest orders about the reference pose for some components of the momentum, tried one after
# the other, and poses each way along a ray that must not add to them.
ORDERS, NEAR_POSES = (3, 8), 3
# Poses of the first batch on a surface, and of the largest.
FIRST_BATCH, LARGEST_BATCH = 6, 96


class CommonData(NamedTuple):
    """What all requirements on a linkage share.

    Attributes:
        linkage: the linkage.
        planar: whether planar parameters are counted.
        masses: whether masses and first moments alone are counted.
        gravity: g (3,), m/s², inertial frame.
    """

    linkage: Linkage
    planar: bool
    masses: bool
    gravity: tuple[Fraction, Fraction, Fraction]

    @property
    def chain(self) -> Chain:
        """The chain whose inputs are all free."""
        linkage = self.linkage
        return linkage.chain if self.planar else linkage.spatial_chain

    @property
    def parameters(self) -> int:
        """Number of inertial parameters of all bodies."""
        size = parameters_per_body(self.planar, self.masses)
        return size * len(self.linkage.bodies)


class RegionConditions(NamedTuple):
    """Conditions of one requirement.

    Attributes:
        requirement: the requirement.
        rows: independent conditions (rank, parameters), in the units of the chain.
        serial: inertia transfers that satisfy them, as rows.
        settled: whether no condition is missing.
        poses: number of finite poses that were used.
        motion: restriction of the inputs, where all poses of it count.
        chain: the chain of that motion; None for other regions.
        select: components of its momentum that count.
    """

    requirement: Requirement
    rows: Array
    serial: Array
    settled: bool
    poses: int
    motion: Motion | None = None
    chain: Chain | None = None
    select: Array | None = None


def collect_region(common: CommonData, requirement: Requirement) -> RegionConditions:
    """Collect the conditions of a requirement.

    Raises:
        LinkageError: the linkage cannot take a pose, or follow a motion, of the requirement.
    """
    try:
        if requirement.path:
            places = places_on_path(requirement, common.linkage.inputs)
            return _on_places(common, requirement, places, len(places))
        if requirement.order is not None:
            return _about_pose(common, requirement, requirement.order)
        motion = _linear_motion(common, requirement)
        if motion is None and requirement.relations:
            surface = read_surface(requirement, common.linkage.inputs)
            on_surface = places_on_surface(surface, common.linkage.inputs)
            return _on_places(common, requirement, on_surface)
        if requirement.quantity == "decoupled":
            return _decoupled(common, requirement, motion)
        return _in_motion(common, requirement, motion)
    except UsageError:
        raise
    except LinkageError as error:
        text = str(error).removeprefix(f"{common.linkage.source}: ")
        raise LinkageError(
            f"{common.linkage.source}: requirement '{requirement.text}': {text}"
        ) from None


def _motion_chain(common: CommonData, motion: Motion | None) -> Chain:
    """Make the chain of a motion in the coordinates of the chain whose inputs are free."""
    free = common.chain
    if motion is None:
        return free
    chain = moving_chain(common.linkage, motion, True)
    return flatten(chain, free.frame.R[2]) if common.planar else chain


def _linear_motion(common: CommonData, requirement: Requirement) -> Motion | None:
    """Read the relations as a motion; None without them, or where they are not linear."""
    if not requirement.relations:
        return None
    try:
        return Motion.parse(requirement.relations, common.linkage.inputs)
    except MotionError:
        if all(_sets_input(common, relation) for relation in requirement.relations):
            return None
        raise


def _sets_input(common: CommonData, relation: str) -> bool:
    """Whether a relation may be a curved one, ``input = expression``."""
    name, equals, body = relation.partition("=")
    return bool(equals and body.strip()) and name.strip() in common.linkage.inputs


def _whole_rows(common: CommonData, rows: Array, masses: bool) -> Array:
    """Extend rows on masses and first moments by the moments of inertia, if those count."""
    if common.masses or not masses:
        return rows
    small, size = (parameters_per_body(common.planar, few) for few in (True, False))
    bodies = len(common.linkage.bodies)
    whole = np.zeros((len(rows), bodies, size))
    whole[:, :, :small] = rows.reshape(len(rows), bodies, small)
    return whole.reshape(len(rows), bodies * size)


def _transfers(common: CommonData, chain: Chain, masses: bool) -> Array:
    """Compute the inertia transfers of a chain as rows on all parameters that count."""
    rows = serial_transfers(chain, masses, relative_tolerance(chain)).rows
    if common.masses or not masses:
        return rows
    small, size = (parameters_per_body(common.planar, few) for few in (True, False))
    inertias = np.eye(common.parameters).reshape(-1, len(common.linkage.bodies), size)
    free = [b * size + k for b in range(inertias.shape[1]) for k in range(small, size)]
    return np.concatenate([_whole_rows(common, rows, True), np.eye(common.parameters)[free]])


def _select_components(common: CommonData, requirement: Requirement, masses: bool) -> Array:
    """Give the rows on the momentum of the chain that a requirement is about.

    Args:
        common: what all requirements share.
        requirement: the requirement.
        masses: whether the momentum is the linear one alone.
    """
    frame = common.chain.frame
    normal = tuple(map(Fraction, frame.R[2].tolist())) if common.planar else None
    rows = exact_rows(requirement, common.gravity, normal)
    return chain_rows(rows, frame, common.planar, masses)


def _in_motion(
    common: CommonData, requirement: Requirement, motion: Motion | None
) -> RegionConditions:
    """Collect the conditions in all poses of a motion."""
    chain, masses = _motion_chain(common, motion), requirement.masses_alone
    tolerance = relative_tolerance(chain)
    transfers = serial_transfers(chain, masses, tolerance).rows
    select = _select_components(common, requirement, masses)
    if requirement.whole:
        gathered = collect_conditions(chain, transfers, masses, tolerance, None)
        conditions, poses, settled = gathered.conditions, gathered.poses, gathered.settled
    else:
        conditions, poses, settled = _partial_conditions(
            chain, masses, Conditions.given(transfers, tolerance), select
        )
    return RegionConditions(
        requirement,
        _whole_rows(common, conditions.rows, masses),
        _transfers(common, chain, masses),
        settled,
        poses,
        motion,
        chain,
        select,
    )


def _partial_conditions(
    chain: Chain, masses: bool, none: Conditions, select: Array
) -> tuple[Conditions, int, bool]:
    """Collect the conditions on some components: orders first, and poses if they add any.

    Args:
        chain: the chain of the motion.
        masses: whether only linear momentum counts.
        none: no conditions yet, beside known solutions.
        select: combinations of the components that count.

    Returns:
        The conditions, the number of poses used, and whether the conditions are settled.
    """
    conditions = none
    for order in ORDERS:
        conditions = _orders_about(chain, None, order, masses, select, none, None)
        rays = generic_directions(7, 9 if chain.width > 1 else 8, chain.width)
        near = [
            selected_rows_at(chain, pose, masses, select)
            for ray in rays
            for sign in (1.0, -1.0)
            for pose in islice(
                continue_along(chain, sign * ray, longest_step=FRESH_STEP_LENGTH), NEAR_POSES
            )
        ]
        if near and all(conditions.contains(rows) for rows in near):
            return conditions, 0, True
    return add_pose_conditions(chain, masses, conditions, select=select)


def _orders_about(
    chain: Chain,
    pose: Pose | None,
    order: int,
    masses: bool,
    select: Array,
    conditions: Conditions,
    common: CommonData | None,
) -> Conditions:
    """Add the conditions of the orders 0 to ``order`` about a pose, along enough rays.

    Args:
        chain: the chain of the motion.
        pose: a closed pose of it; None for the reference pose.
        order: highest order of derivative.
        masses: whether only linear momentum counts.
        select: combinations of the components that count.
        conditions: those that there are.
        common: extends rows on masses by moments of inertia; None to leave them.
    """
    for ray in generic_directions(0, comb(chain.width + order - 1, order), chain.width):
        block = _series_rows(chain, pose, ray, order, masses, select)
        before = conditions.rank
        conditions = conditions.append(
            block if common is None else _whole_rows(common, block, masses)
        )
        if conditions.complete or (conditions.rank == before and before):
            break
    return conditions


def _decoupled(
    common: CommonData, requirement: Requirement, motion: Motion | None
) -> RegionConditions:
    """Give the conditions under which the inertia on the base is constant as well."""
    space = design_space(common.linkage, motion, spatial=not common.planar)
    if not np.allclose(space.chain.frame.R, common.chain.frame.R):
        raise LinkageError("moves in a plane of its own: count all parameters (--spatial)")
    freed = decoupling(certify(space))
    basis = freed.decoupled_space.scaled_basis
    return RegionConditions(
        requirement,
        complement(basis).T,
        basis[:, : freed.serial_nullity].T,
        freed.freed.settled,
        freed.freed.poses,
        motion,
    )


def _about_pose(common: CommonData, requirement: Requirement, order: int) -> RegionConditions:
    """Collect the conditions up to an order about a pose."""
    chain, masses = common.chain, requirement.masses_alone
    pose = None
    if requirement.pose is not None and any(value for _, value in requirement.pose):
        pose = _pose_at(common, dict(requirement.pose))
    transfers, select = (
        _transfers(common, chain, masses),
        _select_components(common, requirement, masses),
    )
    none = Conditions.given(transfers, relative_tolerance(chain))
    conditions = _orders_about(chain, pose, order, masses, select, none, common)
    return RegionConditions(
        requirement, conditions.rows, transfers, True, int(pose is not None)
    )


def _series_rows(
    chain: Chain, pose: Pose | None, ray: Array, order: int, masses: bool, select: Array
) -> Array:
    """Compute the rows of the orders 0 to ``order`` along a ray, scaled by its convergence."""
    rays = ray[None]
    series = (
        expand(chain, rays, order)
        if pose is None
        else expand_from(chain, pose.screws, rays, order)
    )
    X = RegressorSeries(chain, series, masses, pose).rows(order)
    rho = radius_of_convergence(series.C[0] @ ray)
    scale = rho ** np.arange(order + 1.0)
    selected = select_rows(X * scale[:, None, None, None, None], select)
    return selected.reshape(-1, X.shape[-1])


def _pose_at(common: CommonData, pose: dict[str, float] | Array) -> Pose:
    """Close the loops at displacements of the inputs, in the coordinates of the chain."""
    chain = common.chain
    q = joint_positions(common.linkage, pose)[chain.joints] / chain.units
    return forward_kinematics(chain, q)


def _on_places(
    common: CommonData,
    requirement: Requirement,
    places: Iterable[Place],
    count: int | None = None,
) -> RegionConditions:
    """Collect the conditions at poses of a curved region, until a batch adds none.

    Args:
        common: what all requirements share.
        requirement: the requirement.
        places: the poses, and the directions in which the region moves there.
        count: number of poses, if all of them count.

    Raises:
        PoseError: a pose of a path, or every pose of a surface tried, cannot be reached.
    """
    chain, masses = common.chain, requirement.masses_alone
    transfers, select = (
        _transfers(common, chain, masses),
        _select_components(common, requirement, masses),
    )
    conditions = Conditions.given(transfers, relative_tolerance(chain))
    units = chain.units[_input_positions(common)]
    following, batch, used, settled = iter(places), count or FIRST_BATCH, 0, False
    while batch <= LARGEST_BATCH and not settled:
        blocks = []
        for place in islice(following, batch):
            try:
                pose = _pose_at(common, place.u)
            except UnreachedError:
                if count is not None:
                    raise
                continue
            X = rows_at(chain, pose, masses)
            parts = X.reshape(chain.width, -1, X.shape[-1])
            along = np.einsum("wd,wrp->drp", place.tangents / units[:, None], parts)
            block = select_rows(along, select).reshape(-1, X.shape[-1])
            blocks.append(block / (np.linalg.norm(block) or 1.0))
        if not blocks:
            raise PoseError("none of its poses tried can be reached from the reference pose")
        used += len(blocks)
        before = conditions.rank
        conditions = conditions.append(_whole_rows(common, np.concatenate(blocks), masses))
        settled = (
            count is not None
            or conditions.complete
            or (used > len(blocks) and conditions.rank == before)
        )
        batch *= 2
    return RegionConditions(requirement, conditions.rows, transfers, settled, used)


def _input_positions(common: CommonData) -> Sequence[int]:
    """Places of the inputs among the joints of the chain, in the order of its columns."""
    place = {int(joint): k for k, joint in enumerate(common.chain.joints)}
    return [place[int(j)] for j in common.linkage.positions_of(common.linkage.inputs)]
