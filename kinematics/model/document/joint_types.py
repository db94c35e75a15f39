"""Joint types of a URDF file and of its loops: degrees of freedom and names of coordinates."""

from __future__ import annotations

DEGREES_OF_FREEDOM = {
    "fixed": 0,
    "revolute": 1,
    "continuous": 1,
    "prismatic": 1,
    "universal": 2,
    "cylindrical": 2,
    "planar": 3,
    "spherical": 3,
    "floating": 6,
}
"""Degrees of freedom of the joint types, of tree joints and of loops alike."""


def coordinate_names(name: str, kind: str) -> list[str]:
    """Compose the names of the coordinates of a joint: ``name``, or ``name.0``, ``name.1`` ….

    Args:
        kind: its type in the file, a key of `DEGREES_OF_FREEDOM`.
    """
    count = DEGREES_OF_FREEDOM[kind]
    return [name] if count == 1 else [f"{name}.{k}" for k in range(count)]
