"""Columns of a sweep with the mass and the place of the matter that is added to each link.

They are called as the numbers of a link in paths: ``crank.added.mass``, ``crank.added.x``, of
counterweights, and ``crank.budget.mass`` … of `balance reduce`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.link_regions import names_of_links
from balance.studies.runs.chunk_job import Column
from kinematics.model.linkage import Linkage

ADDED, BUDGET = "added", "budget"
"""What the names of columns have between link and number."""
_NAME = re.compile(rf"(?P<link>.*)\.({ADDED}|{BUDGET})\.(mass|x|y|z)")


def weight_columns(linkage: Linkage, links: Sequence[str], what: str) -> tuple[Column, ...]:
    """Name mass (kg) and centre of mass in the link frame (m) of the weights of links.

    Args:
        links: names of the bodies, or ``all``; see `names_of_links`.
        what: `ADDED` or `BUDGET`.
    """
    units = {"mass": "kg", "x": "m", "y": "m", "z": "m"}
    return tuple(
        Column(f"{name}.{what}.{number}", "real", unit)
        for name in names_of_links(linkage, links)
        for number, unit in units.items()
    )


def weight_values(
    linkage: Linkage, links: Sequence[str], weights: Sequence[Counterweight]
) -> list[float]:
    """Return the numbers of `weight_columns`; a link without a weight has no centre."""
    known = {weight.link: [weight.mass, *weight.com.tolist()] for weight in weights}
    without = [0.0, np.nan, np.nan, np.nan]
    names = names_of_links(linkage, links)
    return [number for name in names for number in known.get(name, without)]


def link_of_column(name: str) -> str:
    """Name the link of which a column has the weight; empty for other columns."""
    match = _NAME.fullmatch(name)
    return "" if match is None else match["link"]
