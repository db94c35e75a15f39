"""A plan beside the laws that it replaces."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from balance.motion.motion_tolerances import (
    QUIET_EXCITED,
    QUIET_LIMIT_EXCEEDED,
    QUIET_POSE_MISSED,
    QUIET_STEP_GAIN,
    SHAKING_RELATIVE,
)
from balance.motion.quiet.com_law import force_bound
from balance.motion.quiet.convex_steps import QuietProblem
from balance.motion.quiet.limits import (
    EXCITATION,
    POSE,
    InputLimits,
    LimitExceeded,
    worst_limit,
)
from balance.motion.quiet.motion_space import PlannedPath
from balance.motion.quiet.passed_poses import misses
from balance.motion.quiet.problem import nearest_poses
from balance.motion.quiet.quiet_motion_result import ComparedLaw, MotionFigures, QuietMotion
from balance.motion.quiet.sampled_loads import SampledPoses
from balance.motion.verification.input_paths import InputPath
from kinematics.errors import PoseError
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Names of the laws that a motion is compared with.
LAWS = "quintic", "trapezoidal"
# Part of the shaking of a plan below which a law shakes less.
LAW_GAIN = 1.0 - QUIET_STEP_GAIN
# Samples at which a motion is measured, and distance from a corner, over the duration.
MEASURED = 801
BESIDE = 1e-9
# Jerk of an acceleration that jumps: above every limit.
JUMP = 1e300


def measure_path(
    problem: QuietProblem, duration: float, path: InputPath, nearby: SampledPoses
) -> tuple[MotionFigures, Array] | None:
    """Measure a motion at many times, on both sides of its corners.

    Args:
        duration: seconds.
        path: the motion of the inputs.
        nearby: closed poses that it passes near.

    Returns:
        Its figures, and its excess over limits by kind and input (5, inputs); None if its loops
        cannot be closed.
    """
    beside = [corner + side * BESIDE * duration for corner in path.corners for side in (-1, 1)]
    time = np.sort(np.concatenate([np.linspace(0.0, duration, MEASURED), beside]))
    u, ud, udd = path.at(time)
    poses = problem.model.near(nearest_poses(problem, nearby, u), u)
    if poses is None:
        return None
    loads = problem.model.loads(poses, ud[..., None], udd[..., None])[..., 0]
    jerk = np.zeros_like(u)
    if problem.limits.has_jerk and isinstance(path, PlannedPath):
        jerk = np.full_like(u, JUMP) if path.corners else path.jerk(time)
    quantities = enumerate([u, ud, udd, jerk, loads[:, 6:]])
    excess = np.array([problem.limits.excess(k, values) for k, values in quantities])
    figures = MotionFigures.of(problem.objective, time, (u, ud, udd), loads)
    return figures, np.maximum(excess, 0.0)


def compare_with_laws(
    problem: QuietProblem,
    duration: float,
    path: InputPath,
    nearby: SampledPoses,
    laws: Sequence[InputPath],
    line: SampledPoses,
    *,
    convex: bool = False,
    passed: SampledPoses | None = None,
    at: Array | None = None,
    cycle: bool = False,
) -> QuietMotion:
    """Measure a plan beside the laws, and keep the quietest that is within the limits.

    Args:
        duration: seconds.
        path: the plan.
        nearby: closed poses of the plan.
        laws: those of `LAWS` between the same poses.
        line: closed poses of the laws.
        convex: whether the plan is the minimum of a convex program.
        passed: closed poses that every motion passes; by default the ends of the line.
        at: times at which the plan passes the poses of the problem.
        cycle: whether it is a cycle.

    Raises:
        PoseError: loops close along neither the plan nor a law.
    """
    model, objective, limits = problem.model, problem.objective, problem.limits
    measured, name = measure_path(problem, duration, path, nearby), "planned"
    if measured is None:
        # Loops that close at the samples of the plan do not close between them.
        name, path, measured = _first_followed(problem, duration, laws, line)
        nearby, at, convex = line, None, False
    after, excess = measured
    exceeded = exceeded_limit(model.linkage, limits, excess)
    exceeded = exceeded or _excited_frequency(problem, duration, path, nearby)
    exceeded = exceeded or _missed_pose(problem, path, at, nearby)
    convex = convex and exceeded is None
    round_off = SHAKING_RELATIVE * problem.inertia_force
    compared = []
    for law_name, law in zip(LAWS, laws, strict=True):
        figures = measure_path(problem, duration, law, line)
        if figures is None:
            compared.append(ComparedLaw(law_name, None, None, law))
            continue
        beyond = exceeded_limit(model.linkage, limits, figures[1])
        compared.append(ComparedLaw(law_name, figures[0], beyond, law))
        less = after.value > round_off and figures[0].value < LAW_GAIN * after.value
        quieter = exceeded is not None or less
        if beyond is None and quieter and not problem.frequencies:
            path, after, exceeded, name = law, figures[0], None, law_name
    inputs, bound = model.linkage.positions_of(model.linkage.inputs), None
    passed = passed or SampledPoses(*(part[[0, -1]] for part in line))
    if objective.part != "moment" and len(passed.q) > 1:
        bound = force_bound(model, passed, duration, objective.measure, cycle)
    return QuietMotion(
        model.linkage,
        objective,
        limits,
        duration,
        line.q[0, inputs],
        line.q[-1, inputs],
        tuple(omega / (2.0 * np.pi) for omega in problem.frequencies),
        convex,
        path,
        name,
        after,
        tuple(compared),
        bound,
        exceeded,
        problem.inertia_force,
        notices=model.linkage.notices,
        gravity=tuple(model.gravity.tolist()),
    )


def _first_followed(
    problem: QuietProblem, duration: float, laws: Sequence[InputPath], line: SampledPoses
) -> tuple[str, InputPath, tuple[MotionFigures, Array]]:
    """Return name, motion and measures of the first law along which loops close.

    Raises:
        PoseError: there is none.
    """
    for name, law in zip(LAWS, laws, strict=True):
        measured = measure_path(problem, duration, law, line)
        if measured is not None:
            return name, law, measured
    source = problem.model.linkage.source
    raise PoseError(f"{source}: the loops cannot be closed between the poses")


def exceeded_limit(
    linkage: Linkage, limits: InputLimits, excess: Array
) -> LimitExceeded | None:
    """Name the limit that a motion exceeds most; None if it keeps all.

    Args:
        excess: over the limits, relative, by kind and input (5, inputs).
    """
    within = bool(excess.max() <= QUIET_LIMIT_EXCEEDED)
    return None if within else worst_limit(linkage, limits, excess)


def _missed_pose(
    problem: QuietProblem, path: InputPath, at: Array | None, nearby: SampledPoses
) -> LimitExceeded | None:
    """Name the pose that a motion misses most; None if it passes all."""
    if not problem.passes or at is None:
        return None
    u = path.at(at)[0]
    known = nearest_poses(problem, nearby, u)
    off = misses(problem, path, at, known, at)
    sizes = np.full(len(at), np.inf) if off is None else off.distances
    worst = int(np.argmax(sizes))
    if sizes[worst] <= QUIET_POSE_MISSED:
        return None
    return LimitExceeded(POSE, f"pose {worst + 1}", 0.0, float(sizes[worst]))


def _excited_frequency(
    problem: QuietProblem, duration: float, path: InputPath, nearby: SampledPoses
) -> LimitExceeded | None:
    """Name the frequency of the base that a motion excites most; None if it excites none."""
    if not problem.frequencies:
        return None
    time = np.linspace(0.0, duration, MEASURED)
    u, ud, udd = path.at(time)
    poses = problem.model.near(nearest_poses(problem, nearby, u), u)
    assert poses is not None
    loads = problem.model.loads(poses, ud[..., None], udd[..., None])[:, :6, 0]
    excited = problem.excited(time, loads)
    worst = int(np.argmax(excited))
    if excited[worst] <= QUIET_EXCITED:
        return None
    frequency = problem.frequencies[worst] / (2.0 * np.pi)
    return LimitExceeded(EXCITATION, f"{number_text(frequency)} Hz", 0.0, float(excited[worst]))
