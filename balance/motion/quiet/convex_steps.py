"""The motion of a space that shakes least near another one: convex programs in sequence.

The size of the shaking is a convex function (a norm over time) of the loads at the samples,
and these are smooth functions of the coefficients y of the motion. Each step replaces the loads
by their first-order change and solves

    minimise  t + μ Σ s + ε/2 mean |ü|²      |r_k + J_k Δy| ≤ t  at every sample
              |x_k + Δx_k| ≤ limit (1 + s),   |Δy| ≤ trust,   s ≥ 0

by a conic program (of a root mean square, ``½ (mean |r + J Δy|² / v + v)`` with its value v,
which is at least the root, instead of t), and keeps the step if the shaking itself falls
(R. Fletcher, A model algorithm for composite nondifferentiable optimization problems, 1982).
With μ large, the excess s over limits vanishes if a motion within them is near. Poses that are
passed (`balance.motion.quiet.passed_poses`) are missed by a size with the same price; the times
at which they are passed are further unknowns. The small ε chooses, among motions of a redundant
arm that shake alike, one of small accelerations. The end
is a local minimum.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import (
    QUIET_STEP_GAIN,
    SHAKING_RELATIVE,
)
from balance.motion.quiet.limits import TORQUE, InputLimits
from balance.motion.quiet.motion_space import MotionSpace
from balance.motion.quiet.objective import QuietObjective, time_weights
from balance.motion.quiet.passed_poses import Misses, PassedPose, misses, order_rows
from balance.motion.quiet.sampled_loads import SampledLinkage, SampledLoads, SampledPoses
from balance.support.clarabel_adapter import solve_cones
from kinematics.numerics.array_types import Array

# Samples for each interval of the functions.
PER_INTERVAL = 4
# Price μ of an excess over a limit, where the shaking of the first motion is 1.
PRICE = 30.0
# Weight ε of accelerations, where those of the first motion are 1.
SMOOTH = 2e-5
# The least trust region, rad and characteristic lengths, and factors by which it changes.
LEAST_TRUST, SHRINK, GROW = 1e-7, 0.35, 2.0
# Part of the gain of the program that a step must bring.
GAIN_SHARE = 0.1
# Weight of the square of the step in units of the trust region, so that it is unique.
STEP_WEIGHT = 1e-5
# Part of a limit that is left for what happens between samples.
RESERVE = 1e-3
# Largest change of the time of a pose in a step with a trust region of 1, over the duration.
TIME_TRUST = 0.2


@dataclass(frozen=True, eq=False)
class QuietProblem:
    """What is minimised, within which limits.

    Attributes:
        model: the linkage.
        objective: the size of the shaking.
        limits: those of the inputs.
        units: units of the inputs: 1 rad, or the characteristic length (inputs,).
        frequencies: ω of a base that must not be excited, rad/s.
        inertia_force: size of the inertia forces, N and N m; a small part of it is no shaking.
        scale: size of the shaking that others are compared with.
        acceleration: root mean square that accelerations are compared with, units/s².
        passes: poses that the motion passes, in order.
        reach: size of the motion, rad and characteristic lengths: poses are missed by parts of
            it.
    """

    model: SampledLinkage
    objective: QuietObjective
    limits: InputLimits
    units: Array
    frequencies: tuple[float, ...] = ()
    inertia_force: float = 0.0
    scale: float = 1.0
    acceleration: float = 1.0
    passes: tuple[PassedPose, ...] = ()
    reach: float = 1.0

    def excitations(self, time: Array) -> Array:
        """Compute the weights (rows, N) of samples in ``1/T ∫ r exp(-i ω t) dt``."""
        angle = np.outer(self.frequencies, time).reshape(-1, time.size)
        return np.concatenate([np.cos(angle), np.sin(angle)]) * time_weights(time)

    def excited(self, time: Array, wrench: Array) -> Array:
        """Compute the excitation of the base at each frequency, over the scale.

        Args:
            time: samples (N,).
            wrench: shaking about the inertial origin (N, 6).
        """
        rows = self.objective.rows
        parts = (self.excitations(time) @ (wrench @ rows.T)).reshape(2, -1, len(rows))
        return np.asarray(np.linalg.norm(parts, axis=(0, 2)) / self.scale)


class SampledMotion(NamedTuple):
    """A motion of a space at its samples.

    Attributes:
        y: free coefficients (free, inputs).
        time: samples (N,), seconds.
        inputs: positions, velocities, accelerations, jerks (4, N, inputs).
        poses: closed poses of the samples.
        wrench: shaking about the inertial origin (N, 6).
        torque: of the inputs (N, inputs).
        value: size of the shaking.
        excess: over the limits, relative, by kind and input (5, inputs); 0 within them.
        excited: size of the excitation of the base at its frequencies, over the scale.
        merit: what is minimised: the value over the scale, with the prices of accelerations
            and of what is exceeded.
        at: times at which poses are passed (passes,), seconds.
        missed: how far they are missed.
    """

    y: Array
    time: Array
    inputs: Array
    poses: SampledPoses
    wrench: Array
    torque: Array
    value: float
    excess: Array
    excited: Array
    merit: float
    at: Array
    missed: Misses


def sample_motion(
    problem: QuietProblem,
    space: MotionSpace,
    y: Array,
    near: SampledPoses,
    time: Array,
    at: Array,
) -> SampledMotion | None:
    """Compute a motion at samples.

    Args:
        near: closed poses near those of the samples.
        at: times at which poses are passed (passes,).

    Returns:
        The motion; None if its loops cannot be closed.
    """
    path = space.path(y)
    inputs = np.stack([*path.at(time), path.jerk(time)])
    poses = problem.model.near(near, inputs[0])
    if poses is None:
        return None
    missed = misses(problem, path, at, poses, time)
    if missed is None:
        return None
    loads = problem.model.loads(poses, inputs[1][..., None], inputs[2][..., None])[..., 0]
    wrench, torque = loads[:, :6], loads[:, 6:]
    value = problem.objective.value(time, wrench)
    excess = np.array([problem.limits.excess(k, x) for k, x in enumerate([*inputs, torque])])
    excess = np.maximum(excess, 0.0)
    excited = problem.excited(time, wrench)
    acceleration = time_weights(time) @ ((inputs[2] / problem.units) ** 2).sum(axis=1)
    merit = value / problem.scale + 0.5 * SMOOTH * acceleration / problem.acceleration**2
    merit += PRICE * (excess.sum() + excited.sum() + missed.distances.sum())
    return SampledMotion(
        y, time, inputs, poses, wrench, torque, value, excess, excited, float(merit), at, missed
    )


def improve_motion(
    problem: QuietProblem,
    space: MotionSpace,
    start: SampledMotion,
    steps: int,
    trust: float,
    least_gain: float = QUIET_STEP_GAIN,
) -> SampledMotion:
    """Improve a motion until steps gain nothing.

    Args:
        start: a motion of the space at `PER_INTERVAL` samples an interval.
        steps: most steps.
        trust: first trust region of coefficients, rad and characteristic lengths.
        least_gain: gain of a step over the merit at which to end.

    Returns:
        The motion with the least merit, at the same samples.
    """
    now, program = start, _StepProgram(problem, space, start.time)
    loads: SampledLoads | None = None
    for _ in range(steps):
        if loads is None:
            loads = problem.model.sample(now.poses, *now.inputs[:3])
        if loads is None or trust < LEAST_TRUST:
            break
        step, later, promised = program.solve(now, loads, trust)
        gain = now.merit - promised
        if not gain > least_gain * now.merit:
            break
        trial = sample_motion(problem, space, now.y + step, now.poses, now.time, now.at + later)
        actual = -np.inf if trial is None else now.merit - trial.merit
        if trial is None or actual < GAIN_SHARE * gain:
            trust *= SHRINK
            continue
        now, loads = trial, None
        trust *= GROW if actual > 0.7 * gain else 1.0
    return now


class _StepProgram:
    """The conic programs of the steps.

    Variables are Δy by input, t (of a peak), s by limit, frequency and passed pose, and the
    changes of the times of poses.

    Rows of limits that a step within the trust region cannot reach are left out.
    """

    def __init__(self, problem: QuietProblem, space: MotionSpace, time: Array) -> None:
        self.problem, self.scale, self.space = problem, problem.scale, space
        self.basis = np.stack([space.basis(time, order) for order in range(4)])
        self.weights = np.sqrt(time_weights(time))
        change = self.weights[:, None] * self.basis[2]
        self.acceleration = SMOOTH / problem.acceleration**2 * (change.T @ change)
        self.excitations = problem.excitations(time)
        self.free, self.width = self.basis.shape[2], len(problem.units)
        self.groups = np.argwhere(np.isfinite(problem.limits.upper)).tolist()
        self.size = self.free * self.width
        self.free_times = [k for k, point in enumerate(problem.passes) if point.share is None]
        self.excited = self.size + 1 + len(self.groups)
        self.passed = self.excited + len(problem.frequencies)
        self.later = self.passed + len(problem.passes)
        self.count = self.later + len(self.free_times)

    def solve(
        self, now: SampledMotion, loads: SampledLoads, trust: float
    ) -> tuple[Array, Array, float]:
        """Compute the step (free, inputs), later times of poses, and the merit promised."""
        # Columns by input, then by coefficient: derivatives of loads by y.
        J = self._by_coefficients(loads)
        counted = self.problem.objective.rows @ J[:, :6] / self.scale
        r = now.wrench @ self.problem.objective.rows.T / self.scale
        cones = self._excitation_cones(r, counted) + self._pass_cones(now)
        q, H = self._costs(now, trust)
        constant = 0.5 * SMOOTH * self._mean_square(now.inputs[2] / self.problem.units)
        constant /= self.problem.acceleration**2
        if self.problem.objective.measure == "peak":
            q[self.size] = 1.0
            cones += self._peak_cones(r, counted)
        else:
            value = max(now.value / self.scale, SHAKING_RELATIVE)
            weighted = (self.weights[:, None, None] * counted).reshape(-1, self.size)
            q[: self.size] += (self.weights[:, None] * r).ravel() @ weighted / value
            H[: self.size, : self.size] += weighted.T @ weighted / value
            constant += 0.5 * (self._mean_square(r) / value + value)
        linear = [self._trust_rows(trust), *self._limit_rows(now, J[:, 6:], trust)]
        linear += self._time_rows(now, trust)
        x = solve_cones(q, cones, linear, H)
        later = np.zeros(len(self.problem.passes))
        if not np.isfinite(x).all():
            return np.zeros((self.free, self.width)), later, np.inf
        later[self.free_times] = x[self.later :]
        promised = float(q @ x + 0.5 * x @ H @ x + constant)
        return x[: self.size].reshape(self.width, self.free).T, later, promised

    def _mean_square(self, values: Array) -> float:
        """Compute the mean over time of the squares of vectors (N, …)."""
        return float(((self.weights[:, None] * values) ** 2).sum())

    def _costs(self, now: SampledMotion, trust: float) -> tuple[Array, Array]:
        """Build the linear and the quadratic part of what a step costs."""
        q, H = np.zeros(self.count), np.zeros((self.count, self.count))
        q[self.size + 1 : self.later] = PRICE
        times = range(self.later, self.count)
        H[times, times] = STEP_WEIGHT / (trust * TIME_TRUST * self.space.duration) ** 2
        weighted = self.weights[:, None] ** 2 * now.inputs[2]
        slope = SMOOTH / self.problem.acceleration**2 * (self.basis[2].T @ weighted)
        for k, unit in enumerate(self.problem.units):
            columns = slice(k * self.free, (k + 1) * self.free)
            q[columns] = slope[:, k] / unit**2
            step = STEP_WEIGHT / (trust * unit) ** 2 / self.free
            H[columns, columns] = self.acceleration / unit**2 + step * np.eye(self.free)
        return q, H

    def _by_coefficients(self, loads: SampledLoads) -> Array:
        """Compute derivatives of ``[wrench; torque]`` by Δy (N, 6 + w, w free)."""
        parts = zip((loads.by_u, loads.by_ud, loads.by_udd), self.basis, strict=False)
        J = sum(by[..., None] * basis[:, None, None] for by, basis in parts)
        return np.asarray(J).reshape(len(self.weights), -1, self.size)

    def _peak_cones(self, r: Array, J: Array) -> list[tuple[Array, Array]]:
        """Build the cones ``|r_k + J_k Δy| ≤ t`` of all samples."""
        samples, m = r.shape
        matrix = np.zeros((samples, m + 1, self.count))
        matrix[:, 0, self.size] = 1.0
        matrix[:, 1:, : self.size] = J
        constant = np.concatenate([np.zeros((samples, 1)), r], axis=1)
        return list(zip(matrix, constant, strict=True))

    def _excitation_cones(self, r: Array, J: Array) -> list[tuple[Array, Array]]:
        """Build the cones of the excitation of the base, one for each frequency."""
        cones, m = [], r.shape[1]
        count = len(self.problem.frequencies)
        for k in range(count):
            weights = self.excitations[[k, count + k]]
            matrix = np.zeros((2 * m + 1, self.count))
            matrix[0, self.excited + k] = 1.0
            matrix[1:, : self.size] = np.tensordot(weights, J, 1).reshape(2 * m, -1)
            cones.append((matrix, np.append(0.0, (weights @ r).ravel())))
        return cones

    def _pass_cones(self, now: SampledMotion) -> list[tuple[Array, Array]]:
        """Build the cones of the poses that are passed: ``|g + G (B Δy + u̇ Δt)| ≤ s``."""
        if not self.problem.passes:
            return []
        cones, B = [], self.space.basis(now.at, 0)
        for k, (off, by_u) in enumerate(zip(now.missed.off, now.missed.by_u, strict=True)):
            matrix = np.zeros((off.size + 1, self.count))
            matrix[0, self.passed + k] = 1.0
            matrix[1:, : self.size] = (by_u[:, :, None] * B[k]).reshape(off.size, -1)
            if k in self.free_times:
                place = self.later + self.free_times.index(k)
                matrix[1:, place] = by_u @ now.missed.rates[k]
            cones.append((matrix, np.append(0.0, off)))
        return cones

    def _time_rows(self, now: SampledMotion, trust: float) -> list[tuple[Array, Array]]:
        """Build the rows of the order of times, and of their trust region."""
        if not self.free_times:
            return []
        count = len(self.free_times)
        order, constants = order_rows(self.problem, now.at, self.space.duration)
        rows = np.concatenate([order, np.eye(count), -np.eye(count)])
        matrix = np.zeros((len(rows), self.count))
        matrix[:, self.later :] = rows
        most = trust * TIME_TRUST * self.space.duration
        return [(matrix, np.concatenate([constants, np.full(2 * count, most)]))]

    def _trust_rows(self, trust: float) -> tuple[Array, Array]:
        """Build the rows of the trust region, and of excesses that are not negative."""
        free = np.repeat(self.problem.units * trust, self.free)
        eye = np.eye(self.count)
        extra = eye[self.size + 1 : self.later]
        matrix = np.concatenate([eye[: self.size], -eye[: self.size], extra, eye[[self.size]]])
        return matrix, np.concatenate([free, free, np.zeros(len(extra) + 1)])

    def _limit_rows(
        self, now: SampledMotion, by_torque: Array, trust: float
    ) -> list[tuple[Array, Array]]:
        """Build the rows of all limits that a step can reach, over their sizes."""
        rows, limits = [], self.problem.limits
        reach = np.repeat(self.problem.units * trust, self.free)
        for place, (kind, k) in enumerate(self.groups, self.size + 1):
            columns = slice(k * self.free, (k + 1) * self.free)
            matrix = np.zeros((len(self.weights), self.count))
            if kind == TORQUE:
                matrix[:, : self.size], x = by_torque[:, k], now.torque[:, k]
            else:
                matrix[:, columns], x = self.basis[kind], now.inputs[kind, :, k]
            span = limits.spans[kind, k]
            reserve = 0.0 if kind == 0 else RESERVE
            change = np.abs(matrix[:, : self.size]) @ reach
            for sign, limit in ((1.0, limits.upper), (-1.0, -limits.lower)):
                most = limit[kind, k] - reserve * span
                near = sign * x + change > most
                block = -sign * matrix[near] / span
                block[:, place] = 1.0
                rows.append((block, (most - sign * x[near]) / span))
        return rows
