"""A design space whose integers `balance.certify` has confirmed or corrected."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

from balance.space.spaces.certainty import Certainty
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.readings import Reading
from kinematics.model.linkage import Notice


@dataclass(frozen=True, eq=False)
class CertifiedSpace(DesignSpace):
    """A design space with the certainty of its integers.

    Attributes:
        certainty: level, reason, bounds, doubts and proof; it holds for all integers.
    """

    certainty: Certainty = field(kw_only=True, repr=False)

    __repr__ = DesignSpace.__repr__

    @property
    def level(self) -> str:
        """Level of certainty; see `Certainty`."""
        return self.certainty.level

    @property
    def assurance(self) -> str:
        """Level of certainty and its reason, in one line."""
        return f"{self.certainty.level}: {self.certainty.reason}"

    @property
    def doubts(self) -> tuple[str, ...]:
        """Reasons why an integer may be wrong, a line each: those that certification left."""
        return self.certainty.doubts

    @property
    def encloses(self) -> bool:
        """Whether the space contains every balanced distribution.

        It does if the rank does not exceed its exact lower bound, or, where there is no such
        bound, if no singular value that was kept is near round-off.
        """
        bound = self.certainty.rank
        return super().encloses if bound is None else self.rank <= bound

    def to_dict(self) -> dict[str, object]:
        """Convert the report to plain data, with its certainty; see `DesignSpace.to_dict`."""
        self.check_proved()
        return super().to_dict() | {"evidence": self.certainty.to_dict()}

    def check_proved(self) -> None:
        """Raise an AssertionError if an integer under ``proved`` is not the exact one.

        Rank, nullity, serial and parallel part are those of the proof, and the table ends at
        the order that reaches the rank, unless orders up to another were requested.
        """
        certainty = self.certainty
        if certainty.level != "proved":
            return
        proof, orders = certainty.proof, certainty.orders
        assert proof is not None
        proved = (proof.rank, proof.nullity, proof.nullity, orders)
        ranks = tuple(order.rank for order in self.orders)
        integers = (self.rank, self.nullity, self.serial_nullity, ranks)
        assert integers == proved, f"proved: {proved}, not {integers}"


def with_certainty(space: DesignSpace, certainty: Certainty) -> CertifiedSpace:
    """Attach a certainty to a design space, in place of the one that it may have.

    Args:
        certainty: level, reason, bounds, doubts and proof.
    """
    values = {item.name: getattr(space, item.name) for item in fields(DesignSpace) if item.init}
    return CertifiedSpace(**values, certainty=certainty)


def with_readings(
    space: CertifiedSpace, notices: Sequence[Notice], readings: Sequence[Reading]
) -> CertifiedSpace:
    """Add both readings of a file to a space, and the notices that tell them."""
    if not notices:
        return space
    return replace(
        space, notices=(*space.notices, *notices), readings=(*space.readings, *readings)
    )
