"""Points of a sketch in the plane: coordinates, steps from a point, and where circles meet.

With complex numbers z = x + iy, in metres:

- ``A=0,400mm``: coordinates;
- ``C=A+250mm@120deg``: ``z_C = z_A + l e^(iα)``, α from the x axis;
- ``P=C+80mm@E``: the same with α the direction from C to E; a negative length leads away;
- ``E=C:350mm,D:350mm``: where the circles about C and D meet. With u of length 1 from C to D,
  ``z_E = z_C + (a + ih) u``, ``a = (d² + r_C² - r_D²) / 2d`` and ``h = √(r_C² - a²)``, on the
  left seen from C to D;
- ``C=A:180mm,O@0``: where the circle about A meets the line from O with this direction, the
  farther one.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Mapping, Sequence
from graphlib import CycleError, TopologicalSorter
from typing import Any, NamedTuple, TypeAlias

from balance.support.units import UnitNumber, read_quantity
from kinematics.error_text import clean, closest_names, did_you_mean
from kinematics.errors import SynthesisError, UsageError
from kinematics.wording import number_text

Places: TypeAlias = Mapping[str, complex]
"""Points by name, metres."""
PointLike: TypeAlias = str | Sequence[float]
"""A point in words, or its two coordinates in metres."""

# Largest coordinate or length, metres.
LARGEST = 1e6
# Decimals of coordinates, which lets 0.25 cos 120° be -0.125.
DECIMALS = 15
# Key of the value of all names that are not given.
FOR_ALL = ""
# Part of the radii of two circles by which they may miss each other, for round-off.
TOUCHING = 1e-12
FORMS = "x,y or A+LENGTH@ANGLE or A:LENGTH,B:LENGTH or A:LENGTH,B@ANGLE"


class _Rule(NamedTuple):
    """How a point follows from others.

    Attributes:
        needs: the names of the others.
        place: computes it from them.
    """

    needs: tuple[str, ...]
    place: Callable[[Places], complex]


def place_points(points: str | Mapping[str, PointLike]) -> dict[str, complex]:
    """Compute the points of a sketch.

    Args:
        points: ``"A=0,0; B=400mm,0; …"``, or points by name.

    Returns:
        The points by name, in their order; metres.

    Raises:
        UsageError: there is no point, or one is written wrongly, twice, or from unknown points
            or itself.
        SynthesisError: two circles do not meet, or a direction is from a point to itself.

    Example:
        >>> from balance.studies.sketches.points import place_points
        >>> place_points("A=0,0; B=600mm,0; C=A:0.5,B:0.5")["C"]
        (0.3+0.4j)
    """
    example = "A=0,0; B=A+250mm@60deg"
    rules = {
        name: _read_point(name, value)
        for name, value in read_pairs("points", points, example).items()
    }
    if not rules:
        raise UsageError(f'points: there are none: write "{example}"')
    for name, rule in rules.items():
        for other in rule.needs:
            if other not in rules:
                raise UsageError(f"point '{name}': {unknown_name('point', other, rules)}")
    needs = {name: rule.needs for name, rule in rules.items()}
    try:
        order = list(TopologicalSorter(needs).static_order())
    except CycleError as error:
        chain = " needs ".join(reversed(error.args[1]))
        raise UsageError(f"points: {chain}: give one of them coordinates") from None
    places: dict[str, complex] = {}
    for name in order:
        z = rules[name].place(places)
        places[name] = complex(round(z.real, DECIMALS), round(z.imag, DECIMALS)) + 0.0
    return {name: places[name] for name in rules}


def read_pairs(
    what: str,
    given: Any,
    example: str,
    separator: str = ";",
    *,
    for_all: bool = False,
) -> dict[str, Any]:
    """Read ``NAME=VALUE`` between separators, or take a mapping as it is.

    Args:
        what: the argument, for messages.
        given: a text, or values by name.
        example: how it is written, for messages.
        separator: the character between two pairs.
        for_all: whether a value may have no name. It holds for all other names; its key is
            `FOR_ALL`.

    Raises:
        UsageError: it is neither a text nor a mapping, a value has no name, or a name is none
            or comes twice.
    """
    if not isinstance(given, (str, Mapping)):
        kind = type(given).__name__
        raise UsageError(
            f'{what}: write "{example}", or give a mapping; this is of type {kind}'
        )
    pairs: list[tuple[str, Any]] = [*given.items()] if isinstance(given, Mapping) else []
    if isinstance(given, str):
        words = [word.rpartition("=") for word in given.split(separator) if word.strip()]
        pairs = [(name.strip(), value.strip()) for name, _, value in words]
    named: dict[str, Any] = {}
    for name, value in pairs:
        if name == FOR_ALL and not for_all:
            text = clean(str(value))
            raise UsageError(f"{what}: '{text}' has no name: write \"{example}\"")
        if name != FOR_ALL and not str(name).isidentifier():
            text = "is no name: take letters, digits and _, and a letter first"
            raise UsageError(f"{what}: '{clean(str(name))}' {text}")
        if name in named:
            item = f"'{clean(name)}'" if name else "a value for all links"
            raise UsageError(f"{what}: {item} is given twice")
        named[name] = value
    return named


def unknown_name(kind: str, name: str, known: Mapping[str, object]) -> str:
    """Say that there is no such item, and which there are.

    Args:
        kind: what it would be.
        known: the items by name.
    """
    names = closest_names(name, known)
    return f"no {kind} '{clean(name)}'{did_you_mean(name, known)}; there are {names}"


def read_length(text: str) -> float:
    """Read a length in metres or with a unit, then a `UnitNumber`.

    Raises:
        UsageError: it is none, or beyond 1000 km.
    """
    value = read_quantity(text.strip(), "length")
    if not abs(value) <= LARGEST:
        raise UsageError(f"'{clean(text)}' is no length up to {LARGEST:g} m")
    return value


def read_direction(text: str, start: str) -> _Rule:
    """Read the direction from a point: an angle from the x axis, or another point.

    Args:
        text: ``120deg``, ``2rad``, ``0``, or the name of a point.
        start: name of the point.

    Returns:
        A rule for ``e^(iα)``.

    Raises:
        UsageError: it is neither, or an angle other than 0 has no unit.
    """
    word = text.strip()
    if word.isidentifier():
        return _Rule((start, word), lambda places: _direction(places, start, word))
    angle = read_quantity(word, "angle")
    if not math.isfinite(angle):
        raise UsageError(f"'{clean(text)}' is no angle")
    if angle and not isinstance(angle, UnitNumber):
        number = clean(word)
        raise UsageError(f"angle '{number}' has no unit: write {number}deg or {number}rad")
    return _Rule((start,), lambda _: cmath.exp(1j * angle))


def _read_point(name: str, value: PointLike) -> _Rule:
    """Read how a point is given."""
    try:
        if not isinstance(value, str):
            value = ",".join(map(str, value))
        if ":" in value:
            return _read_meeting(name, value)
        if "@" in value:
            return _read_step(value)
        x, y = map(read_length, _split(value, ","))
    except UsageError as error:
        raise UsageError(f"point '{name}': {error}") from None
    return _Rule((), lambda _: complex(x, y))


def _split(text: str, character: str) -> list[str]:
    """Split a text into two parts."""
    parts = [part.strip() for part in text.split(character)]
    if len(parts) != 2 or not all(parts):
        raise UsageError(f"'{clean(text)}' is not {FORMS}")
    return parts


def _read_step(text: str) -> _Rule:
    """Read ``POINT+LENGTH@DIRECTION``."""
    step, direction = _split(text, "@")
    start, plus, size = (word.strip() for word in step.partition("+"))
    if not plus or not start.isidentifier():
        raise UsageError(f"'{clean(text)}' is not {FORMS}")
    length, way = read_length(size), read_direction(direction, start)
    return _Rule(way.needs, lambda places: places[start] + length * way.place(places))


def _read_meeting(name: str, text: str) -> _Rule:
    """Read ``POINT:LENGTH,POINT:LENGTH``, or ``POINT:LENGTH,POINT@DIRECTION``."""
    parts = _split(text, ",")
    lines = [part for part in parts if "@" in part]
    circles = [_read_circle(part) for part in parts if part not in lines]
    if len(circles) == 2:
        (first, r), (second, s) = circles
        if first == second:
            raise UsageError(f"'{clean(text)}': both distances are from {first}")
        return _Rule(
            (first, second), lambda places: _meeting(name, (first, second), (r, s), places)
        )
    if not circles:
        raise UsageError(f"'{clean(text)}' is not {FORMS}")
    (centre, r), (start, direction) = circles[0], _split(lines[0], "@")
    way = read_direction(direction, start)
    return _Rule(
        (centre, *way.needs),
        lambda places: _farther_meeting(name, (centre, start), r, way.place(places), places),
    )


def _read_circle(text: str) -> tuple[str, float]:
    """Read ``POINT:LENGTH``."""
    centre, size = _split(text, ":")
    radius = read_length(size)
    if radius <= 0.0:
        raise UsageError(f"'{clean(text)}': a distance is a positive length")
    return centre, radius


def _farther_meeting(
    name: str, names: tuple[str, str], r: float, way: complex, places: Places
) -> complex:
    """Compute where a circle meets a line, the farther one along the line.

    Args:
        names: of the centre, and of a point of the line.
        r: radius, metres.
        way: direction of the line, of length 1.
    """
    centre, start = (places[each] for each in names)
    along = (centre - start) * way.conjugate()
    off = abs(along.imag)
    if off > r * (1.0 + TOUCHING):
        problem = f"the line through {names[1]} passes {names[0]} at {_mm(off)}"
        raise SynthesisError(f"point '{name}': {problem}", f"add {_mm(off - r)} to {_mm(r)}")
    return start + (along.real + math.sqrt(max((r - off) * (r + off), 0.0))) * way


def _meeting(
    name: str, centres: tuple[str, str], radii: tuple[float, float], places: Places
) -> complex:
    """Compute where two circles meet, on the left seen from the first centre to the second."""
    (r, s), start = radii, places[centres[0]]
    d = abs(places[centres[1]] - start)
    if not d:
        problem = f"points {centres[0]} and {centres[1]} are at one place"
        problem = f"point '{name}': {problem}: two distances from it give no point"
        raise SynthesisError(problem, "correct one of them")
    about = f"about {centres[0]} and {centres[1]}, which are {_mm(d)} apart"
    slack = TOUCHING * (r + s)
    if d > r + s + slack:
        problem = f"the circles {about}, do not meet: their radii add up to {_mm(r + s)}"
        remedy = f"lengthen them by {_mm(d - r - s)} in all"
        raise SynthesisError(f"point '{name}': {problem}", remedy)
    if d < abs(r - s) - slack:
        problem = f"the circles {about}, do not meet: their radii differ by {_mm(abs(r - s))}"
        remedy = f"let them differ by {_mm(abs(r - s) - d)} less"
        raise SynthesisError(f"point '{name}': {problem}", remedy)
    a = (d * d + (r - s) * (r + s)) / (2.0 * d)
    h = math.sqrt(max((r - a) * (r + a), 0.0))
    return start + complex(a, h) * _direction(places, *centres)


def _direction(places: Places, start: str, end: str) -> complex:
    """Compute the direction from a point to another, of length 1."""
    step = places[end] - places[start]
    if not step:
        problem = f"points {start} and {end} are at one place, and have no direction"
        raise SynthesisError(problem, "correct one of them")
    return step / abs(step)


def _mm(length: float) -> str:
    """Write a length in millimetres."""
    return f"{number_text(1e3 * length, '.6g')} mm"
