"""Claim: a whole design space costs at most six pivoted QRs of its stacked regressor.

The geometries are general ones near the model's, with the rank of its file in exact arithmetic.
"""

from __future__ import annotations

from itertools import cycle

from balance import design_space
from balance.space.certification.exact_ranks import exact_ranks
from benchmarks.claims.kernel_costs_less_than_a_qr import KernelCostsLessThanAQr
from benchmarks.inputs.geometry import variants
from kinematics.loading.model_gallery import load


class AnswerCostsFewQr(KernelCostsLessThanAQr):
    """From an assembled linkage to rank by order, null space and gap."""

    claims = (("time_design_space", "time_pivoted_qr", 6.0), ("track_wrong_ranks", 0.0))

    def setup(self, model: str, order: int) -> None:
        """Prepare the rows as for the kernels, and the linkages."""
        super().setup(model, order)
        self.copies = variants(model, 24, seed=2)
        self.linkages = cycle(self.copies)

    def time_design_space(self, model: str, order: int) -> None:
        """The public call on another geometry."""
        assert design_space(next(self.linkages)).kept > 0.0

    def track_wrong_ranks(self, model: str, order: int) -> int:
        """Count geometries with another rank."""
        exact = exact_ranks(load(model)).rank
        return sum(design_space(copy).rank != exact for copy in self.copies)
