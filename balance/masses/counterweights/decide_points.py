"""Decide whether matter in some regions balances a linkage, and find the least."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from balance.masses.counterweights.added_program import (
    IDLE_MASS_PRICE,
    AddedObjective,
    AddedProgram,
    AddedSolution,
    added_objective,
    build_added_program,
    certificate_dual,
    solve_added,
)
from balance.masses.counterweights.counterweight import counterweight_of
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.exclusion import check_exclusion, describe_exclusion
from balance.masses.counterweights.lumps import fewer_lumps, lumps_of, refine_lumps
from balance.masses.counterweights.moved_matter import moved_masses
from balance.masses.counterweights.quadratic_minimum import least_values
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.volume.settled_shares import settled
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.masses.designs.verdicts import TOO_NARROW, UNCHECKED_MATTER, UNSETTLED
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    CONDITION_LEFT,
    COUNTERWEIGHT_RESIDUAL,
    INSIDE_REGION,
    LUMP_FIT,
    LUMP_MASS_ZERO,
    MASS_EXCLUDED,
)
from kinematics.model.arrays import freeze
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import project_out


def decide(
    space: DesignSpace,
    regions: Mapping[int, Region],
    minimise: AddedObjective = "mass",
    price: float = IDLE_MASS_PRICE,
    moved: Mapping[int, float] | None = None,
) -> Counterweights:
    """Decide whether matter in some regions balances a linkage, and minimise it.

    The density of the matter has no limit: it is point masses.

    Args:
        space: the design space, whose conditions are used as they are.
        regions: region by position of the body.
        minimise: the objective; see `counterweights`.
        price: price of mass besides it, in squares of ``space.length``.
        moved: largest share of the given mass that may be moved, by position of the body.
    """
    program = build_added_program(space, regions, minimise, price, moved)
    blank = blank_answer(program, minimise, moved or {})
    answer = decide_without_matter(blank, program)
    return answer or decide_by_points(blank, program, solve_added(program))


def decide_without_matter(
    blank: Counterweights, program: AddedProgram
) -> Counterweights | None:
    """Decide on a program that needs no matter, or that no matter fulfils; None for others.

    Args:
        blank: its request, as from `blank_answer`.
        program: the program.
    """
    if program.space.as_given.balanced:
        return _keep_given_masses(blank, program)
    if _left_over(program):
        return _proved(blank, program, program.unmatched)
    return None


def decide_by_points(
    blank: Counterweights, program: AddedProgram, solution: AddedSolution
) -> Counterweights:
    """Decide on a program by the answer of the solver for matter of any density.

    Args:
        blank: its request, as from `blank_answer`.
        program: the program.
        solution: the answer, as from `solve_added`.
    """
    # Of a mass that certificates exclude, the dual is a certificate.
    if is_excluded(blank, program, solution):
        answer = _proved(blank, program, program.lift @ solution.dual)
        if answer.verdict == "infeasible":
            return answer
        return _proved(blank, program, program.lift @ certificate_dual(program))
    return _balanced(blank, program, solution)


def is_excluded(blank: Counterweights, program: AddedProgram, solution: AddedSolution) -> bool:
    """Whether the solver found no matter, or a mass that certificates exclude."""
    added = program.unit * float(solution.moments[:, 3, 3].sum())
    return solution.infeasible or not added < MASS_EXCLUDED * blank.given_mass


def blank_answer(
    program: AddedProgram, minimise: AddedObjective, moved: Mapping[int, float]
) -> Counterweights:
    """Make the answer to a request for which nothing was found or excluded.

    Args:
        program: the program.
        minimise: its objective.
        moved: largest share of the given mass that may be moved, by position of the body.
    """
    space = program.space
    return Counterweights(
        space,
        "undecided",
        minimise,
        {space.bodies[b]: region for b, region in program.regions.items()},
        float(given_parameters(space)[:, 0].sum()),
        words=f"undecided: {UNCHECKED_MATTER}",
        price=program.idle * space.length**2,
        movable={space.bodies[b]: share for b, share in moved.items()},
    )


def _keep_given_masses(blank: Counterweights, program: AddedProgram) -> Counterweights:
    """Return the verdict on masses that are balanced as they stand in the file."""
    space = program.space
    if not space.sure:
        return replace(blank, words=f"undecided: {UNSETTLED}")
    z = given_parameters(space)
    value, _ = added_objective(program, [np.zeros((4, 4)) for _ in program.regions])
    return replace(
        blank,
        verdict="feasible",
        value=value,
        z=freeze(z),
        gap=0.0,
        residual=balance_residual(space, z),
        words="feasible: the masses in the file are balanced, and nothing is added",
    )


def _left_over(program: AddedProgram) -> bool:
    """Whether the given masses leave something in which no added matter has a part."""
    parts = program.given.reshape(len(program.space.bodies), -1)
    size = float(np.linalg.norm(parts, axis=1).sum())
    return float(np.linalg.norm(program.unmatched)) > CONDITION_LEFT * size


def _proved(blank: Counterweights, program: AddedProgram, w: Array) -> Counterweights:
    """Return the verdict by a certificate, if its check accepts it."""
    w, regions = freeze(w / (float(np.linalg.norm(w)) or 1.0)), program.regions
    check = check_exclusion(blank.space, regions, w, program.moved)
    if not check.accepted:
        return blank
    if not blank.space.encloses:
        return replace(blank, words=f"undecided: {TOO_NARROW}")
    text = describe_exclusion(blank.space, regions, w)
    return replace(blank, verdict="infeasible", certificate=w, check=check, words=text)


def _balanced(
    blank: Counterweights, program: AddedProgram, solution: AddedSolution
) -> Counterweights:
    """Return the verdict with counterweights, if their check accepts them."""
    space, kinds = program.space, list(program.regions.values())
    shares = solution.shares
    least = max(LUMP_FIT, LUMP_MASS_ZERO * float(solution.moments[:, 3, 3].sum()))
    force = space.balance == "force"
    rough = [
        lumps_of(region, P, force, least)
        for region, P in zip(kinds, solution.moments, strict=True)
    ]
    none = np.zeros_like(shares)
    placed = solution.moments[:, 3, 3]
    fixed = settled(program, program.cost, solution.dual, shares, placed, none, last=True)
    rows, target = fixed.program.rows, fixed.program.target
    lumps = refine_lumps(kinds, rows, target, rough)
    if not program.inertia[0].size:
        fewer = fewer_lumps(rows, fixed.prices, lumps)
        lumps = refine_lumps(kinds, rows, target, fewer)
    shares = fixed.shares_of(program, np.array([cluster.moments for cluster in lumps]))
    z = with_moments(program, np.array([cluster.moments for cluster in lumps]), shares)
    residual = balance_residual(space, z)
    inside = all(
        not cluster.masses.size or float(region.excess(cluster.points).max()) <= INSIDE_REGION
        for region, cluster in zip(kinds, lumps, strict=True)
    )
    if not (inside and residual <= COUNTERWEIGHT_RESIDUAL):
        return blank
    if not space.sure:
        return replace(blank, words=f"undecided: {UNSETTLED}")
    value, priced = added_objective(program, [cluster.moments for cluster in lumps], shares)
    prices = least_values(kinds, solution.forms)
    added = sum(float(cluster.masses.sum()) for cluster in lumps)
    gains = program.taken.gains(-solution.forms, prices, program.price_of_moving)
    bound = solution.bound - float(gains.sum()) + added * float(prices.min(initial=0.0))
    weights = tuple(
        counterweight_of(space.bodies[b], region, cluster, program.unit)
        for (b, region), cluster in zip(program.regions.items(), lumps, strict=True)
        if cluster.masses.size
    )
    answer = replace(
        blank,
        verdict="feasible",
        value=value,
        z=freeze(z),
        residual=residual,
        weights=weights,
        moved=moved_masses(space, program.regions, program.taken, shares, program.unit),
        gap=max(0.0, priced - bound) / priced if priced > 0.0 else 0.0,
    )
    return replace(answer, words=f"feasible: {answer.change} balance it")


def with_moments(program: AddedProgram, moments: Array, shares: Array | None = None) -> Array:
    """Add matter to the given masses: parameters (bodies, 10), SI units.

    Args:
        program: the program of its regions.
        moments: what is placed on each link (links, 4, 4), in unit coordinates and units of
            mass.
        shares: share that is taken from the given mass of each link; none by default.
    """
    if shares is not None:
        moments = program.taken.net(moments, shares)
    z = given_parameters(program.space)
    b = list(program.regions)
    places = np.array([region.place for region in program.regions.values()])
    H = program.space.frames[b] @ places
    z[b] += program.unit * from_pseudo_inertia(H @ moments @ H.mT)
    return z


def balance_residual(space: DesignSpace, z: Array) -> float:
    """Compute how far a distribution is from the design space, over the bodies' sizes.

    Args:
        z: parameters (bodies, 10) about the inertial origin, SI units.
    """
    chain_z = to_chain(z, space.chain.frame, space.planar, space.balance == "force")
    size = float(np.linalg.norm(chain_z, axis=1).sum())
    residual = project_out(chain_z.reshape(-1), space.scaled_basis)
    return float(np.linalg.norm(residual)) / (size or 1.0)
