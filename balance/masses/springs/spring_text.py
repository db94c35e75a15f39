"""Text of a spring, such as ``base@0,0,0:0.5 arm@0.2,0,0 k=150``, and what it means.

``L0=0.05`` is the free length at which the force between both points vanishes. A spring with a
string behind a pulley has its own free length, and that of the string, less the way from its
anchor to the pulley: 0 if they are the same, and below 0 if the spring pulls where its ends
meet, as one that is wound with initial tension does.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from balance.support.units import read_quantity
from kinematics.errors import UsageError

FORM = "write 'base,arm' or 'base@0,0,0:0.5 arm@0.2,0,0 k=100:200 L0=0.05'"
# Largest coordinate of a point, metres, and largest stiffness, N/m.
MAX_COORDINATE, MAX_STIFFNESS = 1e6, 1e12
SpringRange = tuple[float, float]


class SpringEnd(NamedTuple):
    """One end of a spring as it is asked for.

    Attributes:
        link: name of the link.
        box: least and greatest coordinate along each axis of the link frame, metres; None
            where the text names the link alone.
    """

    link: str
    box: tuple[SpringRange, ...] | None

    @property
    def free(self) -> bool:
        """Whether the text leaves the point open."""
        return self.box is not None and any(low < high for low, high in self.box)


class SpringText(NamedTuple):
    """A spring as it is asked for.

    Attributes:
        text: the text.
        ends: its two ends.
        stiffness: least and greatest stiffness, N/m.
        length: least and greatest free length, metres; None where the text says nothing.
    """

    text: str
    ends: tuple[SpringEnd, SpringEnd]
    stiffness: SpringRange
    length: SpringRange | None = None


def read_spring(text: str) -> SpringText:
    """Read a spring: two links, each with a point or without, stiffness and free length.

    Args:
        text: ``LINK[@X,Y,Z] LINK[@X,Y,Z] [k=K] [L0=L]``, where each number may be a range
            ``low:high`` and have a unit; or ``LINK,LINK``.

    Raises:
        UsageError: the text has another form; a stiffness is negative, or a range is empty.
    """
    words = text.split()
    if len(words) == 1 and "@" not in text and text.count(",") == 1:
        words = text.split(",")
    given: dict[str, str] = {}
    for _ in range(2):
        name, equals, value = words[-1].partition("=") if words else ("", "", "")
        if equals and name in ("k", "L0") and name not in given:
            given[name] = value
            words.pop()
    stiffness = _read_stiffness(text, given["k"]) if "k" in given else (0.0, math.inf)
    length = _read_length(text, given["L0"]) if "L0" in given else None
    if len(words) != 2 or not all(words):
        raise UsageError(f"spring '{text}' has no known form: {FORM}")
    first, second = (_read_end(text, word) for word in words)
    return SpringText(" ".join(text.split()), (first, second), stiffness, length)


def _read_stiffness(text: str, words: str) -> SpringRange:
    """Read a stiffness or a range of them."""
    low, high = _read_range(text, words, "stiffness")
    if low < 0.0:
        raise UsageError(f"spring '{text}': a stiffness is not negative: give k=0 or more")
    if not 0.0 < high <= MAX_STIFFNESS:
        raise UsageError(
            f"spring '{text}': give a stiffness above 0 and up to {MAX_STIFFNESS:g} N/m"
        )
    return low, high


def _read_length(text: str, words: str) -> SpringRange:
    """Read a free length or a range of them."""
    low, high = _read_range(text, words, "length")
    if max(-low, high) > MAX_COORDINATE:
        raise UsageError(f"spring '{text}': a free length is beyond {MAX_COORDINATE:g} m")
    return low, high


def _read_end(text: str, word: str) -> SpringEnd:
    """Read ``LINK`` or ``LINK@X,Y,Z``."""
    link, at, point = word.partition("@")
    if not at:
        return SpringEnd(link, None)
    numbers = point.split(",")
    if not link or len(numbers) != 3:
        raise UsageError(f"spring '{text}': '{word}' is no point of a link: {FORM}")
    box = tuple(_read_range(text, number, "length") for number in numbers)
    if any(max(abs(low), abs(high)) > MAX_COORDINATE for low, high in box):
        raise UsageError(f"spring '{text}': a coordinate is beyond {MAX_COORDINATE:g} m")
    return SpringEnd(link, box)


def _read_range(text: str, words: str, quantity: str) -> SpringRange:
    """Read ``0.3`` or ``0.1:0.3``, with units or without."""
    parts = re.split(":", words)
    try:
        values = [read_quantity(part, quantity) for part in parts]
    except UsageError as error:
        raise UsageError(f"spring '{text}': {error}") from None
    if len(values) > 2 or not all(map(math.isfinite, values)) or values[0] > values[-1]:
        raise UsageError(f"spring '{text}': '{words}' is not a number or a range low:high")
    return values[0], values[-1]
