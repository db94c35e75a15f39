"""A pose reached along paths that meet: where only one path leaves a pose in general.

The paths through a pose and through the meetings on them are a network of curves. A search in
its breadth follows them until one leads through the pose; the linkage then moves on segments,
and rests in the meetings between them.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import PATH_REACHED
from balance.motion.paths.follow import PathEvent
from balance.motion.paths.path import ReactionlessPath, sample_path
from balance.motion.paths.path_search import paths_through
from balance.motion.paths.rest_equations import RestEquations, RowsAtPose
from kinematics.numerics.array_types import Array

# Most meetings on the way, and most that are looked at.
DEPTH, MOST = 3, 12
# Lengths of paths to either side of a meeting, over the distance to the pose; and the least. A
# long path may pass poses near which its samples leave a momentum; a shorter one does not.
REACHES, LEAST_REACH = (3.0, 1.8), 0.6
# Samples of a segment, at least, and for each unit of its length.
SAMPLES, PER_LENGTH = 65, 200


class _Leg(NamedTuple):
    """The way to a meeting: the leg before, the path, and places on it."""

    before: _Leg | None
    path: ReactionlessPath
    first: float
    last: float


def path_through_meetings(
    equations: RestEquations, here: RowsAtPose, target: Array
) -> tuple[ReactionlessPath, ...]:
    """Find segments of paths from a pose to another one.

    Args:
        here: the equations at the start.
        target: displacements of the inputs at the end (mobility,), rad and m.

    Returns:
        The segments, in order; none if the pose is on no path that was found.
    """
    units = equations.units
    inputs = equations.linkage.positions_of(equations.linkage.inputs)
    first = here.q[inputs] * units
    distance = float(np.linalg.norm((target - first) / units))
    for reach in REACHES:
        segments = _search(equations, here, target, max(LEAST_REACH, reach * distance))
        if segments:
            return segments
    return ()


def _search(
    equations: RestEquations, here: RowsAtPose, target: Array, length: float
) -> tuple[ReactionlessPath, ...]:
    """Search with paths of a length; see `path_through_meetings`."""
    units = equations.units
    inputs = equations.linkage.positions_of(equations.linkage.inputs)
    waiting: deque[tuple[_Leg | None, RowsAtPose]] = deque([(None, here)])
    seen = [here.q]
    looked = 0
    while waiting and looked < MOST:
        before, pose = waiting.popleft()
        looked += 1
        paths, meetings = paths_through(equations, pose, length)
        for path in paths:
            where = _place_on(path, target, units)
            if where is not None:
                return _segments(equations, _Leg(before, path, 0.0, where))
        if _depth(before) == DEPTH:
            continue
        for meeting in meetings:
            if any(np.abs(meeting.q - q).max() < 1e-6 for q in seen):
                continue
            seen.append(meeting.q)
            for path in paths:
                where = _place_on(path, meeting.q[inputs] * units, units)
                if where is not None:
                    waiting.append((_Leg(before, path, 0.0, where), meeting))
                    break
    return ()


def _depth(leg: _Leg | None) -> int:
    """Count the legs of a way."""
    return 0 if leg is None else 1 + _depth(leg.before)


def _place_on(path: ReactionlessPath, u: Array, units: Array) -> float | None:
    """Find the arc length at which a path leads through a pose; None if it does not."""
    from scipy.interpolate import make_interp_spline
    from scipy.optimize import minimize_scalar

    spline = make_interp_spline(path.s, path.u / units, k=5)
    distance = np.linalg.norm((path.u - u) / units, axis=1)
    k = int(distance.argmin())
    ends = path.s[max(k - 1, 0)], path.s[min(k + 1, len(path.s) - 1)]
    least = minimize_scalar(
        lambda s: float(np.linalg.norm(spline(s) - u / units) ** 2),
        bounds=ends,
        method="bounded",
        options={"xatol": 1e-12},
    )
    return float(least.x) if np.sqrt(least.fun) <= PATH_REACHED else None


def _segments(equations: RestEquations, leg: _Leg | None) -> tuple[ReactionlessPath, ...]:
    """Cut the paths of a way at its meetings."""
    from scipy.interpolate import make_interp_spline

    pieces: list[ReactionlessPath] = []
    while leg is not None:
        if abs(leg.last - leg.first) > PATH_REACHED:
            spline = make_interp_spline(leg.path.s, leg.path.q / equations.chain.units, k=5)
            span = abs(leg.last - leg.first)
            count = max(SAMPLES, int(PER_LENGTH * span))
            q = np.array(
                [equations.close(spline(s)) for s in np.linspace(leg.first, leg.last, count)]
            )
            ends = (PathEvent("start", 0.0, "start"), PathEvent("target", span, "its end"))
            pieces.append(sample_path(equations, 0, np.linspace(0.0, span, count), q, ends))
        leg = leg.before
    return tuple(reversed(pieces))
