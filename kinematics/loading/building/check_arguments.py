"""Check the numbers and names of a linkage that a program builds."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from decimal import Decimal, localcontext

import numpy as np
from numpy.typing import ArrayLike

from kinematics.error_text import clean, closest_names
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.files.urdf.validate_fields import MAX_NUMBER, SMALLEST_AXIS
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import INERTIA_ASYMMETRY

BodyLike = tuple[float, ArrayLike, ArrayLike]
"""Mass (kg), centre of mass (3,) (m) and inertia about that centre (3, 3) (kg m²)."""


def find_by_name(kind: str, name: object) -> str:
    """Compose the label of an item for messages, such as ``joint 'j1'``.

    Args:
        kind: kind of the item.
        name: its name, of any type.

    Returns:
        The label, free of unprintable characters.
    """
    return f"{kind} '{clean(str(name))}'"


def checked_name(label: str, what: str, value: object) -> str:
    """Return a name, which must be a text that is not empty.

    Args:
        what: attribute of the item in messages.

    Raises:
        Refusal: it is empty, or no text.
    """
    if not isinstance(value, str) or not value.strip():
        text = clean(repr(value), 40)
        raise Refusal(label, f"{what} is {text}, not a name", f"give {what} as a text")
    return value


def checked_array(label: str, what: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Convert numbers to an array of a given shape, all of them finite.

    Args:
        what: attribute of the item in messages.
        shape: their shape.

    Raises:
        Refusal: the shape is another one, or a number is not finite.
    """
    count = " by ".join(map(str, shape)) if shape else "one"
    try:
        array = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        array = np.array(np.nan)
    if array.shape != shape or not np.all(np.abs(array) <= MAX_NUMBER):
        numbers = "number" if not shape else "numbers"
        problem = f"{what} = {clean(repr(value), 60)} is not {count} finite {numbers}"
        raise Refusal(label, problem, f"give {count} finite {numbers}")
    return array


def checked_direction(label: str, what: str, value: ArrayLike) -> Array:
    """Convert a direction to an array (3,), of any length but zero.

    Args:
        what: attribute of the item in messages.
        value: the direction (3,).

    Raises:
        Refusal: it is zero, or not three finite numbers.
    """
    axis = checked_array(label, what, value, (3,))
    if np.linalg.norm(axis) < SMALLEST_AXIS:
        raise Refusal(label, f"{what} is zero", f"give {what} a direction, such as (0, 0, 1)")
    return axis


def exact_differences(ends: Iterable[float], starts: Iterable[float]) -> str:
    """Compute ``end - start`` as text, exact in the decimals of the numbers.

    0.3 - 0.1 is 0.2, where floating-point arithmetic finds 0.19999999999999998: loops that
    close in the decimals of the user close exactly.

    Args:
        ends: numbers (n,).
        starts: numbers (n,), in the same unit.

    Returns:
        The differences as decimals, separated by blanks.
    """
    with localcontext() as context:
        context.prec = 60
        pairs = zip(map(float, ends), map(float, starts), strict=True)
        exact = [Decimal(repr(end)) - Decimal(repr(start)) for end, start in pairs]
        return " ".join(str(d.normalize()) if d else "0" for d in exact)


def links_and_joints(bodies: Mapping[str, BodyLike] | None) -> ReadOptions:
    """Choose the bodies that carry parameters: those with an entry, or all without entries."""
    return ReadOptions(bodies="all" if bodies is None else "given")


def bodies_by_link(
    bodies: Mapping[str, BodyLike] | None, frames: Mapping[str, ArrayLike]
) -> dict[str, tuple[float, Array, Array]]:
    """Check masses, centres of mass and inertias of links.

    Args:
        bodies: mass, centre of mass and inertia by the name of the link.
        frames: the links; only their names count.

    Returns:
        Mass (kg), centre of mass (3,) (m) and inertia about that centre (3, 3) (kg m²), in the
        frames in which they were given.

    Raises:
        Refusal: there is no such link, or a number is missing or not finite.
    """
    parameters = {}
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
        parameters[name] = (
            float(checked_array(label, "mass", mass, ())),
            checked_array(label, "com", com, (3,)),
            tensor,
        )
    return parameters
