"""The result of `design_space`: a space of mass distributions, and what it says."""

from __future__ import annotations

import os
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.conditions.collect import floor_of
from balance.conditions.rank import Decision
from balance.exact.ranks import Exact, exact_ranks
from balance.inertial_parameters.conversions import to_chain, violations
from balance.spaces.certainty import Certainty
from balance.spaces.distance_to_rank_drop import nearest_drop
from balance.spaces.result import Answer
from balance.spaces.save import SpaceRecord, digest
from balance.transfers.by_joint import Transfer, by_joint
from balance.transfers.serial_space import CLEAR, SURE, Transfers
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage, Notice
from kinematics.wording import listed, paragraph

if TYPE_CHECKING:
    from balance.interpretation.explain import Explanation

__all__ = ["SCHEMA", "AsGiven", "DesignSpace"]

Array = NDArray[np.float64]

SCHEMA = "balance.report/1"
# Of a space that `balance.certify` has not seen.
UNCERTIFIED = Certainty(
    "estimated", "by floating-point arithmetic alone; see balance.certify", None, None, 0.0, 0
)
# Masses in files are rounded: a given distribution counts as balanced up to this part of
# the sum of its bodies' contributions.
BALANCED = 1e-9
# A special geometry that is missed by δ has conditions of the size δ, δ² …: below this, the
# second may be round-off.
SMALL = 5e-8


class AsGiven(NamedTuple):
    """Whether the masses in the file lie in the design space.

    Attributes:
        balanced: residual below 1e-9.
        residual: size of the conditions' residual over the sum of the bodies' parts in it.
    """

    balanced: bool
    residual: float


@dataclass(frozen=True, eq=False)
class DesignSpace(Answer):
    """Mass distributions with vanishing momentum in every motion of a linkage.

    Attributes:
        linkage: the linkage.
        highest_order: the highest order of derivative that was asked for; None for as many
            as needed.
        decision: basis and conditions in the units of the chain, where columns of the basis
            are orthonormal, and the numbers behind the rank.
        chain: arrays of the joints that move, and those units.
        exchanged: inertia transfers across joints, in those units.
        certainty: how sure the integers are; ``"estimated"`` until `balance.certify` has
            compared them with those of exact arithmetic.
    """

    linkage: Linkage
    highest_order: int | None
    decision: Decision = field(repr=False)
    chain: Chain = field(repr=False)
    exchanged: Transfers = field(repr=False)
    certainty: Certainty = field(default=UNCERTIFIED, repr=False)

    def __repr__(self) -> str:
        """Up to six lines: the space, its parts, its certainty."""
        ranks = ", ".join(str(order.rank) for order in self.orders)
        return paragraph(
            f"DesignSpace of {self.linkage.name}",
            self.parts,
            f"ranks by order {ranks}",
            f"bodies {listed(self.bodies)}",
            f"{self.certainty.level}: {self.certainty.reason}",
            f"as given: {'balanced' if self.as_given.balanced else 'not balanced'}",
        )

    @property
    def singular_values(self) -> Array:
        """Those of all conditions, relative to the largest (rank,)."""
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
        found = []
        floor = floor_of(self.chain)
        if self.dropped > SURE * floor:
            found.append(
                f"a singular value of {self.dropped:.1e} counts as round-off: ranks may be "
                "too low"
            )
        exchanged = self.exchanged
        if exchanged.kept < CLEAR:
            found.append(f"a direction of size {exchanged.kept:.1e} decides about transfers")
        if exchanged.dropped > SURE * floor:
            found.append(
                f"a direction of size {exchanged.dropped:.1e} counts as round-off: the serial "
                "part may be wrong"
            )
        if self.kept < SMALL:
            found.append(
                f"the smallest singular value kept is {self.kept:.1e}: conditions of the size "
                "of its square are below round-off"
            )
        return tuple(found)

    @property
    def certified(self) -> bool:
        """Whether the space comes from `balance.certify`."""
        return self.certainty is not UNCERTIFIED

    @property
    def sure(self) -> bool:
        """Whether all conditions are known, and none is in doubt.

        The doubts of a certified space are those of its certainty; those of floating point
        are settled then.
        """
        doubts = self.certainty.doubts if self.certified else self.doubts
        return self.settled and not doubts

    @property
    def encloses(self) -> bool:
        """Whether the space contains every balanced distribution: no condition is round-off.

        True if the exact lower bound of the rank is no less than the rank, or, without such
        a bound, if no singular value that was kept is near round-off.
        """
        proved = self.certainty.rank
        return not self.decision.thin if proved is None else self.rank <= proved

    @cached_property
    def transfers(self) -> tuple[Transfer, ...]:
        """What may be exchanged across each joint that moves; together, ``serial``.

        Transfers of different joints may depend on one another along a loop, so that their
        dimensions may add up to more than that of ``serial``.
        """
        force = self.balance == "force"
        return by_joint(self.linkage, self.chain, self.exchanged, force)

    @cached_property
    def as_given(self) -> AsGiven:
        """Whether the masses in the file are balanced."""
        rows = self.decision.conditions.rows
        given = np.array([body.inertia for body in self.linkage.bodies])
        z = to_chain(given, self.chain.frame, self.planar, self.balance == "force")
        by_body = np.einsum("rbp,bp->rb", rows.reshape(-1, *z.shape), z)
        total = float(np.sqrt(np.einsum("rb,rb->b", by_body, by_body)).sum())
        left = by_body.sum(axis=1)
        residual = float(np.sqrt(left @ left)) / total if total > 0.0 else 0.0
        if not np.isfinite(residual):  # lengths that no double precision can square
            residual = 1.0
        return AsGiven(residual <= BALANCED, residual)

    @cached_property
    def nearest_drop(self) -> float | None:
        """Smallest change of geometry that lowers the rank, to first order.

        In characteristic lengths and radians; None where no order reaches the rank, where no
        small change that keeps the loops closed lowers it, and where there is none.
        """
        if self.kmax is None or self.rank == 0:
            return None
        force = self.balance == "force"
        found = nearest_drop(self.linkage, self.chain, force, self.kmax, self.rank)
        return found if np.isfinite(found) else None

    @property
    def brief(self) -> str:
        """The answer in short, in words."""
        count, algebra = self.rank + self.nullity, "planar" if self.planar else "spatial"
        verdict = "balanced" if self.as_given.balanced else "not balanced"
        return (
            f"rank {self.rank} of {count} {algebra} parameters, nullity {self.nullity}, "
            f"mobility {self.linkage.mobility}, {verdict} as given"
        )

    def explain(self) -> Explanation:
        """The space in words: what each joint lets through, and what the loops add."""
        from balance.interpretation.explain import explain

        return explain(self, self.transfers)

    @property
    def warnings(self) -> tuple[Notice, ...]:
        """The notices, and then the masses in the file that no body can have."""
        unreal = [
            Notice("non_physical", f"link '{body.name}': {problem}")
            for body in self.linkage.bodies
            for problem in violations(body.inertia)
        ]
        return (*self.notices, *unreal)

    def record(self) -> SpaceRecord:
        """What is known of the space without its linkage, and where it comes from."""
        from kinematics.version import __version__

        known = {f.name: getattr(self, f.name) for f in fields(Answer)}
        if self.linkage.at:
            pose = Notice("reference_pose", f"the reference pose is {self.linkage.pose}")
            known["notices"] = (*self.notices, pose)
        return SpaceRecord(
            **known, singular_values=self.singular_values, kept=self.kept, dropped=self.dropped,
            sha256=digest(self.source), version=__version__,
        )  # fmt: skip

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the record of the space to a file; see `SpaceRecord.save`."""
        self.record().save(path)

    def exact(self) -> Exact:
        """The ranks by exact arithmetic, from the decimals of the file.

        Raises:
            ExactError: the linkage is not from a file with closed loops, its loops do not
                close exactly, or the motion relates axes without a rational ratio.
        """
        return exact_ranks(
            self.linkage, self.motion, self.balance, self.highest_order,
            spatial=not self.planar, expected=self.rank,
        )  # fmt: skip

    def to_dict(
        self, explanation: Explanation | None = None, exact: Exact | None = None
    ) -> dict[str, object]:
        """The report as plain data, ready for JSON.

        ``balance/schemas/report.schema.json`` describes it. A key whose value is ``None``
        was not asked for.

        Args:
            explanation: what ``explain`` found, for the keys ``transfers`` and ``freedoms``.
            exact: what ``exact`` found, for that key.
        """
        self.check_proved()
        linkage = self.linkage
        return {
            "schema": SCHEMA,
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
            "certainty": self.certainty.level,
            "evidence": self.certainty.to_dict(),
            "exact": exact.to_dict() if exact else None,
            "transfers": None,
            "freedoms": None,
            "margin": {
                "kept": self.kept,
                "dropped": self.dropped,
                "change": self.nearest_drop,
            },
            "singular_values": self.singular_values.tolist(),
            "basis": self.basis.tolist(),
            "as_given": self.as_given._asdict(),
            "warnings": [notice._asdict() for notice in self.warnings],
        } | (explanation.to_dict() if explanation else {})

    def check_proved(self) -> None:
        """Raise an AssertionError if an integer under ``proved`` is not the exact one.

        Rank, nullity, serial and parallel part are those of the proof, and the table ends at
        the order that reaches the rank, unless orders up to another were asked for.
        """
        certainty = self.certainty
        if certainty.level != "proved":
            return
        proof, orders = certainty.proof, certainty.orders
        assert proof is not None
        known = (proof.rank, proof.nullity, proof.nullity, orders)
        ranks = tuple(order.rank for order in self.orders)
        found = (self.rank, self.nullity, self.serial_nullity, ranks)
        assert found == known, f"proved: {known}, not {found}"
