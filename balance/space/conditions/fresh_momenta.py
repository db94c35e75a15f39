"""Momenta that are left at finite poses that decided nothing."""

from __future__ import annotations

from itertools import islice

import numpy as np

from balance.space.conditions.collect import selected_rows_at
from kinematics.closure.continuation import continue_along
from kinematics.closure.series import loop_matrix
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array

# Number of rays along which fresh poses are taken.
FRESH_RAYS = 2
# Number of steps each way.
FRESH_STEPS = 8
# Longest step, in units of the coordinates; irregular, to avoid special poses.
FRESH_STEP_LENGTH = 0.237
# Least singular value of the loop matrix, in parts of that at the reference pose, below which a
# pose is nearly singular: round-off grows with its inverse square there.
NEARLY_SINGULAR = 0.01


def momentum_left(
    chain: Chain, basis: Array, force: bool, select: Array | None = None
) -> tuple[float, int]:
    """Measure the largest momentum left at fresh poses, relative to the conditions.

    The poses lie both ways along generic rays, nearer than those that decided the rank. Those
    that are nearly singular do not count.

    Args:
        chain: the linkage without idle joints.
        basis: distributions as columns (parameters, count), in units of the chain.
        force: whether only linear momentum counts.
        select: combinations of the momentum components that count; all of them by default.

    Returns:
        The largest momentum, and the number of poses.
    """
    rng = np.random.default_rng(106)
    worst, poses = 0.0, 0
    least = NEARLY_SINGULAR * _distance_to_singularity(chain, chain.screws)
    for _ in range(1 if chain.width == 1 else FRESH_RAYS):
        ray = rng.standard_normal(chain.width)
        for sign in (1.0, -1.0):
            way = continue_along(
                chain, sign * ray / np.sqrt(ray @ ray), longest_step=FRESH_STEP_LENGTH
            )
            for pose in islice(way, FRESH_STEPS):
                if _distance_to_singularity(chain, pose.screws) < least:
                    continue
                X = selected_rows_at(chain, pose, force, select)
                momenta = np.sqrt(np.sum((X @ basis) ** 2, axis=0)).max(initial=0.0)
                worst = max(worst, float(momenta / (np.linalg.norm(X) or 1.0)))
                poses += 1
    return worst, poses


def _distance_to_singularity(chain: Chain, screws: Array) -> float:
    """Compute the least singular value of the loop matrix of the dependent joints."""
    if not chain.dependent.size:
        return 1.0
    S = loop_matrix(chain, screws)[:, chain.dependent]
    return float(np.linalg.svd(S, compute_uv=False)[-1])
