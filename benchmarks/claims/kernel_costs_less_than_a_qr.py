"""Claim: closure and momentum series cost at most half of one pivoted QR of their rows.

The error is that of the rows along one ray against finite poses in mpmath.
"""

from __future__ import annotations

from itertools import cycle
from math import comb

import numpy as np
import scipy.linalg

from balance.space.momentum.regressor import RegressorSeries
from benchmarks.inputs.geometry import variants
from benchmarks.references import reference
from kinematics.closure.series import expand


class KernelCostsLessThanAQr:
    """Both kernels to a fixed order, along as many rays as span that order."""

    params = (("four_bar_general", 4), ("three_rsr", 2))
    claims = (("time_kernels", "time_pivoted_qr", 0.5), ("track_error", 1e-12))

    def setup(self, model: str, order: int) -> None:
        """Prepare geometries, rays, and the rows for the factorisation."""
        chains = [linkage.chain for linkage in variants(model, 24)]
        width = chains[0].width
        rays = np.random.default_rng(1).standard_normal((comb(width + order - 1, order), width))
        self.rays = rays / np.linalg.norm(rays, axis=1, keepdims=True)
        self.order = order
        self.chains = cycle(chains)
        self.stacks = cycle([self._stack(chain) for chain in chains])

    def _rows(self, chain) -> np.ndarray:
        return RegressorSeries(chain, expand(chain, self.rays, self.order)).rows(self.order)

    def _stack(self, chain) -> np.ndarray:
        """Stack the rows of every order, along the rays that span it."""
        rows = self._rows(chain)
        needed = [comb(chain.width + k - 1, k) for k in range(self.order + 1)]
        blocks = [block[:count] for block, count in zip(rows, needed, strict=True)]
        return np.concatenate([block.reshape(-1, block.shape[-1]) for block in blocks])

    def time_kernels(self, model: str, order: int) -> None:
        """Closure series and momentum series of another geometry."""
        self._rows(next(self.chains))

    def time_pivoted_qr(self, model: str, order: int) -> None:
        """LAPACK's pivoted QR of the stacked regressor of another geometry."""
        scipy.linalg.qr(next(self.stacks), mode="r", pivoting=True)

    def track_error(self, model: str, order: int) -> float:
        """Error of the rows, relative to the largest entry of each order."""
        chain = next(self.chains)
        true = reference.momentum(chain, self.rays[0], order)
        return reference.off(self._rows(chain)[:, 0], true)
