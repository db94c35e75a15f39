"""Forms of the values that the options of quantities of a sweep have, before any model."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from typing import Any

# Most samples of a motion.
MOST_SAMPLES = 1_000_000


def expected_form(option: str, value: object) -> str:
    """Say how the value of an option is written if this one is wrong; else an empty text.

    Args:
        option: name of an option of a quantity.
        value: its value, as a study has it.
    """
    is_right, form = FORMS[option]
    return "" if is_right(value) else form


def _is_number(value: object) -> bool:
    """Whether a value is a finite number, neither true nor false."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return -sys.float_info.max <= value <= sys.float_info.max


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_list(value: object, is_right: Callable[[Any], bool]) -> bool:
    """Whether a value is a list whose items are right."""
    return isinstance(value, list | tuple) and all(map(is_right, value))


def _is_table(value: object, is_right: Callable[[Any], bool]) -> bool:
    """Whether a value is a table whose values are right."""
    return isinstance(value, Mapping) and all(map(is_right, value.values()))


def _is_pair(value: object) -> bool:
    """Whether a value is a list of two numbers, which may be infinite."""
    return isinstance(value, list | tuple) and len(value) == 2 and all(
        _is_number(x) or x in (math.inf, -math.inf) for x in value
    )  # fmt: skip


def _is_count(value: object) -> bool:
    if isinstance(value, bool) or not isinstance(value, int):
        return False
    return 0 < value <= MOST_SAMPLES


def _is_row(value: object) -> bool:
    return _is_list(value, _is_number)


FORMS: Mapping[str, tuple[Callable[[object], bool], str]] = {
    "add": (lambda value: _is_list(value, _is_text), '["crank", "rocker"]'),
    "bounds": (lambda value: _is_table(value, _is_pair), "{rocker = [0.1, 3.0]}, in kg"),
    "count": (_is_count, "a whole number"),
    "crank": (_is_text, '"u1"'),
    "duration": (_is_number, "seconds"),
    "keep": (lambda value: _is_list(value, _is_text), '["coupler"]'),
    "minimise": (_is_text, '"mass"'),
    "poses": (lambda value: _is_list(value, _is_row), "[[0.0], [0.5]]"),
    "regions": (lambda value: _is_table(value, _is_text), '{crank = "ball(0,0,0,0.1)"}'),
    "samples": (_is_count, f"a whole number up to {MOST_SAMPLES}"),
    "speed": (_is_number, "rad/s"),
    "within": (_is_number, "metres"),
}
