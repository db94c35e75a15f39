"""How sure a design space is: proved, verified or estimated, and the numbers behind it."""

from __future__ import annotations

from typing import NamedTuple

from balance.exact.proof import Proof

__all__ = ["LEVELS", "Certainty"]

LEVELS = ("estimated", "verified", "proved")


class Certainty(NamedTuple):
    """What is known of a design space beyond floating-point arithmetic.

    Attributes:
        level: ``"proved"``: exact lower bounds of rank and nullity add up to the number of
            parameters, and rank by order, kmax, serial and parallel part are those of exact
            arithmetic; ``"verified"``: the same ranks by exact arithmetic, where it can be
            done, and all momenta vanish to 1e-11 of the size of the conditions at finite
            poses that were not used; ``"estimated"``: neither.
        reason: why, in one line.
        rank: lower bound of the rank by exact arithmetic, if the loops close at all orders;
            None if it cannot be done.
        nullity: lower bound of the nullity by exact arithmetic, if idle joints stay at
            rest; or None.
        residual: largest momentum left at the poses tried, relative to the conditions.
        poses: how many were tried.
        doubts: why an estimate may be wrong, a line each; without any, floating point
            decided by a wide margin.
        proof: of the rank and nullity, if they are proved.
        orders: rank by order, by exact arithmetic; empty if it cannot be done.
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

    def to_dict(self) -> dict[str, object]:
        """The entry ``evidence`` of the report: all but level, proof and orders."""
        rest = {"level", "proof", "orders"}
        known = {name: value for name, value in self._asdict().items() if name not in rest}
        return known | {"doubts": list(self.doubts)}
