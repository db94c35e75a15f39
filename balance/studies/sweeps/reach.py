"""Whether a point of a link reaches a target, in many geometries.

A spherical joint at the point welds the link to the ground there, as a further loop. Its gap is
closed in steps along the straight line to the target, with all joints moving by steps of least
norm: the linkage reaches the target if it can follow that line on its branch.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from balance.motion.motion_tolerances import (
    SWEEP_BRANCH_DISTANCE,
    SWEEP_CLOSED,
    SWEEP_FREE_DAMPING,
    SWEEP_NEWTON_DONE,
)
from balance.studies.sweeps.closing import NEWTON_STEPS, SHORTEST, ClosedGeometries, Closer
from balance.studies.sweeps.closing_kernels import close_each, closing_workspace
from kinematics.model.arrays import freeze
from kinematics.model.chain import arrange_loops, loop_signs
from kinematics.model.linkage import Linkage

Array = NDArray[np.float64]


class Reach:
    """A link of a model whose points are to reach targets."""

    def __init__(self, linkage: Linkage, closer: Closer, link: str) -> None:
        """Extend the chain of the model by a spherical joint.

        Args:
            link: name of the link.
        """
        self._closer, self._place, self._name = closer, linkage.places[link], link
        chain = arrange_loops(linkage)
        n, at = chain.parent.size, self._place.link
        parent = np.append(chain.parent, [at, n, n + 1])
        ends = np.vstack([chain.ends, [n + 2, -1]])
        mimics = np.hstack([chain.mimics, np.zeros((len(chain.mimics), 3))])
        signs = loop_signs(parent, ends)
        moving = np.any(signs != 0.0, axis=0) | np.any(mimics != 0.0, axis=0)
        self._topology = (
            freeze(parent, np.int64), freeze(ends, np.int64), freeze(signs), freeze(mimics),
            freeze(signs.T @ signs), freeze(np.flatnonzero(moving), np.int64),
        )  # fmt: skip
        self._axes = np.roll(linkage.chain.frame.R, 1, axis=0)  # the normal of a plane first
        self._workspace = closing_workspace(n + 3, len(ends), len(mimics))

    def reaches(
        self, closed: ClosedGeometries, rows: NDArray[np.int64], points: Array,
        target: Sequence[float],
    ) -> NDArray[np.bool_]:  # fmt: skip
        """Decide which geometries bring their points of the link to a target.

        Args:
            points: in the frame of the link (rows, 3), metres; one of each geometry.
            target: in the inertial frame (3,), metres.

        Returns:
            Whether each of these rows does (rows,).
        """
        frame = self._closer.chain.frame
        screws, gaps = self._closer.to_chain(closed.placed)
        links = closed.placed.links[self._name]
        frames = np.broadcast_to(links, (len(screws), 4, 4))[rows] @ self._place.pose
        here = (frames[:, :3, :3] @ points[rows][..., None])[..., 0] + frames[:, :3, 3]
        here = (here - frame.origin) / frame.length
        goal = (np.array(target, dtype=np.float64) - frame.origin) / frame.length
        axes = np.broadcast_to(self._axes, (rows.size, 3, 3))
        moments = np.cross(here[:, None], axes)
        added = np.concatenate([axes, moments], axis=-1)
        q = np.concatenate(
            [closed.q[rows] / self._closer.chain.units, np.zeros((rows.size, 3))], 1
        )
        start = self._starts(closed, rows, here)
        welds = np.tile(np.eye(4), (rows.size, 1, 1, 1))
        given = np.concatenate([screws[rows], added], axis=1), gaps[rows]
        return self._follow(given, here, start, goal, welds, q)

    def _starts(self, closed: ClosedGeometries, rows: NDArray[np.int64], here: Array) -> Array:
        """Compute where the point is at the closed poses (rows, 3), in units of the chain."""
        frame = self._closer.chain.frame
        H = closed.H[rows, self._place.link]
        si = frame.length * here + frame.origin
        there = (H[:, :3, :3] @ si[..., None])[..., 0] + H[:, :3, 3]
        return np.asarray((there - frame.origin) / frame.length)

    def _follow(
        self, given: tuple[Array, Array], here: Array, start: Array, goal: Array, welds: Array,
        q: Array,
    ) -> NDArray[np.bool_]:  # fmt: skip
        """Follow the straight line from the start of each row to the goal."""
        share, step = np.zeros(len(q)), np.ones(len(q))
        limits = (
            SWEEP_FREE_DAMPING, SWEEP_CLOSED, SWEEP_NEWTON_DONE, SWEEP_BRANCH_DISTANCE,
            NEWTON_STEPS,
        )  # fmt: skip
        rows = np.arange(len(q))
        while rows.size:
            step[rows] = np.minimum(step[rows], 1.0 - share[rows])
            ahead = share[rows] + step[rows]
            line = start[rows] + ahead[:, None] * (goal - start[rows])
            welds[rows, 0, :3, 3] = line - here[rows]
            solutions, good = q[rows], np.zeros(rows.size, dtype=np.bool_)
            gaps = np.concatenate([given[1][rows], welds[rows]], axis=1)
            close_each(
                self._topology, (given[0][rows], gaps), limits, solutions, good, self._workspace
            )
            q[rows[good]], share[rows[good]] = solutions[good], ahead[good]
            step[rows] *= np.where(good, 2.0, 0.5)
            rows = rows[(share[rows] < 1.0) & (step[rows] >= SHORTEST)]
        return share == 1.0
