"""A shape that a workshop cuts from plate, in place of the least matter of any shape."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from balance.masses.counterweights.alike_links import alike_links, classes_among
from balance.masses.counterweights.counterweights_result import Counterweights, Relaxation
from balance.masses.counterweights.shaped.shape_changes import (
    ROUNDED,
    are_whole,
    balancing_shapes,
    larger_regions,
)
from balance.masses.counterweights.shaped.weight_shape import WeightShape, shape_text
from balance.masses.counterweights.volume.cut_regions import Stock

# Thicknesses that are proposed, at most, over the size of the smallest region.
THICKNESSES = (0.16, 0.08)
# Most links with matter for which shapes are tried: on more they take seconds.
MOST_LINKS = 4


def propose_shape(answer: Counterweights) -> Relaxation | None:
    """Find a shape of plate that balances in place of matter of any shape, by solving for it.

    Sectors are tried, and then discs, in the regions of the answer, and then sectors in larger
    ones of links that are alike, where these are the default. Thicknesses are rounded preferred
    numbers.

    Args:
        answer: counterweights that balance.

    Returns:
        The shape and its regions; None where none of these were found that are joined to their
        links and wide enough to cut, there are many links, or a shape cannot be asked for.
    """
    space, density = answer.space, answer.density
    if not (answer.may_have_shape and density and len(answer.regions) <= MOST_LINKS):
        return None
    stocks = {
        space.bodies.index(name): Stock(region, density[name])
        for name, region in answer.regions.items()
    }
    smallest = min(region.size for region in answer.regions.values())
    sizes = [_rounded_below(part * smallest) for part in THICKNESSES]
    sectors = [WeightShape("sector", size) for size in sizes]
    for shape in (*sectors, WeightShape("disc", sizes[0])):
        shaped = balancing_shapes(answer, stocks, [shape])
        if shaped is not None and are_whole(shaped):
            return Relaxation((), None, shaped.added_mass, shape=shape_text([shape]))
    default = {b for b in stocks if space.bodies[b] in answer.chosen}
    for alike in classes_among(alike_links(space.linkage), default):
        for shape in sectors:
            trial = larger_regions(answer, stocks, [shape], alike)
            if trial is not None and trial.whole:
                return replace(trial.change, shape=shape_text([shape]))
    return None


def _rounded_below(size: float) -> float:
    """Return the largest rounded preferred number up to a size."""
    decade = int(np.floor(np.log10(size)))
    numbers = [float(f"{number:g}e{decade}") for number in ROUNDED]
    return max(number for number in numbers if number <= size)
