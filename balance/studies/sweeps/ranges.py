"""Values of a parameter, row by row: grids, lists and samples.

A row of a study has a number, and its values follow from that number alone: rows can be
computed in any order and by any process. Grids and lists come first, the last one fastest; the
samples of one point of the grid follow one another. A sample of row r is the r-th number of a
stream of its own, which follows from the seed and the name of the parameter, so that other
parameters do not change it.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any

import numpy as np

from balance.studies.sweeps.study_units import in_si
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array, IntArray

SAMPLED = ("uniform", "normal", "sobol")
"""Kinds of samples."""
# Most values of one grid, and points of a Sobol sequence.
MOST_VALUES, MOST_POINTS = 10_000_000, 2**30
# The largest double.
MOST = sys.float_info.max
# Whole numbers below this are doubles.
MOST_EXACT = 2**53
# Random numbers that a Philox generator makes in one step.
WORDS = 4
_GRID = re.compile(r"\s*([^:]*[^:\s])\s*:\s*([^:]*[^:\s])\s*:\s*([^:\s]+)\s*")


class RangeError(ValueError):
    """A range that has no values; the message says why."""


@dataclass(frozen=True)
class Range:
    """The values that one parameter takes.

    Attributes:
        kind: ``"grid"``, ``"list"``, ``"uniform"``, ``"normal"`` or ``"sobol"``.
        numbers: first value, last value and how many of a grid; the values of a list; the
            bounds of uniform and Sobol samples; mean and standard deviation of normal ones.
    """

    kind: str
    numbers: tuple[float, ...]

    @property
    def count(self) -> int:
        """Number of values of a grid or a list; 1 for samples."""
        if self.kind == "grid":
            return int(self.numbers[2])
        return len(self.numbers) if self.kind == "list" else 1


def read_range(value: object, *quantities: str) -> Range:
    """Read a range as a study writes it.

    Args:
        value: a grid ``"first:last:count"``, a list of numbers, one number, or a table with one
            of the keys uniform, normal and sobol. Numbers may be texts with a unit.
        quantities: of which numbers may have a unit, keys of `balance.support.units.UNITS`.

    Returns:
        The range.

    Raises:
        RangeError: it is none, it is empty, or a number is not finite.
    """
    if isinstance(value, str) and ":" in value:
        return _read_grid(value, quantities)
    given = value
    try:
        value = in_si(given, *quantities)
    except UsageError as error:
        if isinstance(given, str) and " is a unit of " not in str(error):
            raise RangeError(f"'{given[:40]}' is no grid 'first:last:count'") from None
        raise RangeError(str(error)) from None
    if isinstance(value, str):
        raise RangeError(f"'{value[:40]}' is no grid 'first:last:count'")
    if isinstance(value, Mapping):
        if len(value) != 1 or next(iter(value)) not in SAMPLED:
            keys = ", ".join(map(str, value)) or "nothing"
            raise RangeError(f"a table has one key of {', '.join(SAMPLED)}, not {keys}")
        ((kind, pair),) = value.items()
        return _read_sample(kind, _numbers(pair))
    numbers = _numbers(value)
    if not numbers:
        raise RangeError("the list is empty")
    return Range("list", numbers)


def stored_range(pair: object) -> Range:
    """Make a range of its kind and its numbers, as they are stored.

    Args:
        pair: a list of both.

    Raises:
        RangeError: they are none, or one that `read_range` would not give.
    """
    if not isinstance(pair, list) or len(pair) != 2 or not isinstance(pair[1], list):
        raise RangeError("it is no pair of a kind and numbers")
    kind, numbers = pair[0], _numbers(pair[1])
    if kind == "grid" and len(numbers) == 3 and abs(numbers[2]) <= MOST_VALUES:
        return _grid(*numbers[:2], int(numbers[2]), "of the file")
    if kind == "list" and numbers:
        return Range(kind, numbers)
    if kind in SAMPLED:
        return _read_sample(kind, numbers)
    raise RangeError(f"'{str(kind)[:40]}' of {len(numbers)} numbers is no range")


def _read_grid(text: str, quantities: Sequence[str]) -> Range:
    """Read a grid ``first:last:count``."""
    match = _GRID.fullmatch(text)
    if match is None:
        raise RangeError(f"'{text[:40]}' is no grid 'first:last:count'")
    try:
        first, last = (_grid_end(word, quantities) for word in (match[1], match[2]))
        count = int(match[3])
    except UsageError as error:
        raise RangeError(f"'{text[:40]}': {error}") from None
    except ValueError:
        raise RangeError(f"'{text[:40]}' has a word that is no number") from None
    return _grid(first, last, count, f"'{text[:40]}'")


def _grid_end(word: str, quantities: Sequence[str]) -> float:
    """Read the first or the last number of a grid."""
    try:
        return float(word)
    except ValueError:
        return float(in_si(word, *quantities))


def _grid(first: float, last: float, count: int, name: str) -> Range:
    """Check the numbers of a grid."""
    _numbers([first, last])
    if count < 1:
        raise RangeError(f"the grid {name} is empty")
    if count == 1 and first != last:
        raise RangeError(f"the grid {name} has one value and two ends")
    if count > MOST_VALUES:
        raise RangeError(f"the grid {name} has more than {MOST_VALUES} values")
    if first == last and count > 1:
        raise RangeError(f"the grid {name} has {count} equal values")
    return Range("grid", (first, last, float(count)))


def _read_sample(kind: str, numbers: tuple[float, ...]) -> Range:
    """Check the two numbers of samples."""
    if len(numbers) != 2:
        raise RangeError(f"{kind} takes two numbers, not {len(numbers)}")
    low, high = numbers
    if kind == "normal" and not high > 0.0:
        raise RangeError(f"normal takes a mean and a positive deviation, not {high:g}")
    if kind != "normal" and not high > low:
        raise RangeError(f"{kind} from {low:g} to {high:g} is empty")
    return Range(kind, numbers)


def is_finite_number(value: object) -> bool:
    """Whether a value of a study is a finite number, neither true nor false."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= MOST


def are_texts(value: object) -> bool:
    """Whether a value of a study is a list of texts."""
    return isinstance(value, list | tuple) and all(isinstance(item, str) for item in value)


def _numbers(value: object) -> tuple[float, ...]:
    """Convert a number or a list of numbers; each must be finite."""
    items: list[Any] = list(value) if isinstance(value, Sequence | np.ndarray) else [value]
    for item in items:
        if isinstance(item, bool) or not isinstance(item, int | float | np.number):
            raise RangeError(f"'{str(item)[:40]}' is no number")
        if not -MOST <= item <= MOST:
            raise RangeError(f"{str(item)[:40]} is not finite")
    return tuple(map(float, items))


def range_values(
    ranges: Mapping[str, Range], samples: int, seed: int, start: int, stop: int
) -> dict[str, Array]:
    """Compute the values of all parameters in rows ``start`` to ``stop``.

    Args:
        ranges: by name of the parameter.
        samples: samples of each point of the grid.
        start: first row.
        stop: row after the last.

    Returns:
        Values by name (rows,).
    """
    rows = np.arange(start, stop, dtype=np.int64)
    point, values = rows // samples, {}
    for name, each in reversed(list(ranges.items())):
        if each.kind not in SAMPLED:
            point, index = np.divmod(point, each.count)
            values[name] = _at_index(each, index)
    names = [name for name, each in ranges.items() if each.kind == "sobol"]
    unit = _sobol(len(names), seed, start, stop) if names else np.empty((stop - start, 0))
    for name, each in ranges.items():
        if each.kind in SAMPLED:
            u = (
                unit[:, names.index(name)]
                if each.kind == "sobol"
                else _uniform(name, seed, start, stop)
            )
            values[name] = _scaled(each, u)
    return {name: values[name] for name in ranges}


def _at_index(each: Range, index: IntArray) -> Array:
    """Compute the values of a grid or a list by their numbers."""
    if each.kind == "list":
        return np.array(each.numbers)[index]
    first, last, count = each.numbers
    if count == 1.0:
        return np.full(index.size, first)
    last_index = int(count) - 1
    a, b = (Fraction(repr(x)) for x in (first, last))
    unit = lcm(a.denominator, b.denominator)
    if max(abs(a), abs(b), Fraction(1)) * unit * last_index < MOST_EXACT:
        # The decimal that a person would write: whole numbers, divided once.
        whole = int(a * unit) * (last_index - index) + int(b * unit) * index
        return np.asarray(whole / float(unit * last_index))
    share = index / float(last_index)
    return np.asarray(first * (1.0 - share) + last * share)


def _scaled(each: Range, u: Array) -> Array:
    """Convert uniform numbers between 0 and 1 to samples."""
    low, high = each.numbers
    if each.kind != "normal":
        return np.asarray(low + (high - low) * u)
    from scipy.special import ndtri

    return np.asarray(low + high * ndtri(np.clip(u, 2.0**-54, 1.0 - 2.0**-53)))


def _uniform(name: str, seed: int, start: int, stop: int) -> Array:
    """Generate the numbers ``start`` to ``stop`` of the stream of a parameter."""
    digest = hashlib.sha256(f"{seed}\n{name}".encode()).digest()
    bits = np.random.Philox(key=int.from_bytes(digest[:16], "little"))
    skipped = start % WORDS
    bits.advance(start // WORDS)
    return np.random.Generator(bits).random(stop - start + skipped)[skipped:]


def _sobol(dimensions: int, seed: int, start: int, stop: int) -> Array:
    """Generate points of a scrambled Sobol sequence (rows, dimensions)."""
    from scipy.stats.qmc import Sobol

    engine = Sobol(dimensions, rng=seed)
    if start:
        engine.fast_forward(start)
    import warnings

    with warnings.catch_warnings():
        # The points of a chunk are part of a sequence, whose balance does not matter there.
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(engine.random(stop - start))
