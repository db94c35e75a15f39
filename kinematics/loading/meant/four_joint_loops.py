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

from kinematics.loading.meant.link_shapes import LinkShapes
from kinematics.loading.meant.link_widths import Width
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import Vector, add_vectors, cross, dot, scale_vector

# Most rigid links through which loops of four are looked for.
MAX_PINS = 60
# Distance of a pin from its image, in parts of the size or in half widths of the lengths, the
# larger of both, with which a relation of lengths is that of this image.
IMAGE_DISTANCE, IMAGE_WIDTHS = 1e-3, 4.0
# Distance of two pins that a loop of four joints may have: in parts of the size, or in half
# widths of their places, the lesser of both.
PINS_DISTINCT, PINS_DISTINCT_WIDTHS = 1e-6, 1e4


class Pin(NamedTuple):
    """Joints on one axis.

    Attributes:
        joints: their numbers.
        links: half width of the place of the pin on each rigid link that it joins.
    """

    joints: tuple[int, ...]
    links: Mapping[int, Width]

    def on(self, link: int, links: Sequence[tuple[int, int]]) -> int:
        """Find a joint of the pin that joins a rigid link.

        Args:
            link: number of the rigid link.
            links: rigid links before and after each joint.
        """
        return next(j for j in self.joints if link in links[j])


class Slide(NamedTuple):
    """A joint that slides in the plane.

    Attributes:
        joint: its number.
        links: rigid links before and after it.
        d: its direction.
        widths: half widths of its place and direction on each of the links.
    """

    joint: int
    links: tuple[int, int]
    d: Vector
    widths: tuple[Width, Width]


class LinkRelation(NamedTuple):
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
    links: Sequence[tuple[int, int]]
    shapes: LinkShapes
    lengths: dict[tuple[int, int, int], Length]

    def angle(self, a: Array, b: Array) -> float:
        """Angle between two unit vectors."""
        return float(np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b))

    def length(self, link: int, p: int, q: int) -> Length:
        """Length of a link between two pins of the plane."""
        key = link, min(p, q), max(p, q)
        if key not in self.lengths:
            self.lengths[key] = self._compute_length(link, p, q)
        return self.lengths[key]

    def _compute_length(self, link: int, p: int, q: int) -> Length:
        """Compute the length of a link between two pins; see `length`."""
        u = self.places[q] - self.places[p]
        length = float(np.linalg.norm(u))
        u = u / length
        pins = self.pins[p], self.pins[q]
        width = pins[0].links[link].along(u) + pins[1].links[link].along(u)
        joints = [pin.on(link, self.links) for pin in pins]
        square = self.shapes.square_of_distance(link, *joints)
        return Length(Fraction(length) ** 2 if square is None else square, length, width)


class Length(NamedTuple):
    """A length: its square, the length itself, and its half width."""

    square: Fraction
    length: float
    width: float

    def differs(self, other: Length) -> tuple[float, float]:
        """Compute the difference from another length, and the same in parts of its half width.

        Args:
            other: the other length.
        """
        error = abs(float(self.square - other.square)) / max(self.length + other.length, 1e-300)
        return error, error / max(self.width + other.width, 1e-300)


def find_relations(
    places: Array,
    pins: Sequence[Pin],
    slides: Sequence[Slide],
    planar: bool,
    size: float,
    limit: float,
    links: Sequence[tuple[int, int]],
    shapes: LinkShapes,
) -> list[LinkRelation]:
    """Find loops of four joints with equal links.

    Args:
        places: points of the pins in their plane, or unit vectors along them (pins, 3).
        slides: joints that slide in the plane.
        planar: whether the pins are in a plane, not on a sphere.
        size: of the linkage; 1 on a sphere.
        limit: largest nearness of a relation.
        links: rigid links before and after each joint.
        shapes: the axes on these links.

    Returns:
        The relations, each loop once.
    """
    if len(pins) > MAX_PINS:
        return []
    figure = _Figure(places, pins, planar, size, links, shapes, {})
    between: dict[tuple[int, int], list[int]] = {}
    for p, q in combinations(range(len(pins)), 2):
        shared = sorted(set(pins[p].links) & set(pins[q].links))
        apart = np.linalg.norm(places[p] - places[q])
        width = max((pins[k].links[link].place for k in (p, q) for link in shared), default=0.0)
        if shared and apart > min(PINS_DISTINCT * size, PINS_DISTINCT_WIDTHS * width):
            between[p, q] = between[q, p] = shared
    relations = [
        relation
        for loop, links_around in _loops_of_four(len(pins), between)
        if (relation := _relation_of(figure, loop, links_around, limit))
    ]
    for k, slide in enumerate(slides):
        relations += _slider_cranks(figure, between, k, slide, limit)
    return relations


def _loops_of_four(
    count: int, between: Mapping[tuple[int, int], Sequence[int]]
) -> Iterator[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Yield pins P, Q, R, S and links P Q, Q R, R S, S P of loops of four rigid links."""
    seen = set()
    for P, R in combinations(range(count), 2):
        middles = [
            (q, a, b)
            for q in range(count)
            if (P, q) in between and (q, R) in between
            for a in between[P, q]
            for b in between[q, R]
            if a != b
        ]
        for (Q, a, b), (S, d, c) in combinations(middles, 2):
            key = frozenset((P, Q, R, S)), frozenset((a, b, c, d))
            if Q != S and len(key[1]) == 4 and key not in seen:
                seen.add(key)
                yield (P, Q, R, S), (a, b, c, d)


def _relation_of(
    figure: _Figure, loop: tuple[int, ...], links: tuple[int, ...], limit: float
) -> LinkRelation | None:
    """Find the relation of a loop of four pins; None if it has none."""
    some_signs: list[tuple[int, ...]] = [(1, 1, 1, 1)]
    if not figure.planar:
        some_signs = [(1, *rest) for rest in product((1, -1), repeat=3)]
    best: LinkRelation | None = None
    for signs in some_signs:
        places = [s * figure.places[p] for s, p in zip(signs, loop, strict=True)]
        compare = _comparison(figure, loop, links, places)
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


def _comparison(
    figure: _Figure, loop: tuple[int, ...], links: tuple[int, ...], places: list[Array]
) -> Callable[[int, int], tuple[float, float]]:
    """Return what compares the lengths of two links: difference, and in parts of its width."""
    ends = [(k, (k + 1) % 4) for k in range(4)]
    if figure.planar:
        lengths = [
            figure.length(link, loop[k], loop[m])
            for link, (k, m) in zip(links, ends, strict=True)
        ]
        return lambda i, j: lengths[i].differs(lengths[j])
    angles = [figure.angle(places[k], places[m]) for k, m in ends]
    widths = [
        figure.pins[loop[k]].links[link].place + figure.pins[loop[m]].links[link].place
        for link, (k, m) in zip(links, ends, strict=True)
    ]

    def compare(i: int, j: int) -> tuple[float, float]:
        error = abs(angles[i] - angles[j])
        return error, error / max(widths[i] + widths[j], 1e-300)

    return compare


def _named(
    figure: _Figure,
    loop: tuple[int, ...],
    signs: tuple[int, ...],
    places: list[Array],
    close: Mapping[str, tuple[float, float, tuple[int, ...]]],
) -> LinkRelation | None:
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
        # The loop may be small beside the linkage.
        size = max(np.linalg.norm(P - Q), np.linalg.norm(Q - R), np.linalg.norm(R - P))
        width = error / nearness if nearness else 0.0
        if np.linalg.norm(image - S) <= max(IMAGE_DISTANCE * float(size), IMAGE_WIDTHS * width):
            pins, turned = (tuple(x[k] for k in order) for x in (loop, signs))
            return LinkRelation(name, pins, turned, -1, error, nearness)
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
    figure: _Figure,
    between: Mapping[tuple[int, int], Sequence[int]],
    number: int,
    slide: Slide,
    limit: float,
) -> Iterator[LinkRelation]:
    """Yield slider-cranks in line with a slide whose crank and coupler are equal."""
    pins, places = figure.pins, figure.places
    d = np.array([float(x) for x in slide.d])
    d /= np.linalg.norm(d)
    before, after = slide.links
    for first, C in product(range(len(pins)), repeat=2):
        if first == C or before not in pins[first].links or after not in pins[C].links:
            continue
        w = places[C] - places[first]
        across = w - (w @ d) * d
        offset = float(np.linalg.norm(across))
        along = abs(float(w @ d))
        if along <= PINS_DISTINCT * figure.size or offset > IMAGE_DISTANCE * along:
            continue
        width = _offset_width(pins[first], pins[C], slide, d, w)
        for A in range(len(pins)):
            if A in (first, C) or (first, A) not in between or (A, C) not in between:
                continue
            for a, b in product(between[first, A], between[A, C]):
                if len({a, b, before, after}) < 4:
                    continue
                crank, coupler = figure.length(a, first, A), figure.length(b, A, C)
                error, nearness = crank.differs(coupler)
                nearness = max(nearness, offset / max(width, 1e-300))
                if nearness <= limit:
                    yield LinkRelation(
                        "isosceles slider-crank",
                        (first, A, C),
                        (1, 1, 1),
                        number,
                        max(error, offset),
                        nearness,
                    )


def _offset_width(first: Pin, last: Pin, slide: Slide, d: Array, w: Array) -> float:
    """Half width of the distance of a pin from the line of a slide through another pin."""
    across = np.eye(3) - np.outer(d, d)
    total = 0.0
    for link, width, pin in zip(slide.links, slide.widths, (first, last), strict=True):
        place = pin.links[link]
        edges = np.array([*place.box, *width.box]).reshape(-1, 3) @ across
        total += float(np.linalg.norm(edges, axis=1).sum()) + place.rest + width.rest
        total += width.angle * float(np.linalg.norm(w))
    return total


def apply_relations(
    places: Sequence[Vector],
    relations: Sequence[LinkRelation],
    slides: Sequence[Slide],
    normal: Vector | None,
) -> tuple[list[Vector], list[LinkRelation]]:
    """Move pins so that relations hold exactly.

    Pins that no relation before has used are moved to the images that a relation gives them.

    Args:
        places: points of the pins in their plane, or unit vectors along them.
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
        relation
        for relation in relations
        if all(
            moved[pin] == image
            for pins, images in list(_choices(relation, moved, slides, normal))[:1]
            for pin, image in zip(pins, images, strict=True)
        )
    ]
    return moved, holding


def _choices(
    relation: LinkRelation,
    places: Sequence[Vector],
    slides: Sequence[Slide],
    normal: Vector | None,
) -> Iterator[tuple[tuple[int, ...], tuple[Vector, ...]]]:
    """Yield pins that a relation can move, and their places."""
    if relation.slide >= 0:
        first, A, C = relation.pins
        d = slides[relation.slide].d
        for fixed, moving in ((first, C), (C, first)):
            w = add_vectors(places[A], places[fixed], -1)
            yield (moving,), (add_vectors(places[fixed], d, 2 * dot(w, d) / dot(d, d)),)
        return
    signed = [
        tuple(sign * x for x in places[pin])
        for sign, pin in zip(relation.signs, relation.pins, strict=True)
    ]
    if relation.name == "rhombus":
        P, Q, R, _ = signed
        h, middle = add_vectors(P, R, -1), _middle(P, R)
        Q = add_vectors(Q, h, -dot(add_vectors(Q, middle, -1), h) / dot(h, h))
        yield (relation.pins[1], relation.pins[3]), (Q, add_vectors(add_vectors(P, R), Q, -1))
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
            h, middle = add_vectors(Q, S, -1), _middle(Q, S)
            along = dot(add_vectors(P, middle, -1), h) / dot(h, h)
            yield (relation.pins[axis],), (add_vectors(P, h, -along),)


def _image(name: str, P: Vector, Q: Vector, R: Vector, normal: Vector | None) -> Vector:
    """Compute the image of Q under the displacement that a relation defines."""
    if name == "parallelogram":
        h = add_vectors(P, R)
        if normal is not None:
            return add_vectors(h, Q, -1)
        return add_vectors(tuple(-x for x in Q), h, 2 * dot(Q, h) / dot(h, h))
    if name == "antiparallelogram":
        h = add_vectors(P, R, -1)
        w = Q
        if normal is not None:
            w = add_vectors(Q, _middle(P, R), -1)
        return add_vectors(Q, h, -2 * dot(w, h) / dot(h, h))
    m = cross(normal, add_vectors(R, P, -1)) if normal is not None else cross(P, R)
    w = add_vectors(Q, P, -1) if normal is not None else Q
    return add_vectors(Q, m, -2 * dot(w, m) / dot(m, m))


def _middle(a: Vector, b: Vector) -> Vector:
    """Compute the middle of two points."""
    return scale_vector(Fraction(1, 2), add_vectors(a, b))
