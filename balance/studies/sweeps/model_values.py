"""What a study does not say: values in the file of its model, regions that follow lengths."""

from __future__ import annotations

from typing import NamedTuple

from balance.masses.counterweights.link_regions import (
    default_region,
    names_of_links,
    radius_text,
    regions_by_name,
)
from balance.space.spaces.compute_space import design_space
from balance.studies.sweeps.plan import Plan
from balance.studies.sweeps.row_quantities import AFTER


class FollowingRegion(NamedTuple):
    """The region of a link to which matter is added, which the lengths of the study change.

    Attributes:
        quantity: what adds matter, ``"counterweights"`` or ``"reduce"``.
        link: name of the link.
        text: its region in the model, in millimetres of four digits, as
            `balance.masses.counterweights.region_text` reads it.
    """

    quantity: str
    link: str
    text: str


def values_in_model(plan: Plan) -> dict[str, float]:
    """Find the values that the model has of the parameters of a study; SI units, by path.

    Names that are no paths have none.
    """
    values = {name: plan.value_in_model(name) for name in plan.study.parameters}
    return {name: value for name, value in values.items() if value is not None}


def following_regions(plan: Plan) -> list[FollowingRegion]:
    """List the default regions, of half the length of a link, that a study makes follow it.

    They are those of links without a region of their own on which joints move.
    """
    moved = plan.links_with_moved_joints()
    regions: list[FollowingRegion] = []
    for quantity in AFTER:
        options = plan.study.quantities.get(quantity)
        if options is None or not moved:
            continue
        space = design_space(plan.linkage, None, max_order=0)
        regions += [
            FollowingRegion(
                quantity, name, radius_text(default_region(space, space.bodies.index(name)))
            )
            for name in names_of_links(plan.linkage, options["links"])
            if name in moved
            and name
            not in regions_by_name(plan.linkage, options["links"], options.get("regions", {}))
        ]
    return regions
