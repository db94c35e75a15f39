"""Claim: ranks are those of exact arithmetic, and bases have no momentum at random poses."""

from __future__ import annotations

import numpy as np

from balance import design_space
from balance.momentum import momentum_regressor
from balance.space.certification.exact_ranks import exact_ranks
from kinematics.loading.model_gallery import gallery, load


class AnswersAreRight:
    """Residual momentum of the null-space basis at poses that were not used."""

    params = tuple((name,) for name in gallery())
    claims = (("track_residual", 1e-12), ("track_wrong_rank", 0.0))

    def setup(self, model: str) -> None:
        """Prepare the linkage and its space."""
        self.linkage = load(model)
        self.space = design_space(self.linkage)

    def time_design_space(self, model: str) -> None:
        """The public call."""
        design_space(self.linkage)

    def track_residual(self, model: str) -> float:
        """Largest momentum at 20 random poses, relative to that of single parameters."""
        rng = np.random.default_rng(3)
        worst = 0.0
        for _ in range(20):
            u = 0.2 * rng.uniform(-1.0, 1.0, self.linkage.mobility)
            X = momentum_regressor(self.linkage, u)
            left = np.abs(X @ self.space.basis).max()
            worst = max(worst, left / (np.abs(X).max() * np.abs(self.space.basis).max()))
        return float(worst)

    def track_wrong_rank(self, model: str) -> int:
        """Difference of the rank from that of exact arithmetic."""
        return abs(self.space.rank - exact_ranks(self.linkage).rank)
