"""Closed poses one after the other, away from the reference pose."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from kinematics.closure import Series, expand, expand_from
from kinematics.linkage import Chain
from kinematics.placement import Pose, follow

__all__ = ["walk"]

Array = NDArray[np.float64]

# Order of the series that predict the next pose.
ORDER = 3


def walk(chain: Chain, ray: Array, known: Series | None = None) -> Iterator[Pose]:
    """Closed poses along a ray, each predicted by its predecessor's series.

    The walk ends where no further pose is found on the same branch.

    Args:
        chain: the linkage at its reference pose.
        ray: direction in the coordinates of the chain (w,).
        known: series along the ray at the reference pose, if there is one already.
    """
    series = expand(chain, ray[None], ORDER) if known is None else known
    q = np.zeros(chain.parent.size)
    while True:
        pose, step = follow(chain, q, series, ray)
        if step == 0.0:
            return
        yield pose
        q = pose.q
        series = expand_from(chain, pose.screws, ray[None], ORDER)
