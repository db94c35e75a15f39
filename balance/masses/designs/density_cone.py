"""Limits of density as cones: a determinant by a semidefinite matrix, its root by squares.

``∏ w_i ≤ det(P)`` for the diagonal w of a lower triangular matrix W exactly if

    [[P, W], [Wᵀ, diag(w)]] ⪰ 0

is possible: then ``P ⪰ W diag(w)⁻¹ Wᵀ``, whose factors have the determinants 1, ∏ w_i and 1.
With a further number t, the limit of `balance.masses.designs.density` is

    κ^{d/(d + 3)} m  ≤  t  ≤  (∏ w_i τ²)^{1/(d + 3)},

whose second part is five second-order cones: with ``w_4 = t`` in the plane,

    a² ≤ w_1 w_2,    b² ≤ w_3 w_4,    e² ≤ a b,    f² ≤ τ t,    t² ≤ e f.

(A. Ben-Tal, A. Nemirovski, Lectures on Modern Convex Optimization, 2001, sections 3.3 and 4.2.)

The tolerances of the solver are absolute, and one body may be a thousand times lighter than
another. Each body is therefore measured by a reference P0: the cones are those of ``T P Tᵀ``
with ``T P0 Tᵀ = 1``, and the unit of mass is that of the reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.support.clarabel_adapter import TRIANGLES, ConstraintBlock, triangles
from balance.support.tolerances import REFERENCE_RIDGE
from kinematics.numerics.array_types import Array


class UnitOfMass(NamedTuple):
    """The unit of mass τ, ``row · x + constant``, and its value at the reference."""

    row: Array
    constant: float
    reference: float = 1.0


class DensityRows(NamedTuple):
    """Rows of the cones of limited bodies, over their coordinates x and further columns.

    Attributes:
        rows: rows (rows, n + further).
        offset: constants of the rows (rows,).
        parts: cones of the rows.
        whiten: T of each body (bodies, k, k).
        mass_factors: factor of the mass in the row ``t - factor m`` of each body (bodies,).
    """

    rows: Array
    offset: Array
    parts: list[ConstraintBlock]
    whiten: Array
    mass_factors: Array

    def beside(self, more: int) -> Array:
        """Return the rows with columns of zeros for more coordinates, which follow x.

        Args:
            more: number of those coordinates.
        """
        n = self.rows.shape[1] - len(self.whiten) * _further(self.whiten.shape[-1])
        return np.insert(self.rows, [n] * more, 0.0, axis=1)


def density_rows(
    blocks: Array,
    references: Array,
    unit: UnitOfMass,
    kappas: Sequence[float],
    constant: Array | None = None,
) -> DensityRows:
    """Build the cones of bodies whose density is limited.

    Args:
        blocks: matrices of each coordinate x (bodies, n, k, k).
        references: matrices P0 (bodies, k, k), positive definite up to round-off.
        unit: the unit of mass.
        kappas: κ of each body, in the units of the matrices.
        constant: part of the matrices that does not depend on x (bodies, k, k); none by
            default.
    """
    count, n, k = blocks.shape[:3]
    fixed = np.zeros_like(references) if constant is None else constant
    root, further = 1.0 / (k + 2), _further(k)
    width = n + count * further
    # A matrix that is positive definite up to its round-off measures a body as well.
    least = REFERENCE_RIDGE * np.trace(references, axis1=1, axis2=2)
    ridge = np.maximum(0.0, least - np.linalg.eigvalsh(references)[:, 0])
    whiten = np.linalg.inv(np.linalg.cholesky(references + ridge[:, None, None] * np.eye(k)))
    # (det P)^root τ^(2 root) is 1 at the reference.
    sizes = np.prod(np.diagonal(whiten, axis1=1, axis2=2) ** (2.0 * root), axis=1)
    factors = np.array(kappas) ** ((k - 1) * root) * sizes / unit.reference ** (2.0 * root)
    rows: list[Array] = []
    offset: list[Array] = []
    for b in range(count):
        start = n + b * further
        columns = np.zeros((n + 1, 2 * k, 2 * k))
        columns[:n, :k, :k] = whiten[b] @ blocks[b] @ whiten[b].T
        columns[n, :k, :k] = whiten[b] @ fixed[b] @ whiten[b].T
        inner = triangles(columns).T
        matrix = np.zeros((2 * k * (2 * k + 1) // 2, width))
        matrix[:, :n] = inner[:, :n]
        matrix[:, start : start + further - 5] = triangles(_lower_entries(k)).T
        powers, constants = _square_rows(n, width, start, k, unit)
        powers[-1, :n] = -factors[b] * blocks[b, :, -1, -1]
        constants[-1] = -factors[b] * fixed[b, -1, -1]
        rows += [matrix, powers]
        offset += [inner[:, n], constants]
    psd, square = ConstraintBlock("psd_triangle", 2 * k), ConstraintBlock("second_order", 3)
    parts = [psd, *[square] * 5, ConstraintBlock("nonnegative", 1)] * count
    return DensityRows(np.concatenate(rows), np.concatenate(offset), parts, whiten, factors)


def _further(k: int) -> int:
    """Return how many columns a body has: the entries of W, and t, a, b, e and f."""
    return k * (k + 1) // 2 + 5


def _lower_entries(k: int) -> Array:
    """Build the matrices (2 k, 2 k) of the entries of W."""
    down, across = np.tril_indices(k)
    every, diagonal = np.arange(down.size), np.flatnonzero(down == across)
    entries = np.zeros((down.size, 2 * k, 2 * k))
    entries[every, down, k + across] = entries[every, k + across, down] = 1.0
    entries[diagonal, range(k, 2 * k), range(k, 2 * k)] = 1.0
    return entries


def _square_rows(
    n: int, width: int, start: int, k: int, unit: UnitOfMass
) -> tuple[Array, Array]:
    """Build the rows of the five cones ``c² ≤ a b``, and that of t; and their constants.

    As a second-order cone, ``c² ≤ a b`` is ``|(2 c, a - b)| ≤ a + b``.
    """
    unknowns = np.eye(width)
    down, across = np.tril_indices(k)
    w = list(unknowns[start + np.flatnonzero(down == across)])
    t, a, b, e, f = unknowns[start + down.size : start + down.size + 5]
    w, tau = [*w, t][:4], np.zeros(width)
    tau[:n] = unit.row / unit.reference
    rows, constants = np.zeros((16, width)), np.zeros(16)
    products = ((a, w[0], w[1]), (b, w[2], w[3]), (e, a, b), (f, tau, t), (t, e, f))
    for i, (c, x, y) in enumerate(products):
        rows[3 * i : 3 * i + 3] = x + y, 2.0 * c, x - y
    constants[[9, 11]] = unit.constant / unit.reference
    rows[15] = t
    return rows, constants


def split_dual(rows: DensityRows, dual: Array) -> tuple[Array, Array]:
    """Split the multipliers of `density_rows` into matrices and multipliers of the masses.

    Args:
        dual: multipliers of the rows.

    Returns:
        Positive semidefinite matrices A (bodies, k, k) of the pseudo-inertias, and μ ≥ 0
        (bodies,): the rows are ``Σ_b <A_b, P_b> - μ_b m_b`` and terms of τ and of the further
        columns.
    """
    count, k = rows.whiten.shape[:2]
    dual = dual.reshape(count, -1)
    lifted = (dual[:, : k * (2 * k + 1)] @ TRIANGLES[2 * k].T).reshape(count, 2 * k, 2 * k)
    matrices = rows.whiten.swapaxes(1, 2) @ lifted[:, :k, :k] @ rows.whiten
    return matrices, rows.mass_factors * np.maximum(0.0, dual[:, -1])


def widen(rows: Array, width: int) -> Array:
    """Append columns of zeros to rows (..., n)."""
    return np.pad(rows, [(0, 0)] * (rows.ndim - 1) + [(0, width - rows.shape[-1])])
