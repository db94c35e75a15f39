"""Claim: formulas of a four-bar take at most 2 s, of a six-bar 10 s, and of a 4-RRR 60 s.

That is with all checks. The error is how far the masses of the design space violate them.
"""

from __future__ import annotations

from balance import Formulas, formulas
from kinematics.loading.model_gallery import load
from kinematics.model.linkage import Linkage

STRAIGHT = "c1=-a1-b1"


class FourBars:
    """Conditions of force and of dynamic balance."""

    params = (
        ("four_bar_general", "force"),
        ("four_bar_general", "dynamic"),
        ("four_bar_kite", "dynamic"),
        ("four_bar_antiparallelogram", "dynamic"),
    )
    claims = (("time_formulas", 2.0), ("track_error", 1e-12), ("track_missing", 0.0))
    repetitions = 5
    motion: str | None = None

    def setup(self, model: str, balance: str) -> None:
        """Load the linkage."""
        self.linkage = self.load(model)
        self.answer = self.formulas(balance)

    def load(self, model: str) -> Linkage:
        """Load a linkage of the gallery."""
        return load(model)

    def formulas(self, balance: str) -> Formulas:
        """Derive the conditions."""
        return formulas(self.linkage, "force" if balance == "force" else "dynamic", self.motion)

    def time_formulas(self, model: str, balance: str) -> None:
        """Formulas of a linkage that is loaded."""
        self.answer = self.formulas(balance)

    def track_error(self, model: str, balance: str) -> float:
        """Return the violation by masses of the design space, relative."""
        return self.answer.residual

    def track_missing(self, model: str, balance: str) -> int:
        """Return the number of conditions that are not known, or not confirmed."""
        return self.answer.unknown + (not self.answer.confirmed)


class SixBars(FourBars):
    """Conditions of force balance, and of dynamic balance."""

    params = (
        ("six_bar_watt", "force"),
        ("six_bar_watt", "dynamic"),
        ("six_bar_stephenson", "force"),
        ("six_bar_stephenson", "dynamic"),
    )
    claims = (("time_formulas", 10.0), ("track_error", 1e-12), ("track_missing", 0.0))


class Platforms(FourBars):
    """A platform on four legs that turns."""

    params = (("four_rrr", "force"), ("four_rrr", "dynamic"))
    claims = (("time_formulas", 60.0), ("track_error", 1e-12), ("track_missing", 0.0))


class StraightPlatforms(FourBars):
    """A platform on four legs that does not turn; one pair and two pairs are parallel."""

    params = (("four_rrr_pair", "force"), ("four_rrr_parallel", "force"))
    claims = (("time_formulas", 60.0), ("track_error", 1e-12), ("track_missing", 0.0))
    motion = STRAIGHT

    def load(self, model: str) -> Linkage:
        """Load a linkage, driven by its first leg."""
        return load(model, inputs=["a1", "b1", "c1"])
