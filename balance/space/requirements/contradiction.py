"""Which requirements contradict each other, where all together cannot be met."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations


def contradiction(
    texts: Sequence[str], excluded: Callable[[Sequence[int]], bool]
) -> tuple[str, ...]:
    """Find one requirement that cannot be met alone, or two that cannot be met together.

    Args:
        texts: the requirements, which together cannot be met.
        excluded: whether those at some positions cannot be met together.

    Returns:
        One text or two, the first that there are; empty if it takes more to contradict.
    """
    alone = next((k for k in range(len(texts)) if excluded([k])), None)
    if alone is not None:
        return (texts[alone],)
    for i, j in combinations(range(len(texts)), 2):
        if len(texts) == 2 or excluded([i, j]):
            return texts[i], texts[j]
    return ()


def contradiction_words(between: Sequence[str], what: str) -> str:
    """Say which requirements contradict each other.

    Args:
        between: the texts from `contradiction`.
        what: what there is none of for them, such as ``"design"``.
    """
    if len(between) == 1:
        return f"'{between[0]}' alone has no {what}"
    if between:
        first, second = between
        return f"'{first}' and '{second}' contradict each other: each alone has a {what}"
    return "no two of the requirements contradict each other, but all together do"
