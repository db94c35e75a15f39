"""Argparse types of ``balance flex``: beams, arms, supports and inputs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.cli.number_arguments import finite_number, positive_number

if TYPE_CHECKING:
    from balance.flexible.beam import Beam
    from balance.flexible.drives import Profile
    from balance.flexible.similarity import Arm

__all__ = [
    "arm_of", "beam_of", "drive_of", "drive_profile",
    "spin_numbers", "support_position",
]  # fmt: skip

ARM_NUMBERS = {
    "length": "length", "EI": "bending", "rhoA": "line_mass", "EA": "axial", "GA": "shear",
    "rhoI": "rotary", "tip": "tip_mass", "radius": "tip_radius", "inertia": "tip_inertia",
    "hub": "hub_radius",
}  # fmt: skip


def support_position(text: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Parse ``S`` or ``S*W+S*W…`` as positions and weights."""
    pairs = [item.partition("*") for item in text.split("+")]
    points = tuple(finite_number(s) for s, _, _ in pairs)
    weights = tuple(finite_number(w) if star else 1.0 / len(pairs) for _, star, w in pairs)
    return points, weights


def _items(text: str, known: tuple[str, ...]) -> dict[str, float]:
    """Parse ``key:value,key:value`` in SI units."""
    found: dict[str, float] = {}
    for item in text.split(","):
        key, colon, value = item.partition(":")
        if not colon or key not in known or key in found:
            raise argparse.ArgumentTypeError(
                f"'{item}' is not one of {', '.join(f'{name}:…' for name in known)}"
            )
        found[key] = finite_number(value)
    missing = [name for name in known[:3] if name not in found]
    if missing:
        raise argparse.ArgumentTypeError(f"{missing[0]}: is missing in '{text}'")
    return found


def beam_of(text: str) -> Beam:
    """Parse a beam; what is wrong with its numbers is an error of the request."""
    from balance.flexible.beam import Beam

    given = _items(text, ("length", "EI", "rhoA", "EA", "GA", "rhoI"))
    try:
        return Beam(**{ARM_NUMBERS[key]: value for key, value in given.items()})
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def arm_of(text: str) -> Arm:
    """Parse an arm."""
    from balance.flexible.similarity import Arm

    given = _items(text, tuple(ARM_NUMBERS))
    own = ("tip", "radius", "inertia", "hub")
    beam = ",".join(f"{key}:{value!r}" for key, value in given.items() if key not in own)
    body = {ARM_NUMBERS[key]: given[key] for key in own if key in given}
    try:
        return Arm(beam_of(beam), **{"tip_mass": 0.0, **body})
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def spin_numbers(text: str) -> tuple[float, ...]:
    """Parse ``SPEED,RISE`` or ``SPEED,RISE,DURATION``."""
    values = tuple(positive_number(word) for word in text.split(","))
    if len(values) not in (2, 3):
        raise argparse.ArgumentTypeError(f"'{text}' is not SPEED,RISE or SPEED,RISE,DURATION")
    return values


def drive_of(text: str) -> tuple[str, tuple[Profile, bool]]:
    """Parse an input ``JOINT=spin:SPEED,RISE``."""
    name, equal, rest = text.partition("=")
    kind, colon, values = rest.partition(":")
    if not equal or not name or not colon or kind not in ("spin", "speed", "moment"):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not JOINT=spin:SPEED,RISE, JOINT=speed:SPEED or "
            "JOINT=moment:VALUE,RISE"
        )
    numbers = tuple(finite_number(word) for word in values.split(","))
    if len(numbers) != (1 if kind == "speed" else 2) or (kind != "speed" and numbers[1] <= 0.0):
        form = "SPEED" if kind == "speed" else "VALUE,RISE with a positive rise time"
        raise argparse.ArgumentTypeError(f"'{text}': write {kind}:{form}")
    return name, drive_profile(kind, numbers)


def drive_profile(kind: str, numbers: tuple[float, ...]) -> tuple[Profile, bool]:
    """Build the profile of an input.

    Args:
        kind: ``"spin"``, ``"speed"`` or ``"moment"``.
        numbers: speed or moment, and rise time, in SI units.

    Returns:
        The profile, and whether it is a moment.
    """
    from balance.flexible.drives import constant_speed, moment_rise, spin_up

    if kind == "speed":
        return constant_speed(numbers[0]), False
    return (moment_rise if kind == "moment" else spin_up)(*numbers), kind == "moment"
