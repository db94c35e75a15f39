"""Claim: how sure a rank is, with the proof if there is one, takes at most two seconds.

Every proof is read by the checker of the tests, which shares nothing with what wrote it.
"""

from __future__ import annotations

import json
import runpy

from balance import certify, design_space
from benchmarks.processes import ROOT
from kinematics.models import gallery, load

LEVELS = ("proved", "verified", "estimated")


class ProofsTakeTwoSeconds:
    """Exact ranks modulo two primes, exact inertia transfers, and fresh poses."""

    params = tuple((name,) for name in gallery())
    claims = (("time_certainty", 2.0), ("track_refused", 0.0))
    total = True
    repetitions = 5

    def setup(self, model: str) -> None:
        """The space, whose kernels are compiled by now."""
        self.space = design_space(load(model))

    def time_certainty(self, model: str) -> None:
        """From a space that knows its rank alone."""
        self.certainty = certify(self.space).certainty

    def track_refused(self, model: str) -> int:
        """Whether there is a proof, and the checker does not take it."""
        certainty = certify(self.space).certainty
        if certainty.proof is None:
            return 0
        check = runpy.run_path(str(ROOT / "tests" / "checker.py"))["check"]
        try:
            check(json.loads(json.dumps(certainty.proof.to_dict())))
        except (AssertionError, ArithmeticError, LookupError, ValueError, TypeError):
            return 1
        return 0

    def row(self, model: str) -> dict[str, int]:
        """How sure the rank is."""
        return {level: int(self.certainty.level == level) for level in LEVELS}
