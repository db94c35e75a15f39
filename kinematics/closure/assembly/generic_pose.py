"""A finite pose in a generic direction of motion, and whether a singular pose is near."""

from __future__ import annotations

import numpy as np

from kinematics.closure.mobility.first_order import (
    conditioning,
    conditioning_beyond,
    first_order,
)
from kinematics.closure.newton import Pose, follow_ray
from kinematics.closure.series import expand, loop_matrix
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import (
    BEYOND_SINGULAR,
    INDISTINGUISHABLE_CONDITIONING,
    LOOP_RANK_RELATIVE,
    NEAR_SINGULAR_CONDITIONING,
)


def generic_direction(chain: Chain) -> tuple[int, Pose | None]:
    """Find a finite pose in a generic direction of the columns of a chain.

    Returns:
        The order at which the loops do not close, 0 if they do; and a closed pose further
        on, None if there is none.
    """
    ray = np.random.default_rng(2).standard_normal(chain.width)
    ray /= np.linalg.norm(ray)
    series = expand(chain, ray[None], 4)
    if order := series.open_order:
        return order, None
    pose, step = follow_ray(chain, np.zeros(chain.parent.size), series, ray)
    return (len(series.residual) + 1, None) if step == 0.0 else (0, pose)


def is_near_singular(chain: Chain, values: Array, pose: Pose) -> bool:
    """Return whether a regular pose is near a singular one.

    It is, if its loop matrix is ill-conditioned, and better conditioned at the next pose.

    Args:
        chain: the linkage as arrays.
        values: singular values of its loop matrix.
        pose: a closed pose further on.
    """
    freedom = int(np.sum(values <= LOOP_RANK_RELATIVE * values.max(initial=0.0)))
    if freedom == values.size:
        return False
    here = float(values[values.size - freedom - 1] / values[0])
    if here >= NEAR_SINGULAR_CONDITIONING:
        return False
    if conditioning(chain, pose.q, freedom) > 1.5 * here:
        return True
    if here >= INDISTINGUISHABLE_CONDITIONING:
        return False
    # The pose further on is no further than the singular one.
    free, _ = first_order(loop_matrix(chain))
    return conditioning_beyond(chain, free, BEYOND_SINGULAR) > 1.5 * here
