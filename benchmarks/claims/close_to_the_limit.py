"""Claim: the momentum kernel takes at most twice as long as the same arithmetic in C.

The C code is compiled with -O3 -march=native; results agree to 1e-13, and both execute the same
number of operations, which are counted at run time. The error is that of closure and momentum
against finite poses in mpmath, along one ray, relative to the largest entry of each order.
"""

from __future__ import annotations

import numpy as np

from balance.space.momentum.regressor import body_regressors, regressor_workspace
from benchmarks.references import compiled, reference
from kinematics.closure.series import expand
from kinematics.loading.model_gallery import load


class CloseToTheLimit:
    """All orders of the regressor, along enough rays to make call overhead negligible."""

    params = (
        ("four_bar_general", 4, 64),
        ("five_bar", 4, 32),
        ("bennett", 4, 32),
        ("three_rsr", 2, 12),
        ("stewart_6ups", 2, 8),
    )
    claims = (
        ("time_ours", "time_in_c", 2.0),
        ("track_difference", 1e-13),
        ("track_operations_apart", 0.0),
        ("track_error", 1e-12),
    )

    def setup(self, model: str, order: int, rays: int) -> None:
        """Prepare the series and the workspace."""
        self.chain = load(model).chain
        self.rays = np.random.default_rng(5).standard_normal((rays, self.chain.width))
        self.series = expand(self.chain, self.rays, order)
        size, rows = (4, 3) if self.chain.planar else (10, 6)
        shape = (order + 1, rays, self.chain.width, rows, self.chain.links.size * size)
        self.X, self.C = np.zeros(shape), np.zeros(shape)
        self.workspace = regressor_workspace(self.series.V, self.chain.links, self.chain.moves)
        self.start = np.empty((0, 4, 4))
        self.time_in_c(model, order, rays)

    def time_ours(self, model: str, order: int, rays: int) -> None:
        """Our compiled kernel."""
        chain, series = self.chain, self.series
        self.X[:] = 0.0
        body_regressors(
            0,
            order,
            self.start,
            chain.links,
            chain.moves,
            series.V,
            series.T,
            self.workspace,
            self.X,
        )

    def time_in_c(self, model: str, order: int, rays: int) -> None:
        """The same in C."""
        self.C[:] = 0.0
        compiled.momentum(self.chain, self.series.V, self.series.T, self.C)

    def track_difference(self, model: str, order: int, rays: int) -> float:
        """Largest difference of the rows, relative to the largest entry of each order."""
        self.time_ours(model, order, rays)
        self.time_in_c(model, order, rays)
        axes = tuple(range(1, self.X.ndim))
        return float((np.abs(self.X - self.C).max(axes) / np.abs(self.C).max(axes)).max())

    def track_error(self, model: str, order: int, rays: int) -> float:
        """Error of our rows along the first ray."""
        self.time_ours(model, order, rays)
        return reference.off(self.X[:, 0], reference.momentum(self.chain, self.rays[0], order))

    def track_operations_apart(self, model: str, order: int, rays: int) -> float:
        """Difference in the number of operations from the Python source, on one ray."""
        chain = self.chain
        series = expand(chain, np.ones((1, chain.width)), order)
        ours = compiled.operations_here(model, order, 1)
        theirs = compiled.operations_in_c(chain, series.V, series.T)
        self.operations = sum(theirs)
        return float(sum(abs(a - b) for a, b in zip(ours, theirs, strict=True)))

    def row(self, model: str, order: int, rays: int) -> dict[str, int]:
        """Number of operations per ray."""
        return {"operations per ray": self.operations}
