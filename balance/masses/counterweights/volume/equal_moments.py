"""Newton's method for the least largest moment of inertia: the largest moments are equal.

A master program of `fill_program` finds which links b have the largest moment of inertia t, and
about which axes: a matrix ``W_b = U_b ω_b U_bᵀ`` of its dual, with ``ω_b ≻ 0`` and
``Σ_b tr ω_b = 1``, has the axes ``U_b`` (3, r) for which ``U_bᵀ I_b U_b = t 1`` with the
inertia I_b of the given and the added matter. With one of the moments as t and an orthonormal
basis E of symmetric matrices (r, r), the least t of which these are equal has the equations

    <U_b E U_bᵀ, I_b> - t tr E = 0,

whose multipliers are the entries of -ω_b. The axes are right where the moments with the third
directions vanish too, which Broyden's method finds (C. G. Broyden, Mathematics of Computation
19, 1965).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_program import AddedProgram
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.counterweights.volume.dual_ascent import (
    fill_all,
    forms_of,
    maximise_dual,
)
from balance.support.clarabel_adapter import TRIANGLES, triangles
from balance.support.tolerances import AXES_ACCEPTED, AXES_SETTLED, MOMENT_WEIGHT_ZERO
from kinematics.numerics.array_types import Array, IntArray

# Most solutions, each with other axes, and the angle beyond which none are found, in radians.
MOST_AXES = 15
AXES_LOST = 0.1


class EqualMoments(NamedTuple):
    """Parts of which links have an equal, the largest, moment of inertia.

    Attributes:
        dual: multipliers of the conditions, then those of the moments of inertia (6 links).
        stocks: those whose rays start inside the parts.
        forms: matrices (links, 4, 4), positive where matter is.
        moments: of the matter (links, 4, 4), in units of mass.
    """

    dual: Array
    stocks: list[Stock]
    forms: Array
    moments: Array


def equalise_moments(
    program: AddedProgram, stocks: Sequence[Stock], dual: Array
) -> EqualMoments | None:
    """Improve the multipliers of a master program by Newton's method; see the module.

    Args:
        program: a program of the largest moment of inertia, without matter that is moved.
        stocks: region and density of each link.
        dual: multipliers of the conditions, then those of the moments of inertia (6 links).

    Returns:
        The parts; None where no axes are found, or a matrix ω is not positive definite.
    """
    rank = program.target.size
    W = _matrices(dual[rank:].reshape(-1, 6))
    weights, axes = np.linalg.eigh(W)
    sizes = (weights > MOMENT_WEIGHT_ZERO).sum(axis=1)
    if not sizes.any():
        return None
    # The largest weight is that of the moment which is minimised.
    order = [int(b) for b in np.argsort(-weights[:, 2], kind="stable") if sizes[b]]
    frames = {b: axes[b][:, ::-1] for b in order}
    search = _Broyden(sum(sizes[b] * (3 - sizes[b]) for b in order))
    eta, error = np.empty(0), np.inf
    for _ in range(MOST_AXES):
        turned = _turned(frames, sizes, search.x)
        links, squares, traces = _equal_parts({b: turned[b][:, : sizes[b]] for b in order})
        if not eta.size:
            parts = np.einsum("ei,ei->e", triangles(W)[links], squares)
            eta = np.append(dual[:rank], -parts[1:])
        equations, cost = _with_equations(program, links, squares, traces)
        eta, seen = maximise_dual(equations, stocks, cost, eta)
        forms = forms_of(equations, eta, cost)
        moments = fill_all(program, seen, forms)
        tensors = np.einsum("lij,lj->li", program.inertia[0], triangles(moments))
        tensors = _matrices(tensors + program.inertia[1])
        residual = np.concatenate([_mixed(tensors[b], turned[b], sizes[b]) for b in order])
        error = float(np.abs(residual).max(initial=0.0))
        if error <= AXES_SETTLED:
            break
        if not error <= AXES_LOST:
            return None
        search.step(residual)
    if error > AXES_ACCEPTED:
        return None
    omega = np.append(1.0 + eta[rank:] @ traces[1:], -eta[rank:])
    W = np.zeros((len(stocks), 3, 3))
    np.add.at(W, links, _matrices(omega[:, None] * squares))
    if any(np.linalg.eigvalsh(W[b])[3 - sizes[b]] <= 0.0 for b in order):
        return None
    return EqualMoments(np.append(eta[:rank], triangles(W)), seen, forms, moments)


def _mixed(tensor: Array, frame: Array, size: int) -> Array:
    """Compute about the angles by which axes miss: moments with the others over differences.

    Args:
        tensor: moments of inertia (3, 3).
        frame: axes of the largest moments, then the others (3, 3).
        size: number of the former.
    """
    turned = frame.T @ tensor @ frame
    others = turned[size:, size:].diagonal()
    return np.asarray((turned[size:, :size] / (others - turned[0, 0])[:, None]).ravel())


class _Broyden:
    """Broyden's method for ``F(x) = 0``, from x = 0 and the Jacobian 1."""

    def __init__(self, n: int) -> None:
        """Start at zero."""
        self.x, self._inverse = np.zeros(n), np.eye(n)
        self._before: Array | None = None
        self._change = np.zeros(n)

    def step(self, residual: Array) -> None:
        """Move x, with the residual F(x)."""
        if self._before is not None:
            moved = self._inverse @ (residual - self._before)
            size = float(self._change @ moved)
            if size:
                change = np.outer(self._change - moved, self._change @ self._inverse)
                self._inverse += change / size
        self._before, self._change = residual, -self._inverse @ residual
        self.x = self.x + self._change


def _turned(frames: Mapping[int, Array], sizes: IntArray, x: Array) -> dict[int, Array]:
    """Turn frames (3, 3), whose first axes are U, by angles of these to the others."""
    turned, at = {}, 0
    for b, V in frames.items():
        r = int(sizes[b])
        K = x[at : at + r * (3 - r)].reshape(3 - r, r)
        at += K.size
        U = np.vstack([np.eye(r), -K])
        Q, R = np.linalg.qr(np.hstack([U, np.eye(3)[:, r:]]))
        turned[b] = V @ (Q * np.sign(R.diagonal()))
    return turned


def _equal_parts(U: Mapping[int, Array]) -> tuple[IntArray, Array, Array]:
    """List the links of the equations, vectors (equations, 6) of ``U E Uᵀ``, and traces of E.

    Args:
        U: axes (3, r) of the largest moments, by link.
    """
    links: list[int] = []
    squares: list[Array] = []
    traces: list[float] = []
    for b, axes in U.items():
        for i in range(axes.shape[1]):
            for j in range(i + 1):
                square = np.outer(axes[:, i], axes[:, j])
                square = square if i == j else np.sqrt(0.5) * (square + square.T)
                links.append(b)
                squares.append(triangles(square))
                traces.append(float(i == j))
    return np.array(links), np.array(squares), np.array(traces)


def _with_equations(
    program: AddedProgram, links: IntArray, squares: Array, traces: Array
) -> tuple[AddedProgram, Array]:
    """Add the equations of equal moments to a program, and the first moment to its cost.

    Args:
        links: links of the equations; the first one is the moment t itself.
        squares: vectors (equations, 6) of ``U E Uᵀ``.
        traces: traces of E (equations,).
    """
    c = np.einsum("ei,eij->ej", squares, program.inertia[0][links])
    g = np.einsum("ei,ei->e", squares, program.inertia[1][links])
    rows = np.zeros((len(program.cost), len(links) - 1, c.shape[1]))
    rows[links[1:], range(len(links) - 1)] = c[1:]
    rows[links[0]] -= traces[1:, None] * c[0]
    cost = program.cost.copy()
    cost[links[0]] += c[0]
    more = program._replace(
        rows=np.concatenate([program.rows, rows], axis=1),
        target=np.append(program.target, traces[1:] * g[0] - g[1:]),
    )
    return more, cost


def _matrices(vectors: Array) -> Array:
    """Convert vectors (links, 6) of `triangles` to matrices (links, 3, 3)."""
    return np.asarray((vectors @ TRIANGLES[3].T).reshape(-1, 3, 3))
