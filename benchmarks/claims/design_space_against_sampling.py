"""Claim: a design space costs a 14th of what sampling with Pinocchio costs, for the same rank.

The peer is the usual method: stacked momentum regressors of Pinocchio at random closed poses,
and a QR with pivots above 1e-8 as in figaroh's base parameters. Newton's method with the
Jacobians of Pinocchio closes its loops; a second timing has given poses and velocities. For a
planar linkage it keeps only planar parameters. The number of poses that its rank needs is
found by doubling before the timing. Exact arithmetic is the reference.
"""

from __future__ import annotations

from itertools import cycle
from time import perf_counter

import numpy as np

from balance import design_space
from balance.space.certification.exact_ranks import exact_ranks
from benchmarks.inputs.geometry import resized
from benchmarks.inputs.sampling import Sampling
from kinematics.loading.model_gallery import load

# Largest number of poses of the peer.
MAX_POSES = 64


class DesignSpaceAgainstSampling:
    """Linkages that need many poses, each in several sizes and places for us."""

    params = (("four_bar_general",), ("five_bar",), ("three_rsr",), ("four_rrr",))
    claims = (("time_ours", "time_sampling", 1 / 14), ("track_wrong_ranks", 0.0))

    def setup(self, model: str) -> None:
        """Find the number of poses that the peer needs."""
        linkage = load(model)
        self.exact = exact_ranks(linkage).rank
        self.copies = resized(model, 8)
        self.linkages = cycle(self.copies)
        self.peer = Sampling(linkage, linkage.planar)
        self.amplitude = 0.1 * linkage.chain.units[linkage.chain.joints == self.peer.inputs[0]]
        self.count = 1
        self.found = -1
        while self.found != self.exact and self.count < MAX_POSES:
            self.count *= 2
            self.given = self._poses(self.count)
            self.found = self.peer.rank(self.given)
        # Fewer poses may be enough, down to half as many.
        for count in range(self.count // 2 + 1, self.count):
            if self.peer.rank(self.given[:count]) == self.exact:
                self.count, self.given = count, self.given[:count]
                break

    def _poses(self, count: int) -> list[tuple[np.ndarray, np.ndarray]]:
        """Compute random closed poses and their joint velocities."""
        rng, found = np.random.default_rng(7), []
        size = float(self.amplitude[0])
        for u in size * rng.uniform(-1.0, 1.0, (count, self.peer.inputs.size)):
            q = self.peer.close_loops(u)
            found.append((q, self.peer.rates(q)))
        return found

    def time_ours(self, model: str) -> None:
        """The public call: rank by order, null space, transfers."""
        design_space(next(self.linkages))

    def time_sampling(self, model: str) -> None:
        """Poses closed by Newton's method, regressors, QR."""
        self.peer.rank(self._poses(self.count))

    def poses_given(self) -> float:
        """Measure the seconds of the peer with given poses and joint velocities."""
        times = []
        for _ in range(9):
            start = perf_counter()
            self.peer.rank(self.given)
            times.append(perf_counter() - start)
        return float(np.median(times))

    def track_wrong_ranks(self, model: str) -> int:
        """Count our ranks, in all sizes and places, that differ from the exact one."""
        return sum(design_space(copy).rank != self.exact for copy in self.copies)

    def row(self, model: str) -> dict[str, int]:
        """Exact rank, ours, the peer's, its poses; its time with poses given, microseconds."""
        ours = design_space(next(self.linkages)).rank
        given = round(1e6 * self.poses_given())
        return {
            "exact": self.exact,
            "ours": ours,
            "peer": self.found,
            "poses": self.count,
            "µs, poses given": given,
        }


class WhereFewPosesDo(DesignSpaceAgainstSampling):
    """Linkages most favourable to sampling: two or three poses are enough."""

    params = (("bennett",), ("slider_crank",))
    claims = (("time_ours", "time_sampling", 1.0), ("track_wrong_ranks", 0.0))
