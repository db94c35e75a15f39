"""Decide whether matter of limited density in some regions balances, and find the least."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from balance.masses.counterweights.added_program import (
    IDLE_MASS_PRICE,
    AddedObjective,
    AddedProgram,
    added_objective,
    build_added_program,
    solve_added,
)
from balance.masses.counterweights.counterweight import change_words, filled_counterweight
from balance.masses.counterweights.counterweights_result import Counterweights, Relaxation
from balance.masses.counterweights.decide_points import (
    balance_residual,
    blank_answer,
    decide,
    decide_by_points,
    decide_without_matter,
    is_excluded,
    with_moments,
)
from balance.masses.counterweights.moved_matter import moved_masses
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.counterweights.volume.fill_program import (
    DensityNeeded,
    FilledParts,
    density_gap,
    density_needed,
    fill_from_points,
    fill_least,
    least_mass,
)
from balance.masses.counterweights.volume.filling_check import check_filling
from balance.masses.counterweights.volume.mirror_images import halved_by_plane
from balance.masses.designs.verdicts import TOO_NARROW, UNSETTLED
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    COUNTERWEIGHT_RESIDUAL,
    FILLED_MASS_ZERO,
    FILLING_GAP,
    MASS_GAP,
)
from kinematics.model.arrays import freeze
from kinematics.wording import number_text


def decide_filled(
    space: DesignSpace,
    stocks: Mapping[int, Stock],
    minimise: AddedObjective = "mass",
    price: float = IDLE_MASS_PRICE,
    prove: bool = True,
    relax: bool = True,
    moved: Mapping[int, float] | None = None,
) -> Counterweights:
    """Decide whether matter of limited density balances a linkage, and minimise it.

    Where not even point masses do, theirs is the verdict.

    Args:
        space: the design space, whose conditions are used as they are.
        stocks: regions and densities by position of the body.
        minimise: ``"mass"`` or ``"rotor"``; see `counterweights`.
        price: price of mass besides it, in squares of ``space.length``.
        prove: whether to prove the gap; see `fill_least`.
        relax: whether to look for the density that is enough if this one is not.
        moved: largest share of the given mass that may be moved, by position of the body.
    """
    regions = {b: stock.region for b, stock in stocks.items()}
    density = {space.bodies[b]: stock.density for b, stock in stocks.items()}
    program = build_added_program(space, regions, minimise, price, moved)
    blank = replace(blank_answer(program, minimise, moved or {}), density=density)
    answer = decide_without_matter(blank, program)
    if answer is not None:
        return answer
    halved, matter = halved_by_plane(program, stocks)
    mirrored = dict(zip(stocks, matter, strict=True))
    points = solve_added(program)
    by_newton: FilledParts | DensityNeeded | None = None
    if not (moved or minimise == "inertia" or is_excluded(blank, program, points)):
        by_newton = fill_from_points(halved, matter, program.lift @ points.dual, prove)
    if isinstance(by_newton, FilledParts):
        answer = _filled(blank, mirrored, halved, by_newton)
        if answer.verdict == "feasible":
            return answer
    answer = decide_by_points(blank, program, points)
    if answer.verdict != "feasible" or not answer.weights:
        return answer
    if isinstance(by_newton, DensityNeeded) and by_newton.bound > 1.0 and not relax:
        needed = by_newton
    else:
        needed = density_needed(halved, matter, how_much=relax)
    if needed.bound > 1.0:
        return _excluded(blank, stocks, halved, needed, relax)
    if needed.factor > 1.0:
        return blank.undecided("matter of this density just or just not balances it")
    return _filled(blank, mirrored, halved, fill_least(halved, matter, needed, prove))


def balancing_mass(
    space: DesignSpace, stocks: Mapping[int, Stock], moved: Mapping[int, float] | None = None
) -> float | None:
    """Compute the mass of some matter that balances a linkage, kg; None if none was found.

    Args:
        space: the design space.
        stocks: regions and densities by position of the body.
        moved: largest share of the given mass that may be moved, by position of the body.
    """
    regions = {b: stock.region for b, stock in stocks.items()}
    if decide(space, regions, moved=moved).verdict != "feasible":
        return None
    program = build_added_program(space, regions, "mass", moved=moved)
    program, matter = halved_by_plane(program, stocks)
    needed = density_needed(program, matter)
    if needed.factor > 1.0:
        return None
    mass = program.unit * least_mass(program, matter, needed)
    # Of regions far beyond the linkage the program may end at a sum that is no mass.
    return mass if mass >= -MASS_GAP * program.unit else None


def _excluded(
    blank: Counterweights,
    stocks: Mapping[int, Stock],
    program: AddedProgram,
    needed: DensityNeeded,
    relax: bool,
) -> Counterweights:
    """Return the verdict by a certificate, if its check accepts it."""
    w = program.lift @ needed.dual
    w = freeze(w / (float(np.linalg.norm(w)) or 1.0))
    check = check_filling(blank.space, stocks, w, program.moved)
    if not check.accepted:
        return blank
    if not blank.space.encloses:
        return replace(blank, words=f"undecided: {TOO_NARROW}")
    holds = ", ".join(f"{number_text(stock.whole)} kg" for stock in stocks.values())
    names = " and ".join(f"'{blank.space.bodies[b]}'" for b in stocks)
    words = f"infeasible: the regions of {names} are too small; they hold {holds}"
    return replace(
        blank,
        verdict="infeasible",
        certificate=w,
        check=check,
        words=words,
        relaxations=_describe_denser(blank.space, stocks, needed, program) if relax else (),
    )


def _describe_denser(
    space: DesignSpace,
    stocks: Mapping[int, Stock],
    needed: DensityNeeded,
    asked: AddedProgram,
) -> tuple[Relaxation, ...]:
    """Describe the density that is enough, if it was found, and the least mass it needs."""
    if not np.isfinite(needed.factor):
        return ()
    program = build_added_program(space, asked.regions, "mass", moved=asked.moved)
    program, matter = halved_by_plane(program, stocks)
    factor = needed.factor * (1.0 + density_gap(program))
    mass = least_mass(program, matter, needed, factor)
    return (Relaxation((), factor, program.unit * mass),)


def _filled(
    blank: Counterweights,
    stocks: Mapping[int, Stock],
    program: AddedProgram,
    parts: FilledParts,
) -> Counterweights:
    """Return the verdict with parts of the regions that are filled, if they balance."""
    space = program.space
    z = with_moments(program, parts.moments, parts.shares)
    residual = balance_residual(space, z)
    if not residual <= COUNTERWEIGHT_RESIDUAL:
        return blank
    if not space.sure:
        return replace(blank, words=f"undecided: {UNSETTLED}")
    value, priced = added_objective(program, list(parts.moments), parts.shares)
    masses = parts.moments[:, 3, 3]
    weights = tuple(
        filled_counterweight(space.bodies[b], stock, form, program.unit * P)
        for (b, stock), form, P in zip(stocks.items(), parts.forms, parts.moments, strict=True)
        if P[3, 3] > FILLED_MASS_ZERO * masses.sum()
    )
    gap = max(0.0, priced - parts.bound) / priced if priced > 0.0 else 0.0
    moved = moved_masses(space, program.regions, program.taken, parts.shares, program.unit)
    text = f"feasible: {change_words(weights, moved, blank.given_mass)} balance it"
    if gap > FILLING_GAP:
        text = f"{text}; less may do: see the gap"
    return replace(
        blank,
        moved=moved,
        verdict="feasible",
        value=value,
        gap=gap,
        z=freeze(z),
        residual=residual,
        weights=weights,
        proof=freeze(program.lift @ parts.dual),
        words=text,
    )
