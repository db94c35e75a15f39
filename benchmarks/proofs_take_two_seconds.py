"""Claim: how sure a rank is, with the proof if there is one, takes at most two seconds."""

from __future__ import annotations

from dataclasses import replace

from balance import design_space
from kinematics.models import gallery, load

LEVELS = ("proved", "verified", "estimated")


class ProofsTakeTwoSeconds:
    """Exact ranks modulo two primes, exact inertia transfers, and fresh poses."""

    params = tuple((name,) for name in gallery())
    claims = (("time_certainty", 2.0),)
    total = True
    repetitions = 5

    def setup(self, model: str) -> None:
        """The space, whose kernels are compiled by now."""
        self.space = design_space(load(model))

    def time_certainty(self, model: str) -> None:
        """From a space that knows its rank alone."""
        self.certainty = replace(self.space).certainty

    def row(self, model: str) -> dict[str, int]:
        """How sure the rank is."""
        return {level: int(self.certainty.level == level) for level in LEVELS}
