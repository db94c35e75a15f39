"""Proofs that no mass distribution of a design space can be built.

A linear space does not meet an open convex cone if and only if some hyperplane holds the
space and has the cone on one side. For pseudo-inertias ``P_b ≻ 0`` that hyperplane is one
symmetric matrix per body,

    Z_b ⪰ 0,  not all zero,        Σ_b <Z_b, P_b> = 0  for every balanced distribution,

because the sum would be positive for bodies that can be built. A Z_b that is not zero weighs
its body: ``<L Lᵀ, P> = ∫ |Lᵀ [x; 1]|² dm``. What is only semidefinite, such as point masses and
rods without width, is not excluded. Where the mass of a body is to be within a ball, which is
``<G_b, P_b> ≥ 0``, a multiplier λ_b ≥ 0 goes with it, and

    Σ_b <Z_b + λ_b G_b, P_b> = 0  for every balanced distribution.

(S. Boyd, L. Vandenberghe, Convex Optimization, 2004, section 5.8, has such theorems of
alternatives.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import cycle
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.designs.constraints import MASS_EQUAL, Constraints, Program
from balance.designs.pseudo_inertia_cone import Cone, cone_of, given_parameters, matrices_of
from balance.spaces.design_space_result import DesignSpace
from kinematics.linalg.gauss_newton import Iterate, gauss_newton, never_stop
from kinematics.wording import check_summary

__all__ = [
    "CertificateCheck",
    "CertificateProof",
    "certificates",
    "check_certificate",
    "conflicting_bodies",
    "judge_certificate",
]

Array = NDArray[np.float64]

# Designs of a larger margin must be excluded by a certificate.
SEPARATES = 1e-12
# The size of the parameters of a body is at most so many times the trace of its matrix.
SIZE = 3.0
# Eigenvalues of a certificate from the solver that count as zero, relative to the largest.
CUTS = (1e-6, 1e-5, 1e-4, 1e-3, 1e-7)
# Steps of Gauss and Newton, and the residual that is small enough.
STEPS, SMALL = 12, 5e-15
# Regularisation of conditions that say the same.
RIDGE = 1e-15
# Part of a matrix that counts as zero where it is bounded.
SLACK = 1e-13


class CertificateProof(NamedTuple):
    """What rules out every design.

    Attributes:
        matrices: Z, one symmetric matrix per body (bodies, k, k).
        multipliers: λ, one number per body (bodies,), 0 where no ball limits its mass.
    """

    matrices: Array
    multipliers: Array


class CertificateCheck(NamedTuple):
    """What the check of a certificate found.

    Attributes:
        accepted: whether it excludes every design with a margin above 1e-12.
        eigenvalue: smallest one of the matrices, less what bounds on masses account for, over
            the sum of their Frobenius norms; of kept bodies none counts.
        orthogonality: size of ``Σ_b <Z_b + λ_b G_b, P_b>`` as a function on the orthonormal
            basis of the design space, over the same.
        separation: designs with a margin above this one are excluded, the margin being the
            smallest eigenvalue of all P_b over the sum T of their traces; with kept bodies
            or least masses, whose traces add up to T0, also T0 over T.
    """

    accepted: bool
    eigenvalue: float
    orthogonality: float
    separation: float

    def __repr__(self) -> str:
        """One line: whether it is accepted, and its residuals to three digits."""
        return check_summary(self)


def check_certificate(
    space: DesignSpace, certificate: Sequence[Array], asked: Constraints | None = None,
    multipliers: ArrayLike | None = None,
) -> CertificateCheck:  # fmt: skip
    """Check a certificate in plain NumPy, without the solver.

    With the residual r of orthogonality, and no eigenvalue below -δ, the margin of any design
    is at most ``(3 |r| + δ) / Σ tr Z_b``: this must not exceed 1e-12. For if all P_b ⪰ t T,
    T being the sum of their traces, then

        t T Σ tr Z_b - δ T  ≤  Σ_b <Z_b, P_b>  ≤  Σ_b <Z_b + λ_b G_b, P_b>  ≤  3 |r| T.

    A body whose mass is bounded may have a Z_b that is positive semidefinite only once λ
    times the mass is taken from ``<Z_b, P_b>``, which is then at least λ times the least mass,
    or the largest if λ < 0. The matrix of a body that is kept is arbitrary, as ``<Z_b, P_b>``
    is known. These numbers, K in all, must add up to no less than zero: they stand beside
    ``t T Σ tr Z_b``, where Z_b is what is left. Bounds that are not needed are left alone.

    Args:
        space: the design space.
        certificate: one symmetric matrix per body, in the coordinates of ``space.chain``:
            (4, 4), or (3, 3) in a plane.
        asked: what else is asked of the bodies.
        multipliers: λ, one number per body; none by default. One that is not zero is for a
            body whose mass is asked to be within a ball.

    Raises:
        ValueError: the matrices or the multipliers are not as many, or not of that shape.
    """
    Z = np.array(certificate, dtype=np.float64)
    spare = np.zeros(len(Z)) if multipliers is None else np.array(multipliers, np.float64)
    return judge_certificate(
        space, cone_of(space), CertificateProof(Z, spare), asked or Constraints()
    )


def judge_certificate(
    space: DesignSpace, cone: Cone, proof: CertificateProof, asked: Constraints
) -> CertificateCheck:
    """See `check_certificate`; the cone is that of the space."""
    Z, spare = proof
    if Z.shape != (len(cone.blocks), cone.size, cone.size):
        raise ValueError(f"certificate of shape {Z.shape}: give one matrix for each body")
    if spare.shape != Z.shape[:1]:
        raise ValueError(f"multipliers of shape {spare.shape}: give one for each body")
    matrices = np.isfinite(Z).all() and (Z == Z.transpose(0, 2, 1)).all() and Z.any()
    numbers = np.isfinite(spare).all() and (spare >= 0.0).all()
    if not (matrices and numbers and set(np.flatnonzero(spare)) <= set(asked.balls)):
        return CertificateCheck(False, -np.inf, np.inf, np.inf)
    checks = [_check(space, cone, proof, asked._replace(bounds={}))]
    if asked.bounds:
        checks.append(_check(space, cone, proof, asked))
    # Either is a proof: bounds that are not needed do no harm.
    return min(checks, key=lambda check: check.separation)


def _check(
    space: DesignSpace, cone: Cone, proof: CertificateProof, asked: Constraints
) -> CertificateCheck:
    """Check a certificate with all bounds of a restriction."""
    Z, spare = proof
    own, known = _known(space, Z, asked) if asked.sized else (Z, 0.0)
    whole = Z.copy()
    for b, ball in asked.balls.items():
        whole[b] += spare[b] * ball.form
    residual = cone.sums(whole)
    size = float(np.sqrt(np.einsum("bij,bij->b", Z, Z)).sum())
    traces = float(np.einsum("bii->", own)) / size
    eigenvalue = float(np.linalg.eigvalsh(own)[:, 0].min()) / size
    orthogonality, known = float(np.sqrt(residual @ residual)) / size, known / size
    doubt = SIZE * orthogonality + max(0.0, -eigenvalue) + max(0.0, -known)
    separation = doubt / (traces + max(0.0, known)) if traces + known > 0.0 else np.inf
    accepted = bool(separation <= SEPARATES)
    return CertificateCheck(accepted, eigenvalue, orthogonality, separation)


def _known(space: DesignSpace, Z: Array, asked: Constraints) -> tuple[Array, float]:
    """Split a certificate into the part that is known of ``Σ_b <Z_b, P_b>`` and the rest.

    With the traces of a design adding up to T, which is at least the T0 of kept bodies and of
    least masses, ``Σ_b <own_b, P_b> + known`` is to be positive. A bounded mass gives λ times
    its bound for the λ taken from the corner of its Z_b. Where λ < 0 there is no choice; λ > 0
    is taken only as far as it is needed to make up for the rest, since a positive trace that
    stays excludes more than a mass that is known.

    Returns:
        The matrices own_b of the rest (bodies, k, k), and the known part per unit of T0.
    """
    file, keep = matrices_of(space, given_parameters(space)), list(asked.keep)
    own, known, spare = Z.copy(), float(np.sum(Z[keep] * file[keep])), []
    for b, (low, high) in asked.bounds.items():
        surplus = _surplus(Z[b])
        if surplus < 0.0:
            own[b, -1, -1] -= surplus
            known += surplus * high
        elif low > 0.0:
            spare.append((b, surplus, low))
    gain = sum(surplus * low for _, surplus, low in spare)
    share = min(1.0, max(0.0, -known / gain)) if gain > 0.0 else 0.0
    for b, surplus, _ in spare:
        own[b, -1, -1] -= share * surplus
    known += share * gain
    own[keep] = 0.0
    least = float(np.einsum("bii->", file[keep])) + sum(low for low, _ in asked.bounds.values())
    if least > 0.0:
        return own, known / least
    return own, -np.inf if known < 0.0 else 0.0


def _surplus(Z: Array) -> float:
    """The largest λ that may be taken from the corner of Z, which stays semidefinite."""
    S, w, slack = Z[:-1, :-1], Z[:-1, -1], SLACK * float(np.abs(Z).max())
    if slack == 0.0:
        return 0.0
    surplus = float(Z[-1, -1] - w @ np.linalg.solve(S + slack * np.eye(len(S)), w))
    return surplus if abs(surplus) > slack else 0.0


def certificates(question: Program, dual: Array) -> Iterator[CertificateProof]:
    """Certificates made of the solver's multipliers.

    Args:
        question: what was asked.
        dual: multipliers of the free bodies' rows, and of the lines.
    """
    cone, lines = question.cone, question.lines
    lifted, (count, n) = cone.lifted().blocks, cone.blocks.shape[:2]
    Z = cone.duals(dual[: dual.size - len(lines)].reshape(count, -1))
    if not len(lines):
        yield from (CertificateProof(found, np.zeros(count)) for found in _polished(lifted, Z))
        return
    # A row that must not be negative is a matrix of one entry; bounds are in one unit again.
    units = np.ones(len(lines))
    for k, (_, factor) in enumerate(question.limits, int(question.sized)):
        units[k] = abs(factor)
    rows = np.zeros((len(lines), *lifted.shape[1:]))
    rows[:, :n, 0, 0] = lines / units[:, None]
    more = np.zeros((len(lines), cone.size, cone.size))
    more[:, 0, 0] = units * np.maximum(dual[dual.size - len(lines) :], 0.0)
    for found in _polished(np.concatenate([lifted, rows]), np.concatenate([Z, more])):
        yield _assembled(question, found[:count], found[count + question.sized :, 0, 0])


def _assembled(question: Program, free: Array, values: Array) -> CertificateProof:
    """Matrices of all bodies; those of kept ones are what makes the sum vanish.

    Args:
        question: what was asked.
        free: matrices of the free bodies.
        values: multipliers of the bounds, and then those of the balls.
    """
    whole, bounding = question.whole, len(question.limits)
    Z = np.zeros((len(whole.blocks), whole.size, whole.size))
    Z[list(question.free)] = free
    for value, (b, factor) in zip(values[:bounding], question.limits, strict=True):
        Z[b, -1, -1] += np.sign(factor) * value
    spare, inside = np.zeros(len(Z)), np.zeros_like(Z)
    for value, (b, G) in zip(values[bounding:], question.balls, strict=True):
        spare[b], inside[b] = value, value * G
    return CertificateProof(_refined(question, Z, inside), spare)


def _refined(question: Program, Z: Array, inside: Array | float = 0.0) -> Array:
    """Matrices whose parts for rows that have a value make the sum vanish.

    The second time, what rounding left the first time is solved for. Rows that depend on one
    another to round-off are one row, as in the question itself: their difference, taken for a
    condition of its own, would make multipliers without limit. Added to the matrices in the
    sum, but not changed, is ``inside``.
    """
    for _ in range(2 if len(question.fixed) else 0):
        rest = np.einsum("bnij,bij->n", question.whole.blocks, Z + inside)
        Z = Z + _fixing(question, np.linalg.lstsq(question.fixed.T, -rest, rcond=MASS_EQUAL)[0])
    return Z


def _fixing(question: Program, multipliers: Array) -> Array:
    """Matrices of all bodies for multipliers of the rows that have a value."""
    whole = question.whole
    Z = np.zeros((len(whole.blocks), whole.size, whole.size))
    kept = [b for b in range(len(Z)) if b not in question.free]
    split = len(kept) * whole.part.rows
    Z[kept] = whole.duals(multipliers[:split].reshape(len(kept), whole.part.rows))
    Z[list(question.told), -1, -1] += multipliers[split:]
    return Z


def conflicting_bodies(question: Program) -> CertificateProof:
    """The certificate that kept bodies and masses cannot be balanced by anything."""
    Z = _fixing(question, question.left / np.linalg.norm(question.left))
    return CertificateProof(_refined(question, Z), np.zeros(len(Z)))


def _polished(blocks: Array, Z: Array) -> Iterator[Array]:
    """Certificates near an approximate one, exact to round-off.

    ``Z_b = L_b L_bᵀ`` stays positive semidefinite and of the rank found, while Gauss-Newton
    steps of least size solve ``Σ_b <blocks_bi, L_b L_bᵀ> = 0`` for every i.

    Args:
        blocks: symmetric matrices (bodies, n, k, k).
        Z: approximate certificate (bodies, k, k).

    Yields:
        One certificate (bodies, k, k) with a total trace of 1 for each decision on ranks.
    """
    values, vectors = np.linalg.eigh(Z)
    largest = values.max()
    for cut in CUTS:
        kept = np.where(values > cut * largest, values, 0.0)
        L = _solved(blocks, vectors * np.sqrt(kept / kept.sum())[:, None, :])
        Z = L @ L.transpose(0, 2, 1) / np.sum(L * L)
        yield 0.5 * (Z + Z.transpose(0, 2, 1))


def _solved(blocks: Array, L: Array) -> Array:
    """Factors with ``Σ_b <blocks_bi, L_b L_bᵀ> = 0``.

    A distribution on the edge of the cone makes for a condition like ``|Lᵀ v|² = 0``, a double
    root: every other step is nearly twice that of Newton, which solves those, and all but
    turns the sign of what is left of the others.
    """
    count, n, k = blocks.shape[:3]
    flat = blocks.reshape(count, n * k, k)

    def conditions(x: Array) -> tuple[Array, Array]:
        slope = (flat @ x.reshape(L.shape)).reshape(count, n, k * k)
        half: Array = slope.transpose(1, 0, 2).reshape(n, -1)
        return half @ x, half

    def met(path: Sequence[Iterate]) -> bool:
        residual = path[-1].residual
        return bool(residual @ residual <= SMALL**2)

    last, solved = gauss_newton(
        conditions, L.reshape(-1), _Alternating(), met, never_stop, STEPS
    )
    found: Array = last.x if solved else last.next
    return found.reshape(L.shape)


class _Alternating:
    """Steps of least size with half the Jacobian, times 0.5 and 0.9 in turn."""

    def __init__(self) -> None:
        """The first factor comes first."""
        self._factors = cycle((0.5, 0.9))

    def step(self, residual: Array, jacobian: Array) -> Array:
        """The step, by normal equations that a small ridge makes regular."""
        square = jacobian @ jacobian.T
        square.flat[:: len(square) + 1] += RIDGE * np.einsum("ii->", square) / len(square)
        change = np.linalg.solve(square, residual) @ jacobian
        return np.asarray(next(self._factors) * change)

    def accepts(self, before: Array, after: Array) -> bool:
        """Yes."""
        return True
