"""A reactionless path as data: samples, momentum along it, events, and a motion in time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from balance.motion.motion_tolerances import (
    INTEGRAL_DETERMINED,
    PATH_MOMENTUM,
    RATE_RESIDUAL_RELATIVE,
)
from balance.motion.paths.follow import PathEvent
from balance.motion.paths.rest_equations import RestEquations
from balance.motion.verification.given_motions import rate_columns, rates_off
from balance.motion.verification.trajectory import Trajectory, drive
from balance.support.csv_text import csv_table
from kinematics.closure.newton import forward_kinematics
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, size_text

# Degree of the spline through the samples, as that of a motion read from a table.
DEGREE = 5
# Samples of a motion in time: the fewest that show its accelerations, and most.
TIMED_SAMPLES = 401, 801, 1601, 3201, 6401
# Singular values of the equations below this part of the momenta of the bodies are damped in
# corrections.
DAMPED = 1e-5
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
        rates: their derivatives by s (N, mobility), rad and m per unit of arc length.
        momentum: momentum along the path over the sum of the sizes of those of the bodies (N,),
            with the rates of a spline of degree five through the samples.
        closure: largest closure residual, radians and characteristic lengths.
        events: ends and meetings, in order of s.
        attitude: rotation vectors of a base that turns (N, 3), rad; None if it does not.
        allowed: momentum up to which the path counts as one without reaction.
    """

    start: int
    direction: Array
    s: Array
    q: Array
    u: Array
    rates: Array
    momentum: Array
    closure: float
    events: tuple[PathEvent, ...]
    attitude: Array | None = None
    allowed: float = PATH_MOMENTUM

    def __repr__(self) -> str:
        """One line: its extent, and the largest momentum."""
        return (
            f"ReactionlessPath through pose {self.start + 1}: s from "
            f"{number_text(self.s[0])} to "
            f"{number_text(self.s[-1])}, momentum {self.residual_text} of the bodies' own"
        )

    @property
    def residual(self) -> float:
        """Largest momentum along the path over those of the bodies."""
        return float(self.momentum.max())

    @property
    def residual_text(self) -> str:
        """The residual, as a bound where steps and round-off decide it."""
        return size_text(self.residual, floor=INTEGRAL_DETERMINED)

    @property
    def reactionless(self) -> bool:
        """Whether the momentum vanishes at every sample."""
        return self.residual <= self.allowed

    @property
    def length(self) -> float:
        """Arc length between the two ends."""
        return float(self.s[-1] - self.s[0])

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``balance/app/schemas/paths.schema.json``."""
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
            "attitude": None if self.attitude is None else self.attitude.tolist(),
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
    """
    from scipy.interpolate import make_interp_spline

    linkage, chain = equations.linkage, equations.chain
    inputs = linkage.positions_of(linkage.inputs)
    slopes = make_interp_spline(s, q[:, inputs], k=DEGREE)(s, 1)
    rows, magnitudes = equations.along(q, slopes)
    y = slopes @ equations.basis
    h = np.einsum("krw,kw->kr", rows, y)
    momentum = np.linalg.norm(h, axis=1) / np.where(magnitudes > 0.0, magnitudes, 1.0)
    closure = max(forward_kinematics(chain, pose).error for pose in q)
    middle, units = int(np.argmin(np.abs(s))), chain.units[inputs]
    tolerance = equations.demand.tolerance
    if not tolerance:
        y = y - _correction(rows, h, magnitudes)
    rates = y @ equations.basis.T * units
    return ReactionlessPath(
        start,
        freeze(rates[middle]),
        freeze(s),
        freeze(q * chain.units),
        freeze(q[:, inputs] * units),
        freeze(rates),
        freeze(momentum),
        closure,
        events,
        allowed=max(PATH_MOMENTUM, tolerance),
    )


def _correction(rows: Array, h: Array, magnitudes: Array) -> Array:
    """Compute the rates that take away the momentum which a spline leaves.

    ``A⁺ h`` with small singular values damped: near a meeting of paths, where they vanish, the
    rates along them leave no momentum, and their round-off is not to be divided by them.

    Args:
        rows: A (N, rows, w).
        h: ``A y`` for a y of about unit length (N, rows).
        magnitudes: size of the momenta of the bodies (N,).
    """
    U, sizes, Vt = np.linalg.svd(rows, full_matrices=False)
    damped = sizes**2 + (DAMPED * magnitudes[:, None]) ** 2
    weights = np.divide(sizes, damped, out=np.zeros_like(sizes), where=damped > 0.0)
    return np.einsum("kiw,ki,kri,kr->kw", Vt, weights, U, h)


def _timed_inputs(path: ReactionlessPath, duration: float) -> tuple[Array, Array, Array, Array]:
    """Compute time, inputs, velocities and accelerations of a motion along a path.

    ``s(τ) = (1 - cos π τ) / 2`` of the length, in so many samples that a spline through the
    inputs has the same velocities and accelerations: a reader can check them.
    """
    from scipy.interpolate import make_interp_spline

    rates = make_interp_spline(path.s, path.rates, k=DEGREE)
    inputs = rates.antiderivative()  # smoother than a spline through the displacements
    first = path.u[0] - inputs(path.s[0])
    for count in TIMED_SAMPLES:
        turn = np.pi * np.linspace(0.0, 1.0, count)[:, None]
        speed = 0.5 * np.pi * path.length / duration * np.sin(turn)
        change = 0.5 * path.length * (np.pi / duration) ** 2 * np.cos(turn)
        s = path.s[0] + 0.5 * path.length * (1.0 - np.cos(turn[:, 0]))
        s = np.clip(s, path.s[0], path.s[-1])
        ud, udd = rates(s) * speed, rates(s, 1) * speed**2 + rates(s) * change
        motion = np.linspace(0.0, duration, count), first + inputs(s), ud, udd
        if rates_off(*motion) <= 0.1 * RATE_RESIDUAL_RELATIVE:
            break
    return motion


def timed_path(
    linkage: LinkageLike, path: ReactionlessPath, duration: float = DURATION
) -> Trajectory:
    """Compute a motion along a path that rests at both of its ends.

    ``s(τ) = (1 - cos π τ) / 2`` of the length, τ the share of the duration.

    Args:
        linkage: the linkage, or what `kinematics.load` accepts.
        path: a path of it.
        duration: seconds.

    Returns:
        The motion of all joints.

    Raises:
        PoseError: an end of the path is not reached along a straight line of the inputs.

    Example:
        >>> import balance, kinematics, numpy as np
        >>> arm = kinematics.from_screws(
        ...     [kinematics.ScrewJoint("u1", "base", "upper"),
        ...      kinematics.ScrewJoint("u2", "upper", "lower", point=(1, 0, 0))],
        ...     bodies={"upper": (1, (0.5, 0, 0), np.eye(3)),
        ...             "lower": (1, (1.5, 0, 0), np.eye(3))},
        ... )
        >>> path = balance.find_paths(arm, kept="moment", length=0.1).paths[0]
        >>> balance.motion.timed_path(arm, path, duration=2.0).duration
        2.0
    """
    return drive(as_linkage(linkage), *_timed_inputs(path, duration))


def path_table(linkage: Linkage, path: ReactionlessPath, duration: float = DURATION) -> bytes:
    """Write a motion along a path as a table that ``balance verify --csv`` reads.

    It rests at both ends. Velocities and accelerations are in the table too: those of a spline
    through rounded displacements would have errors of 1e-9.

    Args:
        duration: seconds.

    Returns:
        Comma-separated values: ``time``, the inputs (displacements in rad and m), and their
        velocities and accelerations.
    """
    names = ["time", *linkage.inputs, *rate_columns(linkage)]
    return csv_table(names, _timed_inputs(path, duration))


def segments_table(linkage: Linkage, segments: Sequence[ReactionlessPath]) -> bytes:
    """Write a motion along segments as a table that ``balance verify --csv`` reads.

    Each takes `DURATION`, along ``630 ∫ τ⁴ (1 - τ)⁴ dτ`` of its length, so that four
    derivatives vanish where two meet, and a spline through the displacements is smooth there.

    Args:
        segments: each begins where the one before it ends.
    """
    from scipy.interpolate import make_interp_spline

    if len(segments) == 1:
        return path_table(linkage, segments[0])
    tau = np.linspace(0.0, 1.0, TIMED_SAMPLES[0])
    way = tau**5 * (126.0 + tau * (-420.0 + tau * (540.0 + tau * (-315.0 + 70.0 * tau))))
    times, inputs = [], []
    for k, path in enumerate(segments):
        s = np.clip(path.s[0] + path.length * way, path.s[0], path.s[-1])
        u = make_interp_spline(path.s, path.u, k=DEGREE)(s)
        times.append(DURATION * (k + tau)[k > 0 :])
        inputs.append(u[k > 0 :])
    columns = np.concatenate(times), np.concatenate(inputs)
    return csv_table(["time", *linkage.inputs], columns)
