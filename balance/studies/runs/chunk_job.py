"""A computation in chunks: what a runner must know of it, and nothing of what it computes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeAlias, runtime_checkable

from numpy.typing import NDArray

from kinematics.errors import UsageError

ROW_NUMBER = "row"
"""Name of the number of a row, counted from 0 in the order of the job."""

ChunkTask: TypeAlias = "tuple[int, int]"
"""A chunk to compute, and the first of its rows that is not yet done, from 0."""

ChunkColumns: TypeAlias = Mapping[str, "NDArray[Any] | Sequence[Any]"]
"""Columns of one chunk by name, all of one length."""


@dataclass(frozen=True)
class Column:
    """A column of results.

    Attributes:
        name: any text but ``row``, different from that of every other column.
        kind: type of its values. A missing value is NaN in a real column, -1 in an integer
            column and an empty text in a text column.
        unit: unit of its values; empty if it has none.
    """

    name: str
    kind: Literal["integer", "real", "text"]
    unit: str = ""

    def __post_init__(self) -> None:
        """Refuse the name of the number of a row."""
        if self.name == ROW_NUMBER:
            raise UsageError(
                f"no column may be called '{ROW_NUMBER}', as the number of a row is"
            )

    @property
    def heading(self) -> str:
        """Name and unit, such as ``peak_force (N)``."""
        return f"{self.name} ({self.unit})" if self.unit else self.name


class ChunkJob(Protocol):
    """A computation whose rows are split into chunks; it can be pickled.

    Attributes:
        kind: what it computes, in one word, such as ``"sweep"``.
        digest: SHA-256 of all that decides the results.
        description: JSON text from which the job can be built again.
        columns: columns of the results.
        rows: number of rows, or a bound of it.
        chunk_rows: most rows of a chunk.
    """

    @property
    def kind(self) -> str:
        """What it computes."""

    @property
    def digest(self) -> str:
        """SHA-256 of all that decides the results."""

    @property
    def description(self) -> str:
        """JSON text from which the job can be built again."""

    @property
    def columns(self) -> tuple[Column, ...]:
        """Columns of the results."""

    @property
    def rows(self) -> int:
        """Number of rows, or a bound of it."""

    @property
    def chunk_rows(self) -> int:
        """Most rows of a chunk."""

    def compute(self, chunk: int) -> ChunkColumns:
        """Compute the columns of a chunk; the same ones in every call."""


@runtime_checkable
class PartedJob(ChunkJob, Protocol):
    """A job whose chunks may take long: it computes some rows of one after the other."""

    def compute_part(self, chunk: int, first: int) -> tuple[ChunkColumns, int]:
        """Compute rows of a chunk for a few seconds.

        Args:
            first: the first of its rows to compute, from 0.

        Returns:
            Their columns, and the row of the chunk after them; 0 at its end.
        """


def chunk_count(rows: int, chunk_rows: int) -> int:
    """Compute the number of chunks: ⌈rows / chunk_rows⌉.

    Args:
        rows: rows of a job.
        chunk_rows: most rows of a chunk.
    """
    return -(-rows // chunk_rows)


def chunk_size(chunk: int, rows: int, chunk_rows: int) -> int:
    """Compute the rows of one chunk: ``chunk_rows``, and what is left in the last one.

    Args:
        chunk: its number, from 0.
        rows: rows of the job.
        chunk_rows: most rows of a chunk.
    """
    return min(chunk_rows, rows - chunk * chunk_rows)
