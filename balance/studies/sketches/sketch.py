"""What a sketch has: points, links that carry them, sliders, and the points of the base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import NamedTuple, TypeAlias

from balance.studies.sketches.points import (
    Places,
    PointLike,
    place_points,
    read_direction,
    read_pairs,
    unknown_name,
)
from balance.studies.sketches.sketched_linkage import BASE
from kinematics.errors import SynthesisError, UsageError

NamesLike: TypeAlias = str | Sequence[str]
"""Names, or a text of names that are parted by commas."""

# Distance of two points up to which they are at one place, over the largest distance of a point
# from the origin.
COINCIDENT = 1e-9


class Sketch(NamedTuple):
    """A sketch whose names agree.

    Attributes:
        places: its points, metres.
        base: points of the base.
        links: points of each link that moves, sliders last.
        sliders: direction of each slider, of length 1.
        base_by_rule: whether the base has the points that one link alone has.
    """

    places: Places
    base: tuple[str, ...]
    links: Mapping[str, tuple[str, ...]]
    sliders: Mapping[str, complex]
    base_by_rule: bool

    @property
    def tool_points(self) -> list[tuple[str, str]]:
        """Links, each with a point that no other link has, nor the base."""
        every = [*self.base, *(point for names in self.links.values() for point in names)]
        return [
            (link, point)
            for link, names in self.links.items()
            for point in names
            if every.count(point) == 1 and link not in self.sliders
        ]


def read_sketch(
    points: str | Mapping[str, PointLike],
    links: str | Mapping[str, NamesLike],
    sliders: str | Mapping[str, str],
) -> Sketch:
    """Read points, links and sliders; see `balance.studies.linkage_from_sketch`.

    Raises:
        UsageError: one is written wrongly, or names what is not there.
        SynthesisError: there is no base, or two points of a link are at one place.
    """
    places = place_points(points)
    carried = {
        link: _read_names(link, names, places)
        for link, names in read_pairs("links", links, "crank=A,C; coupler=C,D").items()
    }
    given = carried.pop(BASE, None)
    slides = {}
    for slider, words in read_pairs("sliders", sliders, "piston=C@0deg").items():
        if slider in carried or slider == BASE:
            raise UsageError(f"slider '{slider}' is a link too: give it another name")
        point, at, direction = (word.strip() for word in words.partition("@"))
        if not at:
            raise UsageError(f"slider '{slider}': write POINT@ANGLE, or POINT@POINT")
        carried[slider] = _read_names(slider, point, places, least=1)
        way = read_direction(direction, point)
        _check_known(slider, way.needs, places)
        slides[slider] = way.place(places)
    base = _points_of_one_link(carried, slides) if given is None else given
    sketch = Sketch(places, base, carried, slides, given is None)
    _check_sketch(sketch)
    return sketch


def _read_names(link: str, names: NamesLike, places: Places, least: int = 2) -> tuple[str, ...]:
    """Read the points of a link.

    Raises:
        UsageError: there are too few, one is unknown, or one comes twice.
    """
    words = names.split(",") if isinstance(names, str) else names
    listed = tuple(word.strip() for word in words)
    _check_known(link, listed, places)
    if len(set(listed)) < len(listed):
        raise UsageError(f"link '{link}': a point is named twice")
    if len(listed) < least and link != BASE:
        raise UsageError(f"link '{link}' has one point: write two or more, {link}=A,B")
    return listed


def _check_known(link: str, names: Sequence[str], places: Places) -> None:
    """Refuse a point that is not there."""
    for point in names:
        if point not in places:
            raise UsageError(f"link '{link}': {unknown_name('point', point, places)}")


def _points_of_one_link(
    links: Mapping[str, Sequence[str]], sliders: Mapping[str, complex]
) -> tuple[str, ...]:
    """List the points that one link alone has, and no slider, in the order of the links."""
    every = [point for names in links.values() for point in names]
    sliding = {point for slider in sliders for point in links[slider]}
    return tuple(point for point in every if every.count(point) == 1 and point not in sliding)


def _check_sketch(sketch: Sketch) -> None:
    """Refuse a sketch without links or base, and points of a link that are at one place.

    Raises:
        UsageError: there is no link, or a point of the base is on none.
        SynthesisError: the base has no point, or two points coincide.
    """
    if not sketch.links:
        raise UsageError("links: none that moves: write crank=A,C; coupler=C,D")
    if not (sketch.base or sketch.sliders):
        problem = "no link is carried by the base: every point is on several links"
        raise SynthesisError(problem, "write base=A,B among the links")
    on_links = {point: names for names in sketch.links.values() for point in names}
    for point in sketch.base:
        if point not in on_links:
            raise UsageError(f"point '{point}' of the base is on no link that moves")
    for slider in sketch.sliders:
        (point,) = sketch.links[slider]
        if point in sketch.base:
            raise UsageError(f"slider '{slider}': its point {point} is on the base, too")
    farthest = max(map(abs, sketch.places.values()))
    for link, names in sketch.links.items():
        for first, second in combinations(names, 2):
            if abs(sketch.places[first] - sketch.places[second]) <= COINCIDENT * farthest:
                problem = f"link '{link}': points {first} and {second} are at one place"
                raise SynthesisError(problem, "correct one of them")
