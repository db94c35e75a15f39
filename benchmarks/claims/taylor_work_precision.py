"""Claim: a Taylor motion is faster than Newton's method, and than steps of low order.

It takes at most 0.4 of the time of Newton's method at the same points, and at most 0.3 of that
of steps of order 3 with the same error. There are 200 points within a quarter of the radius of
convergence, and the time includes the expansion. The table shows the largest joint error, in
radians, against poses closed by Newton's method, the loop residual of those poses in mpmath,
and the number of steps of order 3 with the same error, at most 64.
"""

from __future__ import annotations

import numpy as np

from benchmarks.references.reference import gap
from kinematics.closure.assembly.tool_frame import tool
from kinematics.closure.newton import forward_kinematics, solve_positions
from kinematics.closure.series import expand_from
from kinematics.closure.taylor.taylor_motion import taylor_motion
from kinematics.loading.model_gallery import load
from kinematics.model.linkage import Linkage

# Number of points, their largest distance in parts of the radius, and the random seed.
POINTS, SHARE, SEED = 200, 0.25, 2
# Largest number of steps of order 3.
MAX_STEPS = 64
# Number of points whose reference is checked.
CHECKED = 10


def _linkage(job: str) -> Linkage:
    """Load a linkage of the gallery, or the five-bar with its tip as input."""
    if job == "five_bar_tip":
        return tool(load("five_bar"), "left_upper", "x,y", (0.5, 1.1, 0.0))
    return load(job)


class TaylorWorkPrecision:
    """Time against error, by order."""

    params = tuple(
        (job, order)
        for job in ("five_bar_tip", "bennett", "three_rsr")
        for order in range(12 if job != "three_rsr" else 8, 0, -1)
    )
    claims = (("time_taylor", "time_newton", 0.4), ("time_taylor", "time_steps", 0.3))
    repetitions = 7

    def setup(self, job: str, order: int) -> None:
        """Prepare points, the closed poses there, and the number of steps."""
        self.linkage = _linkage(job)
        motion = taylor_motion(self.linkage, order)
        self.chain = motion.chain
        rng = np.random.default_rng(SEED)
        v = rng.standard_normal((POINTS, motion.scales.size))
        sizes = SHARE * motion.radius * rng.uniform(0.0, 1.0, (POINTS, 1))
        self.v = sizes * v / np.linalg.norm(v, axis=1, keepdims=True)
        self.u = self.v * motion.scales
        self.closed = np.array([motion.polish(u) for u in self.u])[:, self.chain.joints]
        self.closed /= self.chain.units
        self.error = self._off(self._predicted(order))
        self.steps = 1
        while self._off(self._stepped()) > max(self.error, 1e-13) and self.steps < MAX_STEPS:
            self.steps *= 2

    def _off(self, q: np.ndarray) -> float:
        return float(np.abs(q - self.closed).max())

    def _predicted(self, order: int) -> np.ndarray:
        q = taylor_motion(self.linkage, order).evaluate(self.u)
        return q[:, self.chain.joints] / self.chain.units

    def _stepped(self) -> np.ndarray:
        """Compute positions after equal steps of order 3, each with a new expansion."""
        return np.array([self._one(v / self.steps) for v in self.v])

    def _one(self, ray: np.ndarray) -> np.ndarray:
        q, screws = np.zeros(self.chain.parent.size), self.chain.screws
        for k in range(self.steps):
            rates = expand_from(self.chain, screws, ray[None], 2).C[0] @ ray
            q = q + rates[0] + rates[1] / 2.0 + rates[2] / 3.0
            if k + 1 < self.steps:
                screws = forward_kinematics(self.chain, q).screws
        return q

    def row(self, job: str, order: int) -> dict[str, str]:
        """Error, residual of the reference, and number of steps with the same error."""
        gaps = [gap(self.chain, q) for q in self.closed[:CHECKED]]
        error, left = f"{self.error:.0e}", f"{max(gaps):.0e}"
        return {"error": error, "open by": left, "steps": str(self.steps)}

    def time_taylor(self, job: str, order: int) -> None:
        """Expand, and evaluate at all points."""
        self._predicted(order)

    def time_newton(self, job: str, order: int) -> None:
        """Close every pose from the reference pose."""
        for v in self.v:
            solve_positions(self.chain, self.chain.columns @ v)

    def time_steps(self, job: str, order: int) -> None:
        """Step to every point."""
        self._stepped()
