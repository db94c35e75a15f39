"""Whether any mass distribution of a design space can be built: a design, or a proof of none.

The bodies can be built if all pseudo-inertias are positive definite. That is a cone, so the
unit is free, and the question is whether ``P_b(y) ⪰ 1`` has a solution: the one with the least
sum of traces is also the one with the largest margin, ``1 / Σ tr P_b``. Where the solver is
not clear, the margin itself is maximised. Either answer is checked without the solver.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.certification.certified_space import CertifiedSpace
from balance.designs.certificate import (
    CertificateCheck,
    CertificateProof,
    certificates,
    conflicting_bodies,
    judge_certificate,
)
from balance.designs.clarabel_adapter import ConstraintBlock, solve_conic
from balance.designs.constraints import Constraints, Program, program
from balance.designs.mass_regions import reach_of
from balance.designs.pseudo_inertia_cone import (
    from_si,
    given_parameters,
    matrices_of,
    parameters_by_body,
    to_si,
)
from balance.designs.verdicts import TOO_NARROW, UNSETTLED, describe_conflict
from balance.spaces.design_space_result import DesignSpace
from kinematics.linalg.vectors import project_out
from kinematics.model.arrays import freeze
from kinematics.spatial.inertia import from_pseudo_inertia
from kinematics.wording import check_summary, repr_lines

__all__ = [
    "DesignCheck",
    "Feasibility",
    "Verdict",
    "decide_feasibility",
    "assemble_design",
    "check_design",
    "feasible",
    "plane_offset",
    "least_traces",
    "out_of_plane_asymmetry",
]

Array = NDArray[np.float64]
Verdict = Literal["feasible", "infeasible", "undecided"]

# A design must fulfil the conditions to this part of its size, and have a margin above it.
BALANCED = 1e-12
# Round-off of parameters about a far origin, per square of its distance in units of the chain.
ROUND_OFF = 1e-15
# Masses in files are rounded: kept bodies may miss conditions by this part of their size.
ROUNDED = 1e-9
# The solver heeds bounds and the radii of balls to this part of them.
WITHIN = 1e-8


class DesignCheck(NamedTuple):
    """What the check of a design found.

    Attributes:
        accepted: whether it lies in the design space to 1e-12 and has a margin above that; or
            to the round-off of parameters about an inertial origin that is far away.
        conditions: distance from the design space over the size of the design, lengths in
            characteristic lengths; in a plane also how far the bodies are from having one
            plane of symmetry parallel to the motion.
        eigenvalue: smallest one of the pseudo-inertias over the sum of their traces.
        reach: largest root mean square distance of a body's mass from the centre of the ball
            in which it is to be, over the radius; 0 if there are no balls.
    """

    accepted: bool
    conditions: float
    eigenvalue: float
    reach: float = 0.0

    def __repr__(self) -> str:
        """One line: whether it is accepted, and its residuals to three digits."""
        return check_summary(self)


@dataclass(frozen=True, eq=False)
class Feasibility:
    """The verdict on a design space.

    Attributes:
        verdict: ``"feasible"``, ``"infeasible"`` or ``"undecided"``.
        y: coordinates in ``space.basis`` of the design with the largest margin, its masses
            adding up to those of the file; None if there is none.
        z: parameters (bodies, 10) of that design about the inertial origin, SI units.
        certificate: one symmetric matrix per body; see `check_certificate`.
        multipliers: one number per body that goes with the certificate.
        margin: the largest t for which ``P_b ⪰ t`` is possible for all bodies when their
            traces add up to 1, in units of the chain; 0 if infeasible.
        residuals: what the check of the design or of the certificate found.
        words: the verdict in one line.
    """

    verdict: Verdict
    y: Array | None
    z: Array | None
    certificate: tuple[Array, ...] | None
    multipliers: Array | None
    margin: float
    residuals: DesignCheck | CertificateCheck | None
    words: str

    def __repr__(self) -> str:
        """One line: the verdict."""
        return repr_lines(f"Feasibility: {self.words}")


def feasible(space: DesignSpace) -> Feasibility:
    """Whether a design space holds a distribution that can be built.

    Args:
        space: a design space.

    Returns:
        ``"feasible"`` with a design that `check_design` accepts, ``"infeasible"`` with a
        certificate that `check_certificate` accepts, or ``"undecided"``: neither stood up to
        its check, or there is a design, but not all conditions of the space are known.
    """
    return decide_feasibility(space, Constraints())


def decide_feasibility(
    space: DesignSpace, asked: Constraints, trusted: bool = False
) -> Feasibility:
    """Whether a design space holds a distribution that fulfils a restriction.

    See `feasible`; the design has the largest margin among those of its total trace.

    Args:
        space: the design space.
        asked: the restriction on the bodies.
        trusted: whether every distribution in the space is known to be balanced.
    """
    # A certificate for a weaker restriction is one for the restriction itself.
    less = asked.anywhere, Constraints(asked.keep), Constraints()
    dropped = asked.balls, asked.bounds, asked.keep
    weaker = [one for one, without in zip(less, dropped, strict=True) if without]
    for wanted in (asked, *weaker):
        question = program(space, wanted)
        for x, proofs in _candidates(question):
            if x is not None and wanted is asked:
                if found := _design(space, asked, question, x):
                    sure = trusted or space.sure
                    return found if sure else _decide_by_transfers(space, asked)
            for proof in proofs:
                if found := _proof(space, asked, question, proof):
                    return found
    return _undecided(
        "neither a design nor a certificate stands up to its check; ask less of the masses, or "
        "put the linkage nearer to the origin"
    )


def _decide_by_transfers(space: DesignSpace, asked: Constraints) -> Feasibility:
    """The verdict where there is a design, but the space is in doubt.

    Proved inertia transfers are balanced whatever the true space is, so a design made of them
    alone stands; otherwise the verdict is undecided.
    """
    serial = space.serial_nullity
    if not (isinstance(space, CertifiedSpace) and space.certainty.nullity == serial):
        return _undecided(UNSETTLED)
    decision = replace(space.decision, basis=space.decision.basis[:, :serial])
    found = decide_feasibility(
        replace(space, basis=space.serial, decision=decision), asked, True
    )
    return found if found.verdict == "feasible" else _undecided(UNSETTLED)


def _proof(
    space: DesignSpace, asked: Constraints, question: Program, proof: CertificateProof
) -> Feasibility | None:
    """The verdict by a proof; None if it proves nothing."""
    check = judge_certificate(space, question.whole, proof, asked)
    if not check.accepted:
        return None
    if not space.encloses:
        return _undecided(TOO_NARROW)
    # The least that is to be asked for the proof to hold.
    less = (Constraints(), asked._replace(keep=(), bounds={}), asked.anywhere) if asked else ()
    enough = (
        one for one in less if judge_certificate(space, question.whole, proof, one).accepted
    )
    text = describe_conflict(space, proof.matrices, next(enough, asked))
    return Feasibility(
        "infeasible", None, None, tuple(freeze(proof.matrices)), freeze(proof.multipliers),
        0.0, check, text,
    )  # fmt: skip


def _undecided(why: str) -> Feasibility:
    return Feasibility("undecided", None, None, None, None, 0.0, None, f"undecided: {why}")


def check_design(
    space: DesignSpace, z: ArrayLike, asked: Constraints | None = None
) -> DesignCheck:
    """Check a design in plain NumPy, without the solver.

    Args:
        space: the design space.
        z: parameters (bodies, 10) about the inertial origin, SI units.
        asked: what else is asked of the bodies. Kept ones must be as in the file, where
            masses are rounded: the conditions need then hold to 1e-9 only, and these bodies
            need not be definite. Bounds and the radii of balls must hold to 1e-8 of them.
    """
    asked = asked or Constraints()
    z = np.reshape(z, (len(space.bodies), 10))
    P = from_si(z, space.chain.frame)
    own = from_pseudo_inertia(P)
    part, Q = own[:, parameters_by_body(space)].reshape(-1), space.scaled_basis
    left = project_out(part, Q)
    conditions = float(np.linalg.norm(left) / (np.linalg.norm(part) or 1.0))
    if space.planar and space.balance == "dynamic":
        conditions = max(conditions, out_of_plane_asymmetry(P[space.chain.links >= 0]))
    total = float(np.einsum("bii->", P))
    if not (np.isfinite(own).all() and total > 0.0):
        return DesignCheck(False, conditions, -np.inf)
    free = [b for b in range(len(P)) if b not in asked.keep]
    eigenvalue = float(np.linalg.eigvalsh(P[free]).min()) / total
    origin = space.chain.frame.origin / space.chain.frame.length
    doubt = max(BALANCED, ROUND_OFF * float(origin @ origin))
    balanced = conditions <= max(doubt, ROUNDED if asked.keep else 0.0)
    flat = matrices_of(space, z)
    furthest = max((reach_of(ball, flat[b]) for b, ball in asked.balls.items()), default=0.0)
    accepted = (
        balanced and eigenvalue > doubt and furthest <= 1.0 + WITHIN and _heeds(space, z, asked)
    )
    return DesignCheck(accepted, conditions, eigenvalue, furthest)


def _heeds(space: DesignSpace, z: Array, asked: Constraints) -> bool:
    """Whether a design keeps what it is to keep, and its masses within bounds."""
    within = all(
        low * (1.0 - WITHIN) <= z[b, 0] <= high * (1.0 + WITHIN)
        for b, (low, high) in asked.bounds.items()
    )
    return within and all(
        np.array_equal(z[b], space.linkage.bodies[b].inertia) for b in asked.keep
    )


def out_of_plane_asymmetry(P: Array) -> float:
    """How far bodies are from one plane of symmetry, relative to their size.

    Args:
        P: pseudo-inertias (bodies, 4, 4) in the coordinates of a planar chain.
    """
    lift = np.eye(4)
    lift[2, 3] = -plane_offset(P)
    size = np.linalg.norm(P) or 1.0
    return float(np.linalg.norm((lift @ P @ lift.T)[:, 2, [0, 1, 3]]) / size)


def plane_offset(P: Array) -> float:
    """Height of the common centre of mass of pseudo-inertias (bodies, 4, 4) above a plane."""
    return float(P[:, 2, 3].sum() / (P[:, 3, 3].sum() or 1.0))


def _candidates(question: Program) -> Iterator[tuple[Array | None, Iterable[CertificateProof]]]:
    """Coordinates of a design, or certificates: of one problem, and then of another."""
    if question.left @ question.left > ROUNDED**2:
        yield None, [conflicting_bodies(question)]
    if question.traces.size == 0:
        cone = question.cone
        every = np.tile(np.eye(cone.size), (len(cone.blocks), 1, 1))
        yield None, [CertificateProof(every, np.zeros(len(every)))]
        return
    q, rows, offset, parts = least_traces(question)
    found = solve_conic(q, rows, offset, parts, careful=len(question.lines) > 0)
    if found.infeasible:
        yield None, certificates(question, found.dual)
    else:
        yield found.x, ()
    # The largest t with P_b ⪰ t, and τ ≥ t, when all traces add up to at most 1.
    wide = np.block([[rows, offset[:, None]], [-q, 0.0]])
    room = np.append(np.zeros(offset.size), 1.0)
    found = solve_conic(
        np.append(0.0 * q, -1.0), wide, room, [*parts, ConstraintBlock("line", 1)]
    )
    yield found.x[:-1], certificates(question, found.dual[:-1])


def least_traces(question: Program) -> tuple[Array, Array, Array, list[ConstraintBlock]]:
    """The least sum of traces with ``P_b ⪰ 1`` and τ ≥ 1, as arguments of `solve_conic`."""
    cone, lines = question.cone, question.lines
    count, rows = len(cone.blocks), cone.stacked(cone.blocks)
    unit, parts = np.tile(cone.rows(np.eye(cone.size)), count), [cone.part] * count
    if len(lines):
        rows = np.concatenate([rows, lines])
        unit = np.append(unit, question.sized * (np.arange(len(lines)) == 0))
        parts.append(ConstraintBlock("line", len(lines)))
    return question.traces, rows, -unit, parts


def _design(
    space: DesignSpace, asked: Constraints, question: Program, x: Array
) -> Feasibility | None:
    """The verdict on coordinates, if they are those of a design."""
    if not np.isfinite(x).all():
        return None
    least = question.cone.least(question.cone.sums_at(x)).min()
    if not (least > 0.0 and (not question.sized or x[-1] > 0.0)):
        return None
    P = question.whole.at(question.embed @ x)
    margin = float(least / (question.traces @ x))
    # Per unit of mass; or so that bodies have the mean mass of the file.
    scale = float(question.unit / (x[-1] if question.sized else P[:, -1, -1].mean()))
    y = scale * (question.embed @ x)
    z = assemble_design(space, asked, scale * P)
    check = check_design(space, z, asked)
    if not check.accepted:
        return None
    text = f"feasible: balanced by bodies that can be built, with a margin of {margin:.1e}"
    y = freeze(y[: space.nullity])
    return Feasibility("feasible", y, z, None, None, margin, check, text)


def assemble_design(
    space: DesignSpace, asked: Constraints, P: Array, along: Array | None = None
) -> Array:
    """Parameters (bodies, 10) of pseudo-inertias in the coordinates of the chain, SI units.

    Args:
        space: the design space.
        asked: bodies that are kept are those of the file; in a plane, the others have their
            centres at the same height.
        P: pseudo-inertias (bodies, k, k).
        along: see `to_si`.
    """
    frame, keep = space.chain.frame, list(asked.keep)
    if not keep:
        return freeze(to_si(P, frame, 0.0, along))
    file = given_parameters(space)
    moving = [b for b in keep if space.chain.links[b] >= 0]
    z = to_si(P, frame, plane_offset(from_si(file[moving], frame)), along)
    z[keep] = file[keep]
    return freeze(z)
