"""The counterweight of one link: lumps, mass properties, and volumes of metal."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from balance.masses.counterweights.added_matter import homogeneous
from balance.masses.counterweights.lumps import Lumps
from balance.masses.counterweights.regions import Region
from balance.space.inertial_parameters.conversions import mass_properties
from kinematics.model.arrays import freeze
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.wording import count_noun, number_text, vector_text

Array = NDArray[np.float64]

DENSITIES = {"steel": 7850.0, "tungsten": 19250.0}
"""Densities of metals, kg/m³."""

MOST_LUMPS = 4
"""Most lumps of a counterweight that are listed one by one."""


@dataclass(frozen=True, eq=False)
class Lump:
    """A point mass.

    Attributes:
        mass: kg.
        position: in the link frame (3,), metres.
    """

    mass: float
    position: Array


@dataclass(frozen=True, eq=False)
class Counterweight:
    """Matter that is added to a link.

    Attributes:
        link: name of the link.
        mass: kg.
        com: centre of mass in the link frame (3,), metres.
        inertia: tensor about it in the axes of the link frame (3, 3), kg m².
        lumps: point masses in the region that make it up, at most four; if more are needed,
            none: the counterweight is then one body with this inertia.
        region: the region.
    """

    link: str
    mass: float
    com: Array
    inertia: Array = field(repr=False)
    lumps: tuple[Lump, ...]
    region: Region

    @property
    def volumes(self) -> dict[str, float]:
        """Volume by name of the metal, m³."""
        return {name: self.mass / density for name, density in DENSITIES.items()}

    @property
    def words(self) -> str:
        """The counterweight in one line."""
        what = "one body" if not self.lumps else count_noun(len(self.lumps), "lump")
        where = vector_text(self.com)
        return (
            f"{self.link}: {number_text(self.mass)} kg at {where} m in its link frame, {what}"
        )

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "link": self.link,
            "mass": self.mass,
            "com": self.com.tolist(),
            "inertia": self.inertia.tolist(),
            "lumps": [{"mass": x.mass, "position": x.position.tolist()} for x in self.lumps],
            "volumes": self.volumes,
        }


def counterweight_of(link: str, region: Region, lumps: Lumps, unit: float) -> Counterweight:
    """Make the counterweight of a link from its lumps.

    Args:
        link: name of the link.
        lumps: point masses in the unit coordinates of the region.
        unit: kilograms per unit of their mass.
    """
    masses, points = unit * lumps.masses, region.to_link(lumps.points)
    # One lump has no inertia about its centre; the difference of two terms leaves round-off.
    mass, com, inertia = float(masses[0]), points[0], np.zeros((3, 3))
    if len(masses) > 1:
        p = homogeneous(points)
        mass, com, inertia = mass_properties(from_pseudo_inertia((masses * p.T) @ p))
    listed = tuple(
        Lump(float(m), freeze(x)) for m, x in zip(masses, points, strict=True)
    ) if len(masses) <= MOST_LUMPS else ()  # fmt: skip
    return Counterweight(link, mass, freeze(com), freeze(inertia), listed, region)
