"""Feasibility of a design space: a physically realisable mass distribution, or a certificate.

A body is realisable if its pseudo-inertia is positive definite. These form a cone, so the unit
of mass is free, and a design exists if ``P_b(y) ⪰ 1`` has a solution. The solution with the
least sum of traces has the largest margin, ``1 / Σ tr P_b``. If this problem gives no clear
answer, the margin itself is maximised. Either answer is checked without the solver.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from balance.masses.designs.certificate import (
    CertificateCheck,
    CertificateProof,
    judge_certificate,
)
from balance.masses.designs.certificate_search import (
    certificates_from_dual,
    certificates_within_densities,
    conflict_certificate,
)
from balance.masses.designs.constraints import Constraints, Program, build_program
from balance.masses.designs.density_cone import (
    DensityRows,
    UnitOfMass,
    density_rows,
    split_dual,
    widen,
)
from balance.masses.designs.design_check import (
    DesignCheck,
    check_design,
    density_excess,
    plane_offset,
)
from balance.masses.designs.pseudo_inertia_cone import (
    from_si,
    given_parameters,
    matrices_of,
    to_si,
)
from balance.masses.designs.verdicts import (
    MOTION_IN_DOUBT,
    TOO_NARROW,
    UNCHECKED,
    UNCHECKED_DENSITY,
    UNSETTLED,
    describe_conflict,
    describe_limits,
)
from balance.space.certification.certified_space import CertifiedSpace
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConicSolution, ConstraintBlock, solve_conic
from balance.support.options import Balance
from balance.support.tolerances import KEPT_BODY_RESIDUAL
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.wording import repr_lines

Verdict = Literal["feasible", "infeasible", "undecided"]


@dataclass(frozen=True, eq=False)
class Feasibility:
    """Result of `feasible`: a verdict with its design or certificate.

    Attributes:
        verdict: ``"feasible"``, ``"infeasible"`` or ``"undecided"``.
        y: coordinates in ``space.basis`` of the design with the largest margin and the total
            mass of the file; None if there is none.
        z: parameters (bodies, 10) of that design about the inertial origin, SI units.
        certificate: one symmetric matrix per body; see `check_certificate`.
        multipliers: one number per body, the second part of the certificate.
        margin: the largest t for which ``P_b ⪰ t`` is possible for all bodies when their
            traces add up to 1, in units of the chain; 0 if infeasible.
        residuals: result of the check of the design or of the certificate.
        words: the verdict in one line.
        reason: why it is so, without the verdict and what limits it.
    """

    verdict: Verdict
    y: Array | None
    z: Array | None
    certificate: tuple[Array, ...] | None
    multipliers: Array | None
    margin: float
    residuals: DesignCheck | CertificateCheck | None
    words: str
    reason: str

    def __repr__(self) -> str:
        """One line: the verdict."""
        return repr_lines(f"Feasibility: {self.words}")


def feasible(
    space: DesignSpace | LinkageLike, *, balance: Balance | None = None
) -> Feasibility:
    """Decide whether a design space contains a physically realisable mass distribution.

    A distribution is realisable if all pseudo-inertias are positive definite. The
    design found has the largest margin t with ``P_b ⪰ t`` and ``Σ tr P_b = 1``. Certificates:
    docs/theory/feasibility.md.

    Args:
        space: a design space, or an argument of `design_space`.
        balance: ``"dynamic"``, as by default, or ``"force"``; of a space, what it is for.

    Returns:
        ``"feasible"`` with a design that `check_design` accepts, ``"infeasible"`` with a
        certificate that `check_certificate` accepts, or ``"undecided"``: neither passed its
        check, or there is a design, but not all conditions of the space are known.

    Source:
        P. M. Wensing, S. Kim, J.-J. Slotine, IEEE Robotics and Automation Letters 3(1), 2018
        (pseudo-inertia); S. Boyd, L. Vandenberghe, Convex Optimization, 2004, section 5.8.

    Example:
        >>> import balance
        >>> balance.masses.feasible("robot.urdf").verdict
        'infeasible'
        >>> balance.masses.feasible("robot.urdf", balance="force").verdict
        'feasible'
    """
    return decide_feasibility(as_space(space, balance=balance), Constraints())


def decide_feasibility(
    space: DesignSpace, constraints: Constraints, all_balanced: bool = False
) -> Feasibility:
    """Decide whether a design space contains a realisable distribution under constraints.

    See `feasible`; the design has the largest margin among those of its total trace.

    Args:
        constraints: constraints on the bodies.
        all_balanced: whether every distribution in the space is known to be balanced.

    Returns:
        The verdict; see `feasible`.
    """
    if constraints.densities:
        looser = decide_feasibility(space, constraints._replace(densities={}), all_balanced)
        if looser.z is None:
            return looser
        balanced = space if all_balanced or space.sure else _transfers_alone(space)
        return _limit_densities(balanced, constraints, looser)
    # A certificate for weaker constraints also proves the constraints infeasible.
    less = constraints.anywhere, Constraints(constraints.keep), Constraints()
    dropped = constraints.balls, constraints.bounds, constraints.keep
    weaker = [relaxation for relaxation, without in zip(less, dropped, strict=True) if without]
    for wanted in (constraints, *weaker):
        program = build_program(space, wanted)
        for x, proofs in _candidates(program):
            if x is not None and wanted is constraints:
                if answer := _design(space, constraints, program, x):
                    sure = all_balanced or space.sure
                    return answer if sure else _decide_by_transfers(space, constraints)
            for proof in proofs:
                if answer := _proof(space, constraints, program, proof):
                    return answer
    return _undecided(UNCHECKED)


def _limit_densities(
    space: DesignSpace, constraints: Constraints, looser: Feasibility
) -> Feasibility:
    """Decide feasibility with limits of density.

    Args:
        space: a space of which every distribution is known to be balanced.
        looser: the answer without the limits, which is a design.
    """
    assert looser.z is not None and looser.y is not None
    P = matrices_of(space, looser.z)
    scale = 1.0
    if not constraints.sized:
        scale = min(1.0, 1.0 / density_excess(space, looser.z, constraints))
    z = assemble_design(space, constraints, scale * P)
    check = check_design(space, z, constraints)
    if check.accepted:
        return replace(looser, y=freeze(scale * looser.y), z=z, residuals=check)
    program = build_program(space, constraints)
    for x, proofs in _density_candidates(program, P):
        if x is not None and (answer := _design(space, constraints, program, x)):
            return answer
        for proof in proofs:
            if answer := _proof(space, constraints, program, proof):
                return answer
    return _undecided(UNCHECKED_DENSITY)


def _density_candidates(
    program: Program, P: Array
) -> Iterator[tuple[Array | None, Iterable[CertificateProof]]]:
    """Solve with limits of density, as `_candidates` does without.

    Args:
        P: pseudo-inertias of a design without them (bodies, k, k), kg.
    """
    cone, size = program.cone.with_all_moments(), program.traces.size
    reference = P[list(program.free)] / program.unit
    wide = program._replace(
        cone=cone,
        lines=widen(program.lines, cone.blocks.shape[1]),
        traces=widen(program.traces, cone.blocks.shape[1]),
    )
    # The unit of mass at which ``P_b ⪰ 1``, as the program asks.
    tau = max(1.0, 1.0 / float(np.linalg.eigvalsh(reference)[:, 0].min()))
    limited = sorted(program.densities)
    unit = UnitOfMass(np.eye(cone.blocks.shape[1])[size - 1], 0.0, tau)
    limits = density_rows(
        cone.blocks[limited],
        tau * reference[limited],
        unit,
        [program.densities[b] for b in limited],
    )
    q, rows, offset, parts = least_traces(wide)
    split = len(rows)
    rows = np.concatenate([widen(rows, limits.rows.shape[1]), limits.rows])
    offset, q = np.append(offset, limits.offset), widen(q, limits.rows.shape[1])
    parts += limits.parts
    solution = solve_conic(q, rows, offset, parts)
    dual = solution.dual
    if solution.infeasible:
        yield None, _density_certificates(program, limits, limited, dual[:split], dual[split:])
    else:
        yield solution.x[:size], ()
    solution = solve_largest_margin(q, rows, offset, parts)
    dual = solution.dual[:-1]
    yield (
        solution.x[:size],
        _density_certificates(program, limits, limited, dual[:split], dual[split:]),
    )


def _density_certificates(
    program: Program, limits: DensityRows, limited: Sequence[int], dual: Array, more: Array
) -> Iterator[CertificateProof]:
    """Construct certificates from the multipliers of `least_traces` and of `density_rows`."""
    cone, count = program.cone.with_all_moments(), len(program.free)
    split = count * cone.part.rows
    matrices = cone.duals(dual[:split].reshape(count, -1))
    added, of_limited = split_dual(limits, more)
    matrices[list(limited)] += added
    masses = np.zeros(count)
    masses[list(limited)] = of_limited
    return certificates_within_densities(program, matrices, dual[split:], masses)


def _decide_by_transfers(space: DesignSpace, constraints: Constraints) -> Feasibility:
    """Decide with the inertia transfers alone, for a space that is in doubt.

    Proved inertia transfers are balanced whatever the true space is, if the joints that count
    as idle rest. A design made of them alone is therefore a design, unless it is in doubt which
    joints move; otherwise the verdict is undecided.
    """
    if not (
        isinstance(space, CertifiedSpace) and space.certainty.nullity == space.serial_nullity
    ):
        return _undecided(UNSETTLED)
    if space.certainty.motion_doubts:
        return _undecided(MOTION_IN_DOUBT.format(space.certainty.motion_doubts[0]))
    answer = decide_feasibility(_transfers_alone(space), constraints, True)
    return answer if answer.verdict == "feasible" else _undecided(UNSETTLED)


def _transfers_alone(space: DesignSpace) -> DesignSpace:
    """Return the space of the inertia transfers alone."""
    basis = space.decision.basis[:, : space.serial_nullity]
    return replace(space, decision=space.decision.with_basis(basis))


def _proof(
    space: DesignSpace, constraints: Constraints, program: Program, proof: CertificateProof
) -> Feasibility | None:
    """Return the verdict by a certificate; None if its check rejects it."""
    check = judge_certificate(space, program.whole, proof, constraints)
    if not check.accepted:
        return None
    if not space.encloses:
        return _undecided(TOO_NARROW)
    # Find the weakest constraints for which the certificate holds.
    less = (
        (
            Constraints(),
            Constraints(within=constraints.within, balls=constraints.balls),
            constraints.anywhere._replace(densities={}),
            constraints._replace(densities={}),
            constraints.anywhere,
        )
        if constraints
        else ()
    )
    enough = (
        relaxation
        for relaxation in less
        if judge_certificate(space, program.whole, proof, relaxation).accepted
    )
    constraints = next(enough, constraints)
    reason = describe_conflict(space, proof.matrices, constraints)
    return Feasibility(
        "infeasible",
        None,
        None,
        tuple(freeze(proof.matrices)),
        freeze(proof.multipliers),
        0.0,
        check,
        f"infeasible{describe_limits(constraints)}: {reason}",
        reason,
    )


def _undecided(why: str) -> Feasibility:
    return Feasibility("undecided", None, None, None, None, 0.0, None, f"undecided: {why}", why)


def _candidates(program: Program) -> Iterator[tuple[Array | None, Iterable[CertificateProof]]]:
    """Solve for the least traces, then for the largest margin: a design, or certificates."""
    if program.residual @ program.residual > KEPT_BODY_RESIDUAL**2:
        yield None, [conflict_certificate(program)]
    if program.traces.size == 0:
        cone = program.cone
        every = np.tile(np.eye(cone.size), (len(cone.blocks), 1, 1))
        yield None, [CertificateProof(every, np.zeros(len(every)))]
        return
    q, rows, offset, parts = least_traces(program)
    solution = solve_conic(q, rows, offset, parts, careful=len(program.lines) > 0)
    if solution.infeasible:
        yield None, certificates_from_dual(program, solution.dual)
    else:
        yield solution.x, ()
    solution = solve_largest_margin(q, rows, offset, parts)
    yield solution.x[:-1], certificates_from_dual(program, solution.dual[:-1])


def solve_largest_margin(
    q: Array, rows: Array, offset: Array, parts: Sequence[ConstraintBlock]
) -> ConicSolution:
    """Maximise t with P_b ⪰ t and τ ≥ t, for traces that add up to at most 1.

    Args:
        q: as from `least_traces`, like the other arguments.

    Returns:
        A solution whose last unknown is t.
    """
    extended = np.block([[rows, offset[:, None]], [-q, 0.0]])
    bound = np.append(np.zeros(offset.size), 1.0)
    blocks = [*parts, ConstraintBlock("nonnegative", 1)]
    return solve_conic(np.append(0.0 * q, -1.0), extended, bound, blocks)


def least_traces(program: Program) -> tuple[Array, Array, Array, list[ConstraintBlock]]:
    """Build arguments of `solve_conic`: the least sum of traces with ``P_b ⪰ 1`` and τ ≥ 1."""
    cone, lines = program.cone, program.lines
    count, rows = len(cone.blocks), cone.stack_rows(cone.blocks)
    unit, parts = np.tile(cone.rows(np.eye(cone.size)), count), [cone.part] * count
    if len(lines):
        rows = np.concatenate([rows, lines])
        unit = np.append(unit, program.sized * (np.arange(len(lines)) == 0))
        parts.append(ConstraintBlock("nonnegative", len(lines)))
    return program.traces, rows, -unit, parts


def _design(
    space: DesignSpace, constraints: Constraints, program: Program, x: Array
) -> Feasibility | None:
    """Return the verdict with the design at coordinates x; None if its check rejects it."""
    if not np.isfinite(x).all():
        return None
    least = program.cone.least(program.cone.linear_at(x)).min()
    if not (least > 0.0 and (not program.sized or x[-1] > 0.0)):
        return None
    P = program.whole.at(program.embed @ x)
    margin = float(least / (program.traces @ x))
    # Divide by τ, or scale to the mean mass of the file.
    scale = float(program.unit / (x[-1] if program.sized else P[:, -1, -1].mean()))
    y = scale * (program.embed @ x)
    z = assemble_design(space, constraints, scale * P)
    check = check_design(space, z, constraints)
    if not check.accepted:
        return None
    reason = f"balanced by bodies that can be built, with a margin of {margin:.1e}"
    y = freeze(y[: space.nullity])
    return Feasibility(
        "feasible", y, z, None, None, margin, check, f"feasible: {reason}", reason
    )


def assemble_design(
    space: DesignSpace, constraints: Constraints, P: Array, along: Array | None = None
) -> Array:
    """Convert pseudo-inertias in the coordinates of the chain to parameters in SI units.

    Args:
        constraints: kept bodies are copied from the file; in a plane, the centres of mass of
            the others have their height.
        P: pseudo-inertias (bodies, k, k).
        along: see `to_si`; if given and no body is kept, the centres of mass in a plane have
            the height of those in the file. Bodies whose density is limited are plates.

    Returns:
        Parameters (bodies, 10) about the inertial origin.
    """
    frame, keep = space.chain.frame, list(constraints.keep)
    placed = bool(keep) or along is not None
    flat = [(b, limit.thickness) for b, limit in constraints.densities.items()]
    if space.planar and flat:
        along = np.zeros(len(P)) if along is None else along.copy()
        for b, thickness in flat:
            assert thickness is not None
            along[b] = P[b, -1, -1] * (thickness / frame.length) ** 2 / 12.0
    if not placed:
        return freeze(to_si(P, frame, along=along))
    file = given_parameters(space)
    moving = [b for b in keep or range(len(P)) if space.chain.links[b] >= 0]
    z = to_si(P, frame, plane_offset(from_si(file[moving], frame)), along)
    z[keep] = file[keep]
    return freeze(z)
