"""Directions without reaction in a pose; where several paths meet, those that are tangents.

A path ``y(s) = s v + …`` through a pose satisfies ``A(y) ẏ = 0`` at every order of s:

    A v = 0
    ∂A[v] v + A ÿ = 0    hence    Lᵀ ∂A[v] v = 0    for the left null vectors L of A.

In a regular pose the second line adds nothing. Where A drops rank, it is a system of quadratic
equations on the null space: the tangent cone of the paths, whose lines are the directions of
the branches (J. J. de Jong, PhD thesis, University of Twente, section 3.2: several reactionless
paths meet in a pose of instantaneous dynamic balance; A. Müller, "Local kinematic analysis of
closed-loop linkages", 2019, for the tangent cone of loops).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import comb
from typing import Literal, NamedTuple

import numpy as np

from balance.motion.motion_tolerances import CONE_DOUBLE_ROOT, CONE_RESIDUAL, MOMENTUM_NULL
from balance.motion.paths.rest_equations import RestEquations, RowsAtPose
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.gauss_newton import Iterate, LeastNorm, gauss_newton, never_stop
from kinematics.numerics.linalg.ties import first_basis, first_largest, round_decimals
from kinematics.numerics.linalg.vectors import distinct_vectors

# Kinds of a pose: regular; several paths cross; they touch, or one folds; none leaves it.
Kind = Literal["regular", "crossing", "fold", "isolated"]

# Most directions that are tried where the second order decides nothing.
MOST_DIRECTIONS = 40
# Decimals of the components of unit tangents by which they are sorted.
LINE_DECIMALS = 6
# Random starts of the search for lines of the cone, and their seed.
STARTS = 40
SEED = 7


class Tangents(NamedTuple):
    """Directions in which paths leave a pose.

    Attributes:
        kind: ``"regular"``, ``"crossing"``, ``"fold"`` (a double direction), or ``"isolated"``
            (rates without reaction, but no path along any).
        directions: unit tangents in the coordinates (count, w), one sense of each.
        family: dimension of the set of paths through the pose: 1 if the directions are all.
    """

    kind: Kind
    directions: Array
    family: int


def null_basis(here: RowsAtPose) -> tuple[Array, Array, Array]:
    """Compute the right and the left null space of the equations in a pose.

    Returns:
        Bases as columns (w, dimension) and (rows, left dimension), which depend on the spaces
        alone, and all singular values over the momenta of the bodies (w,), falling; zero where
        there are fewer rows.
    """
    U, sizes, Vt = np.linalg.svd(here.rows, full_matrices=True)
    values = np.zeros(Vt.shape[0])
    values[: sizes.size] = sizes / (here.scale or 1.0)
    rank = int(np.count_nonzero(values > MOMENTUM_NULL))
    return first_basis(Vt[rank:]).T, first_basis(U[:, rank:].T).T, values


def leading_directions(N: Array) -> Array:
    """Choose directions of a null space in which as few coordinates move as possible.

    Each of the directions moves one of the leading coordinates, the others of these rest.

    Args:
        N: orthonormal columns (w, k).

    Returns:
        Unit directions (k, w).
    """
    k, remainder = N.shape[1], N.copy()
    leaders: list[int] = []
    for _ in range(k):
        sizes = np.linalg.norm(remainder, axis=1)
        lead = first_largest(sizes)
        leaders.append(lead)
        row = remainder[lead] / sizes[lead]
        remainder = remainder - np.outer(remainder @ row, row)
    directions = np.linalg.solve(N[leaders].T, N.T)
    return np.asarray(directions / np.linalg.norm(directions, axis=1, keepdims=True))


def fan_of_directions(here: RowsAtPose, count: int) -> Array:
    """Choose directions all around a null space: evenly in a plane, else at random.

    Args:
        here: the equations in a pose; its null space has two dimensions or more.
        count: number of directions; paths lead to both sides along each.

    Returns:
        Unit directions (count, w).
    """
    N = null_basis(here)[0]
    if N.shape[1] == 2:
        angles = np.pi * np.arange(count) / count
        around = np.column_stack([np.cos(angles), np.sin(angles)])
    else:
        around = np.random.default_rng(SEED).standard_normal((count, N.shape[1]))
        around /= np.linalg.norm(around, axis=1, keepdims=True)
    return np.asarray(around @ N.T)


def _resting_directions(N: Array) -> Array:
    """List directions of a null space in which all coordinates rest that can.

    Where the equations say nothing at second order, paths leave along special directions
    only, and those of a symmetric linkage are among these.

    Args:
        N: orthonormal columns (w, k).

    Returns:
        Unit directions (count, w); `leading_directions` if there are too many.
    """
    w, k = N.shape
    if comb(w, k - 1) > MOST_DIRECTIONS:
        return leading_directions(N)
    lines: list[Array] = []
    for resting in combinations(range(w), k - 1):
        _, sizes, Vt = np.linalg.svd(N[list(resting)], full_matrices=True)
        if sizes.min(initial=1.0) > CONE_DOUBLE_ROOT:
            lines.append(N @ Vt[-1])
    lines = list(_arrange_lines(np.array(lines).reshape(-1, w)))
    first = distinct_vectors(
        lines, lambda some, v: np.abs(some - v).max(axis=1) <= CONE_DOUBLE_ROOT
    )
    return np.array([lines[i] for i in first]).reshape(-1, w)


def tangent_directions(equations: RestEquations, here: RowsAtPose, generic: int) -> Tangents:
    """Find the directions of all paths through a pose, from the pose alone.

    Args:
        equations: the equations of the linkage.
        here: the equations in the pose.
        generic: dimension of the null space in poses around it.
    """
    N, L, _ = null_basis(here)
    k = N.shape[1]
    if k == 0:
        return Tangents("isolated", np.empty((0, len(N))), 0)
    if k == generic:
        return Tangents("regular", leading_directions(N), k)
    Q = _quadratics(equations.derivative(here.q), N, L, here.scale)
    if len(Q) == 0:
        return Tangents("crossing", _resting_directions(N), k)
    roots, double = _lines_of_two(Q) if k == 2 else (_lines_of_many(Q, k), False)
    kind: Kind = "isolated" if len(roots) == 0 else "fold" if double else "crossing"
    lines = _arrange_lines(roots @ N.T)
    return Tangents(kind, lines, max(1, k - len(Q)) if len(lines) else 0)


def _arrange_lines(lines: Array) -> Array:
    """Sort lines (count, w) by their components; the largest of each becomes positive."""
    signed = np.array([v * np.sign(v[first_largest(np.abs(v))]) for v in lines])
    order = sorted(
        range(len(lines)), key=lambda k: tuple(-round_decimals(signed[k], LINE_DECIMALS))
    )
    return signed[order].reshape(lines.shape)


def _quadratics(derivative: Array, N: Array, L: Array, scale: float) -> Array:
    """Compute independent symmetric forms ``Lᵀ ∂A[v] v`` on the null space (count, k, k)."""
    T = np.einsum("ria,rl->lia", derivative, L)
    forms = np.einsum("lia,ip,aq->lpq", T, N, N) / (scale or 1.0)
    forms = 0.5 * (forms + np.swapaxes(forms, 1, 2))
    _, sizes, Vt = np.linalg.svd(forms.reshape(len(forms), -1), full_matrices=False)
    kept = sizes > CONE_RESIDUAL
    return Vt[kept].reshape(-1, *forms.shape[1:])


def _lines_of_two(Q: Sequence[Array] | Array) -> tuple[Array, bool]:
    """Solve quadratic forms in two unknowns: lines (count, 2), and whether one is double.

    ``a x² + 2 b x y + c y² = 0`` has the lines ``(x, y) ∝ (-b ± √(b² - a c), a)``.
    """
    (a, b), (_, c) = Q[0]
    root = b * b - a * c
    if root < -CONE_DOUBLE_ROOT:
        return np.empty((0, 2)), False
    if root <= CONE_DOUBLE_ROOT:
        lines = [np.array([-b, a]) if abs(a) >= abs(c) else np.array([c, -b])]
    else:
        # The sum of equal signs does not cancel; the other line follows from it.
        s = -b - np.copysign(np.sqrt(root), b)
        lines = [np.array([s, a]), np.array([c, s])]
    units = np.array([line / np.linalg.norm(line) for line in lines])
    kept = [np.abs(np.einsum("i,lij,j->l", v, Q, v)).max() <= CONE_DOUBLE_ROOT for v in units]
    return units[kept], root <= CONE_DOUBLE_ROOT


def _lines_of_many(Q: Array, k: int) -> Array:
    """Solve quadratic forms in k unknowns from many starts: distinct lines (count, k)."""
    rng = np.random.default_rng(SEED)

    def equations(v: Array) -> tuple[Array, Array]:
        value = np.einsum("i,lij,j->l", v, Q, v)
        slope = 2.0 * np.einsum("lij,j->li", Q, v)
        return np.append(value, v @ v - 1.0), np.vstack([slope, 2.0 * v])

    def solved(path: Sequence[Iterate]) -> bool:
        return path[-1].error <= CONE_RESIDUAL**1.5

    lines: list[Array] = []
    for start in [*np.eye(k), *rng.standard_normal((STARTS, k))]:
        start = start / np.linalg.norm(start)
        solution = gauss_newton(equations, start, LeastNorm(1e-8, 0.5), solved, never_stop, 40)
        if solution.solved:
            v = solution.last.x / np.linalg.norm(solution.last.x)
            lines.append(v * np.sign(v[first_largest(np.abs(v))]))
    first = distinct_vectors(
        lines, lambda some, v: np.abs(some - v).max(axis=1) <= CONE_DOUBLE_ROOT
    )
    return np.array([lines[i] for i in first]).reshape(-1, k)
