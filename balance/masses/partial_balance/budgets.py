"""The least shaking for a budget of added matter, and many budgets side by side."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.counterweights.counterweight import Counterweight, moved_text, net_mass
from balance.masses.counterweights.moved_matter import moved_masses
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.shaped.weight_shape import shape_text, shapes_in_words
from balance.masses.designs.density import STEEL
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.masses.partial_balance.added_weights import (
    check_budget,
    counterweights_at,
    filled_counterweights_at,
    read_budget,
)
from balance.masses.partial_balance.elastic_frame import ElasticFrame
from balance.masses.partial_balance.least_shaking import CapsConflict, LeastShaking, removed_by
from balance.masses.partial_balance.partial_balance import (
    ParetoFront,
    PartialBalance,
    PartialVerdict,
)
from balance.masses.partial_balance.shaking_objectives import PartialObjective
from balance.masses.partial_balance.shaking_problem import (
    ShakingFigures,
    ShakingOptions,
    ShakingProblem,
    build_problem,
)
from balance.masses.partial_balance.wider_regions import (
    HARDLY_SAVED,
    try_wider_regions,
)
from balance.motion.verification.given_motions import Motions, motions_or_turn
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.materials import Density, density_in_si
from balance.support.options import Balance
from balance.support.tolerances import (
    FILLING_GAP_PROVED,
    LEAST_SHAKING_GAP,
    SHAKING_GAP_PROVED,
)
from balance.support.units import length_in_si
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.arrays import freeze
from kinematics.model.motion import Motion
from kinematics.numerics.linalg.ties import first_largest
from kinematics.wording import number_text, size_text

# Caps that are named as kept are larger than the least ones by the accuracy of the solver.
CAP_SPARE = 1.0 + 1e-4
# Largest budget of a front without one, in masses of the linkage.
UNLIMITED = 100.0


def partial(
    space: DesignSpace | LinkageLike,
    links: Sequence[str],
    budget: float | str,
    *,
    regions: Mapping[str, Region | str] | None = None,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance | None = None,
    motions: Motions | None = None,
    speed: float | str | None = None,
    crank: str | None = None,
    weight_moment: float | None = None,
    max_bearing: Mapping[str, float] | None = None,
    max_torque: Mapping[str, float] | None = None,
    frame: ElasticFrame | None = None,
    about: ArrayLike | None = None,
    density: Density = STEEL,
    thickness: float | str | None = None,
    minimise: PartialObjective = "rms",
    move: Mapping[str, float] | None = None,
    shape: str | None = None,
) -> PartialBalance:
    """Compute the matter within a budget that lets a linkage shake least along motions.

    It minimises the root of the mean over the motions of ``|F|² + |M|²/ℓ²``, with the shaking
    force F, the shaking moment M, and ``ℓ = weight_moment``.
    With an elastic frame it minimises that of ``|x|² + ℓ² |θ|²``, its displacement and
    rotation. Matter is added inside the regions, or moved there. The problem is convex, and
    ``PartialBalance.bound`` proves the optimum. If less matter than the budget is enough, the
    lightest is found.

    Args:
        space: a design space, or an argument of `kinematics.load`; a space for force balance
            does not count moments, and the motion of a space restricts the random motions.
        links: names of the links that may get matter, or a text, ``"crank,rocker"``.
        budget: most mass to add, kg, from 0 up, or a text, ``"500g"``.
        regions: where matter may be added, by link: a region, or a text such as
            ``"ball(0,0,0,0.1)"`` or ``"80mm"``, the radius of a ball about the joint that
            carries the link; by default this ball with half the link's length.
        motion: restriction of the inputs of a linkage; a space has its own.
        balance: ``"dynamic"``, as by default of a linkage; ``"force"``: moments do not count.
        motions: one or several, as for `balance.verify`; by default its random ones.
        speed: speed of a crank, rad/s, or ``"300rpm"``; one turn of it is the motion.
        crank: name of that crank; by default as for `balance.motion.one_turn`.
        weight_moment: ℓ, metres; by default the characteristic length of the linkage.
        max_bearing: largest force in joints, N, by name. In overconstrained linkages forces
            are those of least norm.
        max_torque: largest drive torque of inputs, N m or N, by name, without gravity.
        frame: an elastic frame that carries the linkage.
        about: point in the inertial frame for moments, metres; the middle of the mechanism by
            default.
        density: density that added matter nowhere exceeds, or that on each link by name,
            kg/m³ or a material as ``"lead"``; steel by default. None for point masses, denser
            than any material.
        thickness: that of plates of added matter on a planar linkage, m or ``"20mm"``, in
            equal halves about its plane.
        minimise: ``"rms"``; ``"peak"``: the largest ``√(|F|² + |M|²/ℓ²)`` of all samples;
            ``"torque"``: the largest drive torque of all inputs, without gravity;
            ``"bearing"``: the largest force in all joints; orders, such as ``(1, 2)``: the rms
            of these harmonics over the turn of a crank at a speed.
        move: links whose given matter may be moved, with the largest share of it, by name; see
            `balance.counterweights`. The budget is the mass that the linkage gains, which may
            then be 0.
        shape: each counterweight is a disc, block, cylinder or sector, ``disc=0.02``; see
            `balance.counterweights`. It goes with force balance of planar linkages, and the
            rms, peak or harmonics: moments of inertia of shapes are no convex set.

    Returns:
        The matter, what the linkage does with it, and the proof that nothing does better.

    Raises:
        BodyError: a link is unknown, or its region cannot be found.
        PoseError: nothing moves.
        UsageError: a number is out of range, or a joint is unknown.

    Source:
        S. Boyd, L. Vandenberghe, Convex Optimization, 2004, sections 4.4 and 5.8.

    Example:
        >>> import balance
        >>> design = balance.partial("robot.urdf", ["crank"], 0.2)
        >>> design.verdict, design.shaking.objective < design.given.objective
        ('optimal', True)
    """
    asked = as_space(space, motion, balance, 0)
    options = ShakingOptions(
        regions,
        motions_or_turn(asked.linkage, motions, speed, crank, asked.motion),
        weight_moment,
        max_bearing,
        max_torque,
        frame,
        about,
        density_in_si(density),
        length_in_si(thickness),
        minimise,
        move,
        shape,
    )
    return single(asked, links, read_budget(budget), options).designs[0]


def single(
    space: DesignSpace,
    links: Sequence[str],
    budget: float,
    options: ShakingOptions,
    progress: Callable[[int, int], None] | None = None,
) -> ParetoFront:
    """Compute what `partial` does, as a front of one design.

    Args:
        space: a design space of the linkage.
        links: names of the links that may get matter.
        budget: most mass to add, kg.
        progress: called with the number of motions done and the number of all motions.
    """
    check_budget(budget)
    problem = build_problem(space, links, options, progress)
    design = _describe(problem, [budget], [problem.solve(budget)])[0]
    try_wider = functools.partial(try_wider_regions, links=links, options=options)
    return replace(design, try_wider=try_wider).front


def pareto(
    space: DesignSpace | LinkageLike,
    links: Sequence[str],
    n: int = 12,
    budget: float | str | None = None,
    *,
    regions: Mapping[str, Region | str] | None = None,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance | None = None,
    motions: Motions | None = None,
    speed: float | str | None = None,
    crank: str | None = None,
    weight_moment: float | None = None,
    max_bearing: Mapping[str, float] | None = None,
    max_torque: Mapping[str, float] | None = None,
    frame: ElasticFrame | None = None,
    about: ArrayLike | None = None,
    density: Density = STEEL,
    thickness: float | str | None = None,
    minimise: PartialObjective = "rms",
    move: Mapping[str, float] | None = None,
    shape: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> ParetoFront:
    """Compute designs between nothing added and the least shaking.

    The motions are computed and factorised once; see `partial`. Given a budget, those of the
    designs are equally spaced from 0 to it, or to the mass of the lightest design of the least
    shaking. Without one they stand where the curve of the shaking over the mass bends.

    Args:
        space: see `partial`, as for the other arguments.
        links: names of the links that may get matter.
        n: number of designs, from 2 up.
        budget: most mass to add, kg; by default a hundred times the mass of the linkage.
        regions: where matter may be added, by link; as for `partial`, by default a ball about
            the proximal joint of half the link's length.
        motion: restriction of the inputs; see `partial`, as for the next four.
        balance: ``"dynamic"`` or ``"force"``.
        motions: one or several.
        speed: of a crank, rad/s.
        crank: its name.
        weight_moment: metres.
        max_bearing: largest force in joints, N.
        max_torque: largest drive torque of inputs, N m or N.
        frame: an elastic frame.
        about: point for moments, metres.
        density: kg/m³, or a material; None for point masses.
        thickness: of plates, metres or ``"20mm"``.
        minimise: see `partial`.
        move: shares of given masses that may be moved, by link.
        shape: of each counterweight, such as ``disc=0.02``.
        progress: called with the number of steps done and the number of all steps.

    Returns:
        The designs.

    Raises:
        BodyError: a link is unknown, or its region cannot be found.
        PoseError: nothing moves.
        UsageError: a number is out of range, or a joint is unknown.

    Source:
        S. Boyd, L. Vandenberghe, Convex Optimization, 2004, section 4.7.

    Example:
        >>> import balance
        >>> front = balance.pareto("robot.urdf", ["crank", "rocker"], 3, 0.5)
        >>> [design.budget for design in front.designs]
        [0.0, 0.25, 0.5]
    """
    if n < 2:
        raise UsageError(f"a front of {n} designs has no two ends: ask for 2 or more")
    most_added = None if budget is None else read_budget(budget)
    computed_space = as_space(space, motion, balance, 0)

    def advance(done: int, count: int) -> None:
        if progress is not None:
            progress(done, count + n)

    options = ShakingOptions(
        regions,
        motions_or_turn(computed_space.linkage, motions, speed, crank, computed_space.motion),
        weight_moment,
        max_bearing,
        max_torque,
        frame,
        about,
        density_in_si(density),
        length_in_si(thickness),
        minimise,
        move,
        shape,
    )
    problem = build_problem(computed_space, links, options, advance)
    most, end = _largest_budget(problem, most_added)
    count, solved = len(problem.loads), {most: end}
    for done in range(1, n):
        advance(count + done, count)
        limit = most * (done - 1) / (n - 1)
        if most_added is None and most > 0.0:
            limit = _next_budget(solved)
        solved[limit] = problem.solve(limit)
    advance(count + n, count)
    budgets = sorted(solved)
    designs = _describe(problem, budgets, [solved[limit] for limit in budgets])
    return ParetoFront(designs, problem.weight_moment, frame, problem.point, minimise)


def _largest_budget(
    problem: ShakingProblem, budget: float | None
) -> tuple[float, LeastShaking | CapsConflict]:
    """Find the largest budget that is used, and the answer to it."""
    given = float(sum(body.inertia[0] for body in problem.space.linkage.bodies))
    most = UNLIMITED * given if budget is None else budget
    end = problem.solve(most)
    if isinstance(end, LeastShaking):
        needed = max(0.0, float(problem.matter.masses @ end.s))
        most = needed if needed < most * (1.0 - LEAST_SHAKING_GAP) else most
    return most, end


def _next_budget(solved: Mapping[float, LeastShaking | CapsConflict]) -> float:
    """Choose the budget that tells most about the curve of the least shaking over the mass.

    It is 0 first, and then the middle of the budgets between which the curve, which falls and
    is convex, leaves most open: the rectangle of what they add and what they save.
    """
    if 0.0 not in solved:
        return 0.0
    budgets = sorted(solved)
    pairs = list(pairwise(budgets))
    sizes = [(b - a) * _saved(solved[a], solved[b]) for a, b in pairs]
    a, b = pairs[first_largest(sizes)]
    return 0.5 * (a + b)


def _saved(smaller: LeastShaking | CapsConflict, larger: LeastShaking | CapsConflict) -> float:
    """Return what a larger budget saves; all if only the larger one keeps the caps."""
    before, after = (
        answer.value if isinstance(answer, LeastShaking) else inf
        for answer in (smaller, larger)
    )
    if before == inf:
        return 0.0 if after == inf else after
    return max(0.0, before - after)


def _describe(
    problem: ShakingProblem,
    budgets: Sequence[float],
    answers: Sequence[LeastShaking | CapsConflict],
) -> tuple[PartialBalance, ...]:
    """Describe the answers to budgets, and compute what the designs do along the motions."""
    minimisers = [answer.s for answer in answers if isinstance(answer, LeastShaking)]
    given, *figures = problem.figures([np.zeros(problem.matter.count), *minimisers])
    remaining = iter(figures)
    return tuple(
        _conflict(problem, budget, given, answer)
        if isinstance(answer, CapsConflict)
        else _result(problem, budget, given, next(remaining), answer)
        for budget, answer in zip(budgets, answers, strict=True)
    )


def _result(
    problem: ShakingProblem,
    budget: float,
    given: ShakingFigures,
    figures: ShakingFigures,
    best: LeastShaking,
) -> PartialBalance:
    """Describe a minimiser."""
    # Integrals over rays have errors of both signs.
    gap = abs(best.value - best.bound) / problem.program.scale
    taken = problem.program.taken
    placed = best.s + removed_by(problem.program, best.shares)
    if problem.shapes:
        weights = best.weights
    elif problem.program.stocks:
        weights = filled_counterweights_at(problem.space, problem.program, best.forms, placed)
    else:
        weights = counterweights_at(problem.space, problem.matter, placed)
    moved = moved_masses(problem.space, problem.matter.regions, taken, best.shares, 1.0)
    share = best.value / (given.objective or 1.0)
    mass = net_mass(weights, moved)
    mass_text = size_text(mass, ".4g", float(given_parameters(problem.space)[:, 0].sum()))
    mass_text = f"{mass_text} kg"
    if any(moved.values()):
        mass_text = f"{moved_text(moved)} and {mass_text} added" if mass else moved_text(moved)
    left_over = size_text(share, ".3g", floor=SHAKING_GAP_PROVED)
    what = f"{left_over} of the {problem.objective} in the file"
    if problem.program.balanced and not weights:
        text = "optimal: the masses in the file are balanced, and nothing is added"
        verdict: PartialVerdict = "optimal"
    elif gap <= (FILLING_GAP_PROVED if problem.program.stocks else SHAKING_GAP_PROVED):
        text = f"optimal: {mass_text} leave {what}, and {_others(problem, weights)} better"
        verdict = "optimal"
    else:
        text = f"undecided: {mass_text} leave {what}; {gap:.1e} of it may be saved"
        verdict = "undecided"
    if weights and share > 1.0 - HARDLY_SAVED:
        text += (
            f"; it saves less than {HARDLY_SAVED:.1%}: matter there is hardly worth its mass"
        )
    return replace(
        _without_design(problem, budget, given, verdict, text),
        shaking=figures,
        bound=best.bound,
        least_objective=best.any_shape,
        least_anywhere=problem.program.least_anywhere,
        weights=weights,
        z=freeze(problem.matter.parameters(best.s)),
        moved=moved,
    )


def _others(problem: ShakingProblem, weights: Sequence[Counterweight]) -> str:
    """Say what else was compared, with its verb."""
    if not problem.shapes:
        return "nothing in the regions does"
    beside = " beside these webs" * any(weight.web is not None for weight in weights)
    return f"no {shapes_in_words(problem.shapes)} in the regions{beside} do"


def _conflict(
    problem: ShakingProblem, budget: float, given: ShakingFigures, conflict: CapsConflict
) -> PartialBalance:
    """Describe caps that no matter keeps."""
    caps = ", ".join(conflict.names) or "the joints"
    text = "undecided: the solver found neither matter that keeps the caps nor a proof"
    if conflict.proved:
        text = f"infeasible: no matter within {budget:g} kg in the regions keeps {caps} capped"
        if (factor := problem.least_caps(budget)) < inf:
            text += f"; caps {number_text(CAP_SPARE * factor)} times as large can be kept"
    verdict: PartialVerdict = "infeasible" if conflict.proved else "undecided"
    return _without_design(problem, budget, given, verdict, text)


def _without_design(
    problem: ShakingProblem,
    budget: float,
    given: ShakingFigures,
    verdict: PartialVerdict,
    words: str,
) -> PartialBalance:
    """Describe the request, and what the linkage of the file does."""
    bodies, regions = problem.space.bodies, problem.matter.regions
    return PartialBalance(
        problem.space,
        budget,
        verdict,
        words,
        given,
        problem.motions,
        problem.point,
        problem.weight_moment,
        problem.frame,
        problem.minimise,
        {bodies[b]: region for b, region in regions.items()},
        shape=shape_text(problem.shapes) if problem.shapes else None,
    )
