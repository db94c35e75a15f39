"""The least of a goal over the bodies of a design space, accurate relative to its value.

A goal is ``q·v + ½ |D v|²`` over the coordinates v of a cone, with ``P_b ⪰ lower_b``, a bound
on the sum of all traces, the lines of the program, and limits of density.

The tolerances of the solver are absolute, but one body may be a thousand times as heavy as
another, and a thousand times as long as wide. Each solution is therefore measured by a design
P0 at coordinates v0, first by a given one and then by the last solution: with
``T_b P0_b T_bᵀ = 1`` the unknowns y of

    v = v0 + R⁻¹ y

have ``Σ_b |T_b (P_b - P0_b) T_bᵀ|² + |D (v - v0)|² = |y|²``. Each line has a row of norm 1, and
the goal, of which D is a part here, is divided by its value.
"""

from __future__ import annotations

from math import inf
from typing import NamedTuple

import numpy as np

from balance.masses.designs.constraints import Program
from balance.masses.designs.density import density_over_limit
from balance.masses.designs.density_cone import widen
from balance.masses.designs.nearest import limit_rows
from balance.masses.designs.pseudo_inertia_cone import Cone
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic
from balance.support.tolerances import (
    DENSITY_RELATIVE,
    NEAREST_DENSITY_TIGHTENED,
    NEAREST_RESIDUAL,
    SOLVER_RESIDUAL,
)
from kinematics.numerics.array_types import Array

# Most solutions, each measured by the one before.
MAX_SOLUTIONS = 6
# An error above this part of the one before has reached the round-off of the solver.
ERROR_FALLS = 0.5


class Goal(NamedTuple):
    """A goal ``q·v + ½ |D v|² + constant`` and its own constraints.

    The coordinates v are those of a cone, followed by the upper bound that a min-max objective
    minimises.

    Attributes:
        q: linear part (n + 1,).
        constant: constant part, without a unit.
        scale: SI units per unit of the goal.
        D: quadratic part (any, n + 1), without rows if there is none.
        rows: rows of its constraints (rows, n + 1).
        offset: constant part of these rows (rows,).
        parts: cones of these rows.
    """

    q: Array
    constant: float
    scale: float
    D: Array
    rows: Array
    offset: Array
    parts: tuple[ConstraintBlock, ...]

    def variable_part(self, v: Array) -> float:
        """Compute the goal at coordinates v (n + 1,), without its constant part."""
        return float(self.q @ v + 0.5 * np.sum((self.D @ v) ** 2))


class BoundedGoal(NamedTuple):
    """A goal, with ``P_b ⪰ lower_b`` and traces up to ``trace_limit``.

    Attributes:
        program: the conic program of the design space with its constraints.
        cone: cone of the coordinates, with all second moments.
        goal: the goal.
        lower: least pseudo-inertias (free, k, k).
        trace_limit: bound on the sum of all traces.
    """

    program: Program
    cone: Cone
    goal: Goal
    lower: Array
    trace_limit: float

    @property
    def unknown(self) -> Array:
        """Which coordinates (n + 1,) are unknown: not the unit of mass, nor an unused bound."""
        unknown = np.ones(self.cone.blocks.shape[1] + 1, dtype=bool)
        if self.program.sized:
            unknown[self.program.traces.size - 1] = False
        unknown[-1] = self.goal.rows[:, -1].any()
        return unknown

    def coordinates_of(self, P: Array) -> Array:
        """Compute the coordinates (n + 1,) of bodies (free, k, k) of the space; the bound is 1.

        The unit of mass is 1 where it is a coordinate that is set.
        """
        blocks, unknown = self.cone.blocks, self.unknown[:-1]
        v = np.where(np.append(unknown, False), 0.0, 1.0)
        rest = triangles_of(self.cone, P - self.cone.linear_at(v[:-1]))
        rows = self.cone.stack_rows(blocks[:, unknown])
        v[:-1][unknown] = np.linalg.lstsq(rows, rest)[0]
        return v


def triangles_of(cone: Cone, P: Array) -> Array:
    """Stack the rows of the solver's cones of matrices (bodies, k, k)."""
    return cone.rows(P).reshape(-1)


class Minimiser(NamedTuple):
    """A minimiser.

    Attributes:
        v: coordinates of the minimiser and the upper bound (n + 1,).
        error: that of the solver.
        limited: whether its program had limits of density.
    """

    v: Array
    error: float
    limited: bool


def minimise_bounded(
    bounded: BoundedGoal, start: Array, limited: bool = False
) -> Minimiser | None:
    """Minimise a goal within its bounds.

    Limits of density enter where the minimiser without them exceeds one.

    Args:
        start: coordinates (n + 1,) of positive definite bodies, which measure the first
            solution.
        limited: whether limits of density enter at once.

    Returns:
        The minimiser; None if the solver finds none.
    """
    program = bounded.program
    if program.densities and not limited:
        unlimited = bounded._replace(program=program._replace(densities={}))
        best = _refine_minimiser(unlimited, start)
        if best is not None and within_densities(program, bounded.cone.linear_at(best.v[:-1])):
            return best
    return _refine_minimiser(bounded, start)


def _refine_minimiser(bounded: BoundedGoal, start: Array) -> Minimiser | None:
    """Minimise a goal within all limits of density.

    Returns:
        The most accurate of the solutions that an earlier one measured, else the first one;
        None if the solver finds none.
    """
    best, reference = None, start
    size = abs(bounded.goal.variable_part(start)) or 1.0
    for k in range(MAX_SOLUTIONS):
        try:
            solution = _solve(bounded, reference, size)
        except np.linalg.LinAlgError:
            break
        if solution is None:
            break
        before = best.error if best is not None and k > 1 else inf
        if k < 2 or solution.error < before:
            best = solution
        if k > 0 and not SOLVER_RESIDUAL < solution.error <= ERROR_FALLS * before:
            break
        reference, size = solution.v, abs(bounded.goal.variable_part(solution.v)) or 1.0
    return best


def nearest_of_value(
    bounded: BoundedGoal, best: Minimiser, distance: Goal, excess: float
) -> Minimiser | None:
    """Find the nearest of the designs whose goal exceeds the least one by a part of it.

    Args:
        bounded: the goal with its bounds.
        best: its minimiser.
        distance: the distance, a goal of the same coordinates.
        excess: that part.

    Returns:
        The nearest one; None if the solver does not find it within the bounds.
    """
    goal, program = bounded.goal, bounded.program
    value = goal.variable_part(best.v)
    distance = distance._replace(
        rows=np.concatenate([goal.rows, -goal.q[None] / value]),
        offset=np.append(goal.offset, 1.0 + excess),
        parts=(*goal.parts, ConstraintBlock("nonnegative", 1)),
    )
    tight = 1.0 + NEAREST_DENSITY_TIGHTENED
    tighter = {b: tight * kappa for b, kappa in program.densities.items()}
    within = bounded._replace(goal=distance, program=program._replace(densities=tighter))
    nearest = minimise_bounded(within, best.v, best.limited)
    if nearest is None or nearest.error > NEAREST_RESIDUAL:
        return None
    P = bounded.cone.linear_at(nearest.v[:-1])
    above = np.linalg.eigvalsh(P - (1.0 - excess) * bounded.lower)
    return nearest if above.min() >= 0.0 and within_densities(program, P) else None


def within_densities(program: Program, P: Array) -> bool:
    """Whether free bodies (free, k, k) need no density above their limits."""
    return all(
        density_over_limit(P[b], kappa) <= 1.0 + DENSITY_RELATIVE
        for b, kappa in program.densities.items()
    )


def _solve(bounded: BoundedGoal, reference: Array, size: float) -> Minimiser | None:
    """Minimise a goal once; see the module.

    Args:
        reference: v0 (n + 1,).
        size: about the value of the goal.

    Raises:
        LinAlgError: a body at v0 is not positive definite.
    """
    program, cone, goal = bounded.program, bounded.cone, bounded.goal
    P0 = cone.linear_at(reference[:-1])
    T = np.linalg.inv(np.linalg.cholesky(P0))[:, None]
    bodies = cone.stack_rows(T @ cone.blocks @ T.mT)
    X = _measured_directions(bounded, bodies, size, reference)
    lines, inside = _lines(bounded, reference, X[:-1])
    rows = np.concatenate([bodies @ X[:-1], lines, goal.rows @ X])
    above = triangles_of(cone, T[:, 0] @ (P0 - bounded.lower) @ T[:, 0].mT)
    offset = np.concatenate([above, inside, goal.rows @ reference + goal.offset])
    parts = [cone.part] * len(P0) + [ConstraintBlock("nonnegative", len(lines)), *goal.parts]
    q, D = (goal.q + goal.D.T @ (goal.D @ reference)) @ X / size, goal.D @ X / np.sqrt(size)
    H = D.T @ D if len(D) else None
    if program.densities:
        limits = limit_rows(cone.blocks, P0, program.densities, P0)
        n, width = X.shape[1], len(X) - 1
        more = np.hstack([limits.rows[:, :width] @ X[:-1], limits.rows[:, width:]])
        rows = np.concatenate([widen(rows, more.shape[1]), more])
        offset, parts = np.append(offset, limits.offset), [*parts, *limits.parts]
        q = widen(q, more.shape[1])
        if H is not None:
            H = np.pad(H, (0, more.shape[1] - n))
    solution = solve_conic(q, rows, offset, parts, H, equilibrate=True)
    if solution.infeasible or not np.isfinite(solution.x).all():
        return None
    v = reference + X @ solution.x[: X.shape[1]]
    return Minimiser(v, solution.error, bool(program.densities))


def _measured_directions(
    bounded: BoundedGoal, bodies: Array, size: float, reference: Array
) -> Array:
    """Compute the directions (n + 1, unknowns) of the unknowns y; see the module.

    Args:
        bodies: rows of the measured bodies, as functions of the coordinates (rows, n).
        size: about the value of the goal.
        reference: v0 (n + 1,), whose upper bound measures this bound.
    """
    unknown = bounded.unknown
    X = (abs(reference[-1]) or 1.0) * np.eye(unknown.size)[:, unknown]
    rows = np.concatenate([bodies, bounded.goal.D[:, :-1] / np.sqrt(size)])
    R = np.linalg.qr(rows[:, unknown[:-1]], mode="r")
    X[:-1, : len(R)][unknown[:-1]] = np.linalg.inv(R)
    return X


def _lines(bounded: BoundedGoal, reference: Array, directions: Array) -> tuple[Array, Array]:
    """Build the rows of the bound on traces and of the lines of the program, of norm 1.

    Args:
        reference: v0 (n + 1,).
        directions: of the unknowns (n, unknowns).

    Returns:
        The rows (lines, unknowns), and their values at v0.
    """
    program, n = bounded.program, len(directions)
    traces = -widen(program.traces, n) / bounded.trace_limit
    rows = np.concatenate([traces[None], widen(program.lines[int(program.sized) :], n)])
    inside = rows @ reference[:-1]
    inside[0] += 1.0
    rows = rows @ directions
    norms = np.linalg.norm(rows, axis=1)
    norms = np.where(norms > 0.0, norms, 1.0)
    return rows / norms[:, None], inside / norms
