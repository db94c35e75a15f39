"""Inputs over time: a spin-up of a joint, a rise of a moment."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from kinematics.error_text import clean
from kinematics.errors import LinkageError, UsageError

# Value, rate and acceleration at a time in seconds.
Profile: TypeAlias = Callable[[float], tuple[float, float, float]]
# A profile, and whether it is a moment.
DriveProfile: TypeAlias = tuple[Profile, bool]

FORM = "spin:SPEED,RISE, speed:SPEED or moment:VALUE,RISE"


def spin_up(speed: float, rise: float) -> Profile:
    """Build the motion from rest to a constant speed, with continuous acceleration.

    u = Ω T [t²/(2T²) + (cos(2πt/T) - 1)/(4π²)] for t ≤ T, then Ω (t - T/2).

    Args:
        speed: final speed Ω, in rad/s or m/s.
        rise: duration T of the acceleration, in seconds.

    Raises:
        LinkageError: the duration is not positive.
    """
    _check_rise(rise)

    def profile(t: float) -> tuple[float, float, float]:
        if t >= rise:
            return speed * (t - 0.5 * rise), speed, 0.0
        x = max(t, 0.0) / rise
        turn = 2.0 * np.pi * x
        value = speed * rise * (0.5 * x**2 + (np.cos(turn) - 1.0) / (4.0 * np.pi**2))
        return (
            value,
            speed * (x - np.sin(turn) / (2.0 * np.pi)),
            (speed / rise * (1.0 - np.cos(turn))),
        )

    return profile


def moment_rise(moment: float, rise: float) -> Profile:
    """Build the rise of a moment M0 [t/T - sin(2πt/T)/(2π)] for t ≤ T, then M0.

    Args:
        moment: final moment M0, in N m (force in N on a slider).
        rise: duration T of the rise, in seconds.

    Raises:
        LinkageError: the duration is not positive.
    """
    _check_rise(rise)
    motion = spin_up(moment, rise)

    def profile(t: float) -> tuple[float, float, float]:
        _, value, rate = motion(t)
        return value, rate, 0.0

    return profile


def constant_speed(speed: float) -> Profile:
    """Build the motion u = speed × t.

    Args:
        speed: in rad/s or m/s.
    """
    return lambda t: (speed * t, speed, 0.0)


def parse_drive(text: str) -> DriveProfile:
    """Parse ``spin:SPEED,RISE``, ``speed:SPEED`` or ``moment:VALUE,RISE``, in SI units.

    Raises:
        UsageError: the text has another form, or a number is out of range.

    Example:
        >>> from balance.motion.flexible.drives import parse_drive
        >>> profile, is_moment = parse_drive("speed:3")
        >>> profile(2.0), is_moment
        ((6.0, 3.0, 0.0), False)
    """
    kind, _, words = text.partition(":")
    try:
        numbers = [float(word) for word in words.split(",")]
    except ValueError:
        numbers = []
    if (
        kind not in ("spin", "speed", "moment")
        or not np.all(np.isfinite(numbers))
        or (len(numbers) != (1 if kind == "speed" else 2))
    ):
        raise UsageError(f"'{clean(text, 200)}' is not {FORM}")
    if kind == "speed":
        return constant_speed(numbers[0]), False
    if numbers[1] <= 0.0:
        raise UsageError(f"'{clean(text, 200)}': the rise time is not positive")
    return (moment_rise if kind == "moment" else spin_up)(*numbers), kind == "moment"


def _check_rise(rise: float) -> None:
    """Refuse a duration that is not positive.

    Raises:
        LinkageError: it is not.
    """
    if not 0.0 < rise < np.inf:
        raise LinkageError(f"rise time {rise:g} s is not positive")
