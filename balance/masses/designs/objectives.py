"""Objectives of a design, minimised as convex problems over the cone of its design space.

Objectives that decrease with mass have no minimiser on the open cone, so we require
``P_b ⪰ ε F_b``. An objective need not depend on all parameters, so the sum of all traces is
bounded:

==========  =====================================================================  =========
mass        total mass                                                              F = 1
inertia     the largest principal moment of any body about the origin of its link   F = 1
rotor       trace of the inertia matrix seen by the coordinates of the motion       F = 1
change      the log-det distance from the masses in the file; see `nearest`            none
==========  =====================================================================  =========

in units of the chain and of the mean mass in the file. ε is 1e-3 where kept bodies or least
masses set the size of a design, and 0.01 where nothing else sets it, but at most half of the
largest value that kept bodies and bounds allow. The traces add up to at most ten times the sum
that the design of the largest margin has at this ε; with kept bodies or bounds, ten times its
own sum.

A least inertia of a planar linkage leaves parameters free of all bodies but those of the
largest moment. Of the designs whose value exceeds the least one by at most 5e-7 of it, the
answer is the nearest one to the masses in the file, where the solver finds it: that of the
least ``Σ_b tr((P0_b⁻¹ (P_b - P0_b))²)``, with eigenvalues of P0 of at least a fifth of their
mean.

The least change depends neither on ε nor on that bound. Newton's method starts at the design
that minimises the distance to second order, ``Σ_b tr((P0_b⁻¹ (P_b - P0_b))²)``, with F = P0.

With limits of density the size of a design is set, as by bounds. The cones of
`balance.masses.designs.density_cone` measure each body by a design; a second solution measures
it by the first one, since the best bodies may be a thousand times lighter. It counts if the
solver is as accurate then.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np

from balance.masses.designs.constraints import Program
from balance.masses.designs.density import density_over_limit
from balance.masses.designs.density_cone import DensityRows, widen
from balance.masses.designs.nearest import file_distance, limit_rows, minimise_distance
from balance.masses.designs.pseudo_inertia_cone import Cone, given_parameters, matrices_of
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic, triangles
from balance.support.tolerances import (
    DENSITY_RELATIVE,
    PSEUDO_INERTIA_SINGULAR,
    SOLVER_RESIDUAL,
    SOLVER_RESIDUAL_FAST,
)
from kinematics.closure.series import expand
from kinematics.errors import BodyError
from kinematics.numerics.array_types import Array

Objective = Literal["mass", "inertia", "rotor", "change"]

# ε: distance of bodies from the boundary of the cone, in units of the mean mass in the file:
# where it alone sets the size of a design, and where kept bodies or least masses do.
BOUNDARY_DISTANCE = 1e-2
SIZED_DISTANCE = 1e-3
# Part of the least value by which the nearest of the designs of this value may exceed it.
VALUE_EXCESS = 5e-7
# Least eigenvalue of a pseudo-inertia that measures this distance, over the mean one.
LEAST_EXTENT = 0.2
# Bound on the sum of all traces, over the least sum that this distance allows.
TRACE_FACTOR = 10.0


class Optimum(NamedTuple):
    """The minimiser of an objective.

    Attributes:
        P: pseudo-inertias of the free bodies (free, k, k), in the coordinates of the chain
            and in kilograms.
        value: value of the objective, SI units; the change has no unit.
        floor: the least mass of a free body, kg, and its least second moment about its centre
            of mass in any direction, kg m²; None for the change.
    """

    P: Array
    value: float
    floor: tuple[float, float] | None = None


class _Goal(NamedTuple):
    """An objective ``q·v + ½ vᵀ H v + constant`` and its own constraints.

    The coordinates v are those of a cone, followed by the upper bound that a min-max objective
    minimises.

    Attributes:
        q: linear part (n + 1,).
        constant: constant part, without a unit.
        scale: SI units per unit of the objective.
        H: quadratic part (n + 1, n + 1), None without one.
        rows: rows of its constraints (rows, n + 1).
        offset: constant part of these rows (rows,).
        parts: cones of these rows.
    """

    q: Array
    constant: float
    scale: float
    H: Array | None
    rows: Array
    offset: Array
    parts: tuple[ConstraintBlock, ...]


class _BoundedGoal(NamedTuple):
    """An objective, with ``P_b ⪰ lower_b`` and traces up to ``trace_limit``.

    Attributes:
        program: the conic program of the design space with its constraints.
        cone: cone of the coordinates.
        goal: the objective.
        lower: least pseudo-inertias (free, k, k).
        trace_limit: bound on the sum of all traces.
        limits: rows of the limits of density.
    """

    program: Program
    cone: Cone
    goal: _Goal
    lower: Array
    trace_limit: float
    limits: DensityRows | None = None


def minimise_objective(
    space: DesignSpace,
    program: Program,
    wanted: Objective,
    z: Array,
    margin: float,
    nearest: bool = False,
) -> Optimum | None:
    """Minimise an objective over the designs of a space.

    Args:
        program: its conic program with constraints.
        z: parameters of a design (bodies, 10) about the inertial origin, SI units.
        margin: margin of that design.
        nearest: whether the nearest one of about the least value is the answer.

    Returns:
        The minimiser; None if the solver does not find it.

    Raises:
        BodyError: the objective is ``"change"``, but a free body of the file is singular.
    """
    file, cone = matrices_of(space, given_parameters(space)) / program.unit, program.cone
    # Spatial force balance does not constrain second moments, but objectives depend on them, as
    # the distance from the file does.
    further = cone.second_order and cone.size == 4
    if wanted == "change" or nearest or program.densities or further:
        cone = cone.with_all_moments()
    lower = np.tile(np.eye(cone.size), (len(cone.blocks), 1, 1))
    if wanted == "change":
        lower = file[list(program.free)]
        _check_definite(space, program.free, lower)
    goal = _goal(space, program, cone, wanted, file)
    trace = float(np.trace(matrices_of(space, z), axis1=1, axis2=2).sum()) / program.unit
    largest = float(np.linalg.eigvalsh(lower).max())
    epsilon = BOUNDARY_DISTANCE
    trace_limit = TRACE_FACTOR * BOUNDARY_DISTANCE * largest / margin
    if program.sized or program.densities:
        distance = SIZED_DISTANCE if program.bounded_below else BOUNDARY_DISTANCE
        epsilon = min(distance, 0.5 * margin * trace / largest)
        trace_limit = TRACE_FACTOR * trace
    bounded = _BoundedGoal(program, cone, goal, epsilon * lower, trace_limit)
    P = matrices_of(space, z)[list(program.free)] / program.unit
    solution = _minimise_nearest(bounded, P, file) if nearest else _minimise(bounded, P)
    if solution is None:
        return None
    v = solution.v
    if wanted == "change":
        return _least_change(program, cone, lower, v[:-1])
    value = float((goal.q @ v + goal.constant) * goal.scale)
    floor = program.unit * epsilon
    return Optimum(program.unit * cone.at(v[:-1]), value, (floor, floor * space.length**2))


def _minimise(bounded: _BoundedGoal, P: Array) -> _Minimiser | None:
    """Minimise an objective; see `minimise_objective`.

    Args:
        P: pseudo-inertias (free, k, k) of a design, in units of mass.
    """
    solution = _solve(bounded)
    if solution is None or _within_densities(bounded.program, bounded.cone.at(solution.v[:-1])):
        return solution
    return _solve_with_densities(bounded, P)


def _minimise_nearest(bounded: _BoundedGoal, P: Array, file: Array) -> _Minimiser | None:
    """Find the nearest of the designs of about the least value; see the module.

    The least value without limits of density is more accurate than that with them. Where these
    designs reach it, it is the least one.

    Args:
        P: pseudo-inertias (free, k, k) of a design, in units of mass.
        file: pseudo-inertias of all bodies in the file (bodies, k, k).
    """
    best = _solve(bounded)
    nearest = best and _nearest(bounded, best, P, file)
    if best is None or nearest is not None or not bounded.program.densities:
        return nearest
    best = _solve_with_densities(bounded, P)
    return best and _nearest(bounded, best, bounded.cone.at(best.v[:-1]), file)


def _nearest(
    bounded: _BoundedGoal, best: _Minimiser, P: Array, file: Array
) -> _Minimiser | None:
    """Find the nearest of the designs of about a given value; see `_minimise_nearest`.

    Args:
        best: a minimiser of this value.
        P: pseudo-inertias that measure the limits of density.
    """
    cone, goal, densities = bounded.cone, bounded.goal, bounded.program.densities
    values, axes = np.linalg.eigh(file[list(bounded.program.free)])
    least = np.linalg.eigvalsh(bounded.lower)[:, :1]
    least = np.maximum(least, LEAST_EXTENT * values.mean(axis=1, keepdims=True))
    reference = (axes * np.maximum(values, least)[:, None]) @ axes.mT
    level = float(goal.q @ best.v) * (1.0 + VALUE_EXCESS)
    distance = _distance_goal(cone, reference)._replace(
        rows=np.concatenate([goal.rows, -goal.q[None]]),
        offset=np.append(goal.offset, level),
        parts=(*goal.parts, ConstraintBlock("nonnegative", 1)),
    )
    limits = limit_rows(cone.blocks, P, densities) if densities else None
    nearest = _solve(bounded._replace(goal=distance, limits=limits))
    if nearest is None or nearest.error > SOLVER_RESIDUAL_FAST:
        return None
    P = cone.at(nearest.v[:-1])
    above = np.linalg.eigvalsh(P - (1.0 - VALUE_EXCESS) * bounded.lower)
    return nearest if above.min() >= 0.0 and _within_densities(bounded.program, P) else None


def _solve_with_densities(bounded: _BoundedGoal, P: Array) -> _Minimiser | None:
    """Minimise an objective with limits of density, measured by a design and then anew.

    Args:
        P: pseudo-inertias (free, k, k) of the design, in units of mass.
    """
    best: _Minimiser | None = None
    for _ in range(2):
        limits = limit_rows(bounded.cone.blocks, P, bounded.program.densities)
        solution = _solve(bounded._replace(limits=limits))
        if solution is None:
            return None
        if best is not None and solution.error > max(best.error, SOLVER_RESIDUAL):
            break
        best, P = solution, bounded.cone.at(solution.v[:-1])
        if not np.all(np.trace(P, axis1=1, axis2=2) > 0.0):
            # Next to no mass is the least: the solver has lost it in its round-off.
            return None
    return best


def _within_densities(program: Program, P: Array) -> bool:
    """Whether free bodies (free, k, k) need no density above their limits."""
    return all(
        density_over_limit(P[b], kappa) <= 1.0 + DENSITY_RELATIVE
        for b, kappa in program.densities.items()
    )


def _least_change(program: Program, cone: Cone, file: Array, start: Array) -> Optimum | None:
    """Minimise the log-det distance from the file, from a design at coordinates ``start``."""
    lines = np.zeros((len(program.lines), start.size))
    lines[:, : program.traces.size] = program.lines
    moves, constant = np.ones(start.size, dtype=bool), np.zeros_like(start)
    if program.sized:
        unit = program.traces.size - 1
        moves[unit], constant[unit] = False, start[unit]
    problem = (
        cone.blocks[:, moves],
        cone.linear_at(constant),
        file,
        lines[:, moves],
        lines @ constant,
        start[moves],
    )
    for densities in ({}, program.densities):
        v = minimise_distance(*problem, densities)
        if v is None:
            return None
        constant[moves] = v
        P = cone.linear_at(constant)
        if _within_densities(program, P):
            break
    return Optimum(program.unit * P, file_distance(P, file))


class _Minimiser(NamedTuple):
    """Coordinates of a minimiser and the upper bound (n + 1,), and the error of the solver."""

    v: Array
    error: float


def _solve(bounded: _BoundedGoal) -> _Minimiser | None:
    """Minimise an objective within its bounds.

    Where the solver stops short of its accuracy, as with bodies of which some are a thousand
    times as heavy as others, a second solution measures each body by the first one. The more
    accurate one counts.
    """
    first = _solve_once(bounded)
    if first is None:
        return None
    if first.error > SOLVER_RESIDUAL:
        scales = _scales_of(bounded.cone.at(first.v[:-1]))
        second = _solve_once(bounded, scales) if np.isfinite(scales).all() else None
        if second is not None and second.error < first.error:
            return second
    return first


def _solve_once(bounded: _BoundedGoal, scales: Array | None = None) -> _Minimiser | None:
    """Minimise an objective once; see `_solve`.

    Args:
        scales: congruences A_b (free, k, k), to require ``A_b P_b A_bᵀ ⪰ A_b lower_b A_bᵀ``.
    """
    program, cone, goal, lower, trace_limit, limits = bounded
    (count, n), size = cone.blocks.shape[:2], program.traces.size
    A = np.tile(np.eye(cone.size), (count, 1, 1)) if scales is None else scales
    blocks = A[:, None] @ cone.blocks @ A[:, None].swapaxes(-1, -2)
    others = program.lines[int(program.sized) :]
    lines = np.zeros((1 + len(others), n))
    lines[0, :size], lines[1:, :size] = -program.traces, others
    linear = np.concatenate([cone.stack_rows(blocks), lines])
    rows = np.concatenate([np.column_stack([linear, np.zeros(len(linear))]), goal.rows])
    offset = np.zeros(len(rows))
    offset[len(linear) :] = goal.offset
    offset[: len(linear) - len(lines)] = -cone.rows(A @ lower @ A.swapaxes(-1, -2)).reshape(-1)
    offset[len(linear) - len(lines)] = trace_limit
    parts = [cone.part] * count + [ConstraintBlock("nonnegative", len(lines)), *goal.parts]
    q, H = goal.q, goal.H
    if limits is not None:
        more = limits.beside(1)
        rows = np.concatenate([widen(rows, more.shape[1]), more])
        offset, parts = np.append(offset, limits.offset), [*parts, *limits.parts]
        q = widen(q, more.shape[1])
        H = H if H is None else widen(widen(H, more.shape[1]).T, more.shape[1]).T
    # Fix the unit of mass at 1, and an unused upper bound at 0.
    values, free = np.zeros(q.size), np.ones(q.size, dtype=bool)
    if program.sized:
        values[size - 1], free[size - 1] = 1.0, False
    free[n] = bool(goal.rows[:, n].any())
    q = q[free]
    if H is not None:
        H, q = H[np.ix_(free, free)], q + (H @ values)[free]
    solution = solve_conic(q, rows[:, free], offset + rows @ values, parts, H)
    if solution.infeasible or not np.isfinite(solution.x).all():
        return None
    values[free] = solution.x
    return _Minimiser(values[: n + 1], solution.error)


def _scales_of(P: Array) -> Array:
    """Compute the congruences that give bodies the mass 1, centre 0 and mean moment 1.

    The scale of lengths is the same in all directions, so that ``trace(S) m ≥ |mc|²`` of planar
    force balance stays a condition of the trace. NaN for a body without mass or extent.
    """
    d = P.shape[-1] - 1
    m, centre = P[:, d, d], P[:, :d, d] / P[:, d, d, None]
    second = np.trace(P, axis1=1, axis2=2) - m - m * (centre**2).sum(axis=1)
    sizes = np.where(np.minimum(m, second) > 0.0, second, np.nan)
    A = np.zeros_like(P)
    A[:, :d, :d] = np.eye(d) * np.sqrt(d / sizes)[:, None, None]
    A[:, :d, d] = -centre * np.sqrt(d / sizes)[:, None]
    A[:, d, d] = 1.0 / np.sqrt(np.where(m > 0.0, m, np.nan))
    return A


def _check_definite(space: DesignSpace, free: tuple[int, ...], P: Array) -> None:
    """Raise BodyError for free bodies of the file with a singular pseudo-inertia."""
    for b, matrix in zip(free, P, strict=True):
        if np.linalg.eigvalsh(matrix)[0] <= PSEUDO_INERTIA_SINGULAR * np.trace(matrix):
            raise BodyError(
                space.source,
                space.bodies[b],
                "has a singular mass distribution in the file, from which no change can be "
                "measured; give it mass and extent in every direction, or keep it",
            )


def _goal(
    space: DesignSpace, program: Program, cone: Cone, wanted: Objective, file: Array
) -> _Goal:
    """Build an objective in the coordinates of a cone."""
    n, free = cone.blocks.shape[1], list(program.free)
    q, none = np.zeros(n + 1), np.empty((0, n + 1))
    area = space.length**2
    if wanted == "change":
        return _distance_goal(cone, file[free])
    if wanted == "inertia":
        q[n] = 1.0
        rows, part = _moments(space, cone, free)
        parts = (part,) * (len(free) if part.kind == "psd_triangle" else 1)
        return _Goal(q, 0.0, program.unit * area, None, rows, np.zeros(len(rows)), parts)
    weights = rotor_weights(space) if wanted == "rotor" else np.zeros_like(file)
    if wanted == "mass":
        weights[:, -1, -1] = 1.0
    q[:n] = np.einsum("bij,bnij->n", weights[free], cone.blocks)
    keep = [b for b in range(len(file)) if b not in free]
    constant = float(np.sum(weights[keep] * file[keep]))
    scale = program.unit * (area if wanted == "rotor" else 1.0)
    return _Goal(q, constant, scale, None, none, np.empty(0), ())


def _distance_goal(cone: Cone, reference: Array) -> _Goal:
    """Build the distance to second order from positive definite matrices (free, k, k)."""
    count, n = cone.blocks.shape[:2]
    whiten = np.linalg.inv(np.linalg.cholesky(reference))[:, None]
    D = np.zeros((count * cone.part.rows, n + 1))
    D[:, :n] = cone.stack_rows(whiten @ cone.blocks @ whiten.swapaxes(-1, -2))
    d = np.tile(triangles(np.eye(cone.size)), count)
    rows = np.empty((0, n + 1))
    return _Goal(-2.0 * d @ D, float(d @ d), 1.0, 2.0 * D.T @ D, rows, np.empty(0), ())


def _moments(space: DesignSpace, cone: Cone, free: list[int]) -> tuple[Array, ConstraintBlock]:
    """Build rows of the upper bound minus each body's inertia about its link origin.

    In a plane the inertia is the moment about the normal, the largest one of a flat body.
    """
    frame, d, n = space.chain.frame, cone.size - 1, cone.blocks.shape[1]
    origins = (space.frames[free, :3, 3] - frame.origin) @ frame.R.T[:, :d] / frame.length
    shift = np.tile(np.eye(d + 1), (len(free), 1, 1))
    shift[:, :d, d] = -origins
    S = (shift[:, None] @ cone.blocks @ shift[:, None].swapaxes(-1, -2))[..., :d, :d]
    trace = np.trace(S, axis1=-2, axis2=-1)
    if d == 2:
        return np.column_stack([-trace, np.ones(len(free))]), ConstraintBlock(
            "nonnegative", len(free)
        )
    inertia = triangles(trace[..., None, None] * np.eye(d) - S)
    unit = np.tile(triangles(np.eye(d)), len(free))
    rows = np.column_stack([-inertia.transpose(0, 2, 1).reshape(-1, n), unit])
    return rows, ConstraintBlock("psd_triangle", d)


def rotor_weights(space: DesignSpace) -> Array:
    """Compute K with ``Σ_b <K_b, P_b>`` the trace of the inertia matrix of the motion.

    A point x of a body has the velocity ``T [x; 1]`` for a unit rate of a coordinate, where T
    holds the first rows of the twist as a matrix. Hence ``K = Σ_w T_wᵀ T_w``.
    """
    chain = space.chain
    twists = expand(chain, np.zeros((1, chain.width)), 0).T[0, 0]
    d = 2 if chain.planar else 3
    K = np.zeros((chain.links.size, d + 1, d + 1))
    for b, link in enumerate(chain.links):
        for twist in twists[link] if link >= 0 else ():
            T = np.column_stack([_cross_matrix(twist[:-d]), twist[-d:]])
            K[b] += T.T @ T
    return K


def _cross_matrix(rotation: Array) -> Array:
    """Compute the matrix of ``ω ×`` in space (3,) or in the plane (1,)."""
    if rotation.size == 1:
        return rotation[0] * np.array([[0.0, -1.0], [1.0, 0.0]])
    return np.cross(rotation, np.eye(3)).T
