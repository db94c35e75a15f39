"""Claim: the certification of a design space, with its proof, takes at most two seconds.

The checker of the tests, which shares no code with the package, checks every proof.
"""

from __future__ import annotations

import json

from balance import certify, design_space
from kinematics.loading.model_gallery import gallery, load
from tests.independent.checker import Rejected, check

LEVELS = ("proved", "verified", "estimated")


class ProofsAreQuick:
    """Exact ranks modulo two primes, exact inertia transfers, and fresh poses."""

    params = tuple((name,) for name in gallery())
    claims = (("time_certainty", 2.0), ("track_refused", 0.0))
    total = True
    repetitions = 5

    def setup(self, model: str) -> None:
        """Compute the space; its kernels are compiled then."""
        self.space = design_space(load(model))

    def time_certainty(self, model: str) -> None:
        """Certification of a space from floating-point arithmetic."""
        self.certainty = certify(self.space).certainty

    def track_refused(self, model: str) -> int:
        """Return 1 if the checker rejects the proof, otherwise 0."""
        certainty = certify(self.space).certainty
        if certainty.proof is None:
            return 0
        try:
            check(json.loads(json.dumps(certainty.proof.to_dict())))
        except Rejected:
            return 1
        return 0

    def row(self, model: str) -> dict[str, int]:
        """1 for the level of certainty, 0 for the others."""
        return {level: int(self.certainty.level == level) for level in LEVELS}
