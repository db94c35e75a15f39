"""Proofs that no counterweights of a shape balance: matter of which they are parts does not.

Sectors of one size are parts of fans about their joints, and flat shapes of plates that are as
thick, of any outline within the sections of their regions. Both are matter of limited density,
whose certificates `balance.masses.counterweights.volume.filling_check` checks. Webs, which lie
in the region and are as thick as their shape, are parts of these plates too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.shaped.across_plane import axes_and_height, height_within
from balance.masses.counterweights.shaped.sectors import fan_of
from balance.masses.counterweights.shaped.weight_shape import WeightShape
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.counterweights.volume.decide_filled import decide_filled
from balance.masses.counterweights.volume.fans import FULL_TURN
from balance.masses.counterweights.volume.plates import stocks_of
from balance.masses.designs.density import DensityLimit
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import PART_ROUND_OFF
from kinematics.errors import UsageError
from kinematics.wording import number_text


def exclude_shapes(
    answer: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> Counterweights:
    """Return the verdict that no shapes balance if that is proved, or else the answer.

    Args:
        answer: of a request for a shape; one that balances is returned as it is.
        stocks: regions and densities by position of the body.
        choices: the shape in each of its sizes.
    """
    if answer.weights:
        return answer
    space, others = answer.space, f"where {number_text(answer.least_mass or 0.0)} kg"
    thickest = max(choices, key=lambda shape: shape.size)
    plates = f"plates of thickness {thickest.size:g} m in the regions balance, of any outline"
    for held, words in (
        (_fans(space, stocks, choices), f"no {choices[0].plural} in the regions balance"),
        (_plates(space, stocks, thickest), f"no {plates}"),
    ):
        proof = decide_filled(space, held, relax=False) if held else answer
        if proof.verdict == "infeasible":
            return replace(
                answer,
                verdict="infeasible",
                certificate=proof.certificate,
                check=proof.check,
                words=f"infeasible: {words}, {others} of other shapes do",
            )
    return answer


def _fans(
    space: DesignSpace, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> dict[int, Stock]:
    """Return fans that hold all sectors of one size; empty for other shapes.

    A region that holds some directions only may have several arcs of them, of which a fan is
    one.
    """
    if choices[0].kind != "sector" or len(choices) > 1:
        return {}
    fans = {b: fan_of(space, b, stock, choices[0]) for b, stock in stocks.items()}
    whole = all(x.fan is not None and x.fan.allowed.width >= FULL_TURN for x in fans.values())
    return fans if whole else {}


def _plates(
    space: DesignSpace, stocks: Mapping[int, Stock], shape: WeightShape
) -> dict[int, Stock]:
    """Return plates about the plane of the linkage; empty if not all such shapes are in them.

    Args:
        shape: the thickest one.
    """
    if not shape.flat:
        return {}
    regions = {b: stock.region for b, stock in stocks.items()}
    for b, region in regions.items():
        axes, plane = axes_and_height(space, b)
        away = height_within(region, shape, axes[2], plane) - plane
        if abs(away) > PART_ROUND_OFF * region.size:
            return {}
    limits = {b: DensityLimit(stock.density, shape.size) for b, stock in stocks.items()}
    try:
        return stocks_of(space, regions, limits)
    except UsageError:
        return {}
