"""Links that bend: their sections, materials and supports, as a user names them."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from balance.motion.flexible.beam import Beam, rectangular_beam
from balance.support.units import read_quantity
from kinematics.error_text import clean
from kinematics.errors import UsageError


class Material(NamedTuple):
    """A material.

    Attributes:
        modulus: Young's modulus, in N/m².
        density: in kg/m³.
        poisson: Poisson's ratio.
    """

    modulus: float
    density: float
    poisson: float


MATERIALS: dict[str, Material] = {
    "steel": Material(210e9, 7850.0, 0.30),
    "aluminium": Material(70e9, 2700.0, 0.33),
    "titanium": Material(114e9, 4430.0, 0.34),
    "carbon": Material(135e9, 1600.0, 0.30),
}
"""Materials by name; carbon is a unidirectional laminate along the beam."""


class FlexLink(NamedTuple):
    """A link that bends.

    Attributes:
        name: name of the link in the file.
        bending: EI, in N m².
        line_mass: ρA, in kg/m.
        axial: EA, in N; infinity if the link does not stretch.
        shear: κGA, in N; infinity without shear deformation.
        rotary: ρI, in kg m.
        length: of the beam, in metres, the same beyond both joints; None: from joint to joint.
        supports: number of points that carry it: 2, or 4, 6 … with a whippletree on each joint,
            at the best points of `balance.motion.flexible.support_points`; 0: at its two
            joints.
        thickness: of its section in the plane, in metres; 0 if that is not known.
    """

    name: str
    bending: float
    line_mass: float
    axial: float = math.inf
    shear: float = math.inf
    rotary: float = 0.0
    length: float | None = None
    supports: int = 0
    thickness: float = 0.0

    def beam(self, length: float) -> Beam:
        """Build the beam of a length in metres.

        Raises:
            LinkageError: a number is out of range.
        """
        return Beam(length, self.bending, self.line_mass, self.axial, self.shear, self.rotary)


NUMBERS = {
    "EI": "bending",
    "rhoA": "line_mass",
    "EA": "axial",
    "GA": "shear",
    "rhoI": "rotary",
    "length": "length",
}
FORM = "LINK=EI:…,rhoA:… or LINK=rect(WIDTH,THICKNESS),MATERIAL"


def parse_flex_link(text: str) -> FlexLink:
    """Parse ``LINK=EI:…,rhoA:…`` or ``LINK=rect(WIDTH,THICKNESS),steel``.

    Further items: ``EA:``, ``GA:``, ``rhoI:`` (SI units), ``length:`` of the beam in metres,
    ``supports:`` 2, 4, 6 …; with a section ``timoshenko`` adds stretch, shear and rotary
    inertia.

    Args:
        text: the words of the user.

    Raises:
        UsageError: it has another form, or a number is out of range.

    Example:
        >>> from balance.motion.flexible.flex_links import parse_flex_link
        >>> parse_flex_link("coupler=EI:4.5e-3,rhoA:0.024").bending
        0.0045
    """
    name, equal, rest = text.partition("=")
    if not equal or not name or not rest:
        raise UsageError(f"--flex {clean(text, 200)}: write {FORM}")
    given: dict[str, float] = {}
    words: list[str] = []
    section: tuple[float, float] | None = None
    for item in re.findall(r"rect\([^)]*\)|[^,]+", rest):
        key, colon, value = item.partition(":")
        rectangle = re.fullmatch(r"rect\(([^,]+),([^,]+)\)", item)
        if rectangle:
            section = (
                _number(text, rectangle[1], "length"),
                _number(text, rectangle[2], "length"),
            )
        elif colon and key in (*NUMBERS, "supports"):
            given[key] = _number(text, value, *["length"] * (key == "length"))
        elif item in (*MATERIALS, "timoshenko"):
            words.append(item)
        else:
            raise UsageError(
                f"--flex {clean(text, 200)}: '{clean(item, 100)}' is not known: write {FORM}; "
                f"materials are {', '.join(MATERIALS)}"
            )
    return _flex_link(text, name, given, words, section)


def _flex_link(
    text: str,
    name: str,
    given: dict[str, float],
    words: list[str],
    section: tuple[float, float] | None,
) -> FlexLink:
    """Compose the link of parsed items."""
    supports = int(given.pop("supports", 0))
    if supports % 2 or not 0 <= supports <= 40:
        raise UsageError(f"--flex {clean(text, 200)}: supports are 2, 4, 6 … 40")
    if supports and "length" in given:
        raise UsageError(f"--flex {clean(text, 200)}: supports set the length: leave it out")
    values: dict[str, float | None] = {NUMBERS[key]: value for key, value in given.items()}
    if section is not None:
        material = next((MATERIALS[word] for word in words if word in MATERIALS), None)
        if material is None:
            raise UsageError(
                f"--flex {clean(text, 200)}: name a material: {', '.join(MATERIALS)}"
            )
        width, thickness = section
        beam = rectangular_beam(
            1.0,
            thickness,
            width,
            material.modulus,
            material.density,
            material.poisson,
            classical="timoshenko" not in words,
        )
        values = {
            "bending": beam.bending,
            "line_mass": beam.line_mass,
            "axial": beam.axial,
            "shear": beam.shear,
            "rotary": beam.rotary,
            "thickness": thickness,
            **values,
        }
    missing = [key for key in ("EI", "rhoA") if NUMBERS[key] not in values]
    if missing:
        raise UsageError(f"--flex {clean(text, 200)}: {missing[0]} is missing: write {FORM}")
    return FlexLink(name, supports=supports, **values)  # type: ignore[arg-type]


def _number(text: str, word: str, *quantities: str) -> float:
    """Parse a positive number, with or without a unit of the quantities.

    Raises:
        UsageError: it is not one.
    """
    try:
        value, reason = read_quantity(word, *quantities) if quantities else float(word), ""
    except UsageError as error:
        value, reason = math.nan, f"; {error}"
    except ValueError:
        value, reason = math.nan, ""
    if not 0.0 < value < math.inf:
        raise UsageError(
            f"--flex {clean(text, 200)}: '{clean(word, 100)}' is not a positive number{reason}"
        )
    return float(value)
