"""A search as a job in chunks: walks from numbered starts, and what becomes of each.

A kite that is folded along its axis turns as one, or opens as two pairs of links: its parts
move independently. Only a pose next to it, closed by steps of least norm, tells this from a
node, where two motions meet.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from balance.space.requirements.require import require as require_all
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.studies.discovery.buildable_walk import margins, walk_to_buildable
from balance.studies.discovery.lane_motion import freedoms
from balance.studies.discovery.polish import move_away, polish
from balance.studies.discovery.rejections import judge_geometries
from balance.studies.discovery.search_requirements import required_structure
from balance.studies.discovery.structure import LaneGeometry, TopologyArrays
from balance.studies.discovery.topologies import Topology, topology
from balance.studies.discovery.walk import (
    REACH,
    Walks,
    Watcher,
    generic_nullity,
    walk_to_special,
)
from balance.studies.runs.chunk_job import Column, chunk_size
from balance.support.options import GRAVITY, Balance
from kinematics.errors import UsageError
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.version import __version__

CHUNK_ROWS = 50
# Random geometries by which the nullity of most geometries is found.
SAMPLE = 16
# Way of the fastest joint in the second walk.
AGAIN = 1.0
# Version of the method: results of another one are not mixed with these.
METHOD = 3
# Entries of a description, and their types.
DESCRIPTION = {"topology": str, "starts": int, "seed": int, "buildable": bool, "origin": str}
MOST_SEED = 2**63
# Axes of a geometry as text have length 1 within this.
UNIT = 1e-6
COLUMNS = (
    Column("outcome", "text"),
    Column("nullity", "integer"),
    Column("codimension", "integer"),
    Column("margin", "real"),
    Column("ratio", "real"),
    Column("steps", "integer"),
    Column("geometry", "text"),
)
# Way from the reference pose, radians, and number of directions in which it is gone.
WAY, WAYS = 0.2, 3
# Least and largest size of the random changes of a linkage, over its size.
NEAREST, FARTHEST = 0.01, 1.0


@dataclass(frozen=True)
class DiscoveryJob:
    """A search for special geometries of one topology.

    Attributes:
        name: the topology; see `balance.studies.discovery.topologies.topology`.
        starts: number of walks.
        seed: seed of the starts.
        buildable: whether to walk to geometries that masses balance which can be built.
        origin: a geometry as text, see `text_of_geometry`; walks start from it and near it.
            By default they start anywhere.
        require: what is balanced, as for `balance.require`, with the letters of joints as
            inputs; see `balance.studies.discovery.search_requirements`.
        gravity: direction of gravity in the frame of the ground (3,).
    """

    name: str
    starts: int
    seed: int = 1
    buildable: bool = False
    origin: str = ""
    require: str = "dynamic"
    gravity: tuple[float, float, float] = GRAVITY

    kind = "discovery"
    columns = COLUMNS
    chunk_rows = CHUNK_ROWS

    @classmethod
    def from_description(cls, text: str) -> DiscoveryJob:
        """Build the job of a file again.

        Args:
            text: the description in the file.

        Raises:
            UsageError: it is not that of a search.
        """
        try:
            data = json.loads(text)
        except (ValueError, RecursionError):
            data = None
        if not isinstance(data, dict) or any(
            type(data.get(name)) is not kind for name, kind in DESCRIPTION.items()
        ):
            raise UsageError("the file holds no search for special geometries")
        job = cls(
            data["topology"],
            data["starts"],
            data["seed"],
            data["buildable"],
            data["origin"],
            str(data.get("require", "dynamic")),
            _gravity(data.get("gravity", list(GRAVITY))),
        )
        if job.starts < 1 or not 0 <= job.seed <= MOST_SEED:
            raise UsageError("the file holds a search without walks or without a seed")
        structure = job.structure
        if job.origin:
            geometry_of_text(job.origin, structure)
        return job

    @property
    def rows(self) -> int:
        """Number of starts."""
        return self.starts

    @property
    def description(self) -> str:
        """JSON text from which the job can be built again."""
        data = {"topology": self.name, "starts": self.starts, "seed": self.seed}
        more = {"buildable": self.buildable, "origin": self.origin, "method": METHOD}
        # Files of searches for dynamic balance do not name it.
        named: dict[str, object] = {}
        if self.require != "dynamic":
            named["require"] = self.require
        if tuple(self.gravity) != tuple(GRAVITY):
            named["gravity"] = list(self.gravity)
        return json.dumps({**data, **more, **named})

    @property
    def digest(self) -> str:
        """SHA-256 of all that decides the results."""
        return hashlib.sha256(f"{__version__}\n{self.description}".encode()).hexdigest()

    @cached_property
    def topology(self) -> Topology:
        """The graph."""
        return topology(self.name)

    @cached_property
    def structure(self) -> TopologyArrays:
        """The graph as arrays, with what is required."""
        structure = self.topology.structure()
        return required_structure(self.topology, structure, self.require, self.gravity)

    @property
    def everywhere(self) -> Balance | None:
        """The balance that is asked for in all poses; None where it is another requirement."""
        if self.require == "force":
            return "force"
        return "dynamic" if self.require == "dynamic" else None

    def space(self, linkage: Linkage) -> DesignSpace:
        """Compute the design space of a linkage of this topology, for what is required.

        Args:
            linkage: from `balance.studies.discovery.to_linkage.to_linkage`.

        Raises:
            LinkageError: it cannot be computed.
        """
        if self.everywhere is not None:
            return design_space(linkage, balance=self.everywhere)
        return require_all(linkage, self.require, gravity=self.gravity)

    @cached_property
    def generic(self) -> int:
        """Dimension of the design space of most geometries, with all inertial parameters."""
        sample = random_starts(self.structure, self.seed, range(SAMPLE))
        return generic_nullity(self.structure, sample)

    def compute(self, chunk: int) -> Mapping[str, Any]:
        """Walk from the starts of a chunk, and judge the ends."""
        count = chunk_size(chunk, self.rows, self.chunk_rows)
        first = chunk * self.chunk_rows
        return self.rows_of(range(first, first + count))

    def rows_of(self, numbers: range, watch: Watcher | None = None) -> Mapping[str, Any]:
        """Walk from some starts, and judge the ends: the columns of their rows.

        Args:
            numbers: numbers of the starts.
            watch: told of the steps of the first walks; see
                `balance.studies.discovery.walk.descend`.
        """
        walks = self.walk(self.start(numbers), watch=watch)
        rows = _Rows(len(numbers))
        arrived = np.flatnonzero(walks.arrived)
        rows.outcome[arrived] = "lost at a node"
        if arrived.size:
            moved, lanes = move_away(self.structure, walks.geometry.take(arrived))
            if lanes.size:
                again = self.walk(moved, AGAIN)
                kept = arrived[lanes[again.arrived]]
                rows.fill(self, kept, again.geometry.take(again.arrived))
        ratio = np.where(np.isfinite(walks.ratio), walks.ratio, np.nan)
        return {
            "outcome": rows.outcome.tolist(),
            "nullity": rows.nullity,
            "codimension": rows.codimension,
            "margin": rows.margin,
            "ratio": ratio,
            "steps": walks.steps,
            "geometry": rows.text,
        }

    def start(self, numbers: range) -> LaneGeometry:
        """Draw starts.

        Args:
            numbers: their numbers; 0 is the origin, if there is one.
        """
        if self.origin:
            origin = geometry_of_text(self.origin)
            return _starts_near(self.structure, origin, self.seed, numbers)
        return random_starts(self.structure, self.seed, numbers)

    def walk(
        self, start: LaneGeometry, reach: float = REACH, watch: Watcher | None = None
    ) -> Walks:
        """Walk as the search does.

        Args:
            reach: way of the fastest joint at the poses, radians.
            watch: told of each step; see `balance.studies.discovery.walk.descend`.
        """
        if self.buildable:
            return walk_to_buildable(self.structure, start, reach=reach, watch=watch)
        return walk_to_special(self.structure, start, self.generic, reach=reach, watch=watch)


def _gravity(given: object) -> tuple[float, float, float]:
    """Read gravity from a description.

    Raises:
        UsageError: it is none.
    """
    listed = given if isinstance(given, list) else []
    values = [float(x) for x in listed if isinstance(x, int | float) and abs(x) < MOST_SEED]
    if len(values) != 3:
        raise UsageError("the file holds a search without a direction of gravity")
    return values[0], values[1], values[2]


class _Rows:
    """Rows of a chunk that are filled in as walks are judged."""

    def __init__(self, count: int) -> None:
        """Start with walks that have not arrived."""
        self.outcome = np.full(count, "not arrived", dtype=object)
        self.nullity, self.codimension = np.full(count, -1), np.full(count, -1)
        self.margin = np.full(count, np.nan)
        self.text = [""] * count

    def fill(self, job: DiscoveryJob, lanes: IntArray, geometry: LaneGeometry) -> None:
        """Polish and judge the ends of walks, and enter what becomes of them."""
        if not lanes.size:
            return
        ends = polish(job.structure, geometry, job.generic)
        split = motion_splits(job.structure, ends.geometry) & ~ends.special
        self.outcome[lanes] = np.where(split, "motion splits", "not exact")
        special_lanes = np.flatnonzero(ends.special)
        if not special_lanes.size:
            return
        ends = ends.take(special_lanes)
        special, to = ends.geometry, lanes[special_lanes]
        self.outcome[to] = judge_geometries(job.topology, job.structure, special)
        self.margin[to] = margins(job.structure, ends)
        if job.buildable:
            fine = self.outcome[to] == "special"
            self.outcome[to[fine & (self.margin[to] == 0.0)]] = "cannot be built"
        self.nullity[to], self.codimension[to] = ends.nullity, ends.codimension
        for k, row in enumerate(to.tolist()):
            self.text[row] = text_of_geometry(special.take(slice(k, k + 1)))


def text_of_geometry(geometry: LaneGeometry) -> str:
    """Write a geometry in one lane as JSON text."""
    points, axes = geometry.points[0].tolist(), geometry.axes[0].tolist()
    return json.dumps({"points": points, "axes": axes})


def geometry_of_text(text: str, structure: TopologyArrays | None = None) -> LaneGeometry:
    """Read a geometry, in one lane, from the column ``geometry``.

    Args:
        text: from `text_of_geometry`.
        structure: the topology that it is to be of.

    Raises:
        UsageError: the text is not that of a geometry, or of one of another topology.
    """
    try:
        data = json.loads(text)
        points, axes = (np.array(data[name], dtype=float) for name in ("points", "axes"))
    except (ValueError, TypeError, KeyError, IndexError, OverflowError, RecursionError):
        raise UsageError("the text of a geometry is damaged") from None
    joints = len(points) if structure is None else len(structure.parent)
    fine = points.shape == axes.shape == (joints, 3) and bool(np.isfinite(points).all())
    if not fine or not np.allclose(np.linalg.norm(axes, axis=1), 1.0, rtol=0.0, atol=UNIT):
        raise UsageError("the text of a geometry is not one of this topology")
    return LaneGeometry(points[None], axes[None])


def motion_splits(structure: TopologyArrays, geometry: LaneGeometry) -> Flags:
    """Tell which linkages have more freedoms than generic ones, at all poses around."""
    n = len(structure.parent)
    screws = structure.screws(geometry)
    more = np.ones(len(screws), bool)
    for direction in np.random.default_rng(3).standard_normal((WAYS, n)):
        q, count = freedoms(structure, screws, np.zeros((len(screws), n)), 0.0 * direction)
        for _ in range(2):
            more &= count > structure.width
            q, count = freedoms(structure, screws, q, 0.5 * WAY * direction)
        more &= count > structure.width
    return more


def random_starts(structure: TopologyArrays, seed: int, numbers: range) -> LaneGeometry:
    """Draw starts: normally distributed points, and directions that are equally likely.

    Args:
        seed: seed of all starts.
        numbers: numbers of the starts; a start depends on its number alone.
    """
    drawn = [_draw(structure, np.random.default_rng([seed, number])) for number in numbers]
    points, axes = (np.stack(arrays) for arrays in zip(*drawn, strict=True))
    return structure.normalise(LaneGeometry(points, axes))


def _starts_near(
    structure: TopologyArrays, origin: LaneGeometry, seed: int, numbers: range
) -> LaneGeometry:
    """Change a linkage by random amounts, from a hundredth of its size to all of it.

    Args:
        origin: the linkage, in one lane.
        seed: seed of all starts.
        numbers: numbers of the starts; 0 is the linkage itself.
    """
    count = len(structure.shifts)
    steps = []
    for number in numbers:
        rng = np.random.default_rng([seed, number])
        size = NEAREST * (FARTHEST / NEAREST) ** rng.random()
        steps.append((number > 0) * size * rng.standard_normal(count))
    many = LaneGeometry(*(np.repeat(array, len(steps), axis=0) for array in origin))
    return structure.change(many, np.stack(steps))


def _draw(structure: TopologyArrays, rng: np.random.Generator) -> tuple[Array, Array]:
    """Draw points and axes (joints, 3) of one start."""
    n = len(structure.parent)
    points = rng.standard_normal((structure.origin.max() + 1, 3))[structure.origin]
    axes = rng.standard_normal((n, 3))
    if structure.planar:
        points[:, 2] = axes[:, 2] = 0.0
        axes = np.where(structure.sliding[:, None], axes, np.eye(3)[2])
    axes[structure.free_axes] = np.tile(np.eye(3), (int(structure.free_axes.sum()) // 3, 1))
    return points, axes
