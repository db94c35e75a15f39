"""What a change of masses does to a load, in words: ``22 → 1.7 N (−92 %)``."""

from __future__ import annotations

from kinematics.wording import number_text, prefix_of

# Ratio of a load to that before, from which it is written as a number of times.
MANY_TIMES = 10.0
# Ratio of the larger load to the smaller, up to which both have three digits: two do not show
# the percentage.
SIMILAR = 2.0
# Percent up to which a load is unchanged.
UNCHANGED = 0.5
# Percent of a load that are taken at most, as written, where some of it is left.
NOT_ALL = 99.99
# Masses below are written in grams, kilograms.
LEAST_KILOGRAMS = 0.1


def change_text(
    before: float, after: float, unit: str, least: float = 0.0, *, worded: bool = False
) -> str:
    """Write a load before and after a change, and by how many percent it differs.

    Args:
        before: its size.
        after: its size then.
        unit: of both; a prefix may stand before it.
        least: sizes up to this are round-off, and written as 0.
        worded: whether to write ``92 % less`` instead of ``−92 %``.
    """
    first, then = (0.0 if size <= least else size for size in (before, after))
    if first == then == 0.0:
        return f"0 {unit}"
    factor, prefix = prefix_of(max(first, then))
    differs = abs(then - first) > UNCHANGED / 100.0 * first
    similar = differs and max(first, then) <= SIMILAR * min(first, then)
    digits = 3 if similar else 2
    start, end = (_with_digits(size / factor, digits) for size in (first, then))
    sizes = f"{start} → {end} {prefix}{unit}"
    return f"{sizes} ({_percent_text(then / first, worded)})" if first else sizes


def grows(before: float, after: float, least: float = 0.0) -> bool:
    """Whether a load is larger after a change, by more than half a percent and round-off.

    Args:
        before: its size.
        after: its size then.
        least: sizes up to this are round-off.
    """
    return after > least and after > before * (1.0 + UNCHANGED / 100.0)


def _percent_text(ratio: float, worded: bool) -> str:
    """Write by how many percent a ratio differs from 1."""
    percent = 100.0 * (ratio - 1.0)
    if abs(percent) <= UNCHANGED:
        return "unchanged"
    if ratio >= MANY_TIMES:
        return f"{_with_digits(ratio)} times"
    size = number_text(abs(percent), ".0f")
    if size == "100" and 0.0 < ratio < 1.0:
        size = number_text(min(abs(percent), NOT_ALL), ".4g")
    if worded:
        return f"{size} % {'less' if percent < 0.0 else 'more'}"
    return f"{'−' if percent < 0.0 else '+'}{size} %"


def mass_added_text(mass: float) -> str:
    """Write an added mass: ``2.3 kg added``, ``85 g added``, or ``nothing added``."""
    if mass <= 0.0:
        return "nothing added"
    if mass < LEAST_KILOGRAMS:
        return f"{_with_digits(1e3 * mass)} g added"
    return f"{_with_digits(mass)} kg added"


def _with_digits(value: float, digits: int = 2) -> str:
    """Write a number with so many digits, and without a power of ten up to a million."""
    return f"{float(number_text(value, f'.{digits}g')):.6g}"
