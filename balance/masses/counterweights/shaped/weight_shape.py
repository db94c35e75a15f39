"""Simple shapes of counterweights: discs and blocks of a thickness, cylinders of a radius."""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt
from typing import Literal, NamedTuple, get_args

import numpy as np

from balance.masses.counterweights.regions import Region, box_region, cylinder_region
from balance.support.units import read_quantity
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

Kind = Literal["disc", "block", "cylinder"]


class WeightShape(NamedTuple):
    """A shape whose axis is normal to the plane of the linkage, and that grows with its mass.

    A mass m of density ρ reaches so far from its axis, and from its middle along it: a disc of
    thickness t ``√(m/(π ρ t))`` and t/2, a square block ``½ √(m/(ρ t))`` along each of two
    axes and t/2, a cylinder of radius r that radius and ``m/(2 π ρ r²)``.

    Attributes:
        kind: its kind.
        size: thickness of a disc or block, radius of a cylinder, m.
    """

    kind: Kind
    size: float

    @property
    def text(self) -> str:
        """The shape as `read_weight_shape` reads it."""
        return f"{self.kind}={self.size:g}"

    @property
    def plural(self) -> str:
        """Several of the shape, in words."""
        what = "radius" if self.kind == "cylinder" else "thickness"
        return f"{self.kind}s of {what} {self.size:g} m"

    @property
    def flat(self) -> bool:
        """Whether its thickness is given, and it grows across."""
        return self.kind != "cylinder"

    @property
    def growth(self) -> float:
        """Metres that a cubic metre reaches: times its root if it is flat, or it."""
        if self.kind == "disc":
            return 1.0 / sqrt(pi * self.size)
        if self.kind == "block":
            return 0.5 / sqrt(self.size)
        return 0.5 / (pi * self.size**2)

    def place(self, mass: float, density: float, centre: Array, axes: Array) -> Region:
        """Make the region that a mass fills.

        Args:
            mass: kg.
            density: kg/m³.
            centre: its centre of mass (3,) in the link frame, m.
            axes: orthonormal rows (3, 3) of the link frame, the last one its axis.
        """
        reach = self.growth * (sqrt(mass / density) if self.flat else mass / density)
        if self.kind == "block":
            place = np.eye(4)
            place[:3, :3], place[:3, 3] = axes.T * [reach, reach, 0.5 * self.size], centre
            text = f"a block {number_text(2.0 * reach)} m square, {self.size:g} m thick"
            return replace(box_region([-1.0] * 3, [1.0] * 3), place=freeze(place), text=text)
        radius, length = (reach, self.size) if self.flat else (self.size, 2.0 * reach)
        ends = f"{number_text(length)} m {'thick' if self.flat else 'long'}"
        text = f"a {self.kind} of radius {number_text(radius)} m, {ends}"
        return replace(cylinder_region(centre, axes[2], radius, length), text=text)


def read_weight_shape(text: str) -> WeightShape:
    """Read a shape from its text, such as ``disc=0.02`` or ``cylinder=30mm``.

    Raises:
        UsageError: there is no such shape, or its size is none.
    """
    kind, _, size = text.strip().partition("=")
    if kind in get_args(Kind) and size:
        length = read_quantity(size, "length")
        if 0.0 < length < np.inf:
            return WeightShape(kind, length)  # type: ignore[arg-type]
    raise UsageError(
        f"shape '{text}' has no known form: write disc=0.02 or block=0.02, of that thickness "
        "in metres, or cylinder=0.03, of that radius"
    )
