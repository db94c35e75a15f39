"""Paths of parameters, such as ``q2.origin.x``, and the sites of a model that they change.

A site is a frame of the file: the ``<origin>`` of a joint, or that of one side of a loop. A
path names a number of a site, the length of a link, which is the distance of its two sites, or
a number of its ``<inertial>``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from kinematics.error_text import closest_names, did_you_mean
from kinematics.errors import UsageError
from kinematics.files.urdf.loop_joints import unit_vector
from kinematics.files.urdf.robot_tree import Inertial, describe_robot, pose_matrix
from kinematics.model.document.element import Element
from kinematics.model.linkage import UnassembledLinkage
from kinematics.numerics.array_types import Array

COMPONENTS = ("x", "y", "z", "roll", "pitch", "yaw")
SIDES = ("predecessor", "successor")
MASSES = ("mass_per_length", "mass", "com", "inertia")
"""Kinds of places that change the masses, and leave all frames where they are; the first is
that of a whole uniform bar, which the others may change again."""
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


class PathError(ValueError):
    """A path that names no number of the model; the message says why."""


class NumberPlace(NamedTuple):
    """What a path names.

    Attributes:
        kind: ``"origin"``, ``"axis"`` or ``"length"``; or one of `MASSES`.
        site: number of the site that changes, or of the link.
        component: of the origin, 0 to 5; of the axis or the centre of mass, 0 to 2; of the
            moments of inertia, 0 to 5 as in `MOMENTS`.
        other: of a length: the site that it is measured from, -1 for the frame of the link.
        end: of a mass per length: the site at the other end.
    """

    kind: str
    site: int
    component: int = 0
    other: int = -1
    end: int = -1


class Site(NamedTuple):
    """A frame of the file that a study can move.

    Attributes:
        owner: name of the joint or loop.
        side: ``""`` for a joint, ``"predecessor"`` or ``"successor"``.
        link: name of the link in whose frame it is.
        child: name of the link that a joint carries; empty for a loop.
        kind: type of the joint or loop.
        origin: x, y, z, roll, pitch, yaw; metres and radians (6,).
        axis: unit vector (3,).
    """

    owner: str
    side: str
    link: str
    child: str
    kind: str
    origin: Array
    axis: Array

    @property
    def label(self) -> str:
        """Name of the frame in paths."""
        return f"{self.owner}.{self.side}" if self.side else self.owner

    @property
    def pose(self) -> Array:
        """Pose in the frame of the link (4, 4)."""
        xyz, rpy = (" ".join(map(repr, part.tolist())) for part in np.split(self.origin, 2))
        return pose_matrix(Element("origin", {"xyz": xyz, "rpy": rpy}))


class Sites(NamedTuple):
    """All sites of a model.

    Attributes:
        sites: joints with their parents first, then both sides of each loop.
        root: name of the link that is the ground.
        links: names of all links.
        inertials: mass, centre of mass and inertia about it in the frame of the link, of those
            that have them: numbers (10,) in this order, the last as in `MOMENTS`.
    """

    sites: tuple[Site, ...]
    root: str
    links: tuple[str, ...]
    inertials: Mapping[str, Array]

    def find(self, path: str) -> NumberPlace:
        """Find what a path names.

        Args:
            path: ``JOINT.origin.x``, ``JOINT.axis.x``, ``LOOP.predecessor.origin.x``,
                ``LOOP.axis.x``, ``LINK.length``, ``LINK.mass``, ``LINK.com.x``,
                ``LINK.inertia.ixx`` or ``LINK.mass_per_length``.

        Returns:
            The place.

        Raises:
            PathError: there is no such joint, loop or link, or it has no such number.
        """
        head, _, last = path.rpartition(".")
        if last == "length" and head in self.links:
            return self._length(head)
        if last == "mass_per_length" and head in self.inertials:
            bar = self._length(head)
            return NumberPlace(last, self.links.index(head), other=bar.other, end=bar.site)
        if last == "mass" and head in self.inertials:
            return NumberPlace("mass", self.links.index(head))
        owner, _, group = head.rpartition(".")
        if owner in self.inertials and last in {"com": "xyz", "inertia": MOMENTS}.get(
            group, ()
        ):
            names = MOMENTS if group == "inertia" else COMPONENTS
            return NumberPlace(group, self.links.index(owner), names.index(last))
        labels = [site.label for site in self.sites]
        if group == "origin" and last in COMPONENTS and owner in labels:
            return NumberPlace("origin", labels.index(owner), COMPONENTS.index(last))
        first = owner if owner in labels else f"{owner}.predecessor"
        if group == "axis" and last in COMPONENTS[:3] and first in labels:
            return self._axis(labels.index(first), COMPONENTS.index(last))
        raise PathError(self._why_not(path))

    def value(self, place: NumberPlace) -> float:
        """Compute the value of a number in the model; metres, radians."""
        if place.kind == "mass_per_length":
            mass = self.inertials[self.links[place.site]][0]
            return float(mass / np.linalg.norm(self.span(place)))
        if place.kind in MASSES:
            numbers = self.inertials[self.links[place.site]]
            return float(numbers[self.inertial_entry(place)])
        site = self.sites[place.site]
        if place.kind == "length":
            return float(np.linalg.norm(self.span(place)))
        return float((site.axis if place.kind == "axis" else site.origin)[place.component])

    @staticmethod
    def inertial_entry(place: NumberPlace) -> int:
        """Number of a place among the ten numbers of an inertial."""
        return {"mass": 0, "com": 1, "inertia": 4}[place.kind] + place.component

    def span(self, place: NumberPlace) -> Array:
        """Compute the vector (3,) of a length, in the frame of its link; metres."""
        start, end = self.ends(place, {})
        return np.asarray(end - start)

    def ends(self, place: NumberPlace, origins: Mapping[int, Array]) -> tuple[Array, Array]:
        """Return both ends (3,) of a length or of a bar, in the frame of its link; metres.

        Args:
            origins: of the sites that have others than in the model.
        """
        here, there = (
            np.zeros(3) if k < 0 else origins.get(k, self.sites[k].origin)[:3]
            for k in (place.other, place.site if place.kind == "length" else place.end)
        )
        return here, there

    def sites_on(self, link: str) -> list[int]:
        """List the numbers of the sites in the frame of a link."""
        return [k for k, site in enumerate(self.sites) if site.link == link]

    def _axis(self, site: int, component: int) -> NumberPlace:
        if self.sites[site].kind in ("fixed", "spherical", "floating"):
            owner, kind = self.sites[site].owner, self.sites[site].kind
            raise PathError(f"'{owner}' is {kind}: it has no axis that matters")
        return NumberPlace("axis", site, component)

    def _length(self, link: str) -> NumberPlace:
        """Find the two ends of a link."""
        sites = self.sites_on(link)
        ends = sites if link == self.root else [-1, *sites]
        if len(ends) != 2:
            count = f"{len(ends)} joints" if len(ends) != 1 else "one joint"
            raise PathError(
                f"link '{link}' has {count}, and a length only lies between two; vary origins"
            )
        place = NumberPlace("length", ends[1], other=ends[0])
        if not self.span(place).any():
            raise PathError(f"link '{link}' has length 0: no direction to lengthen it in")
        return place

    def _why_not(self, path: str) -> str:
        """Explain why a path names nothing."""
        owners = list(dict.fromkeys(site.owner for site in self.sites))
        name = next((x for x in [*owners, *self.links] if f"{path}.".startswith(f"{x}.")), None)
        if name is None:
            head, known = path.partition(".")[0], [*owners, *self.links]
            meant, choices = did_you_mean(head, known), closest_names(head, known)
            return f"names no joint, loop or link{meant}; there are {choices}"
        if name not in owners:
            more = ", mass, com.x|y|z, inertia.ixx|…, mass_per_length"
            more = more if name in self.inertials else ""
            return f"link '{name}' has the numbers length{more}"
        fields = "origin.x|y|z|roll|pitch|yaw, axis.x|y|z"
        if any(site.side for site in self.sites if site.owner == name):
            fields = "predecessor.origin.x|y|z|roll|pitch|yaw, successor.origin.…, axis.x|y|z"
        return f"'{name}' has the numbers {fields}"


def read_sites(linkage: UnassembledLinkage) -> Sites:
    """Read the sites of a model from the elements of its file.

    Args:
        linkage: a linkage that was read from a file.

    Raises:
        UsageError: it was made without one.
    """
    if linkage.tree is None:
        raise UsageError(
            f"{linkage.source}: it has no elements of a file whose numbers could vary; write "
            "it by to_urdf() and load that"
        )
    joints = linkage.tree.every("joint")
    children = {joint.link_at("child") for joint in joints}
    links = tuple(link.name for link in linkage.tree.every("link"))
    root = next(name for name in links if name not in children)
    sites = [*_in_order(joints, root), *_loop_sites(linkage.tree)]
    inertials = {
        name: np.array(
            [
                part.mass,
                *part.origin[:3, 3],
                *part.inertia.diagonal(),
                *part.inertia[[0, 0, 1], [1, 2, 2]],
            ]
        )
        for name, part in _turned_inertials(linkage).items()
    }
    return Sites(tuple(sites), root, links, inertials)


def _turned_inertials(linkage: UnassembledLinkage) -> dict[str, Inertial]:
    """Read the inertials of all links, along the axes of the frame of the link."""
    assert linkage.tree is not None
    inertials = {}
    for name, part in describe_robot(linkage.tree).links.items():
        if part is not None:
            R = part.origin[:3, :3]
            origin = np.eye(4)
            origin[:3, 3] = part.origin[:3, 3]
            inertials[name] = Inertial(part.mass, R @ part.inertia @ R.T, origin)
    return inertials


def _in_order(joints: list[Element], root: str) -> Iterator[Site]:
    """Yield the sites of the joints of the tree, parents first."""
    reached, pending = {root}, joints
    while pending:
        later = []
        for joint in pending:
            if joint.link_at("parent") not in reached:
                later.append(joint)
                continue
            child = joint.link_at("child")
            reached.add(child)
            yield _site(joint, joint, "", joint.link_at("parent"), child)
        pending = later


def _loop_sites(tree: Element) -> Iterator[Site]:
    """Yield both sides of each loop."""
    for loop in tree.every("loop"):
        for side in SIDES:
            part = loop.first(side) or loop
            yield _site(loop, part, side, part.attributes["link"], "")


def _site(item: Element, part: Element, side: str, link: str, child: str) -> Site:
    """Make the site of a joint, or of one side of a loop."""
    origin, axis = part.first("origin"), item.first("axis")
    numbers = [0.0] * 6
    if origin is not None:
        numbers = origin.vector("xyz", "0 0 0") + origin.vector("rpy", "0 0 0")
    n = unit_vector(axis.vector("xyz", "") if axis is not None else [1.0, 0.0, 0.0])
    kind = item.attributes["type"]
    return Site(item.name, side, link, child, kind, np.array(numbers), n)
