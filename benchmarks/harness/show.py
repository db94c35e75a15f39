"""Print figures, verdicts and tables, as text or in Markdown."""

from __future__ import annotations

import numpy as np

Rows = list[tuple[str, dict[str, object]]]


def seconds(times: np.ndarray) -> str:
    """Format median, 10th and 90th percentile of times, in a suitable unit."""
    low, median, high = np.percentile(times, [10, 50, 90])
    unit, name = next(
        (u, n)
        for u, n in ((1e-6, "µs"), (1e-3, "ms"), (1.0, "s"))
        if median < 1e4 * u or n == "s"
    )
    return f"{median / unit:9.1f} {name:<2}   ({low / unit:.1f} … {high / unit:.1f})"


class Text:
    """Plain text."""

    def claim(self, name: str, text: str) -> None:
        """Print the claim of a module."""
        print(f"\n{text}")

    def line(self, label: str, name: str, value: str) -> None:
        """Print one figure, or one verdict."""
        print(f"  {label:<28} {name:<32} {value}", flush=True)

    def table(self, rows: Rows, total: bool = False) -> None:
        """Print the rows of all parameters under one head, and their sums if wanted."""
        if not rows:
            return
        head = list(rows[0][1])
        if total:
            sums = {name: sum(row[name] for _, row in rows) for name in head}
            rows = [*rows, ("total", sums)]
        self.cells([["", *head], *([label, *map(str, row.values())] for label, row in rows)])

    def cells(self, rows: list[list[str]]) -> None:
        """Print a table; its first row is the head."""
        first, *wide = (max(map(len, column)) for column in zip(*rows, strict=True))
        for label, *row in rows:
            padded = (f"  {cell:>{width}}" for cell, width in zip(row, wide, strict=True))
            print(f"  {label:<{max(28, first)}}{''.join(padded)}", flush=True)


class Markdown(Text):
    """Tables in Markdown."""

    def __init__(self) -> None:
        """Start without an open table."""
        self._open = False

    def claim(self, name: str, text: str) -> None:
        """Print a heading, and the claim."""
        self._open = False
        print(f"\n### {name}\n\n{text}")

    def line(self, label: str, name: str, value: str) -> None:
        """Print one row of the table of times and verdicts."""
        if not self._open:
            print("\n| case | what | value |\n|---|---|---|")
            self._open = True
        print(f"| {label} | {name.removeprefix('time_')} | {value.strip()} |", flush=True)

    def cells(self, rows: list[list[str]]) -> None:
        """Print a separate table."""
        self._open = False
        head, *rest = (f"| {' | '.join(row)} |" for row in rows)
        print("", head, "|---" * len(rows[0]) + "|", *rest, sep="\n", flush=True)
