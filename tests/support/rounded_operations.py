"""Operations of doubles rounded at random: Monte Carlo arithmetic of uncompiled kernels.

A sum, difference, product or quotient that a double does not hold exactly changes by -1, 0 or 1
units in its last place, as `tests.support.perturbed_functions` draws them.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import cache
from math import frexp, inf, isfinite, nextafter
from typing import Any

import numpy as np

from tests.support.perturbed_functions import perturb_last_bits, rounding

# An odd factor, and the bits of a word.
FACTOR, WORD = 0x9E3779B97F4A7C15, 2**64 - 1


def _sum_is_exact(a: Any, b: Any, total: Any) -> Any:
    """Whether a rounded sum is the sum."""
    return (total - a == b) & (total - b == a)


def _difference_is_exact(a: Any, b: Any, difference: Any) -> Any:
    """Whether a rounded difference is the difference."""
    return (difference + b == a) & (a - difference == b)


def _product_is_exact(a: Any, b: Any, product: Any) -> Any:
    """Whether a factor is 0, 1, 2 or a half, up to its sign; short products stay anyway."""
    return _is_simple(a) | _is_simple(b)


def _quotient_is_exact(a: Any, b: Any, quotient: Any) -> Any:
    """Whether the dividend is 0, or the divisor 1, 2 or a half, up to its sign."""
    return (a == 0.0) | _is_simple(b)


def _is_simple(x: Any) -> Any:
    """Whether a number is 0, 1, 2 or a half, up to its sign."""
    size = abs(x)
    return (size == 0.0) | (size == 1.0) | (size == 2.0) | (size == 0.5)


OPERATIONS: dict[str, tuple[Callable[..., Any], Callable[..., Any]]] = {
    "Add": (operator.add, _sum_is_exact),
    "Sub": (operator.sub, _difference_is_exact),
    "Mult": (operator.mul, _product_is_exact),
    "Div": (operator.truediv, _quotient_is_exact),
}


@cache
def operation(name: str) -> Callable[[Any, Any], Any]:
    """The operation of a name, rounded at random.

    Args:
        name: one of `OPERATIONS`, after ``in place`` if an array on the left is changed.
    """
    plain, is_exact = OPERATIONS[name.rpartition(" ")[2]]
    in_place = name.startswith("in place")

    def rounded(a: Any, b: Any) -> Any:
        result = plain(a, b)
        if isinstance(result, float):
            return result if is_exact(a, b, result) else _step(result)
        if isinstance(result, np.ndarray) and result.dtype == np.float64:
            result = np.where(is_exact(a, b, result), result, perturb_last_bits(result))
            if in_place:
                a[...] = result
                return a
        return result

    return rounded


def _step(value: float) -> float:
    """Change a double by -1, 0, 0 or 1 units in its last place, unless 26 bits hold it."""
    if not isfinite(value) or frexp(value)[0] * 2.0**26 % 1.0 == 0.0:
        return value
    mixed = (hash(abs(value)) * FACTOR + rounding.seed) * FACTOR & WORD
    quarter = mixed >> 62
    if quarter in (1, 2):
        return value
    return type(value)(nextafter(value, inf if (quarter == 0) == (value < 0.0) else -inf))
