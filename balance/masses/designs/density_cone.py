"""Limits of density as cones: a determinant by a semidefinite matrix, its root by a power.

``∏ w_i ≤ det(P)`` for the diagonal w of a lower triangular matrix W exactly if

    [[P, W], [Wᵀ, diag(w)]] ⪰ 0

is possible: then ``P ⪰ W diag(w)⁻¹ Wᵀ``, whose factors have the determinants 1, ∏ w_i and 1.
The limit of `balance.masses.designs.density` is then a power cone,

    ∏ w_i^{1/(d + 3)} τ^{2/(d + 3)} ≥ κ^{d/(d + 3)} m.

(A. Ben-Tal, A. Nemirovski, Lectures on Modern Convex Optimization, 2001, section 4.2.)

The tolerances of the solver are absolute, and one body may be a thousand times lighter than
another. Each body is therefore measured by a reference P0 of its own: the cones are those of
``T P Tᵀ`` with ``T P0 Tᵀ = 1``, and masses are in units of that of P0.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.masses.designs.clarabel_adapter import TRIANGLES, ConstraintBlock, triangles

Array = NDArray[np.float64]


class LiftedBodies(NamedTuple):
    """Rows of the cones of some bodies, over their coordinates x and the entries of each W.

    Attributes:
        rows: rows (rows, n + entries).
        offset: constants of the rows (rows,).
        parts: cones of the rows, one pair for each body; a body without a limit has the first
            alone.
        pivots: columns of the diagonal of W of each body (bodies, k).
        whiten: T of each body (bodies, k, k).
        mass_rows: factor of the mass in the power cone of each body, 0 without one (bodies,).
    """

    rows: Array
    offset: Array
    parts: list[ConstraintBlock]
    pivots: Array
    whiten: Array
    mass_rows: Array


class UnitOfMass(NamedTuple):
    """The unit of mass as a function ``row · x + constant``, and its value at the reference."""

    row: Array
    constant: float
    reference: float = 1.0


def lift_bodies(
    blocks: Array, references: Array, unit: UnitOfMass, limits: Mapping[int, float]
) -> LiftedBodies:
    """Build the cones of some bodies and of their limits of density.

    Args:
        blocks: matrices of each coordinate x (bodies, n, k, k).
        references: positive definite matrices P0 (bodies, k, k).
        unit: the unit of mass.
        limits: κ by position of the body, in the units of the matrices.
    """
    count, n, k = blocks.shape[:3]
    down, across = np.tril_indices(k)
    entries, width = down.size, n + count * down.size
    on_diagonal = np.flatnonzero(down == across)
    lifted = np.zeros((entries, 2 * k, 2 * k))
    lifted[range(entries), down, k + across] = lifted[range(entries), k + across, down] = 1.0
    lifted[on_diagonal, range(k, 2 * k), range(k, 2 * k)] = 1.0
    lifted_rows = triangles(lifted).T
    whiten = np.linalg.inv(np.linalg.cholesky(references))
    corner = np.zeros((n, 2 * k, 2 * k))
    rows: list[Array] = []
    offset: list[Array] = []
    parts: list[ConstraintBlock] = []
    pivots, mass_rows = np.zeros((count, k), dtype=int), np.zeros(count)
    for b in range(count):
        start = n + b * entries
        pivots[b] = start + on_diagonal
        corner[:, :k, :k] = whiten[b] @ blocks[b] @ whiten[b].T
        own = np.zeros((lifted_rows.shape[0], width))
        own[:, :n], own[:, start : start + entries] = triangles(corner).T, lifted_rows
        rows.append(own)
        offset.append(np.zeros(len(own)))
        parts.append(ConstraintBlock("psd_triangle", 2 * k))
        if b in limits:
            root = 1.0 / (k + 2)
            power = np.zeros((k + 2, width))
            power[range(k), pivots[b]] = 1.0
            power[k, :n] = unit.row / unit.reference
            # The left side is 1 at the reference.
            size = np.prod(np.diagonal(whiten[b]) ** (2.0 * root))
            mass_rows[b] = limits[b] ** ((k - 1) * root) * size
            mass_rows[b] /= unit.reference ** (2.0 * root)
            power[k + 1, :n] = mass_rows[b] * blocks[b, :, -1, -1]
            rows.append(power)
            offset.append(np.eye(k + 2)[k] * unit.constant / unit.reference)
            exponents = (*[root] * k, 2.0 * root)
            parts.append(ConstraintBlock("power", k + 2, exponents))
    return LiftedBodies(
        np.concatenate(rows), np.concatenate(offset), parts, pivots, whiten, mass_rows
    )


def logarithm_rows(
    lifted: LiftedBodies,
) -> tuple[Array, Array, list[ConstraintBlock]]:
    """Build the cones ``u ≤ log w`` of all diagonals, with a further column for each u.

    Returns:
        Rows (3 entries, columns + entries), their constants, and their cones.
    """
    columns, width = lifted.pivots.reshape(-1), lifted.rows.shape[1]
    count = columns.size
    rows = np.zeros((count, 3, width + count))
    rows[range(count), 0, width + np.arange(count)] = 1.0
    rows[range(count), 2, columns] = 1.0
    offset = np.tile([0.0, 1.0, 0.0], count)
    parts = [ConstraintBlock("exponential", 3)] * count
    return rows.reshape(-1, width + count), offset, parts


def split_dual(
    lifted: LiftedBodies, dual: Array
) -> tuple[Array, Array]:
    """Split the multipliers of `lift_bodies` into matrices and multipliers of the masses.

    Args:
        dual: multipliers of the rows.

    Returns:
        Positive semidefinite matrices A (bodies, k, k) of the pseudo-inertias, and μ ≥ 0
        (bodies,): the rows are ``Σ_b <A_b, P_b> - μ_b m_b`` and terms of W and τ.
    """
    k = lifted.whiten.shape[-1]
    matrices, masses = np.zeros_like(lifted.whiten), np.zeros(len(lifted.whiten))
    row, b = 0, -1
    for part in lifted.parts:
        values = dual[row : row + part.rows]
        row += part.rows
        if part.kind == "psd_triangle":
            b += 1
            A = (TRIANGLES[2 * k] @ values).reshape(2 * k, 2 * k)[:k, :k]
            matrices[b] = lifted.whiten[b].T @ A @ lifted.whiten[b]
        else:
            masses[b] = max(0.0, -lifted.mass_rows[b] * float(values[-1]))
    return matrices, masses

