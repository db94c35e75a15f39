"""The motion between two poses that shakes least: starts, levels of refinement, comparison."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from balance.motion.motion_tolerances import QUIET_LIMIT_EXCEEDED
from balance.motion.quiet.com_law import fit_to_law
from balance.motion.quiet.compare import compare_with_laws, measure_path
from balance.motion.quiet.convex_steps import (
    PER_INTERVAL,
    QuietProblem,
    SampledMotion,
    improve_motion,
    sample_motion,
)
from balance.motion.quiet.limits import Limit, input_limits
from balance.motion.quiet.motion_space import (
    MotionSpace,
    PlannedPath,
    harmonic_space,
    leg_times,
    path_through,
    quintic_path,
    rest_space,
    trapezoidal_path,
)
from balance.motion.quiet.objective import Measure, Part
from balance.motion.quiet.passed_poses import least_acceleration, settle
from balance.motion.quiet.problem import (
    PoseLike,
    check_duration,
    nearest_poses,
    quiet_problem,
    scaled_problem,
)
from balance.motion.quiet.quiet_motion_result import PassedPoint, QuietMotion
from balance.motion.quiet.sampled_loads import SampledPoses
from balance.motion.quiet.stops import Stops, ToolLike, read_stops, read_tool
from balance.motion.verification.input_paths import InputPath
from balance.support.options import GRAVITY
from kinematics.errors import PoseError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.numerics.array_types import Array

# Intervals of the spline: of the search from several starts, and of the answer.
COARSE, FINE = 10, 40
# Most steps of both.
COARSE_STEPS, FINE_STEPS = 30, 30
# First trust regions of both, rad and characteristic lengths.
COARSE_TRUST, FINE_TRUST = 0.5, 0.06
# Gain of a step over the merit at which the search on the coarse space ends.
COARSE_GAIN = 3e-3
# How often limits are tightened by what a motion exceeds between samples, and what is beyond
# repair.
TIGHTENED, TIGHTENED_MOST = 4, 0.3
# Harmonics of a cycle, if no number is given, and most of them.
HARMONICS, MOST_HARMONICS = 5, 30


def quiet_motion(
    linkage: LinkageLike,
    start: PoseLike,
    end: PoseLike | None,
    duration: float,
    *,
    via: Sequence[PoseLike] = (),
    tool: ToolLike = None,
    cycle: bool = False,
    harmonics: int = HARMONICS,
    minimise: Part = "force",
    measure: Measure = "rms",
    about: Sequence[float] | None = None,
    weight_moment: float | None = None,
    velocity: Limit = None,
    acceleration: Limit = None,
    jerk: Limit = None,
    torque: Limit = None,
    file_limits: bool = True,
    gravity: Sequence[float] = GRAVITY,
    frequencies: Sequence[float] = (),
) -> QuietMotion:
    """Plan the motion between poses that shakes the base least, from rest to rest or in cycles.

    The masses stay as they are. Motions are splines of degree five in the inputs. From three
    first motions (quintic and trapezoidal law on the straight line, straight line of the centre
    of mass) convex programs in sequence lead to local minima
    (`balance.motion.quiet.convex_steps`); the least of them is refined. The answer never shakes
    more than those of the two laws that keep the limits; these rest at all poses on the way.

    A pose by the names ``x``, ``y``, ``z``, ``rx``, ``ry``, ``rz`` is one of the tool, in
    coordinates of `kinematics.tool` from the reference pose; directions that are not named are
    free. Where a tool leaves inputs free, the plan chooses them, but those of the start.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        start: displacements of the inputs from the reference pose, by name or in order, rad and
            m; those that are not named are 0.
        end: those at the end; those that are not named stay. None with a cycle, whose last
            pose is then the last of ``via``.
        duration: seconds; of a cycle, its period.
        via: poses that are passed on the way, in order, at times that the plan chooses.
        tool: link whose poses are given; or the link and its point (3,), metres, in its frame.
        cycle: whether the motion returns to the start and repeats, without rest. It is then a
            sum of harmonics.
        harmonics: number of multiples of the rate of a cycle.
        minimise: size of the ``"force"``, of the ``"moment"`` about a point, or of ``"both"``:
            ``√(|F|² + |M|²/ℓ²)``.
        measure: root mean square over time (``"rms"``) or ``"peak"`` of it.
        about: point of the moment, metres, inertial frame; by default the middle of the
            mechanism.
        weight_moment: ℓ, metres; by default the characteristic length of the linkage.
        velocity: largest speed of all inputs, or by name, rad/s and m/s.
        acceleration: largest acceleration.
        jerk: largest jerk; accelerations then vanish at both ends.
        torque: largest torque or force of the inputs, N m and N, with gravity.
        file_limits: whether ``<limit>`` of the file counts, where no limit above replaces it.
        gravity: acceleration (3,), m/s², for torques alone.
        frequencies: natural frequencies of the base, Hz, that the motion does not excite. The
            shaking of a cycle has multiples of its rate alone: those next to the frequencies
            vanish.

    Returns:
        The motion, what it shakes beside the two laws, and a bound.

    Raises:
        PoseError: a pose cannot be reached, or the straight line between them.
        BodyError: there is no such tool.
        UsageError: an option is none, or a limit is not above 0.

    Example:
        >>> import balance, kinematics, numpy as np
        >>> arm = kinematics.from_screws(
        ...     [kinematics.ScrewJoint("u1", "base", "slide", kind="prismatic")],
        ...     bodies={"slide": (2, (0, 0, 0), np.eye(3))},
        ... )
        >>> plan = balance.quiet_motion(arm, [0.0], [0.5], 1.0)
        >>> round(plan.after.value, 1), round(plan.quintic.value, 1)
        (3.5, 4.1)
    """
    linkage = as_linkage(linkage)
    check_duration(duration)
    if not 1 <= harmonics <= MOST_HARMONICS:
        raise UsageError(f"the number of harmonics is one from 1 to {MOST_HARMONICS}")
    limits = input_limits(linkage, velocity, acceleration, jerk, torque, file=file_limits)
    lines = cycle_lines(frequencies, duration) if cycle else frequencies
    problem = quiet_problem(
        linkage, limits, minimise, measure, about, weight_moment, gravity, lines
    )
    given = [start, *via, *([] if end is None else [end])]
    if len(given) < 2:
        raise UsageError("give the pose to reach, or poses that a cycle passes")
    stops = read_stops(problem.model, problem.units, given, read_tool(linkage, tool), cycle)
    problem = replace(problem, passes=stops.passes, reach=stops.reach(problem.units))
    times = leg_times(stops.inputs, problem.units, duration)
    laws = [path_through(law, stops.inputs, times) for law in (quintic_path, trapezoidal_path)]
    spaces = _spaces(stops, duration, limits.has_jerk, harmonics)
    at = _pass_times(stops, times)
    quintic = _fit_to_space(problem, spaces[0], laws[0], stops.line, at)
    if quintic is None:
        raise PoseError(f"{linkage.source}: the loops cannot be closed between the poses")
    problem = scaled_problem(problem, quintic.value, quintic.time, quintic.inputs[2])
    first = _first_motions(problem, spaces[0], laws, stops.line, at)
    path, motion = _plan(problem, spaces, first)
    plan = compare_with_laws(
        problem,
        duration,
        path,
        motion.poses,
        laws,
        stops.line,
        passed=stops.known_ends,
        at=motion.at,
        cycle=cycle,
    )
    return _with_stops(plan, stops, motion.at if plan.law == "planned" else at, harmonics)


def cycle_lines(frequencies: Sequence[float], duration: float) -> list[float]:
    """List the multiples of the rate of a cycle next to natural frequencies, Hz."""
    numbers = {
        number
        for frequency in frequencies
        for number in (math.floor(frequency * duration), math.ceil(frequency * duration))
        if number > 0
    }
    return [number / duration for number in sorted(numbers)]


def _spaces(
    stops: Stops, duration: float, smooth: bool, harmonics: int
) -> tuple[MotionSpace, MotionSpace]:
    """Make the coarse and the fine space of motions; they are one for a cycle."""
    first, last = stops.poses[0].u, stops.poses[-1].u
    if stops.cycle:
        space = harmonic_space(first.size, duration, harmonics)
        return space, space
    coarse, fine = (
        rest_space(first, last, duration, count, smooth, stops.open_end)
        for count in (COARSE, FINE)
    )
    return coarse, fine


def _pass_times(stops: Stops, times: Array) -> Array:
    """Pick the times of the poses that are passed from those of all stops."""
    if stops.cycle:
        return times[:-1]
    return times[1:] if stops.open_end else times[1:-1]


def _with_stops(plan: QuietMotion, stops: Stops, at: Array, harmonics: int) -> QuietMotion:
    """Add the poses that are passed to a plan."""
    passed = tuple(
        PassedPoint(
            float(time),
            plan.path.at(np.array([time]))[0][0],
            "" if pose.tool is None else f"{pose.tool.tool.name} at {pose.tool.words}",
        )
        for pose, time in zip(stops.passes, at, strict=True)
    )
    end = stops.poses[0].u if stops.cycle else stops.poses[-1].u
    if stops.open_end:
        end = passed[-1].u
    return replace(plan, end=end, passed=passed, harmonics=harmonics if stops.cycle else None)


def _plan(
    problem: QuietProblem, spaces: Sequence[MotionSpace], first: Sequence[SampledMotion]
) -> tuple[PlannedPath, SampledMotion]:
    """Search from several motions, refine the best one, and see that it keeps all limits.

    Args:
        spaces: the coarse space, of which the first motions are, and the fine one.

    Returns:
        The motion, and its samples.
    """
    coarse, fine = spaces
    if problem.objective.measure == "peak":
        # The root mean square is easier to minimise, and its minimum is near that of the peak.
        mean = replace(problem, objective=problem.objective._replace(measure="rms"))
        quiet = _find_minimum(mean, coarse, _sample_again(mean, coarse, first))
        first = [
            min(first, key=lambda motion: motion.merit),
            *_sample_again(problem, coarse, [quiet]),
        ]
    best = _find_minimum(problem, coarse, first)
    motion = _fit_to_space(problem, fine, coarse.path(best.y), best.poses, best.at)
    if motion is None:
        return coarse.path(best.y), best
    within = problem
    for _ in range(TIGHTENED):
        motion = improve_motion(within, fine, motion, FINE_STEPS, FINE_TRUST)
        motion = _settled(within, fine, motion)
        measured = measure_path(problem, fine.duration, fine.path(motion.y), motion.poses)
        if measured is None or not 0.0 < measured[1].max() < TIGHTENED_MOST:
            break
        if measured[1].max() <= QUIET_LIMIT_EXCEEDED:
            break
        within = replace(within, limits=within.limits.tightened(1.5 * measured[1]))
        (motion,) = _sample_again(within, fine, [motion])
    return fine.path(motion.y), motion


def _settled(problem: QuietProblem, space: MotionSpace, motion: SampledMotion) -> SampledMotion:
    """Let a motion pass its poses exactly."""
    y = settle(problem, space, motion.y, motion.at, motion.poses, motion.time)
    settled = sample_motion(problem, space, y, motion.poses, motion.time, motion.at)
    return motion if settled is None else settled


def _find_minimum(
    problem: QuietProblem, space: MotionSpace, first: Sequence[SampledMotion]
) -> SampledMotion:
    """Descend from several motions, and return the least of the minima."""
    minima = [
        improve_motion(problem, space, motion, COARSE_STEPS, COARSE_TRUST, COARSE_GAIN)
        for motion in first
    ]
    return min(minima, key=lambda motion: motion.merit)


def _sample_again(
    problem: QuietProblem, space: MotionSpace, motions: Sequence[SampledMotion]
) -> list[SampledMotion]:
    """Sample motions of a space for another problem."""
    again = (sample_motion(problem, space, m.y, m.poses, m.time, m.at) for m in motions)
    return [motion for motion in again if motion is not None]


def _first_motions(
    problem: QuietProblem,
    space: MotionSpace,
    laws: Sequence[InputPath],
    line: SampledPoses,
    at: Array,
) -> list[SampledMotion]:
    """Make the motions from which the search starts."""
    time = space.times(PER_INTERVAL)
    motions = [_fit_to_space(problem, space, law, line, at) for law in laws]
    started = [motion for motion in motions if motion is not None]
    assert started
    first = started[0]
    if problem.passes:
        y = least_acceleration(space, problem.units.size)
        y = settle(problem, space, y, at, first.poses, time)
    else:
        y = fit_to_law(
            problem.model, space, first.y, first.poses, time, problem.objective.measure
        )
    fitted = sample_motion(problem, space, y, first.poses, time, at)
    return started if fitted is None else [*started, fitted]


def _fit_to_space(
    problem: QuietProblem,
    space: MotionSpace,
    path: InputPath,
    known: SampledPoses,
    at: Array,
) -> SampledMotion | None:
    """Sample the motion of a space that is nearest to another one.

    Args:
        known: closed poses that the other motion passes through.
        at: times at which poses are passed.
    """
    time, y = space.times(PER_INTERVAL), space.fit(path)
    near = nearest_poses(problem, known, space.path(y).at(time)[0])
    return sample_motion(problem, space, y, near, time, at)
