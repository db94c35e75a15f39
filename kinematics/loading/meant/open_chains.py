"""Axes of an open chain that are parallel, perpendicular, or meet, inside the digits of a file.

Between a joint and the next one on its path to the ground, three numbers are constant in
any motion: the angle between their axes, their distance, and how far along an axis its common
normals with its neighbours are apart. Where one of them is a right angle or zero inside its
interval, it is so exactly in the screws that are returned. Joints are taken parents first, so
that each has one predecessor to be related to, and no relation contradicts another.
"""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.linalg.rational import Vector, cross, dot, nearby_fraction

Array = NDArray[np.float64]


class AxisRelation(NamedTuple):
    """A relation between a joint and an earlier one that holds inside a width.

    Attributes:
        text: the two joints and the relation.
        error: by how much it does not hold as written, radians or parts of the size.
        nearness: the same in parts of the width of the digits.
    """

    text: str
    error: float
    nearness: float


class Limits(NamedTuple):
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


def snap_open_chain(
    linkage: Linkage, limits: Limits
) -> tuple[tuple[Vector, ...], list[AxisRelation]]:
    """Compute rational screws whose axes have their relations exactly.

    Args:
        linkage: a linkage without loops.
        limits: largest errors of the relations.

    Returns:
        Screws (n, 6) of any length, and the relations that hold.
    """
    return _Snapping(linkage, limits).screws()


class _Snapping:
    """Directions and points of the joints, made exact one by one; see `snap_open_chain`."""

    def __init__(self, linkage: Linkage, limits: Limits) -> None:
        """Start with no joint."""
        self._linkage, self._limits = linkage, limits
        self._n: list[Vector] = []
        self._p: list[Vector] = []
        self._feet: dict[int, list[Fraction]] = {}
        self._relations: list[AxisRelation] = []

    def screws(self) -> tuple[tuple[Vector, ...], list[AxisRelation]]:
        """Take the joints in order; see `snap_open_chain`."""
        screws = []
        for j, joint in enumerate(self._linkage.joints):
            before, turning = self._predecessors(j)
            self._n.append(self._direction(j, before, turning))
            self._p.append(_rational(joint.point))
            if joint.kind != "prismatic" and turning != GROUND:
                self._place(j, turning)
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

    def _direction(self, j: int, before: int, turning: int) -> Vector:
        """Make the direction of a joint exactly parallel, or perpendicular, to earlier ones."""
        joint = self._linkage.joints[j]
        n = _rational(joint.screw[3:] if joint.kind == "prismatic" else joint.screw[:3])
        across = [
            k for k in dict.fromkeys((before, turning))
            if k != GROUND and self._angle(n, k, right=True) <= self._limits.angle
        ]  # fmt: skip
        for k in (before, turning, *range(j)):
            if k == GROUND or self._angle(n, k) > self._limits.angle:
                continue
            if all(dot(self._n[k], self._n[m]) == 0 for m in across):
                self._record(f"{self._name(j)} parallel to {self._name(k)}", self._angle(n, k))
                sign = 1 if dot(n, self._n[k]) > 0 else -1
                return tuple(sign * x for x in self._n[k])
        for m in across:
            self._record(
                f"{self._name(j)} perpendicular to {self._name(m)}",
                self._angle(n, m, right=True),
            )
        if len(across) == 2 and any(both := cross(*(self._n[m] for m in across))):
            sign = 1 if dot(n, both) > 0 else -1
            return tuple(sign * x for x in both)
        for m in across[:1]:
            n = _without(n, self._n[m])
        return n

    def _place(self, j: int, g: int) -> None:
        """Shift a point so that the axis meets an earlier one, and its other neighbours."""
        n, m, w = self._n[j], self._n[g], _difference(self._p[j], self._p[g])
        normal = cross(m, n)
        if not any(normal):
            apart = _without(w, m)
            if _size(apart) <= self._limits.place:
                self._record(
                    f"{self._name(j)} on the axis of {self._name(g)}", place=_size(apart)
                )
                self._p[j] = _difference(self._p[j], apart)
            return
        if _size(normal) < self._limits.angle * _size(m) * _size(n):
            return
        apart = _along(w, normal)
        if _size(apart) <= self._limits.place:
            self._record(f"{self._name(j)} meets {self._name(g)}", place=_size(apart))
            self._p[j] = _difference(self._p[j], apart)
        here = self._foot(g, j)
        for other in self._feet.get(g, ()):
            more = tuple((here - other) * x for x in m)
            if _size(more) <= self._limits.place:
                text = f"normals on {self._name(g)} meet that of {self._name(j)}"
                self._record(text, place=_size(more))
                self._p[j] = _difference(self._p[j], more)
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
        u, v, r = self._n[a], self._n[b], _difference(self._p[b], self._p[a])
        uu, uv, vv = dot(u, u), dot(u, v), dot(v, v)
        t = (vv * dot(r, u) - uv * dot(r, v)) / (uu * vv - uv * uv)
        return t + dot(self._p[a], u) / uu

    def _angle(self, n: Vector, k: int, right: bool = False) -> float:
        """Compute the angle between a direction and a joint's, or its distance from π/2."""
        m = self._n[k]
        sine, size = _size(cross(n, m)), _size(n) * _size(m)
        return abs(float(dot(n, m))) / size if right else sine / size

    def _record(self, text: str, angle: float = 0.0, place: float = 0.0) -> None:
        """Record a relation, and its error."""
        limits = self._limits
        error = max(angle, place / limits.size)
        nearness = max(angle / limits.digits_angle, place / limits.digits_place)
        self._relations.append(AxisRelation(text, error, nearness))

    def _name(self, j: int) -> str:
        return self._linkage.joints[j].name


def _rational(x: Array) -> Vector:
    return tuple(nearby_fraction(Fraction(float(y))) for y in x)


def _size(a: Vector) -> float:
    return float(dot(a, a)) ** 0.5


def _difference(a: Vector, b: Vector) -> Vector:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _along(a: Vector, n: Vector) -> Vector:
    factor = dot(a, n) / dot(n, n)
    return tuple(factor * x for x in n)


def _without(a: Vector, n: Vector) -> Vector:
    return _difference(a, _along(a, n))
