"""One walk step by step, for those who watch it: geometries and their singular values."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from balance.studies.discovery.families import relations_of
from balance.studies.discovery.job import DiscoveryJob, geometry_of_text
from balance.studies.discovery.polish import polish
from balance.studies.discovery.relations import GeometryRelation
from balance.studies.discovery.structure import LaneGeometry
from balance.studies.discovery.walk import conditions_at
from balance.studies.runs.chunk_job import chunk_size
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array, IntArray


@dataclass(frozen=True, eq=False)
class WatchedWalk:
    """A walk with all steps that were kept.

    Attributes:
        job: the search that it belongs to.
        start: its number.
        geometry: the geometries, a lane for each: the start, one after each step, and the
            polished end, if the walk has arrived.
        values: singular values of the momentum rows of each, over the largest (steps, p).
        falling: what the walk lowers, at the start and after each step: the ratio, or the
            momentum of the best masses that can be built.
        polished: whether the last geometry is the polished end.
        outcome: what became of the walk; one of `OUTCOMES` of `rejections`.
        nullity: dimension of the design space at the end; -1 if it has not arrived.
        codimension: number of equations that the end fulfils; -1 if it has not arrived.
        relations: independent relations that hold at the end.
    """

    job: DiscoveryJob
    start: int
    geometry: LaneGeometry
    values: Array
    falling: Array
    polished: bool
    outcome: str
    nullity: int
    codimension: int
    relations: tuple[GeometryRelation, ...]

    @property
    def kept(self) -> int:
        """Index of the singular value that the walk lowers."""
        return self.job.structure.unknowns - self.job.generic - 1

    @property
    def ratios(self) -> Array:
        """Smallest kept singular value over the largest, step by step (steps,)."""
        return self.values[:, self.kept]


def watch_walk(job: DiscoveryJob, start: int) -> WatchedWalk:
    """Walk from one start of a search, and keep the steps.

    Args:
        start: number of the start.

    Raises:
        UsageError: the linkage cannot move at the start.
    """
    steps: list[LaneGeometry] = []
    falling: list[float] = []

    def watch(_: IntArray, geometry: LaneGeometry, ratios: Array) -> None:
        steps.append(geometry)
        falling.append(float(ratios[0]))

    rows = job.rows_of(range(start, start + 1), watch)
    if not steps:
        raise UsageError(
            f"start {start}: the linkage loses its way at once; take another start"
        )
    polished, relations = False, []
    if rows["outcome"][0] == "special":
        ends = polish(job.structure, steps[-1], job.generic)
        polished = bool(ends.special[0])
        if polished:
            steps.append(ends.geometry)
        end = geometry_of_text(rows["geometry"][0])
        relations = relations_of(job.topology, job.structure, end)[0][1]
    geometry = LaneGeometry(*(np.concatenate(a) for a in zip(*steps, strict=True)))
    values = conditions_at(job.structure, geometry).values
    return WatchedWalk(
        job,
        start,
        geometry,
        values / values[:, :1],
        np.array(falling),
        polished,
        str(rows["outcome"][0]),
        int(rows["nullity"][0]),
        int(rows["codimension"][0]),
        tuple(relations),
    )


def first_special_start(job: DiscoveryJob) -> int:
    """Find the first start of a search whose walk ends at a special geometry.

    Returns:
        Its number; -1 if there is none.
    """
    for chunk in range(-(-job.rows // job.chunk_rows)):
        first = chunk * job.chunk_rows
        count = chunk_size(chunk, job.rows, job.chunk_rows)
        outcomes = job.rows_of(range(first, first + count))["outcome"]
        if "special" in outcomes:
            return first + outcomes.index("special")
    return -1
