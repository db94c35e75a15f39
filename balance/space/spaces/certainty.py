"""Certainty of a design space: proved, verified or estimated, and the numbers behind it."""

from __future__ import annotations

from typing import NamedTuple

from balance.space.exact.proof import Proof
from kinematics.wording import repr_lines

LEVELS = ("estimated", "verified", "proved")


class Certainty(NamedTuple):
    """Certainty of the integers of a design space, by exact arithmetic and fresh poses.

    Attributes:
        level: ``"proved"``: exact lower bounds of rank and nullity add up to the number of
            parameters, and rank by order, kmax, serial and parallel part are those of exact
            arithmetic; ``"verified"``: exact arithmetic finds the same ranks, joints that rest
            are shown to rest, and all momenta vanish to 1e-11 of the size of the conditions at
            finite poses that were not used (to 1e-6, if exact arithmetic finds no condition
            at many further orders), or the exact bounds meet and overconstrained loops close
            exactly up to the order that the reason names; ``"estimated"``: neither.
        reason: why the level is this one, in one line.
        rank: lower bound of the rank by exact arithmetic, if the loops close at all orders;
            None if it cannot be done.
        nullity: lower bound of the nullity by exact arithmetic, if idle joints stay at
            rest; None if it cannot be done.
        residual: largest momentum left at the poses tried, relative to the conditions.
        poses: number of poses tried.
        doubts: why an integer may be wrong, a line each; empty if exact arithmetic confirms
            them, or floating point decided them by a wide margin.
        proof: of the rank and nullity, if the level is ``"proved"``; otherwise None.
        orders: exact rank by order, if the level is ``"proved"``; otherwise empty.
    """

    level: str
    reason: str
    rank: int | None
    nullity: int | None
    residual: float
    poses: int
    doubts: tuple[str, ...] = ()
    proof: Proof | None = None
    orders: tuple[int, ...] = ()

    def __repr__(self) -> str:
        """Up to six lines: level, reason, doubts."""
        doubts = [f"in doubt: {doubt}" for doubt in self.doubts]
        return repr_lines(f"Certainty: {self.level}", self.reason, *doubts)

    @property
    def motion_doubts(self) -> tuple[str, ...]:
        """The doubts whether all joints that count as idle rest, and about the mobility."""
        return tuple(
            doubt for doubt in self.doubts if doubt.startswith(("mobility:", "idle joints:"))
        )

    def with_doubt(self, doubt: str) -> Certainty:
        """Lower the level to ``estimated`` for a doubt, which becomes the reason."""
        return self._replace(
            level="estimated", reason=doubt, doubts=(*self.doubts, doubt), proof=None, orders=()
        )

    def to_dict(self) -> dict[str, object]:
        """Convert to the entry ``evidence`` of the report: all but level, proof and orders."""
        left_out = {"level", "proof", "orders"}
        entries = {
            name: value for name, value in self._asdict().items() if name not in left_out
        }
        return entries | {"doubts": list(self.doubts)}
