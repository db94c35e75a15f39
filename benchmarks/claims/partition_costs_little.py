"""Claim: the serial-parallel partition adds at most half to the time of a design space.

The rank is that of exact arithmetic with the partition and without.
"""

from __future__ import annotations

from itertools import cycle

import numpy as np

from balance import design_space
from balance.space.certification.exact_ranks import exact_ranks
from balance.space.spaces import compute_space
from balance.space.spaces.design_space import DesignSpace
from balance.space.transfers.serial_part import Transfers, serial_transfers
from benchmarks.inputs.geometry import resized
from kinematics.loading.model_gallery import gallery, load
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage


def _none(chain: Chain, force: bool, tolerance: float) -> Transfers:
    """Return no transfers, so that the whole null space is computed at once."""
    empty = np.empty(0, np.int64)
    parameters = len(chain.links) * (4 if chain.planar else 10)
    return Transfers(np.empty((0, parameters)), empty, empty, empty, 1.0, 0.0)


class PartitionCostsLittle:
    """Ranks and null space, with or without projecting out the serial space first."""

    params = tuple((name,) for name in gallery())
    claims = (("time_with_partition", "time_without", 1.5), ("track_wrong_ranks", 0.0))

    def setup(self, model: str) -> None:
        """Prepare different geometries that are as special as the model's."""
        self.copies = resized(model, 24, seed=3)
        self.linkages = cycle(self.copies)

    def time_with_partition(self, model: str) -> None:
        """The public call."""
        design_space(next(self.linkages))

    def time_without(self, model: str) -> None:
        """The same conditions without a known serial space."""
        _without_partition(next(self.linkages))

    def track_wrong_ranks(self, model: str) -> int:
        """Count ranks other than the exact one, with the partition and without."""
        exact = exact_ranks(load(model)).rank
        spaces = [f(copy) for copy in self.copies for f in (design_space, _without_partition)]
        return sum(space.rank != exact for space in spaces)


def _without_partition(linkage: Linkage) -> DesignSpace:
    """Compute the design space with its null space at once."""
    compute_space.serial_transfers = _none
    try:
        return design_space(linkage)
    finally:
        compute_space.serial_transfers = serial_transfers
