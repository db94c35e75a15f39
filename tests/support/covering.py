"""Which cases of a large table run: those that cover it, or all with ``ALL_CASES=1``."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeVar

Case = TypeVar("Case")
ALL_CASES = os.environ.get("ALL_CASES", "0") not in ("", "0")


def number_of_cases(few: int, every: int) -> int:
    """How many random cases run: few, or every one with ``ALL_CASES=1``."""
    return every if ALL_CASES else few


def spread(cases: Sequence[Case], step: int, start: int = 0) -> Sequence[Case]:
    """Every ``step``-th case from ``start`` on, or all with ``ALL_CASES=1``."""
    return cases if ALL_CASES else cases[start::step]


def joint_types(path: Path) -> set[str]:
    """Types of the joints and loops in a file; a mimic joint counts as one more."""
    text = path.read_text(encoding="utf-8")
    return set(re.findall(r'<(?:joint|loop)\b[^>]*\btype="(\w+)"', text)) | {
        word for word in ("mimic", "loop") if f"<{word}" in text
    }


def covering_pairs(
    models: Mapping[str, set[str]], styles: Sequence[str]
) -> list[tuple[str, str]]:
    """Pairs of a model and a style: each model once, and each style with all types of joints.

    Args:
        models: types of the joints of each model, by its name.
        styles: names of the styles.
    """
    if ALL_CASES:
        return [(model, style) for model in models for style in styles]
    names = sorted(models)
    chosen = {(name, styles[k % len(styles)]) for k, name in enumerate(names)}
    for k, style in enumerate(styles):
        # Another order for each style, so that models take turns.
        turned = names[3 * k % len(names) :] + names[: 3 * k % len(names)]
        missing = set.union(*models.values())
        missing -= set().union(*(models[name] for name, own in chosen if own == style))
        while missing:
            best = max(turned, key=lambda name: len(models[name] & missing))
            chosen.add((best, style))
            missing -= models[best]
    return sorted(chosen)
