"""Decide whether counter-rotors on a set of joints make a linkage feasible.

With the conditions ``A z + Σ_j J_j c_j = 0`` of
`balance.masses.remedies.counter_rotations.counter_rotors`, a set S of joints is feasible if
some z and ``J_j ≥ 0``, j in S, fulfil them with ``P_b(z) ≻ 0`` for all bodies. It is infeasible
if and only if there are weights w of the conditions with

    Aᵀ w ≙ Z,    Z_b ⪰ 0, not all zero,    w·c_j ≥ 0 for every j in S,

because ``0 = w·(A z + Σ J_j c_j) = Σ_b <Z_b, P_b> + Σ_j J_j w·c_j`` would be positive. One
certificate therefore excludes every set in which no joint has ``w·c_j < 0``. Designs and
certificates are checked without the solver.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.designs.certificate import PARAMETERS_PER_TRACE, CertificateCheck
from balance.masses.designs.certificate_search import refine_matrices
from balance.masses.designs.constraints import Program
from balance.masses.designs.feasibility import least_traces, solve_largest_margin
from balance.masses.designs.pseudo_inertia_cone import Cone, cone_of_columns
from balance.masses.remedies.counter_rotations.counter_rotors import RotorConditions
from balance.support.clarabel_adapter import solve_conic
from balance.support.tolerances import (
    CERTIFICATE_MARGIN,
    DESIGN_RESIDUAL,
    FIXED_RANK_RELATIVE,
    ROTOR_WEIGHT_ZERO,
)
from kinematics.numerics.array_types import Array, Flags

# Momentum of a rotor over the sum of all, up to which a design does without it.
ROTOR_UNUSED = 1e-7


class RotorDesign(NamedTuple):
    """A balanced distribution with counter-rotors.

    Attributes:
        z: counted parameters of all bodies (parameters,), in the units of the chain.
        J: momenta of all rotors (k,), not negative.
    """

    z: Array
    J: Array


class RotorCertificate(NamedTuple):
    """A proof that some rotors do not make a linkage feasible.

    Attributes:
        weights: w, one per condition (ρ,).
        matrices: Z, one per body (bodies, k, k).
        excluded: whether w·c_j is not negative, for all rotors (k,): the certificate excludes
            every set of such joints.
    """

    weights: Array
    matrices: Array
    excluded: Flags


def rotor_basis(conditions: RotorConditions, chosen: Sequence[int]) -> tuple[Array, Array]:
    """Compute an orthonormal basis of the balanced distributions with some rotors.

    Args:
        chosen: positions of the rotors.

    Returns:
        Parameters of all bodies (parameters, n), and momenta of the chosen rotors (s, n).
    """
    A = np.column_stack([conditions.bodies, conditions.rotors[:, list(chosen)]])
    _, values, V = np.linalg.svd(A)
    rank = int(np.sum(values > FIXED_RANK_RELATIVE * values.max(initial=0.0)))
    split = conditions.bodies.shape[1]
    return V[rank:, :split].T, V[rank:, split:].T


def decide_rotors(
    conditions: RotorConditions, chosen: Sequence[int]
) -> RotorDesign | RotorCertificate | None:
    """Decide whether counter-rotors on a set of joints make a linkage feasible.

    Args:
        chosen: positions of the rotors.

    Returns:
        A design that `check_rotor_design` accepts, a certificate that
        `check_rotor_certificate` accepts, or None.
    """
    bodies, rotors = rotor_basis(conditions, chosen)
    cone = cone_of_columns(conditions.space, bodies)
    for x, dual in _solutions(cone, rotors):
        if x is not None:
            design = _design(conditions, chosen, bodies @ x, rotors @ x)
            if design is not None and check_rotor_design(conditions, design):
                return design
        for proof in _certificates(conditions, chosen, cone, rotors, dual):
            if check_rotor_certificate(conditions, proof).accepted:
                return proof
    return None


def check_rotor_design(conditions: RotorConditions, design: RotorDesign) -> bool:
    """Check that a design is balanced, and that its bodies and rotors can be built."""
    z, J = design
    size = float(np.linalg.norm(z) + np.linalg.norm(J))
    if not 0.0 < size < np.inf:
        return False
    residual = np.linalg.norm(conditions.bodies @ z + conditions.rotors @ J) / size
    cone = cone_of_columns(conditions.space, z[:, None])
    traces = float(np.einsum("bnii->", cone.blocks))
    least = float(cone.least(cone.linear_at(np.ones(1))).min())
    return bool(
        residual <= DESIGN_RESIDUAL
        and least > DESIGN_RESIDUAL * traces
        and J.min(initial=0.0) >= 0.0
    )


def check_rotor_certificate(
    conditions: RotorConditions, proof: RotorCertificate
) -> CertificateCheck:
    """Check a certificate in plain NumPy; see the module.

    With T the sum of the traces of all P_b and of all J_j of a design in which every
    ``P_b ⪰ t T``, the residual r of ``Aᵀ w ≙ Z``, eigenvalues of Z not below -δ and weights
    of the excluded rotors not below -λ,

        t T Σ tr Z_b  ≤  (3 |r| + δ + λ) T,

    so that t is at most 1e-12 if the certificate is accepted.

    Returns:
        The verdict and its residuals. The eigenvalue is -δ - λ.
    """
    w, Z, excluded = proof
    size = float(np.sqrt(np.einsum("bij,bij->b", Z, Z)).sum())
    if not (np.isfinite(w).all() and np.isfinite(size) and size > 0.0):
        return CertificateCheck(False, -np.inf, np.inf, np.inf)
    every = cone_of_columns(conditions.space, np.eye(conditions.bodies.shape[1]))
    residual = every.sums(Z)
    residual[: conditions.bodies.shape[1]] -= conditions.bodies.T @ w
    negative = max(0.0, -float(np.linalg.eigvalsh(Z)[:, 0].min()))
    negative += max(0.0, -float((conditions.rotors.T @ w)[excluded].min(initial=0.0)))
    negative, mismatch = negative / size, float(np.linalg.norm(residual)) / size
    traces = float(np.einsum("bii->", Z)) / size
    separation = (
        (PARAMETERS_PER_TRACE * mismatch + negative) / traces if traces > 0.0 else np.inf
    )
    accepted = bool(separation <= CERTIFICATE_MARGIN)
    return CertificateCheck(accepted, -negative, mismatch, separation)


def _solutions(cone: Cone, rotors: Array) -> Iterator[tuple[Array | None, Array]]:
    """Solve for the least traces, then for the largest margin: coordinates, and dual."""
    count, n = cone.blocks.shape[:2]
    if n == 0:
        yield None, np.tile(cone.rows(np.eye(cone.size)), count)
        return
    traces = np.einsum("bnii->n", cone.blocks) + rotors.sum(axis=0)
    program = Program(
        cone,
        tuple(range(count)),
        False,
        rotors,
        (),
        (),
        traces,
        1.0,
        cone,
        np.eye(n),
        np.empty((0, n)),
        (),
        np.empty(0),
    )
    q, rows, offset, parts = least_traces(program)
    solution = solve_conic(q, rows, offset, parts)
    yield (None if solution.infeasible else solution.x), solution.dual
    solution = solve_largest_margin(q, rows, offset, parts)
    yield solution.x[:-1], solution.dual[:-1]


def _design(
    conditions: RotorConditions, chosen: Sequence[int], z: Array, J: Array
) -> RotorDesign | None:
    """Project an approximate design onto the conditions, without the rotors it does not use."""
    if not np.isfinite(z).all():
        return None
    total = np.abs(z).sum() + np.abs(J).sum()
    kept = [j for j, value in zip(chosen, J, strict=True) if value > ROTOR_UNUSED * total]
    given = np.concatenate([z, [value for value in J if value > ROTOR_UNUSED * total]])
    basis = np.concatenate(rotor_basis(conditions, kept))
    near = basis @ (basis.T @ given)
    momenta = np.zeros(len(conditions.joints))
    momenta[kept] = near[z.size :]
    return RotorDesign(near[: z.size], momenta)


def _certificates(
    conditions: RotorConditions, chosen: Sequence[int], cone: Cone, rotors: Array, dual: Array
) -> Iterator[RotorCertificate]:
    """Construct certificates from the dual solution of the conic solver."""
    if not np.isfinite(dual).all():
        return
    split = dual.size - len(rotors) if cone.blocks.shape[1] else dual.size
    lifted, count = cone.with_all_moments().blocks, len(cone.blocks)
    Z = cone.duals(dual[:split].reshape(count, -1))
    # A momentum that is not negative is a semidefinite matrix of size 1.
    rows = np.zeros((len(rotors), *lifted.shape[1:]))
    rows[:, : rotors.shape[1], 0, 0] = rotors
    more = np.zeros((len(rotors), cone.size, cone.size))
    if split < dual.size:
        more[:, 0, 0] = np.maximum(dual[split:], 0.0)
    A = np.column_stack([conditions.bodies, conditions.rotors[:, list(chosen)]])
    every = cone_of_columns(conditions.space, np.eye(conditions.bodies.shape[1]))
    for matrices in refine_matrices(np.concatenate([lifted, rows]), np.concatenate([Z, more])):
        sums = every.sums(matrices[:count])[: conditions.bodies.shape[1]]
        target = np.concatenate([sums, matrices[count:, 0, 0]])
        w = np.linalg.lstsq(A.T, target, rcond=FIXED_RANK_RELATIVE)[0]
        weights = conditions.rotors.T @ w
        size = float(np.abs(matrices[:count]).sum())
        yield RotorCertificate(w, matrices[:count], weights >= -ROTOR_WEIGHT_ZERO * size)
