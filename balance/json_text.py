"""JSON text of results: the one encoder of what commands print and pages hold."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from fractions import Fraction

import numpy as np

__all__ = ["json_text", "plain"]


def json_text(data: object, indent: int | None = None) -> str:
    """Data as strict JSON, in one piece: no NaN, no infinity, no types of NumPy.

    Args:
        data: what `plain` takes.
        indent: blanks per level; everything in one line by default.

    Raises:
        TypeError: something in the data has no counterpart in JSON.
    """
    return json.dumps(plain(data), indent=indent, ensure_ascii=False, allow_nan=False)


def plain(data: object) -> object:
    """Data in the types of JSON alone: dict, list, str, int, float, bool and None.

    Arrays and tuples become lists, scalars of NumPy those of Python, fractions texts such as
    ``"1/3"``. A number that is NaN or infinite becomes None: JSON has no other word for it.

    Raises:
        TypeError: something in the data, or a key, is of another type.
    """
    if isinstance(data, np.ndarray | np.generic):
        data = data.tolist()
    if isinstance(data, float):
        return data if math.isfinite(data) else None
    if data is None or isinstance(data, str | int):
        return data
    if isinstance(data, Fraction):
        return str(data)
    if isinstance(data, Mapping):
        if not all(isinstance(key, str) for key in data):
            raise TypeError("JSON has no keys but texts")
        return {key: plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain(value) for value in data]
    raise TypeError(f"JSON has no type for {type(data).__name__}")
