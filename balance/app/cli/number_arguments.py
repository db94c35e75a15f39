"""Numbers and points on the command line, as types of argparse."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable

# Largest coordinate of a point, metres.
MAX_POINT = 1e6


def add_about(group: argparse._ArgumentGroup, default: str) -> None:
    """Add the option ``--about``, the point of the moments.

    Args:
        default: the point without the option, in words.
    """
    group.add_argument(
        "--about", type=point, metavar="X,Y,Z",
        help=f"point of moments, m (default: {default})",
    )  # fmt: skip


def whole_number(lowest: int, highest: int, what: str = "a number") -> Callable[[str], int]:
    """Build an argparse type of whole numbers from ``lowest`` to ``highest``.

    Args:
        what: name of the number in the error message.

    Returns:
        A function that parses a word, and raises ArgumentTypeError for any other word.
    """

    def read(text: str) -> int:
        digits = text.isascii() and text.isdigit() and len(text) <= 18
        number = int(text) if digits else lowest - 1
        if not lowest <= number <= highest:
            raise argparse.ArgumentTypeError(
                f"'{text}' is not {what} from {lowest} to {highest}"
            )
        return number

    return read


def finite_number(text: str) -> float:
    """Parse a finite number.

    Raises:
        ArgumentTypeError: the word is none.
    """
    return _number(text, "a number", math.isfinite)


def positive_number(text: str) -> float:
    """Parse a positive number.

    Raises:
        ArgumentTypeError: the word is none.
    """
    return _number(text, "a positive number", lambda value: 0.0 < value < math.inf)


def number_between(lowest: float, highest: float) -> Callable[[str], float]:
    """Build an argparse type of numbers from ``lowest`` to ``highest``.

    Returns:
        A function that parses a word, and raises ArgumentTypeError for any other word.
    """
    what = f"a number from {lowest:g} to {highest:g}"
    return lambda text: _number(text, what, lambda value: lowest <= value <= highest)


def _number(text: str, what: str, allowed: Callable[[float], bool]) -> float:
    """Parse a number that is allowed, and not NaN."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not allowed(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not {what}")
    return value


def point(text: str) -> tuple[float, ...]:
    """Parse a point of ``0.1,0,-0.05``, metres.

    Raises:
        ArgumentTypeError: there are not three numbers, or one is too large.
    """
    try:
        values = tuple(float(word) for word in text.split(","))
    except ValueError:
        values = ()
    if len(values) != 3 or not all(abs(value) <= MAX_POINT for value in values):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not a point such as 0.1,0,-0.05: three numbers, metres"
        )
    return values
