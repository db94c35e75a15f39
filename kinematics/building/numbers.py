"""Numbers that a program gives for a linkage: checked, and told apart exactly."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from decimal import Decimal, localcontext

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinematics.error_text import clean, closest_names
from kinematics.tolerances import INERTIA_ASYMMETRY
from kinematics.urdf.input_files import ReadOptions
from kinematics.urdf.validate_fields import MAX_NUMBER, SMALLEST_AXIS
from kinematics.urdf.xml_tree import Refusal

__all__ = [
    "BodyLike",
    "checked_array",
    "bodies_by_link",
    "links_and_joints",
    "exact_differences",
    "checked_direction",
    "checked_name",
    "find_by_name",
]

Array = NDArray[np.float64]
BodyLike = tuple[float, ArrayLike, ArrayLike]
"""Mass (kg), centre of mass (3,) and inertia tensor about that centre (3, 3)."""


def find_by_name(kind: str, name: object) -> str:
    """How messages call an item, such as ``joint 'j1'``."""
    return f"{kind} '{clean(str(name))}'"


def checked_name(label: str, what: str, value: object) -> str:
    """A name, which must be a text that is not empty."""
    if not isinstance(value, str) or not value.strip():
        text = clean(repr(value), 40)
        raise Refusal(label, f"{what} is {text}, not a name", f"give {what} as a text")
    return value


def checked_array(label: str, what: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Finite numbers of a shape.

    Raises:
        Refusal: they are not; ``label`` says of what, and ``what`` which numbers.
    """
    count = " by ".join(map(str, shape)) if shape else "one"
    try:
        found = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        found = np.array(np.nan)
    if found.shape != shape or not np.all(np.abs(found) <= MAX_NUMBER):
        numbers = "number" if not shape else "numbers"
        problem = f"{what} = {clean(repr(value), 60)} is not {count} finite {numbers}"
        raise Refusal(label, problem, f"give {count} finite {numbers}")
    return found


def checked_direction(label: str, what: str, value: ArrayLike) -> Array:
    """A direction (3,) of any length but zero."""
    axis = checked_array(label, what, value, (3,))
    if np.linalg.norm(axis) < SMALLEST_AXIS:
        raise Refusal(label, f"{what} is zero", f"give {what} a direction, such as (0, 0, 1)")
    return axis


def exact_differences(ends: Iterable[float], starts: Iterable[float]) -> str:
    """The words of ``end - start``, exact in the decimals of the numbers.

    0.3 - 0.1 is 0.2, where floating-point arithmetic finds 0.19999999999999998: loops that
    close in the decimals of the user close exactly.
    """
    with localcontext() as context:
        context.prec = 60
        pairs = zip(map(float, ends), map(float, starts), strict=True)
        exact = [Decimal(repr(end)) - Decimal(repr(start)) for end, start in pairs]
        return " ".join(str(d.normalize()) if d else "0" for d in exact)


def links_and_joints(bodies: Mapping[str, BodyLike] | None) -> ReadOptions:
    """Which bodies carry parameters: those that are named, or all if none is given."""
    return ReadOptions(bodies="all" if bodies is None else "given")


def bodies_by_link(
    bodies: Mapping[str, BodyLike] | None, frames: Mapping[str, ArrayLike]
) -> dict[str, tuple[float, Array, Array]]:
    """Masses, centres of mass and inertias of links, checked.

    Args:
        bodies: by the name of the link.
        frames: what the links are; only names count.

    Raises:
        Refusal: there is no such link, or a number is missing or not finite.
    """
    found = {}
    for name, body in (bodies or {}).items():
        label = find_by_name("body", name)
        if name not in frames:
            remedy = f"correct the name; the links are {closest_names(str(name), frames)}"
            raise Refusal(label, "there is no such link", remedy)
        try:
            mass, com, inertia = body
        except (TypeError, ValueError):
            problem = f"{clean(repr(body), 60)} is not mass, centre of mass and inertia"
            raise Refusal(label, problem, "give (kg, 3 numbers, 3 by 3 numbers)") from None
        tensor = checked_array(label, "inertia", inertia, (3, 3))
        if np.abs(tensor - tensor.T).max() > INERTIA_ASYMMETRY * np.abs(tensor).max():
            problem = "inertia is not symmetric"
            raise Refusal(label, problem, "give the tensor about the centre of mass")
        found[name] = (
            float(checked_array(label, "mass", mass, ())),
            checked_array(label, "com", com, (3,)),
            tensor,
        )
    return found
