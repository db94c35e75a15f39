"""Single changes that make an infeasible request for counterweights feasible."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from balance.masses.counterweights.answer import Counterweights, Relaxation
from balance.masses.counterweights.decide import decide
from balance.masses.counterweights.link_regions import default_region
from balance.masses.counterweights.regions import Region
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import BOUND_RELATIVE, GROWTH_RELATIVE
from kinematics.numerics.linalg.ties import rank_least_first

# Largest factor by which a region may grow.
LARGEST_GROWTH = 64.0


def single_relaxations(
    space: DesignSpace, regions: Mapping[int, Region]
) -> tuple[Relaxation, ...]:
    """Find the smallest growth of each region, and each further link, that alone helps.

    A region that grows about its centre contains the smaller one, so that feasibility is
    monotone in the factor, and bisection finds the smallest one. The factor that is returned
    was found feasible, and one smaller by a thousandth was not.

    Args:
        regions: region by position of the body; no matter in them balances the linkage.

    Returns:
        Growths of regions, the smallest first, then further links, the lightest first;
        equal ones in the order of the bodies.
    """
    grown = [relaxation for b in regions if (relaxation := _smallest_growth(space, regions, b))]
    more = []
    for b in range(len(space.bodies)):
        if b not in regions:
            answer = decide(
                space, dict(sorted({**regions, b: default_region(space, b)}.items()))
            )
            if answer.verdict == "feasible":
                more.append(Relaxation(space.bodies[b], None, answer.added_mass))
    factors = [relaxation.factor or 0.0 for relaxation in grown]
    masses = [relaxation.mass for relaxation in more]
    return (
        *(grown[k] for k in rank_least_first(factors, relative=2.0 * GROWTH_RELATIVE)),
        *(more[k] for k in rank_least_first(masses, relative=BOUND_RELATIVE)),
    )


def _smallest_growth(
    space: DesignSpace, regions: Mapping[int, Region], body: int
) -> Relaxation | None:
    """Find the smallest factor by which a region must grow; None if none up to 64 helps."""

    def at(factor: float) -> Counterweights:
        return decide(space, {**regions, body: regions[body].grown(factor)})

    low, high = 1.0, LARGEST_GROWTH
    answer = at(high)
    if answer.verdict != "feasible":
        return None
    while high > low * (1.0 + GROWTH_RELATIVE):
        middle = float(np.sqrt(low * high))
        trial = at(middle)
        if trial.verdict == "feasible":
            high, answer = middle, trial
        else:
            low = middle
    return Relaxation(space.bodies[body], high, answer.added_mass)
