"""Read a linkage as it is meant: with the special geometry that lies inside its digits.

Between a joint and the next one on its path to the ground, and between joints of one link,
three numbers are constant in any motion: the angle between their axes, their distance, and how
far along an axis its common normals with its neighbours are apart. Where one of them is a right
angle or zero inside its interval, it is so exactly in the screws that are returned. Joints are
taken parents first, and related to earlier ones in an order in which no relation contradicts
another.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from kinematics.closure.assembly.assemble import assemble_mode
from kinematics.errors import LinkageError
from kinematics.files.urdf.rational_screws import exact_geometry
from kinematics.loading.meant.digits import EXACT, MIN_DIGITS, FileDigits, file_digits
from kinematics.loading.meant.exact_screws import exact_screws, find_figures
from kinematics.loading.meant.four_joint_loops import LinkRelation
from kinematics.loading.meant.link_widths import LinkWidths, link_widths
from kinematics.model.arrays import freeze
from kinematics.model.chain import extent
from kinematics.model.linkage import GROUND, Joint, Linkage, MeantGeometry, Notice
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import (
    Vector,
    add_vectors,
    cross,
    dot,
    nearby_fraction,
    nearby_vector,
    part_across,
    root,
)
from kinematics.numerics.linalg.rational_directions import (
    nearby_unit_vector,
    nearby_unit_vector_across,
)
from kinematics.numerics.tolerances import EXACT_SCREW_DIFFERENCE, MEANT_DIFFERENCE
from kinematics.wording import size_text

# Nearness, in half widths of the intervals, up to which a special geometry outside of them is
# named: it may be meant, or missed on purpose.
NEAR = 30.0
# The same, up to which a relation is one of the decimals: tilts of round-off change lengths by
# their squares.
HELD_AS_WRITTEN = 1e-9
# The same as `NEAR` for axes of open chains, in radians and parts of the size: six digits,
# with which exporters write absolute poses, from which relative ones get more digits.
NEAR_OPEN = 1e-5


def as_meant(linkage: Linkage, *, exactly: bool = False, again: bool = True) -> Linkage:
    """Move the axes of a linkage to the special geometry inside the digits of its file.

    Args:
        exactly: whether its numbers count as written: axes are made exactly parallel, or
            exactly meet, where they are up to round-off, and no more.
        again: whether to start again if the linkage assembles at another pose.

    Returns:
        The linkage, with ``meant`` where its loops are planar or spherical and its numbers are
        rounded; its axes are moved where a special geometry lies inside all intervals.
    """
    if linkage.tree is None:
        return linkage
    # Loops that close only to rounding show that short numbers are rounded, too.
    mended = any(notice.code == "closes_to_rounding" for notice in linkage.notices)
    digits = file_digits(linkage.tree, 0 if mended else MIN_DIGITS)
    if digits is None and linkage.displaced is None:
        return linkage
    if exactly and _has_exact_numbers(linkage):
        return linkage
    if digits is None or (exactly and linkage.displaced is not None):
        # Numbers are exact, and so are the links; only another pose is rounded.
        digits = EXACT
    widths = link_widths(linkage, digits)
    if not linkage.loops and not exactly:
        return _open_chain_as_meant(linkage, digits, widths, again)
    figures = find_figures(linkage, widths, NEAR)
    if not figures:
        return linkage
    if exactly:
        screws, _ = exact_screws(linkage, widths, figures, HELD_AS_WRITTEN)
        written = MeantGeometry(
            screws, screws, None, (), (), digits.significant, 0.0, 0.0, True
        )
        return replace(linkage, meant=written) if _is_near(linkage, screws) else linkage
    plain, _ = exact_screws(linkage, widths, figures, HELD_AS_WRITTEN)
    screws, wider = plain, plain
    inside: list[LinkRelation] = []
    all_relations: list[LinkRelation] = []
    if any(figure.relations for figure in figures):
        screws, inside = exact_screws(linkage, widths, figures, 1.0)
        wider, all_relations = exact_screws(linkage, widths, figures, NEAR)
    near = [relation for relation in all_relations if relation not in inside]
    shown = near or inside
    meant = MeantGeometry(
        screws=screws,
        plain=plain,
        near=wider if near else None,
        relations=tuple(_words(linkage, relation) for relation in inside),
        near_relations=tuple(_words(linkage, relation) for relation in near),
        digits=min(digits.significant, 17),
        distance=max((relation.error for relation in shown), default=0.0),
        nearness=max((relation.nearness for relation in shown), default=0.0),
        in_decimals=all(relation.error == 0.0 for relation in inside),
        apart=len(linkage.joints) - len({j for x in inside for j in _joints_of(x)}),
    )
    return _with_screws(linkage, meant, again)


def _has_exact_numbers(linkage: Linkage) -> bool:
    """Whether screws are those of the decimals of the file: it has no angles to round."""
    try:
        return linkage.displaced is None and not exact_geometry(linkage).notices
    except LinkageError:
        return False


def _open_chain_as_meant(
    linkage: Linkage, digits: FileDigits, widths: LinkWidths, again: bool
) -> Linkage:
    """Move the axes of an open chain to the special geometry inside the digits."""
    size = max(extent(linkage).length, 1e-300)
    angle, place = widths.angle, widths.place
    inner = _Limits(angle, place, angle, place, size)
    far = inner._replace(
        angle=max(NEAR * angle, NEAR_OPEN), place=max(NEAR * place, NEAR_OPEN * size)
    )
    screws, inside = _snap_open_chain(linkage, inner)
    wider, all_relations = _snap_open_chain(linkage, far)
    texts = {relation.text for relation in inside}
    near = [relation for relation in all_relations if relation.text not in texts]
    if not inside and not near:
        return linkage
    plain, _ = _snap_open_chain(linkage, inner._replace(angle=0.0, place=0.0))
    shown = near or inside
    meant = MeantGeometry(
        screws=screws,
        plain=plain,
        near=wider if near else None,
        relations=tuple(x.text for x in inside),
        near_relations=tuple(x.text for x in near),
        digits=min(digits.significant, 17),
        distance=max(x.error for x in shown),
        nearness=max(x.nearness for x in shown),
        in_decimals=max((x.error for x in inside), default=0.0) <= MEANT_DIFFERENCE,
    )
    return _with_screws(linkage, meant, again)


def with_screws(linkage: Linkage, screws: tuple[Vector, ...]) -> Linkage:
    """Assemble a linkage again with other screws of its joints.

    Args:
        screws: screws (n, 6) of any length, near its own.

    Raises:
        LinkageError: it does not assemble with them.
    """
    joints = tuple(
        _move_joint(joint, _unit_screw(screw))
        for joint, screw in zip(linkage.joints, screws, strict=True)
    )
    draft = replace(linkage, joints=joints)
    again, _ = assemble_mode(
        draft, linkage.inputs, None, exactly=True, stay=linkage.at is not None
    )
    notices = tuple(
        notice
        for notice in dict.fromkeys(again.notices)
        if notice.code != "nearly_planar" or not again.planar
    )
    return replace(again, notices=notices)


def _with_screws(linkage: Linkage, meant: MeantGeometry, again: bool) -> Linkage:
    """Attach the meant geometry to a linkage, and move its axes where they differ from it."""
    if _is_near(linkage, meant.screws):
        return replace(linkage, meant=meant)
    if not linkage.loops:
        linkage = replace(linkage, notices=(*linkage.notices, _axes_notice(linkage, meant)))
    try:
        there = with_screws(linkage, meant.screws)
    except LinkageError:
        return linkage
    if _is_near(there, meant.screws, EXACT_SCREW_DIFFERENCE):
        return replace(there, meant=meant)
    # It left a singular pose: the geometry is that at the pose to which it went.
    return as_meant(there, again=False) if again else linkage


def _axes_notice(linkage: Linkage, meant: MeantGeometry) -> Notice:
    """State that axes of an open chain were moved to be parallel, perpendicular, or meet."""
    written = np.array([joint.screw for joint in linkage.joints])
    tilt = float(
        np.abs(np.array([_unit_screw(x) for x in meant.screws]) - written)[:, :3].max()
    )
    text = (
        f"axes that are parallel, perpendicular, or meet inside the {meant.digits} digits of "
        f"the file, and are tilted by {size_text(tilt, '.0e')} rad as written, are read so "
        "(--as-written for the other)"
    )
    return Notice("special_as_meant", text)


def _is_near(
    linkage: Linkage, screws: tuple[Vector, ...], limit: float = MEANT_DIFFERENCE
) -> bool:
    """Return whether screws are those of a linkage, up to a relative limit."""
    as_written = np.array([joint.screw for joint in linkage.joints])
    apart = float(np.abs(np.array([_unit_screw(screw) for screw in screws]) - as_written).max())
    return apart <= limit * max(1.0, float(np.abs(as_written).max()))


def _unit_screw(screw: Vector) -> Array:
    """Convert a rational screw to one of unit length."""
    n = screw[:3] if any(screw[:3]) else screw[3:]
    length = float(sum(x * x for x in n)) ** 0.5
    return np.array([float(x) for x in screw]) / length


def _move_joint(joint: Joint, screw: Array) -> Joint:
    """Give a joint another screw, and the nearest point of it."""
    point = joint.point
    if joint.kind != "prismatic":
        n = screw[:3]
        point = np.cross(n, screw[3:]) + (n @ point) * n
    return replace(joint, screw=freeze(screw), point=freeze(point))


def _words(linkage: Linkage, relation: LinkRelation) -> str:
    """Name a relation and its joints."""
    names = (linkage.joints[j].name for j in _joints_of(relation))
    return f"{relation.name} {' '.join(names)}"


def _joints_of(relation: LinkRelation) -> tuple[int, ...]:
    """Joints that a relation names."""
    return relation.pins if relation.slide < 0 else (*relation.pins, relation.slide)


class _AxisRelation(NamedTuple):
    """A relation between a joint and an earlier one that holds inside a width.

    Attributes:
        text: the two joints and the relation.
        error: by how much it does not hold as written, radians or parts of the size.
        nearness: the same in parts of the width of the digits.
    """

    text: str
    error: float
    nearness: float


class _Limits(NamedTuple):
    """Largest errors of relations, and what the digits leave open.

    Attributes:
        angle: largest error of a direction, radians.
        place: largest distance, metres.
        digits_angle: error of a direction that the digits leave open, radians.
        digits_place: distance that they leave open, metres.
        size: of the linkage, metres.
    """

    angle: float
    place: float
    digits_angle: float
    digits_place: float
    size: float


def _snap_open_chain(
    linkage: Linkage, limits: _Limits
) -> tuple[tuple[Vector, ...], list[_AxisRelation]]:
    """Compute rational screws whose axes have their relations exactly.

    Args:
        linkage: a linkage without loops.
        limits: largest errors of the relations.

    Returns:
        Screws (n, 6) of any length, and the relations that hold.
    """
    return _Snapping(linkage, limits).screws()


class _Snapping:
    """Directions and points of the joints, made exact one by one; see `_snap_open_chain`."""

    def __init__(self, linkage: Linkage, limits: _Limits) -> None:
        """Start with no joint."""
        self._linkage, self._limits = linkage, limits
        self._turning: list[int] = []
        self._n: list[Vector] = []
        self._units = np.empty((0, 3))
        self._p: list[Vector] = []
        self._feet: dict[int, list[Fraction]] = {}
        self._relations: list[_AxisRelation] = []

    def screws(self) -> tuple[tuple[Vector, ...], list[_AxisRelation]]:
        """Take the joints in order; see `_snap_open_chain`."""
        screws = []
        for j, joint in enumerate(self._linkage.joints):
            before, turning = self._predecessors(j)
            beside = [k for k in range(j) if self._turning[k] == turning]
            self._turning.append(turning)
            self._n.append(self._direction(j, before, turning, beside))
            self._units = np.vstack([self._units, _unit(self._n[j])])
            self._p.append(nearby_vector(joint.point))
            anchor = turning
            if turning == GROUND:
                axes = (k for k in beside if self._linkage.joints[k].kind != "prismatic")
                anchor = next(axes, GROUND)
            if joint.kind != "prismatic" and anchor != GROUND:
                self._place(j, anchor)
            n, p = self._n[j], self._p[j]
            if joint.kind == "prismatic":
                screws.append((Fraction(0),) * 3 + n)
                continue
            pitch = Fraction(0)
            if joint.kind == "helical":
                pitch = nearby_fraction(Fraction(float(joint.screw[:3] @ joint.screw[3:])))
            moment = tuple(x + pitch * y for x, y in zip(cross(p, n), n, strict=True))
            screws.append(n + moment)
        return tuple(screws), self._relations

    def _predecessors(self, j: int) -> tuple[int, int]:
        """Find the joint before another on the path to the ground, and the last that turns."""
        joints = self._linkage.joints
        before = turning = joints[j].parent
        while turning != GROUND and joints[turning].kind == "prismatic":
            turning = joints[turning].parent
        return before, turning

    def _direction(self, j: int, before: int, turning: int, beside: list[int]) -> Vector:
        """Make the direction of a joint exactly parallel, or perpendicular, to earlier ones.

        Its angles are constant with the joint before, the last that turns, and those that the
        same joint turns (``beside``).
        """
        n = nearby_vector(self._linkage.joints[j].direction)
        across = self._perpendicular(n, dict.fromkeys((before, turning, *beside)))
        for k in (before, turning, *self._nearly_parallel(n)):
            if k == GROUND or self._angle(n, k) > self._limits.angle:
                continue
            if all(dot(self._n[k], self._n[m]) == 0 for m in across):
                self._record(f"{self._name(j)} parallel to {self._name(k)}", self._angle(n, k))
                sign = 1 if dot(n, self._n[k]) > 0 else -1
                return tuple(sign * x for x in self._n[k])
        for m in across:
            self._record(
                f"{self._name(j)} perpendicular to {self._name(m)}",
                self._angle(n, m, from_perpendicular=True),
            )
        if len(across) == 2:
            both = cross(*(self._n[m] for m in across))
            sign = 1 if dot(n, both) > 0 else -1
            return tuple(sign * x for x in both)
        if not across:
            return nearby_unit_vector(n)
        other = self._n[across[0]]
        if root(dot(other, other)) is None:
            return part_across(n, other)
        return nearby_unit_vector_across(n, other)

    def _perpendicular(self, n: Vector, joints: Iterable[int]) -> list[int]:
        """List the joints across a direction: one, or two that are not parallel."""
        across: list[int] = []
        for k in joints:
            if k == GROUND or self._angle(n, k, from_perpendicular=True) > self._limits.angle:
                continue
            if not across:
                across = [k]
            elif self._angle(self._n[k], across[0]) > NEAR_OPEN:
                return [across[0], k]
        return across

    def _nearly_parallel(self, n: Vector) -> list[int]:
        """List the earlier joints within the limit of a direction, or round-off beyond it."""
        sines = np.linalg.norm(np.cross(self._units, _unit(n)), axis=1)
        return np.flatnonzero(sines <= self._limits.angle + EXACT_SCREW_DIFFERENCE).tolist()

    def _place(self, j: int, g: int) -> None:
        """Shift a point so that the axis meets an earlier one, and its other neighbours."""
        n, m, w = self._n[j], self._n[g], add_vectors(self._p[j], self._p[g], -1)
        normal = cross(m, n)
        if not any(normal):
            apart = part_across(w, m)
            if _size(apart) <= self._limits.place:
                self._record(
                    f"{self._name(j)} on the axis of {self._name(g)}", place=_size(apart)
                )
                self._p[j] = add_vectors(self._p[j], apart, -1)
            return
        if _size(normal) < self._limits.angle * _size(m) * _size(n):
            return
        apart = _along(w, normal)
        if _size(apart) <= self._limits.place:
            self._record(f"{self._name(j)} meets {self._name(g)}", place=_size(apart))
            self._p[j] = add_vectors(self._p[j], apart, -1)
        here = self._foot(g, j)
        for other in self._feet.get(g, ()):
            more = tuple((here - other) * x for x in m)
            if _size(more) <= self._limits.place:
                text = f"normals on {self._name(g)} meet that of {self._name(j)}"
                self._record(text, place=_size(more))
                self._p[j] = add_vectors(self._p[j], more, -1)
                here = other
                break
        self._feet.setdefault(g, []).append(here)
        self._feet.setdefault(j, []).append(self._foot(j, g))

    def _foot(self, a: int, b: int) -> Fraction:
        """Compute where on an axis the common normal with another starts.

        With ``r = p_b - p_a``, the point ``p_a + t n_a`` has
        ``t = (n_b·n_b r·n_a - n_a·n_b r·n_b) / (n_a·n_a n_b·n_b - (n_a·n_b)²)``.
        Points of an axis are measured from that nearest to the origin.
        """
        u, v, r = self._n[a], self._n[b], add_vectors(self._p[b], self._p[a], -1)
        uu, uv, vv = dot(u, u), dot(u, v), dot(v, v)
        t = (vv * dot(r, u) - uv * dot(r, v)) / (uu * vv - uv * uv)
        return t + dot(self._p[a], u) / uu

    def _angle(self, n: Vector, k: int, from_perpendicular: bool = False) -> float:
        """Compute the angle between a direction and a joint's, or its distance from π/2."""
        m = self._n[k]
        sine, size = _size(cross(n, m)), _size(n) * _size(m)
        return abs(float(dot(n, m))) / size if from_perpendicular else sine / size

    def _record(self, text: str, angle: float = 0.0, place: float = 0.0) -> None:
        """Record a relation, and its error."""
        limits = self._limits
        error = max(angle, place / limits.size)
        nearness = max(angle / limits.digits_angle, place / limits.digits_place)
        self._relations.append(_AxisRelation(text, error, nearness))

    def _name(self, j: int) -> str:
        return self._linkage.joints[j].name


def _unit(n: Vector) -> Array:
    floats = np.array([float(x) for x in n])
    return floats / np.linalg.norm(floats)


def _size(a: Vector) -> float:
    return float(dot(a, a)) ** 0.5


def _along(a: Vector, n: Vector) -> Vector:
    factor = dot(a, n) / dot(n, n)
    return tuple(factor * x for x in n)
