"""Texts of regions, such as ``ball(0,0,0.1,0.2)`` or ``80mm``, and what they mean."""

from __future__ import annotations

import numpy as np

from balance.masses.counterweights.mesh_region import mesh_region
from balance.masses.counterweights.regions import (
    Region,
    ball_region,
    box_region,
    cylinder_region,
    ellipsoid_region,
)
from balance.support.units import read_quantity
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array

COLLISION = "collision"
USAGE = {
    "ball": "ball(x,y,z,r)",
    "box": "box(x0:x1,y0:y1,z0:z1) or with ,roll,pitch,yaw",
    "cylinder": "cylinder(x,y,z,ax,ay,az,r,length)",
    "ellipsoid": "ellipsoid(x,y,z,a,b,c) or with ,roll,pitch,yaw",
    "mesh": "mesh(FILE.stl) in metres or mesh(FILE.stl,1mm)",
}
# What each number of a region is; a direction is a number without a unit.
_LENGTH, _ANGLE, _DIRECTION = ("length",), ("angle",), ()
_QUANTITIES: dict[str, tuple[tuple[str, ...], ...]] = {
    "ball": (_LENGTH,) * 4,
    "box": (*(_LENGTH,) * 6, *(_ANGLE,) * 3),
    "cylinder": (*(_LENGTH,) * 3, *(_DIRECTION,) * 3, *(_LENGTH,) * 2),
    "ellipsoid": (*(_LENGTH,) * 6, *(_ANGLE,) * 3),
}


def read_region(text: str) -> Region:
    """Read a region from its text, such as ``ball(0,0,0.1,0.2)``.

    Texts that have a meaning for a link alone are refused; see `depends_on_link`.

    Raises:
        FileError: the file of a mesh is none of a closed convex one.
        UsageError: the text has another form, or the region is empty or inside out.
    """
    words = text.strip()
    kind, _, inner = words.partition("(")
    if is_mesh(words):
        file, scale = _mesh_file(words)
        return mesh_region(file, scale, words)
    numbers = _numbers(inner, ":" if kind == "box" else "", _QUANTITIES.get(kind, ()))
    if kind in USAGE and words.endswith(")") and numbers is not None:
        if kind == "ball" and numbers.size == 4:
            return ball_region(numbers[:3], float(numbers[3]))
        if kind == "box" and numbers.size in (6, 9) and _are_ranges(inner):
            return box_region(numbers[:6:2], numbers[1:6:2], _angles(numbers))
        if kind == "cylinder" and numbers.size == 8:
            return cylinder_region(
                numbers[:3], numbers[3:6], float(numbers[6]), float(numbers[7])
            )
        if kind == "ellipsoid" and numbers.size in (6, 9):
            return ellipsoid_region(numbers[:3], numbers[3:6], _angles(numbers))
    usage = f"{USAGE[kind]} in numbers, metres or with a unit" if kind in USAGE else ""
    forms = ["80mm (about its joint)", *USAGE.values(), COLLISION]
    raise UsageError(f"region '{text}' has no known form: write {usage or ', '.join(forms)}")


def depends_on_link(text: str) -> bool:
    """Whether a region needs its link: ``collision``, or a radius (see `read_radius`)."""
    return text.strip() == COLLISION or read_radius(text) is not None


def read_radius(text: str) -> float | None:
    """Read the radius, metres, of a ball about the joint that carries a link: ``80mm``.

    Returns:
        The radius; None for a text of another form.

    Raises:
        UsageError: the radius is not above 0.
    """
    try:
        radius = read_quantity(text.strip(), *_LENGTH)
    except UsageError:
        return None
    if not 0.0 < radius < np.inf:
        raise UsageError(f"region '{text}' has no size: a radius is a length above 0")
    return radius


def is_mesh(text: str) -> bool:
    """Whether the text of a region names the file of a mesh."""
    return text.strip().startswith("mesh(") and text.strip().endswith(")")


def _mesh_file(words: str) -> tuple[str, float]:
    """Read path and unit, in metres, of ``mesh(FILE)`` or ``mesh(FILE,UNIT)``.

    Raises:
        UsageError: it has no path, or the unit is no length above 0.
    """
    file, comma, unit = words[len("mesh(") : -1].rpartition(",")
    file = file if comma else unit
    scale = read_quantity(unit, *_LENGTH) if comma else 1.0
    if not file or not 0.0 < scale < np.inf:
        raise UsageError(f"region '{words}' has no known form: write {USAGE['mesh']}")
    return file.strip(), scale


def _angles(numbers: Array) -> Array:
    """Return the last three of nine numbers; zero for fewer."""
    return numbers[6:] if numbers.size == 9 else np.zeros(3)


def _are_ranges(inner: str) -> bool:
    """Whether the first three of the words between commas, and no others, are ranges."""
    ranges, angles = [1, 1, 1], [0, 0, 0]
    return [word.count(":") for word in inner.split(",")] in (ranges, ranges + angles)


def _numbers(
    inner: str, separator: str, quantities: tuple[tuple[str, ...], ...]
) -> Array | None:
    """Parse the numbers of ``a,12mm:c)``; None if one is no number, or they are too many."""
    words = inner.removesuffix(")").split(",")
    split = [word.split(separator) if separator else [word] for word in words]
    parts = [part for group in split for part in group]
    if len(parts) > len(quantities):
        return None
    try:
        return np.array(
            [
                read_quantity(part, *units)
                for part, units in zip(parts, quantities, strict=False)
            ]
        )
    except UsageError:
        return None
