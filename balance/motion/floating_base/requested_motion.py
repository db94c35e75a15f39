"""Drives of a linkage on its base: prescribed inputs or torques, and starting velocities."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike

import numpy as np

from balance.motion.floating_base.base import BaseInChain
from balance.motion.floating_base.equations import Drive
from balance.motion.motion_tolerances import RELATION_RESIDUAL
from balance.motion.verification.given_motions import MotionLike, from_csv
from balance.motion.verification.input_paths import InputPath, RestToRest, SplinePath
from balance.motion.verification.trajectory import Trajectory, order_inputs, random_motions
from kinematics.closure.joint_positions import values_by_input
from kinematics.errors import UsageError
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.wording import vector_text

BASE_VELOCITIES = ("wx", "wy", "wz", "vx", "vy", "vz")
"""Names of the velocities of a base: angular, and of its centre of mass."""

# Default duration, seconds, of a motion that has no end.
DURATION = 10.0
# Longest and shortest duration, seconds.
SHORTEST, LONGEST = 1e-9, 1e6


def prescribed_drive(
    linkage: Linkage,
    chain: Chain,
    motions: MotionLike | InputPath | None,
    motion: Motion,
    seed: int,
    duration: float | None,
) -> tuple[Drive, tuple[float, float]]:
    """Make the drive of inputs whose motion is prescribed, and its start and end.

    Args:
        motions: the motion; by default a random one from rest to rest, again and again.
        motion: restriction of a random motion.
        seed: seed of a random motion.
        duration: seconds, or None for the default.

    Raises:
        UsageError: the duration is longer than the motion is known, or no duration.
        PoseError: there is no random motion.
    """
    units = chain.units[linkage.positions_of(linkage.inputs)]
    start = 0.0
    recorded: Trajectory | InputPath | None
    if isinstance(motions, str | PathLike):
        recorded = from_csv(linkage, motions, motion)
    else:
        recorded = motions
    if recorded is None:
        (trajectory,) = random_motions(linkage, 1, seed=seed, motion=motion)
        assert trajectory.path is not None
        path: InputPath = RestToRest(trajectory.path, trajectory.duration)
    elif isinstance(recorded, Trajectory):
        start = float(recorded.time[0])
        path = recorded.path or SplinePath.through(recorded.time, recorded.u)
    else:
        path = recorded
    if isinstance(path, SplinePath):
        start = path.corners[0]
    span = start, start + _duration(path, duration)
    return Drive(np.eye(units.size), units, path, np.zeros(units.size)), span


def _duration(path: InputPath, duration: float | None) -> float:
    """Return the duration of a prescribed motion; see `prescribed_drive`."""
    if not isinstance(path, SplinePath):
        return checked_duration(duration)
    whole = path.corners[-1] - path.corners[0]
    if duration is not None and duration > whole:
        raise UsageError(f"the motion takes {whole:.6g} s, not {duration:g} s: give no more")
    return whole if duration is None else checked_duration(duration)


def checked_duration(duration: float | None) -> float:
    """Return a duration, 10 s by default.

    Raises:
        UsageError: it is too short or too long.
    """
    if duration is None:
        return DURATION
    if not SHORTEST <= duration <= LONGEST:
        raise UsageError(f"no motion takes {duration:g} s: give {SHORTEST:g} to {LONGEST:g}")
    return duration


def free_drive(
    linkage: Linkage, chain: Chain, torques: Mapping[str, float], motion: Motion
) -> Drive:
    """Make the drive of inputs that move freely under constant torques.

    Args:
        torques: N m or N by name; 0 for inputs that are not named.
        motion: restriction of the inputs.

    Raises:
        PoseError: there is no such input.
        UsageError: a torque is not finite.
    """
    units = chain.units[linkage.positions_of(linkage.inputs)]
    basis = np.linalg.qr(order_inputs(motion, linkage) / units[:, None])[0]
    if not np.isfinite(list(torques.values())).all():
        raise UsageError("torques must be finite numbers")
    load = values_by_input(linkage, torques) * units / chain.frame.length**2
    return Drive(basis, units, None, basis.T @ load)


def initial_rates(
    linkage: Linkage,
    chain: Chain,
    base: BaseInChain,
    drive: Drive,
    initial: Mapping[str, float],
) -> tuple[Array, Array]:
    """Compute the rates at the start of the freedoms of the base, and of free coordinates.

    Args:
        drive: how the inputs move.
        initial: velocities by name; see `balance.motion.simulate_floating_base`.

    Raises:
        PoseError: there is no such input.
        UsageError: a velocity is not finite, or cannot be chosen.
        MotionError: the inputs are restricted otherwise.
    """
    if not np.isfinite(list(initial.values())).all():
        raise UsageError("velocities at the start must be finite numbers")
    speeds = {name: value for name, value in initial.items() if name not in BASE_VELOCITIES}
    rates = values_by_input(linkage, speeds) / drive.units
    if speeds and not drive.free:
        raise UsageError(
            f"the motion of input {next(iter(speeds))} is prescribed, its velocity too: give "
            "torques to let it move freely"
        )
    y = drive.basis.T @ rates
    if np.abs(drive.basis @ y - rates).max(initial=0.0) > RELATION_RESIDUAL * max(
        1.0, np.abs(rates).max(initial=0.0)
    ):
        raise UsageError("the velocities of the inputs at the start break their relations")
    return _base_rates(chain, base, initial), y[: drive.free]


def _base_rates(chain: Chain, base: BaseInChain, initial: Mapping[str, float]) -> Array:
    """Compute the rates of the freedoms of the base at the start (3 or 6,)."""
    given = np.array([initial.get(name, 0.0) for name in BASE_VELOCITIES])
    b = np.concatenate([given[:3], given[3:] / chain.frame.length])
    beta = base.freedoms.T @ b
    if np.abs(base.freedoms @ beta - b).max() > RELATION_RESIDUAL * np.abs(b).max():
        raise UsageError(
            "the base of a planar linkage moves in its plane, with the normal "
            f"{vector_text(base.freedoms[:3, 0])}: give no other velocity, or a spatial base"
        )
    # From the velocity of the centre of mass to that at the origin.
    b[3:] -= np.cross(b[:3], base.com)
    return np.asarray(base.freedoms.T @ b)
