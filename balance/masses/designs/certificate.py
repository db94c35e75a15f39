"""Certificates that no mass distribution of a design space is physically realisable.

A linear space does not meet an open convex cone if and only if some hyperplane holds the
space and has the cone on one side. For pseudo-inertias ``P_b ≻ 0`` that hyperplane is one
symmetric matrix per body,

    Z_b ⪰ 0,  not all zero,        Σ_b <Z_b, P_b> = 0  for every balanced distribution,

because the sum would be positive for realisable bodies. A non-zero Z_b weighs its body:
``<L Lᵀ, P> = ∫ |Lᵀ [x; 1]|² dm``. Semidefinite pseudo-inertias, such as those of point masses
and of rods without width, are not excluded. If the mass of a body must be within a ball, which
is ``<G_b, P_b> ≥ 0``, the certificate has a multiplier λ_b ≥ 0 for it, and

    Σ_b <Z_b + λ_b G_b, P_b> = 0  for every balanced distribution.

If the density of a body is limited (`balance.masses.designs.density`), its Z_b need not be
positive semidefinite. Let S be its block of second moments and s the Schur complement of S in
Z_b, and let C be the second moments of the body about its centre of mass. Then

    <Z_b, P_b>  ≥  <S, C> + s m  ≥  d det(S)^{1/d} det(C)^{1/d} + s m
                                 ≥  d det(S)^{1/d} κ m^{1+2/d} + s m

because a square is left out, by the means of the eigenvalues of ``S^½ C S^½``, and by the
limit. The least value of the last expression over the masses that the bounds allow is a known
term, like the products of kept bodies.

(Theorems of alternatives: S. Boyd, L. Vandenberghe, Convex Optimization, 2004, section 5.8.)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.designs.constraints import Constraints
from balance.masses.designs.density import mass_where_least
from balance.masses.designs.pseudo_inertia_cone import (
    Cone,
    cone_of,
    given_parameters,
    matrices_of,
)
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    CERTIFICATE_MARGIN,
    FIXED_RANK_RELATIVE,
    MASS_MULTIPLIER_RELATIVE,
)
from kinematics.loading.model_gallery import LinkageLike
from kinematics.numerics.array_types import Array
from kinematics.wording import check_summary

# Bound on the norm of a body's parameters over the trace of its pseudo-inertia.
PARAMETERS_PER_TRACE = 3.0


class CertificateProof(NamedTuple):
    """A certificate: the dual variables that exclude every design.

    Attributes:
        matrices: Z, one symmetric matrix per body (bodies, k, k).
        multipliers: λ, one number per body (bodies,), 0 where no ball limits its mass.
    """

    matrices: Array
    multipliers: Array


class CertificateCheck(NamedTuple):
    """Result of `check_certificate`.

    Attributes:
        accepted: whether the certificate excludes every design with a margin above 1e-12.
        eigenvalue: smallest eigenvalue of the matrices of bodies that are not kept, after the
            multipliers of mass bounds are subtracted, over the sum of the Frobenius norms.
        orthogonality: norm of ``Σ_b <Z_b + λ_b G_b, P_b>`` as a function on the orthonormal
            basis of the design space, over the same sum.
        separation: the certificate excludes designs with a larger margin. The margin is the
            smallest eigenvalue of all P_b over the sum T of their traces; with kept bodies
            or least masses, whose traces add up to T0, it is also at most T0 over T.
    """

    accepted: bool
    eigenvalue: float
    orthogonality: float
    separation: float

    def __repr__(self) -> str:
        """One line: whether it is accepted, and its residuals to three digits."""
        return check_summary(self)


def check_certificate(
    space: DesignSpace | LinkageLike,
    certificate: Sequence[Array],
    constraints: Constraints | None = None,
    multipliers: ArrayLike | None = None,
) -> CertificateCheck:
    """Check a certificate of infeasibility in plain NumPy, without the solver.

    With the residual r of orthogonality, and no eigenvalue below -δ, the margin of any design
    is at most ``(3 |r| + δ) / Σ tr Z_b``, which must not exceed 1e-12. If all P_b ⪰ t T, where
    T is the sum of their traces, then

        t T Σ tr Z_b - δ T  ≤  Σ_b <Z_b, P_b>  ≤  Σ_b <Z_b + λ_b G_b, P_b>  ≤  3 |r| T.

    If the mass of a body is bounded, its Z_b need be positive semidefinite only after a
    multiplier λ is subtracted from its last diagonal entry. ``<Z_b, P_b>`` then contains λ
    times the mass, which is at least λ times the least mass, or the largest mass if λ < 0. The
    matrix of a kept body is arbitrary, because ``<Z_b, P_b>`` is known. The sum K of these
    known terms must not be negative. It is added to ``t T Σ tr Z_b``, where Z_b is the
    remaining matrix. A body whose density is limited adds the least value of ``<Z_b, P_b>``
    that the limit allows, and no remaining matrix. Bounds and densities that the proof does not
    need are ignored. If it gives weight only to kept bodies and to those with a limit, it
    excludes designs of every margin, and the separation is 0.

    Args:
        space: the design space, or the linkage, its path or its name.
        certificate: one symmetric matrix per body, in the coordinates of ``space.chain``:
            (4, 4), or (3, 3) in a plane.
        constraints: kept bodies, mass bounds, balls and densities, from ``Design.constraints``;
            none by default.
        multipliers: λ ≥ 0, one number per body; zeros by default. Only bodies whose mass must
            be within a ball may have one that is not zero.

    Returns:
        The verdict on the certificate and its residuals.

    Raises:
        ValueError: the shape of the matrices or of the multipliers is wrong.

    Source:
        S. Boyd, L. Vandenberghe, Convex Optimization, 2004, section 5.8.

    Example:
        >>> import balance, kinematics
        >>> space = balance.design_space(kinematics.load("robot.urdf"))
        >>> answer = balance.masses.feasible(space)
        >>> answer.verdict
        'infeasible'
        >>> balance.checks.check_certificate(space, answer.certificate).accepted
        True
    """
    space, Z = as_space(space), np.array(certificate, dtype=np.float64)
    if multipliers is None:
        multipliers = np.zeros(len(Z))
    return judge_certificate(
        space,
        cone_of(space),
        CertificateProof(Z, np.array(multipliers, np.float64)),
        constraints or Constraints(),
    )


def judge_certificate(
    space: DesignSpace, cone: Cone, proof: CertificateProof, constraints: Constraints
) -> CertificateCheck:
    """Check a certificate, with the cone of the design space at hand; see `check_certificate`.

    Args:
        cone: its cone, from `balance.masses.designs.pseudo_inertia_cone.cone_of`.
        constraints: kept bodies, mass bounds, balls and densities.

    Raises:
        ValueError: the shape of the matrices or of the multipliers is wrong.
    """
    Z, multipliers = proof
    if Z.shape != (len(cone.blocks), cone.size, cone.size):
        raise ValueError(f"certificate of shape {Z.shape}: give one matrix for each body")
    if multipliers.shape != Z.shape[:1]:
        raise ValueError(f"multipliers of shape {multipliers.shape}: give one for each body")
    matrices = np.isfinite(Z).all() and (Z == Z.transpose(0, 2, 1)).all() and Z.any()
    numbers = np.isfinite(multipliers).all() and (multipliers >= 0.0).all()
    if not (
        matrices and numbers and set(np.flatnonzero(multipliers)) <= set(constraints.balls)
    ):
        return CertificateCheck(False, -np.inf, np.inf, np.inf)
    light = constraints._replace(densities={})
    checks = [_check(space, cone, proof, light._replace(bounds={}))]
    if constraints.bounds:
        checks.append(_check(space, cone, proof, light))
    if constraints.densities and constraints.sized:
        checks.append(_check(space, cone, proof, constraints))
        checks += _check_all_densities(space, cone, proof, constraints)
    # Each check proves infeasibility: a certificate need not use the bounds and densities.
    return min(checks, key=lambda check: check.separation)


def _check(
    space: DesignSpace, cone: Cone, proof: CertificateProof, constraints: Constraints
) -> CertificateCheck:
    """Check a certificate with all bounds of the constraints."""
    Z, multipliers = proof
    rest, known_part = (
        _split_known_terms(space, Z, constraints) if constraints.sized else (Z, 0.0)
    )
    whole = Z.copy()
    for b, ball in constraints.balls.items():
        whole[b] += multipliers[b] * ball.form
    residual = cone.sums(whole)
    size = float(np.sqrt(np.einsum("bij,bij->b", Z, Z)).sum())
    traces = float(np.einsum("bii->", rest)) / size
    eigenvalue = float(np.linalg.eigvalsh(rest)[:, 0].min()) / size
    orthogonality, known_part = float(np.sqrt(residual @ residual)) / size, known_part / size
    doubt = PARAMETERS_PER_TRACE * orthogonality + max(0.0, -eigenvalue) + max(0.0, -known_part)
    separation = (
        doubt / (traces + max(0.0, known_part)) if traces + known_part > 0.0 else np.inf
    )
    accepted = bool(separation <= CERTIFICATE_MARGIN)
    return CertificateCheck(accepted, eigenvalue, orthogonality, separation)


def _check_all_densities(
    space: DesignSpace, cone: Cone, proof: CertificateProof, constraints: Constraints
) -> list[CertificateCheck]:
    """Check a certificate whose bodies are all kept or have a limit of density.

    The residual r is a function of these bodies alone. With σ the smallest singular value of
    their pseudo-inertias as functions of the coordinates, and T_S the sum of their traces, it
    is at most ``|r| / σ T_S``. Therefore no design is left, of whatever margin, if the known
    terms of the matrices ``Z_b - |r| / σ`` are positive.

    Returns:
        The result if no design is left; else nothing.
    """
    Z, multipliers = proof
    whole = Z.copy()
    for b, ball in constraints.balls.items():
        whole[b] += multipliers[b] * ball.form
    weighed = np.flatnonzero(whole.any(axis=(1, 2)))
    if not set(weighed.tolist()) <= {*constraints.keep, *constraints.densities}:
        return []
    size = float(np.sqrt(np.einsum("bij,bij->b", Z, Z)).sum())
    lifted = cone.with_all_moments()
    residual, blocks = lifted.sums(whole), lifted.blocks[weighed]
    orthogonality = float(np.sqrt(residual @ residual))
    columns = blocks.transpose(0, 2, 3, 1).reshape(-1, blocks.shape[1])
    values = np.linalg.svd(columns, compute_uv=False)
    least = values[values > FIXED_RANK_RELATIVE * values[0]].min()
    lowered = Z[weighed] - orthogonality / least * np.eye(cone.size)
    file = matrices_of(space, given_parameters(space))
    terms = []
    for b, matrix in zip(weighed.tolist(), lowered, strict=True):
        if b in constraints.keep:
            terms.append(float(np.sum(matrix * file[b])))
            continue
        if np.linalg.eigvalsh(matrix[:-1, :-1])[0] <= MASS_MULTIPLIER_RELATIVE * size:
            return []
        terms.append(_least_product(space, matrix, constraints, b)[1])
    if not sum(terms) > CERTIFICATE_MARGIN * float(np.abs(terms).sum()):
        return []
    return [CertificateCheck(True, 0.0, orthogonality / size, 0.0)]


def _split_known_terms(
    space: DesignSpace, Z: Array, constraints: Constraints
) -> tuple[Array, float]:
    """Split ``Σ_b <Z_b, P_b>`` into known terms and the matrices of the rest.

    The traces of a design add up to T, at least the T0 of kept bodies and of least masses.
    The certificate holds if ``Σ_b <rest_b, P_b> + known_part`` is positive. A mass bound adds λ
    times its value to the known terms, for the λ subtracted from the corner of its Z_b. A
    negative λ must be subtracted. A positive λ is subtracted only as far as the known terms
    need it, since a positive trace excludes more designs than a known mass. A body whose
    density is limited is a known term if its mass has a lower bound, or if Z_b is not definite.

    Returns:
        The matrices rest_b (bodies, k, k), and the known part per unit of T0.
    """
    file, keep = matrices_of(space, given_parameters(space)), list(constraints.keep)
    rest, known_part = Z.copy(), float(np.sum(Z[keep] * file[keep]))
    positive, limited = [], set()
    for b in constraints.densities:
        low = constraints.bounds.get(b, (0.0, np.inf))[0]
        if Z[b].any() and (low > 0.0 or _surplus(Z[b]) < 0.0):
            rest[b], value = _least_product(space, Z[b], constraints, b)
            known_part += value
            limited.add(b)
    for b, (low, high) in constraints.bounds.items():
        if b in limited:
            continue
        surplus = _surplus(Z[b])
        if surplus < 0.0:
            rest[b, -1, -1] -= surplus
            known_part += surplus * high
        elif low > 0.0:
            positive.append((b, surplus, low))
    gain = sum(surplus * low for _, surplus, low in positive)
    share = min(1.0, max(0.0, -known_part / gain)) if gain > 0.0 else 0.0
    for b, surplus, _ in positive:
        rest[b, -1, -1] -= share * surplus
    known_part += share * gain
    rest[keep] = 0.0
    least = float(np.einsum("bii->", file[keep])) + sum(
        low for low, _ in constraints.bounds.values()
    )
    if least > 0.0:
        return rest, known_part / least
    return rest, -np.inf if known_part < 0.0 else 0.0


def _least_product(
    space: DesignSpace, Z: Array, constraints: Constraints, b: int
) -> tuple[Array, float]:
    """Compute the least of ``<Z - rest, P>`` for a body whose density is limited.

    Args:
        Z: matrix of the body.
        b: its position.

    Returns:
        The remaining matrix, which is round-off that makes S definite, and the least value.
    """
    d = len(Z) - 1
    kappa = constraints.densities[b].least_moment / space.chain.frame.length**2
    low, high = constraints.bounds.get(b, (0.0, np.inf))
    values = np.linalg.eigvalsh(Z[:d, :d])
    definite = MASS_MULTIPLIER_RELATIVE * float(np.abs(Z).max())
    slack = max(0.0, definite - float(values[0]))
    rest = np.zeros_like(Z)
    rest[range(d), range(d)] = -slack
    values = values + slack
    S, w = Z[:d, :d] + slack * np.eye(d), Z[:d, -1]
    per_mass = float(Z[-1, -1] - w @ np.linalg.solve(S, w))
    area = d * kappa * float(np.exp(np.log(values).mean()))
    m = min(max(mass_where_least(per_mass, area, d), low), high)
    return rest, per_mass * m + area * m ** (1.0 + 2.0 / d)


def _surplus(Z: Array) -> float:
    """Compute the largest λ with ``Z - λ e eᵀ ⪰ 0``, where e is the last unit vector.

    It is 0 if round-off makes the rest of the matrix singular.
    """
    S, w, slack = Z[:-1, :-1], Z[:-1, -1], MASS_MULTIPLIER_RELATIVE * float(np.abs(Z).max())
    if slack == 0.0:
        return 0.0
    try:
        surplus = float(Z[-1, -1] - w @ np.linalg.solve(S + slack * np.eye(len(S)), w))
    except np.linalg.LinAlgError:
        return 0.0
    return surplus if abs(surplus) > slack else 0.0
