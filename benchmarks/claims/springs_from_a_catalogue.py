"""Claim: springs of a catalogue cost less than 1681 programs of their choices alone by SciPy.

The peer is given the torques over the workspace, and solves the bounded least squares of each
choice of stiffnesses by the method of F. Stark and R. Parker (BVLS). Ours computes these
torques, leaves choices out whose bound excludes them, and decides balance and certainty, too.
The error is that of the least torque, relative.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import lsq_linear

from balance import springs
from balance.masses.springs.attached_springs import attach_springs
from balance.masses.springs.spring_problem import SpringProblem
from balance.masses.springs.spring_text import read_spring
from kinematics.loading.model_gallery import load

GRAVITY = (0.0, -9.81, 0.0)
# Two springs from the ground, each of which may be attached anywhere on a line there.
ASKED = {
    "four_bar_general": (
        "base@0:0.3,0.3,0 crank@0.05,0.2,0",
        "base@0.4:0.8,0.3,0 rocker@0.1,0.2,0",
    ),
    "slider_crank": ("base@0,0.2:0.4,0 crank@0.1,0,0", "base@0.3,0.2:0.4,0 coupler@0.1,0,0"),
}
CATALOGUE = tuple(float(k) for k in np.linspace(5.0, 122.0, 40))


class SpringsOfACatalogue:
    """All 1681 choices of two springs, none of which balances."""

    params = tuple((name,) for name in ASKED)
    claims = (("time_ours", "time_programs", 1.0), ("track_error", 1e-9))
    repetitions = 5

    def setup(self, model: str) -> None:
        """Load the linkage, and compute the torques of unit springs."""
        self.linkage = load(model)
        asked = attach_springs(self.linkage, [read_spring(text) for text in ASKED[model]])
        problem = SpringProblem(self.linkage, asked, np.array(GRAVITY), {})
        rows = problem.torque_rows
        self.rows = rows.reshape(-1, rows.shape[-1])
        self.steps = [0.0, *(k / problem.unit for k in CATALOGUE)]
        self.time_ours(model)

    def time_ours(self, model: str) -> None:
        """The public call."""
        self.answer = springs(self.linkage, ASKED[model], gravity=GRAVITY, catalogue=CATALOGUE)

    def time_programs(self, model: str) -> None:
        """Bounded least squares of each choice."""
        self.least = min(
            self._program(first, second) for first in self.steps for second in self.steps
        )

    def _program(self, first: float, second: float) -> float:
        """Norm of the torques that two stiffnesses leave, with the best of their points."""
        given = self.rows @ np.array([first, 0.0, second, 0.0, 1.0])
        limits = np.array([first, second])
        free = limits > 0.0
        if not free.any():
            return float(np.linalg.norm(given))
        A = self.rows[:, [1, 3]][:, free]
        program = lsq_linear(A, -given, (-limits[free], limits[free]), method="bvls")
        return float(np.sqrt(2.0 * program.cost))

    def track_error(self, model: str) -> float:
        """Difference of the least torque, over that of gravity."""
        self.time_programs(model)
        alone = float(np.linalg.norm(self.rows[:, -1]))
        return abs(self.answer.share_left - self.least / alone)
