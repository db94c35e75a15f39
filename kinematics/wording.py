"""Format numbers, vectors and lists of names in few words, for the reprs of results."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from math import ceil, inf, isnan, log10
from operator import itemgetter
from textwrap import shorten, wrap
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinematics.numerics.tolerances import NUMBER_DETERMINED, SIZE_DETERMINED, WRITTEN_AS_ZERO

# Most names in a list.
MAX_NAMES = 6
# Most lines of a repr.
MAX_LINES = 6
# Most characters of a line.
WIDTH = 96
# Part of the floor of a size up to which it is written as a bound: not 1, for floors and scales
# are powers of ten.
NEAR_FLOOR = 0.95
# Least and greatest power of ten of numbers that are written without one.
PLAIN_POWERS = range(-2, 6)
# Sizes from which a unit has a prefix, the largest first.
PREFIXES = ((1e6, 1e6, "M"), (1e4, 1e3, "k"))
# Most rows of a table in a notebook.
HTML_ROWS = 12
# Characters of a cell there: those of all lines that a result is printed in.
CELL_WIDTH = (MAX_LINES - 1) * WIDTH


def check_summary(check: NamedTuple, **floors: float) -> str:
    """Summarise the result of a check in a line: ``Check: accepted, error below 1e-12``.

    Fields beside one another of the same text share it: ``error and gap below 1e-12``.

    Args:
        check: the result, its verdict first.
        floors: for fields by name, the floor of `size_text` if it is another one.
    """
    (name, verdict), *rest = check._asdict().items()
    word = name if verdict else f"not {name}"
    sizes = (
        (label, size_text(x, ".2g", floor=floors.get(label, SIZE_DETERMINED)))
        for label, x in rest
    )
    facts = []
    for text, group in groupby(sizes, key=itemgetter(1)):
        *labels, last = (label for label, _ in group)
        facts.append(f"{', '.join(labels)} and {last} {text}" if labels else f"{last} {text}")
    return ", ".join([f"{type(check).__name__}: {word}", *facts])


def size_text(
    size: float, form: str = ".1e", scale: float = 1.0, floor: float = SIZE_DETERMINED
) -> str:
    """Write a size, or a bound where round-off decides it: ``0.25``, ``below 1e-12``.

    Sizes from 0.01 up to a million have no power of ten.

    A bound is the power of ten from ``0.95 floor scale`` up: a scale that is itself a power of
    ten, up to its last bits, has one bound.

    Args:
        size: the size; one that is undefined is written as it is.
        form: format of a number that is determined.
        scale: what the size is to be compared with, in its own unit.
        floor: part of the scale up to which round-off decides the size. Sizes above
            ``scale / floor`` are quotients of it, and written as ``above 1e+12``.
    """
    if isnan(size) or size == -inf or not 0.0 < scale < inf:
        return _without_power(f"{size:{form}}")
    least, most = NEAR_FLOOR * floor * scale, scale / (NEAR_FLOOR * floor)
    if abs(size) <= least:
        return f"below {10.0 ** ceil(log10(least)):.0e}"
    if abs(size) >= most:
        return f"above {10.0 ** -ceil(-log10(most)):.0e}"
    return _without_power(f"{size:{form}}")


def _without_power(text: str) -> str:
    """Write a number without its power of ten, unless that is large: ``9.42e+03`` as 9420."""
    mantissa, _, power = text.partition("e")
    if not power or int(power) not in PLAIN_POWERS:
        return text
    digits = sum(map(str.isdigit, mantissa))
    return f"{float(text):.{max(digits - 1 - int(power), 0)}f}"


def unit_text(
    size: float,
    unit: str,
    form: str = ".4g",
    scale: float = 0.0,
    floor: float = SIZE_DETERMINED,
    beside: float = 0.0,
) -> str:
    """Write a size with its unit, in thousands if it is large: ``971 N``, ``97.7 kN``.

    Args:
        unit: of the size, which a prefix may stand before.
        scale: what the size is to be compared with, see `size_text`; 0 for nothing.
        floor: see `size_text`.
        beside: a size with which it is read, and whose prefix it has if that is larger.
    """
    factor, prefix = prefix_of(max(abs(size), abs(beside)))
    if prefix and abs(size) > floor * scale:
        return f"{number_text(size / factor, form)} {prefix}{unit}"
    text = size_text(size, form, scale, floor) if scale else number_text(size, form)
    return f"{text} {unit}"


def prefix_of(size: float) -> tuple[float, str]:
    """Choose the prefix of the unit of a size, and what it multiplies by: ``(1000.0, "k")``."""
    for least, factor, prefix in PREFIXES:
        if least <= abs(size) < inf:
            return factor, prefix
    return 1.0, ""


def round_to_ten_digits(value: float) -> float:
    """Round a computed number to ten significant digits, the last of which still hold.

    Rounded once more to those of a format, halves such as 0.12345 are written alike whether
    computed from above or from below.
    """
    return float(f"{value:.{NUMBER_DETERMINED}g}") + 0.0


def number_text(
    value: float, form: str = ".4g", scale: float = 0.0, floor: float = SIZE_DETERMINED
) -> str:
    """Write a computed number so that its last bits do not decide a digit: ``0.125``, ``0``.

    See `round_to_ten_digits`.

    Args:
        scale: a size in the unit of the number.
        floor: part of the scale up to which a number is round-off, and written as 0.
    """
    determined = 0.0 if abs(value) <= floor * scale else round_to_ten_digits(value)
    return _without_power(f"{determined:{form}}")


def outward_text(least: float, most: float) -> str:
    """Write a range whose ends are rounded outwards to four digits: ``5.213 to 5.302``."""
    from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal

    ends = (
        Context(4, mode).create_decimal(Decimal(repr(round_to_ten_digits(value))))
        for value, mode in ((least, ROUND_FLOOR), (most, ROUND_CEILING))
    )
    return " to ".join(f"{float(end):.4g}" for end in ends)


def count_noun(number: int, noun: str) -> str:
    """Write a number of things: ``1 loop``, ``2 loops``, ``3 bodies``.

    Args:
        noun: in the singular.
    """
    plural = f"{noun[:-1]}ies" if noun.endswith("y") else f"{noun}s"
    return f"{number} {noun if number == 1 else plural}"


def first_names(names: Sequence[str]) -> str:
    """List the first six names, and ``…`` for the others."""
    return ", ".join(names[:MAX_NAMES]) + (" …" if len(names) > MAX_NAMES else "")


def without_round_off(values: NDArray[np.float64], size: float) -> NDArray[np.float64]:
    """Return an array with zeros in place of numbers below `WRITTEN_AS_ZERO` of a size."""
    return np.where(np.abs(values) > WRITTEN_AS_ZERO * size, values, 0.0)


def vector_text(x: ArrayLike) -> str:
    """Write the components of a vector to four digits: ``(0.5, 0, -1)``."""
    values = np.asarray(x, dtype=np.float64)
    kept = without_round_off(values, float(np.abs(values).max(initial=0.0)))
    return f"({', '.join(map(number_text, kept.tolist()))})"


def repr_lines(head: str, *lines: str) -> str:
    """Join at most six lines: a head, others indented below it, and how many are left out.

    Long lines are cut, except for the first below the head, which has the verdict: it goes on
    in further lines if there is room.
    """
    most = MAX_LINES - 1
    whole = (*wrap(lines[0], WIDTH), *lines[1:]) if lines else ()
    if len(whole) <= most:
        lines = whole
    if len(lines) > most:
        lines = (*lines[: most - 1], f"and {len(lines) - most + 1} more")
    cut = (shorten(line, WIDTH, placeholder=" …") for line in (head, *lines))
    return "\n  ".join(cut)


def html_facts(title: str, *facts: tuple[str, str]) -> str:
    """Build a small HTML table of facts for notebooks, with every text escaped.

    Args:
        title: caption of the table, any text.
        facts: label and value of each row, any text; rows beyond the twelfth are counted.

    Returns:
        One ``<table>`` element without style or script.
    """
    from html import escape

    rows = [(label, shorten(value, CELL_WIDTH, placeholder=" …")) for label, value in facts]
    if len(rows) > HTML_ROWS:
        rows[HTML_ROWS - 1 :] = [("", f"and {len(rows) - HTML_ROWS + 1} more")]
    cells = "".join(
        f"<tr><th>{escape(label)}</th><td>{escape(value)}</td></tr>" for label, value in rows
    )
    caption = escape(shorten(title, WIDTH, placeholder=" …"))
    return f"<table><caption>{caption}</caption><tbody>{cells}</tbody></table>"
