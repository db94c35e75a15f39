"""Claim: a whole design space costs at most six pivoted QRs of its stacked regressor."""

from __future__ import annotations

from itertools import cycle

from balance import design_space
from benchmarks.geometry import variants
from benchmarks.kernel_costs_half_a_qr import KernelCostsHalfAQr


class AnswerCostsSixQr(KernelCostsHalfAQr):
    """From an assembled linkage to rank by order, null space and gap."""

    claims = (("time_design_space", "time_pivoted_qr", 6.0),)

    def setup(self, model: str, order: int) -> None:
        """As for the kernels, and the linkages themselves."""
        super().setup(model, order)
        self.linkages = cycle(variants(model, 24, seed=2))

    def time_design_space(self, model: str, order: int) -> None:
        """The public call, on one more geometry."""
        design_space(next(self.linkages))
