"""Dimensions of parts: what a workshop cuts them to."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from kinematics.wording import number_text

# Part of a region below which matter that is missing is round-off: it is full.
MISSING = 1e-9


class Dimensions(NamedTuple):
    """Dimensions of a counterweight that is a whole disc, sector, block or ball.

    Attributes:
        shape: its name.
        sizes: extents along the axes of its region (3,), mm.
        radius: mm; None for a block.
        angle: of a sector, degrees; None for the others.
    """

    shape: str
    sizes: tuple[float, float, float]
    radius: float | None
    angle: float | None

    @property
    def words(self) -> str:
        """The shape with its dimensions."""
        x, y, z = (number_text(size) for size in self.sizes)
        if self.radius is None:
            return f"a {self.shape} of {x} × {y} × {z} mm"
        radius = f"radius {number_text(self.radius)} mm"
        if self.shape == "ball":
            return f"a ball of {radius}"
        turn = "" if self.angle is None else f"{number_text(self.angle)}° and "
        ends = "long" if self.shape == "cylinder" else "thick"
        return f"a {self.shape} of {turn}{radius}, {z} mm {ends}"


def whole_dimensions(weight: Counterweight) -> Dimensions | None:
    """Return the dimensions of a counterweight; None unless it is a whole simple shape.

    A cylinder that is no longer than its diameter is a disc.
    """
    region = weight.region
    names = {"sector": "sector", "cylinder": "disc", "box": "block", "ball": "ball"}
    if region.kind not in names or weight.share < 1.0 - MISSING:
        return None
    x, y, z = (2e3 * np.linalg.norm(region.place[:3, :3], axis=0)).tolist()
    shape = names[region.kind]
    if shape == "disc" and z > x:
        shape = "cylinder"
    radius = None if shape == "block" else 0.5 * x
    angle = float(np.degrees(2.0 * region.half_angle)) if shape == "sector" else None
    return Dimensions(shape, (x, y, z), radius, angle)
