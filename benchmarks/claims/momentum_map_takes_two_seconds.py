"""Claim: a map of the momentum matrix over 200 by 200 poses takes at most two seconds.

The error is the largest relative difference of the matrices from those of single poses.
"""

from __future__ import annotations

import numpy as np

from balance.pose import momentum_map, reaction_null_space
from kinematics.loading.model_gallery import load


class MomentumMap:
    """A planar five-bar around its pose in the file."""

    params = (("five_bar", 200),)
    claims = (("time_map", 2.0), ("track_error", 1e-9))
    repetitions = 3

    def setup(self, model: str, count: int) -> None:
        """Load the linkage."""
        self.linkage = load(model)
        self.angles = np.linspace(-0.3, 0.3, count)

    def time_map(self, model: str, count: int) -> None:
        """All poses."""
        axes = dict.fromkeys(self.linkage.inputs, self.angles)
        self.map = momentum_map(self.linkage, axes)

    def track_error(self, model: str, count: int) -> float:
        """Of every fortieth row and column."""
        self.time_map(model, count)
        errors = []
        for i in range(0, count, 40):
            for k in range(0, count, 40):
                pose = [self.angles[i], self.angles[k]]
                matrix = reaction_null_space(self.linkage, pose).matrix
                error = np.abs(self.map.matrix[i, k] - matrix).max()
                errors.append(error / np.abs(matrix).max())
        return float(max(errors))
