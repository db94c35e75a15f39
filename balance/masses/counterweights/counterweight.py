"""The counterweight of one link: lumps, mass properties, and volumes of metal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from balance.masses.counterweights.added_matter import homogeneous
from balance.masses.counterweights.lumps import Lumps
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.space.inertial_parameters.conversions import mass_properties
from balance.support.change_text import MASS_FORM
from balance.support.mass_table import MassTable, mass_table
from balance.support.materials import MATERIALS
from balance.support.tolerances import ARM_ZERO, CUT_BY_PLANE, MASSES_EQUAL, PLACED_AS_TAKEN
from balance.support.vector_digits import vector_digits
from kinematics.model.arrays import freeze
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.numerics.tolerances import WRITTEN_AS_ZERO
from kinematics.wording import count_noun, number_text, vector_text

DENSITIES = {name: MATERIALS[name] for name in ("steel", "tungsten")}
"""Densities of the metals whose volumes are listed, kg/m³."""

MOST_LUMPS = 4
"""Most lumps of a counterweight that are listed one by one."""

SLIVER = np.radians(10.0)
"""Angle of a sector below which no workshop cuts it, radians."""

PART_DIGITS = 3
"""Digits of the percentage of a region that matter fills."""

NORMAL_DIGITS = 3
"""Decimals of the normal of a plane that bounds a counterweight: a flat minimum leaves it free
to about 1e-4."""


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
        form: symmetric matrix Q (4, 4): matter of full density is where ``[x; 1]ᵀ Q [x; 1]``
            is positive in the region, at x in the link frame, metres; its largest entry is 1.
            None for point masses.
        density: that of the matter, kg/m³; None for point masses.
        arm: distance of a disc, block, cylinder or sector, with its web, from the nearest joint
            of its link, in the plane of the linkage, m; None for matter of any shape. What
            bridges it is not counted.
        web: bar that joins a disc, block or cylinder to that joint; None without any. Mass,
            centre and inertia are those of the shape and of the web outside it.
    """

    link: str
    mass: float
    com: Array
    inertia: Array = field(repr=False)
    lumps: tuple[Lump, ...]
    region: Region
    form: Array | None = field(default=None, repr=False)
    density: float | None = None
    arm: float | None = None
    web: Region | None = None

    @property
    def cut(self) -> tuple[Array, float] | None:
        """Unit normal n (3,) and distance d, m, if the part is ``n·x > d`` in the region."""
        if self.form is None:
            return None
        if np.abs(self.form[:3, :3]).max() > CUT_BY_PLANE * np.abs(self.form).max():
            return None
        size = float(np.linalg.norm(self.form[:3, 3]))
        if size * self.region.size <= WRITTEN_AS_ZERO * abs(float(self.form[3, 3])):
            return None  # the form is the same everywhere: the region is filled
        return self.form[:3, 3] / size, -0.5 * float(self.form[3, 3]) / size

    @property
    def what(self) -> str:
        """What it is, in words: lumps, one body, or a part of the region."""
        if self.form is None:
            return "one body" if not self.lumps else count_noun(len(self.lumps), "lump")
        return self.part_text(PART_DIGITS)

    def part_text(self, digits: int) -> str:
        """Write which part of its region it fills, the percentage to so many digits."""
        share = f"{number_text(100.0 * self.share, f'.{digits}g')} % of {self.region.words}"
        if self.web is not None:
            return f"{share}, and {self.web.text}"
        if self.cut is None:
            return share
        normal, distance = self.cut
        along = f"({vector_digits(normal, NORMAL_DIGITS)})"
        return f"{share}: beyond {number_text(distance)} m along {along}"

    @property
    def mean_density(self) -> float:
        """Density if it filled its region, kg/m³: point masses are denser wherever they are."""
        return self.mass / self.region.volume

    @property
    def share(self) -> float:
        """Part of the region that is filled; 0 for point masses."""
        if self.web is not None:
            return 1.0
        return 0.0 if self.density is None else self.mean_density / self.density

    @property
    def web_sizes(self) -> tuple[float, float]:
        """Length and width of the web, m; zero without one."""
        if self.web is None:
            return 0.0, 0.0
        length, width, _ = (2.0 * np.linalg.norm(self.web.place[:3, :3], axis=0)).tolist()
        return length, width

    @property
    def floats(self) -> bool:
        """Whether it is a shape that nothing joins to its link."""
        return self.arm is not None and self.arm > ARM_ZERO * self.region.size

    @property
    def too_narrow(self) -> bool:
        """Whether it is a sector that no workshop cuts."""
        return self.region.kind == "sector" and 2.0 * self.region.half_angle < SLIVER

    @property
    def moments(self) -> Array:
        """Pseudo-inertia ``∫ [x; 1][x; 1]ᵀ dm`` (4, 4) in the link frame, SI units."""
        P = self.mass * np.outer(np.append(self.com, 1.0), np.append(self.com, 1.0))
        P[:3, :3] += 0.5 * np.trace(self.inertia) * np.eye(3) - self.inertia
        return P

    @property
    def volumes(self) -> dict[str, float]:
        """Volume by name of the metal, m³."""
        return {name: self.mass / density for name, density in DENSITIES.items()}

    @property
    def words(self) -> str:
        """The counterweight in one line."""
        where = f"{number_text(self.mass)} kg at {vector_text(self.com)} m"
        return f"{self.link}: {where} in its link frame, {self.what}"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "link": self.link,
            "mass": self.mass,
            "com": self.com.tolist(),
            "inertia": self.inertia.tolist(),
            "lumps": [{"mass": x.mass, "position": x.position.tolist()} for x in self.lumps],
            "volumes": self.volumes,
            "form": None if self.form is None else self.form.tolist(),
            "density": self.density,
            "arm": self.arm,
            "web": None
            if self.web is None
            else {
                "joint": self.web.to_link([-1.0, 0.0, 0.0]).tolist(),
                "length": self.web_sizes[0],
                "width": self.web_sizes[1],
            },
        }


def counterweight_of(link: str, region: Region, lumps: Lumps, unit: float) -> Counterweight:
    """Make the counterweight of a link from its lumps, the heaviest first.

    Args:
        link: name of the link.
        lumps: point masses in the unit coordinates of the region.
        unit: kilograms per unit of their mass.
    """
    order = _heaviest_first(lumps)
    masses, points = unit * lumps.masses[order], region.to_link(lumps.points[order])
    # One lump has no inertia about its centre; the difference of two terms leaves round-off.
    mass, com, inertia = float(masses[0]), points[0], np.zeros((3, 3))
    if len(masses) > 1:
        p = homogeneous(points)
        mass, com, inertia = mass_properties(from_pseudo_inertia((masses * p.T) @ p))
    listed = (
        tuple(Lump(float(m), freeze(x)) for m, x in zip(masses, points, strict=True))
        if len(masses) <= MOST_LUMPS
        else ()
    )
    return Counterweight(link, mass, freeze(com), freeze(inertia), listed, region)


def _heaviest_first(lumps: Lumps) -> list[int]:
    """Order lumps by mass, and those of equal mass by their coordinates, largest first."""
    order = list(range(lumps.masses.size))
    columns = [*lumps.points.T[::-1], lumps.masses]
    for column, size in zip(columns, (1.0, 1.0, 1.0, 0.0), strict=True):
        ranks = rank_least_first((-column[order]).tolist(), size, MASSES_EQUAL)
        order = [order[k] for k in ranks]
    return order


def filled_counterweight(
    link: str,
    stock: Stock,
    form: Array,
    moments: Array,
    arm: float | None = None,
    web: Region | None = None,
) -> Counterweight:
    """Make the counterweight of a link that fills a part of its region.

    Args:
        link: name of the link.
        stock: region and density.
        form: matrix (4, 4) in unit coordinates; matter is where it is positive.
        moments: its pseudo-inertia (4, 4), kg, in unit coordinates.
        arm: distance of a shape from the nearest joint of the link, m.
        web: bar that joins a shape to that joint, whose moments are among these.
    """
    place = stock.region.place
    mass, com, inertia = mass_properties(from_pseudo_inertia(place @ moments @ place.T))
    back = np.linalg.inv(place)
    Q = back.T @ stock.effective_form(form) @ back
    return Counterweight(
        link,
        mass,
        freeze(com),
        freeze(inertia),
        (),
        stock.region,
        freeze(Q / np.abs(Q).max()),
        stock.density,
        arm,
        web,
    )


def added_mass_table(
    weights: Sequence[Counterweight], length: float, verdict: str
) -> MassTable:
    """Make the table of counterweights; see `balance.support.mass_table.mass_table`."""
    rows = ((each.link, each.mass, each.com, each.inertia) for each in weights)
    return mass_table(rows, length, verdict)


def net_mass(weights: Sequence[Counterweight], moved: Mapping[str, float]) -> float:
    """Compute the mass that a linkage gains, kg.

    Args:
        weights: what is placed on links.
        moved: mass that was taken from links, kg, by name.
    """
    placed, taken = sum(weight.mass for weight in weights), sum(moved.values())
    net = placed - taken
    return net if not taken or net > PLACED_AS_TAKEN * placed else 0.0


def change_words(
    weights: Sequence[Counterweight],
    moved: Mapping[str, float],
    given_mass: float,
    form: str = MASS_FORM,
) -> str:
    """Say what is moved and added, before a verb: ``2 kg added to 5 kg``.

    Args:
        form: format of the added mass.
    """
    net = net_mass(weights, moved)
    if not any(moved.values()):
        return f"{number_text(net, form)} kg added to {number_text(given_mass)} kg"
    added = f"{number_text(net, form)} kg" if net else "nothing"
    return f"{moved_text(moved)}, with {added} added to {number_text(given_mass)} kg,"


def sliver_sentence(weights: Sequence[Counterweight]) -> str:
    """Say which sectors are too narrow to cut, after another sentence; empty without any."""
    names = [f"'{weight.link}'" for weight in weights if weight.too_narrow]
    if not names:
        return ""
    many = len(names) > 1
    what = f"The sector{'s' * many} on {' and '.join(names)} {'are' if many else 'is'}"
    return f" {what} too narrow to cut."


def moved_text(moved: Mapping[str, float]) -> str:
    """Say what is moved, such as ``0.2 kg moved on 'crank'``; nothing if nothing is."""
    parts = [(name, mass) for name, mass in moved.items() if mass]
    return ", ".join(f"{number_text(mass)} kg moved on '{name}'" for name, mass in parts)
