"""The tables of a study as the text of a TOML file."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

# Keys that TOML takes without quotes, as long as they have no dot.
_BARE = re.compile("[A-Za-z0-9_-]+")


def study_text(tables: Mapping[str, Mapping[str, Any]]) -> str:
    """Write the tables of a study, which `balance.studies.read_study` reads again.

    Args:
        tables: those of `balance.studies.sweeps.study_data.StudyData.from_tables`, of texts,
            finite numbers, truth values, lists and tables.

    Returns:
        The text, a table of options of each quantity under a head such as ``[compute.design]``.
    """
    parts = []
    for name, table in tables.items():
        below = {k: v for k, v in table.items() if name == "compute" and isinstance(v, Mapping)}
        parts.append(_table(name, {k: v for k, v in table.items() if k not in below}))
        parts += [_table(f"{name}.{_key(k)}", options) for k, options in below.items()]
    return "\n".join(filter(None, parts))


def _table(head: str, entries: Mapping[str, Any]) -> str:
    """Write a table, a line for each entry; nothing if it is empty."""
    lines = [f"{_key(name)} = {_value(value)}\n" for name, value in entries.items()]
    return "".join([f"[{head}]\n", *lines]) if lines else ""


def _key(name: str) -> str:
    """Write a key, with quotes if it needs them."""
    return name if _BARE.fullmatch(name) else _value(name)


def _value(value: Any) -> str:
    """Write a value; tables inside a table are on one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{_key(name)} = {_value(each)}" for name, each in value.items())
        return f"{{{pairs}}}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)
