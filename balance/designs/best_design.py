"""A mass distribution that can be built and does not shake, the best one for some purpose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from balance.certification.certified_space import CertifiedSpace
from balance.certification.certify_space import certify
from balance.designs.certificate import CertificateCheck
from balance.designs.constraints import Constraints, constraints_of, program
from balance.designs.feasibility import (
    ROUNDED,
    DesignCheck,
    Verdict,
    assemble_design,
    check_design,
    decide_feasibility,
    out_of_plane_asymmetry,
)
from balance.designs.mass_regions import BALL_RADIUS, Ball
from balance.designs.objectives import Objective, minimise_objective
from balance.designs.pseudo_inertia_cone import from_si, given_parameters, matrices_of
from balance.designs.verdicts import describe_furthest, describe_limits
from balance.inertial_parameters.body_inertia import BodyInertia, body_inertias
from balance.inertial_parameters.conversions import LABELS
from balance.spaces.compute import design_space
from balance.spaces.design_space_result import DesignSpace
from kinematics.wording import repr_lines

__all__ = ["DESIGN_SCHEMA", "Design", "Objective", "design"]

Array = NDArray[np.float64]

DESIGN_SCHEMA = "balance.design/2"


@dataclass(frozen=True, eq=False)
class Design:
    """A design, or why there is none.

    Attributes:
        space: the design space; spatial if bodies that are kept are off the plane.
        verdict: ``"feasible"``, ``"infeasible"`` or ``"undecided"``.
        minimise: the objective.
        value: its value in SI units (see `design`), None without an objective or a design.
        keep: names of the bodies held as the file gives them.
        bounds: least and largest mass of a body, kg.
        within: radius of the ball about the joints of each link that is not kept, in which
            its mass is to be, in lengths of the link; None if it may be anywhere.
        z: parameters (bodies, 10) about the inertial origin, SI units; None if there is
            no design.
        certificate: one symmetric matrix per body; see `check_certificate`.
        multipliers: one number per body that goes with the certificate.
        margin: smallest eigenvalue of the pseudo-inertias over the sum of their traces, in
            units of the chain.
        residuals: what the check of the design or of the certificate found.
        words: the verdict in one line.
        anywhere: the answer if masses may be anywhere, where none is within the balls, but
            that does not settle the other.
    """

    space: DesignSpace
    verdict: Verdict
    minimise: Objective | None
    value: float | None
    keep: tuple[str, ...]
    bounds: Mapping[str, tuple[float, float]]
    within: float | None
    z: Array | None
    certificate: tuple[Array, ...] | None
    multipliers: Array | None
    margin: float
    residuals: DesignCheck | CertificateCheck | None
    words: str
    anywhere: Design | None = None

    @property
    def asked(self) -> Constraints:
        """What was asked, as `check_design` and `check_certificate` take it."""
        return constraints_of(self.space, self.keep, self.bounds, self.within)

    @property
    def balls(self) -> dict[str, Ball]:
        """Where the mass of each body was to be, metres, inertial frame; see `Ball`.

        The disc of a planar linkage is drawn at the height of the middle of the mechanism.
        """
        frame, names = self.space.chain.frame, self.space.bodies
        return {
            names[b]: Ball(
                frame.length * ball.centre @ frame.R[: ball.centre.size] + frame.origin,
                frame.length * ball.radius,
            )
            for b, ball in self.asked.balls.items()
        }

    def __repr__(self) -> str:
        """Up to six lines: the verdict, and the mass of each body."""
        bodies = (f"{body.name} {body.mass:.4g} kg" for body in self.bodies)
        return repr_lines(f"Design for {self.space.linkage.name}", self.words, *bodies)

    @property
    def bodies(self) -> tuple[BodyInertia, ...]:
        """The bodies in a designer's terms; empty if there is no design."""
        if self.z is None:
            return ()
        space, size = self.space, 2.0 ** np.round(np.log2(np.linalg.norm(self.z)))
        return body_inertias(
            space.bodies, self.z.reshape(-1, 1) / size, [size], space.frames, space.axes,
            LABELS, space.length, space.source,
        )  # fmt: skip

    def to_dict(self) -> dict[str, object]:
        """The design as plain data, ready for JSON."""
        return {
            "schema": DESIGN_SCHEMA,
            "model": self.space.linkage.name,
            "at": self.space.linkage.at,
            "algebra": "planar" if self.space.planar else "spatial",
            "balance": self.space.balance,
            "verdict": self.verdict,
            "minimise": self.minimise,
            "value": self.value,
            "keep": list(self.keep),
            "bounds": {
                name: [low, high if high < inf else None]
                for name, (low, high) in self.bounds.items()
            },
            "within": self.within,
            "balls": {
                name: {"centre": ball.centre.tolist(), "radius": ball.radius}
                for name, ball in self.balls.items()
            },
            "margin": self.margin,
            "residuals": self.residuals._asdict() if self.residuals else None,
            "words": self.words,
            "certificate": [Z.tolist() for Z in self.certificate] if self.certificate else None,
            "multipliers": None if self.multipliers is None else self.multipliers.tolist(),
            "bodies": [_as_data(body) for body in self.bodies],
            "anywhere": self.anywhere.to_dict() if self.anywhere else None,
        }


def _as_data(body: BodyInertia) -> dict[str, object]:
    assert body.com is not None and body.link_com is not None and body.link_inertia is not None
    return {
        "name": body.name,
        "mass": body.mass,
        "com": body.com.tolist(),
        "link_com": body.link_com.tolist(),
        "link_inertia": body.link_inertia.tolist(),
        "moments": np.linalg.eigvalsh(body.link_inertia).tolist(),
        "z": body.z.tolist(),
    }


def design(
    space: DesignSpace,
    minimise: Objective | None = None,
    *,
    keep: Sequence[str] = (),
    bounds: Mapping[str, tuple[float, float]] | None = None,
    within: float | None = BALL_RADIUS,
) -> Design:
    """The best design of a space, or a certificate that there is none.

    In a plane all centres of mass are put at one height, and the plane is a plane of symmetry
    of every body, so that all six components of the momentum vanish: bodies are discs. If
    bodies that are kept do not allow for that, all ten parameters are conditioned.

    The mass of each body that is not kept is within a ball about the joints of its link, in a
    plane a disc; see `balance.designs.mass_regions.ball_of`. Where that leaves no design, the
    answer without balls is given too; what has none anywhere has none in them.

    Args:
        space: a design space.
        minimise: ``"mass"``: total mass, kg; ``"inertia"``: the largest principal moment of
            inertia of any body that is not kept, about the origin of its link frame, kg m²;
            ``"rotor"``: trace of the inertia matrix that the coordinates of the motion feel
            at the reference pose, kg m², those that slide counted in characteristic lengths
            (``space.length``, in metres);
            ``"change"``: distance from the masses in the file, without a unit. See
            `balance.designs.objectives` for what bounds each. By default, the margin is
            maximised.
        keep: bodies that stay as the file gives them.
        bounds: least and largest mass of bodies, kg.
        within: radius of the balls, in lengths of the links; None for masses anywhere.

    Raises:
        BodyError: a body is unknown, its bounds contradict each other, it is kept and
            bounded, or the change is measured from one that is singular.
        LinkageError: all bodies are kept.
        ValueError: there is no such objective, or the radius is not above 0.
    """
    if minimise is not None and minimise not in get_args(Objective):
        raise ValueError(f"minimise must be one of {', '.join(get_args(Objective))}")
    bounds = dict(bounds or {})
    asked = constraints_of(space, keep, bounds, within)
    if space.planar and space.balance == "dynamic" and _leaves_plane(space, asked):
        wider = design_space(space.linkage, space.motion, spatial=True)
        space = certify(wider) if isinstance(space, CertifiedSpace) else wider
        asked = constraints_of(space, keep, bounds, within)
    found = decide_feasibility(space, asked)
    design = Design(
        space, found.verdict, minimise, None, tuple(keep), bounds, within, found.z,
        found.certificate, found.multipliers, found.margin, found.residuals, found.words,
    )  # fmt: skip
    if minimise and found.z is not None:
        design = _best(design, asked)
    return design if within is None or design.z is not None else _beside(design, asked)


def _beside(known: Design, asked: Constraints) -> Design:
    """The answer where there is no design within balls, beside the one without them."""
    beyond = design(
        known.space, known.minimise, keep=known.keep, bounds=known.bounds, within=None
    )
    if beyond.verdict == "infeasible":
        return replace(beyond, within=known.within)
    if known.verdict == beyond.verdict:
        return known
    says = f"{beyond.verdict} anywhere"
    if beyond.z is not None:
        P = matrices_of(known.space, beyond.z)
        says = f"{says}: {describe_furthest(known.space, P, asked)}"
    own = known.words.replace("undecided:", f"undecided{describe_limits(asked)}:", 1)
    return replace(known, words=f"{own}; {says}", anywhere=beyond)


def _leaves_plane(space: DesignSpace, asked: Constraints) -> bool:
    """Whether bodies that are kept have no common plane of symmetry."""
    moving = [b for b in asked.keep if space.chain.links[b] >= 0]
    kept = np.array([space.linkage.bodies[b].inertia for b in moving]).reshape(-1, 10)
    return out_of_plane_asymmetry(from_si(kept, space.chain.frame)) > ROUNDED


def _best(known: Design, asked: Constraints) -> Design:
    """The best design, once there is one."""
    assert known.z is not None and known.minimise is not None
    space, wanted = known.space, known.minimise
    question = program(space, asked)
    best = minimise_objective(space, question, wanted, known.z, known.margin)
    if best is not None:
        P = matrices_of(space, given_parameters(space))
        P[list(question.free)] = best.P
        z = assemble_design(space, asked, P, _thickness(space) if wanted == "change" else None)
        check = check_design(space, z, asked)
        if check.accepted:
            margin = question.cone.least(best.P).min() / np.trace(P, axis1=1, axis2=2).sum()
            return replace(
                known, z=z, value=best.value, margin=float(margin), residuals=check,
                words=f"feasible: the design of the least {wanted}",
            )  # fmt: skip
    text = (
        f"undecided: there are designs, but the one of the least {wanted} was not found; ask "
        "for no objective to see one"
    )
    return replace(known, verdict="undecided", z=None, margin=0.0, residuals=None, words=text)


def _thickness(space: DesignSpace) -> Array:
    """Second moments of the file's bodies along the third axis of the chain."""
    P = from_si(given_parameters(space), space.chain.frame)
    m = np.where(P[:, 3, 3], P[:, 3, 3], 1.0)
    return np.asarray(P[:, 2, 2] - P[:, 2, 3] ** 2 / m)
