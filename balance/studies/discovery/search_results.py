"""What a search has found: families, random members that confirm them, and who can be built."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from time import monotonic
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.masses.designs.feasibility import feasible
from balance.studies.discovery.confirm import FamilyConfirmation, confirm
from balance.studies.discovery.exact_families import ExactFamily, decide_exactly
from balance.studies.discovery.families import Family, group_members
from balance.studies.discovery.job import DiscoveryJob, geometry_of_text
from balance.studies.discovery.motion_range import MotionRange, motion_range
from balance.studies.discovery.structure import LaneGeometry
from balance.studies.discovery.to_linkage import to_linkage
from balance.studies.runs.file_errors import damaged
from balance.studies.runs.results_file import ResultsFile
from kinematics.errors import LinkageError, UsageError

# Random members of a family that confirm its relations, and those that are tried for masses.
MEMBERS, TRIED = 100, 20
# Pause between two counts of families, over the duration of a count.
TALLY_PAUSE = 20.0


class SearchResults(NamedTuple):
    """What the walks of a file have found so far.

    Attributes:
        job: the search.
        outcomes: number of walks by what became of them.
        families: the families, that of the most members first.
    """

    job: DiscoveryJob
    outcomes: dict[str, int]
    families: tuple[Family, ...]


@dataclass(frozen=True, eq=False)
class ExaminedFamily:
    """A family with what its random members show.

    Attributes:
        family: the family.
        confirmation: random members, and how many have the nullity.
        serial: dimension of the serial part in the members that were tried.
        verdicts: number of members tried for masses, by verdict.
        buildable: number of the first random member that can be built; -1 if none was found.
        motion: range of motion of the member that is shown; None if it has several degrees of
            freedom.
        exact: what exact arithmetic says on its relations.
    """

    family: Family
    confirmation: FamilyConfirmation
    serial: int
    verdicts: dict[str, int]
    buildable: int
    motion: MotionRange | None
    exact: ExactFamily

    @property
    def shown(self) -> LaneGeometry:
        """A member that can be built, if one was found: random, or else that of a walk."""
        return _shown(self.family, self.confirmation, self.buildable)


def _shown(family: Family, confirmation: FamilyConfirmation, buildable: int) -> LaneGeometry:
    """Choose the member to show, in one lane."""
    if buildable < 0:
        return max(family.members, key=lambda member: member.margin > 0.0).geometry
    return confirmation.geometry.take(slice(buildable, buildable + 1))


def read_search(file: ResultsFile) -> SearchResults:
    """Group what the walks of a file have found.

    Raises:
        UsageError: the file is not that of a search.
        FileError: it is damaged.
    """
    if file.about["kind"] != DiscoveryJob.kind:
        raise UsageError(f"{file.path}: a file of '{file.about['kind']}', not of a search")
    try:
        job = DiscoveryJob.from_description(file.about["description"])
    except UsageError as error:
        raise damaged(file.path, str(error)) from None
    if job.columns != file.columns or job.rows != file.rows:
        raise damaged(file.path, "its rows or columns are not those of its search")
    table = file.read()
    special = np.flatnonzero(table["outcome"] == "special").tolist()
    ends = [_end_of(file.path, job, table, k) for k in special]
    families = group_members(job.topology, job.structure, job.generic, ends)
    return SearchResults(job, dict(Counter(table["outcome"].tolist()).most_common()), families)


def _end_of(
    path: str, job: DiscoveryJob, table: Mapping[str, NDArray[Any]], k: int
) -> tuple[int, LaneGeometry, int, int, float]:
    """Read the end of a walk: its number, geometry, nullity, codimension and margin.

    Raises:
        FileError: the file is damaged.
    """
    row, nullity = int(table["row"][k]), int(table["nullity"][k])
    codimension, margin = int(table["codimension"][k]), float(table["margin"][k])
    try:
        geometry = geometry_of_text(table["geometry"][k], job.structure)
    except UsageError as error:
        raise damaged(path, f"row {row}: {error}") from None
    changes = len(job.structure.moved)
    if not job.generic < nullity <= job.structure.unknowns or not 0 < codimension <= changes:
        raise damaged(
            path, f"row {row}: its nullity or codimension is none of a special geometry"
        )
    return row, geometry, nullity, codimension, margin


class FamilyTally:
    """Counts the families in a file while walks are added to it.

    Counting groups all that was found, so it is repeated only after 20 times its own duration.
    """

    def __init__(self, file: ResultsFile) -> None:
        """Start with the walks that the file has."""
        self._file = file
        self._known, self._next = 0, 0.0

    def count(self) -> int:
        """Return the number of families, as it was when they were last counted."""
        begin = monotonic()
        if begin >= self._next:
            self._known = len(read_search(self._file).families)
            end = monotonic()
            self._next = end + TALLY_PAUSE * (end - begin)
        return self._known


def examine(
    job: DiscoveryJob, family: Family, *, members: int = MEMBERS, tried: int = TRIED
) -> ExaminedFamily:
    """Draw random members of a family, decide them, and look for masses for some of them.

    Args:
        family: one of its families.
        members: number of random members to decide.
        tried: number of them to look for masses for.
    """
    confirmation = confirm(job.structure, family, members)
    verdicts: Counter[str] = Counter()
    serial, buildable = -1, -1
    for number in range(min(tried, confirmation.members)):
        try:
            linkage = to_linkage(job.topology, job.structure, confirmation.geometry, number)
            space = job.space(linkage)
            verdict = str(feasible(space).verdict)
            serial = max(serial, space.serial_nullity)
        except LinkageError:
            verdict = "refused"
        verdicts[verdict] += 1
        if verdict == "feasible" and buildable < 0:
            buildable = number
    shown = _shown(family, confirmation, buildable)
    motion = motion_range(job.topology, job.structure, shown)
    exact = decide_exactly(job.structure, family, job.everywhere)
    return ExaminedFamily(
        family, confirmation, serial, dict(verdicts), buildable, motion, exact
    )
