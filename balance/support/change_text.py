"""What a change of masses does to a load, in words: ``21.9 → 1.73 N (−92 %)``."""

from __future__ import annotations

from kinematics.wording import number_text, prefix_of

# Ratio of a load to that before, from which it is written as a number of times.
MANY_TIMES = 10.0
LOAD_FORM = ".3g"
"""Format of a load, in sentences and in the lines below them."""
MASS_FORM = ".4g"
"""Format of an added mass, likewise."""
# Percent up to which a load is unchanged.
UNCHANGED = 0.5
# Percent of a load that are taken at most, as written, where some of it is left.
NOT_ALL = 99.99
# Masses below are written in grams, kilograms.
LEAST_KILOGRAMS = 0.1


def change_text(
    before: float,
    after: float,
    unit: str,
    least: float = 0.0,
    *,
    worded: bool = False,
    more: str = "",
) -> str:
    """Write a load before and after a change, and by how many percent it differs.

    Args:
        before: its size.
        after: its size then.
        unit: of both; a prefix may stand before it.
        least: sizes up to this are round-off, and written as 0.
        worded: whether to write ``92 % less`` instead of ``−92 %``.
        more: what follows the percent in their parentheses.
    """
    first, then = (0.0 if size <= least else size for size in (before, after))
    if first == then == 0.0:
        return f"0 {unit}"
    factor, prefix = prefix_of(max(first, then))
    start, end = (number_text(size / factor, LOAD_FORM) for size in (first, then))
    sizes = f"{start} → {end} {prefix}{unit}"
    return f"{sizes} ({percent_text(then / first, worded)}{more})" if first else sizes


def grows(before: float, after: float, least: float = 0.0) -> bool:
    """Whether a load is larger after a change, by more than half a percent and round-off.

    Args:
        before: its size.
        after: its size then.
        least: sizes up to this are round-off.
    """
    return after > least and after > before * (1.0 + UNCHANGED / 100.0)


def percent_text(ratio: float, worded: bool = False) -> str:
    """Write by how many percent a ratio differs from 1."""
    percent = 100.0 * (ratio - 1.0)
    if abs(percent) <= UNCHANGED:
        return "unchanged"
    if ratio >= MANY_TIMES:
        return f"{number_text(ratio, '.2g')} times"
    size = number_text(abs(percent), ".0f")
    if size == "100" and 0.0 < ratio < 1.0:
        size = number_text(min(abs(percent), NOT_ALL), ".4g")
    if worded:
        return f"{size} % {'less' if percent < 0.0 else 'more'}"
    return f"{'−' if percent < 0.0 else '+'}{size} %"


def mass_added_text(mass: float, form: str = MASS_FORM) -> str:
    """Write an added mass: ``2.3 kg added``, ``85 g added``, or ``nothing added``."""
    if mass <= 0.0:
        return "nothing added"
    if mass < LEAST_KILOGRAMS:
        return f"{number_text(1e3 * mass, form)} g added"
    return f"{number_text(mass, form)} kg added"
