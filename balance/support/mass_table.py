"""Tables of masses, centres and inertias, in workshop units, for Python and notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import zip_longest
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from balance.support.vector_digits import vector_digits
from kinematics.numerics.array_types import Array
from kinematics.wording import html_facts, number_text, without_round_off

# Grams in a kilogram, and millimetres in a metre; kg mm² in kg m².
PER_SI, INERTIA_PER_SI = 1e3, 1e6
DIGITS = ".4g"
# Of the largest moment of a link: objectives determine moments less well than masses, to 2e-5.
MOMENT_DIGITS = 3
SOLID = "solid of its inertia (mm), density (kg/m³)"
HEAD = ("link", "mass (g)", "x (mm)", "y (mm)", "z (mm)")
MOMENTS = ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")
# Rows and columns of these moments.
ENTRIES = ((0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2))
TITLE = "centres of mass in link frames"
FRAMES = "Centres of mass, and moments about them, are in the link frames of the file."


class MassRow(NamedTuple):
    """Mass, centre and inertia of what is on a link.

    Attributes:
        link: its name.
        mass: g.
        x: of the centre of mass in the frame of the link, as in the file, mm.
        y: mm.
        z: mm.
        ixx: moment of inertia about the centre of mass, in the axes of that frame, kg mm².
        iyy: kg mm².
        izz: kg mm².
        ixy: product of inertia, as in URDF, kg mm².
        ixz: kg mm².
        iyz: kg mm².
    """

    link: str
    mass: float
    x: float
    y: float
    z: float
    ixx: float
    iyy: float
    izz: float
    ixy: float
    ixz: float
    iyz: float

    @property
    def moments(self) -> tuple[float, ...]:
        """Ixx, Iyy, Izz, Ixy, Ixz, Iyz, kg mm²."""
        return (self.ixx, self.iyy, self.izz, self.ixy, self.ixz, self.iyz)


class MassTable(tuple[MassRow, ...]):
    """Rows of masses, which are printed as a table.

    Attributes:
        verdict: of the answer that has them; it is printed where there are none.
        solids: shape, size, mm, and density, kg/m³, of the solid that has the inertia of a
            link, by name; empty if no density is limited.
        note: a line below the rows; empty if there is nothing to note.
    """

    verdict: str = ""
    note: str = ""
    solids: Mapping[str, str] = MappingProxyType({})

    def __repr__(self) -> str:
        """Lines of columns, their head first, and in which frames they are.

        Without rows, it says that there are none, and the verdict.

        Moments of inertia that are zero for all links, to the digits that are written, have no
        column.
        """
        if not self:
            return f"no masses: {self.verdict}".removesuffix(": ")
        moments = [_moment_texts(row) for row in self]
        shown = [k for k in range(len(MOMENTS)) if any(texts[k] != "0" for texts in moments)]
        rows = [(*HEAD, *(f"{MOMENTS[k]} (kg mm²)" for k in shown))]
        for row, texts in zip(self, moments, strict=True):
            rows.append((*_texts(row), *(texts[k] for k in shown)))
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        ends = [SOLID, *(self.solids.get(row.link, "") for row in self)] if self.solids else []
        lines = [
            "  ".join(
                [row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:]), end]
            ).rstrip()
            for row, end in zip_longest(rows, ends, fillvalue="")
        ]
        return "\n".join([*lines, FRAMES, *[self.note] * bool(self.note)])

    def _repr_html_(self) -> str:
        """The same table for notebooks."""
        if not self:
            return html_facts(TITLE, ("no masses", self.verdict))
        facts = []
        for link, mass, *place in map(_texts, self):
            solid = f", {self.solids[link]} kg/m³" if link in self.solids else ""
            facts.append((link, f"{mass} g at ({', '.join(place)}) mm{solid}"))
        return html_facts(TITLE, *facts, *[("note", self.note)] * bool(self.note))


def mass_table(
    masses: Iterable[tuple[str, float, Array | None, Array | None]],
    length: float,
    verdict: str = "",
    solids: Mapping[str, str] | None = None,
    note: str = "",
) -> MassTable:
    """Make a table of masses.

    Args:
        masses: link, mass, kg, centre of mass (3,) in its frame, m, and inertia about it
            (3, 3) along the axes of that frame, kg m², of each; those without them are left
            out.
        length: a length of the linkage, m: coordinates smaller by ten decades are zero.
        verdict: of the answer that has the masses, in one line.
        solids: shape and size of solids, by link; see `MassTable`.
        note: a line below the rows.
    """
    table = MassTable(
        MassRow(
            link,
            PER_SI * float(mass),
            *(PER_SI * without_round_off(com, length)).tolist(),
            *(INERTIA_PER_SI * without_round_off(inertia[ENTRIES], mass * length**2)).tolist(),
        )
        for link, mass, com, inertia in masses
        if com is not None and inertia is not None
    )
    table.verdict, table.solids, table.note = verdict, solids or {}, note
    return table


def _texts(row: MassRow) -> tuple[str, ...]:
    return (row.link, *(number_text(x, DIGITS) for x in (row.mass, row.x, row.y, row.z)))


def _moment_texts(row: MassRow) -> tuple[str, ...]:
    """Write moments of inertia to the last decimal place of the largest one."""
    digits = vector_digits(np.array(row.moments), MOMENT_DIGITS).split(", ")
    return tuple(number_text(float(text), DIGITS) for text in digits)
