"""Copies of a linkage that cancel its momentum: finite groups of turns and mirrorings.

A copy ``g`` of a linkage, driven in step, is its image under ``x → g (x - O) + O`` with an
orthogonal matrix g. Linear momentum is a polar vector, angular momentum about O an axial one:
the copy has ``g p`` and ``det(g) g ξ_O``. If the copies g form a group with the linkage itself,

    Σ_g g p = 0  and  Σ_g det(g) g ξ_O = 0    ⇔    the momenta p and ξ_O of all motions have no
                                                    part that every g leaves as it is.

Groups of two leave as they are: a turn by π about n the parts of p and ξ_O along n; a mirror
with normal n the part of p across n and that of ξ_O along n; the inversion in O all of ξ_O. The
turns by π about three perpendicular axes, with the linkage itself, leave nothing: three copies
balance any linkage, whatever its masses. Groups of three are turns by 2π/3, which leave the
same as a turn by π. So either one copy does, or three.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.remedies.momentum_along import momentum_along
from balance.motion.verification.trajectory import random_motions
from balance.support.tolerances import AS_GIVEN_RESIDUAL
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.motion import motion_of
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_direction, first_largest, round_decimals
from kinematics.wording import vector_text

# Random motions, and samples of each, whose momenta span those of all motions.
MOTIONS = 3
SAMPLES = 60
SEED = 7


class Copy(NamedTuple):
    """A copy of a linkage at ``x → ±Q (x - O) + O``.

    Attributes:
        rotation: Q (3, 3), a rotation.
        mirrored: whether the sign is negative, so that the parts are mirrored.
        point: O (3,), in the frame of the root, metres.
        words: the copy in words.
    """

    rotation: Array
    mirrored: bool
    point: Array
    words: str

    @property
    def pose(self) -> Array:
        """The displacement (4, 4) ``x → Q x + t`` of the linkage, inverted if mirrored."""
        displacement = np.eye(4)
        sign = -1.0 if self.mirrored else 1.0
        displacement[:3, :3] = self.rotation
        displacement[:3, 3] = self.point - sign * self.rotation @ self.point
        return displacement


class Place(NamedTuple):
    """Where a linkage is, and the axes that copies of it are turned about.

    Attributes:
        centre: middle of its joints on the ground (3,), metres.
        radius: it stays within this distance of the centre, metres.
        axes: unit vectors as rows (3, 3); the last is the normal of a planar linkage.
        planar: whether it moves in a plane.
    """

    centre: Array
    radius: float
    axes: Array
    planar: bool


class _Momenta(NamedTuple):
    """Momenta of many poses over the largest sum of those of the bodies.

    Attributes:
        linear: p (N, 3).
        moment: ξ about ``middle`` over ``length`` (N, 3).
        middle: a point (3,), metres.
        length: metres.
    """

    linear: Array
    moment: Array
    middle: Array
    length: float


def single_copies(
    linkage: Linkage, motion: Sequence[str], force: bool, place: Place
) -> Iterator[Copy]:
    """Find the copies that balance a linkage alone, identical parts before mirrored ones.

    Turns are tried about the axes of the place first, then about the axis that the momenta
    leave. Points that the momenta leave free are such that the copy is beside the linkage.

    Args:
        linkage: an assembled linkage with masses.
        motion: relations between its inputs.
        force: whether only the force counts.

    Yields:
        The copies: each cancels momentum, or linear momentum, along random motions.
    """
    momenta = _sample_momenta(linkage, motion, force)
    axes = [*place.axes[::-1]] if force and place.planar else [*place.axes]
    for n in [*axes, *_left_axis(momenta, force)]:
        point = _turn_point(momenta, n, place, force)
        if point is not None:
            yield _half_turn(n, point)
            break
    for n in axes:
        across = momenta.linear - np.outer(momenta.linear @ n, n)
        if not force and _vanishes(across) and _vanishes(momenta.moment @ n):
            plane = _move_to_radius(place, n, place.centre)
            Q = 2.0 * np.outer(n, n) - np.eye(3)
            yield Copy(Q, True, plane, f"mirrored with the normal {vector_text(n)}")
            break
    centre = _inversion_point(momenta, place, force)
    if centre is not None:
        yield Copy(np.eye(3), True, centre, f"inverted in the point {vector_text(centre)} m")


def four_group(place: Place) -> tuple[Copy, ...]:
    """Make the three copies turned by π about perpendicular axes, which balance any linkage.

    The axes meet in a point beside the linkage: in the plane of a planar linkage at one radius
    along both its axes, else at three quarters of a radius along all three. The balls about
    the linkage and its copies do not overlap then.

    Args:
        place: where the linkage is.
    """
    shift = [1.0, 1.0, 0.0] if place.planar else [0.75, 0.75, 0.75]
    point = place.centre - place.radius * np.array(shift) @ place.axes
    return tuple(_half_turn(n, point) for n in place.axes)


def half_turn_in_plane(place: Place) -> Copy:
    """Make the copy of a planar linkage turned by π about an axis in its plane.

    It is the mirror image in the plane: it cancels the moment of any force-balanced linkage.

    Args:
        place: where the linkage is.
    """
    n, across = place.axes[0], place.axes[1]
    return _half_turn(n, place.centre - place.radius * across)


def place_of(linkage: Linkage) -> Place:
    """Find a ball in which a linkage stays, and axes to turn copies of it about.

    The radius is the longest way along the joints from the middle of those on the ground, to
    twice the distance of a centre of mass from its joint; a slide counts with the length of the
    linkage. It is rounded up, the centre is rounded, to two digits of the radius. The axes
    are those of the root, or of the plane if its normal is none of them.
    """
    joints = linkage.joints
    ground = np.array([joint.point for joint in joints if joint.parent == GROUND])
    centre, slide = ground.mean(axis=0), linkage.spatial_chain.frame.length
    way = np.zeros(len(joints))
    for j, joint in enumerate(joints):
        before = joints[joint.parent].point if joint.parent != GROUND else centre
        way[j] = np.linalg.norm(joint.point - before)
        way[j] += slide if joint.kind == "prismatic" else 0.0
        way[j] += way[joint.parent] if joint.parent != GROUND else 0.0
    radius = float(way.max())
    for body in linkage.bodies:
        com = body.inertia[1:4] / body.inertia[0] if body.inertia[0] else body.frame[:3, 3]
        ahead = float(np.linalg.norm(com - joints[body.link].point))
        radius = max(radius, float(way[body.link]) + 2.0 * ahead)
    radius = radius or slide
    digits = 1 - int(np.floor(np.log10(radius * (1.0 + AS_GIVEN_RESIDUAL))))
    radius = float(np.round(np.ceil(radius * 10.0**digits - AS_GIVEN_RESIDUAL), 0))
    R = linkage.chain.frame.R
    axes = np.eye(3) if not linkage.planar or _is_coordinate(R[2]) else R
    if linkage.planar and _is_coordinate(R[2]):
        axes = np.roll(np.eye(3), 2 - first_largest(np.abs(R[2])), axis=0)
    return Place(
        round_decimals(centre, digits),
        round(radius / 10.0**digits, digits),
        axes,
        linkage.planar,
    )


def _is_coordinate(n: Array) -> bool:
    """Whether a unit vector is a coordinate axis."""
    return bool(np.abs(n).max() >= 1.0 - AS_GIVEN_RESIDUAL)


def _sample_momenta(linkage: Linkage, motion: Sequence[str], force: bool) -> _Momenta:
    """Compute momenta along random motions; moments are zero if only the force counts."""
    limits = motion_of(linkage, tuple(motion) or None)
    frame = linkage.spatial_chain.frame
    runs = [
        momentum_along(linkage, trajectory)
        for trajectory in random_motions(linkage, MOTIONS, SAMPLES, SEED, motion=limits)
    ]
    total = np.concatenate([run.total for run in runs])
    size = max(float(run.size.max()) for run in runs) or 1.0
    linear = total[:, 3:] / size
    moment = (total[:, :3] / size - np.cross(frame.origin, linear)) / frame.length
    return _Momenta(linear, 0.0 * moment if force else moment, frame.origin, frame.length)


def _vanishes(x: Array) -> bool:
    """Whether momenta over those of the bodies are round-off."""
    return bool(np.abs(x).max(initial=0.0) <= AS_GIVEN_RESIDUAL)


def _half_turn(n: Array, point: Array) -> Copy:
    """Make the copy turned by π about the line through a point along a unit vector."""
    Q = 2.0 * np.outer(n, n) - np.eye(3)
    words = f"turned by π about the line through {vector_text(point)} m along {vector_text(n)}"
    return Copy(np.round(Q, 15), False, point, words)


def _left_axis(momenta: _Momenta, force: bool) -> list[Array]:
    """Find a direction n with ``n·p = 0`` and ``n·ξ = m·p`` for one m, in all poses."""
    zero = np.zeros_like(momenta.linear)
    rows = np.hstack([momenta.linear, zero])
    if not force:
        rows = np.vstack([rows, np.hstack([momenta.moment, -momenta.linear])])
    _, sizes, directions = np.linalg.svd(rows)
    axes = directions[sizes <= AS_GIVEN_RESIDUAL * np.sqrt(len(rows)), :3]
    if not axes.size:
        return []
    _, sizes, directions = np.linalg.svd(axes)
    if not sizes[0] > np.sqrt(AS_GIVEN_RESIDUAL):
        return []
    equal = sizes >= (1.0 - np.sqrt(AS_GIVEN_RESIDUAL)) * sizes[0]
    return [first_direction(directions[: sizes.size][equal])]


def _turn_point(momenta: _Momenta, n: Array, place: Place, force: bool) -> Array | None:
    """Find a point of the axis n of a turn by π that balances; None if there is none.

    With ``m = n × O``, the moment about the axis is ``n·ξ - m·p``.
    """
    p, moment = momenta.linear, momenta.moment @ n
    if not _vanishes(p @ n):
        return None
    if force or _vanishes(p):
        return (
            _move_to_radius(place, _direction_across(place, n), place.centre)
            if _vanishes(moment)
            else None
        )
    m = np.linalg.lstsq(p, moment, rcond=AS_GIVEN_RESIDUAL)[0]
    if not _vanishes(p @ m - moment):
        return None
    point = momenta.middle + momenta.length * np.cross(m, n)
    _, sizes, directions = np.linalg.svd(p)
    if sizes[1] > AS_GIVEN_RESIDUAL * sizes[0]:
        return point
    return _move_to_radius(place, np.round(first_direction(directions[:1]), 15), point)


def _direction_across(place: Place, n: Array) -> Array:
    """Choose a direction across n, one of the axes if possible."""
    nearest = next(axis for axis in place.axes if abs(axis @ n) < 0.75)
    across = nearest - (nearest @ n) * n
    return np.asarray(across / np.linalg.norm(across))


def _inversion_point(momenta: _Momenta, place: Place, force: bool) -> Array | None:
    """Find the point O with ``ξ = O × p`` in all poses; None if there is none."""
    if force:
        return _move_to_radius(place, place.axes[0], place.centre)
    p = momenta.linear
    rows = np.cross(np.eye(3)[None], p[:, None]).swapaxes(1, 2).reshape(-1, 3)
    right = momenta.moment.ravel()
    point = np.linalg.lstsq(rows, right, rcond=AS_GIVEN_RESIDUAL)[0]
    if not _vanishes(rows @ point - right):
        return None
    return momenta.middle + momenta.length * point


def _move_to_radius(place: Place, free: Array, point: Array) -> Array:
    """Move a point along a direction in which it is free, to one radius from the centre."""
    return np.asarray(point + (free @ (place.centre - point) - place.radius) * free)
