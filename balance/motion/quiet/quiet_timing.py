"""The timing of a given path that shakes least, and the price of time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.motion.quiet.answer import QuietMotion
from balance.motion.quiet.compare import compare_with_laws, exceeded_limit, measure_path
from balance.motion.quiet.convex_steps import QuietProblem
from balance.motion.quiet.limits import Limit, input_limits
from balance.motion.quiet.motion_space import PlannedPath, quintic_path, trapezoidal_path
from balance.motion.quiet.objective import Measure, Part
from balance.motion.quiet.problem import (
    check_duration,
    follow_poses,
    nearest_poses,
    quiet_problem,
    scaled_problem,
)
from balance.motion.quiet.sampled_loads import SampledPoses
from balance.motion.quiet.timing import (
    PathLoads,
    path_loads,
    quietest_timing,
    samples_of_path,
    shortest_timing,
    timed_spline,
)
from balance.motion.verification.input_paths import SplinePath
from balance.support.options import GRAVITY
from kinematics.errors import PoseError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage

Array = NDArray[np.float64]

# Poses on the path from which those of its motions are found.
PATH_POSES = 161
# Degree of the spline through poses of a path.
DEGREE = 3
# The shortest duration of a curve of time and shaking without limits, over the longest.
SHORTEST = 0.25


@dataclass(frozen=True, eq=False)
class _LawOnPath:
    """A motion along a path, with a law of the arc; an `InputPath`."""

    path: SplinePath
    law: PlannedPath

    @property
    def corners(self) -> tuple[float, ...]:
        """Those of the law."""
        return self.law.corners

    def at(self, time: Array) -> tuple[Array, Array, Array]:
        """Compute displacements, velocities and accelerations; see `InputPath`."""
        s, sd, sdd = self.law.at(time)
        u, tangent, curvature = self.path.at(np.clip(s[:, 0], 0.0, 1.0))
        return u, tangent * sd, curvature * sd**2 + tangent * sdd


def quiet_timing(
    linkage: LinkageLike,
    poses: ArrayLike,
    duration: float,
    *,
    minimise: Part = "force",
    measure: Measure = "rms",
    about: Sequence[float] | None = None,
    weight_moment: float | None = None,
    velocity: Limit = None,
    acceleration: Limit = None,
    torque: Limit = None,
    file_limits: bool = True,
    gravity: Sequence[float] = GRAVITY,
    front: int = 0,
) -> QuietMotion:
    """Compute the timing of a given path, from rest to rest, that shakes the base least.

    A convex program gives it (`balance.motion.quiet.timing`): no other timing of the path
    within the limits shakes less.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        poses: displacements of the inputs from the reference pose (2 or more, mobility), rad
            and m; a cubic spline leads through them, a straight line through two.
        duration: seconds.
        minimise: as `balance.quiet_motion`, as for all options that follow.
        measure: ``"rms"`` or ``"peak"``.
        about: point of the moment, metres, inertial frame.
        weight_moment: ℓ, metres.
        velocity: largest speed of all inputs, or by name, rad/s and m/s.
        acceleration: largest acceleration.
        torque: largest torque or force, N m and N, with gravity.
        file_limits: whether ``<limit>`` of the file counts.
        gravity: acceleration (3,), m/s², for torques alone.
        front: number of durations, from the shortest possible one to the given one, for which
            to compute the least shaking, too.

    Returns:
        The motion, and what it shakes beside the quintic and the trapezoidal timing.

    Raises:
        PoseError: there are fewer than two poses, or the loops cannot be closed on the path.
        UsageError: an option is none, or a limit is not above 0.

    Example:
        >>> import balance, kinematics, numpy as np
        >>> arm = kinematics.from_screws(
        ...     [kinematics.ScrewJoint("u1", "base", "slide", kind="prismatic")],
        ...     bodies={"slide": (2, (0, 0, 0), np.eye(3))},
        ... )
        >>> plan = balance.quiet_timing(arm, [[0.0], [0.5]], 1.0, measure="peak")
        >>> round(plan.after.value, 1), plan.verdict
        (4.0, 'optimal')
    """
    linkage = as_linkage(linkage)
    check_duration(duration)
    limits = input_limits(linkage, velocity, acceleration, None, torque, file=file_limits)
    problem = quiet_problem(linkage, limits, minimise, measure, about, weight_moment, gravity)
    path = _spline_through(linkage, poses, problem.units)
    line = follow_poses(problem.model, path.at(np.linspace(0.0, 1.0, PATH_POSES))[0])
    share = np.zeros(1), np.ones(1), duration
    laws = [_LawOnPath(path, law(*share)) for law in (quintic_path, trapezoidal_path)]
    time = np.linspace(0.0, duration, PATH_POSES)
    first = measure_path(problem, duration, laws[0], line)
    if first is None:
        raise PoseError(f"{linkage.source}: the loops cannot be closed along the path")
    problem = scaled_problem(problem, first[0].value, time, laws[0].at(time)[2])
    s = samples_of_path()[0]
    u = path.at(s)[0]
    closed = problem.model.near(nearest_poses(problem, line, u), u)
    assert closed is not None
    loads = path_loads(problem, closed, path)
    timing = quietest_timing(problem, loads, duration)
    plan = timed_spline(path, timing, max(duration, timing.duration))
    answer = compare_with_laws(problem, duration, plan, line, laws, line, convex=True)
    if not timing.within:
        exceeded = exceeded_limit(linkage, limits, timing.excess)
        return replace(answer, exceeded=exceeded, shortest=_shortest(problem, loads, duration))
    if not front:
        return answer
    shortest = _shortest(problem, loads, duration)
    curve = _front(problem, loads, path, line, (shortest or 0.0, duration), front)
    return replace(answer, front=curve, shortest=shortest)


def _spline_through(linkage: Linkage, poses: ArrayLike, units: Array) -> SplinePath:
    """Make the path through poses, for s from 0 to 1.

    Raises:
        PoseError: they are no poses, or two that follow each other are one.
    """
    from scipy.interpolate import make_interp_spline

    u = np.asarray(poses, dtype=np.float64)
    if u.ndim != 2 or len(u) < 2 or u.shape[1] != linkage.mobility or not np.isfinite(u).all():
        raise PoseError(
            f"{linkage.source}: give two or more poses of {linkage.mobility} inputs "
            f"({', '.join(linkage.inputs)})"
        )
    steps = np.linalg.norm(np.diff(u, axis=0) / units, axis=1)
    if not steps.all():
        raise PoseError(f"{linkage.source}: two poses of the path that follow are one")
    s = np.append(0.0, np.cumsum(steps)) / steps.sum()
    return SplinePath(make_interp_spline(s, u, k=min(DEGREE, len(u) - 1)), ())


def _shortest(problem: QuietProblem, loads: PathLoads, guess: float) -> float | None:
    """Compute the shortest duration within the limits; None if nothing limits it."""
    if not np.isfinite(problem.limits.upper[[1, 2, 4]]).any():
        return None
    timing = shortest_timing(problem, loads, guess)
    return timing.duration if timing.within else None


def _front(
    problem: QuietProblem, loads: PathLoads, path: SplinePath, line: SampledPoses,
    ends: tuple[float, float], count: int,
) -> tuple[tuple[float, float], ...]:  # fmt: skip
    """Compute the least shaking for durations between two.

    Returns:
        Pairs of duration and size of the shaking.
    """
    points = []
    for duration in np.geomspace(max(ends[0], SHORTEST * ends[1]), ends[1], count):
        timing = quietest_timing(problem, loads, float(duration))
        plan = timed_spline(path, timing, max(float(duration), timing.duration))
        measured = measure_path(problem, float(duration), plan, line)
        if measured is not None:
            points.append((float(duration), measured[0].value))
    return tuple(points)
