"""Finite poses: joint positions that close the loops, reached from the reference pose."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import hypot

import numpy as np
from numpy.typing import ArrayLike

from kinematics.closure.newton import follow_ray, forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.error_text import did_you_mean
from kinematics.errors import PoseError, UnreachedError
from kinematics.model.arrays import Chain, Frame
from kinematics.model.chain import arrange_loops, lock_joints, move_chain
from kinematics.model.linkage import Body, Linkage, names_of
from kinematics.model.plane import flatten
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import GIVEN_POSE_RESIDUAL

# Most steps from the reference pose to another pose.
MAX_STEPS = 2000
# Order of the series that predicts the next pose.
SERIES_ORDER = 6


def joint_positions(linkage: Linkage, q: ArrayLike | Mapping[str, float]) -> Array:
    """Compute the positions of all joints that close the loops (finite position analysis).

    Args:
        q: displacements from the reference pose, in radians and metres: of the inputs, in their
            order (mobility,), or by name, where inputs that are not named stay at 0: the other
            joints then follow along the straight line of input displacements, without a
            change of branch; or of all joints (n,), which must close the loops.

    Returns:
        Positions in the order of ``linkage.joints`` (n,), in radians and metres.

    Raises:
        PoseError: the joints do not close the loops, or the loops cannot be closed.
    """
    all_names = names_of(linkage.joints)
    if isinstance(q, Mapping):
        q = values_by_input(linkage, q)
    values = np.asarray(q, dtype=np.float64)
    if not np.isfinite(values).all():
        raise PoseError(f"{linkage.source}: joint positions must be finite numbers")
    if values.shape == (linkage.mobility,):
        chain = input_chain(linkage)
        point = values / chain.units[linkage.positions_of(linkage.inputs)]
        goal = zip(linkage.inputs, values, strict=True)
        return solve_joint_positions(chain, point, linkage.source, goal) * chain.units
    if values.shape == (len(all_names),):
        return _check_closure(linkage, values)
    raise PoseError(
        f"{linkage.source}: got {values.size} joint positions; "
        f"give {linkage.mobility} (the inputs) or {len(all_names)} (all joints)"
    )


def values_by_input(
    linkage: Linkage, values: Mapping[str, float], others: Sequence[float] | None = None
) -> Array:
    """Put values by name in the order of the inputs (mobility,).

    Args:
        values: by name of input.
        others: values (mobility,) of inputs that are not named; 0 by default.

    Raises:
        PoseError: a name is not that of an input.
    """
    check_inputs(linkage, values)
    defaults = np.zeros(linkage.mobility) if others is None else others
    pairs = zip(linkage.inputs, defaults, strict=True)
    return np.array([values.get(name, other) for name, other in pairs], dtype=np.float64)


def check_inputs(linkage: Linkage, names: Iterable[str]) -> None:
    """Raise PoseError for the first name that is not that of an input."""
    for name in names:
        if name not in linkage.inputs:
            raise PoseError(
                f"{linkage.source}: joint {name} is not an input"
                f"{did_you_mean(name, linkage.inputs)}; "
                f"the inputs are {', '.join(linkage.inputs)}"
            )


def input_chain(linkage: Linkage) -> Chain:
    """Return the spatial chain of all joints whose columns are the inputs."""
    return linkage.once(_input_chain)


def with_bodies(linkage: Linkage, bodies: Sequence[Body]) -> Linkage:
    """Replace the masses of the bodies of a linkage; all chains keep their coordinates.

    Args:
        linkage: the linkage.
        bodies: its bodies, with other masses.
    """
    changed = replace(linkage, bodies=tuple(bodies))
    # Where all axes meet, the coordinates of a new chain would follow the masses.
    changed._made[_input_chain,] = input_chain(linkage)
    return changed


def _input_chain(linkage: Linkage, frame: Frame | None = None) -> Chain:
    """Make that chain, by default in the coordinates of `arrange_loops`."""
    if frame is None and not linkage.idle:
        return linkage.spatial_chain  # it has all joints
    independent = linkage.positions_of(linkage.inputs)
    return move_chain(arrange_loops(linkage, frame), independent, np.eye(linkage.mobility))


def si_chain(linkage: Linkage, spatial: bool) -> Chain:
    """Return the chain of all joints in SI units about the inertial origin.

    Args:
        spatial: whether to keep all components of a planar linkage. Otherwise it is reduced to
            its plane, in the axes of the plane, without idle joints.
    """
    return linkage.once(_si_chain, spatial or not linkage.planar)


def _si_chain(linkage: Linkage, spatial: bool) -> Chain:
    chain = _input_chain(linkage, Frame())
    if spatial:
        return chain
    moving = lock_joints(chain, np.isin(names_of(linkage.joints), linkage.idle))
    return flatten(moving, linkage.chain.frame.R[2])


def _check_closure(linkage: Linkage, q: Array) -> Array:
    """Return the given positions, if they close the loops."""
    chain = input_chain(linkage)
    error = forward_kinematics(chain, q / chain.units).error
    if not error <= GIVEN_POSE_RESIDUAL:
        raise PoseError(
            f"{linkage.source}: these joint positions leave the loops open by {error:.2g} "
            "(radians and characteristic lengths); give the inputs alone to have them closed"
        )
    return q


def solve_joint_positions(
    chain: Chain, point: Array, source: str, goal: Iterable[tuple[str, float]]
) -> Array:
    """Follow the straight line of coordinates from the reference pose to a point.

    At each step the motion is expanded anew, and the step stays within the radius of
    convergence, so that the branch does not change.

    Args:
        chain: the linkage at its reference pose.
        point: coordinates of the chain (w,), in its units.
        source: file of the linkage, for the error.
        goal: inputs and their displacements there, for the error.

    Returns:
        Positions of the joints of the chain (n,), in its units.

    Raises:
        UnreachedError: the loops cannot be closed all the way, or it takes too many steps.
    """
    if chain.dependent.size == 0:
        return chain.columns @ point
    q, screws = np.zeros(chain.parent.size), chain.screws
    length = remaining_length = hypot(*point)
    used_up = 0
    for _ in range(MAX_STEPS):
        # The remaining length is decremented, so that rounding leaves no residual step.
        if remaining_length == 0.0:
            return q
        ray = point / length
        series = expand_from(chain, screws, ray[None], SERIES_ORDER)
        pose, step = follow_ray(chain, q, series, ray, remaining_length)
        if step == 0.0:
            break
        q, screws, remaining_length = pose.q, pose.screws, remaining_length - step
    else:
        used_up = MAX_STEPS
    where = ", ".join(f"{name}={value:.4g}" for name, value in goal)
    raise UnreachedError(source, where, 1.0 - remaining_length / length, q.tolist(), used_up)
