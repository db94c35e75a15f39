"""Bars between points: their mass, inertia and shape.

A bar of length l is a box with the width w in the plane and the thickness t along z, or a
cylinder of diameter w. It ends at its points. About its centre, along (x), across in the plane
(y) and normal to it (z):

    box        m = ρ l w t,      I = m/12 (w² + t², l² + t², l² + w²)
    cylinder   m = ρ l π w²/4,   I = m (w²/8, l²/12 + w²/16, l²/12 + w²/16)
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.studies.sketches.points import read_length
from balance.support.units import UnitNumber
from kinematics.error_text import clean
from kinematics.errors import UsageError
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, round_to_ten_digits


class BarSection(NamedTuple):
    """The section of a bar.

    Attributes:
        width: in the plane, or the diameter; metres.
        thickness: along z, metres.
        circular: whether it is a disc.
    """

    width: float
    thickness: float
    circular: bool = False

    @property
    def area(self) -> float:
        """Area, m²."""
        factor = math.pi / 4.0 if self.circular else 1.0
        return factor * self.width * self.thickness

    @property
    def words(self) -> str:
        """The section in mm: ``30 × 10`` or ``ø 20``."""
        width, thickness = (number_text(1e3 * x) for x in (self.width, self.thickness))
        return f"ø {width}" if self.circular else f"{width} × {thickness}"


LINE = BarSection(0.0, 0.0)
"""The section of a line."""


class UniformSolid(NamedTuple):
    """A solid body of uniform density.

    Attributes:
        mass: kg.
        centre: of mass (3,), metres.
        inertia: about the centre (3, 3), kg m².
    """

    mass: float
    centre: Array
    inertia: Array


def read_section(text: str) -> BarSection:
    """Read ``30mmx10mm``, width and thickness, or ``d20mm``, a diameter.

    Raises:
        UsageError: it is neither, a size is not positive, or one alone has a unit.
    """
    word = text.strip().replace("×", "x")
    circular = word[:1] in ("d", "ø", "⌀")
    sizes = [word[1:]] if circular else word.split("x")
    if not (circular or len(sizes) == 2):
        raise UsageError(
            f"section '{clean(text)}' is not WIDTHxTHICKNESS, as in 30mmx10mm, or dDIAMETER"
        )
    try:
        values = [read_length(size) for size in sizes]
    except UsageError as error:
        raise UsageError(f"section '{clean(text)}': {error}") from None
    if min(values) <= 0.0:
        raise UsageError(f"section '{clean(text)}': sizes are positive")
    if len({isinstance(value, UnitNumber) for value in values}) > 1:
        problem = "one size has no unit: give both one, as in 30mmx10mm"
        raise UsageError(f"section '{clean(text)}': {problem}")
    return BarSection(values[0], values[-1], circular)


def make_bar(
    start: complex, end: complex, section: BarSection, line_density: float
) -> UniformSolid:
    """Compute mass, centre and inertia of a bar between two points.

    Args:
        start: one end, in the frame of its link, metres.
        end: the other.
        line_density: mass per length, kg/m.
    """
    length, (w, t) = abs(end - start), section[:2]
    mass = line_density * length
    if section.circular:
        axial, across, normal = w * w / 8.0, *[length**2 / 12.0 + w * w / 16.0] * 2
    else:
        squares = (w * w + t * t, length**2 + t * t, length**2 + w * w)
        axial, across, normal = (square / 12.0 for square in squares)
    along = in_space((end - start) / length)
    beside = in_space(1j * (end - start) / length)
    inertia = mass * (
        axial * np.outer(along, along)
        + across * np.outer(beside, beside)
        + np.diag([0.0, 0.0, normal])
    )
    return UniformSolid(mass, in_space(0.5 * (start + end)), inertia)


def make_visual(start: complex, end: complex, section: BarSection) -> Element:
    """Make the ``<visual>`` of a bar: a box, or a cylinder turned from its z axis onto it."""
    length, yaw = _round([abs(end - start), cmath.phase(end - start)])
    pitch = 0.5 * math.pi if section.circular else 0.0
    middle = in_space(0.5 * (start + end))
    at = {"xyz": number_words(_round(middle)), "rpy": number_words([0.0, pitch, yaw])}
    shape = Element("box", {"size": number_words([length, section.width, section.thickness])})
    if section.circular:
        sizes = {"radius": 0.5 * section.width, "length": length}
        shape = Element("cylinder", {name: number_words([x]) for name, x in sizes.items()})
    return Element("visual", {}, (Element("origin", at), Element("geometry", {}, (shape,))))


def joined_inertial(solids: Sequence[UniformSolid], scale: float = 1.0) -> Element:
    """Make the ``<inertial>`` of solids that are one link; common matter counts twice.

    Args:
        scale: factor of mass and inertia.
    """
    total = sum(solid.mass for solid in solids)
    centre = np.average(
        [solid.centre for solid in solids], axis=0, weights=[solid.mass for solid in solids]
    )
    inertia = np.zeros((3, 3))
    for solid in solids:
        apart = solid.centre - centre
        parallel = apart @ apart * np.eye(3) - np.outer(apart, apart)
        inertia += scale * (solid.inertia + solid.mass * parallel)
    at = Element("origin", {"xyz": number_words(_round(centre))})
    return make_elements.inertial(round_to_ten_digits(scale * total), _round(inertia), at)


def _round(values: ArrayLike) -> Array:
    """Round computed numbers; see `round_to_ten_digits`."""
    return np.vectorize(round_to_ten_digits)(np.asarray(values, dtype=np.float64))


def in_space(z: complex) -> Array:
    """Write a point of the plane in space (3,)."""
    return np.array([z.real, z.imag, 0.0])
