"""Counterweights: the least matter, added inside regions of links, that balances a linkage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import get_args

import numpy as np

from balance.masses.counterweights.answer import Counterweights, Relaxation
from balance.masses.counterweights.decide import decide
from balance.masses.counterweights.link_regions import default_region, regions_of
from balance.masses.counterweights.program import AddedObjective
from balance.masses.counterweights.regions import Region
from balance.space.requirements.in_space import in_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import BOUND_RELATIVE, GROWTH_RELATIVE
from kinematics.numerics.linalg.ties import rank_least_first

# Largest factor by which a region may grow.
LARGEST_GROWTH = 64.0


def counterweights(
    space: DesignSpace, add: Sequence[str],
    regions: Mapping[str, Region | str] | None = None, minimise: AddedObjective = "mass",
    *, relax: bool = True,
) -> Counterweights:  # fmt: skip
    """Compute the least matter that balances a linkage when added to some of its links.

    The masses in the file stay. Added matter is any measure inside a region of each link's
    frame, ``Σ_b ∫ A_b(x) dμ_b = r``, so that the program is convex: its answer is a global
    optimum with a proved gap, or infeasible with a certificate. For dynamic balance of a
    planar linkage, all six components of the momentum count.

    Args:
        space: a design space.
        add: names of the links to which matter may be added.
        regions: where, by name: a `Region` of the link frame, or its text, such as
            ``ball(0,0,0,0.1)``, ``box(-0.2:0,-0.1:0.1,0:0.1)``,
            ``cylinder(x,y,z,ax,ay,az,r,length)``, ``ellipsoid(x,y,z,a,b,c)`` in metres, or
            ``collision``, the convex hull of the link's collision elements. By default a ball
            about the joint that carries the link, of half its length.
        minimise: ``"mass"``: added mass, kg; ``"inertia"``: the largest principal moment of
            inertia of any of these links with its counterweight, about the origin of its
            frame, kg m²; ``"rotor"``: trace of the generalised inertia matrix at the reference
            pose, kg m². The last two have a price on mass, 0.01 squares of ``space.length``.
        relax: whether to look for single changes that help if there is no answer.

    Returns:
        The counterweights, or the certificate.

    Raises:
        BodyError: a body is unknown, or part of the ground.
        UsageError: no link is named, one is named twice, or a region is wrong.
        ValueError: there is no such objective.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf", balance="force")
        >>> answer = balance.counterweights(space, ["crank", "rocker"])
        >>> answer.verdict
        'feasible'
    """
    if minimise not in get_args(AddedObjective):
        raise ValueError(f"minimise must be one of {', '.join(get_args(AddedObjective))}")
    body_regions = regions_of(space, add, regions or {})
    if space.planar and space.balance == "dynamic":
        space = in_space(space)
    answer = decide(space, body_regions, minimise)
    given = regions or {}
    answer = replace(answer, chosen=tuple(name for name in answer.regions if name not in given))
    if answer.verdict != "infeasible" or not relax:
        return answer
    helps = _single_relaxations(space, body_regions)
    text = f"{answer.words}; {helps[0].words}" if helps else answer.words
    return replace(answer, relaxations=helps, words=text)


def _single_relaxations(
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
