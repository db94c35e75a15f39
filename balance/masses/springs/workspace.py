"""Poses of a workspace, in which springs are judged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import hypot

import numpy as np
from numpy.typing import NDArray

from balance.motion.verification.joint_limits import joint_limits
from kinematics.closure.continuation import SERIES_ORDER, continue_in_directions
from kinematics.closure.joint_positions import check_inputs, input_chain
from kinematics.closure.newton import Pose, follow_ray, forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.errors import LinkageError, PoseError, UsageError
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage

Array = NDArray[np.float64]

# Poses of a workspace: with one input, and with several.
POSES_OF_ONE, POSES_OF_SEVERAL = 61, 96
# Range of an input each way where neither the file nor a caller gives one, rad and
# characteristic lengths.
DEFAULT_RANGE = 1.0
# Most steps from the reference pose to a pose: more are only taken near singular poses.
MAX_STEPS = 40
# Generic rays along which a linkage is followed for conditions.
RAYS = 2


def input_ranges(linkage: Linkage, ranges: Mapping[str, tuple[float, float]]) -> Array:
    """Read the ranges of the inputs (2, inputs), radians and metres.

    Those that are not given are the limits in the file, and without limits 1 rad or one
    characteristic length each way.

    Args:
        ranges: by name of input.

    Raises:
        PoseError: a name is not that of an input.
        UsageError: a range is empty.
    """
    check_inputs(linkage, ranges)
    at, chain = linkage.positions_of(linkage.inputs), input_chain(linkage)
    whole = DEFAULT_RANGE * chain.units[at]
    limits = joint_limits(linkage)[:, at]
    low, high = (np.where(np.isfinite(x), x, sign * whole)
                 for sign, x in zip((-1.0, 1.0), limits, strict=True))  # fmt: skip
    for k, name in enumerate(linkage.inputs):
        if name in ranges:
            low[k], high[k] = ranges[name]
        if not low[k] < high[k]:
            raise UsageError(f"range {low[k]:g}:{high[k]:g} of {name} is empty: give low:high")
    return np.array([low, high])


def workspace_poses(linkage: Linkage, ranges: Array) -> tuple[list[Pose], Array]:
    """Sample the poses within ranges of the inputs.

    One input takes equal steps; several take points of a fixed random sequence. Points at
    which the loops cannot be closed are left out.

    Args:
        linkage: the linkage.
        ranges: shape (2, inputs), radians and metres.

    Returns:
        The poses, in the frame of `input_chain`, and their inputs (poses, inputs).

    Raises:
        PoseError: no pose of the ranges is reached.
    """
    chain, at = input_chain(linkage), linkage.positions_of(linkage.inputs)
    low, high = ranges
    if low.size == 1:
        shares = np.linspace(0.0, 1.0, POSES_OF_ONE)[:, None]
    else:
        shares = np.random.default_rng(107).random((POSES_OF_SEVERAL, low.size))
    poses, reached = [], []
    for point in low + shares * (high - low):
        pose = _pose_towards(chain, point / chain.units[at])
        if pose is not None:
            poses.append(pose)
            reached.append(point)
    if not poses:
        raise PoseError(
            f"{linkage.source}: no pose of the ranges is reached: give smaller ones"
        )
    return poses, np.array(reached)


def _pose_towards(chain: Chain, point: Array) -> Pose | None:
    """Follow a straight line of coordinates to its end; None where few steps do not lead there.

    Args:
        chain: the linkage at its reference pose.
        point: coordinates of the chain (w,).
    """
    pose, rest = forward_kinematics(chain, np.zeros(chain.parent.size)), float(hypot(*point))
    if not chain.dependent.size:
        return forward_kinematics(chain, chain.columns @ point)
    ray = point / (rest or 1.0)
    for _ in range(MAX_STEPS):
        if rest == 0.0:
            return pose
        series = expand_from(chain, pose.screws, ray[None], SERIES_ORDER)
        pose, step = follow_ray(chain, pose.q, series, ray, rest)
        if step == 0.0:
            break
        rest -= step
    return None


def generic_poses(linkage: Linkage, seed: int) -> Iterator[tuple[Chain, Pose]]:
    """Follow the linkage along generic rays, both ways.

    Args:
        linkage: the linkage.
        seed: of the rays.

    Raises:
        LinkageError: it has no motion.
    """
    chain = input_chain(linkage)
    if chain.width == 0:
        raise LinkageError(f"{linkage.source}: does not move: springs have nothing to balance")
    rays = np.random.default_rng(seed).standard_normal((RAYS, chain.width))
    rays /= np.linalg.norm(rays, axis=1)[:, None]
    return continue_in_directions(chain, rays)
