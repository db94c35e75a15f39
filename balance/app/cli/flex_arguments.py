"""Argparse types of ``balance flex``: beams, arms, supports and inputs."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.app.cli.number_arguments import finite_number, positive_number
from kinematics.errors import UsageError

if TYPE_CHECKING:
    from balance.motion.flexible.beam import Beam
    from balance.motion.flexible.drives import DriveProfile
    from balance.motion.flexible.similarity import Arm
    from balance.motion.flexible.supported_beam_modes import EndBody


ARM_NUMBERS = {
    "length": "length",
    "EI": "bending",
    "rhoA": "line_mass",
    "EA": "axial",
    "GA": "shear",
    "rhoI": "rotary",
    "tip": "tip_mass",
    "radius": "tip_radius",
    "inertia": "tip_inertia",
    "hub": "hub_radius",
}


def support_position(text: str) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Parse ``S`` or ``S*W+S*W…`` as positions and weights."""
    pairs = [item.partition("*") for item in text.split("+")]
    points = tuple(finite_number(s) for s, _, _ in pairs)
    weights = tuple(finite_number(w) if star else 1.0 / len(pairs) for _, star, w in pairs)
    return points, weights


def tip_of(text: str) -> EndBody:
    """Parse ``MASS``, ``MASS,INERTIA`` or ``MASS,INERTIA,OFFSET``; numbers from 0 up."""
    from balance.motion.flexible.supported_beam_modes import EndBody

    values = [finite_number(word) for word in text.split(",")]
    if not 1 <= len(values) <= 3 or min(values) < 0.0 or values[0] == 0.0:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not MASS, MASS,INERTIA or MASS,INERTIA,OFFSET, such as 0.5,1e-4"
        )
    mass, inertia, offset = [*values, 0.0, 0.0][:3]
    return EndBody(mass, offset, inertia)


def _items(text: str, keys: tuple[str, ...], needed: int = 3) -> dict[str, float]:
    """Parse ``key:value,key:value`` in SI units, of which the first keys are needed."""
    numbers: dict[str, float] = {}
    for item in text.split(","):
        key, colon, value = item.partition(":")
        if not colon or key not in keys or key in numbers:
            raise argparse.ArgumentTypeError(
                f"'{item}' is not one of {', '.join(f'{name}:…' for name in keys)}"
            )
        numbers[key] = finite_number(value)
    missing = [name for name in keys[:needed] if name not in numbers]
    if missing:
        raise argparse.ArgumentTypeError(f"{missing[0]}: is missing in '{text}'")
    return numbers


def beam_of(text: str) -> Beam:
    """Parse a beam; what is wrong with its numbers is an error of the request."""
    from balance.motion.flexible.beam import Beam

    given = _items(text, ("length", "EI", "rhoA", "EA", "GA", "rhoI"))
    try:
        return Beam(**{ARM_NUMBERS[key]: value for key, value in given.items()})
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def arm_of(text: str) -> Arm:
    """Parse an arm."""
    from balance.motion.flexible.similarity import Arm

    given = _items(text, tuple(ARM_NUMBERS))
    body_keys = ("tip", "radius", "inertia", "hub")
    beam = ",".join(f"{key}:{value!r}" for key, value in given.items() if key not in body_keys)
    body = {ARM_NUMBERS[key]: given[key] for key in body_keys if key in given}
    try:
        return Arm(beam_of(beam), **{"tip_mass": 0.0, **body})
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def spin_numbers(text: str) -> tuple[float, ...]:
    """Parse ``SPEED,RISE`` or ``SPEED,RISE,DURATION``."""
    return _rise_numbers(text, "SPEED")


def moment_numbers(text: str) -> tuple[float, ...]:
    """Parse ``VALUE,RISE`` or ``VALUE,RISE,DURATION``."""
    return _rise_numbers(text, "VALUE")


def _rise_numbers(text: str, word: str) -> tuple[float, ...]:
    """Parse two or three positive numbers."""
    values = tuple(positive_number(number) for number in text.split(","))
    if len(values) not in (2, 3):
        form = f"{word},RISE or {word},RISE,DURATION"
        raise argparse.ArgumentTypeError(f"'{text}' is not {form}")
    return values


def translator_numbers(text: str) -> dict[str, float]:
    """Parse ``pitch:…,mass:…,length:…,breadth:…`` and ``hubmass:…``."""
    keys = ("pitch", "mass", "length", "breadth", "hubmass")
    numbers = _items(text, keys, needed=4)
    wrong = [name for name, value in numbers.items() if value <= 0.0]
    if wrong:
        raise argparse.ArgumentTypeError(f"{wrong[0]}: {numbers[wrong[0]]:g} is not positive")
    return numbers


def drive_of(text: str) -> tuple[str, DriveProfile]:
    """Parse an input ``JOINT=spin:SPEED,RISE``."""
    from balance.motion.flexible.drives import FORM, parse_drive

    name, equal, words = text.partition("=")
    if not equal or not name:
        raise argparse.ArgumentTypeError(f"'{text}' is not JOINT= and {FORM}")
    try:
        return name, parse_drive(words)
    except UsageError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
