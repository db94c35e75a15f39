"""Certificates of infeasibility from the dual solution of the conic solver.

The solver's multipliers are accurate to about eight digits. Gauss-Newton steps refine them, so
that they fulfil the conditions of `balance.masses.designs.certificate` to round-off.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import cycle

import numpy as np

from balance.masses.designs.certificate import CertificateProof
from balance.masses.designs.constraints import Program
from balance.support.tolerances import (
    CERTIFICATE_RANK_RELATIVE,
    CERTIFICATE_RESIDUAL,
    CERTIFICATE_RIDGE_RELATIVE,
    FIXED_RANK_RELATIVE,
)
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.gauss_newton import Iterate, gauss_newton, never_stop

# Most Gauss-Newton steps from the solution of the conic solver.
MAX_STEPS = 12


def certificates_from_dual(program: Program, dual: Array) -> Iterator[CertificateProof]:
    """Construct certificates from the dual solution of the conic solver.

    Args:
        dual: multipliers of the rows of the free bodies, then of the inequalities.

    Yields:
        One certificate for each decision on the ranks of its matrices.
    """
    cone, lines = program.cone, program.lines
    lifted, (count, n) = cone.with_all_moments().blocks, cone.blocks.shape[:2]
    Z = cone.duals(dual[: dual.size - len(lines)].reshape(count, -1))
    if not len(lines):
        for matrices in refine_matrices(lifted, Z):
            yield CertificateProof(matrices, np.zeros(count))
        return
    # An inequality is a semidefinite constraint of size 1. Undo the scaling of the bounds.
    units = np.ones(len(lines))
    for k, (_, factor) in enumerate(program.limits, int(program.sized)):
        units[k] = abs(factor)
    rows = np.zeros((len(lines), *lifted.shape[1:]))
    rows[:, :n, 0, 0] = lines / units[:, None]
    more = np.zeros((len(lines), cone.size, cone.size))
    more[:, 0, 0] = units * np.maximum(dual[dual.size - len(lines) :], 0.0)
    for matrices in refine_matrices(np.concatenate([lifted, rows]), np.concatenate([Z, more])):
        yield _all_bodies(program, matrices[:count], matrices[count + program.sized :, 0, 0])


def certificates_within_densities(
    program: Program, matrices: Array, lines: Array, masses: Array
) -> Iterator[CertificateProof]:
    """Construct certificates from a dual solution that limits of density have a part in.

    The factors of μ and of the matrices are refined together. The condition on the unit of mass
    is left to the check, which takes the best value of that part.

    Args:
        matrices: positive semidefinite matrices of the free bodies (free, k, k).
        lines: multipliers of the inequalities (lines,).
        masses: μ of the free bodies (free,), taken from the corners of their matrices.

    Yields:
        One certificate for each decision on the ranks of its matrices.
    """
    cone, count = program.cone.with_all_moments(), len(matrices)
    tau = program.traces.size - 1
    blocks = np.delete(cone.blocks, tau, axis=1)
    (n, k), inner = blocks.shape[1:3], np.delete(program.lines, tau, axis=1)[1:]
    units = np.array([abs(factor) for _, factor in program.limits] + [1.0] * len(program.balls))
    rows = np.zeros((len(inner) + count, n, k, k))
    rows[: len(inner), : inner.shape[1], 0, 0] = inner / units[:, None]
    rows[len(inner) :, :, 0, 0] = -blocks[:, :, -1, -1]
    more = np.zeros((len(rows), k, k))
    more[:, 0, 0] = np.append(units * np.maximum(lines[1:], 0.0), masses)
    every = np.concatenate([blocks, rows]), np.concatenate([matrices, more])
    for refined in refine_matrices(*every):
        values = refined[count:, 0, 0]
        free = refined[:count].copy()
        free[:, -1, -1] -= values[len(inner) :]
        yield _all_bodies(program, free, values[: len(inner)])


def _all_bodies(program: Program, free: Array, values: Array) -> CertificateProof:
    """Extend a certificate to all bodies; the matrices of kept bodies make the sum vanish.

    Args:
        free: matrices of the free bodies.
        values: multipliers of the bounds, then of the balls.
    """
    whole, bounding = program.whole, len(program.limits)
    Z = np.zeros((len(whole.blocks), whole.size, whole.size))
    Z[list(program.free)] = free
    for value, (b, factor) in zip(values[:bounding], program.limits, strict=True):
        Z[b, -1, -1] += np.sign(factor) * value
    multipliers, inside = np.zeros(len(Z)), np.zeros_like(Z)
    for value, (b, G) in zip(values[bounding:], program.balls, strict=True):
        multipliers[b], inside[b] = value, value * G
    return CertificateProof(_solve_fixed_rows(program, Z, inside), multipliers)


def _solve_fixed_rows(program: Program, Z: Array, inside: Array | float = 0.0) -> Array:
    """Choose the multipliers of the fixed rows so that ``Σ_b <Z_b + inside_b, P_b>`` vanishes.

    The second solve removes the round-off of the first. Rows that depend on one another to
    round-off count as one row, as in the program itself: multipliers of their difference would
    be unbounded.
    """
    for _ in range(2 if len(program.fixed) else 0):
        residual = np.einsum("bnij,bij->n", program.whole.blocks, Z + inside)
        Z = Z + _fixed_rows_matrices(
            program, np.linalg.lstsq(program.fixed.T, -residual, rcond=FIXED_RANK_RELATIVE)[0]
        )
    return Z


def _fixed_rows_matrices(program: Program, multipliers: Array) -> Array:
    """Compute the matrices of all bodies for multipliers of the fixed rows."""
    whole = program.whole
    Z = np.zeros((len(whole.blocks), whole.size, whole.size))
    kept = [b for b in range(len(Z)) if b not in program.free]
    split = len(kept) * whole.part.rows
    Z[kept] = whole.duals(multipliers[:split].reshape(len(kept), whole.part.rows))
    Z[list(program.fixed_masses), -1, -1] += multipliers[split:]
    return Z


def conflict_certificate(program: Program) -> CertificateProof:
    """Construct the certificate that no masses balance the kept bodies and fixed masses."""
    Z = _fixed_rows_matrices(program, program.residual / np.linalg.norm(program.residual))
    return CertificateProof(_solve_fixed_rows(program, Z), np.zeros(len(Z)))


def refine_matrices(blocks: Array, Z: Array) -> Iterator[Array]:
    """Refine an approximate certificate to round-off.

    Minimum-norm Gauss-Newton steps on L solve ``Σ_b <blocks_bi, L_b L_bᵀ> = 0`` for every i.
    ``Z_b = L_b L_bᵀ`` stays positive semidefinite and keeps its rank.

    Args:
        blocks: symmetric matrices (bodies, n, k, k).
        Z: approximate certificate (bodies, k, k).

    Yields:
        One certificate (bodies, k, k) with a total trace of 1 for each decision on ranks.
    """
    values, vectors = np.linalg.eigh(Z)
    largest = values.max()
    for cut in CERTIFICATE_RANK_RELATIVE:
        kept = np.where(values > cut * largest, values, 0.0)
        L = _solve_factors(blocks, vectors * np.sqrt(kept / kept.sum())[:, None, :])
        Z = L @ L.transpose(0, 2, 1) / np.sum(L * L)
        yield 0.5 * (Z + Z.transpose(0, 2, 1))


def _solve_factors(blocks: Array, L: Array) -> Array:
    """Solve ``Σ_b <blocks_bi, L_b L_bᵀ> = 0`` for the factors L.

    A distribution on the boundary of the cone makes a condition like ``|Lᵀ v|² = 0``, a double
    root. Every other step is therefore nearly twice a Newton step: it solves double roots, and
    nearly reverses the residual of the other conditions.
    """
    count, n, k = blocks.shape[:3]
    flat = blocks.reshape(count, n * k, k)

    def conditions(x: Array) -> tuple[Array, Array]:
        jacobian = (flat @ x.reshape(L.shape)).reshape(count, n, k * k)
        half_jacobian: Array = jacobian.transpose(1, 0, 2).reshape(n, -1)
        return half_jacobian @ x, half_jacobian

    def converged(path: Sequence[Iterate]) -> bool:
        residual = path[-1].residual
        return bool(residual @ residual <= CERTIFICATE_RESIDUAL**2)

    last, solved = gauss_newton(
        conditions, L.reshape(-1), _AlternatingSteps(), converged, never_stop, MAX_STEPS
    )
    factors = last.x if solved else _take_step(last)
    return factors.reshape(L.shape)


def _take_step(last: Iterate) -> Array:
    """Return the unknowns after the step, or before it if its equations are singular."""
    try:
        return np.asarray(last.next)
    except np.linalg.LinAlgError:
        return np.asarray(last.x)


class _AlternatingSteps:
    """Minimum-norm steps with half the Jacobian, times 0.5 and 0.9 in turn."""

    def __init__(self) -> None:
        """Start with the factor 0.5."""
        self._factors = cycle((0.5, 0.9))

    def step(self, residual: Array, jacobian: Array) -> Array:
        """Compute the step from normal equations with a small diagonal term."""
        square = jacobian @ jacobian.T
        square.flat[:: len(square) + 1] += (
            CERTIFICATE_RIDGE_RELATIVE * np.einsum("ii->", square) / len(square)
        )
        change = np.linalg.solve(square, residual) @ jacobian
        return np.asarray(next(self._factors) * change)

    def accepts(self, before: Array, after: Array) -> bool:
        """Accept every step."""
        return True
