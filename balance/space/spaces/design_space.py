"""The result of `design_space`: a space of mass distributions, as data.

Functions compute results beyond these arrays on demand: `balance.certify`, `balance.explain`,
`balance.checks.exact_ranks`, `balance.space.distance_to_rank_drop`, `balance.space.save_space`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, NamedTuple

import numpy as np

from balance.space.conditions.collect import relative_tolerance
from balance.space.conditions.rank import Decision
from balance.space.inertial_parameters.conversions import (
    basis_from_chain,
    violations,
)
from balance.space.spaces.given_masses import AsGiven, keeps_centre_of_mass, residual_of
from balance.space.spaces.readings import Reading
from balance.space.spaces.space_data import RequirementRank, SpaceData
from balance.space.transfers.by_joint import Transfer, by_joint
from balance.space.transfers.serial_part import Transfers
from balance.support.later_fields import LaterFields
from balance.support.result_files import WithPage
from balance.support.tolerances import (
    AS_GIVEN_RESIDUAL,
    DROPPED_CLEARLY,
    KEPT_CLEARLY,
    MASS_NEVER,
    SQUARE_ROUND_OFF,
)
from kinematics.files.urdf.validate_inertias import UNPHYSICAL
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Linkage, Notice
from kinematics.model.motion import while_text
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import MARGIN_DETERMINED
from kinematics.wording import first_names, html_facts, repr_lines, size_text

REPORT_SCHEMA = "balance.report/1"
Verdict = Literal["as_given", "force_alone", "open", "impossible", "undecided"]
DESIGN_DECIDES = "(balance design decides)"
# Codes of the notices on masses that no body has.
UNPHYSICAL_CODES = (UNPHYSICAL, "non_physical")


class CanBalance(NamedTuple):
    """Whether a linkage can balance, as far as its design space decides it.

    Attributes:
        verdict: ``"as_given"``: the masses of the file balance it; ``"force_alone"``: they
            leave no shaking force, but a shaking moment; ``"impossible"``: it balances only
            without mass; ``"open"``: other masses balance it, and `balance.design` decides
            whether bodies can have them; ``"undecided"``.
        sentence: a question, and the answer to it.
        verb: the command of ``balance`` that comes next; empty if there is none.
    """

    verdict: Verdict
    sentence: str
    verb: str


def square_doubt(kept: float) -> tuple[str, ...]:
    """Say that the square of the smallest singular value kept would be lost in round-off.

    Args:
        kept: that value, relative to the largest.

    Returns:
        A line, or none.
    """
    if not kept < SQUARE_ROUND_OFF:
        return ()
    size = size_text(kept, floor=MARGIN_DETERMINED)
    return (
        f"the smallest singular value kept is {size}: conditions of the size of its square are "
        "below round-off",
    )


@dataclass(frozen=True, eq=False)
class DesignSpace(SpaceData, WithPage, LaterFields):
    """Mass distributions with vanishing momentum in every motion of a linkage.

    Attributes:
        linkage: the linkage.
        highest_order: the highest order of derivative requested; None for as many as needed.
        decision: basis and conditions in the units of the chain, where columns of the basis
            are orthonormal, and the numbers behind the rank.
        chain: arrays of the joints that move, and those units.
        chain_transfers: inertia transfers across joints, in those units.
        readings: where the numbers of the file are special but for rounding, or just miss it,
            both answers, and which one this is.
    """

    page_maker = "report:space_page"

    linkage: Linkage
    highest_order: int | None
    decision: Decision = field(repr=False)
    chain: Chain = field(repr=False)
    chain_transfers: Transfers = field(repr=False)
    readings: tuple[Reading, ...] = field(default=(), kw_only=True, repr=False)

    def __repr__(self) -> str:
        """Up to six lines: the space, its parts, its certainty."""
        ranks = ", ".join(str(order.rank) for order in self.orders)
        return repr_lines(
            f"{type(self).__name__} of {self.linkage.name}",
            self.parts,
            f"ranks by order {ranks}",
            f"bodies {first_names(self.bodies)}",
            self.assurance,
            f"as given: {self.as_given.verdict}",
        )

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        return html_facts(
            f"{type(self).__name__} of {self.linkage.name}",
            ("parameters", self.parts),
            ("ranks by order", ", ".join(str(order.rank) for order in self.orders)),
            ("bodies", first_names(self.bodies)),
            ("certainty", self.assurance),
            ("as given", self.as_given.verdict),
        )

    @cached_property
    def basis(self) -> Array:
        """Null-space basis in SI units (parameters, nullity); see `SpaceRecord`."""
        force = self.balance == "force"
        basis = basis_from_chain(self.decision.basis, self.chain.frame, self.planar, force)
        return freeze(basis)

    @property
    def rank(self) -> int:
        """Number of independent conditions."""
        return self.decision.rank

    @property
    def nullity(self) -> int:
        """Dimension of the space."""
        return self.decision.basis.shape[1]

    @property
    def singular_values(self) -> Array:
        """Singular values of all conditions, relative to the largest (rank,)."""
        return self.decision.singular_values

    @property
    def kept(self) -> float:
        """The smallest singular value that counts; 1 if there are none."""
        return self.decision.kept

    @property
    def dropped(self) -> float:
        """Upper bound of the largest singular value that does not count."""
        return self.decision.dropped

    @property
    def scaled_basis(self) -> Array:
        """The basis in the units of the chain, where its columns are orthonormal."""
        return self.decision.basis

    @property
    def doubts(self) -> tuple[str, ...]:
        """Decisions of floating-point arithmetic that are near round-off, a line each.

        Empty if every size that was dropped as round-off is far below the limit, and every
        size that was kept is far above it.
        """
        doubts = []
        limit = DROPPED_CLEARLY * relative_tolerance(self.chain)
        if self.dropped > limit:
            doubts.append(
                f"a singular value of {size_text(self.dropped)} counts as round-off: "
                "ranks may be too low"
            )
        transfers = self.chain_transfers
        if transfers.kept < KEPT_CLEARLY:
            doubts.append(
                f"a direction of size {size_text(transfers.kept)} decides about transfers"
            )
        if transfers.dropped > limit:
            doubts.append(
                f"a direction of size {size_text(transfers.dropped)} counts as round-off: "
                "the serial part may be wrong"
            )
        return (*doubts, *square_doubt(self.kept))

    @property
    def level(self) -> str:
        """Level of certainty; see `Certainty`."""
        return "estimated"

    @property
    def assurance(self) -> str:
        """Certainty of the integers, in one line."""
        return "estimated: by floating-point arithmetic alone; see balance.certify"

    @property
    def sure(self) -> bool:
        """Whether all conditions are known and no decision was near round-off."""
        return self.settled and not self.doubts

    @property
    def encloses(self) -> bool:
        """Whether the space contains every balanced distribution.

        It does if no singular value that was kept is near round-off.
        """
        return not self.decision.ill_conditioned

    @property
    def options(self) -> dict[str, Any]:
        """The options of `design_space` that give this space, by name."""
        return {
            "motion": self.motion,
            "balance": self.balance,
            "max_order": self.highest_order,
            "spatial": not self.planar,
        }

    @property
    def requirements(self) -> tuple[RequirementRank, ...]:
        """The requirements of which this is the common space; see `balance.require`."""
        return ()

    @property
    def aim(self) -> str:
        """What is asked for, in words."""
        return f"{self.balance} balance"

    @property
    def parts_text(self) -> str:
        """The two parts of the space, in words."""
        return f"{self.serial_nullity} serial + {self.nullity - self.serial_nullity} parallel"

    @cached_property
    def transfers(self) -> tuple[Transfer, ...]:
        """Inertia transfers across each joint that moves; together they span ``serial``.

        Transfers of different joints may depend on one another along a loop, so that their
        dimensions may add up to more than that of ``serial``.
        """
        force = self.balance == "force"
        return by_joint(self.linkage, self.chain, self.chain_transfers, force)

    @cached_property
    def as_given(self) -> AsGiven:
        """Whether the masses in the file are balanced."""
        residual = residual_of(
            self.linkage,
            self.chain,
            self.planar,
            self.balance == "force",
            self.decision.conditions.rows,
        )
        if residual is None:
            return AsGiven(None, None)
        return AsGiven(residual <= AS_GIVEN_RESIDUAL, residual)

    @cached_property
    def can_balance(self) -> CanBalance:
        """Whether the linkage can balance, as far as the space decides it."""
        return _answer_of(self)

    @property
    def brief(self) -> str:
        """Summary in one line of words."""
        count, algebra = self.rank + self.nullity, "planar" if self.planar else "spatial"
        return (
            f"rank {self.rank} of {count} {algebra} parameters, nullity {self.nullity}, "
            f"mobility {self.linkage.mobility}, {self.as_given.verdict} as given"
        )

    @property
    def warnings(self) -> tuple[Notice, ...]:
        """The notices, and then the inequalities of physical bodies that masses violate.

        The notice on a file names all links that violate them.
        """
        if any(notice.code == UNPHYSICAL for notice in self.linkage.notices):
            return self.notices
        unreal = [
            Notice("non_physical", f"link '{body.name}': {problem}")
            for body in self.linkage.bodies
            for problem in violations(body.inertia)
        ]
        return (*self.notices, *unreal)

    def to_dict(self) -> dict[str, object]:
        """Convert the report to plain data, ready for JSON.

        ``balance/app/schemas/report.schema.json`` describes it. A key whose value is ``None``
        is the result of a function that was not called, such as `balance.explain`.
        """
        linkage = self.linkage
        return {
            "schema": REPORT_SCHEMA,
            "verdict": self.can_balance.verdict,
            "sentence": self.can_balance.sentence,
            "next": None,
            "alternative": None,
            "model": linkage.name,
            "at": linkage.at,
            "algebra": "planar" if self.planar else "spatial",
            "balance": self.balance,
            "bodies": list(self.bodies),
            "parameters": self.rank + self.nullity,
            "joints": len(linkage.joints),
            "loops": len(linkage.loops),
            "mobility": linkage.mobility,
            "inputs": list(self.inputs),
            "idle": list(self.idle),
            "motion": list(self.motion.relations) if self.motion else [],
            "orders": [order._asdict() for order in self.orders],
            "poses": self.poses,
            "kmax": self.kmax,
            "rank": self.rank,
            "nullity": self.nullity,
            "serial": self.serial_nullity,
            "parallel": self.nullity - self.serial_nullity,
            "certainty": self.level,
            "evidence": None,
            "requirements": [item._asdict() for item in self.requirements],
            "gravity": None,
            "readings": [reading.to_dict() for reading in self.readings],
            "exact": None,
            "transfers": None,
            "freedoms": None,
            "decoupled": None,
            "pure_inertia": None,
            "margin": {
                "kept": self.kept,
                "dropped": self.dropped,
                "change": None,
            },
            "singular_values": self.singular_values.tolist(),
            "basis": self.basis.tolist(),
            "as_given": self.as_given._asdict(),
            "warnings": [notice.to_dict() for notice in self.warnings],
        }


def _answer_of(space: DesignSpace) -> CanBalance:
    """Say whether a linkage can balance, as far as its design space decides it."""
    answer, when = _answer(space), while_text(space.motion)
    if not space.requirements:
        return answer._replace(sentence=f"Can it balance{when}? {answer.sentence}.")
    # Only the design takes requirements.
    verb = answer.verb if answer.verb == "design" else ""
    sentence = f"Can it balance as required{when}? {answer.sentence}."
    return CanBalance(answer.verdict, sentence, verb)


def _answer(space: DesignSpace) -> CanBalance:
    given = space.as_given.balanced
    if space.doubts:
        return CanBalance("undecided", f"Undecided: {space.doubts[0]}", "verify")
    if given and not space.settled:
        last = space.orders[-1].order if space.orders else 0
        text = f"Undecided: these masses meet the conditions up to order {last}, not all"
        return CanBalance("undecided", text, "verify")
    real = not any(notice.code in UNPHYSICAL_CODES for notice in space.warnings)
    if given and real:
        text = f"Yes, with these masses: {balanced_text(space)}"
        return CanBalance("as_given", text, "verify")
    force_alone = (
        given is False
        and real
        and space.balance == "dynamic"
        and not space.requirements
        and keeps_centre_of_mass(space.linkage, space.chain, space.planar)
    )
    return _with_other_masses(space, force_alone)


def _with_other_masses(space: DesignSpace, force_alone: bool) -> CanBalance:
    """Say what masses other than those of the file can do."""
    without = _massless_text(space) if space.encloses else ""
    verb = "remedies" if without else "design"
    if force_alone:
        others = f"both {without}" if without else f"perhaps both with others {DESIGN_DECIDES}"
        text = f"Only forces with these masses, which leave a shaking moment; {others}"
        return CanBalance("force_alone", text, verb)
    if without:
        return CanBalance("impossible", f"No, {without}", verb)
    given = space.as_given.balanced
    if given is None:
        return CanBalance("open", f"Perhaps, for its file has no masses {DESIGN_DECIDES}", verb)
    unphysical = ", which balance it but which no bodies can have" if given else ""
    text = f"Not with these masses{unphysical}; perhaps with others {DESIGN_DECIDES}"
    return CanBalance("open", text, verb)


def _massless_text(space: DesignSpace) -> str:
    """Say which links have no mass in any distribution of the space; empty if each may."""
    masses = space.scaled_basis[:: len(space.scaled_basis) // len(space.bodies)]
    massless = np.linalg.norm(masses, axis=1) <= MASS_NEVER
    if massless.all():
        return "only without mass"
    if massless.any():
        names = [name for name, never in zip(space.bodies, massless, strict=True) if never]
        return f"only without mass in {first_names(names)}"
    if np.linalg.norm(masses.sum(axis=0)) <= MASS_NEVER:
        return "only with masses that add up to nothing"
    return ""


def balanced_text(space: DesignSpace) -> str:
    """Say what does not shake with masses of a design space, in its motion."""
    if space.requirements or not space.settled:
        return "what is asked for holds"
    when = "" if space.motion else " in any motion"
    if space.balance == "force":
        return f"no shaking force{when} (the moment does not count)"
    return f"no shaking force and no shaking moment{when}"
