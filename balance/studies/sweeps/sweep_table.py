"""The table of all geometries of a sweep, in memory."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from balance.studies.runs.chunk_job import Column, chunk_count
from balance.studies.sweeps.job import SweepJob
from balance.support.processes import map_in_processes
from balance.support.result_files import Picture, WithPage, draw_file
from kinematics.wording import count_noun, first_names, html_facts, number_text, repr_lines

if TYPE_CHECKING:
    from pandas import DataFrame

    from kinematics.model.linkage import Linkage


@dataclass(frozen=True, eq=False)
class SweepTable(WithPage):
    """The results of a sweep, column by column.

    Attributes:
        columns: values by name, read-only: integers (-1 where there is none), real numbers
            (NaN where there is none) and texts (empty where there is none), row by row.
        units: unit of each column that has one.
        reasons: how many geometries have no answer, by reason.
        job: what was computed; pages and pictures are drawn from it and the columns.
        source: name of the study in messages.
    """

    page_maker = "sweep:table_page"
    picture_maker = "sweep_plot:table_picture"

    columns: Mapping[str, NDArray[Any]]
    units: Mapping[str, str]
    reasons: Mapping[str, int]
    job: SweepJob
    source: str

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return the column of a name."""
        return self.columns[name]

    def __len__(self) -> int:
        """Count the geometries."""
        return len(self.columns["reason"])

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the columns."""
        return iter(self.columns)

    def __repr__(self) -> str:
        """Up to six lines: how many geometries, columns, reasons."""
        told = [f"{count} without an answer: {why}" for why, count in self.reasons.items()]
        head = f"SweepTable: {count_noun(len(self), 'geometry')}"
        return repr_lines(head, f"columns {first_names(list(self.columns))}", *told)

    def _repr_html_(self) -> str:
        """Table of the columns with their least and largest values, for notebooks."""
        rows = []
        for name, values in self.columns.items():
            plain = [x for x in _plain(values) if isinstance(x, (int, float))]
            unit = f" {self.units[name]}" if name in self.units else ""
            if plain:
                ends = f"{number_text(min(plain))} to {number_text(max(plain))}{unit}"
                rows.append((name, ends))
        told = ((f"{count} without an answer", why) for why, count in self.reasons.items())
        return html_facts(f"SweepTable: {count_noun(len(self), 'geometry')}", *told, *rows)

    def linkage(self, row: int, added: str = "") -> Linkage:
        """Build the linkage of a row, with its lengths and masses, at its closed pose.

        Its ``to_urdf()`` is the text of a file.

        Args:
            row: its number, from 0.
            added: ``"counterweights"`` or ``"reduce"``, a quantity of the study: the matter
                that it adds to the row is then in the masses of the links; or ``"design"``:
                its masses are then those of the links. Empty for the given masses.

        Raises:
            UsageError: there is no such row, its loops do not close, the study does not compute
                that quantity, or it finds no masses for the row.
            LinkageError: no body has the masses of the row, or the linkage cannot move.
        """
        return self.job.linkage(row, added)

    def to_pandas(self) -> DataFrame:
        """Convert to a pandas table, with pandas installed."""
        from pandas import DataFrame

        return DataFrame(dict(self.columns))

    def to_dict(self) -> dict[str, object]:
        """Convert to the values of a JSON object; None where a value is missing."""
        return {
            "columns": {name: _plain(values) for name, values in self.columns.items()},
            "units": dict(self.units),
            "reasons": dict(self.reasons),
        }

    def plot(
        self, path: str | PathLike[str] | None = None, columns: Sequence[str] = ()
    ) -> Picture:
        """Draw columns over each other: a map if two of them form a grid, points if not.

        Geometries of lower rank than most are circled.

        Args:
            path: file to write the picture to, which ends in ``.png`` or ``.svg``; None for
                none.
            columns: names of two columns of numbers, and of a third one for the colour; by
                default the first two that vary of the parameters, and the first that varies of
                the quantities.

        Returns:
            The bytes of the picture, PNG without a path; notebooks show it.

        Raises:
            UsageError: the path has another ending, or there are no such columns.
            PackageError: Matplotlib is missing.
            FileError: the file cannot be written.
        """
        return draw_file(self, path, columns=tuple(columns))


def compute_table(job: SweepJob, workers: int, source: str) -> SweepTable:
    """Compute all chunks of a job, and join their columns.

    Args:
        workers: processes to use.
        source: name of the study in messages.
    """
    chunks = range(chunk_count(job.rows, job.chunk_rows))
    parts = list(map_in_processes(job.compute, chunks, min(workers, len(chunks))))
    columns = {
        column.name: _join(column, [part[column.name] for part in parts])
        for column in job.columns
    }
    reasons = Counter(reason for reason in columns["reason"].tolist() if reason)
    units = {column.name: column.unit for column in job.columns if column.unit}
    return SweepTable(
        MappingProxyType(columns),
        MappingProxyType(units),
        MappingProxyType(dict(reasons.most_common())),
        job,
        source,
    )


def _join(column: Column, parts: Sequence[Any]) -> NDArray[Any]:
    """Join the values of a column, read-only."""
    kinds = {"integer": np.int64, "real": np.float64, "text": np.object_}
    joined = np.concatenate([np.asarray(part, dtype=kinds[column.kind]) for part in parts])
    joined.flags.writeable = False
    return joined


def _plain(values: NDArray[Any]) -> list[Any]:
    """Convert a column to a list, None where a value is missing."""
    none = -1 if values.dtype.kind == "i" else ""
    return [None if value == none or value != value else value for value in values.tolist()]
