"""Cases of certainty: what a family and a seed stand for, in which file, and what is true.

A file in decimals that are exact has one reading. One in rounded numbers stands for the linkage
that was rounded; if a special one is as near as the digits leave open, for either.
"""

from __future__ import annotations

import re
import zlib
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from tests.independent import planar_families as planar
from tests.independent import spatial_families as spatial
from tests.independent.families import FAMILIES as ORDINARY
from tests.independent.families import linkage
from tests.independent.hard_families import coupled, related, special_joints, yokes
from tests.independent.plain_linkage import AXES, Joint, Linkage, cross, urdf, vector
from tests.independent.turned_files import turned_text

# Digits of files in rounded numbers, most often those of a double.
DIGITS, ODDS = (17, 16, 15, 14, 12, 10, 9, 8, 7, 6, 5, 4, 3), (0.3, *[0.7 / 12] * 12)
# Digits below which the numbers of a file count as design values: exit 4, or a refusal, is
# right too.
FEWEST = 6
# Sine of the angle between axes that count as parallel even as written, ten units of the last
# digit of 1 in two components, and a little more; and parts of an axis that count as zero in
# another reading.
ROUND_OFF = Fraction(15, 10**15)
# Orders up to which loops of yokes close, and idle joints rest: above the 16th power.
ORDERS_OF_YOKES = 40


class Case(NamedTuple):
    """A file and its truth.

    Attributes:
        text: of the file.
        options: words of the command line.
        readings: what the file may stand for.
        note: how it is written.
        decided: whether an answer can be asked for.
        orders: of the truth; 0 for the usual.
        rounded: whether the numbers of the file are rounded.
    """

    text: str
    options: list[str]
    readings: tuple[Linkage, ...]
    note: str = ""
    decided: bool = True
    orders: int = 0
    rounded: bool = False


def _exact(linkage: Linkage, *others: Linkage, note: str = "", orders: int = 0) -> Case:
    """A file in exact decimals."""
    return Case(urdf(linkage), linkage.options, (linkage, *others), note, True, orders)


def _rounded(rng, linkage: Linkage, digits: int, oblique: bool, *others: Linkage) -> Case:
    """A file in rounded numbers."""
    linkage = replace(linkage, as_written=False)
    frames = str(rng.choice(["turned", "axes", "plain"], p=[0.7, 0.15, 0.15]))
    text = turned_text(linkage, rng, digits, oblique, frames)
    plane = "any plane" if oblique else "given plane"
    return Case(
        text,
        linkage.options,
        (linkage, *others),
        f"{digits} digits, {frames}, {plane}",
        digits >= FEWEST,
        rounded=True,
    )


def _six_bar(rng) -> tuple[Joint, ...]:
    """A four-bar and a dyad from one of its links to another, the pins at random."""
    while True:
        joints = list(planar.ring(planar.corners(rng, "general")))
        before, after = (int(x) for x in rng.choice(4, 2, replace=False))
        kinds = str(rng.choice(["RRR", "RRP", "RPR", "RRR"]))
        axes = [AXES[2] if kind == "R" else vector(3, 4, 0) for kind in kinds]
        points = [(*planar._decimals(rng)[:2], Fraction(0)) for _ in kinds]
        # Links next to each other with a dyad make a structure.
        if abs(before - after) != 2:
            continue
        planar.chained(joints, before, after, kinds, points, axes)
        return tuple(sorted(joints, key=lambda joint: joint.loop))


def _planar(rng) -> Linkage:
    """A planar linkage of one loop or more."""
    kind = int(rng.integers(6))
    if kind == 0:
        joints = _six_bar(rng)
    elif kind == 1:
        points = [planar._decimals(rng) for _ in range(5)]
        joints = planar.ring(points)
    elif kind == 2:
        joints, _ = planar.grid(rng)
        joints = tuple(sorted(joints, key=lambda joint: joint.loop))
    elif kind == 3:
        points = [planar._decimals(rng) for _ in range(4)]
        points[3] = points[2]
        joints = planar.ring(points, "RRRP", [AXES[2]] * 3 + [vector(1, 1, 0)])
    else:
        name = str(rng.choice(["general", "parallelogram", "kite", "antiparallelogram"]))
        joints = planar.ring(planar.corners(rng, name))
    return Linkage(joints, spatial=bool(rng.random() < 0.15), force=bool(rng.random() < 0.15))


def _turned(rng) -> Case:
    """Any linkage, whole turned, in turned frames, with 3 to 17 digits."""
    kind = int(rng.integers(5))
    if kind == 0:
        found = _planar(rng)
    elif kind == 1:
        joints = tuple(special_joints(rng))
        drawn = bool(rng.random() < 0.5)
        flat = all(joint.axis == AXES[2] for joint in joints)
        found = Linkage(joints, spatial=drawn or not flat)
    elif kind == 2:
        found = Linkage(spatial.general(rng)[0], spatial=True)
    elif kind == 3:
        joints = [
            Joint(
                str(rng.choice(["R", "P"], p=[0.8, 0.2])),
                k,
                k + 1,
                spatial._point(rng),
                spatial._axis(rng),
            )
            for k in range(int(rng.integers(2, 6)))
        ]
        found = Linkage(tuple(joints), spatial=True)
    else:
        found = related(rng)
        found = replace(found, spatial=True)
    digits = int(rng.choice(DIGITS, p=ODDS))
    if found.mimics and rng.random() < 0.7:
        digits = 17
    return _rounded(rng, found, digits, True)


def _oblique(rng) -> Case:
    """A planar linkage in any plane, in turned frames, mostly with the digits of doubles."""
    return _rounded(rng, _planar(rng), int(rng.choice([17, 17, 16, 15, 12, 9])), True)


def _coupled(rng) -> Case:
    """Coupled special loops, one of them off by 10^-k, in exact decimals or rounded."""
    found, specials, power = coupled(rng)
    note = f"off by 1e-{power}" if power else "special"
    if rng.random() < 0.5:
        # The last digit of the file is the one that is off: the special loop is inside of it.
        short = power and _significant_digits(urdf(found)) < FEWEST
        return _exact(found, *(() if found.as_written or short else specials), note=note)
    digits = int(rng.choice([17, 17, 15, 12, 9]))
    # A double is known to sixteen digits, after operations to three less.
    others = specials if power and power >= min(digits, 16) - 3 else ()
    case = _rounded(rng, found, digits, bool(rng.random() < 0.7), *others)
    return case._replace(note=f"{note}, {case.note}")


def _significant_digits(text: str) -> int:
    """The most significant digits of a coordinate of a file in exact decimals."""
    numbers = " ".join(re.findall('origin xyz="([^"]*)"', text)).split()
    return max(len(x.lstrip("-").replace(".", "").lstrip("0")) for x in numbers)


HARD: dict[str, Callable] = {
    "related": lambda rng: _exact(related(rng)),
    "yokes": lambda rng: _exact(yokes(rng), orders=ORDERS_OF_YOKES),
    "turned": _turned,
    "oblique": _oblique,
    "coupled": _coupled,
}

FAMILIES = (*HARD, *ORDINARY)


def _short(x: Fraction) -> Fraction:
    """A number of 13 decimals if that is within a few units of the round-off of doubles."""
    short = Fraction(round(x * 10**13), 10**13)
    return short if abs(x - short) < Fraction(3, 10**15) else x


def _without_round_off(linkage: Linkage, backwards: bool = False) -> Linkage:
    """The linkage with axes that are parallel, and points that are short, to round-off.

    Numbers count as written if that is asked for; axes that are parallel to round-off are
    parallel even then: to the first of them, or to the last.
    """
    joints = []
    step = -1 if backwards else 1
    for joint in linkage.joints[::step]:
        axis = joint.axis
        for other in (x.axis for x in joints):
            w = cross(axis, other)
            size = sum(x * x for x in axis) * sum(x * x for x in other)
            if 0 < sum(x * x for x in w) <= ROUND_OFF**2 * size:
                along = sum(x * y for x, y in zip(axis, other, strict=True))
                axis = other if along > 0 else tuple(-x for x in other)
                break
        point = joint.point if linkage.as_written else tuple(map(_short, joint.point))
        joints.append(joint._replace(axis=axis, point=point))
    return replace(linkage, joints=tuple(joints[::step]))


def _without_noise(linkage: Linkage) -> Linkage:
    """The linkage with the directions whose small components are the noise of an exporter."""
    joints = []
    for joint in linkage.joints:
        most = max(map(abs, joint.axis))
        axis = tuple(x if abs(x) > ROUND_OFF * most else Fraction(0) for x in joint.axis)
        if len([x for x in axis if x]) == 1:
            axis = tuple(Fraction((x > 0) - (x < 0)) for x in axis)
        joints.append(joint._replace(axis=axis))
    return replace(linkage, joints=tuple(joints))


def _special_inside(linkage: Linkage) -> Iterator[Linkage]:
    """Yield kites, parallelograms and antiparallelograms inside the digits of a four-bar.

    The last pin of three others is moved to the image of the pin opposite to it, or of the
    first: under the reflection in a diagonal, in the middle of a diagonal, or in its bisector.
    """
    joints = linkage.joints
    if len(joints) != 4 or any(x.kind != "R" or x.axis != AXES[2] for x in joints):
        return
    points = [joint.point[:2] for joint in joints]
    numbers = [x for point in points for x in point]
    decimals = next(k for k in range(30) if all((10**k * x).denominator == 1 for x in numbers))
    if decimals < FEWEST - 1:
        return
    for corners in planar.special_inside(points, decimals):
        moved = (
            joint._replace(point=(*point, joint.point[2]))
            for joint, point in zip(joints, corners, strict=True)
        )
        yield replace(linkage, joints=tuple(moved))


def certainty_case(family: str, seed: int) -> Case:
    """What a family and a seed stand for."""
    if family in ORDINARY:
        found = linkage(family, seed)
        others = [_without_round_off(found, backwards) for backwards in (False, True)]
        if not found.as_written:
            others += [_without_noise(found), *_special_inside(found)]
        return _exact(found, *(other for other in others if other != found))
    return HARD[family](np.random.default_rng([seed, zlib.crc32(family.encode())]))
