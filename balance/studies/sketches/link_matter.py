"""What the links of a sketch are made of: sections, densities and masses by link."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from balance.studies.sketches.bars import (
    LINE,
    BarSection,
    UniformSolid,
    in_space,
    joined_inertial,
    make_bar,
    make_visual,
    read_section,
)
from balance.studies.sketches.points import FOR_ALL, read_pairs, unknown_name
from balance.support.materials import MATERIALS, density_in_si
from balance.support.units import read_quantity
from kinematics.error_text import clean
from kinematics.errors import UsageError
from kinematics.model.document.element import Element
from kinematics.wording import round_to_ten_digits

ByLink: TypeAlias = float | str | Mapping[str, float | str]
"""A value for all links, a text ``"30mmx10mm, crank=d20mm"``, or values by link."""

# Distance of points from a line, over the length of their link, up to which they are on it.
STRAIGHT = 1e-9


class LinkSolid(NamedTuple):
    """The matter of a link.

    Attributes:
        mass: kg; None without ``<inertial>``.
        elements: its ``<inertial>`` and ``<visual>`` elements.
    """

    mass: float | None
    elements: tuple[Element, ...]


class LinkMatter(NamedTuple):
    """What a link is made of.

    Attributes:
        section: of its bars; None without.
        density: kg/m³.
        mass: kg, in place of that of section and density; None for that.
    """

    section: BarSection | None
    density: float
    mass: float | None

    @property
    def words(self) -> str:
        """The section in words, mm; empty without one."""
        return "" if self.section is None else self.section.words

    def build(self, points: Sequence[complex], slide: complex | None) -> LinkSolid:
        """Make the matter of a link.

        Args:
            points: that it carries, in its frame, metres.
            slide: direction of a slider, of length 1; None for other links.
        """
        if self.section is None and self.mass is None:
            return LinkSolid(None, ())
        section = LINE if self.section is None else self.section
        ends = _bar_ends(points)
        if slide is not None:
            # A block twice as long as wide.
            half = section.width * slide
            ends = [(points[0] - half, points[0] + half)]
        # Without a section the mass is given, and any density does.
        line_density = self.density * section.area or 1.0
        if slide is not None and self.section is None:
            solids = [UniformSolid(1.0, in_space(points[0]), np.zeros((3, 3)))]
        else:
            solids = [make_bar(*pair, section, line_density) for pair in ends]
        shapes = [] if self.section is None else [make_visual(*pair, section) for pair in ends]
        total = sum(solid.mass for solid in solids)
        mass = round_to_ten_digits(total) if self.mass is None else self.mass
        return LinkSolid(mass, (joined_inertial(solids, mass / total), *shapes))


def read_matter(
    links: Mapping[str, object],
    section: str | Mapping[str, str],
    density: ByLink,
    mass: str | Mapping[str, float | str],
) -> dict[str, LinkMatter]:
    """Read what each link is made of; see `linkage_from_sketch`.

    Raises:
        UsageError: a value is written wrongly or not positive, or there is no such link.
    """
    by_link = {FOR_ALL: density} if isinstance(density, (float, int, np.number)) else density
    example = "30mmx10mm, crank=d20mm"
    sections = read_pairs("section", section, example, ",", for_all=True)
    densities = read_pairs("density", by_link, "steel, rod=titanium", ",", for_all=True)
    masses = read_pairs("mass", mass, "piston=0.5, crank=200g", ",")
    for what, names in (("section", sections), ("density", densities), ("mass", masses)):
        for name in names:
            if name not in (FOR_ALL, *links):
                raise UsageError(f"{what}: {unknown_name('link', name, links)}")
    others = densities.get(FOR_ALL, MATERIALS["steel"])
    matter = {}
    for link in links:
        words = sections.get(link, sections.get(FOR_ALL))
        if words is not None and not isinstance(words, str):
            raise UsageError(f"section: '{clean(str(words))}' is no text, as 30mmx10mm is")
        kilograms = masses.get(link)
        matter[link] = LinkMatter(
            None if words is None else read_section(words),
            _positive("density", density_in_si(densities.get(link, others)), "kg/m³"),
            None if kilograms is None else _positive("mass", kilograms, "kg"),
        )
    return matter


def _positive(what: str, value: Any, unit: str) -> float:
    """Convert a mass or a density to SI units.

    Raises:
        UsageError: it is not positive, or too large.
    """
    number = float(read_quantity(value, what) if isinstance(value, str) else value)
    if not 0.0 < number < 1e12:
        text = clean(str(value))
        raise UsageError(f"{what} '{text}' is not between 0 and 1e12 {unit}")
    return number


def _bar_ends(points: Sequence[complex]) -> list[tuple[complex, complex]]:
    """List the ends of the bars of a link: one along a line, or one along each side."""
    if len(points) < 2:
        return []
    first, last = max(combinations(points, 2), key=lambda pair: abs(pair[1] - pair[0]))
    step = last - first
    off = [abs(((z - first) / step).imag) for z in points]
    if max(off) <= STRAIGHT:
        return [(first, last)]
    return list(zip(points, [*points[1:], points[0]], strict=True))
