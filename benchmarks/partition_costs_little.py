"""Claim: to split the design space into its parts adds at most half to the time it takes."""

from __future__ import annotations

from itertools import cycle

import numpy as np

from balance import design_space, designspace
from balance.opening import Transfers, transfers
from benchmarks.geometry import resized
from kinematics.linkage import Chain
from kinematics.models import gallery


def _none(chain: Chain, force: bool, floor: float) -> Transfers:
    """No transfer at all, so that the whole null space is found as one."""
    empty = np.empty(0, np.int64)
    parameters = len(chain.links) * (4 if chain.planar else 10)
    return Transfers(np.empty((0, parameters)), empty, empty, empty)


class PartitionCostsLittle:
    """Ranks and null space, with the serial part taken out first, or not at all."""

    params = tuple((name,) for name in gallery())
    claims = (("time_with_partition", "time_without", 1.5),)

    def setup(self, model: str) -> None:
        """Geometries that are never the same, but as special as the model's."""
        self.linkages = cycle(resized(model, 24, seed=3))

    def time_with_partition(self, model: str) -> None:
        """The public call."""
        design_space(next(self.linkages))

    def time_without(self, model: str) -> None:
        """The same conditions, with nothing known beforehand."""
        designspace.transfers = _none
        design_space(next(self.linkages))
        designspace.transfers = transfers
