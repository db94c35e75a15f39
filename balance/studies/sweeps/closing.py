"""Close the loops of many geometries at once, by continuation from the model's own pose.

The parameters go from those of the model, λ = 0, to those of the row, λ = 1, in steps that are
halved until Newton's method stays near its own first step, so that the branch does not change.
Inputs keep their positions. Where that leads nowhere, they move too, by steps of least norm: a
four-bar may well close at another angle of its crank.

Geometries take their steps side by side; what happens to one follows from it alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import (
    SWEEP_BRANCH_DISTANCE,
    SWEEP_CLOSED,
    SWEEP_DAMPING,
    SWEEP_FREE_DAMPING,
    SWEEP_NEWTON_DONE,
)
from balance.studies.sweeps.closing_kernels import close_each, closing_workspace, place_each
from balance.studies.sweeps.placing import OpenGeometries, Placer
from kinematics.closure.joint_positions import input_chain
from kinematics.model.arrays import freeze
from kinematics.model.chain import loop_signs
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array, Flags, IntArray

Between = Callable[[IntArray, Array], Mapping[str, Array]]

# Most Newton steps, and the shortest step of λ.
NEWTON_STEPS, SHORTEST = 12, 1.0 / 64.0


class ClosedGeometries(NamedTuple):
    """Geometries at poses that close their loops.

    Attributes:
        closed: 1 if the inputs kept their positions, 2 if they had to move, 0 if the loops of
            the row do not close (rows,).
        screws: of the joints at these poses (rows, n, 6), inertial frame, SI units.
        q: joint positions from the reference pose of the model (rows, n), radians and metres.
        H: displacement of each link by them (rows, n + 1, 4, 4), SI; the last is the ground's.
        placed: the geometries before their loops were closed.
    """

    closed: IntArray
    screws: Array
    q: Array
    H: Array
    placed: OpenGeometries


def newton_limits(free: bool) -> tuple[float, float, float, float, int]:
    """Return the limits of `close_each`.

    Args:
        free: whether inputs move too.
    """
    return (
        SWEEP_FREE_DAMPING if free else SWEEP_DAMPING,
        SWEEP_CLOSED,
        SWEEP_NEWTON_DONE,
        SWEEP_BRANCH_DISTANCE,
        NEWTON_STEPS,
    )


def continue_rows(
    solve: Callable[[IntArray, Array], tuple[Array, Flags]],
    rows: IntArray,
    q: Array,
    share: Array,
) -> None:
    """Follow rows as far as loops close, in steps that are doubled, and halved where they fail.

    Args:
        solve: closes the loops of rows at the λ of each; returns joint positions, and where it
            did.
        rows: rows to follow.
        q: in and out: joint positions of all rows (count, n).
        share: in and out: λ that each row has reached (count,).
    """
    step = np.ones(share.size)
    while rows.size:
        step[rows] = np.minimum(step[rows], 1.0 - share[rows])
        ahead = share[rows] + step[rows]
        solutions, good = solve(rows, ahead)
        q[rows[good]], share[rows[good]] = solutions[good], ahead[good]
        step[rows] *= np.where(good, 2.0, 0.5)
        rows = rows[(share[rows] < 1.0) & (step[rows] >= SHORTEST)]


class Closer:
    """Closes the loops of geometries of one model."""

    def __init__(self, linkage: Linkage, placer: Placer) -> None:
        """Prepare the arrays of the model.

        Args:
            linkage: the model at its reference pose.
        """
        self.placer, self.chain = placer, input_chain(linkage)
        chain = self.chain
        signs = freeze(loop_signs(chain.parent, chain.ends))
        parts = chain.parent, chain.ends, signs, chain.mimics, freeze(signs.T @ signs)
        self._topology, self._workspace = (
            parts,
            closing_workspace(chain.parent.size, len(chain.ends), len(chain.mimics)),
        )
        self._sliding = np.array([joint.kind == "prismatic" for joint in linkage.joints])
        coupled = np.any(signs != 0.0, axis=0) | np.any(chain.mimics != 0.0, axis=0)
        self._coupled = freeze(np.flatnonzero(coupled), np.int64)
        self._dependent = freeze(np.intersect1d(self._coupled, chain.dependent), np.int64)

    def close(
        self, rows: int, values: Mapping[str, Array], between: Between
    ) -> ClosedGeometries:
        """Close the loops.

        Args:
            values: of each path (rows,), metres and radians.
            between: computes these values for some rows and for the λ of each (rows,).
        """
        n = self.chain.parent.size
        q, share = np.zeros((rows, n)), np.zeros(rows)
        closed = np.zeros(rows, dtype=np.int64)
        for mode, joints in ((1, self._dependent), (2, self._coupled)):
            open_rows = np.flatnonzero(share < 1.0)
            if open_rows.size:
                # From the pose of the model anew: where inputs stop, a dead centre is near.
                q[open_rows], share[open_rows] = 0.0, 0.0
                self._follow(between, open_rows, joints, q, share)
            closed[open_rows[share[open_rows] == 1.0]] = mode
        placed = self.placer.place(rows, values)
        s, _ = self.to_chain(placed)
        H, there = np.empty((rows, n + 1, 4, 4)), np.empty_like(s)
        H[:, n] = np.eye(4)
        place_each(self.chain.parent, s, q, H, there, np.empty((4, 4)))
        return ClosedGeometries(
            closed, self._from_chain(there), q * self.chain.units, self._si(H), placed
        )

    def _follow(
        self,
        between: Between,
        rows: IntArray,
        joints: IntArray,
        q: Array,
        share: Array,
    ) -> None:
        """Follow rows from where they are to their own parameters, as far as loops close."""

        def solve(rows: IntArray, ahead: Array) -> tuple[Array, Flags]:
            placed = self.placer.place(rows.size, between(rows, ahead))
            return self._newton(placed, q[rows], joints)

        continue_rows(solve, rows, q, share)

    def _newton(
        self, placed: OpenGeometries, start: Array, joints: IntArray
    ) -> tuple[Array, Flags]:
        """Close loops by Newton's method; return joint positions, and where it did."""
        q, good = start.copy(), np.zeros(len(start), dtype=np.bool_)
        limits = newton_limits(free=joints is self._coupled)
        topology = *self._topology, joints
        close_each(topology, self.to_chain(placed), limits, q, good, self._workspace)
        return q, good

    def to_chain(self, placed: OpenGeometries) -> tuple[Array, Array]:
        """Convert screws and gaps to the coordinates of the model's chain."""
        gaps, frame = placed.gaps.copy(), self.chain.frame
        o = frame.origin
        gaps[..., :3, 3] = (gaps[..., :3, :3] @ o + gaps[..., :3, 3] - o) / frame.length
        return self.screws_to_chain(placed.screws), gaps

    def screws_to_chain(self, screws: Array) -> Array:
        """Convert screws (rows, n, 6) from SI units to the coordinates of the chain."""
        out, frame = screws.copy(), self.chain.frame
        out[..., 3:] += np.cross(screws[..., :3], frame.origin)
        out[:, ~self._sliding, 3:] /= frame.length
        return out

    def _from_chain(self, screws: Array) -> Array:
        """Convert screws (rows, n, 6) from the coordinates of the chain to SI units."""
        out, frame = screws.copy(), self.chain.frame
        out[:, ~self._sliding, 3:] *= frame.length
        out[..., 3:] -= np.cross(screws[..., :3], frame.origin)
        return out

    def _si(self, H: Array) -> Array:
        """Convert displacements from the coordinates of the chain to SI units, in place."""
        o = self.chain.frame.origin
        H[..., :3, 3] = self.chain.frame.length * H[..., :3, 3] + o - H[..., :3, :3] @ o
        return H
