"""What a design may be best in, as a convex problem over the cone of its design space.

Objectives that shrink with the masses have no least value over an open cone, so bodies must
stay clear of its edge, ``P_b ⪰ ε F_b``; and what an objective does not see must not grow
without limit, so the sum of all traces is bounded:

==========  =====================================================================  =========
mass        total mass                                                              F = 1
inertia     the largest principal moment of any body about the origin of its link   F = 1
rotor       trace of the inertia matrix seen by the coordinates of the motion       F = 1
change      ``Σ_b tr((P0_b⁻¹ (P_b - P0_b))²)``, P0 being that of the file           F = P0
==========  =====================================================================  =========

in units of the chain and of the mean mass in the file. ε is 0.01, or half of what kept bodies
and bounds leave possible. The traces add up to at most ten times what the design of the
largest margin needs for that; with kept bodies or bounds, ten times what it has.

The distance is, to second order, that of the metric on pseudo-inertias which is the same in
any frame and unit (T. Lee, P. M. Wensing, F. C. Park, IEEE Transactions on Robotics 36(1),
2020).
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.designs.clarabel_adapter import ConstraintBlock, solve_conic, triangles
from balance.designs.constraints import Program
from balance.designs.pseudo_inertia_cone import Cone, given_parameters, matrices_of
from balance.spaces.design_space_result import DesignSpace
from kinematics.closure.series import expand
from kinematics.errors import BodyError

__all__ = ["Objective", "Optimum", "minimise_objective"]

Array = NDArray[np.float64]
Objective = Literal["mass", "inertia", "rotor", "change"]

# How far bodies stay from the edge of the cone, in units of the mean mass in the file; and
# the sum of all traces, over the least one that allows for that.
FLOOR, ROOM = 1e-2, 10.0
# A body is singular if an eigenvalue of its matrix is below this part of their sum.
SINGULAR = 1e-12


class Optimum(NamedTuple):
    """The best point of a program.

    Attributes:
        P: pseudo-inertias of the free bodies (free, k, k), in the coordinates of the chain
            and in kilograms.
        value: of the objective, in SI units; without a unit for the change.
    """

    P: Array
    value: float


class _Goal(NamedTuple):
    """An objective ``q·v + ½ vᵀ H v + constant``, and the constraints that it brings.

    The coordinates v are those of a cone, and then the bound on what is to be small at its
    largest.

    Attributes:
        q: linear part (n + 1,).
        constant: without unit, as the rest.
        scale: SI units per unit of the objective.
        H: quadratic part (n + 1, n + 1), None without one.
        rows: constraints (rows, n + 1).
        parts: their cones.
    """

    q: Array
    constant: float
    scale: float
    H: Array | None
    rows: Array
    parts: tuple[ConstraintBlock, ...]


def minimise_objective(
    space: DesignSpace, question: Program, wanted: Objective, z: Array, margin: float
) -> Optimum | None:
    """The best design, None if the solver does not find it.

    Args:
        space: the design space.
        question: what else is asked.
        wanted: what to minimise.
        z: parameters of a design (bodies, 10) about the inertial origin, SI units.
        margin: its margin.

    Raises:
        BodyError: the change is to be small, but a free body of the file is singular.
    """
    file, cone = matrices_of(space, given_parameters(space)) / question.unit, question.cone
    # For force balance in space, second moments are not conditioned, but wanted.
    if wanted == "change" or (cone.lorentz and cone.size == 4):
        cone = cone.lifted()
    floor = np.tile(np.eye(cone.size), (len(cone.blocks), 1, 1))
    if wanted == "change":
        floor = file[list(question.free)]
        _check_definite(space, question.free, floor)
    goal = _goal(space, question, cone, wanted, file)
    trace = float(np.trace(matrices_of(space, z), axis1=1, axis2=2).sum()) / question.unit
    largest = float(np.linalg.eigvalsh(floor).max())
    epsilon, room = FLOOR, ROOM * FLOOR * largest / margin
    if question.sized:
        epsilon, room = min(FLOOR, 0.5 * margin * trace / largest), ROOM * trace
    v = _solve(question, cone, goal, epsilon * floor, room)
    if v is None:
        return None
    half = 0.0 if goal.H is None else 0.5 * v @ goal.H @ v
    value = float((goal.q @ v + half + goal.constant) * goal.scale)
    return Optimum(question.unit * cone.at(v[:-1]), value)


def _solve(
    question: Program, cone: Cone, goal: _Goal, floor: Array, room: float
) -> Array | None:
    """Coordinates of the least value with ``P_b ⪰ floor_b`` and traces up to ``room``."""
    (count, n), own = cone.blocks.shape[:2], question.traces.size
    others = question.lines[int(question.sized) :]
    lines = np.zeros((1 + len(others), n))
    lines[0, :own], lines[1:, :own] = -question.traces, others
    linear = np.concatenate([cone.stacked(cone.blocks), lines])
    rows = np.concatenate([np.column_stack([linear, np.zeros(len(linear))]), goal.rows])
    offset = np.zeros(len(rows))
    offset[: len(linear) - len(lines)] = -cone.rows(floor).reshape(-1)
    offset[len(linear) - len(lines)] = room
    parts = [cone.part] * count + [ConstraintBlock("line", len(lines)), *goal.parts]
    # The unit of mass is 1 here, and a bound that bounds nothing is 0.
    known, free = np.zeros(n + 1), np.ones(n + 1, dtype=bool)
    if question.sized:
        known[own - 1], free[own - 1] = 1.0, False
    free[n] = len(goal.parts) > 0
    H, q = None, goal.q[free]
    if goal.H is not None:
        H, q = goal.H[np.ix_(free, free)], q + (goal.H @ known)[free]
    found = solve_conic(q, rows[:, free], offset + rows @ known, parts, H)
    if found.infeasible or not np.isfinite(found.x).all():
        return None
    known[free] = found.x
    return known


def _check_definite(space: DesignSpace, free: tuple[int, ...], P: Array) -> None:
    """Refuse bodies from which no distance is defined."""
    for b, matrix in zip(free, P, strict=True):
        if np.linalg.eigvalsh(matrix)[0] <= SINGULAR * np.trace(matrix):
            raise BodyError(
                space.source, space.bodies[b],
                "has a singular mass distribution in the file, from which no change can be "
                "measured; give it mass and extent in every direction, or keep it",
            )  # fmt: skip


def _goal(
    space: DesignSpace, question: Program, cone: Cone, wanted: Objective, file: Array
) -> _Goal:
    """The objective in the coordinates of a cone."""
    n, free = cone.blocks.shape[1], list(question.free)
    q, none = np.zeros(n + 1), np.empty((0, n + 1))
    area = space.length**2
    if wanted == "change":
        whiten = np.linalg.inv(np.linalg.cholesky(file[free]))[:, None]
        D = np.zeros((len(free) * cone.part.rows, n + 1))
        D[:, :n] = cone.stacked(whiten @ cone.blocks @ whiten.swapaxes(-1, -2))
        d = np.tile(triangles(np.eye(cone.size)), len(free))
        return _Goal(-2.0 * d @ D, float(d @ d), 1.0, 2.0 * D.T @ D, none, ())
    if wanted == "inertia":
        q[n] = 1.0
        rows, part = _moments(space, cone, free)
        parts = (part,) * (len(free) if part.kind == "matrix" else 1)
        return _Goal(q, 0.0, question.unit * area, None, rows, parts)
    weights = _swept(space) if wanted == "rotor" else np.zeros_like(file)
    if wanted == "mass":
        weights[:, -1, -1] = 1.0
    q[:n] = np.einsum("bij,bnij->n", weights[free], cone.blocks)
    keep = [b for b in range(len(file)) if b not in free]
    constant = float(np.sum(weights[keep] * file[keep]))
    scale = question.unit * (area if wanted == "rotor" else 1.0)
    return _Goal(q, constant, scale, None, none, ())


def _moments(space: DesignSpace, cone: Cone, free: list[int]) -> tuple[Array, ConstraintBlock]:
    """Bound minus the inertia of each body about the origin of its link frame, as rows.

    In a plane that is the moment about the normal, the largest of a flat body.
    """
    frame, d, n = space.chain.frame, cone.size - 1, cone.blocks.shape[1]
    origins = (space.frames[free, :3, 3] - frame.origin) @ frame.R.T[:, :d] / frame.length
    shift = np.tile(np.eye(d + 1), (len(free), 1, 1))
    shift[:, :d, d] = -origins
    S = (shift[:, None] @ cone.blocks @ shift[:, None].swapaxes(-1, -2))[..., :d, :d]
    trace = np.trace(S, axis1=-2, axis2=-1)
    if cone.lorentz:
        return np.column_stack([-trace, np.ones(len(free))]), ConstraintBlock("line", len(free))
    inertia = triangles(trace[..., None, None] * np.eye(d) - S)
    unit = np.tile(triangles(np.eye(d)), len(free))
    rows = np.column_stack([-inertia.transpose(0, 2, 1).reshape(-1, n), unit])
    return rows, ConstraintBlock("matrix", d)


def _swept(space: DesignSpace) -> Array:
    """Weights K with ``Σ_b <K_b, P_b>`` the trace of the inertia matrix of the motion.

    A point x of a body moves by ``T [x; 1]`` for a unit rate of a coordinate, T being the
    first rows of the twist as a matrix; so ``K = Σ_w T_wᵀ T_w``.
    """
    chain = space.chain
    twists = expand(chain, np.zeros((1, chain.width)), 0).T[0, 0]
    d = 2 if chain.planar else 3
    K = np.zeros((chain.links.size, d + 1, d + 1))
    for b, link in enumerate(chain.links):
        for twist in twists[link] if link >= 0 else ():
            T = np.column_stack([_turning(twist[:-d]), twist[-d:]])
            K[b] += T.T @ T
    return K


def _turning(rotation: Array) -> Array:
    """The matrix of ``ω ×`` in space (3,) or in the plane (1,)."""
    if rotation.size == 1:
        return rotation[0] * np.array([[0.0, -1.0], [1.0, 0.0]])
    return np.cross(rotation, np.eye(3)).T
