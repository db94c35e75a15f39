"""Numbers and points on the command line, as types of argparse."""

from __future__ import annotations

import argparse
import math
import re
from collections.abc import Callable, Sequence

from balance.support.units import read_quantity
from kinematics.errors import UsageError

# Largest coordinate of a point, metres, and of an acceleration, m/s².
MAX_POINT = 1e6
# Most processes of a command.
MAX_WORKERS = 1024


def add_about(group: argparse._ArgumentGroup, default: str) -> None:
    """Add the option ``--about``, the point of the moments.

    Args:
        default: the point without the option, in words.
    """
    group.add_argument(
        "--about",
        type=point,
        metavar="X,Y,Z",
        help=f"point of moments, m (default: {default})",
    )


def add_tool(group: argparse._ArgumentGroup, purpose: str) -> None:
    """Add the options ``--tool`` and ``--point`` of a link and its point.

    Args:
        purpose: what the link is for, for the help.
    """
    group.add_argument("--tool", metavar="LINK", help=purpose)
    group.add_argument(
        "--point",
        type=point,
        metavar="X,Y,Z",
        help="its point in its frame, m (default: the origin)",
    )


def add_workers(group: argparse._ActionsContainer, keeps_results: bool) -> None:
    """Add the option ``--workers``, processes on this machine; 0 stands for this one alone.

    A command that keeps its results in a file, for it may take hours, has one per core by
    default, as None; another one works in this process, for others take seconds to start.

    Args:
        keeps_results: whether the command keeps them, and goes on with them by ``--resume``.
    """
    default = "one per core" if keeps_results else "0"
    group.add_argument(
        "--workers",
        type=whole_number(0, MAX_WORKERS),
        default=None if keeps_results else 0,
        metavar="N",
        help=f"processes on this machine; 0: this process alone (default: {default})",
    )


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


def finite_quantity(*quantities: str) -> Callable[[str], float]:
    """Build an argparse type of finite numbers with or without a unit.

    Args:
        quantities: see `balance.support.units.read_quantity`.

    Returns:
        A function that parses a word, and raises ArgumentTypeError for any other word.
    """
    return lambda text: _number(text, "a number", math.isfinite, quantities)


def positive_quantity(*quantities: str) -> Callable[[str], float]:
    """Build an argparse type of positive numbers with or without a unit.

    Args:
        quantities: see `balance.support.units.read_quantity`.

    Returns:
        A function that parses a word, and raises ArgumentTypeError for any other word.
    """
    what = "a positive number"
    return lambda text: _number(text, what, lambda value: 0.0 < value < math.inf, quantities)


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


def number_between(lowest: float, highest: float, *quantities: str) -> Callable[[str], float]:
    """Build an argparse type of numbers from ``lowest`` to ``highest``.

    Args:
        quantities: those whose units may follow the number.

    Returns:
        A function that parses a word, and raises ArgumentTypeError for any other word.
    """
    what = f"a number from {lowest:g} to {highest:g}"
    return lambda text: _number(
        text, what, lambda value: lowest <= value <= highest, quantities
    )


def _number(
    text: str, what: str, allowed: Callable[[float], bool], quantities: Sequence[str] = ()
) -> float:
    """Parse a number that is allowed, and not NaN."""
    reason = ""
    try:
        value = read_quantity(text, *quantities) if quantities else float(text)
    except UsageError as error:
        value, reason = math.nan, f"; {error}" if re.match("[-+.]*[0-9]", text) else ""
    except ValueError:
        value = math.nan
        if re.match("[-+.]*[0-9]", text):
            reason = "; write the number alone, in SI units"
    if not allowed(value):
        raise argparse.ArgumentTypeError(f"'{text}' is not {what}{reason}")
    return value


def values_by_name(text: str, form: str, *quantities: str) -> dict[str, float]:
    """Parse values by name of ``u1=0.3,u2=-10deg``.

    Args:
        form: an example, for the message.
        quantities: those whose units may follow a number.

    Raises:
        ArgumentTypeError: the text is nothing like it, or names one twice.
    """
    words = [word.rpartition("=") for word in text.split(",")]
    names = [name.strip() for name, *_ in words]
    reason = ""
    try:
        values = [read_quantity(value, *quantities) for *_, value in words]
    except UsageError as error:
        values, reason = [math.nan], f": {error}"
    if not all(names) or len(set(names)) < len(names) or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"'{text}' is not {form} with each name once{reason}")
    return dict(zip(names, values, strict=True))


def point(text: str) -> tuple[float, ...]:
    """Parse a point of ``0.1,0,-0.05``, metres.

    Raises:
        ArgumentTypeError: there are not three numbers, or one is too large.
    """
    return _vector(text, "length", "a point such as 0.1,0,-0.05: three numbers, metres")


def gravity(text: str) -> tuple[float, ...]:
    """Parse an acceleration of ``0,0,-9.81``, m/s².

    Raises:
        ArgumentTypeError: there are not three numbers, or one is too large.
    """
    return _vector(text, "acceleration", "a vector such as 0,0,-9.81: three numbers, m/s²")


def _vector(text: str, quantity: str, form: str) -> tuple[float, ...]:
    """Parse three numbers with or without a unit, of the form in words."""
    try:
        values = tuple(read_quantity(word, quantity) for word in text.split(","))
    except UsageError:
        values = ()
    if len(values) != 3 or not all(abs(value) <= MAX_POINT for value in values):
        raise argparse.ArgumentTypeError(f"'{text}' is not {form}")
    return values
