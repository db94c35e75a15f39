"""Changes of nested lists and tables, as of JSON and TOML."""

from __future__ import annotations

import datetime
import random
from collections.abc import Iterator
from copy import deepcopy
from typing import Any

ODD_VALUES: tuple[Any, ...] = (
    None, True, False, 0, 1, -1, 2, 3, 7, 10**6, 2**62, 2**63, 10**30, 0.0, 0.5, -0.5, 1e300,
    -1e-300, float("nan"), float("inf"), "", "x", "0", "nan", "1e400", "rank",
    "q2.origin.x", "{", "ключ", "0.1:0.4:3", "0.1:0.4:0", "a\nb", "\x00", "x" * 300,
    [], {}, [[]], [None], ["x"], [1, 2], [0.5, "x"], [True], {"x": 1}, {"uniform": [0, 1]},
    {"uniform": "x"}, {"sobol": [1, 1]}, {"": {}}, {"points": []}, datetime.date(2026, 1, 1),
    datetime.time(7, 0),
    datetime.datetime(2026, 1, 1, 7, 0),
)  # fmt: skip


def odd_value(rng: random.Random) -> Any:
    """Take a value that is wrong in most places."""
    return deepcopy(rng.choice(ODD_VALUES))


def changed(rng: random.Random, value: Any) -> Any:
    """Change one place of nested lists and tables; the value itself stays as it is."""
    value = deepcopy(value)
    places = list(_places(value))
    if not places or rng.random() < 0.03:
        return odd_value(rng)
    inside, key = rng.choice(places)
    other, there = rng.choice(places)
    change = rng.randrange(8)
    if change == 0:
        del inside[key]
    elif change == 1:
        inside[key] = deepcopy(other[there])
    elif change == 2 and isinstance(inside, list):
        inside.insert(key, odd_value(rng))
    elif change == 2:
        inside[rng.choice(("x", "", key + "x", key.upper(), there))] = odd_value(rng)
    elif change == 3:
        inside[key] = rng.choice(([inside[key]], {"x": inside[key]}, str(inside[key])))
    elif change == 4 and isinstance(inside[key], int | float):
        inside[key] = inside[key] * rng.choice((-1, 0, 2, 0.5, 1e6, 1e-6))
    else:
        inside[key] = odd_value(rng)
    return value


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Yield each list or table with each of its keys, from the outside in."""
    keys: Any = range(len(value)) if isinstance(value, list) else ()
    for key in list(value) if isinstance(value, dict) else keys:
        yield value, key
        yield from _places(value[key])
