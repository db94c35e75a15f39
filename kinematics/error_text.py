"""Format texts and names of users in error messages: on one line, short, with near misses."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

# Most names in a list.
MAX_NAMES = 8


def clean(text: str, limit: int = 80) -> str:
    """Put a text on one line, without control characters, and shorten it."""
    line = "".join(c if c.isprintable() else " " for c in text)
    return line if len(line) <= limit else line[:limit] + "…"


def quoted(names: Iterable[str]) -> str:
    """List the first names, quoted, and how many are left."""
    texts = [f"'{clean(name)}'" for name in names]
    rest = f" and {len(texts) - MAX_NAMES} more" if len(texts) > MAX_NAMES else ""
    return ", ".join(texts[:MAX_NAMES]) + rest


def closest_names(name: str, candidates: Iterable[str]) -> str:
    """List the known names, quoted, or the few most like ``name`` if there are many.

    Args:
        name: a name that is not known.
        candidates: the names to choose from.
    """
    names = list(candidates)
    if len(names) > MAX_NAMES:
        short = [other for other in names[:2000] if len(other) < 80]
        like = get_close_matches(name[:80], short, MAX_NAMES, 0.5)
        if like:
            return f"{quoted(like)} and others"
    return quoted(names)
