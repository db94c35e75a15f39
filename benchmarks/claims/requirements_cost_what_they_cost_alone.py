"""Claim: a list of requirements costs at most 1.2 times what its requirements cost one by one.

Their conditions are stacked, and the rank of the whole is decided once. The error is the
difference of its rank from that of a QR with pivots of the stacked momentum regressors of
Pinocchio, at closed poses of each region.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from balance import require
from benchmarks.inputs.sampling import ZERO_PIVOT, Sampling
from kinematics.loading.model_gallery import load

# For each linkage its requirements, and for the peer the rows of the momentum that vanish, the
# direction of the inputs (None: every one), and whether at one displacement alone.
LISTS = {
    "fuga_i": (
        ("force", slice(0, 2), None, 0.0),
        ("dynamic at u1=0.1", slice(0, 3), None, 0.1),
    ),
    "five_bar": (
        ("force", slice(0, 2), None, 0.0),
        ("dynamic along u1=u2", slice(0, 3), (1.0, 1.0), 0.0),
    ),
    "three_rsr": (
        ("dynamic along u1=u2", slice(0, 6), "u1=u2", 0.0),
        ("dynamic along u2=u3", slice(0, 6), "u2=u3", 0.0),
        ("dynamic along u3=u1", slice(0, 6), "u3=u1", 0.0),
    ),
}
# Directions of two freedoms of the 3-RSR on its planes.
PLANES = {
    "u1=u2": ((1.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    "u2=u3": ((0.0, 1.0, 1.0), (1.0, 0.0, 0.0)),
    "u3=u1": ((1.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
}
# Poses of each region, and how far they are from the reference pose, radians.
POSES, REACH = 12, 0.1


class RequirementsTogether:
    """In the plane, in space, and on three planes at once."""

    params = tuple((name,) for name in LISTS)
    claims = (("time_together", "time_one_by_one", 1.2), ("track_wrong_rank", 0.0))

    def setup(self, model: str) -> None:
        """Load the linkage, and count the conditions of the peer."""
        self.linkage = load(model)
        self.texts = [text for text, *_ in LISTS[model]]
        self.time_one_by_one(model)

    def time_together(self, model: str) -> None:
        """All in one."""
        require(self.linkage, self.texts)

    def time_one_by_one(self, model: str) -> None:
        """Each by itself."""
        for text in self.texts:
            require(self.linkage, text)

    def track_wrong_rank(self, model: str) -> int:
        """By how much our rank differs from that of sampled regressors."""
        sampled = self._sampled_rank(model)
        return abs(require(self.linkage, self.texts).rank - sampled)

    def _sampled_rank(self, model: str) -> int:
        """Rank of the stacked regressors of Pinocchio."""
        peer, rng = Sampling(self.linkage, self.linkage.planar), np.random.default_rng(7)
        count = peer.inputs.size
        blocks = []
        for _, rows, way, at in LISTS[model]:
            given = PLANES.get(way, (way,)) if way is not None else np.eye(count)
            basis = np.array(given).T
            for _ in range(1 if at else POSES):
                u = REACH * basis @ rng.uniform(-1.0, 1.0, basis.shape[1])
                if at:
                    u = at * np.eye(count)[0]
                q = peer.close_loops(u)
                C = peer.rates(q) @ basis
                height = len(peer.rows)
                momenta = peer.regressor(q, C).reshape(basis.shape[1], height, -1)[:, rows]
                block = momenta.reshape(-1, momenta.shape[2])
                blocks.append(block / np.linalg.norm(block))
        R = scipy.linalg.qr(np.concatenate(blocks), mode="r", pivoting=True)[0]
        return int(np.sum(np.abs(np.diag(R)) > ZERO_PIVOT))
