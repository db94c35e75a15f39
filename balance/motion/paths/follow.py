"""Integration of a path from a pose, with its events.

The state is the vector of all joint positions, the parameter the arc length s in it, in radians
and characteristic lengths:

    dq/ds = C N y / |C N y|,    N = null space of A(q),  C the joint rates per input rate

where y is the last tangent in a null space of dimension 1, and the first tangent, projected,
in a larger one. Each evaluation first closes the loops, so that their error does not grow.

Near that pose the null space is ill-conditioned, and an integrator would turn off the path. The
pose lies ahead if the smallest singular value that the equations keep falls towards zero.
Newton's method finds it, and the local curve through it along which the path arrives continues
the path.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import (
    MOMENTUM_NULL,
    ON_LOCAL_CURVE,
    PATH_CONDITIONING,
    PATH_EDGE_RATE,
    PATH_MOMENTUM,
    PATH_STEP_ERROR,
)
from balance.motion.paths.branches import tangent_directions
from balance.motion.paths.local_curve import LocalArc, solve_local_curve
from balance.motion.paths.meeting_poses import meeting_pose
from balance.motion.paths.rest_equations import RestEquations, RowsAtPose
from kinematics.errors import PoseError
from kinematics.numerics.array_types import Array
from kinematics.numerics.integration import Integration, StalledError
from kinematics.wording import number_text

Dense = Callable[[float], Array]

# Longest step of the integration: dense output of longer ones is less smooth.
LONGEST_STEP = 0.03
# Steps are shortened so often where the loops do not close within one.
MAX_RETRIES = 6
# Most steps of one arc.
MAX_STEPS = 20_000
# Distance ahead, in arc length, from which a meeting is looked for, and the furthest one found.
SIGHT = 0.09
REACH = 0.2


def _above(j: int, bound: float, q: Array) -> float:
    """Compute how far a joint is above a bound."""
    return float(q[j]) - bound


class PathEvent(NamedTuple):
    """What happens on a path.

    Attributes:
        kind: ``"length"`` (as long as asked for), ``"limit"`` of a joint, ``"singular"`` pose
        of
            the linkage, ``"edge"`` of the workspace, ``"meeting"`` of several paths,
            ``"stop"`` (the direction without reaction turns away from the one asked for) or
            ``"momentum"`` (rank of the equations rises: no direction is left).
        s: arc length from the start of the path, negative before it.
        text: in words.
    """

    kind: str
    s: float
    text: str


class Arc(NamedTuple):
    """A path to one side of its start.

    Attributes:
        pieces: ends in s, and the dense output up to there, in order.
        events: meetings along it, then its end.
    """

    pieces: tuple[tuple[float, Dense], ...]
    events: tuple[PathEvent, ...]

    @property
    def length(self) -> float:
        """Arc length reached."""
        return self.events[-1].s

    def positions(self, s: float) -> Array:
        """Compute joint positions (n,), before the loops are closed, at an arc length."""
        for end, dense in self.pieces:
            if s <= end:
                return np.asarray(dense(s))
        return np.asarray(self.pieces[-1][1](s))


class _Direction:
    """The right side of the differential equation, with the tangent it continues."""

    def __init__(self, equations: RestEquations, tangent: Array, dimension: int) -> None:
        """Start along a tangent (w,) in a null space of some dimension."""
        self.equations, self.dimension = equations, dimension
        self.first = self.last = tangent

    def tangent(self, here: RowsAtPose) -> Array:
        """Compute the tangent in the coordinates, of length 1 in all joints."""
        _, sizes, Vt = np.linalg.svd(here.rows, full_matrices=True)
        small = int(np.count_nonzero(sizes <= MOMENTUM_NULL * here.scale))
        small += max(0, Vt.shape[0] - sizes.size)
        N = Vt[Vt.shape[0] - max(self.dimension, small) :].T
        along = self.last if self.dimension == 1 else self.first
        y = N @ (N.T @ along)
        size = float(np.linalg.norm(here.rates @ y))
        if not size > 1e-9:
            raise PoseError("the direction vanishes")
        return np.asarray(y / size)

    def __call__(self, s: float, q: Array) -> Array:
        """Compute dq/ds."""
        here = self.equations.at(self.equations.close(q))
        return np.asarray(here.rates @ self.tangent(here))


def follow_arc(
    equations: RestEquations,
    start: Array,
    tangent: Array,
    length: float,
    dimension: int,
    limits: Array | None = None,
    first: float = 0.0,
) -> Arc:
    """Integrate a path to one side.

    Args:
        equations: the equations of the linkage.
        start: joint positions of a closed pose (n,), chain units.
        tangent: direction in the coordinates (w,).
        length: arc length at which to stop.
        dimension: dimension of the null space along the path.
        limits: least and largest positions of the joints (2, n), chain units.
        first: arc length at the start.

    Returns:
        The path, and why it ends.
    """
    walk = _Walk(equations, _Direction(equations, tangent, dimension), limits, length)
    if not length > first:
        return Arc(((first, lambda _: start),), (PathEvent("length", first, ""),))
    walk.run(start, first)
    pieces = walk.pieces or [(first, lambda _: start)]
    return Arc(tuple(pieces), tuple(walk.events))


class _Walk:
    """The integration of one arc, step by step."""

    def __init__(
        self,
        equations: RestEquations,
        direction: _Direction,
        limits: Array | None,
        length: float,
    ) -> None:
        """Start without pieces and events."""
        self.equations, self.direction, self.length = equations, direction, length
        self.watch = _Watch(equations, direction, limits)
        exact = direction.dimension == 1 and not equations.demand.tolerance
        self.ahead = _MeetingAhead(equations) if exact else None
        self.pieces: list[tuple[float, Dense]] = []
        self.events: list[PathEvent] = []
        self.longest, self.retries = LONGEST_STEP, 0

    def run(self, q: Array, s: float) -> None:
        """Integrate from a pose to the event that ends the path."""
        integration = None
        for _ in range(MAX_STEPS):
            try:
                integration = integration or self._start(q, s)
                integration.step()
            except PoseError:
                self.retries += 1
                if self.retries > MAX_RETRIES:
                    self.events.append(self.watch.lost(q, s))
                    return
                integration, self.longest = None, self.longest / 4.0
                continue
            except StalledError:
                self.events.append(self.watch.lost(q, s))
                return
            solver = integration.solver
            ended = self._keep(s, float(solver.t), solver.dense_output())
            if ended:
                return
            q, s = self.equations.close(solver.y), float(solver.t)
            if not integration.running:
                self.events.append(PathEvent("length", s, "as long as asked for"))
                return
            passed = self._look(q, s)
            if passed is not None:
                if self._pass(passed, s):
                    return
                q, s, integration = (
                    self.equations.close(passed.positions(passed.length)),
                    (s + passed.length),
                    None,
                )
        self.events.append(PathEvent("stop", s, "too many steps"))

    def _start(self, q: Array, s: float) -> Integration:
        """Start the integration at a pose."""
        error = max(PATH_STEP_ERROR, self._round_off(q))
        return Integration(
            self.direction, s, q, self.length, rtol=error, atol=error, max_step=self.longest
        )

    def _round_off(self, q: Array) -> float:
        """Estimate the round-off of the direction: that of A over its least size that counts.

        A part of the direction with a smaller size moves the base no more than round-off.
        """
        here = self.equations.at(q)
        sizes = np.linalg.svd(here.rows, compute_uv=False) / (here.scale or 1.0)
        counted = self.equations.width - self.direction.dimension
        kept = sizes[:counted][sizes[:counted] > MOMENTUM_NULL]
        return float(np.finfo(np.float64).eps / kept.min()) if kept.size else 0.0

    def _keep(self, first: float, last: float, dense: Dense) -> bool:
        """Keep one step and its events; return whether the path ends in it."""
        self.pieces.append((last, dense))
        met, end = self.watch.step(first, last, dense)
        self.events += met
        if end is not None:
            self.events.append(end)
        return end is not None

    def _look(self, q: Array, s: float) -> _PassedMeeting | None:
        """Look for a meeting ahead."""
        if self.ahead is None:
            return None
        return self.ahead.look(self.equations.at(q), s, self.direction.last)

    def _pass(self, passed: _PassedMeeting, s: float) -> bool:
        """Continue through a meeting; return whether the path ends on the way."""
        end = min(s + passed.length, self.length)
        self.pieces.append((end, lambda x: passed.positions(x - s)))
        if s + passed.meeting <= end:
            self.events.append(PathEvent("meeting", s + passed.meeting, "several paths meet"))
        self.direction.last = passed.tangent
        if end >= self.length:
            self.events.append(PathEvent("length", end, "as long as asked for"))
        return end >= self.length


class _Watch:
    """Functions of the pose whose zeros are events."""

    def __init__(
        self, equations: RestEquations, direction: _Direction, limits: Array | None
    ) -> None:
        """Watch a path from its start on."""
        self.equations, self.direction, self.limits = equations, direction, limits

    def step(
        self, first: float, last: float, dense: Dense
    ) -> tuple[list[PathEvent], PathEvent | None]:
        """Look at one step of the integration: meetings in it, and the event that ends it."""
        end = self._stop(first, last, dense)
        at = last if end is None else end.s
        equations, direction = self.equations, self.direction
        before = equations.at(equations.close(np.asarray(dense(first))))
        after = equations.at(equations.close(np.asarray(dense(at))))
        tangent = direction.tangent(after)
        met = []
        turn = self._orientation(before, after, tangent)
        if turn is not None:
            s = self._locate(first, at, dense, turn)
            met = [PathEvent("meeting", s, "several paths meet")]
        direction.last = tangent / np.linalg.norm(tangent)
        return met, end

    def _stop(self, first: float, last: float, dense: Dense) -> PathEvent | None:
        """Find the first event in a step that ends the path."""
        events: list[PathEvent] = []
        here = self.equations.at(self.equations.close(np.asarray(dense(last))))
        if here.conditioning < PATH_CONDITIONING:
            s = self._root(
                lambda q: self.equations.at(q).conditioning - PATH_CONDITIONING,
                first,
                last,
                dense,
            )
            events.append(self.lost(self.equations.close(np.asarray(dense(s))), s))
        if self.limits is not None:
            for j in np.flatnonzero((here.q < self.limits[0]) | (here.q > self.limits[1])):
                bound = self.limits[0 if here.q[j] < self.limits[0][j] else 1][j]
                s = self._root(partial(_above, int(j), float(bound)), first, last, dense)
                name = self.equations.linkage.joints[j].name
                events.append(PathEvent("limit", s, f"{name} is at its limit"))
        tolerance = self.equations.demand.tolerance
        if tolerance and self._share(here) > tolerance:
            s = self._root(
                lambda q: self._share(self.equations.at(q)) - tolerance, first, last, dense
            )
            text = f"the momentum reaches {number_text(tolerance, '.3g')} of the bodies' own"
            events.append(PathEvent("momentum", s, text))
        elif not tolerance and self._momentum(here) > PATH_MOMENTUM:
            events.append(PathEvent("momentum", first, "no direction without reaction is left"))
        return min(events, key=lambda event: event.s, default=None)

    def _momentum(self, here: RowsAtPose) -> float:
        """Compute the momentum along the tangent over those of the bodies."""
        tangent = self.direction.tangent(here)
        size = here.scale * float(np.linalg.norm(tangent)) or 1.0
        return float(np.linalg.norm(here.rows @ tangent)) / size

    def _share(self, here: RowsAtPose) -> float:
        """Compute the momentum along the tangent over that of the bodies at these rates."""
        return self.equations.share(here, self.direction.tangent(here))

    def lost(self, q: Array, s: float) -> PathEvent:
        """Name a pose beyond which the loops do not close, or branches of the linkage meet."""
        here = self.equations.at(q)
        try:
            self.direction.tangent(here)
        except PoseError:
            return PathEvent("stop", s, "the direction without reaction turns away")
        if float(np.linalg.norm(here.rates, 2)) > PATH_EDGE_RATE:
            return PathEvent("edge", s, "edge of the workspace: the loops close no further")
        return PathEvent("singular", s, "singular pose of the linkage")

    def _root(
        self, function: Callable[[Array], float], first: float, last: float, dense: Dense
    ) -> float:
        """Find where a function of the pose vanishes in a step."""
        from scipy.optimize import brentq

        def value(s: float) -> float:
            return function(self.equations.close(np.asarray(dense(s))))

        if value(first) * value(last) >= 0.0:
            return first
        return float(brentq(value, first, last, xtol=1e-13))

    def _orientation(
        self, before: RowsAtPose, after: RowsAtPose, tangent: Array
    ) -> Array | None:
        """Return the rows that the equations keep, if they turn over within a step."""
        if self.direction.dimension != 1 or before.rows.shape[1] < 2:
            return None
        if self.equations.demand.tolerance:
            return None
        U = np.linalg.svd(before.rows)[0][:, : before.rows.shape[1] - 1]
        sizes = [
            float(np.linalg.det(np.vstack([U.T @ here.rows / here.scale, y])))
            for here, y in ((before, self.direction.last), (after, tangent))
        ]
        return U if sizes[0] * sizes[1] < 0.0 else None

    def _locate(self, first: float, last: float, dense: Dense, U: Array) -> float:
        """Find the pose in a step in which the equations drop rank."""
        from scipy.optimize import brentq

        def value(s: float) -> float:
            here = self.equations.at(self.equations.close(np.asarray(dense(s))))
            y = self.direction.tangent(here)
            return float(np.linalg.det(np.vstack([U.T @ here.rows / here.scale, y])))

        return float(brentq(value, first, last, xtol=1e-12))


class _PassedMeeting(NamedTuple):
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


class _MeetingAhead:
    """Watches for meetings ahead of a path whose null space has dimension 1."""

    def __init__(self, equations: RestEquations) -> None:
        """Start without knowing how the singular values change."""
        self.equations = equations
        self.before: tuple[float, float] | None = None

    def look(self, here: RowsAtPose, s: float, tangent: Array) -> _PassedMeeting | None:
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
    ) -> _PassedMeeting | None:
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

    def _part(self, arc: LocalArc, sigma: float) -> _PassedMeeting:
        """Make the part of the path from an advance of the local curve to its far end."""
        first, sense = arc.length_at(sigma), -np.sign(sigma)
        ends, _ = arc.ends()
        _, tangent, far = ends[0 if sense > 0.0 else 1]
        return _PassedMeeting(arc, first, sense, abs(first) + far, abs(first), tangent)
