"""Half widths of the intervals in which the joints of a link lie, from the digits of a file."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt
from typing import NamedTuple

import numpy as np

from kinematics.files.urdf.nominal_angles import nearest_twelfth
from kinematics.loading.meant.digits import DOUBLE_DIGITS, FileDigits
from kinematics.model.chain import extent
from kinematics.model.document.element import Element
from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.array_types import Array

# Round-off of the position of a joint, in parts of the size of the linkage, and of directions:
# products of a dozen rotations. Special linkages in doubles, turned at random, are off by up to
# a quarter of it.
ROUND_OFF = 2.0**-50


class Width(NamedTuple):
    """Half widths of a joint on a link.

    Attributes:
        box: half edges of the box in which its place lies, each a vector (3,), metres,
            inertial frame.
        rest: radius of a ball of further errors of its place, metres.
        angle: half width of its direction, radians.
    """

    box: tuple[tuple[float, ...], ...] = ()
    rest: float = 0.0
    angle: float = 0.0

    def __add__(self, other: Width) -> Width:  # type: ignore[override]
        """Add half widths: intervals of sums."""
        return Width(self.box + other.box, self.rest + other.rest, self.angle + other.angle)

    @property
    def place(self) -> float:
        """Half diagonal of the box, and the rest, metres."""
        squares = (x * x for edge in self.box for x in edge)
        return sqrt(sum(squares)) + self.rest

    def along(self, u: Array) -> float:
        """Compute the half width of the place along a direction, metres.

        Args:
            u: unit vector (3,).
        """
        return float(sum(abs(np.array(edge) @ u) for edge in self.box)) + self.rest


class LinkWidths(NamedTuple):
    """Half widths of the joints on each rigid link of a linkage.

    Attributes:
        links: rigid links before and after each joint; welded links have one number.
        widths: half widths by link and joint.
        whole: those of the whole linkage: of a position that all numbers decide.
        closed: whether the loops were closed by Newton's method, so that each link has the
            shape of the file; otherwise the links on which loops end have shapes that all
            numbers decide.
        round_off: of positions, metres.
        exact: whether the numbers have fewer digits than doubles, so that errors of lengths
            are compared with their widths without round-off.
    """

    links: tuple[tuple[int, int], ...]
    widths: Mapping[tuple[int, int], Width]
    whole: Width
    closed: bool
    round_off: float
    exact: bool

    def of(self, link: int, joint: int) -> Width:
        """Find the half widths of a joint on a link.

        Args:
            link: number of the rigid link.
            joint: number of the joint.
        """
        return self.widths.get((link, joint), Width())

    @property
    def angle(self) -> float:
        """Half width of the angle between two axes of the linkage."""
        return self.whole.angle + ROUND_OFF

    @property
    def place(self) -> float:
        """Half width of the distance between two joints of the linkage."""
        return self.whole.place + self.round_off


def link_widths(linkage: Linkage, digits: FileDigits) -> LinkWidths:
    """Compute the half widths of all joints on their links.

    Args:
        linkage: a linkage that was read from a file.
        digits: the digits of the numbers of the file.
    """
    assert linkage.tree is not None
    size = max(extent(linkage).length, 1e-300)
    turned = {name: place.pose[:3, :3] for name, place in linkage.places.items()}
    reader = _Reader(linkage.tree, digits, size, turned)
    links = _rigid_links(linkage)
    widths: dict[tuple[int, int], Width] = {}
    place = angle = 0.0
    for j, joint in enumerate(linkage.joints):
        near, far = reader.sides(joint.whole)
        before, after = links[j]
        first = joint.parent == GROUND or linkage.joints[joint.parent].whole != joint.whole
        widths[before, j] = near if first else Width()
        widths[after, j] = far
        both = (near if first else Width()) + far
        place, angle = place + both.place, angle + both.angle
    middle = np.mean([joint.point for joint in linkage.joints], axis=0)
    far_size = size + float(np.abs(middle).max())
    whole = Width((), place + angle * size, angle)
    return LinkWidths(
        links,
        widths,
        whole,
        linkage.displaced is not None,
        ROUND_OFF * far_size,
        digits.significant < DOUBLE_DIGITS,
    )


def _rigid_links(linkage: Linkage) -> tuple[tuple[int, int], ...]:
    """Number the links before and after each joint, welded ones alike."""
    of = {link: link for link in range(-1, len(linkage.joints))}

    def find(link: int) -> int:
        while of[link] != link:
            link = of[link]
        return link

    for loop in linkage.loops:
        ends = sorted((find(loop.end), find(loop.successor)))
        of[ends[1]] = ends[0]
    return tuple((find(joint.parent), find(j)) for j, joint in enumerate(linkage.joints))


class _Reader:
    """Half widths of the joints and loops of a file."""

    def __init__(
        self, tree: Element, digits: FileDigits, size: float, turned: Mapping[str, Array]
    ) -> None:
        """Read the elements of a file.

        Args:
            size: lever of angles, metres.
            turned: rotation (3, 3) of each link at the reference pose.
        """
        self._digits, self._size, self._turned = digits, size, turned
        self._items = {item.name: item for item in tree.every("joint") + tree.every("loop")}
        self._carrier = {item.link_at("child"): item for item in tree.every("joint")}

    def sides(self, name: str) -> tuple[Width, Width]:
        """Compute the half widths of a joint on the link before it and on that after it."""
        item = self._items.get(name)
        if item is None:
            return Width(), Width()
        axis = self._axis(item)
        if item.tag == "joint":
            return self._at(item, item.link_at("parent")) + axis, axis
        ends = (item.first(role) or item for role in ("predecessor", "successor"))
        near, far = (self._at(end, end.attributes.get("link", "")) + axis for end in ends)
        return near, far

    def _at(self, item: Element, link: str) -> Width:
        """Half widths of an origin on a link, and of the fixed joints that carry it."""
        return self._origin(item, link) + self._fixed(link)

    def _fixed(self, link: str) -> Width:
        """Add up the half widths of the fixed joints that carry a link."""
        total = Width()
        while link in self._carrier and self._carrier[link].attributes["type"] == "fixed":
            carrier = self._carrier[link]
            link = carrier.link_at("parent")
            origin = self._origin(carrier, link)
            total += Width(origin.box, origin.rest + origin.angle * self._size, origin.angle)
        return total

    def _origin(self, item: Element, link: str) -> Width:
        """Half widths of an origin in the frame of a link."""
        origin = item.first("origin")
        if origin is None:
            return Width()
        words = origin.attributes.get("xyz", "").split()
        R = self._turned.get(link, np.eye(3))
        box = tuple(
            tuple((self._digits.half_unit(word) * edge).tolist())
            for word, edge in zip(words, R.T, strict=False)
        )
        turns = origin.attributes.get("rpy", "").split()
        angle = sum(self._digits.half_unit(x, False) for x in turns if not nearest_twelfth(x))
        return Width(box, 0.0, angle)

    def _axis(self, item: Element) -> Width:
        """Half widths of the direction of an axis."""
        axis = item.first("axis")
        if axis is None:
            return Width()
        words = axis.attributes.get("xyz", "1 0 0")
        length = sqrt(sum(float(x) ** 2 for x in words.split()))
        return Width((), 0.0, self._half_units(words) / length)

    def _half_units(self, words: str) -> float:
        """Root of the sum of squares of half units of a direction."""
        return sqrt(sum(self._digits.half_unit(x, False) ** 2 for x in words.split()))
