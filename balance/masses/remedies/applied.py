"""The result of one remedy: its verdict, its cost, and the linkage with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Literal

import numpy as np

from balance.masses.partial_balance.motion_loads import input_inertia
from balance.masses.remedies.as_built import AsBuilt, InputSteps, as_built, input_steps
from balance.masses.remedies.catalogue import CATALOGUE
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.trade_off import TradeOff
from balance.support.result_files import write_file
from kinematics.errors import UsageError
from kinematics.model.linkage import Linkage
from kinematics.wording import number_text, repr_lines, size_text

RemedyVerdict = Literal["feasible", "partial", "infeasible", "undecided", "refused"]


@dataclass(frozen=True, eq=False)
class AppliedRemedy:
    """A remedy that was applied to a linkage.

    Attributes:
        remedy: name of the remedy in `balance.masses.remedies.catalogue`.
        words: what is built in where, in one line.
        verdict: ``"feasible"``: the linkage with it is balanced; ``"partial"``: it shakes
            less, or an input needs less torque; ``"infeasible"``, with a proof;
            ``"undecided"``; ``"refused"``: the remedy does not apply to this linkage.
        reason: the proof, or why not, in one line.
        proof: for ``"infeasible"``, the certificate and its check without the solver, as plain
            data: ``matrices`` (see `balance.checks.check_certificate`) if no masses balance the
            linkage with the remedy, else the ``functional`` that excludes matter in the
            regions (see `balance.masses.counterweights.exclusion`).
        added_mass: kg, without gears; None unless feasible or partial, as for the next four.
        mass_ratio: the same over the mass of the moving bodies in the file.
        input_inertia: inertia that each input feels, by its name, kg m² or kg; see
            `balance.masses.partial_balance.motion_loads.input_inertia`.
        inertia_ratio: their sum over the same sum of the file.
        built: what it asks of bearings, gears and room; see `balance.masses.remedies.as_built`.
        new_links: links that the remedy adds, without counterweights.
        new_joints: joints and loops that it adds.
        lost_freedoms: degrees of freedom that it takes.
        residual: largest shaking over random motions, relative to the inertia wrenches of
            the bodies, by `balance.verify`; for ``"partial"`` the root mean square of the
            shaking over that of the file; None if there is no linkage to verify.
        urdf: file of the linkage with the remedy and its masses; None if there is none.
        files: other files by name, such as the table of a varying ratio.
        details: plain data for JSON.
        trade_off: added mass against inertia, if the request asks for it; see
            `balance.masses.remedies.trade_off`.
    """

    remedy: str
    words: str
    verdict: RemedyVerdict
    reason: str
    proof: Mapping[str, object] | None = field(default=None, repr=False)
    added_mass: float | None = None
    mass_ratio: float | None = None
    input_inertia: Mapping[str, float] | None = None
    inertia_ratio: float | None = None
    built: AsBuilt | None = None
    new_links: tuple[str, ...] = ()
    new_joints: tuple[str, ...] = ()
    lost_freedoms: int = 0
    residual: float | None = None
    urdf: bytes | None = field(default=None, repr=False)
    files: Mapping[str, bytes] = field(default_factory=dict, repr=False)
    details: Mapping[str, object] = field(default_factory=dict, repr=False)
    trade_off: tuple[TradeOff, ...] = field(default=(), repr=False)

    def __repr__(self) -> str:
        """Two lines: the remedy, and its verdict."""
        head = f"AppliedRemedy {self.remedy}: {self.words}"
        if self.added_mass is None or self.inertia_ratio is None:
            return repr_lines(head, f"{self.verdict}: {self.reason}")
        costs = (
            f"{number_text(self.added_mass_with_gears)} kg added, input inertia × "
            f"{number_text(self.inertia_ratio)}"
        )
        return repr_lines(head, f"{self.verdict}: {costs}")

    @property
    def helps(self) -> bool:
        """Whether there is a linkage with the remedy that shakes less, or needs less torque."""
        return self.verdict in ("feasible", "partial")

    @property
    def added_mass_with_gears(self) -> float:
        """Added mass with that of gears, kg; 0 if nothing is built."""
        gears = 0.0 if self.built is None else self.built.gear_mass
        return (self.added_mass or 0.0) + gears

    @property
    def added_text(self) -> str:
        """Added mass with that of gears, in words: ``33.62 kg with its gears``."""
        gears = " with its gears" * (self.added_mass_with_gears > (self.added_mass or 0.0))
        return f"{number_text(self.added_mass_with_gears, '.4g')} kg{gears}"

    @property
    def short(self) -> str:
        """What is built, in a few words."""
        return CATALOGUE[self.remedy].short

    @property
    def title(self) -> str:
        """The kind of remedy, in words of the field."""
        return CATALOGUE[self.remedy].title

    def to_urdf(self, path: str | PathLike[str] | None = None) -> bytes:
        """Return the file of the linkage with the remedy and its masses.

        Args:
            path: file to write it to; None for none.

        Raises:
            UsageError: there is none.
            FileError: the file cannot be written.
        """
        if self.urdf is None:
            raise UsageError(f"{self.words}: no linkage to write: {self.reason}")
        return write_file(path, self.urdf)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/remedies.schema.json``."""
        entry = CATALOGUE[self.remedy]
        return {
            "remedy": self.remedy,
            "abbreviation": entry.abbreviation,
            "title": entry.title,
            "short": entry.short,
            "source": entry.source,
            "words": self.words,
            "verdict": self.verdict,
            "reason": self.reason,
            "proof": None if self.proof is None else dict(self.proof),
            "added_mass": self.added_mass,
            "mass_ratio": self.mass_ratio,
            "input_inertia": None if self.input_inertia is None else dict(self.input_inertia),
            "inertia_ratio": self.inertia_ratio,
            "built": None if self.built is None else self.built._asdict(),
            "new_links": list(self.new_links),
            "new_joints": list(self.new_joints),
            "lost_freedoms": self.lost_freedoms,
            "residual": self.residual,
            "details": dict(self.details),
            "trade_off": [point._asdict() for point in self.trade_off],
        }


def refused(remedy: str, reason: str, words: str = "") -> AppliedRemedy:
    """Return the result of a remedy that does not apply.

    Args:
        reason: why not, in one line.
        words: what would have been built in.
    """
    return AppliedRemedy(remedy, words or CATALOGUE[remedy].title, "refused", reason)


def describe_residual(share: float, what: str = "file") -> str:
    """State that what should be balanced shakes by a share of the sum over the bodies."""
    return f"its {what} shakes by {size_text(share)} of the inertia wrenches of its bodies"


def inertia_ratio(request: RemedyRequest, now: Mapping[str, float]) -> float | None:
    """Compute the sum of the inertias that inputs feel over that of the file.

    Inertias of sliding inputs count times the square of the characteristic length.

    Args:
        now: inertia by input of the linkage with a remedy; inputs that it lost are left out of
            this sum, and not out of that of the file.

    Returns:
        The ratio; None if the inputs of the file feel no inertia.
    """
    before = total_inertia(request, request.input_inertia)
    return total_inertia(request, now) / before if before > 0.0 else None


def total_inertia(request: RemedyRequest, inertias: Mapping[str, float]) -> float:
    """Add up inertias by input, those of sliding inputs times the square of the length."""
    sliding, square = request.linkage.sliding, request.space.length**2
    counted = [x * (square if name in sliding else 1.0) for name, x in inertias.items()]
    return float(np.sum(counted))


def with_cost(
    request: RemedyRequest,
    done: AppliedRemedy,
    added: float,
    linkage: Linkage,
    relations: Sequence[str] = (),
    steps: InputSteps | None = None,
) -> AppliedRemedy:
    """Add the cost to a result that balances the linkage.

    Args:
        added: mass that it adds, kg.
        linkage: the linkage with it. Inputs that the request has not are balancers, which
            stand where the inertia of the others is felt.
        relations: between the inputs.
        steps: of all its inputs, where balancers move with the others; by default each input
            moves alone.
    """
    given = request.given_mass
    felt = input_inertia(linkage)
    if steps is None:
        steps = input_steps(request, linkage, relations)
    else:
        felt = {name: felt[name] for name in request.linkage.inputs}
    built = as_built(request, linkage, steps, done.new_joints)
    whole = f"{number_text(added + built.gear_mass, '.4g')} kg"
    gears = " with its gears" * (built.gear_mass > 0.0)
    return replace(
        done,
        added_mass=added,
        mass_ratio=added / given,
        input_inertia=felt,
        inertia_ratio=inertia_ratio(request, felt),
        built=built,
        reason=done.reason or f"balanced: {whole}{gears} added to {number_text(given)} kg",
    )
