"""The places and directions of a linkage that have names: its joints, links and axes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from balance.transfers.serial_space import Transfers
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Joint, Linkage

__all__ = ["Described", "Direction", "Site", "directions", "distinct", "sites"]

Array = NDArray[np.float64]

# Distances relative to the size of the linkage, and sines of angles, that count as zero.
SAME = 1e-9
# How the names of directions begin that are normal to others.
NORMAL = "the normal to "


class Described(Protocol):
    """What is asked of a `DesignSpace` here."""

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies, in the order of the parameters."""
        ...

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters of one body."""
        ...

    @property
    def planar(self) -> bool:
        """Whether planar parameters are counted."""
        ...

    @property
    def balance(self) -> str:
        """``"dynamic"`` or ``"force"``."""
        ...

    @property
    def basis(self) -> Array:
        """Of the design space (parameters, nullity), SI units."""
        ...

    @property
    def scaled_basis(self) -> Array:
        """The same in the units of the chain, where its columns are orthonormal."""
        ...

    @property
    def serial_nullity(self) -> int:
        """How many columns of it, the first ones, are serial."""
        ...

    @property
    def axes(self) -> Array:
        """Rows are the axes of planar parameters (3, 3)."""
        ...

    @property
    def frames(self) -> Array:
        """Poses of the link frames of the bodies (bodies, 4, 4)."""
        ...

    @property
    def length(self) -> float:
        """Characteristic length, metres."""
        ...

    @property
    def linkage(self) -> Linkage:
        """The linkage."""
        ...

    @property
    def chain(self) -> Chain:
        """The joints that move as arrays."""
        ...

    @property
    def exchanged(self) -> Transfers:
        """Inertia transfers across joints, in the units of the chain."""
        ...


class Direction(NamedTuple):
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


class Site(NamedTuple):
    """A joint as a body sees it.

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


def sites(space: Described, body: int) -> list[Site]:
    """The moving joints at a body, one for every centre; those of loops come last."""
    chain, joints = space.chain, space.linkage.joints
    part = space.exchanged.part
    found: list[Site] = []
    for j, joint in enumerate(joints[k] for k in chain.joints):
        here = part[chain.links[body]] in (part[j], part[chain.parent[j]])
        if here and all(
            np.linalg.norm(joint.point - s.point) > SAME * space.length for s in found
        ):
            found.append(_site(joint))
    return found


def _site(joint: Joint) -> Site:
    """A joint by name, centre and axis; one of several degrees goes by its own name."""
    axis = joint.screw[3:] if joint.kind == "prismatic" else joint.screw[:3]
    return Site(joint.whole, joint.point, axis / np.linalg.norm(axis), joint.name)


def directions(space: Described, place: int, places: Sequence[Site]) -> list[Direction]:
    """Directions at one of the joints of a body: along its links and axes, and across them.

    Across is the vector product of the axis, or of the normal of the plane, with another.

    Args:
        space: whose axes count if it is planar.
        place: which of the joints.
        places: the joints of the body.
    """
    site = places[place]
    axis = Direction(site.axis, f"the axis of {site.label}")
    links = _links(place, places)
    if space.planar:
        n = space.axes[2]
        plain = distinct([*links, *([axis] if abs(site.axis @ n) < SAME else [])])
        crossed, end = plain, ""
    else:
        n = site.axis
        crossed = [*links, *(Direction(s.axis, f"the axis of {s.label}") for s in places)]
        plain = distinct([*links, axis])
        parallel = all(np.linalg.norm(np.cross(s.axis, n)) < SAME for s in places)
        end = "" if parallel else f" and {axis.name}"
    normals = [Direction(np.cross(n, d.along), f"{NORMAL}{d.name}{end}") for d in crossed]
    return distinct([*plain, *normals])


def _links(place: int, places: Sequence[Site]) -> list[Direction]:
    """From joint to joint, and to the middle of more than two."""
    site, found = places[place], []
    for k, other in enumerate(places):
        if k != place:
            first, second = (site, other) if place < k else (other, site)
            along = second.point - first.point
            found.append(Direction(along, f"{first.name}-{second.name}"))
    if len(places) > 2:
        middle = np.mean([other.point for other in places], axis=0)
        found.append(Direction(middle - site.point, f"{site.name}-middle"))
    return distinct(found)


def distinct(directions: Sequence[Direction]) -> list[Direction]:
    """Directions as unit vectors, without zeros and without repetitions, up to sign."""
    found: list[Direction] = []
    known = np.empty((0, 3))
    for direction in directions:
        size = float(np.linalg.norm(direction.along))
        if size <= SAME:
            continue
        a = direction.along / size
        off = np.minimum(abs(known - a).max(axis=1), abs(known + a).max(axis=1))
        if off.min(initial=1.0) > SAME:
            known = np.vstack([known, a])
            found.append(direction._replace(along=a))
    return found
