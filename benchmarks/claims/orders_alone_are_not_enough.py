"""Claim: finite poses find the rank where derivatives at one pose lose it.

A row of coupled four-bars has one degree of freedom, so that all conditions but the first few
must come from higher orders. In a long row the last conditions are lost in round-off at any
order. Exact arithmetic is the reference.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from balance import design_space
from balance.space.certification.exact_ranks import exact_ranks
from benchmarks.inputs.geometry import four_bar_chain
from kinematics.loading.model_gallery import load
from kinematics.model.linkage import Linkage

ORDERS = (10, 20, 50)
LONGEST = 20


@cache
def _row(count: int) -> tuple[Linkage, dict[str, int]]:
    """Build a row of four-bars, and compute its ranks and their costs."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "chain.urdf"
        path.write_text(four_bar_chain(count), encoding="utf-8")
        linkage = load(path)
        exact = exact_ranks(linkage)
    space = design_space(linkage)
    alone = {f"to order {k}": design_space(linkage, max_order=k).rank for k in ORDERS}
    return linkage, {
        "exact": exact.rank,
        "kmax": exact.kmax,
        "ours": space.rank,
        "poses": space.poses,
        **alone,
    }


class PosesFindTheRank:
    """The public call, which adds poses where needed."""

    params = ((2,), (5,), (12,), (LONGEST,))
    claims = (("track_missed", 0.0),)

    def setup(self, count: int) -> None:
        """Compute the ranks by every route."""
        self.linkage, self.ranks = _row(count)

    def time_design_space(self, count: int) -> None:
        """The public call."""
        design_space(self.linkage)

    def track_missed(self, count: int) -> float:
        """Error of the rank."""
        return abs(self.ranks["exact"] - self.ranks["ours"])

    def row(self, count: int) -> dict[str, int]:
        """Rank by exact arithmetic and the order it takes; ours; by orders alone."""
        return self.ranks


class OrdersAloneDoNot:
    """The longest row, with conditions at the reference pose only."""

    params = ((LONGEST,),)
    claims = (("track_right", 0.0),)

    def setup(self, count: int) -> None:
        """Compute the ranks by every route."""
        self.linkage, self.ranks = _row(count)

    def time_orders(self, count: int) -> None:
        """Conditions to the highest order."""
        design_space(self.linkage, max_order=ORDERS[-1])

    def track_right(self, count: int) -> int:
        """Number of highest orders with the right rank."""
        return sum(self.ranks[f"to order {k}"] == self.ranks["exact"] for k in ORDERS)
