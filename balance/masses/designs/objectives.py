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
own sum. With kept bodies or bounds both are rounded down to four digits, since the solver
knows the largest margin to about six.

Objectives leave much free: a least inertia does not depend on the bodies of less inertia. Of
the designs whose value exceeds the least one by at most 1e-5 of it, the answer is the nearest
one to the masses in the file, where the solver finds it: that of the least
``Σ_b tr((P0_b⁻¹ (P_b - P0_b))²)``, with eigenvalues of P0 of at least a fifth of their mean.

The least change depends neither on ε nor on that bound. Newton's method starts at the design
that minimises the distance to second order, ``Σ_b tr((P0_b⁻¹ (P_b - P0_b))²)``, with F = P0.

With limits of density the size of a design is set, as by bounds. Where the minimiser without
these limits fulfils them, it is that with them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

import numpy as np

from balance.masses.designs.bounded_goal import (
    BoundedGoal,
    Goal,
    minimise_bounded,
    nearest_of_value,
    within_densities,
)
from balance.masses.designs.constraints import Program
from balance.masses.designs.nearest import file_distance, minimise_distance
from balance.masses.designs.pseudo_inertia_cone import Cone, given_parameters, matrices_of
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConstraintBlock, triangles
from balance.support.tolerances import PSEUDO_INERTIA_SINGULAR
from kinematics.closure.series import expand
from kinematics.errors import BodyError
from kinematics.numerics.array_types import Array

Objective = Literal["mass", "inertia", "rotor", "change"]

# ε: distance of bodies from the boundary of the cone, in units of the mean mass in the file:
# where it alone sets the size of a design, and where kept bodies or least masses do.
BOUNDARY_DISTANCE = 1e-2
SIZED_DISTANCE = 1e-3
# Part of the least value by which the nearest of the designs of this value may exceed it.
VALUE_EXCESS = 1e-5
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


def minimise_objective(
    space: DesignSpace, program: Program, wanted: Objective, z: Array, margin: float
) -> Iterator[Optimum]:
    """Minimise an objective over the designs of a space.

    Args:
        program: its conic program with constraints.
        z: parameters of a design (bodies, 10) about the inertial origin, SI units.
        margin: margin of that design.

    Yields:
        The nearest of the designs of about the least value, then the minimiser; what of them
        the solver finds.

    Raises:
        BodyError: the objective is ``"change"``, but a free body of the file is singular.
    """
    free = list(program.free)
    file = matrices_of(space, given_parameters(space)) / program.unit
    cone = program.cone.with_all_moments()
    design = matrices_of(space, z) / program.unit
    trace = float(np.trace(design, axis1=1, axis2=2).sum())
    change = wanted == "change"
    if change:
        _check_definite(space, program.free, file[free])
    lower = file[free] if change else np.tile(np.eye(cone.size), (len(free), 1, 1))
    largest = float(np.linalg.eigvalsh(lower).max())
    epsilon, trace_limit = _distance_and_traces(program, margin, trace, largest)
    goal = _goal(space, program, cone, wanted, file)
    bounded = BoundedGoal(program, cone, goal, epsilon * lower, trace_limit)
    best = minimise_bounded(bounded, bounded.coordinates_of(design[free]))
    if best is None:
        return
    if change:
        nearest = _least_change(program, cone, lower, best.v[:-1])
        if nearest is not None:
            yield nearest
        return
    floor = program.unit * epsilon
    distance = _distance_goal(cone, _reference(file[free], bounded.lower))
    for solution in (nearest_of_value(bounded, best, distance, VALUE_EXCESS), best):
        if solution is not None:
            value = float((goal.q @ solution.v + goal.constant) * goal.scale)
            P = program.unit * cone.linear_at(solution.v[:-1])
            yield Optimum(P, value, (floor, floor * space.length**2))


def _distance_and_traces(
    program: Program, margin: float, trace: float, largest: float
) -> tuple[float, float]:
    """Compute ε and the bound on the sum of all traces; see the module.

    Args:
        margin: margin of a design.
        trace: sum of its traces, in units of mass.
        largest: largest eigenvalue of the matrices F of which ε is the factor.
    """
    if program.sized or program.densities:
        distance = SIZED_DISTANCE if program.bounded_below else BOUNDARY_DISTANCE
        epsilon = min(distance, _four_digits(0.5 * margin * trace / largest))
        return epsilon, _four_digits(TRACE_FACTOR * trace)
    return BOUNDARY_DISTANCE, TRACE_FACTOR * BOUNDARY_DISTANCE * largest / margin


def _four_digits(x: float) -> float:
    """Round a positive number down to four digits."""
    unit = 10.0 ** (math.floor(math.log10(x)) - 3)
    return math.floor(x / unit) * unit


def _reference(file: Array, lower: Array) -> Array:
    """Make bodies of the file that measure a distance: none is thinner than a part of its size.

    Args:
        file: pseudo-inertias of the file (free, k, k).
        lower: least pseudo-inertias (free, k, k).
    """
    values, axes = np.linalg.eigh(file)
    least = np.linalg.eigvalsh(lower)[:, :1]
    least = np.maximum(least, LEAST_EXTENT * values.mean(axis=1, keepdims=True))
    return np.asarray((axes * np.maximum(values, least)[:, None]) @ axes.mT)


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
        if within_densities(program, P):
            break
    return Optimum(program.unit * P, file_distance(P, file))


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
) -> Goal:
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
        return Goal(q, 0.0, program.unit * area, none, rows, np.zeros(len(rows)), parts)
    weights = rotor_weights(space) if wanted == "rotor" else np.zeros_like(file)
    if wanted == "mass":
        weights[:, -1, -1] = 1.0
    q[:n] = np.einsum("bij,bnij->n", weights[free], cone.blocks)
    keep = [b for b in range(len(file)) if b not in free]
    constant = float(np.sum(weights[keep] * file[keep]))
    scale = program.unit * (area if wanted == "rotor" else 1.0)
    return Goal(q, constant, scale, none, none, np.empty(0), ())


def _distance_goal(cone: Cone, reference: Array) -> Goal:
    """Build the distance to second order from positive definite matrices (free, k, k)."""
    count, n = cone.blocks.shape[:2]
    whiten = np.linalg.inv(np.linalg.cholesky(reference))[:, None]
    D = np.zeros((count * cone.part.rows, n + 1))
    D[:, :n] = cone.stack_rows(whiten @ cone.blocks @ whiten.swapaxes(-1, -2))
    d = np.tile(triangles(np.eye(cone.size)), count)
    rows = np.empty((0, n + 1))
    return Goal(-2.0 * d @ D, float(d @ d), 1.0, np.sqrt(2.0) * D, rows, np.empty(0), ())


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
