"""Tables of facts on several linkages: a row for each fact, a column for each linkage."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import wrap

__all__ = ["joined_facts", "side_by_side"]

Facts = Sequence[tuple[str, str]]

# Characters of a line, and the least of a column.
LINE, LEAST = 110, 22
MISSING = "–"


def joined_facts(facts: Sequence[Facts]) -> list[tuple[str, list[str]]]:
    """Join lists of facts to rows of a label and a text for each list.

    Labels are in the order in which they first appear; one that a list has several times has
    its texts in one cell, and one that it does not have a dash.

    Args:
        facts: pairs of label and value for each linkage.
    """
    labels: list[str] = []
    for pairs in facts:
        after = -1
        for label, _ in pairs:
            if label not in labels:
                labels.insert(after + 1, label)
            after = labels.index(label)
    return [
        (label, ["; ".join(v for name, v in pairs if name == label) or MISSING
                 for pairs in facts])
        for label in labels
    ]  # fmt: skip


def side_by_side(facts: Sequence[Facts]) -> str:
    """Write facts on several linkages as a plain text table, with cells of several lines.

    Args:
        facts: pairs of label and value for each linkage.
    """
    rows = joined_facts(facts)
    first = max(len(label) for label, _ in rows) + 1
    width = max((LINE - first) // len(facts) - 2, LEAST)
    lines = []
    for label, cells in rows:
        texts = [wrap(cell, width) for cell in cells]
        for k in range(max(map(len, texts))):
            parts = [text[k] if k < len(text) else "" for text in texts]
            body = "  ".join(f"{part:<{width}}" for part in parts)
            lines.append(f"{label if k == 0 else '':<{first}} {body}".rstrip())
    return "\n".join(lines)
