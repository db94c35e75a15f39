"""Masses asked for in an option that look like grams, next to those of the links."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from kinematics.wording import number_text

if TYPE_CHECKING:
    from kinematics.model.linkage import Linkage, Notice

# Mass asked for, over that of all links, that is noted: thousand times too much is far above.
IMPLAUSIBLE = 20.0


def note_implausible_masses(
    linkage: Linkage, requests: Iterable[tuple[str, float]]
) -> tuple[Notice, ...]:
    """Note masses that were asked for and are many times those of the links of the file.

    Args:
        linkage: the linkage; without masses nothing is noted.
        requests: option, as far as the mass, and the mass, kg, of each.
    """
    from balance.masses.payload import PAYLOAD_BODY
    from kinematics.model.linkage import Notice

    masses = [b.inertia[0] for b in linkage.bodies if b.name != PAYLOAD_BODY]
    given = float(sum(masses))
    return tuple(
        Notice(
            "heavy_request",
            (
                f"{option}{mass:g} is in kg, {number_text(mass / given, '.2g')} times the "
                f"{number_text(given, '.3g')} kg of all moving links: did you mean {mass:g}g?"
            ),
        )
        for option, mass in requests
        if 0.0 < IMPLAUSIBLE * given < mass
    )
