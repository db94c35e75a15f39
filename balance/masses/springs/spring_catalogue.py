"""Springs that can be had: stiffnesses and free lengths, as text and in steps."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import isfinite, prod
from typing import NamedTuple

import numpy as np

from balance.masses.springs.spring_text import (
    MAX_COORDINATE,
    MAX_STIFFNESS,
    SpringRange,
    SpringText,
)
from balance.support.units import read_quantity
from kinematics.errors import UsageError

# Most springs of a catalogue, and most choices of them for the springs that are asked for.
MAX_LISTED, MAX_CHOICES = 1000, 4096
FORM = "write K or K@L0, such as 400,600@0.05, or steps low:high:step of them"


class CatalogueSpring(NamedTuple):
    """A spring that can be had.

    Attributes:
        stiffness: N/m.
        free_length: metres; 0 for one that acts as without.
    """

    stiffness: float
    free_length: float = 0.0


Choice = tuple[CatalogueSpring | None, ...]


def read_catalogue(text: str) -> list[CatalogueSpring]:
    """Read springs ``K1,K2@L0``, where ``low:high:step`` is one spring for each step.

    Args:
        text: stiffnesses in N/m and free lengths in metres, or with units.

    Raises:
        UsageError: a number cannot be read, or there are more than 1000 springs.
    """
    listed: list[CatalogueSpring] = []
    for word in text.split(","):
        stiffness, at, length = word.partition("@")
        steps = [_steps(text, stiffness, "stiffness")]
        steps.append(_steps(text, length, "length") if at else [0.0])
        if len(listed) + prod(map(len, steps)) > MAX_LISTED:
            raise UsageError(f"catalogue '{text}': more than {MAX_LISTED} springs")
        listed += [CatalogueSpring(*pair) for pair in product(*steps)]
    return check_catalogue(listed)


def _steps(text: str, words: str, quantity: str) -> list[float]:
    """Read a number, or all of ``low:high:step``."""
    try:
        values = [read_quantity(part, quantity) for part in words.split(":")]
    except UsageError as error:
        raise UsageError(f"catalogue '{text}': {error}") from None
    if len(values) == 1:
        return values
    if len(values) != 3 or not all(map(isfinite, values)):
        raise UsageError(f"catalogue '{text}': '{words}' is no steps: {FORM}")
    low, high, step = values
    if not (low <= high and step > 0.0 and (high - low) / step < MAX_LISTED):
        raise UsageError(f"catalogue '{text}': '{words}' is no steps: {FORM}")
    # The last step counts where round-off alone puts it beyond the end.
    count = int(np.floor((high - low) / step + 1e-9)) + 1
    return [round(low + k * step, 12) for k in range(count)]


def check_catalogue(
    catalogue: Sequence[float | tuple[float, float]],
) -> list[CatalogueSpring]:
    """Sort the springs of a catalogue, each once.

    Args:
        catalogue: stiffnesses, N/m, or pairs of stiffness and free length, metres.

    Raises:
        UsageError: a stiffness is not above 0, or a number is too large.
    """
    listed = []
    for entry in catalogue:
        spring = CatalogueSpring(*(entry if isinstance(entry, tuple) else (entry,)))
        if not 0.0 < spring.stiffness <= MAX_STIFFNESS:
            raise UsageError(
                f"a catalogue has stiffnesses above 0 and up to {MAX_STIFFNESS:g} N/m"
            )
        if not abs(spring.free_length) <= MAX_COORDINATE:
            raise UsageError(f"a catalogue has free lengths up to {MAX_COORDINATE:g} m")
        listed.append(spring)
    return sorted(set(listed))


def with_lengths(
    springs: Sequence[SpringText], catalogue: Sequence[CatalogueSpring]
) -> list[SpringText]:
    """Give springs that name no free length those of a catalogue, or none at all."""
    lengths = [spring.free_length for spring in catalogue] or [0.0]
    every = min(lengths), max(lengths)
    return [
        spring._replace(length=every if spring.length is None else spring.length)
        for spring in springs
    ]


def list_choices(
    catalogue: Sequence[CatalogueSpring], springs: Sequence[SpringText]
) -> list[Choice]:
    """List the springs of a catalogue for each spring asked for, None for none, fewest first.

    Raises:
        UsageError: there are more than 4096 choices.
    """
    options: list[list[CatalogueSpring | None]] = [
        [None, *(entry for entry in catalogue if _within(entry, spring))] for spring in springs
    ]
    total = prod(map(len, options))
    if total > MAX_CHOICES:
        raise UsageError(
            f"{total} choices of springs: at most {MAX_CHOICES} are tried; name fewer springs, "
            "or fewer of the catalogue"
        )
    return sorted(product(*options), key=lambda choice: len(used_in(choice)))


def _within(entry: CatalogueSpring, spring: SpringText) -> bool:
    """Whether a spring of the catalogue may be one that is asked for."""
    (low, high), (short, long) = spring.stiffness, spring.length or (0.0, 0.0)
    return low <= entry.stiffness <= high and short <= entry.free_length <= long


def used_in(choice: Choice) -> tuple[int, ...]:
    """List the springs that a choice uses."""
    return tuple(k for k, entry in enumerate(choice) if entry is not None)


def stiffness_ranges(choice: Choice) -> list[SpringRange]:
    """Give the stiffnesses of a choice as ranges, (0, 0) for springs that it does not use."""
    return [(entry.stiffness,) * 2 if entry else (0.0, 0.0) for entry in choice]
