"""Smooth closed motions in time: inputs, and all other joints following on one branch.

The inputs are functions of time; positions of the other joints are predicted by their
Taylor series and closed by Newton's method, so that errors do not add up. With the series of
the motion along ``u̇`` (see `kinematics.closure.series`) the rates are

    q̇ = C_0 u̇        q̈ = C_0 ü + C_1 u̇
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.verification.csv_motion import read_columns, refuse_row
from kinematics.closure.joint_positions import input_chain, joint_positions
from kinematics.closure.newton import follow_ray, forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.errors import MotionError, PoseError
from kinematics.linalg.skyline_qr import pivots
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion

__all__ = [
    "FIRM", "Trajectory", "drive", "from_csv", "order_inputs", "random_motions", "rest_to_rest",
]  # fmt: skip

Array = NDArray[np.float64]

# Order of the series that predict the next sample.
ORDER = 3
# Steps between two samples at most; the first may be far from the reference pose.
STEPS = 200
# Random motions: harmonics of one period, first amplitude in radians and characteristic
# lengths, factor by which it shrinks, and the least one tried.
HARMONICS = 3
AMPLITUDE, SHRINK, LEAST = 0.8, 0.7, 1e-3
# Near a singularity joints are faster by so much than at the reference pose, for the same
# rates of the inputs, or the loops hold them less firmly by so much.
FASTER, FIRM = 4.0, 0.25
# A closed motion must come back to where it began, in radians and characteristic lengths.
BACK = 1e-9
# Inputs that change by less, relative to their size, do not move; forces of joints at other
# rates underflow or overflow, SI units.
STILL, SLOWEST, FASTEST = 1e-12, 1e-100, 1e100
# How far the rows of a table may be from a motion's relations, and the fewest: a spline of
# degree five needs six.
OFF, SAMPLES = 1e-9, 6


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
        closure: largest mismatch of the loops, in radians and characteristic lengths.
        firmness: how firmly the loops hold the other joints at worst, relative to the
            reference pose; 0 at a singularity, near which round-off is amplified.
    """

    time: Array
    u: Array
    ud: Array
    udd: Array
    q: Array
    qd: Array
    qdd: Array
    closure: float
    firmness: float

    def __repr__(self) -> str:
        """One line in words."""
        count, joints = self.q.shape
        return f"Trajectory: {count} samples of {joints} joints over {self.duration:.4g} s"

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, seconds."""
        return float(self.time[-1] - self.time[0])

    @property
    def moves(self) -> bool:
        """Whether inputs move, neither too slowly nor too fast."""
        far = np.ptp(self.u, axis=0).max(initial=0.0)
        rate = np.abs(self.qd).max(initial=0.0)
        size = max(1.0, np.abs(self.u).max(initial=0.0))
        return bool(far > STILL * size and SLOWEST < rate < FASTEST)


def drive(
    linkage: Linkage, time: ArrayLike, u: ArrayLike, ud: ArrayLike, udd: ArrayLike
) -> Trajectory:
    """The motion of all joints when the inputs move as given.

    Args:
        linkage: an assembled linkage.
        time: samples in seconds (N,).
        u: displacements of the inputs from the reference pose (N, mobility), SI units; the
            first sample is reached from the reference pose along a straight line.
        ud: their velocities.
        udd: their accelerations.

    Raises:
        PoseError: the loops cannot be closed on the way, on the branch that the linkage is on.
    """
    t, *path = (np.asarray(x, dtype=np.float64) for x in (time, u, ud, udd))
    if t.ndim != 1 or any(x.shape != (t.size, linkage.mobility) for x in path):
        raise PoseError(
            f"{linkage.source}: give one row of {linkage.mobility} inputs "
            f"({', '.join(linkage.inputs)}) for each time"
        )
    if not all(np.isfinite(x).all() for x in (t, *path)):
        raise PoseError(f"{linkage.source}: the motion must be of finite numbers")
    found = _track(linkage, input_chain(linkage), (t, *path))
    if isinstance(found, Trajectory):
        return found
    raise PoseError(
        f"{linkage.source}: the loops cannot be closed beyond {found:.6g} s of the motion; "
        "give smaller displacements"
    )


def random_motions(
    linkage: Linkage,
    count: int = 10,
    samples: int = 200,
    seed: int = 0,
    *,
    motion: Motion | None = None,
    period: float = 1.0,
) -> Iterator[Trajectory]:
    """Random smooth motions that begin and end at the reference pose.

    Each coordinate is a sum of the first sines of the period with random amplitudes and
    phases. The amplitude shrinks until the loops close all the way on one branch and no pose
    is near a singularity: joints at most four times as fast, for the same rates of the inputs,
    as at the reference pose, and the loops at least a quarter as firm.

    Args:
        linkage: an assembled linkage.
        count: how many.
        samples: of each, both ends included.
        seed: seed of the random numbers; motion k is the same whatever ``count`` is.
        motion: restriction of the inputs; free by default.
        period: seconds.

    Raises:
        PoseError: no motion, however small, is found near the reference pose.
    """
    chain = input_chain(linkage)
    units = chain.units[linkage.positions_of(linkage.inputs)]
    basis = np.eye(linkage.mobility) if motion is None else order_inputs(motion, linkage)
    basis = np.linalg.qr(basis / units[:, None])[0] * units[:, None] if basis.size else basis
    time = np.linspace(0.0, period, samples)
    fastest, least = FASTER * _fastest(chain), FIRM
    amplitude = AMPLITUDE
    for number in range(count):
        path = _sines(np.random.default_rng([seed, number]), time, basis.shape[1])
        amplitude = min(AMPLITUDE, amplitude / SHRINK)
        while True:
            inputs = [amplitude * x @ basis.T for x in path]
            found = _track(linkage, chain, (time, *inputs), fastest, least)
            if isinstance(found, Trajectory) and _returned(found, chain):
                yield found
                break
            amplitude *= SHRINK
            if amplitude < LEAST:
                raise PoseError(
                    f"{linkage.source}: no motion was found near the reference pose; write "
                    "the file at a pose further from a singularity, or name other inputs"
                )


def _fastest(chain: Chain) -> float:
    """Largest rate of a joint for unit rates of the inputs, at the reference pose."""
    series = expand_from(chain, chain.screws, np.zeros((1, chain.width)), 0)
    return max(1.0, float(np.abs(series.C).max(initial=0.0)))


def _firmness(chain: Chain, screws: Array) -> float:
    """Least distance of a column of the loop matrix from those before it; 0 if singular."""
    found = pivots(screws, chain.mimics, chain.envelope, chain.dependent.size)
    return float(np.abs(found).min()) if found.size else 1.0


def order_inputs(motion: Motion, linkage: Linkage) -> Array:
    """The basis of a motion with its rows in the order of the linkage's inputs."""
    if sorted(motion.inputs) != sorted(linkage.inputs):
        problem = f"made for the inputs {', '.join(motion.inputs)}"
        text = ", ".join(motion.relations)
        raise MotionError(text, problem, linkage.inputs, linkage.source)
    return motion.basis[[motion.inputs.index(name) for name in linkage.inputs]]


def _sines(rng: np.random.Generator, time: Array, width: int) -> list[Array]:
    """Sums of sines that start at 0, within 1, and their two derivatives; (N, width)."""
    k = np.arange(1, HARMONICS + 1)[:, None]
    size = rng.uniform(0.3, 1.0, (HARMONICS, width)) * rng.choice([-1.0, 1.0], width) / k
    phase = rng.uniform(-0.8, 0.8, (HARMONICS, width))
    omega = 2.0 * np.pi * k / (time[-1] - time[0])
    angle = omega * time[:, None, None] + phase
    path = np.einsum("kw,tkw->tw", size, np.sin(angle) - np.sin(phase))
    scale = 1.0 / np.abs(path).max(axis=0, initial=0.0)
    speed = np.einsum("kw,tkw->tw", size * omega, np.cos(angle))
    change = -np.einsum("kw,tkw->tw", size * omega**2, np.sin(angle))
    return [scale * path, scale * speed, scale * change]


def _returned(found: Trajectory, chain: Chain) -> bool:
    """Whether all joints come back to where they began: otherwise the branch changed."""
    return bool(np.all(np.abs(found.q[-1] - found.q[0]) <= BACK * chain.units))


def rest_to_rest(
    linkage: Linkage, poses: ArrayLike, duration: float = 1.0, samples: int = 200
) -> Trajectory:
    """A motion that rests at given poses, with straight lines of the inputs in between.

    On each line ``s(τ) = 10 τ³ - 15 τ⁴ + 6 τ⁵``, so that velocity and acceleration vanish at
    both ends.

    Args:
        linkage: an assembled linkage.
        poses: displacements of the inputs from the reference pose (poses, mobility), at least
            two, SI units.
        duration: of each line, seconds.
        samples: of the whole motion.

    Raises:
        PoseError: the loops cannot be closed on the way.
    """
    stops = np.asarray(poses, dtype=np.float64)
    if stops.ndim != 2 or len(stops) < 2 or stops.shape[1] != linkage.mobility:
        raise PoseError(
            f"{linkage.source}: give two or more poses of {linkage.mobility} inputs "
            f"({', '.join(linkage.inputs)})"
        )
    tau = np.linspace(0.0, len(stops) - 1.0, samples)
    leg = np.minimum(tau.astype(np.int64), len(stops) - 2)
    x = (tau - leg)[:, None]
    way = np.diff(stops, axis=0)[leg]
    u = stops[leg] + way * (x**3 * (10.0 - 15.0 * x + 6.0 * x * x))
    ud = way * (30.0 * x * x * (1.0 - x) ** 2) / duration
    udd = way * (60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)) / duration**2
    return drive(linkage, duration * tau, u, ud, udd)


def from_csv(
    linkage: Linkage, path: str | PathLike[str], motion: Motion | None = None
) -> Trajectory:
    """A motion from a table: a column ``time`` and one for each input, by its name.

    Positions in between belong to the spline of degree five through the rows, which tells
    velocities and accelerations.

    Args:
        linkage: an assembled linkage.
        path: file of comma-separated values; displacements from the reference pose, SI.
        motion: relations that the inputs must fulfil.

    Raises:
        FileError: the file is no such table, or nothing moves in it.
        PoseError: the loops cannot be closed on the way.
    """
    from scipy.interpolate import make_interp_spline

    table = read_columns(path, ["time", *linkage.inputs], SAMPLES)
    time, u = table[:, 0], table[:, 1:]
    if not np.all(np.diff(time) > 0.0):
        raise refuse_row(path, "", "its times do not increase")
    if motion is not None:
        basis = np.linalg.qr(order_inputs(motion, linkage))[0]
        if np.abs(u - u @ basis @ basis.T).max() > OFF * max(1.0, np.abs(u).max()):
            raise refuse_row(path, "", f"its rows are not on {', '.join(motion.relations)}")
    spline = make_interp_spline(time, u, k=5)
    if (way := drive(linkage, time, u, spline(time, 1), spline(time, 2))).moves:
        return way
    raise refuse_row(path, "", "nothing moves", "give inputs that change with time")


def _track(
    linkage: Linkage, chain: Chain, path: tuple[Array, ...],
    fastest: float = np.inf, least: float = 0.0,
) -> Trajectory | float:  # fmt: skip
    """The trajectory, or the time beyond which it cannot be followed.

    Args:
        linkage: the linkage.
        chain: its arrays, from `input_chain`.
        path: time, displacements of the inputs, velocities, accelerations.
        fastest: what rates of joints may be, for unit rates of the inputs.
        least: what the firmness must be, relative to the reference pose.
    """
    time, u, ud, udd = path
    inputs = linkage.positions_of(linkage.inputs)
    scale = chain.units[inputs]
    # Random motions start at the reference pose, where nothing has to be closed.
    start = np.zeros(chain.parent.size)
    if u[:1].any():
        start = joint_positions(linkage, u[0]) / chain.units
    pose = forward_kinematics(chain, start)
    q, qd, qdd = (np.zeros((time.size, chain.parent.size)) for _ in range(3))
    closure, firmness = 0.0, 1.0
    held = _firmness(chain, chain.screws)
    # What is ahead depends on one column only, the ray: far fewer numbers to expand.
    narrow = replace(chain, moves=freeze(chain.moves.any(axis=1, keepdims=True), np.bool_))
    steps = zip(u / scale, ud / scale, udd / scale, strict=True)
    for k, (now, speed, change) in enumerate(steps):
        ahead = u[min(k + 1, len(u) - 1)] / scale - now
        length = float(np.sqrt(ahead @ ahead))
        ray = ahead / length if length > 0.0 else ahead
        C = expand_from(chain, pose.screws, speed[None], 1).C[0]
        firmness = min(firmness, _firmness(chain, pose.screws) / held)
        if not (np.abs(C[0]).max(initial=0.0) <= fastest and firmness >= least):
            return float(time[k])
        q[k], qd[k], qdd[k] = pose.q, C[0] @ speed, C[0] @ change + C[1] @ speed
        closure = max(closure, forward_kinematics(chain, pose.q).error)
        left, line = length, replace(narrow, columns=freeze((chain.columns @ ray)[:, None]))
        for _ in range(STEPS):
            if left == 0.0:
                break
            series = expand_from(line, pose.screws, np.ones((1, 1)), ORDER)
            pose, step = follow_ray(line, pose.q, series, np.ones(1), left)
            if step == 0.0:
                return float(time[k])
            left -= step
        if left > 0.0:
            return float(time[k])
    q, qd, qdd = (chain.units * x for x in (q, qd, qdd))
    return Trajectory(
        freeze(time), freeze(u), freeze(ud), freeze(udd), freeze(q), freeze(qd), freeze(qdd),
        closure, firmness,
    )  # fmt: skip
