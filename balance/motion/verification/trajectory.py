"""Smooth motions in time that close the loops, on one branch.

The inputs are functions of time. A Taylor series predicts the other joints at the next sample,
and Newton's method closes the loops there, so errors do not accumulate. With the series of the
motion along ``u̇`` (see `kinematics.closure.series`) the rates are

    q̇ = C_0 u̇        q̈ = C_0 ü + C_1 u̇
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import (
    CONDITIONING_LEAST,
    CONDITIONING_NOTICE,
    INPUT_RANGE_RELATIVE,
    JOINT_RATE_RATIO,
    MOTION_RETURN,
    SAMPLE_REST,
)
from balance.motion.verification.input_paths import InputPath, SinePath, random_sines
from balance.motion.verification.motion_kernels import (
    follow_planar_samples,
    follow_samples,
    motion_workspace,
)
from balance.motion.verification.table_rounding import InputErrors
from kinematics.closure.joint_positions import input_chain, joint_positions
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.errors import MotionError, PoseError
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.skyline_qr import pivots

# Random motions: their first amplitude, radians and characteristic lengths.
FIRST_AMPLITUDE = 0.8
# Factor by which the amplitude shrinks after a motion that cannot be followed.
AMPLITUDE_FACTOR = 0.7
# The least amplitude tried, of the fastest joint.
LEAST_AMPLITUDE = 1e-3
# Joint rates outside this range, SI units, make forces that underflow or overflow.
SLOWEST = 1e-100
FASTEST = 1e100


@dataclass(frozen=True, eq=False)
class Trajectory:
    """A motion sampled in time; all displacements are from the reference pose, SI units.

    Attributes:
        time: seconds (N,).
        u: displacements of the inputs (N, mobility).
        ud: their velocities.
        udd: their accelerations.
        q: positions of all joints, in the order of ``linkage.joints`` (N, n).
        qd: their velocities.
        qdd: their accelerations.
        closure: largest closure residual, in radians and characteristic lengths.
        conditioning: smallest pivot of the loop matrix along the motion over the one at the
            reference pose; 0 at a singularity, near which round-off is amplified.
        path: the inputs as functions of time, if they are known between the samples.
        errors: how far the inputs can be off, since a table of them is rounded; None for
            inputs that are exact.
    """

    time: Array
    u: Array
    ud: Array
    udd: Array
    q: Array
    qd: Array
    qdd: Array
    closure: float
    conditioning: float
    path: InputPath | None = None
    errors: InputErrors | None = None

    def __repr__(self) -> str:
        """One line: number of samples and joints, and the duration."""
        count, joints = self.q.shape
        return f"Trajectory: {count} samples of {joints} joints over {self.duration:.4g} s"

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, seconds."""
        return float(self.time[-1] - self.time[0])

    @property
    def moves(self) -> bool:
        """Whether the inputs move, neither too slowly nor too fast."""
        span = np.ptp(self.u, axis=0).max(initial=0.0)
        rate = np.abs(self.qd).max(initial=0.0)
        size = max(1.0, np.abs(self.u).max(initial=0.0))
        return bool(span > INPUT_RANGE_RELATIVE * size and SLOWEST < rate < FASTEST)


class Stop(NamedTuple):
    """Where a motion of the inputs cannot be followed any further.

    Attributes:
        time: of the last sample that is reached, seconds.
        share: of the way from there to the next sample, as far as the loops close.
    """

    time: float
    share: float


def singularity_remark(motions: Iterable[Trajectory]) -> str:
    """Say that motions pass near a singularity; empty if none does."""
    if all(motion.conditioning >= CONDITIONING_NOTICE for motion in motions):
        return ""
    return (
        "the motion passes near a singularity, where round-off is amplified: what little is "
        "left to shake there may be no more than that"
    )


def drive(
    linkage: Linkage,
    time: ArrayLike,
    u: ArrayLike,
    ud: ArrayLike,
    udd: ArrayLike,
    *,
    start: Array | None = None,
) -> Trajectory:
    """Compute the motion of all joints for given motions of the inputs.

    The joint rates are ``q̇ = C_0 u̇`` and ``q̈ = C_0 ü + C_1 u̇``.

    Args:
        time: samples in seconds (N,).
        u: displacements of the inputs from the reference pose (N, mobility), SI units; the
            first sample is reached from the reference pose along a straight line.
        ud: velocities of the inputs (N, mobility).
        udd: accelerations of the inputs (N, mobility).
        start: positions of all joints (n,) at the first sample, where they are known from a
            motion on the linkage's branch.

    Returns:
        The motion of all joints.

    Raises:
        PoseError: the loops cannot be closed along the motion on the linkage's branch.
    """
    t, *path = (np.asarray(x, dtype=np.float64) for x in (time, u, ud, udd))
    if t.ndim != 1 or any(x.shape != (t.size, linkage.mobility) for x in path):
        raise PoseError(
            f"{linkage.source}: give one row of {linkage.mobility} inputs "
            f"({', '.join(linkage.inputs)}) for each time"
        )
    if not all(np.isfinite(x).all() for x in (t, *path)):
        raise PoseError(f"{linkage.source}: the motion must be of finite numbers")
    outcome = track(linkage, (t, *path), start=start)
    if isinstance(outcome, Trajectory):
        return outcome
    raise PoseError(
        f"{linkage.source}: the loops cannot be closed beyond {outcome.time:.6g} s of the "
        "motion; give smaller displacements"
    )


def random_motions(
    linkage: Linkage,
    count: int = 10,
    samples: int = 200,
    seed: int = 0,
    *,
    motion: Motion | None = None,
) -> Iterator[Trajectory]:
    """Generate random smooth motions of 1 s that begin and end at the reference pose.

    Each coordinate is a sum of the first sines of that period with random amplitudes and
    phases. The amplitude shrinks until the loops close along the motion on one branch and no
    pose is near-singular. A pose counts as near-singular if some joint is more than four times
    faster than at the reference pose for the same rates of the inputs, or the smallest pivot
    of the loop matrix is below a quarter of its reference value.

    Args:
        samples: samples of each motion, both ends included.
        seed: seed of the random numbers; motion k is the same whatever ``count`` is.
        motion: restriction of the inputs; free by default.

    Yields:
        The motions.

    Raises:
        PoseError: no motion, however small, is found near the reference pose.
    """
    chain = input_chain(linkage)
    units = chain.units[linkage.positions_of(linkage.inputs)]
    basis = np.eye(linkage.mobility) if motion is None else order_inputs(motion, linkage)
    basis = np.linalg.qr(basis / units[:, None])[0] * units[:, None] if basis.size else basis
    time = np.linspace(0.0, 1.0, samples)
    rate = _largest_rate(chain)
    fastest, least = JOINT_RATE_RATIO * rate, CONDITIONING_LEAST
    amplitude = FIRST_AMPLITUDE
    for number in range(count):
        sines = random_sines(np.random.default_rng([seed, number]), time, basis.shape[1])
        amplitude = min(FIRST_AMPLITUDE, amplitude / AMPLITUDE_FACTOR)
        while True:
            path = replace(sines, basis=basis, amplitude=amplitude)
            outcome = track(linkage, (time, *path.at(time)), fastest, least)
            if isinstance(outcome, Trajectory) and _returns(outcome, chain):
                yield replace(outcome, path=path)
                break
            amplitude *= AMPLITUDE_FACTOR
            if amplitude * rate < LEAST_AMPLITUDE:
                raise PoseError(
                    f"{linkage.source}: no motion was found near the reference pose; write "
                    "the file at a pose further from a singularity, or name other inputs"
                )


def input_reach(linkage: Linkage, trajectories: Iterable[Trajectory]) -> dict[str, float]:
    """Find the largest displacement of each input in motions, from the reference pose.

    Returns:
        Radians or metres, by the name of the input.
    """
    sizes = np.max([np.abs(each.u).max(axis=0) for each in trajectories], axis=0)
    return dict(zip(linkage.inputs, sizes.tolist(), strict=True))


def are_shortened(trajectories: Iterable[Trajectory]) -> bool:
    """Whether all are random motions that are smaller than the first that was tried."""
    return all(
        isinstance(each.path, SinePath) and each.path.amplitude < 0.99 * FIRST_AMPLITUDE
        for each in trajectories
    )


def _largest_rate(chain: Chain) -> float:
    """Compute the largest joint rate at the reference pose, for unit rates of the inputs."""
    series = expand_from(chain, chain.screws, np.zeros((1, chain.width)), 0)
    return max(1.0, float(np.abs(series.C).max(initial=0.0)))


def loop_pivot(chain: Chain, screws: Array) -> float:
    """Compute the smallest pivot of the loop matrix; 0 at a singularity.

    Args:
        chain: the linkage as arrays.
        screws: joint screws at the pose (n, 6 or 3).
    """
    values = pivots(screws, chain.mimics, chain.envelope, chain.dependent.size)
    return float(np.abs(values).min()) if values.size else 1.0


def order_inputs(motion: Motion, linkage: Linkage) -> Array:
    """Return the basis of a motion with its rows in the order of the linkage's inputs.

    Args:
        linkage: the linkage with the same inputs.

    Returns:
        The basis (mobility, w).

    Raises:
        MotionError: the motion has other inputs.
    """
    if sorted(motion.inputs) != sorted(linkage.inputs):
        problem = f"made for the inputs {', '.join(motion.inputs)}"
        text = ", ".join(motion.relations)
        raise MotionError(text, problem, linkage.inputs, linkage.source)
    return motion.basis[[motion.inputs.index(name) for name in linkage.inputs]]


def _returns(trajectory: Trajectory, chain: Chain) -> bool:
    """Whether all joints return to their start; otherwise the branch changed."""
    return bool(
        np.all(np.abs(trajectory.q[-1] - trajectory.q[0]) <= MOTION_RETURN * chain.units)
    )


def _compute_ways(u: Array) -> tuple[Array, Array]:
    """Compute the ways of the inputs to the next sample (N, w), and their lengths (N,).

    A way within `SAMPLE_REST` is none, and the next one makes up for it.
    """
    ways = np.diff(u, axis=0, append=u[-1:])
    for k in np.flatnonzero(np.linalg.norm(ways[:-1], axis=1) <= SAMPLE_REST):
        if np.linalg.norm(ways[k]) <= SAMPLE_REST:
            ways[k + 1] += ways[k]
            ways[k] = 0.0
    ways[-1] = 0.0
    return ways, np.linalg.norm(ways, axis=1)


def track(
    linkage: Linkage,
    path: tuple[Array, ...],
    fastest: float = np.inf,
    least: float = 0.0,
    *,
    shortest: float = 0.0,
    start: Array | None = None,
) -> Trajectory | Stop:
    """Follow a motion of the inputs: the trajectory, or where it cannot go on.

    Args:
        path: time, displacements of the inputs, velocities, accelerations.
        fastest: bound on joint rates for unit rates of the inputs.
        least: bound on the conditioning, relative to the reference pose.
        shortest: step of the inputs, radians and characteristic lengths, below which they have
            reached a limit: steps shrink towards a dead centre without an end.
        start: positions of all joints at the first sample; computed by default.
    """
    # A planar linkage without idle joints is followed in its plane.
    flat = linkage.chain.planar and not linkage.idle
    chain = linkage.chain if flat else input_chain(linkage)
    time, u, ud, udd = path
    scale = chain.units[linkage.positions_of(linkage.inputs)]
    if start is None:
        # Random motions start at the reference pose, where the loops are closed.
        start = joint_positions(linkage, u[0]) if u[:1].any() else np.zeros(chain.parent.size)
    start = start / chain.units
    pose = forward_kinematics(chain, start)
    motion = tuple(np.zeros((time.size, chain.parent.size)) for _ in range(3))
    extremes = np.array([0.0, 1.0, 0.0])
    # Predict along one direction only: the expansion has far fewer numbers.
    moves = freeze(chain.moves.any(axis=1, keepdims=True), np.bool_)
    advance, lengths = _compute_ways(u / scale)
    directions = advance / np.where(lengths > 0.0, lengths, 1.0)[:, None]
    lines = freeze((directions @ chain.columns.T)[:, :, None])
    rates = (np.ascontiguousarray(x / scale)[:, None] for x in (ud, udd))
    purpose = ("motion",)
    workspace = chain.borrow(purpose, lambda: motion_workspace(chain))
    follow = follow_planar_samples if flat else follow_samples
    reached = follow(
        chain.walked,
        (lines, moves, lengths, *rates),
        np.array([fastest, least, loop_pivot(chain, chain.screws), shortest]),
        (start.copy(), pose.H, pose.screws.copy(), np.empty(start.size)),
        (*motion, extremes),
        workspace,
    )
    chain.give_back(purpose, workspace)
    if reached < time.size:
        return Stop(float(time[reached]), float(extremes[2]))
    q, qd, qdd = (freeze(chain.units * x) for x in motion)
    time, u, ud, udd = map(freeze, path)
    return Trajectory(time, u, ud, udd, q, qd, qdd, *extremes[:2].tolist())
