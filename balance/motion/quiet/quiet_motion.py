"""The motion between two poses that shakes least: starts, levels of refinement, comparison."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from balance.motion.motion_tolerances import QUIET_LIMIT_EXCEEDED
from balance.motion.quiet.answer import QuietMotion
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
    quintic_path,
    rest_space,
    trapezoidal_path,
)
from balance.motion.quiet.objective import Measure, Part
from balance.motion.quiet.problem import (
    PoseLike,
    check_duration,
    end_poses,
    follow_poses,
    nearest_poses,
    quiet_problem,
    scaled_problem,
)
from balance.motion.quiet.sampled_loads import SampledPoses
from balance.support.options import GRAVITY
from kinematics.errors import PoseError
from kinematics.loading.model_gallery import LinkageLike, as_linkage

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
# Poses on the straight line of the inputs.
LINE_POSES = 81


def quiet_motion(
    linkage: LinkageLike,
    start: PoseLike,
    end: PoseLike,
    duration: float,
    *,
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
    """Plan the motion from rest to rest between two poses that shakes the base least.

    The masses stay as they are. Motions are splines of degree five in the inputs. From three
    first motions (quintic and trapezoidal law on the straight line, straight line of the centre
    of mass) convex programs in sequence lead to local minima
    (`balance.motion.quiet.convex_steps`); the least of them is refined. The answer never shakes
    more than those of the two laws that keep the limits.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        start: displacements of the inputs from the reference pose, by name or in order, rad and
            m; those that are not named are 0.
        end: those at the end; those that are not named stay.
        duration: seconds.
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
        frequencies: natural frequencies of the base, Hz, that the motion does not excite.

    Returns:
        The motion, what it shakes beside the two laws, and a bound.

    Raises:
        PoseError: a pose cannot be reached, or the straight line between them.
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
    limits = input_limits(linkage, velocity, acceleration, jerk, torque, file=file_limits)
    ends = end_poses(linkage, start, end)
    problem = quiet_problem(
        linkage, limits, minimise, measure, about, weight_moment, gravity, frequencies
    )
    share = np.linspace(0.0, 1.0, LINE_POSES)[:, None]
    line = follow_poses(problem.model, ends[0] + share * (ends[1] - ends[0]))
    laws = [law(*ends, duration) for law in (quintic_path, trapezoidal_path)]
    spaces = [
        rest_space(*ends, duration, count, smooth=limits.has_jerk) for count in (COARSE, FINE)
    ]
    quintic = _fit_to_space(problem, spaces[0], laws[0], line)
    if quintic is None:
        raise PoseError(f"{linkage.source}: the loops cannot be closed between the poses")
    problem = scaled_problem(problem, quintic.value, quintic.time, quintic.inputs[2])
    first = _first_motions(problem, spaces[0], laws, line)
    path, poses = _plan(problem, spaces, first)
    return compare_with_laws(problem, duration, path, poses, laws, line)


def _plan(
    problem: QuietProblem, spaces: Sequence[MotionSpace], first: Sequence[SampledMotion]
) -> tuple[PlannedPath, SampledPoses]:
    """Search from several motions, refine the best one, and see that it keeps all limits.

    Args:
        spaces: the coarse space, of which the first motions are, and the fine one.

    Returns:
        The motion, and closed poses of it.
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
    motion = _fit_to_space(problem, fine, coarse.path(best.y), best.poses)
    if motion is None:
        return coarse.path(best.y), best.poses
    within = problem
    for _ in range(TIGHTENED):
        motion = improve_motion(within, fine, motion, FINE_STEPS, FINE_TRUST)
        measured = measure_path(problem, fine.duration, fine.path(motion.y), motion.poses)
        if measured is None or not 0.0 < measured[1].max() < TIGHTENED_MOST:
            break
        if measured[1].max() <= QUIET_LIMIT_EXCEEDED:
            break
        within = replace(within, limits=within.limits.tightened(1.5 * measured[1]))
        (motion,) = _sample_again(within, fine, [motion])
    return fine.path(motion.y), motion.poses


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
    again = (sample_motion(problem, space, m.y, m.poses, m.time) for m in motions)
    return [motion for motion in again if motion is not None]


def _first_motions(
    problem: QuietProblem, space: MotionSpace, laws: Sequence[PlannedPath], line: SampledPoses
) -> list[SampledMotion]:
    """Make the motions from which the search starts."""
    time = space.times(PER_INTERVAL)
    motions = [_fit_to_space(problem, space, law, line) for law in laws]
    started = [motion for motion in motions if motion is not None]
    assert started
    y = fit_to_law(
        problem.model, space, started[0].y, started[0].poses, time, problem.objective.measure
    )
    fitted = sample_motion(problem, space, y, started[0].poses, time)
    return started if fitted is None else [*started, fitted]


def _fit_to_space(
    problem: QuietProblem, space: MotionSpace, path: PlannedPath, known: SampledPoses
) -> SampledMotion | None:
    """Sample the motion of a space that is nearest to another one.

    Args:
        known: closed poses that the other motion passes through.
    """
    time, y = space.times(PER_INTERVAL), space.fit(path)
    near = nearest_poses(problem, known, space.path(y).at(time)[0])
    return sample_motion(problem, space, y, near, time)
