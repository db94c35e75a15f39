"""The timing of a given path that shakes least, and the price of time.

Along a path u(s), 0 ≤ s ≤ 1, with ``b(s) = ṡ²`` and ``s̈ = b'/2``, all loads are linear in b
and its derivative (D. Verscheure et al., Time-optimal path tracking for robots: a convex
optimization approach, IEEE Trans. Automatic Control 54, 2009):

    u̇² = u'² b        ü = u'' b + u' b'/2        shaking = F_2(s) b + F_1(s) b'/2

and the duration ``∫ ds/√b`` is convex. The peak of the shaking, and its mean square over time
``1/T ∫ |F|²/√b ds``, are convex too: cones of second order express them with ``c ≤ √b``,
``d ≥ 1/c`` and ``e ≥ |F|²/c`` at every sample. Any other timing of the path within the limits
shakes at least as much, up to the discretisation: b is a cubic spline, on knots that are dense
where the motion rests, ``s = (1 - cos θ)/2``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import QUIET_LIMIT_EXCEEDED
from balance.motion.quiet.compare import compare_with_laws, exceeded_limit, measure_path
from balance.motion.quiet.convex_steps import PRICE, RESERVE, QuietProblem
from balance.motion.quiet.limits import TORQUE, Limit, input_limits
from balance.motion.quiet.motion_space import PlannedPath, quintic_path, trapezoidal_path
from balance.motion.quiet.objective import Measure, Part
from balance.motion.quiet.problem import (
    check_duration,
    follow_poses,
    nearest_poses,
    quiet_problem,
    scaled_problem,
)
from balance.motion.quiet.quiet_motion_result import QuietMotion
from balance.motion.quiet.sampled_loads import SampledPoses
from balance.motion.verification.input_paths import SplinePath
from balance.support.clarabel_adapter import solve_cones
from balance.support.options import GRAVITY
from kinematics.errors import PoseError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Poses on the path from which those of its motions are found.
PATH_POSES = 161
# Degree of the spline through poses of a path.
DEGREE = 3
# The shortest duration of a curve of time and shaking without limits, over the longest.
SHORTEST = 0.25

# Intervals of b, and samples of each.
INTERVALS, PER_INTERVAL = 40, 4
# Times through which the answer is a spline.
TIMES = 801


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

    A convex program gives it (see the module): no other timing of the path
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
    s = _samples_of_path()[0]
    u = path.at(s)[0]
    closed = problem.model.near(nearest_poses(problem, line, u), u)
    assert closed is not None
    loads = _path_loads(problem, closed, path)
    timing = _quietest_timing(problem, loads, duration)
    plan = _timed_spline(path, timing, max(duration, timing.duration))
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
    timing = _TimingProgram(problem, loads, guess).solve(quiet=False)
    return timing.duration if timing.within else None


def _front(
    problem: QuietProblem,
    loads: PathLoads,
    path: SplinePath,
    line: SampledPoses,
    ends: tuple[float, float],
    count: int,
) -> tuple[tuple[float, float], ...]:
    """Compute the least shaking for durations between two.

    Returns:
        Pairs of duration and size of the shaking.
    """
    points = []
    for duration in np.geomspace(max(ends[0], SHORTEST * ends[1]), ends[1], count):
        timing = _quietest_timing(problem, loads, float(duration))
        plan = _timed_spline(path, timing, max(float(duration), timing.duration))
        measured = measure_path(problem, float(duration), plan, line)
        if measured is not None:
            points.append((float(duration), measured[0].value))
    return tuple(points)


class PathLoads(NamedTuple):
    """A geometric path at samples, and its loads per unit of b and of b'/2.

    Attributes:
        s: samples (N,), midpoints of even intervals of θ.
        weights: of the samples in integrals over s (N,).
        tangent: u' (N, inputs).
        curvature: u'' (N, inputs).
        by_b: wrench and torque per unit of b (N, 6 + inputs).
        by_change: the same per unit of b'/2.
        still: the torque at rest, with gravity (N, inputs).
    """

    s: Array
    weights: Array
    tangent: Array
    curvature: Array
    by_b: Array
    by_change: Array
    still: Array


def _samples_of_path() -> tuple[Array, Array]:
    """Return samples s of a path, and their weights in integrals over s."""
    count = INTERVALS * PER_INTERVAL
    theta = (np.arange(count) + 0.5) * np.pi / count
    return 0.5 * (1.0 - np.cos(theta)), 0.5 * np.sin(theta) * np.pi / count


def _path_loads(problem: QuietProblem, poses: SampledPoses, path: SplinePath) -> PathLoads:
    """Compute the loads along a path.

    Args:
        poses: closed poses of the samples.
        path: the inputs as functions of s.
    """
    s, weights = _samples_of_path()
    _, tangent, curvature = path.at(s)
    nothing = np.zeros_like(tangent)
    rates = np.stack([tangent, nothing, nothing], axis=2)
    changes = np.stack([curvature, tangent, nothing], axis=2)
    loads = problem.model.loads(poses, rates, changes)
    still = loads[..., 2]
    return PathLoads(
        s,
        weights,
        tangent,
        curvature,
        loads[..., 0] - still,
        loads[..., 1] - still,
        still[:, 6:],
    )


class Timing(NamedTuple):
    """A timing of a path.

    Attributes:
        duration: ``∫ ds/√b``, seconds.
        time: times (N,), from 0 to the duration.
        s: places on the path there (N,).
        excess: over the limits, relative, by kind and input (5, inputs).
    """

    duration: float
    time: Array
    s: Array
    excess: Array

    @property
    def within(self) -> bool:
        """Whether the timing keeps all limits."""
        return bool(self.excess.max() <= QUIET_LIMIT_EXCEEDED)


def _quietest_timing(problem: QuietProblem, loads: PathLoads, duration: float) -> Timing:
    """Compute the timing that shakes least, and lasts at most some time.

    Args:
        duration: seconds.

    Returns:
        The timing; if no timing keeps the limits, one that exceeds them least.
    """
    return _TimingProgram(problem, loads, duration).solve(quiet=True)


class _TimingProgram:
    """The conic program; times are in units of the duration.

    Variables are the coefficients of b, c, d, e of the samples, the peak, and the excess over
    each limit, of velocities over its square.
    """

    def __init__(self, problem: QuietProblem, loads: PathLoads, duration: float) -> None:
        from scipy.interpolate import BSpline

        self.problem, self.loads, self.duration = problem, loads, duration
        knots = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, INTERVALS + 1)))
        knots = np.concatenate([np.zeros(3), knots, np.ones(3)])
        count = INTERVALS + 3
        # b vanishes at both ends.
        self.splines = BSpline(knots, np.eye(count)[:, 1:-1], 3)
        self.b, self.change = self.splines(loads.s), 0.5 * self.splines(loads.s, 1)
        self.free, self.samples = count - 2, len(loads.s)
        groups = np.argwhere(np.isfinite(problem.limits.upper))
        self.groups = [(kind, k) for kind, k in groups.tolist() if kind in (1, 2, TORQUE)]
        starts = np.cumsum([self.free, self.samples, self.samples, self.samples, 1])
        self.c, self.d, self.e, self.peak, self.slack = starts.tolist()
        self.count = self.slack + len(self.groups)

    def solve(self, quiet: bool) -> Timing:
        """Solve for the least shaking within the duration, or for the least duration."""
        q = np.zeros(self.count)
        q[self.slack :] = PRICE
        if not quiet:
            q[self.d : self.e] = self.loads.weights
        elif self.problem.objective.measure == "peak":
            q[self.peak] = 1.0
        else:
            q[self.e : self.peak] = self.loads.weights
        cones = [*self._root_cones(), *(self._load_cones() if quiet else [])]
        linear = [
            self._limit_rows(kind, k, place)
            for place, (kind, k) in enumerate(self.groups, self.slack)
        ]
        extra = np.eye(self.count)[self.slack :]
        linear.append((extra, np.zeros(len(extra))))
        if quiet:
            lasting = np.zeros((1, self.count))
            lasting[0, self.d : self.e] = -self.loads.weights
            linear.append((lasting, np.ones(1)))
        return self._timing(solve_cones(q, cones, linear))

    def _root_cones(self) -> list[tuple[Array, Array]]:
        """Build ``c² ≤ b`` and ``1 ≤ c d`` of all samples."""
        each = np.arange(self.samples)
        root, inverse = np.zeros((2, self.samples, 3, self.count))
        root[:, 0, : self.free] = root[:, 1, : self.free] = self.b
        root[each, 2, self.c + each] = 2.0
        inverse[each, 0, self.c + each] = inverse[each, 1, self.c + each] = 1.0
        inverse[each, 0, self.d + each] = 1.0
        inverse[each, 1, self.d + each] = -1.0
        constants = (np.array([1.0, -1.0, 0.0]), np.array([0.0, 0.0, 2.0]))
        pairs = zip((root, inverse), constants, strict=True)
        return [(block, constant) for matrix, constant in pairs for block in matrix]

    def _load_cones(self) -> list[tuple[Array, Array]]:
        """Build the cones of the size of the shaking: the peak, or ``|F|² ≤ c e``."""
        rows = self.problem.objective.rows
        scale = self.problem.scale * self.duration**2
        F = np.einsum("nm,nf->nmf", self.loads.by_b[:, :6] @ rows.T, self.b)
        F += np.einsum("nm,nf->nmf", self.loads.by_change[:, :6] @ rows.T, self.change)
        peak = self.problem.objective.measure == "peak"
        each, m = np.arange(self.samples), len(rows)
        matrix = np.zeros((self.samples, m + 2 - peak, self.count))
        if peak:
            matrix[:, 0, self.peak] = 1.0
            matrix[:, 1:, : self.free] = F / scale
        else:
            for row, sign in ((0, 1.0), (1, -1.0)):
                matrix[each, row, self.c + each] = sign
                matrix[each, row, self.e + each] = 1.0
            matrix[:, 2:, : self.free] = 2.0 * F / scale
        constant = np.zeros(matrix.shape[1])
        return [(block, constant) for block in matrix]

    def _loads_by_b(self, kind: int, k: int) -> tuple[Array, Array]:
        """Compute the load of a limit as an affine function of b: (N, free) and (N,).

        Of velocities it is the square.
        """
        loads, unit = self.loads, 1.0 / self.duration**2
        none = np.zeros(self.samples)
        if kind == 1:
            return unit * loads.tangent[:, k, None] ** 2 * self.b, none
        if kind == 2:
            rows = (
                loads.curvature[:, k, None] * self.b + loads.tangent[:, k, None] * self.change
            )
            return unit * rows, none
        by_b, by_change = loads.by_b[:, 6 + k, None], loads.by_change[:, 6 + k, None]
        return unit * (by_b * self.b + by_change * self.change), loads.still[:, k]

    def _limit_rows(self, kind: int, k: int, place: int) -> tuple[Array, Array]:
        """Build the rows of a limit, over its size, with its excess."""
        limit = self.problem.limits.upper[kind, k] ** (2 if kind == 1 else 1)
        rows, still = self._loads_by_b(kind, k)
        signs = (1.0,) if kind == 1 else (1.0, -1.0)
        matrix = np.zeros((len(signs) * self.samples, self.count))
        matrix[:, : self.free] = np.concatenate([-sign * rows / limit for sign in signs])
        matrix[:, place] = 1.0
        constant = np.concatenate([1.0 - RESERVE - sign * still / limit for sign in signs])
        return matrix, constant

    def _timing(self, x: Array) -> Timing:
        """Compute the times of places on the path for a solution, and the excess."""
        excess = np.zeros_like(self.problem.limits.upper)
        for (kind, k), value in zip(self.groups, x[self.slack :], strict=True):
            excess[kind, k] = max(0.0, np.sqrt(1.0 + value) - 1.0 if kind == 1 else value)
        theta = np.linspace(0.0, np.pi, 16 * TIMES + 1)
        middle = 0.5 * (theta[1:] + theta[:-1])
        s = 0.5 * (1.0 - np.cos(middle))
        b = np.maximum(self.splines(s) @ x[: self.free], 1e-12)
        steps = 0.5 * np.sin(middle) * np.diff(theta) / np.sqrt(b) * self.duration
        time = np.append(0.0, np.cumsum(steps))[::16]
        return Timing(float(time[-1]), time, 0.5 * (1.0 - np.cos(theta[::16])), excess)


def _timed_spline(path: SplinePath, timing: Timing, duration: float) -> SplinePath:
    """Make the motion of a timing, made slower to last a duration.

    Args:
        path: the inputs as functions of s.
        duration: seconds, at least that of the timing.
    """
    time = timing.time * (duration / timing.duration)
    return SplinePath.through(time, path.at(timing.s)[0])
