"""A sweep as a job in chunks: what it computes of which rows."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from numpy.typing import NDArray

from balance.studies.runs.chunk_job import Column
from balance.studies.sweeps.plan import Plan
from balance.studies.sweeps.quantities import quantity_columns
from balance.studies.sweeps.rows import compute_rows
from balance.studies.sweeps.study_data import StudyData
from kinematics.errors import FileError
from kinematics.version import __version__


@dataclass(frozen=True)
class SweepJob:
    """A study that is computed chunk by chunk, by any process, in any order.

    Attributes:
        kind: ``"sweep"``.
        digest: SHA-256 of the study, of its model and of the version of this program.
        description: the study as JSON text.
        columns: parameters, whether the loops close and why not, then the quantities.
        rows: number of geometries.
        chunk_rows: most geometries of a chunk.
    """

    digest: str
    description: str
    columns: tuple[Column, ...]
    rows: int
    chunk_rows: int
    kind: str = "sweep"

    @classmethod
    def of_study(cls, study: StudyData) -> SweepJob:
        """Check a study against its model, and make its job.

        Raises:
            FileError: the study does not fit its model.
        """
        text = study.to_text()
        plan = _plan_of(text)
        columns = (
            *(Column(name, "real", _unit_of(name)) for name in plan.driven),
            Column("closed", "integer"), Column("reason", "text"),
            *quantity_columns(study.quantities, plan.linkage),
        )  # fmt: skip
        names = [column.name for column in columns]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            remedy = "give the parameter another name"
            where = f"[parameters] {twice}"
            raise FileError(study.source, where, "is the name of a column of results", remedy)
        # A study is the same one from any folder.
        same = replace(study, source="", model=replace(study.model, source="")).to_text()
        digest = hashlib.sha256(f"{__version__}\n{same}".encode()).hexdigest()
        return cls(digest, text, columns, study.rows, study.chunk_rows)

    @classmethod
    def from_description(cls, text: str) -> SweepJob:
        """Make a job again from its description."""
        return cls.of_study(StudyData.from_text(text))

    def compute(self, chunk: int) -> Mapping[str, NDArray[Any] | list[Any]]:
        """Compute the columns of a chunk.

        Args:
            chunk: its number, from 0.

        Returns:
            Values by name of the column: the same ones in every call.
        """
        start = chunk * self.chunk_rows
        stop = min(start + self.chunk_rows, self.rows)
        if not 0 <= start < stop:
            raise ValueError(f"there is no chunk {chunk}")
        values = compute_rows(_plan_of(self.description), start, stop)
        return {column.name: values[column.name] for column in self.columns}


@lru_cache(maxsize=4)
def _plan_of(text: str) -> Plan:
    """Read a study and its model, once in each process."""
    return Plan(StudyData.from_text(text))


def _unit_of(path: str) -> str:
    """Name the unit of a parameter; empty if it has none."""
    head, _, last = path.rpartition(".")
    if head.endswith(".inertia"):
        return "kg m²"
    if last in ("roll", "pitch", "yaw"):
        return "rad"
    if head.endswith((".origin", ".com")):
        return "m"
    return {"length": "m", "mass": "kg"}.get(last, "") if head else ""
