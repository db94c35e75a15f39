"""Wheels on the base with motors of their own: speed, torque and power along motions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.judge import MOTIONS
from balance.masses.remedies.momentum_along import Momentum, momentum_along
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.wheels.varying_ratio import table_bytes
from balance.masses.remedies.wheels.wheels_on_base import (
    ForceBalanced,
    NoWheel,
    Wheel,
    balance_force,
    fine_motion,
    has_momentum,
    make_wheel,
    motion_columns,
    verify_with_wheels,
)
from balance.motion.verification.trajectory import Trajectory, random_motions
from kinematics.model.motion import motion_of
from kinematics.wording import number_text

Array = NDArray[np.float64]

SEED = 3


def build_motor_wheels(request: RemedyRequest) -> AppliedRemedy:
    """Build a wheel with a motor for each axis along which a moment is left.

    The force is balanced by counterweights. The axes are the normal of a planar linkage, and
    where its centres of mass are in different planes two across it; or those of the root. The
    speed is ``-h / J``, the torque ``-ḣ``, the power ``h ḣ / J`` along random motions of one
    second. J is the mean of ``|h|`` over the mean speed of the fastest input (radians and
    characteristic lengths per second) and over the gear of the request; the torque does not
    depend on it. Each wheel is a thin ring of the rotor radius ρ, of mass ``J / ρ²``.

    Returns:
        The result; a file has time, inputs, and the wheels' motion at the greatest power, and
        one a motion with the wheels for ``balance verify --csv``.

    Raises:
        NoWheel: the force cannot be balanced, or no moment is left.
        LinkageError: the linkage cannot be moved.
    """
    balanced = balance_force(request)
    limits = motion_of(balanced.linkage, request.motion or None)
    runs = [*random_motions(balanced.linkage, MOTIONS, seed=SEED, motion=limits)]
    wheels = _wheels(request, balanced, runs)
    mass = sum(wheel.mass for wheel in wheels)
    count = "a wheel" if len(wheels) == 1 else f"{len(wheels)} wheels about perpendicular axes"
    blank = AppliedRemedy(
        "active_wheel",
        f"{count} of {number_text(mass)} kg on the base, with motors",
        "undecided",
        "",
    )
    fine = fine_motion(balanced.linkage, limits)
    done, (*moved, shown) = verify_with_wheels(request, blank, balanced, wheels, [*runs, fine])
    first = balanced.linkage.mobility
    peaks = [
        [
            w.peaks(trajectory.ud[:, first + k], trajectory.udd[:, first + k])
            for k, w in enumerate(wheels)
        ]
        for trajectory in moved
    ]
    worst = max(range(len(moved)), key=lambda k: max(peak["power"] for peak in peaks[k]))
    table = _table(balanced.linkage.inputs, moved[worst], wheels)
    names = *balanced.linkage.inputs, *(wheel.joint for wheel in wheels)
    motion = motion_columns(names, shown)
    return replace(
        done, files={"drive.csv": table_bytes(table), "motion.csv": table_bytes(motion)},
        details={
            "wheels": [wheel.details() for wheel in wheels],
            "motions": [
                {"name": f"random motion {k + 1} of 1 s", "peaks": part}
                for k, part in enumerate(peaks)
            ],
            "worst": worst + 1,
            "peaks": [
                {key: max(part[k][key] for part in peaks) for key in peaks[0][k]}
                for k in range(len(wheels))
            ],
        },
    )  # fmt: skip


def _wheels(
    request: RemedyRequest, balanced: ForceBalanced, runs: Sequence[Trajectory]
) -> list[Wheel]:
    """Make the wheels; several are at two radii from the origin, along their axes."""
    linkage = balanced.linkage
    momenta = [momentum_along(linkage, trajectory) for trajectory in runs]
    candidates = linkage.chain.frame.R[::-1] if linkage.planar else np.eye(3)
    axes = [axis for axis in candidates if has_momentum(linkage, momenta, axis[None])]
    if not axes:
        raise NoWheel("refused", "no moment is left once counterweights balance the force")
    radius, pace = request.rotor_radius, _pace(request, balanced, runs)
    several = len(axes) > 1
    return [
        make_wheel(
            balanced.document, axis, 2.0 * radius * axis * several,
            _mean_size(momenta, axis) / (pace * request.gear), radius,
            f"_{k}" if several else "",
        )
        for k, axis in enumerate(axes, 1)
    ]  # fmt: skip


def _mean_size(momenta: Sequence[Momentum], axis: Array) -> float:
    """Compute the mean of ``|h|`` about an axis."""
    return float(np.mean([np.abs(momentum.total[:, :3] @ axis).mean() for momentum in momenta]))


def _pace(request: RemedyRequest, balanced: ForceBalanced, runs: Sequence[Trajectory]) -> float:
    """Compute the mean speed of the fastest input, rad/s and characteristic lengths/s."""
    kinds = {joint.name: joint.kind for joint in balanced.linkage.joints}
    slides = [kinds[name] == "prismatic" for name in balanced.linkage.inputs]
    units = np.where(slides, request.space.length, 1.0)
    return float(
        np.mean([np.abs(trajectory.ud / units).max(axis=1).mean() for trajectory in runs])
    )


def _table(
    inputs: Sequence[str], motion: Trajectory, wheels: Sequence[Wheel]
) -> dict[str, Array]:
    """List time, inputs, and angle, speed, torque and power of each wheel."""
    columns = {"time": motion.time}
    columns |= {name: motion.u[:, k] for k, name in enumerate(inputs)}
    for k, wheel in enumerate(wheels, len(inputs)):
        speed, torque = motion.ud[:, k], wheel.inertia * motion.udd[:, k]
        columns |= {
            f"{wheel.name} angle": motion.u[:, k], f"{wheel.name} speed": speed,
            f"{wheel.name} torque": torque, f"{wheel.name} power": torque * speed,
        }  # fmt: skip
    return columns
