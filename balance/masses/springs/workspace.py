"""Poses of a workspace, in which springs are judged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from balance.motion.verification.joint_limits import joint_limits
from kinematics.closure.continuation import continue_in_directions
from kinematics.closure.joint_positions import check_inputs, input_chain, joint_positions
from kinematics.closure.newton import Pose, forward_kinematics
from kinematics.errors import LinkageError, PoseError, UnreachedError, UsageError
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage

Array = NDArray[np.float64]

# Poses of a workspace: with one input, and with several.
POSES_OF_ONE, POSES_OF_SEVERAL = 61, 96
# Range of an input each way where neither the file nor a caller gives one, rad and
# characteristic lengths.
DEFAULT_RANGE = 1.0
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
    chain, (low, high) = input_chain(linkage), ranges
    if low.size == 1:
        shares = np.linspace(0.0, 1.0, POSES_OF_ONE)[:, None]
    else:
        shares = np.random.default_rng(107).random((POSES_OF_SEVERAL, low.size))
    poses, reached = [], []
    for point in low + shares * (high - low):
        try:
            q = joint_positions(linkage, point)
        except UnreachedError:
            continue
        poses.append(forward_kinematics(chain, q / chain.units))
        reached.append(point)
    if not poses:
        raise PoseError(
            f"{linkage.source}: no pose of the ranges is reached: give smaller ones"
        )
    return poses, np.array(reached)


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
