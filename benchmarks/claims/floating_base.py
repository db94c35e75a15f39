"""Claim: ten seconds on a base that floats are simulated in ten, and energy is conserved.

The error is the larger drift of energy and momentum, relative to their peaks.
"""

from __future__ import annotations

from balance.motion.floating_base.base import FloatingBase
from balance.motion.floating_base.simulate import simulate_floating_base
from kinematics.loading.model_gallery import load

BASE = FloatingBase(4.0, (0.5, 0.7, 0.9), (0.1, -0.2, 0.05), 40.0, 900.0)


class FloatingBaseConservesEnergy:
    """Ten linkages on springs, on the first random motion."""

    params = tuple(
        (name,)
        for name in (
            "zero_reaction_arm",
            "double_pendulum_counter_rotary",
            "hprs",
            "fuga_i",
            "four_bar_general",
            "five_bar",
            "slider_crank",
            "four_bar_kite_balanced",
            "three_rsr",
            "rusr",
        )
    )
    claims = (("time_simulation", 10.0), ("track_error", 1e-9))
    repetitions = 1
    slow = True

    def setup(self, model: str) -> None:
        """Prepare the linkage and compile the kernels."""
        self.linkage = load(model)
        simulate_floating_base(self.linkage, BASE, duration=0.1)

    def time_simulation(self, model: str) -> None:
        """Ten seconds."""
        simulate_floating_base(self.linkage, BASE)

    def track_error(self, model: str) -> float:
        """Relative to the peaks."""
        found = simulate_floating_base(self.linkage, BASE)
        return max(found.energy_drift, found.momentum_drift)
