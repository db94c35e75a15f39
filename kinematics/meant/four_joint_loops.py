"""Loops of four joints with equal links: parallelogram, antiparallelogram, kite, and the like.

In the plane, and on a sphere about the point in which all axes meet, a loop P Q R S of four
links is special where opposite links, or neighbours, are equal. Its last pin then is the image
of the second under a displacement that the other two determine, by rational formulas:

- parallelogram: half a turn about the middle of P and R; ``S = P + R - Q`` in the plane, and
  on the sphere half a turn about ``P + R``;
- antiparallelogram: the reflection that exchanges P and R;
- kite: the reflection that keeps P and R;
- rhombus: parallelogram and kite at once;
- slider-crank with crank O A and coupler A C of one length, in line with its slide d:
  ``C = O + 2 (A - O)·d / d² d``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.linalg.rational import Vector, cross, dot

__all__ = ["Pin", "Relation", "Slide", "apply_relations", "find_relations"]

Array = NDArray[np.float64]

# Most rigid links through which loops of four are looked for.
MAX_PINS = 60
# Distance of a pin from its image, in parts of the size, with which a relation of lengths is
# that of this image.
IMAGE_DISTANCE = 1e-3
# Distance of two pins, in parts of the size, that a loop of four joints may have.
PINS_DISTINCT = 1e-6

Move = Callable[[Vector, Vector, Vector, Vector], Vector]


class Pin(NamedTuple):
    """Joints on one axis.

    Attributes:
        joints: their numbers.
        links: half width of the place of the pin on each rigid link that it joins.
    """

    joints: tuple[int, ...]
    links: Mapping[int, float]


class Slide(NamedTuple):
    """A joint that slides in the plane.

    Attributes:
        joint: its number.
        links: rigid links before and after it.
        d: its direction.
        angles: half width of its direction on each of the links.
    """

    joint: int
    links: tuple[int, int]
    d: Vector
    angles: tuple[float, float]


class Relation(NamedTuple):
    """A relation of lengths around a loop of four joints.

    Attributes:
        name: of the loop: ``"parallelogram"``, ``"antiparallelogram"``, ``"kite"``,
            ``"rhombus"`` or ``"isosceles slider-crank"``.
        pins: P, Q, R and S, or O, A and C of a slider-crank.
        signs: of the directions of the pins.
        slide: number of the slide among the slides; -1 without one.
        error: largest difference of lengths that the relation makes equal.
        nearness: the same in parts of the half width of its interval.
    """

    name: str
    pins: tuple[int, ...]
    signs: tuple[int, ...]
    slide: int
    error: float
    nearness: float


class _Figure(NamedTuple):
    """Pins in the plane or on the sphere; see `find_relations`."""

    places: Array
    pins: Sequence[Pin]
    planar: bool
    size: float

    def distance(self, a: Array, b: Array) -> float:
        """Distance of two points, or angle between two unit vectors."""
        if self.planar:
            return float(np.linalg.norm(a - b))
        return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))


def find_relations(
    places: Array, pins: Sequence[Pin], slides: Sequence[Slide], normal: Array | None,
    size: float, limit: float,
) -> list[Relation]:  # fmt: skip
    """Find loops of four joints with equal links.

    Args:
        places: points of the pins in their plane, or unit vectors along them (pins, 3).
        pins: the pins.
        slides: joints that slide in the plane.
        normal: normal of the plane (3,); None on a sphere.
        size: of the linkage; 1 on a sphere.
        limit: largest nearness of a relation.

    Returns:
        The relations, each loop once.
    """
    if len(pins) > MAX_PINS:
        return []
    figure = _Figure(places, pins, normal is not None, size)
    between: dict[tuple[int, int], list[int]] = {}
    for p, q in combinations(range(len(pins)), 2):
        shared = sorted(set(pins[p].links) & set(pins[q].links))
        if shared and np.linalg.norm(places[p] - places[q]) > PINS_DISTINCT * size:
            between[p, q] = between[q, p] = shared
    found = [
        relation
        for loop, links in _loops_of_four(len(pins), between)
        if (relation := _relation_of(figure, loop, links, limit))
    ]
    if normal is not None:
        for k, slide in enumerate(slides):
            found += _slider_cranks(figure, between, k, slide, limit)
    return found


def _loops_of_four(
    count: int, between: Mapping[tuple[int, int], Sequence[int]]
) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Yield pins P, Q, R, S and links P Q, Q R, R S, S P of loops of four rigid links."""
    seen = set()
    for P, R in combinations(range(count), 2):
        middles = [
            (q, a, b) for q in range(count) if (P, q) in between and (q, R) in between
            for a in between[P, q] for b in between[q, R] if a != b
        ]  # fmt: skip
        for (Q, a, b), (S, d, c) in combinations(middles, 2):
            key = frozenset((P, Q, R, S)), frozenset((a, b, c, d))
            if Q != S and len(key[1]) == 4 and key not in seen:
                seen.add(key)
                yield (P, Q, R, S), (a, b, c, d)


def _relation_of(
    figure: _Figure, loop: tuple[int, ...], links: tuple[int, ...], limit: float
) -> Relation | None:
    """Find the relation of a loop of four pins; None if it has none."""
    some_signs: list[tuple[int, ...]] = [(1, 1, 1, 1)]
    if not figure.planar:
        some_signs = [(1, *rest) for rest in product((1, -1), repeat=3)]
    ends = [(loop[k], loop[(k + 1) % 4]) for k in range(4)]
    widths = [
        figure.pins[p].links[link] + figure.pins[q].links[link]
        for link, (p, q) in zip(links, ends, strict=True)
    ]
    best: Relation | None = None
    for signs in some_signs:
        places = [s * figure.places[p] for s, p in zip(signs, loop, strict=True)]
        lengths = [figure.distance(places[k], places[(k + 1) % 4]) for k in range(4)]

        def compare(i: int, j: int, lengths: list[float] = lengths) -> tuple[float, float]:
            error = abs(lengths[i] - lengths[j])
            return error, error / max(widths[i] + widths[j], 1e-300)

        pairs = {
            "opposite": (compare(0, 2), compare(1, 3), (0, 1, 2, 3)),
            "kite": (compare(0, 3), compare(1, 2), (0, 1, 2, 3)),
            "turned kite": (compare(0, 1), compare(2, 3), (1, 2, 3, 0)),
        }
        close = {
            kind: (max(a[0], b[0]), max(a[1], b[1]), order)
            for kind, (a, b, order) in pairs.items()
            if max(a[1], b[1]) <= limit
        }
        if not close:
            continue
        relation = _named(figure, loop, signs, places, close)
        if relation and (best is None or relation.name == "rhombus"):
            best = relation
    return best


def _named(
    figure: _Figure, loop: tuple[int, ...], signs: tuple[int, ...], places: list[Array],
    close: Mapping[str, tuple[float, float, tuple[int, ...]]],
) -> Relation | None:  # fmt: skip
    """Name the relation that lengths and the place of the last pin show."""
    inside = {kind for kind, (_, nearness, _) in close.items() if nearness <= 1.0}
    kinds = inside or set(close)
    names = ["parallelogram", "antiparallelogram"] if "opposite" in kinds else []
    if len(kinds) == 3 and figure.planar:
        names = ["rhombus", *names]
    choices = [(name, "opposite") for name in names]
    choices += [("kite", kind) for kind in ("kite", "turned kite") if kind in kinds]
    for name, kind in choices:
        error, nearness, order = close[kind]
        if name == "rhombus":
            error = max(error for error, _, _ in close.values())
            nearness = max(nearness for _, nearness, _ in close.values())
        P, Q, R, S = (places[k] for k in order)
        image = _float_image(name, P, Q, R, figure.planar)
        if np.linalg.norm(image - S) <= IMAGE_DISTANCE * figure.size:
            pins, turned = (tuple(x[k] for k in order) for x in (loop, signs))
            return Relation(name, pins, turned, -1, error, nearness)
    return None


def _float_image(name: str, P: Array, Q: Array, R: Array, planar: bool) -> Array:
    """Compute the image of Q in floating point."""
    h: Array
    if name in ("parallelogram", "rhombus"):
        if planar:
            return np.asarray(P + R - Q)
        h = P + R
        return np.asarray(2 * (Q @ h) / max(float(h @ h), 1e-300) * h - Q)
    middle = (P + R) / 2 if planar else np.zeros(3)
    if name == "antiparallelogram":
        h = P - R
        return np.asarray(Q - 2 * ((Q - middle) @ h) / (h @ h) * h)
    if planar:
        along = (R - P) / np.linalg.norm(R - P)
        w = Q - P
        return np.asarray(P + 2 * (w @ along) * along - w)
    m = np.cross(P, R)
    return np.asarray(Q - 2 * (Q @ m) / max(float(m @ m), 1e-300) * m)


def _slider_cranks(
    figure: _Figure, between: Mapping[tuple[int, int], Sequence[int]], number: int,
    slide: Slide, limit: float,
) -> Iterator[Relation]:  # fmt: skip
    """Yield slider-cranks in line with a slide whose crank and coupler are equal."""
    pins, places = figure.pins, figure.places
    d = np.array([float(x) for x in slide.d])
    d /= np.linalg.norm(d)
    before, after = slide.links
    for first, C in product(range(len(pins)), repeat=2):
        if first == C or before not in pins[first].links or after not in pins[C].links:
            continue
        w = places[C] - places[first]
        offset = float(np.linalg.norm(w - (w @ d) * d))
        width = pins[first].links[before] + pins[C].links[after]
        width += sum(slide.angles) * float(np.linalg.norm(w))
        for A in range(len(pins)):
            if A in (first, C) or (first, A) not in between or (A, C) not in between:
                continue
            for a, b in product(between[first, A], between[A, C]):
                if len({a, b, before, after}) < 4:
                    continue
                error = abs(
                    figure.distance(places[first], places[A])
                    - figure.distance(places[A], places[C])
                )
                known = pins[first].links[a] + pins[A].links[a]
                known += pins[A].links[b] + pins[C].links[b]
                nearness = max(error / max(known, 1e-300), offset / max(width, 1e-300))
                if nearness <= limit and abs(w @ d) > PINS_DISTINCT * figure.size:
                    yield Relation(
                        "isosceles slider-crank", (first, A, C), (1, 1, 1), number,
                        max(error, offset), nearness,
                    )  # fmt: skip


def apply_relations(
    places: Sequence[Vector], relations: Sequence[Relation], slides: Sequence[Slide],
    normal: Vector | None,
) -> tuple[list[Vector], list[Relation]]:  # fmt: skip
    """Move pins so that relations hold exactly.

    Pins that no relation before has used are moved to the images that a relation gives them.

    Args:
        places: points of the pins in their plane, or unit vectors along them.
        relations: the relations.
        slides: joints that slide.
        normal: normal of the plane; None on a sphere.

    Returns:
        The places, and the relations that hold exactly.
    """
    moved, used = list(places), set[int]()
    for relation in sorted(relations, key=lambda x: (x.name != "rhombus", x.pins)):
        for pins, images in _choices(relation, moved, slides, normal):
            if not used & set(pins):
                for pin, image in zip(pins, images, strict=True):
                    moved[pin] = image
                break
        used |= set(relation.pins)
    holding = [
        relation for relation in relations
        if all(
            moved[pin] == image
            for pins, images in list(_choices(relation, moved, slides, normal))[:1]
            for pin, image in zip(pins, images, strict=True)
        )
    ]  # fmt: skip
    return moved, holding


def _choices(
    relation: Relation, places: Sequence[Vector], slides: Sequence[Slide],
    normal: Vector | None,
) -> Iterator[tuple[tuple[int, ...], tuple[Vector, ...]]]:  # fmt: skip
    """Yield pins that a relation can move, and their places."""
    if relation.slide >= 0:
        first, A, C = relation.pins
        d = slides[relation.slide].d
        for fixed, moving in ((first, C), (C, first)):
            w = _sum(places[A], places[fixed], -1)
            yield (moving,), (_sum(places[fixed], d, 2 * dot(w, d) / dot(d, d)),)
        return
    signed = [
        tuple(sign * x for x in places[pin])
        for sign, pin in zip(relation.signs, relation.pins, strict=True)
    ]
    if relation.name == "rhombus":
        P, Q, R, _ = signed
        h, middle = _sum(P, R, -1), tuple((x + y) / 2 for x, y in zip(P, R, strict=True))
        Q = _sum(Q, h, -dot(_sum(Q, middle, -1), h) / dot(h, h))
        yield (relation.pins[1], relation.pins[3]), (Q, _sum(_sum(P, R), Q, -1))
        return
    orders = [(0, 1, 2, 3), (0, 3, 2, 1)]
    if relation.name != "kite":
        orders += [(1, 0, 3, 2), (1, 2, 3, 0)]
    for order in orders:
        P, Q, R, _ = (signed[k] for k in order)
        image = _image(relation.name, P, Q, R, normal)
        sign = relation.signs[order[3]]
        yield (relation.pins[order[3]],), (tuple(sign * x for x in image),)
    if relation.name == "kite" and normal is not None:
        for axis in (0, 2):
            P, Q, S = signed[axis], signed[1], signed[3]
            h, middle = _sum(Q, S, -1), tuple((x + y) / 2 for x, y in zip(Q, S, strict=True))
            along = dot(_sum(P, middle, -1), h) / dot(h, h)
            yield (relation.pins[axis],), (_sum(P, h, -along),)


def _image(name: str, P: Vector, Q: Vector, R: Vector, normal: Vector | None) -> Vector:
    """Compute the image of Q under the displacement that a relation defines."""
    if name == "parallelogram":
        h = _sum(P, R)
        if normal is not None:
            return _sum(h, Q, -1)
        return _sum(tuple(-x for x in Q), h, 2 * dot(Q, h) / dot(h, h))
    if name == "antiparallelogram":
        h = _sum(P, R, -1)
        w = Q
        if normal is not None:
            w = _sum(Q, tuple((x + y) / 2 for x, y in zip(P, R, strict=True)), -1)
        return _sum(Q, h, -2 * dot(w, h) / dot(h, h))
    m = cross(normal, _sum(R, P, -1)) if normal is not None else cross(P, R)
    w = _sum(Q, P, -1) if normal is not None else Q
    return _sum(Q, m, -2 * dot(w, m) / dot(m, m))


def _sum(a: Vector, b: Vector, factor: Fraction | int = 1) -> Vector:
    """Compute ``a + factor b``."""
    return tuple(x + factor * y for x, y in zip(a, b, strict=True))
