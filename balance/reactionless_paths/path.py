"""A reactionless path as data: samples, momentum along it, events, and a motion in time."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from balance.motion_tolerances import PATH_MOMENTUM
from balance.reactionless_paths.follow import PathEvent
from balance.reactionless_paths.rest_equations import RestEquations
from balance.verification.trajectory import Trajectory, drive
from kinematics.closure.newton import forward_kinematics
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage

__all__ = ["ReactionlessPath", "path_table", "sample_path", "timed_path"]

Array = NDArray[np.float64]
Profile = Callable[[Array], tuple[Array, ...]]

# Degree of the spline through the samples, as that of a motion read from a table.
DEGREE = 5
# Samples of a motion in time.
TIMED_SAMPLES = 801
# Samples of a table: as many as give the spline through them the best accelerations, since
# round-off grows as samples get closer. Relative error that is good enough.
TABLE_SAMPLES = 101, 151, 201, 301, 401, 601, 801, 1201, 1601, 3201, 6401
TIMED_ERROR = 3e-11
# Arc length between the samples of a path that the motion follows, if they are closer.
TIMED_STEP = 0.004
# Duration of a motion, seconds.
DURATION = 1.0


@dataclass(frozen=True, eq=False)
class ReactionlessPath:
    """A path along which the demanded part of the momentum vanishes.

    Attributes:
        start: number of the pose that it leads through.
        direction: rates of the inputs there (mobility,), rad and m per unit of arc length.
        s: arc length in all joints, radians and characteristic lengths (N,); 0 at that pose.
        q: positions of all joints (N, n), rad and m, displacements from the reference pose.
        u: those of the inputs (N, mobility).
        momentum: momentum along the path over the sum of the sizes of the bodies' own (N,),
            with the rates of a spline of degree five through the samples.
        closure: largest mismatch of the loops, radians and characteristic lengths.
        events: ends and meetings, in order of s.
    """

    start: int
    direction: Array
    s: Array
    q: Array
    u: Array
    momentum: Array
    closure: float
    events: tuple[PathEvent, ...]

    def __repr__(self) -> str:
        """One line: its extent, and the largest momentum."""
        return (
            f"ReactionlessPath through pose {self.start + 1}: s from {self.s[0]:.4g} to "
            f"{self.s[-1]:.4g}, momentum ≤ {self.residual:.1e} of the bodies' own"
        )

    @property
    def residual(self) -> float:
        """Largest momentum along the path over the bodies' own."""
        return float(self.momentum.max())

    @property
    def reactionless(self) -> bool:
        """Whether the momentum vanishes at every sample."""
        return self.residual <= PATH_MOMENTUM

    @property
    def length(self) -> float:
        """Arc length between the two ends."""
        return float(self.s[-1] - self.s[0])

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``balance/schemas/paths.schema.json``."""
        return {
            "start": self.start,
            "direction": self.direction.tolist(),
            "length": self.length,
            "momentum": self.residual,
            "closure": self.closure,
            "events": [event._asdict() for event in self.events],
            "s": self.s.tolist(),
            "inputs": self.u.tolist(),
            "joints": self.q.tolist(),
        }


def sample_path(
    equations: RestEquations, start: int, s: Array, q: Array, events: tuple[PathEvent, ...]
) -> ReactionlessPath:
    """Measure the momentum of closed poses of a path, and keep them.

    Args:
        equations: the equations of the linkage.
        start: number of the pose that it leads through.
        s: arc lengths (N,), at least six.
        q: positions of all joints (N, n), chain units.
        events: of the path.
    """
    from scipy.interpolate import make_interp_spline

    linkage, chain = equations.linkage, equations.chain
    inputs = linkage.positions_of(linkage.inputs)
    rates = make_interp_spline(s, q[:, inputs], k=DEGREE)(s, 1)
    momentum = np.zeros(s.size)
    closure = 0.0
    for k, (pose, rate) in enumerate(zip(q, rates, strict=True)):
        h = equations.at(pose).rows @ (equations.basis.T @ rate)
        own = equations.own_momentum(pose, rate)
        momentum[k] = np.sqrt(h @ h) / own if own > 0.0 else 0.0
        closure = max(closure, forward_kinematics(chain, pose).error)
    middle = int(np.argmin(np.abs(s)))
    return ReactionlessPath(
        start, freeze(rates[middle] * chain.units[inputs]), freeze(s), freeze(q * chain.units),
        freeze(q[:, inputs] * chain.units[inputs]), freeze(momentum), closure, events,
    )  # fmt: skip


def _rest_to_rest(x: Array) -> tuple[Array, ...]:
    """Compute ``σ(τ) = (1 - cos π τ) / 2`` and two derivatives: at rest at both ends."""
    return (
        0.5 - 0.5 * np.cos(np.pi * x), 0.5 * np.pi * np.sin(np.pi * x),
        0.5 * np.pi**2 * np.cos(np.pi * x),
    )  # fmt: skip


def _ever_faster(x: Array) -> tuple[Array, ...]:
    """Compute ``σ(τ) = τ²`` and two derivatives: uniformly accelerated from rest.

    Without higher derivatives of its own: a spline through few samples is exact at its ends.
    """
    return x * x, 2.0 * x, np.full_like(x, 2.0)


def _timed_inputs(
    path: ReactionlessPath, duration: float, count: int, profile: Profile
) -> tuple[Array, ...]:
    """Compute time, inputs, velocities and accelerations along a path."""
    from scipy.interpolate import make_interp_spline

    apart = max(1, int(TIMED_STEP * (len(path.s) - 1) / path.length))
    kept = np.unique([*range(0, len(path.s), apart), len(path.s) - 1])
    if path.residual > TIMED_ERROR or kept.size < 16:
        kept = np.arange(len(path.s))
    spline = make_interp_spline(path.s[kept], path.u[kept], k=DEGREE)
    tau = np.linspace(0.0, 1.0, count)
    where, speed, change = (path.length * x[:, None] for x in profile(tau))
    s = np.clip(path.s[0] + where[:, 0], path.s[0], path.s[-1])
    first, second = spline(s, 1), spline(s, 2)
    return (
        duration * tau, spline(s), first * speed / duration,
        (second * speed**2 + first * change) / duration**2,
    )  # fmt: skip


def _table_inputs(path: ReactionlessPath, duration: float) -> tuple[Array, Array]:
    """Compute time and inputs from which a spline has the best accelerations."""
    from scipy.interpolate import make_interp_spline

    least, best = np.inf, (np.empty(0), np.empty((0, 0)))
    for count in TABLE_SAMPLES:
        time, u, _, udd = _timed_inputs(path, duration, count, _ever_faster)
        found = make_interp_spline(time, u, k=DEGREE)(time, 2)
        error = float(np.abs(found - udd).max() / (np.abs(udd).max() or 1.0))
        if error < least:
            least, best = error, (time, u)
        if error <= TIMED_ERROR:
            break
    return best


def timed_path(
    linkage: Linkage, path: ReactionlessPath, duration: float = DURATION
) -> Trajectory:
    """Compute a motion along a path that rests at both of its ends.

    ``s(τ) = (1 - cos π τ) / 2`` of the length, τ the share of the duration.

    Args:
        linkage: the linkage.
        path: a path of it.
        duration: seconds.

    Returns:
        The motion of all joints.

    Raises:
        PoseError: an end of the path is not reached along a straight line of the inputs.
    """
    return drive(linkage, *_timed_inputs(path, duration, TIMED_SAMPLES, _rest_to_rest))


def path_table(linkage: Linkage, path: ReactionlessPath, duration: float = DURATION) -> bytes:
    """Write a motion along a path as a table that ``balance verify --csv`` reads.

    It is uniformly accelerated from rest: the spline that is put through the rows follows such
    a motion best.

    Args:
        linkage: the linkage.
        path: a path of it.
        duration: seconds.

    Returns:
        Comma-separated values: ``time`` and the inputs, displacements in rad and m.
    """
    time, u = _table_inputs(path, duration)
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["time", *linkage.inputs])
    writer.writerows([[repr(float(x)) for x in row] for row in np.column_stack([time, u])])
    return text.getvalue().encode()
