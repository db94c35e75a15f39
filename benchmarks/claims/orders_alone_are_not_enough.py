"""Claim: where derivatives at one pose lose the rank, finite poses find it.

One degree of freedom moves a whole row of coupled four-bars, so that all conditions but the
first few must come from higher orders. The last of a long row drown in round-off, however
many orders are computed. Exact arithmetic is the judge.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from balance import design_space
from balance.exact.ranks import exact_ranks
from benchmarks.inputs.geometry import four_bar_chain
from kinematics.model.linkage import Linkage
from kinematics.model_gallery import load

ORDERS = (10, 20, 50)
LONGEST = 20


@cache
def _row(count: int) -> tuple[Linkage, dict[str, int]]:
    """A row of four-bars; its ranks, and what they took."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "chain.urdf"
        path.write_text(four_bar_chain(count), encoding="utf-8")
        linkage = load(path)
        exact = exact_ranks(linkage)
    space = design_space(linkage)
    alone = {f"to order {k}": design_space(linkage, max_order=k).rank for k in ORDERS}
    return linkage, {
        "exact": exact.rank, "kmax": exact.kmax, "ours": space.rank, "poses": space.poses,
        **alone,
    }  # fmt: skip


class PosesFindTheRank:
    """The public call, which takes poses where it needs them."""

    params = ((2,), (5,), (12,), (LONGEST,))
    claims = (("track_missed", 0.0),)

    def setup(self, count: int) -> None:
        """Ranks by every route."""
        self.linkage, self.ranks = _row(count)

    def time_design_space(self, count: int) -> None:
        """The public call."""
        design_space(self.linkage)

    def track_missed(self, count: int) -> float:
        """By how much the rank is wrong."""
        return abs(self.ranks["exact"] - self.ranks["ours"])

    def row(self, count: int) -> dict[str, int]:
        """Rank by exact arithmetic and the order it takes; ours; by orders alone."""
        return self.ranks


class OrdersAloneDoNot:
    """The longest row: orders that were asked for, at the reference pose."""

    params = ((LONGEST,),)
    claims = (("track_right", 0.0),)

    def setup(self, count: int) -> None:
        """Ranks by every route."""
        self.linkage, self.ranks = _row(count)

    def time_orders(self, count: int) -> None:
        """The most orders that were asked for."""
        design_space(self.linkage, max_order=ORDERS[-1])

    def track_right(self, count: int) -> int:
        """How many of the highest orders give the rank."""
        return sum(self.ranks[f"to order {k}"] == self.ranks["exact"] for k in ORDERS)
