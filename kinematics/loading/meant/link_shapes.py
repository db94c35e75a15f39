"""Distances of parallel joints on one link, from the decimals of a file, without round-off.

The pose of a linkage is that at which its loops close, to round-off or to the digits of the
file. The shape of a link is that of its own numbers.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

from kinematics.files.urdf.rational_joints import RationalJoints
from kinematics.files.urdf.rational_poses import RationalPose
from kinematics.loading.meant.link_widths import LinkWidths
from kinematics.model.document.element import Element
from kinematics.model.linkage import Linkage
from kinematics.numerics.linalg.rational import Vector, add_vectors, decimal, dot


class _Axis(NamedTuple):
    """An axis on a link: point and direction (3,), in the frame of the link called root."""

    root: str
    point: Vector
    direction: Vector


class LinkShapes:
    """Axes on the rigid links of a linkage, computed when they are asked for."""

    def __init__(self, linkage: Linkage, widths: LinkWidths) -> None:
        """Read the elements of a file.

        Args:
            linkage: a linkage that was read from a file.
            widths: the half widths of its joints, with the numbers of its rigid links.
        """
        assert linkage.tree is not None
        self._reader = _Reader(linkage.tree)
        self._names = [joint.whole for joint in linkage.joints]
        self._links = widths.links
        self._axes: dict[tuple[int, int], _Axis] = {}

    def square_of_distance(self, link: int, joint: int, other: int) -> Fraction | None:
        """Compute the squared distance of two parallel axes on a link.

        Args:
            link: number of the rigid link, as in `LinkWidths.links`.
            joint: number of the joint whose axis is the normal of the plane.
            other: number of another joint.

        Returns:
            The square, square metres; None if the link is welded of parts by loops.
        """
        p, q = self._axis(link, joint), self._axis(link, other)
        if p is None or q is None or p.root != q.root:
            return None
        w = add_vectors(q.point, p.point, -1)
        return dot(w, w) - dot(w, p.direction) ** 2 / dot(p.direction, p.direction)

    def _axis(self, link: int, joint: int) -> _Axis | None:
        """Place the axis of a joint on a link; None if the file does not have the joint."""
        if (link, joint) not in self._axes:
            ends = self._reader.ends(self._names[joint])
            for each, end in zip(self._links[joint], ends, strict=False):
                self._axes[each, joint] = end
        return self._axes.get((link, joint))


class _Reader:
    """Axes of the joints and loops of a file on their links."""

    def __init__(self, tree: Element) -> None:
        """Read the elements of a file."""
        self._poses = RationalJoints(replace(tree, children=()))
        self._items = {item.name: item for item in tree.every("joint") + tree.every("loop")}
        self._carrier = {item.link_at("child"): item for item in tree.every("joint")}

    def ends(self, name: str) -> tuple[_Axis, ...]:
        """Place the axis of a joint on the link before it and on that after it."""
        item = self._items.get(name)
        if item is None:
            return ()
        axis = item.first("axis")
        words = "1 0 0" if axis is None else axis.attributes.get("xyz", "1 0 0")
        n = tuple(decimal(word) for word in words.split())
        if item.tag == "joint":
            near = self._place(item, item.link_at("parent"), n)
            return near, self._place(None, item.link_at("child"), n)
        return tuple(
            self._place(end, end.attributes.get("link", ""), n)
            for end in (item.first(role) or item for role in ("predecessor", "successor"))
        )

    def _place(self, item: Element | None, link: str, n: Vector) -> _Axis:
        """Place an axis at an origin on a link."""
        pose = self._origin(item)
        while link in self._carrier and self._carrier[link].attributes["type"] == "fixed":
            pose = self._origin(self._carrier[link]) @ pose
            link = self._carrier[link].link_at("parent")
        return _Axis(link, pose.d, pose.turn(n))

    def _origin(self, item: Element | None) -> RationalPose:
        """Pose of the origin of an element."""
        return self._poses.origin_pose("", None if item is None else item.first("origin"))
