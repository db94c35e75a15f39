"""Passing a pose in which several paths meet, on the path that leads through it.

Near that pose the null space is ill-conditioned, and an integrator would turn off the path. The
pose lies ahead if the smallest singular value that the equations keep falls towards zero.
Newton's method finds it, and the local curve through it along which the path arrives continues
the path.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.motion.motion_tolerances import ON_LOCAL_CURVE
from balance.motion.paths.branches import tangent_directions
from balance.motion.paths.local_curve import LocalArc, solve_local_curve
from balance.motion.paths.meeting_poses import meeting_pose
from balance.motion.paths.rest_equations import RestEquations, RowsAtPose

Array = NDArray[np.float64]

# Distance ahead, in arc length, from which a meeting is looked for, and the furthest one found.
SIGHT = 0.09
REACH = 0.2


class PassedMeeting(NamedTuple):
    """The part of a path from a pose through a meeting to the far end of the local curve.

    Attributes:
        arc: the local curve.
        first: arc length of the local curve at the pose.
        sense: 1 or -1, in which sense the path runs along it.
        length: of this part.
        meeting: distance of the meeting from the pose along it.
        tangent: tangent at the far end (w,).
    """

    arc: LocalArc
    first: float
    sense: float
    length: float
    meeting: float
    tangent: Array

    def positions(self, s: float) -> Array:
        """Compute joint positions (n,) at an arc length from the pose."""
        low, high = self.arc.extent
        where = float(np.clip(self.first + self.sense * s, low, high))
        return np.asarray(self.arc.positions(np.array([where]))[0])


class MeetingAhead:
    """Watches for meetings ahead of a path whose null space has dimension 1."""

    def __init__(self, equations: RestEquations) -> None:
        """Start without knowing how the singular values change."""
        self.equations = equations
        self.before: tuple[float, float] | None = None

    def look(self, here: RowsAtPose, s: float, tangent: Array) -> PassedMeeting | None:
        """Find a meeting ahead through which the path leads.

        Args:
            here: the equations in the last pose of the path.
            tangent: its tangent (w,).

        Returns:
            The way through it; None if there is none, or the path only passes near it.
        """
        if self.equations.width < 2:
            return None
        value = float(np.linalg.svd(here.rows, compute_uv=False)[self.equations.width - 2])
        before, self.before = self.before, (s, value / here.scale)
        if before is None or s <= before[0]:
            return None
        fall = (before[1] - self.before[1]) / (s - before[0])
        if not fall > 0.0 or self.before[1] > fall * SIGHT:
            return None
        met = meeting_pose(self.equations, here, 1, REACH)
        return None if met is None else self._through(here, met[0], tangent)

    def _through(
        self, here: RowsAtPose, met: RowsAtPose, tangent: Array
    ) -> PassedMeeting | None:
        """Find the local curve through a meeting on which a pose lies."""
        equations = self.equations
        inputs = equations.linkage.positions_of(equations.linkage.inputs)
        y = equations.basis.T @ (here.q[inputs] - met.q[inputs])
        for v in tangent_directions(equations, met, 1).directions:
            sigma = float(v @ y)
            if sigma * float(v @ tangent) >= 0.0 or np.linalg.norm(y) > 2.0 * abs(sigma):
                continue
            curve = solve_local_curve(equations, met, v)
            if curve is None or abs(sigma) > curve.advance:
                continue
            off = y - curve.coordinates(np.array([sigma]))[0][0]
            if np.linalg.norm(off) <= ON_LOCAL_CURVE:
                return self._part(LocalArc(equations, curve), sigma)
        return None

    def _part(self, arc: LocalArc, sigma: float) -> PassedMeeting:
        """Make the part of the path from an advance of the local curve to its far end."""
        first, sense = arc.length_at(sigma), -np.sign(sigma)
        ends, _ = arc.ends()
        _, tangent, far = ends[0 if sense > 0.0 else 1]
        return PassedMeeting(arc, first, sense, abs(first) + far, abs(first), tangent)
