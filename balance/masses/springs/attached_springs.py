"""Springs attached to a linkage: their points in the frame and units of a chain."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.springs.spring_text import SpringEnd, SpringText
from kinematics.closure.joint_positions import input_chain
from kinematics.error_text import did_you_mean
from kinematics.errors import BodyError, LinkageError, UsageError
from kinematics.model.linkage import GROUND, Linkage, LinkPose
from kinematics.numerics.array_types import Array
from kinematics.wording import without_round_off


class AttachedEnd(NamedTuple):
    """One end of a spring.

    Attributes:
        link: the rigid body that it is on; -1 is the ground.
        middle: the point, or the middle of the box that it may be in, (3,), at the reference
            pose, in the frame and units of the chain.
        axes: half edges of that box as rows (free, 3), likewise.
    """

    link: int
    middle: Array
    axes: Array


class AttachedSpring(NamedTuple):
    """A spring between two links.

    Attributes:
        asked: the text that asks for it.
        ends: its two ends.
        lengths: least and greatest free length, in the units of the chain; both 0 unless both
            ends are given.
    """

    asked: SpringText
    ends: tuple[AttachedEnd, AttachedEnd]
    lengths: tuple[float, float] = (0.0, 0.0)

    @property
    def free(self) -> int:
        """Number of coordinates and free lengths that are to be found."""
        return sum(len(end.axes) for end in self.ends) + self.any_length

    @property
    def any_length(self) -> bool:
        """Whether the free length is to be found."""
        return self.lengths[0] < self.lengths[1]

    @property
    def paired(self) -> bool:
        """Whether both ends are free, so that products of their coordinates are unknowns."""
        return all(len(end.axes) for end in self.ends)

    @property
    def columns(self) -> int:
        """Number of unknowns: k, k s_i of the first end, k t_j of the second, k s_i t_j.

        Where the free length is to be found: k, and k times its place in its range.
        """
        first, second = (len(end.axes) for end in self.ends)
        return (1 + first) * (1 + second) + self.any_length

    def with_length(self, length: float) -> tuple[AttachedSpring, Array]:
        """Fix the free length.

        Args:
            length: in the units of the chain, within the range.

        Returns:
            The spring, and the matrix from its unknowns to those of this one.
        """
        spring, count = self._replace(lengths=(length, length)), self.columns
        if not self.any_length:
            return spring, np.eye(count)
        low, high = self.lengths
        return spring, np.array([[1.0], [(2.0 * length - low - high) / (high - low)]])

    def fixed(self, end: int, shares: Array) -> AttachedSpring:
        """Fix one end at coordinates in its box."""
        ends = list(self.ends)
        there = ends[end]
        ends[end] = there._replace(
            middle=there.middle + shares @ there.axes, axes=there.axes[:0]
        )
        return self._replace(ends=(ends[0], ends[1]))

    def spread(self, end: int, shares: Array) -> Array:
        """Compute all unknowns (columns, n) from those with one end fixed (n,).

        Args:
            end: the end that is fixed, 0 or 1.
            shares: its coordinates.
        """
        factors = [np.eye(1 + len(self.ends[k].axes)) for k in range(2)]
        factors[end] = np.append(1.0, shares)[:, None]
        table = np.einsum("iI,jJ->ijIJ", *factors)
        rows = [(0, 0), *((i, 0) for i in range(1, len(table)))]
        rows += [(0, j) for j in range(1, table.shape[1])]
        rows += [(i, j) for i in range(1, len(table)) for j in range(1, table.shape[1])]
        return np.array([table[i, j].reshape(-1) for i, j in rows])


def attach_springs(
    linkage: Linkage, springs: Sequence[SpringText]
) -> tuple[AttachedSpring, ...]:
    """Attach springs to a linkage.

    Where a text names links alone, the spring ends at the centre of mass of its second link,
    and anywhere within a characteristic length about the joint by which that link hangs on
    the first one.

    Raises:
        BodyError: a link is unknown, or has no mass where its centre is asked for.
        LinkageError: both ends are on one rigid body.
        UsageError: nothing says where an end is, or one with a free length may be anywhere.
    """
    return tuple(_attach(linkage, spring) for spring in springs)


def place_of(linkage: Linkage, name: str) -> LinkPose:
    """Find a link of the file by its name.

    Raises:
        BodyError: there is none.
    """
    if name not in linkage.places:
        raise BodyError(
            linkage.source,
            name,
            f"there is no such link{did_you_mean(name, linkage.places)}; "
            f"the links are {', '.join(linkage.places)}",
        )
    return linkage.places[name]


def _attach(linkage: Linkage, spring: SpringText) -> AttachedSpring:
    """Attach one spring."""
    first, second = spring.ends
    places = [place_of(linkage, end.link) for end in spring.ends]
    if places[0].link == places[1].link:
        raise LinkageError(
            f"{linkage.source}: spring '{spring.text}': both ends are on one rigid body: name "
            "two links that move against each other"
        )
    far = second.box or _mass_centre(linkage, spring, places[1])
    near = first.box or _box_about_joint(linkage, places, spring)
    ends = [_end(linkage, place, box) for place, box in zip(places, (near, far), strict=True)]
    asked = spring._replace(ends=(SpringEnd(first.link, near), SpringEnd(second.link, far)))
    low, high = spring.length or (0.0, 0.0)
    if (low or high) and any(len(end.axes) for end in ends):
        raise UsageError(
            f"{linkage.source}: spring '{spring.text}': a spring with a free length has one "
            f"point at each end, such as {first.link}@0,0,0.1 {second.link}@0.2,0,0: its "
            "energy has the root of a distance, which in every pose only a spring between the "
            "same points takes up; to find points leave the free length out, as a string over "
            "a pulley does, or a pair with k1 L1 + k2 L2 = 0"
        )
    unit = input_chain(linkage).frame.length
    return AttachedSpring(asked, (ends[0], ends[1]), (low / unit, high / unit))


def _end(linkage: Linkage, place: LinkPose, box: Sequence[tuple[float, float]]) -> AttachedEnd:
    """Carry a box of a link frame to the reference pose, in the frame of the chain."""
    frame = input_chain(linkage).frame
    low, high = np.array(box).T
    middle = place.pose[:3, :3] @ (0.5 * (low + high)) + place.pose[:3, 3]
    half = (0.5 * (high - low))[:, None] * place.pose[:3, :3].T
    axes = half[high > low] @ frame.R.T / frame.length
    return AttachedEnd(place.link, frame.R @ (middle - frame.origin) / frame.length, axes)


def _mass_centre(
    linkage: Linkage, spring: SpringText, place: LinkPose
) -> tuple[tuple[float, float], ...]:
    """Find the centre of mass of a link, in the frame of the link."""
    body = next((b for b in linkage.bodies if b.link == place.link), None)
    if body is None or not body.inertia[0] > 0.0:
        name = spring.ends[1].link
        raise BodyError(
            linkage.source,
            name,
            "has no mass, so no centre that a spring can end at; give "
            f"the spring a point, such as {name}@0.1,0,0",
        )
    centre = body.inertia[1:4] / body.inertia[0]
    local = place.pose[:3, :3].T @ (centre - place.pose[:3, 3])
    local = without_round_off(local, input_chain(linkage).frame.length)
    return tuple((x, x) for x in local.tolist())


def _box_about_joint(
    linkage: Linkage, places: Sequence[LinkPose], spring: SpringText
) -> tuple[tuple[float, float], ...]:
    """Make the box about the joint by which the second link hangs on the first.

    It is the joint on the way from the second link down to the first; if the first link is
    not on that way, the joint that carries the second.
    """
    first, link = places[0].link, places[1].link
    if link == GROUND:
        raise UsageError(
            f"{linkage.source}: spring '{spring.text}': name the ground first, or give both "
            "ends a point"
        )
    top = link
    while top != GROUND and linkage.joints[top].parent != first:
        top = linkage.joints[top].parent
    joint = linkage.joints[link if top == GROUND else top]
    pose, length = places[0].pose, input_chain(linkage).frame.length
    local = without_round_off(pose[:3, :3].T @ (joint.point - pose[:3, 3]), length)
    return tuple((x - length, x + length) for x in local.tolist())
