"""Named points and directions of a linkage: its joints, links and axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import GEOMETRY_EQUAL
from kinematics.model.linkage import Joint
from kinematics.numerics.linalg import vectors

Array = NDArray[np.float64]

# How the names of directions begin that are normal to others.
NORMAL = "the normal to "


class NamedDirection(NamedTuple):
    """A direction with a name.

    Attributes:
        along: unit vector (3,).
        name: such as ``"u1-q2"``, which points from u1 to q2, ``"the axis of u1"`` or
            ``"the normal to u1-q2"``.
    """

    along: Array
    name: str

    @property
    def normal(self) -> bool:
        """Whether it is normal to other directions."""
        return self.name.startswith(NORMAL)

    @property
    def adverb(self) -> str:
        """The name as it follows a noun: ``"along u1-q2"``, ``"across u1-q2"``."""
        return f"across {self.name[len(NORMAL) :]}" if self.normal else f"along {self.name}"


class NamedPoint(NamedTuple):
    """A joint of a body, as a point with an axis.

    Attributes:
        name: of the joint in the file.
        point: its centre (3,), metres.
        axis: unit vector along it (3,).
        label: name of the axis.
    """

    name: str
    point: Array
    axis: Array
    label: str


def named_points(space: DesignSpace, body: int) -> list[NamedPoint]:
    """List the moving joints at a body, one for every centre; those of loops come last.

    Args:
        body: number of the body.
    """
    chain, joints = space.chain, space.linkage.joints
    part = space.chain_transfers.rigid_part
    here = [
        joints[k]
        for j, k in enumerate(chain.joints)
        if part[chain.links[body]] in (part[j], part[chain.parent[j]])
    ]
    apart = GEOMETRY_EQUAL * space.length
    first = vectors.distinct_vectors(
        [joint.point for joint in here],
        lambda some, point: np.linalg.norm(some - point, axis=1) <= apart,
    )
    return [_named_point(here[k]) for k in first]


def _named_point(joint: Joint) -> NamedPoint:
    """Name a joint; one of several degrees goes by its own name."""
    axis = joint.screw[3:] if joint.kind == "prismatic" else joint.screw[:3]
    return NamedPoint(joint.whole, joint.point, axis / np.linalg.norm(axis), joint.name)


def named_directions(
    space: DesignSpace, place: int, places: Sequence[NamedPoint]
) -> list[NamedDirection]:
    """List directions at a joint of a body: along its links and axes, and across them.

    Across is the vector product of the axis, or of the normal of the plane, with another.

    Args:
        space: whose axes count if it is planar.
        place: number of the joint.
        places: the joints of the body.
    """
    site = places[place]
    axis = NamedDirection(site.axis, f"the axis of {site.label}")
    links = _link_directions(place, places)
    if space.planar:
        n = space.axes[2]
        plain = distinct_directions(
            [*links, *([axis] if abs(site.axis @ n) < GEOMETRY_EQUAL else [])]
        )
        crossed, end = plain, ""
    else:
        n = site.axis
        crossed = [*links, *(NamedDirection(s.axis, f"the axis of {s.label}") for s in places)]
        plain = distinct_directions([*links, axis])
        parallel = all(np.linalg.norm(np.cross(s.axis, n)) < GEOMETRY_EQUAL for s in places)
        end = "" if parallel else f" and {axis.name}"
    normals = [NamedDirection(np.cross(n, d.along), f"{NORMAL}{d.name}{end}") for d in crossed]
    return distinct_directions([*plain, *normals])


def _link_directions(place: int, places: Sequence[NamedPoint]) -> list[NamedDirection]:
    """List directions from joint to joint, and to the middle of more than two."""
    site, directions = places[place], []
    for k, other in enumerate(places):
        if k != place:
            first, second = (site, other) if place < k else (other, site)
            along = second.point - first.point
            directions.append(NamedDirection(along, f"{first.name}-{second.name}"))
    if len(places) > 2:
        middle = np.mean([other.point for other in places], axis=0)
        directions.append(NamedDirection(middle - site.point, f"{site.name}-middle"))
    return distinct_directions(directions)


def distinct_directions(directions: Sequence[NamedDirection]) -> list[NamedDirection]:
    """Normalise directions, and remove zeros and repetitions up to sign."""
    unit = [
        direction._replace(along=direction.along / size)
        for direction in directions
        if (size := float(np.linalg.norm(direction.along))) > GEOMETRY_EQUAL
    ]
    first = vectors.distinct_vectors([direction.along for direction in unit], _opposite_or_same)
    return [unit[k] for k in first]


def _opposite_or_same(some: Array, vector: Array) -> NDArray[np.bool_]:
    """Mark the unit vectors (k, 3) that equal another one (3,), up to sign."""
    apart = np.minimum(abs(some - vector).max(axis=1), abs(some + vector).max(axis=1))
    return np.asarray(apart <= GEOMETRY_EQUAL)
