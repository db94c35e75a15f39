"""Counterweights: the least matter, added inside regions of links, that balances a linkage."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import chain
from typing import get_args

import numpy as np

from balance.masses.counterweights.added_program import IDLE_MASS_PRICE, AddedObjective
from balance.masses.counterweights.alike_links import alike_links, classes_among
from balance.masses.counterweights.counterweights_result import Counterweights, Relaxation
from balance.masses.counterweights.decide_points import decide
from balance.masses.counterweights.link_regions import (
    ALL,
    default_region,
    regions_by_name,
    regions_of,
)
from balance.masses.counterweights.moved_matter import moved_links
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.shaped.decide_shaped import decide_shaped
from balance.masses.counterweights.shaped.exclude_shapes import exclude_shapes
from balance.masses.counterweights.shaped.shape_changes import (
    balancing_shape_mass,
    shape_changes,
)
from balance.masses.counterweights.shaped.weight_shape import WeightShape, wanted_shapes
from balance.masses.counterweights.volume.decide_filled import balancing_mass, decide_filled
from balance.masses.counterweights.volume.plates import (
    density_limits,
    stocks_of,
    with_further_links,
)
from balance.masses.designs.density import STEEL, DensityLimit
from balance.motion.verification.before_after import compare_masses
from balance.motion.verification.given_motions import Motions, motions_or_turn
from balance.space.requirements.contradiction import contradiction, contradiction_words
from balance.space.requirements.recompute_spatial import recompute_spatial
from balance.space.requirements.required_space import (
    RequiredSpace,
    space_of,
    with_requirements,
)
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.materials import Density, density_in_si
from balance.support.options import Balance
from balance.support.tolerances import GROWTH_RELATIVE, MASS_GAP
from balance.support.units import length_in_si
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.motion import Motion
from kinematics.numerics.linalg.ties import rank_least_first

# Largest factor by which a region may grow.
LARGEST_GROWTH = 64.0

MassOf = Callable[[Mapping[int, Region]], float | None]


def counterweights(
    space: DesignSpace | LinkageLike,
    links: Sequence[str],
    regions: Mapping[str, Region | str] | None = None,
    minimise: AddedObjective = "mass",
    *,
    density: Density = STEEL,
    thickness: float | str | None = None,
    price_of_mass: float = IDLE_MASS_PRICE,
    shape: str | None = None,
    move: Mapping[str, float] | None = None,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance | None = None,
    motions: Motions | None = None,
    speed: float | str | None = None,
    crank: str | None = None,
    relax: bool = True,
    prove: bool = True,
) -> Counterweights:
    """Compute the least matter that balances a linkage when added to some of its links.

    The masses in the file stay. Added matter is any measure inside a region of each link's
    frame whose density is nowhere above that of the material, ``Σ_b ∫ A_b(x) dμ_b = r``, so
    that the program is convex: its answer is a global optimum with a proved gap, or infeasible
    with a certificate. For dynamic balance of a planar linkage, all six components of the
    momentum count.

    The least matter fills the parts of the regions where a quadratic polynomial is positive;
    for forces a plane cuts them off. See `balance.masses.counterweights.volume.fill_program`.
    In the limit of infinite density it is point masses.

    Args:
        space: a design space, or a linkage, its path or its name.
        links: names of the links to which matter may be added, or a text, ``"crank,rocker"``.
        regions: where, by name, or ``all`` for each link without one: a `Region` of the link
            frame, or its text, such as ``ball(0,0,0,0.1)``, ``box(-0.2:0,-0.1:0.1,0:0.1)``,
            ``cylinder(x,y,z,ax,ay,az,r,length)``, ``ellipsoid(x,y,z,a,b,c)`` in metres,
            ``mesh(FILE.stl,1mm)``, a closed convex mesh in the link frame and its unit, or
            ``collision``, the convex hull of the link's collision elements. By default a ball
            about the joint that carries the link, of half its length, or of a radius: ``80mm``.
        minimise: ``"mass"``: added mass, kg; ``"inertia"``: the largest principal moment of
            inertia of any of these links with its counterweight, about the origin of its
            frame, kg m²; ``"rotor"``: trace of the generalised inertia matrix at the reference
            pose, kg m². The last two have a price on mass: ``price_of_mass``.
        density: density that added matter nowhere exceeds, or that on each link by name,
            kg/m³ or a material as ``"lead"``; steel by default. None for point masses, denser
            than any material.
        thickness: that of plates of added matter on a planar linkage, m or ``"20mm"``, in
            equal halves about the plane of the linkage, within the section of each region with
            it. The momentum then has three components. Not for point masses.
        price_of_mass: what is added to the objectives inertia and rotor for each kilogram, in
            squares of ``space.length``, so that no mass is added that serves nothing.
        shape: ``disc=0.02`` or ``block=0.02``, of that thickness in metres,
            ``cylinder=0.03``, of that radius, or ``sector=0.02,0.1``, of that thickness and
            radius about the joint that carries the link (without a radius that of the largest
            circle about it in the region): each counterweight is one of them, across the plane
            of the linkage and within its region, for the least mass of such shapes that
            balances forces. ``disc=0.005/0.008/0.01`` gives a choice: each counterweight has
            the size that is best. Not for point masses.
        move: links whose given matter may be moved, with the largest share of it, by name: it
            is taken evenly from all of the link, and at least as much is placed in its region
            again. The mass then is that which the linkage gains, and a kilogram that is moved
            costs a hundredth of one that is added.
        motion: restriction of the inputs of a linkage; a space has its own.
        balance: ``"dynamic"``, as by default of a linkage, or ``"force"``.
        motions: one or several, as for `balance.verify`; the answer then has the loads along
            them, before and after.
        speed: speed of a crank, rad/s, or ``"300rpm"``; one turn of it is the motion.
        crank: name of that crank; by default as for `balance.motion.one_turn`.
        relax: whether to look for changes that help if there is no answer: of one link, or of
            links that are alike.
        prove: whether the gap of matter of limited density is proved by integrals of many
            samples; else it is that of the integrals which found the matter.

    Returns:
        The counterweights, or the certificate.

    Raises:
        BodyError: a body is unknown, or part of the ground.
        FileError: the mesh of a region cannot be read, or is not closed and convex.
        UsageError: no link is named, one is named twice, or a region, a density, the thickness
            or the price is wrong.
        ValueError: there is no such objective.

    Example:
        >>> import balance
        >>> links = ["crank", "rocker"]
        >>> balance.counterweights("robot.urdf", links, balance="force").verdict
        'feasible'
    """
    if minimise not in get_args(AddedObjective):
        raise ValueError(f"minimise must be one of {', '.join(get_args(AddedObjective))}")
    asked = as_space(space, motion, balance)
    motions = motions_or_turn(asked.linkage, motions, speed, crank, asked.motion)
    regions = regions_by_name(asked.linkage, links, regions or {})
    body_regions = regions_of(asked, links, regions)
    thickness = length_in_si(thickness)
    limits = density_limits(asked, body_regions, density_in_si(density), thickness)
    if not (np.isfinite(price_of_mass) and price_of_mass >= 0.0):
        raise UsageError(f"a price of mass of {price_of_mass:g}: give a number from 0 up")
    if asked.planar and asked.balance == "dynamic" and thickness is None:
        asked = recompute_spatial(asked)
    choices = wanted_shapes(shape, asked, density, move, _name_clash(minimise, thickness))
    moved = moved_links(asked, body_regions, move)
    if limits:
        stocks = stocks_of(asked, body_regions, limits)
        denser = relax and not choices
        answer = decide_filled(asked, stocks, minimise, price_of_mass, prove, denser, moved)
        if choices and answer.weights:
            answer = decide_shaped(answer, stocks, choices)
            answer = exclude_shapes(answer, stocks, choices)
    else:
        answer = decide(asked, body_regions, minimise, price_of_mass, moved)
    chosen = tuple(name for name in answer.regions if name not in regions)
    answer = replace(answer, chosen=chosen, thickness=thickness)
    if motions is not None and answer.z is not None:
        return with_loads(answer, motions)
    undecided = answer.verdict == "undecided" and not choices
    if answer.verdict == "feasible" or undecided or not relax:
        return answer

    mass_of = _mass_finder(answer, limits, choices, moved)
    if choices:
        grown = shape_changes(answer, stocks, choices)
    else:
        grown = _smallest_growths(asked, body_regions, mass_of)
    answer = _with_relaxations(answer, body_regions, grown, mass_of)
    if isinstance(asked, RequiredSpace) and len(asked.regions) > 1 and not limits:
        words = f"{answer.words}; {_contradiction(asked, body_regions)}"
        return replace(answer, words=words)
    return answer


def _mass_finder(
    answer: Counterweights,
    limits: Mapping[int, DensityLimit],
    choices: Sequence[WeightShape],
    moved: Mapping[int, float],
) -> MassOf:
    """Make the function that computes the mass of matter in other regions that balances."""
    space = answer.space

    def mass_of(regions: Mapping[int, Region]) -> float | None:
        if not limits:
            helped = decide(space, regions, moved=moved)
            return helped.added_mass if helped.verdict == "feasible" else None
        held = stocks_of(space, regions, with_further_links(limits, regions))
        if choices:
            return balancing_shape_mass(answer, held, choices)
        return balancing_mass(space, held, moved)

    return mass_of


def _with_relaxations(
    answer: Counterweights,
    regions: Mapping[int, Region],
    grown: tuple[Relaxation, ...],
    mass_of: MassOf,
) -> Counterweights:
    """Add changes that would help, and the first of them to the words.

    Args:
        regions: region by position of the body; no matter in them balances the linkage.
        grown: growths of regions that would help.
        mass_of: computes the mass of matter in some regions that balances the linkage.
    """
    more = _find_further_links(answer.space, regions, mass_of, together=not grown)
    answer = replace(answer, relaxations=(*answer.relaxations, *grown, *more))
    words = [change.words for change in answer.worth_naming[:1]]
    if not words and answer.verdict == "undecided":
        words = ["other regions, sizes or shapes may do"]
    return replace(answer, words="; ".join([answer.words, *words]))


def _name_clash(minimise: AddedObjective, thickness: float | None) -> str:
    """Say what of a request does not go with a shape; empty if all does."""
    if minimise == "mass" and thickness is None:
        return ""
    return "shapes are found for the least mass, and have their thickness: leave out the rest"


def _contradiction(space: RequiredSpace, regions: Mapping[int, Region]) -> str:
    """Name the requirements that no matter in the regions meets: one alone, or two."""

    def excluded(chosen: Sequence[int]) -> bool:
        some = with_requirements(
            space_of(space.common, [space.regions[k] for k in chosen]),
            space.certainty,
            space.common,
            [space.regions[k] for k in chosen],
        )
        return decide(some, regions).verdict == "infeasible"

    return contradiction_words(contradiction(space.texts, excluded), "counterweight")


def _smallest_growths(
    space: DesignSpace, regions: Mapping[int, Region], mass_of: MassOf
) -> tuple[Relaxation, ...]:
    """Find the smallest growths of regions that alone help.

    Links that are alike are taken together: where the linkage is symmetric, so is the least
    matter. A region that grows about its centre contains the smaller one, so that feasibility
    is monotone in the factor, and bisection finds the smallest one. The factor that is returned
    was found feasible, and one smaller by a thousandth was not.

    Args:
        regions: region by position of the body; no matter in them balances the linkage.
        mass_of: computes the mass of matter in some regions that balances the linkage.

    Returns:
        Growths, the smallest first; equal ones in the order of the bodies.
    """
    classes = classes_among(alike_links(space.linkage), regions)
    growths = [_smallest_growth(space, regions, alike, mass_of) for alike in classes]
    grown = [relaxation for relaxation in growths if relaxation]
    factors = [relaxation.factor or 0.0 for relaxation in grown]
    return tuple(grown[k] for k in rank_least_first(factors, relative=2.0 * GROWTH_RELATIVE))


def _find_further_links(
    space: DesignSpace, regions: Mapping[int, Region], mass_of: MassOf, together: bool
) -> tuple[Relaxation, ...]:
    """Find the further links, in their default regions, that alone help.

    Links that are alike are taken together; the first of them alone is tried too.

    Args:
        regions: region by position of the body; no matter in them balances the linkage.
        mass_of: computes the mass of matter in some regions that balances the linkage.
        together: whether to look for as many as are needed together if none alone help.

    Returns:
        Further links, the lightest first; equal ones in the order of the bodies.
    """
    more: list[Relaxation] = []
    others = {*range(len(space.bodies))} - {*regions}
    further = classes_among(alike_links(space.linkage), others)
    for alike in further:
        more += _further_of_class(space, regions, alike, mass_of)
    if together and not more and len(further) > 1:
        return _fewest_further_links(space, regions, further, mass_of)
    masses = [relaxation.mass for relaxation in more]
    return tuple(more[k] for k in rank_least_first(masses, relative=2.0 * MASS_GAP))


def _further_of_class(
    space: DesignSpace, regions: Mapping[int, Region], alike: Sequence[int], mass_of: MassOf
) -> list[Relaxation]:
    """Add matter to bodies that are alike: to the first alone, and to all if they take less."""
    every = _further_links(space, regions, alike, mass_of)
    if every is None or len(alike) == 1:
        return [every] if every else []
    first = _further_links(space, regions, alike[:1], mass_of)
    if first is None:
        return [every]
    lighter = every.mass < first.mass * (1.0 - 2.0 * MASS_GAP)
    return [first, every] if lighter else [first]


def _further_links(
    space: DesignSpace, regions: Mapping[int, Region], bodies: Sequence[int], mass_of: MassOf
) -> Relaxation | None:
    """Add matter to further bodies, in their default regions; None if that does not help."""
    more = {b: default_region(space, b) for b in bodies}
    mass = mass_of(dict(sorted({**regions, **more}.items())))
    if mass is None:
        return None
    return Relaxation(tuple(space.bodies[b] for b in sorted(bodies)), None, mass)


def _fewest_further_links(
    space: DesignSpace,
    regions: Mapping[int, Region],
    further: Sequence[tuple[int, ...]],
    mass_of: MassOf,
) -> tuple[Relaxation, ...]:
    """Leave out of all further links those that are not needed; empty if all do not help.

    All of them come second, if they take less.
    """
    kept = list(further)
    relaxation = _further_links(space, regions, list(chain(*kept)), mass_of)
    if relaxation is None:
        return ()
    every = relaxation
    for alike in further[::-1]:
        fewer = [part for part in kept if part != alike]
        fewest = _further_links(space, regions, list(chain(*fewer)), mass_of) if fewer else None
        if fewest is not None:
            kept, relaxation = fewer, fewest
    whole = replace(every, links=(ALL,))
    if relaxation is every:
        return (whole,)
    lighter = every.mass < relaxation.mass * (1.0 - 2.0 * MASS_GAP)
    return (relaxation, whole) if lighter else (relaxation,)


def _smallest_growth(
    space: DesignSpace, regions: Mapping[int, Region], alike: Sequence[int], mass_of: MassOf
) -> Relaxation | None:
    """Find the smallest factor by which regions must grow; None if none up to 64 helps."""

    def at(factor: float) -> float | None:
        return mass_of({**regions, **{b: regions[b].grown(factor) for b in alike}})

    low, high = 1.0, LARGEST_GROWTH
    mass = at(high)
    if mass is None:
        return None
    while high > low * (1.0 + GROWTH_RELATIVE):
        middle = float(np.sqrt(low * high))
        trial = at(middle)
        if trial is not None:
            high, mass = middle, trial
        else:
            low = middle
    return Relaxation(tuple(space.bodies[b] for b in alike), high, mass)


def with_loads(
    counterweights: Counterweights, motions: Motions | None = None
) -> Counterweights:
    """Add the loads along motions to counterweights that balance.

    Args:
        motions: by default the random ones of `balance.verify`.

    Raises:
        LinkageError: see `balance.verify`.
    """
    space = counterweights.space
    assert counterweights.z is not None
    along = compare_masses(
        space.linkage,
        counterweights.z,
        motions=motions,
        motion=space.motion,
        balance=space.balance,
    )
    return replace(counterweights, along=along)
