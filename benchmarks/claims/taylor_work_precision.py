"""Claim: a Taylor motion is faster than Newton's method alone, and than low-order steps.

It takes at most 0.4 of the time of Newton's method at the same points, and at most 0.3 of that
of as many steps of order 3 as leave no larger an error. Two hundred points within a quarter of
the radius of convergence; the expansion is included. The table shows the largest error of a
joint, in radians, against poses closed by Newton's method, how far those leave the loops open
in mpmath, and how many steps of order 3 match the error, 64 at most.
"""

from __future__ import annotations

import numpy as np

from benchmarks.references.reference import gap
from kinematics.assembly.tool_frame import tool
from kinematics.closure.newton import forward_kinematics, solve_positions
from kinematics.closure.series import expand_from
from kinematics.model.linkage import Linkage
from kinematics.model_gallery import load
from kinematics.taylor.taylor_motion import taylor_motion

POINTS, SHARE, SEED = 200, 0.25, 2
MOST = 64
# Points whose reference is checked.
CHECKED = 10


def _linkage(job: str) -> Linkage:
    """Forward kinematics of a linkage of the gallery, or the tip of the five-bar."""
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
        """Points, the poses that close the loops there, and the number of steps."""
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
        while self._off(self._stepped()) > max(self.error, 1e-13) and self.steps < MOST:
            self.steps *= 2

    def _off(self, q: np.ndarray) -> float:
        return float(np.abs(q - self.closed).max())

    def _predicted(self, order: int) -> np.ndarray:
        q = taylor_motion(self.linkage, order).evaluate(self.u)
        return q[:, self.chain.joints] / self.chain.units

    def _stepped(self) -> np.ndarray:
        """Positions after equal steps of order 3, each expanded anew."""
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
        """The error, that of the reference, and the steps that match ours."""
        gaps = [gap(self.chain, q) for q in self.closed[:CHECKED]]
        error, left = f"{self.error:.0e}", f"{max(gaps):.0e}"
        return {"error": error, "open by": left, "steps": str(self.steps)}

    def time_taylor(self, job: str, order: int) -> None:
        """Expand, and evaluate at all points."""
        self._predicted(order)

    def time_newton(self, job: str, order: int) -> None:
        """Close every pose from the reference pose, one after the other."""
        for v in self.v:
            solve_positions(self.chain, self.chain.columns @ v)

    def time_steps(self, job: str, order: int) -> None:
        """Step to every point."""
        self._stepped()
