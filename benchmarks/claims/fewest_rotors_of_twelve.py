"""Claim: all 4096 sets of twelve counter-rotors take less time than 512 programs of one set.

Certificates and feasible sets decide the others. Each geometry is new: two loops of seven
links with hinges at random decimals. The error is the number of sets that stay undecided.
"""

from __future__ import annotations

from itertools import cycle

import numpy as np

from balance import design_space
from balance.masses.remedies.counter_rotations.counter_rotors import (
    RotorConditions,
    rotor_conditions,
)
from balance.masses.remedies.counter_rotations.fewest_rotors import search_sets
from balance.masses.remedies.counter_rotations.rotor_sets import decide_rotors
from benchmarks.inputs.geometry import two_loops

# Programs that the search must undercut, an eighth of all sets.
PROGRAMS = 512
# Geometries in turn.
GEOMETRIES = 3


def _conditions(seed: int) -> RotorConditions:
    """Compute the conditions of two loops of seven links on one base."""
    return rotor_conditions(design_space(two_loops(7, seed)))


class FewestRotorsOfTwelve:
    """Two loops of seven links."""

    slow = True
    params = ((12,),)
    claims = (("time_search", "time_programs", 1.0), ("track_undecided", 0.5))

    def setup(self, candidates: int) -> None:
        """Prepare the conditions of several geometries."""
        self.conditions = cycle([_conditions(seed) for seed in range(GEOMETRIES)])
        self.chosen = np.random.default_rng(0).integers(0, 2, (PROGRAMS, candidates))

    def time_search(self, candidates: int) -> None:
        """All sets, pruned."""
        search_sets(next(self.conditions))

    def time_programs(self, candidates: int) -> None:
        """Programs of random sets, each by itself."""
        conditions = next(self.conditions)
        for one in self.chosen:
            decide_rotors(conditions, np.flatnonzero(one).tolist())

    def track_undecided(self, candidates: int) -> float:
        """Number of sets that neither a design nor a certificate decides."""
        return float(len(search_sets(next(self.conditions)).open))
