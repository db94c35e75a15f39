"""Format texts and names of users in error messages: on one line, short, with near misses."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches

# Most names in a list.
MAX_NAMES = 8
# Least difflib ratio of a name that may have been meant: one letter of four, two of seven.
NEAR = 0.7


def clean(text: str, limit: int = 80) -> str:
    """Put a text on one line, without control characters, and shorten it."""
    line = text
    if not text.isprintable():
        line = "".join(c if c.isprintable() else " " for c in text)
    return line if len(line) <= limit else line[:limit] + "…"


def quoted(names: Iterable[str]) -> str:
    """List the first names, quoted, and how many are left."""
    texts = [f"'{clean(name)}'" for name in names]
    rest = f" and {len(texts) - MAX_NAMES} more" if len(texts) > MAX_NAMES else ""
    return ", ".join(texts[:MAX_NAMES]) + rest


def did_you_mean(name: str, candidates: Iterable[str]) -> str:
    """Ask for the known name that is a letter or two off; nothing if none is.

    Args:
        name: a name that is not known.
        candidates: the names to choose from.

    Returns:
        `` (did you mean 'crank'?)`` with a blank in front, or an empty text.

    Examples:
        >>> from kinematics.error_text import did_you_mean
        >>> did_you_mean("crnak", ["crank", "coupler"]), did_you_mean("arm", ["crank"])
        (" (did you mean 'crank'?)", '')
    """
    known = {other.lower(): other for other in list(candidates)[:2000] if len(other) < 80}
    like = get_close_matches(name[:80].lower(), known, 1, NEAR)
    if not like or known[like[0]] == name:
        return ""
    return f" (did you mean '{clean(known[like[0]])}'?)"


def closest_names(name: str, candidates: Iterable[str]) -> str:
    """List the known names, quoted, or the few most like ``name`` if there are many.

    Args:
        name: a name that is not known.
        candidates: the names to choose from.
    """
    names = list(candidates)
    if len(names) > MAX_NAMES:
        short = {other.lower(): other for other in names[:2000] if len(other) < 80}
        like = get_close_matches(name[:80].lower(), short, MAX_NAMES, 0.5)
        if like:
            return f"{quoted(short[other] for other in like)} and others"
    return quoted(names)
