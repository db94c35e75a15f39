"""Computed numbers and vectors as text."""

from __future__ import annotations

import numpy as np

from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import round_decimals
from kinematics.wording import number_text, round_to_ten_digits, without_round_off


def vector_digits(vector: Array, digits: int, scale: float = 0.0) -> str:
    """Format numbers to the last decimal place of the largest one.

    Args:
        vector: the numbers (n,).
        digits: significant digits of the largest one.
        scale: a size in the unit of the numbers; those below `WRITTEN_AS_ZERO` of it are 0.
    """
    vector = without_round_off(vector, scale)
    largest = round_to_ten_digits(float(np.abs(vector).max()))
    place = digits - 1 - int(np.floor(np.log10(largest))) if largest else 0
    return ", ".join(f"{x + 0.0:.{digits}g}" for x in round_decimals(vector, place).tolist())


def plain_number(value: float, digits: int) -> str:
    """Write a number without an exponent where it is short."""
    text = number_text(value, f".{digits}g")
    return f"{float(text):.0f}" if "e+0" in text and float(text) < 1e7 else text
