"""A sweep as a job in chunks: what it computes of which rows."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain
from time import monotonic
from typing import Any

import numpy as np
from numpy.typing import NDArray

from balance.space.many.many_geometries import design_space_many
from balance.studies.runs.chunk_job import Column, chunk_size
from balance.studies.sweeps.closing import ClosedGeometries
from balance.studies.sweeps.geometry import SweptGeometry
from balance.studies.sweeps.model_values import (
    FollowingRegion,
    following_regions,
    values_in_model,
)
from balance.studies.sweeps.plan import Plan
from balance.studies.sweeps.quantities import (
    RANK_DROP,
    full_options,
    masses_of_column,
    quantity_columns,
)
from balance.studies.sweeps.row_quantities import (
    QUANTITIES,
    WITH_MASSES,
    Quantity,
    masses_after,
)
from balance.studies.sweeps.study_data import StudyData
from balance.studies.sweeps.study_units import unit_of_path
from kinematics.closure.joint_positions import with_bodies
from kinematics.errors import FileError, LinkageError, UsageError
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.version import __version__

Texts = NDArray[np.object_]

OPEN = "its loops do not close"
NO_NUMBER = "a parameter has no finite value"
# Seconds of the rows that are kept together, and of a row at least.
PART_SECONDS, SHORTEST = 3.0, 1e-6
# Rows that tell the rank of generic geometries.
PROBES = 64


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
            *(Column(name, "real", unit_of_path(name)) for name in plan.driven),
            Column("closed", "integer"),
            Column("reason", "text"),
            *quantity_columns(study.quantities, plan.linkage),
        )
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
        # Values of a study may be of any size; what overflows is no finite number in its row.
        with np.errstate(over="ignore", invalid="ignore"):
            values = _compute_rows(_plan_of(self.description), start, stop)
        return {column.name: values[column.name] for column in self.columns}

    def linkage(self, row: int, added: str = "") -> Linkage:
        """Build the linkage of a row, at the pose that closes its loops.

        Args:
            row: its number, from 0.
            added: the quantity whose matter its links have as well, or ``"design"``, whose
                masses they have instead; empty for the masses given.

        Raises:
            UsageError: there is no such row, its loops do not close, the study does not compute
                that quantity, or it finds no matter for the row.
            LinkageError: no body has the masses of the row, or the linkage cannot move.
        """
        geometry = self._geometry(row)
        if not added:
            return geometry.linkage
        study = _plan_of(self.description).study
        if added not in WITH_MASSES or added not in study.quantities:
            raise UsageError(f"added='{added}' is no matter that the study adds: leave it out")
        z, words = masses_after(geometry, added, study.quantities[added])
        if z is None:
            raise UsageError(f"row {row}: no masses of {added}: {words}")
        return _with_masses(geometry.linkage, z)

    def completed(self, row: int, column: str = "") -> tuple[Linkage, str]:
        """Build the linkage of a row with the masses that the study computes, if there are any.

        Args:
            row: its number, from 0.
            column: a column that was computed with such masses: those are taken first.

        Returns:
            The linkage; and the quantity of its masses, the first of `WITH_MASSES`, or an
            empty text if they are those given.

        Raises:
            LinkageError: as for `linkage`.
        """
        geometry = self._geometry(row)
        quantities = _plan_of(self.description).study.quantities
        first = masses_of_column(quantities, geometry.linkage, column)
        names = [name for name in WITH_MASSES if name in quantities]
        for name in sorted(names, key=lambda name: name != first):
            z, _ = masses_after(geometry, name, quantities[name])
            if z is not None:
                return _with_masses(geometry.linkage, z), name
        return geometry.linkage, ""

    def values_in_model(self) -> dict[str, float]:
        """See `balance.studies.sweeps.model_values.values_in_model`."""
        return values_in_model(_plan_of(self.description))

    def following_regions(self) -> list[FollowingRegion]:
        """See `balance.studies.sweeps.model_values.following_regions`."""
        return following_regions(_plan_of(self.description))

    def _geometry(self, row: int) -> SweptGeometry:
        """Close the loops of a row; raises errors of `linkage`."""
        if not 0 <= row < self.rows:
            raise UsageError(f"there is no row {row}: give one from 0 to {self.rows - 1}")
        plan = _plan_of(self.description)
        values = plan.values(row, row + 1)
        closed, reasons = _close(plan, values)
        if reasons[0]:
            raise UsageError(f"row {row} is no linkage, for {reasons[0]}: give another row")
        study, masses = plan.study, plan.masses(values, 0)
        return SweptGeometry(plan.linkage, masses, closed, 0, study.balance, study.spatial)

    def compute_part(self, chunk: int, first: int) -> tuple[dict[str, Any], int]:
        """Compute rows of a chunk for a few seconds; see `PartedJob.compute_part`.

        The rows of quantities that are computed one by one.
        """
        size, begin = chunk_size(chunk, self.rows, self.chunk_rows), monotonic()
        plan = _plan_of(self.description)
        step = size if set(plan.study.quantities) == {"rank"} else 1
        parts: list[dict[str, Any]] = []
        row = first
        while row < size and not (parts and monotonic() - begin > PART_SECONDS):
            start = chunk * self.chunk_rows + row
            step = min(step, size - row)
            with np.errstate(over="ignore", invalid="ignore"):
                parts.append(_compute_rows(plan, start, start + step))
            row += step
            spent = monotonic() - begin
            each = max(spent / (row - first), SHORTEST)
            step = max(1, min(2 * step, int((PART_SECONDS - spent) / each)))
        columns = {
            column.name: list(chain.from_iterable(part[column.name] for part in parts))
            for column in self.columns
        }
        return columns, row if row < size else 0


@lru_cache(maxsize=4)
def _plan_of(text: str) -> Plan:
    """Read a study and its model, once in each process."""
    return Plan(StudyData.from_text(text))


def _with_masses(linkage: Linkage, z: Array) -> Linkage:
    """Give the bodies of a linkage parameters (bodies, 10), inertial origin."""
    bodies = zip(linkage.bodies, z, strict=True)
    return with_bodies(linkage, [replace(body, inertia=freeze(each)) for body, each in bodies])


def _compute_rows(plan: Plan, start: int, stop: int) -> dict[str, Any]:
    """Compute the columns of rows ``start`` to ``stop`` of a study.

    Args:
        plan: the study with its model.
        start: first row.
        stop: row after the last.

    Returns:
        Values by name of the column, texts as lists.
    """
    study = plan.study
    values = plan.values(start, stop)
    closed, reasons = _close(plan, values)
    plan.constraints.check(plan.closer, values, closed, reasons)
    columns: dict[str, Any] = {**values, "closed": closed.closed, "reason": reasons}
    lower = any(options.get("where") == RANK_DROP for options in study.quantities.values())
    if lower or "rank" in study.quantities:
        columns |= _ranks(plan, closed.screws, reasons)
    below = columns["rank"] < _generic_rank(plan) if lower else None
    geometries = _Geometries(plan, values, closed)
    answered = reasons == ""
    for name, options in study.quantities.items():
        if name != "rank":
            chosen = answered.copy()
            if options.get("where") == RANK_DROP:
                chosen &= below
            columns |= _by_row(geometries, name, chosen, reasons)
    return {
        name: column.tolist() if column.dtype == object else column
        for name, column in columns.items()
    }


def _close(plan: Plan, values: dict[str, Array]) -> tuple[ClosedGeometries, Texts]:
    """Close the geometries of rows, and note why some do not."""
    closed = plan.close(values)
    reasons = np.where(closed.closed > 0, "", OPEN).astype(object)
    finite = np.all([np.isfinite(value) for value in values.values()], axis=0)
    reasons[~finite] = NO_NUMBER
    return closed, reasons


def _ranks(plan: Plan, screws: Array, reasons: Texts) -> dict[str, Any]:
    """Compute the integers of all closed geometries; the reason why one has none is noted."""
    study, rows = plan.study, np.flatnonzero(reasons == "")
    many = design_space_many(
        plan.linkage, screws[rows], study.balance, spatial=study.spatial, workers=1
    )
    integers = {
        "rank": many.rank,
        "nullity": many.nullity,
        "serial": many.serial_nullity,
        "kmax": many.kmax,
    }
    columns: dict[str, Any] = {}
    for name, numbers in integers.items():
        columns[name] = np.full(reasons.size, -1, dtype=np.int64)
        columns[name][rows] = numbers
    columns["parallel"] = np.where(
        columns["rank"] >= 0, columns["nullity"] - columns["serial"], -1
    )
    columns["kept_pivot"] = np.full(reasons.size, np.nan)
    columns["kept_pivot"][rows] = np.where(many.rank >= 0, many.kept, np.nan)
    columns["unsure"] = np.full(reasons.size, "", dtype=object)
    for number, text in many.unsure.items():
        columns["unsure"][rows[number]] = text
    for number, text in many.refused.items():
        reasons[rows[number]] = _short(text, plan.linkage.source)
    return columns


@lru_cache(maxsize=4)
def _generic_rank(plan: Plan) -> int:
    """Compute the largest rank of 64 rows that are spread over a study."""
    count = min(PROBES, plan.study.rows)
    rows = sorted({(k * plan.study.rows) // count for k in range(count)})
    parts = [plan.values(row, row + 1) for row in rows]
    values = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    closed, reasons = _close(plan, values)
    return int(_ranks(plan, closed.screws, reasons)["rank"].max())


class _Geometries:
    """Rows that were closed together, as linkages.

    Attributes:
        plan: the study with its model.
        values: of all columns of parameters (rows,).
        closed: the geometries.
    """

    def __init__(self, plan: Plan, values: dict[str, Array], closed: ClosedGeometries) -> None:
        """Start without linkages."""
        self.plan, self.values, self.closed = plan, values, closed
        self._by_row: dict[int, SweptGeometry] = {}
        self._by_shape: dict[tuple[bytes, ...], SweptGeometry] = {}

    def at(self, row: int) -> SweptGeometry:
        """Return the geometry of a row, made once; those of one shape share its motions.

        Raises:
            LinkageError: no body has the masses of the row.
        """
        if row not in self._by_row:
            plan, closed = self.plan, self.closed
            numbers = [self.values[path][row] for path in plan.closer.placer.places]
            poses = closed.screws[row], closed.q[row], closed.H[row], np.array(numbers)
            shape = tuple(array.tobytes() for array in poses)
            study, masses = plan.study, plan.masses(self.values, row)
            geometry = SweptGeometry(
                plan.linkage,
                masses,
                closed,
                row,
                study.balance,
                study.spatial,
                self._by_shape.get(shape),
            )
            self._by_row[row] = geometry
            self._by_shape.setdefault(shape, geometry)
        return self._by_row[row]


def _by_row(
    geometries: _Geometries, name: str, chosen: Flags, reasons: Texts
) -> dict[str, Any]:
    """Compute a quantity of the chosen rows; the first reason for no value is noted."""
    plan, quantity = geometries.plan, QUANTITIES[name]
    study = plan.study
    options = full_options(study.quantities, name)
    columns = quantity.columns(plan.linkage, options)
    empty = {"integer": -1, "real": np.nan, "text": ""}
    types = {"integer": np.int64, "real": np.float64, "text": np.object_}
    arrays: dict[str, Any] = {
        column.name: np.full(reasons.size, empty[column.kind], dtype=types[column.kind])
        for column in columns
    }
    answered = _compute_together(geometries, quantity, np.flatnonzero(chosen), arrays)
    for row in np.flatnonzero(chosen & ~answered).tolist():
        try:
            geometry = geometries.at(row)
            values = quantity.compute(geometry, options)
            why = geometry.lacks.get(name, "")
        except LinkageError as error:
            values, why = (), str(error)
        if why and not reasons[row]:
            reasons[row] = f"{name}: {_short(why, plan.linkage.source)}"
        for column, value in zip(columns, values, strict=False):
            arrays[column.name][row] = value
    return arrays


def _compute_together(
    geometries: _Geometries, quantity: Quantity, rows: IntArray, arrays: dict[str, Any]
) -> Flags:
    """Compute a quantity of rows at once, where it can be; return of which (all rows,)."""
    plan, closed = geometries.plan, geometries.closed
    answered = np.zeros(closed.closed.size, dtype=np.bool_)
    if quantity.together is None:
        return answered
    known: dict[int, dict[str, Array]] = {}
    for row in rows.tolist():
        with suppress(LinkageError):
            known[row] = plan.masses(geometries.values, row)
    rows = np.array([*known], dtype=np.int64)
    values, held = quantity.together(plan.linkage, plan.closer, closed, rows, [*known.values()])
    answered[rows[held]] = True
    for array, column in zip(arrays.values(), values.T, strict=True):
        array[rows[held]] = column[held]
    return answered


def _short(text: str, source: str) -> str:
    """Shorten a message to a reason that many rows share: without source, numbers, remedy."""
    words = text.removeprefix(f"{source}: ").partition("; ")[0]
    return re.sub(r"(?<![\w.])[-+]?\d+(\.\d+)?(e[-+]?\d+)?(?![\w.])", "…", words)
