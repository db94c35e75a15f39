"""Tables of masses and of their centres, in grams and millimetres, for Python and notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import zip_longest
from types import MappingProxyType
from typing import NamedTuple

from kinematics.numerics.array_types import Array
from kinematics.wording import html_facts, number_text, without_round_off

# Grams in a kilogram, and millimetres in a metre.
PER_SI = 1e3
DIGITS = ".4g"
SOLID = "solid of its inertia (mm)"
HEAD = ("link", "mass (g)", "x (mm)", "y (mm)", "z (mm)")
TITLE = "centres of mass in link frames"


class MassRow(NamedTuple):
    """Mass and centre of what is on a link.

    Attributes:
        link: its name.
        mass: g.
        x: of the centre of mass in the frame of the link, as in the file, mm.
        y: mm.
        z: mm.
    """

    link: str
    mass: float
    x: float
    y: float
    z: float


class MassTable(tuple[MassRow, ...]):
    """Rows of masses, which are printed as a table.

    Attributes:
        verdict: of the answer that has them; it is printed where there are none.
        solids: shape and size, mm, of the solid that has the inertia of a link, by name; empty
            if no density is limited.
    """

    verdict: str = ""
    solids: Mapping[str, str] = MappingProxyType({})

    def __repr__(self) -> str:
        """Lines of columns, their head first; or that there are none, and the verdict."""
        if not self:
            return f"no masses: {self.verdict}".removesuffix(": ")
        rows = [HEAD, *(_texts(row) for row in self)]
        widths = [max(len(row[k]) for row in rows) for k in range(len(HEAD))]
        ends = [SOLID, *(self.solids.get(row.link, "") for row in self)] if self.solids else []
        return "\n".join(
            "  ".join(
                [row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:]), end]
            ).rstrip()
            for row, end in zip_longest(rows, ends, fillvalue="")
        )

    def _repr_html_(self) -> str:
        """The same table for notebooks."""
        if not self:
            return html_facts(TITLE, ("no masses", self.verdict))
        facts = []
        for link, mass, *place in map(_texts, self):
            solid = f", {self.solids[link]} mm" if link in self.solids else ""
            facts.append((link, f"{mass} g at ({', '.join(place)}) mm{solid}"))
        return html_facts(TITLE, *facts)


def mass_table(
    masses: Iterable[tuple[str, float, Array | None]],
    length: float,
    verdict: str = "",
    solids: Mapping[str, str] | None = None,
) -> MassTable:
    """Make a table of masses.

    Args:
        masses: link, mass, kg, and centre of mass (3,) in its frame, m, of each; those
            without one are left out.
        length: a length of the linkage, m: coordinates smaller by ten decades are zero.
        verdict: of the answer that has the masses, in one line.
        solids: shape and size of solids, by link; see `MassTable`.
    """
    table = MassTable(
        MassRow(
            link,
            PER_SI * float(mass),
            *(PER_SI * x for x in without_round_off(com, length).tolist()),
        )
        for link, mass, com in masses
        if com is not None
    )
    table.verdict, table.solids = verdict, solids or {}
    return table


def _texts(row: MassRow) -> tuple[str, ...]:
    return (row.link, *(number_text(x, DIGITS) for x in row[1:]))
