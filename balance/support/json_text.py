"""The JSON encoder for the output of commands and for pages."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from fractions import Fraction


def json_text(data: object, indent: int | None = None) -> str:
    """Encode data as strict JSON: no NaN, no infinity.

    Args:
        data: nested mappings, sequences, arrays and scalars; see `plain_data`.
        indent: blanks per level; everything in one line by default.

    Raises:
        TypeError: something in the data has no counterpart in JSON.

    Example:
        >>> import numpy as np
        >>> from balance.support.json_text import json_text
        >>> json_text({"rank": np.int64(7), "gap": float("inf")})
        '{"rank": 7, "gap": null}'
    """
    return json.dumps(plain_data(data), indent=indent, ensure_ascii=False, allow_nan=False)


def plain_data(data: object) -> object:
    """Convert data to the types of JSON: dict, list, str, int, float, bool and None.

    Arrays and tuples become lists, NumPy scalars Python scalars, and fractions strings such as
    ``"1/3"``. NaN and infinities become None, since JSON has no number for them.

    Raises:
        TypeError: something in the data, or a key, is of another type.
    """
    if hasattr(data, "tolist"):
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
        return {key: plain_data(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [plain_data(value) for value in data]
    raise TypeError(f"JSON has no type for {type(data).__name__}")
