"""Changes of a request for counterweights of a shape, each of which was found to balance.

Sizes are the preferred numbers of the series R10 (ISO 3), ten in a decade.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from balance.masses.counterweights.alike_links import alike_links, classes_among
from balance.masses.counterweights.counterweights_result import Counterweights, Relaxation
from balance.masses.counterweights.regions import Region, cylinder_region
from balance.masses.counterweights.shaped.across_plane import axes_and_height, height_within
from balance.masses.counterweights.shaped.decide_shaped import decide_shaped
from balance.masses.counterweights.shaped.weight_shape import WeightShape, shape_text
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.counterweights.volume.decide_filled import decide_filled
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import MASS_GAP
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first, round_decimals

R10 = (1.0, 1.25, 1.6, 2.0, 2.5, 3.15, 4.0, 5.0, 6.3, 8.0)
# Largest factor by which a region or a size grows.
LARGEST_CHANGE = 5.0
# Decimals of the centre of a region, m, and of its axis.
PLACE_DECIMALS, AXIS_DECIMALS = 6, 12


def shape_changes(
    answer: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> tuple[Relaxation, ...]:
    """Find larger regions, and a larger size, with which counterweights of a shape balance.

    The regions of links that are alike, or else of all, become cylinders across the plane of
    the linkage about their centres. Where nothing helps sectors of a given radius, they get
    that of the largest circle.

    Args:
        answer: the request, to which there is no answer.
        stocks: regions and densities by position of the body.
        choices: the shape in each of its sizes.

    Returns:
        The changes, the smallest growth first, each of which was solved as a request of its
        own.
    """
    if answer.verdict == "infeasible" and not answer.depends_on_regions:
        return ()
    changes = _growths(answer, stocks, choices)
    if changes or choices[0].radius is None:
        return changes
    wider = [shape._replace(radius=None) for shape in choices]
    changes = _growths(answer, stocks, wider)
    return tuple(replace(change, shape=change.shape or shape_text(wider)) for change in changes)


def _growths(
    answer: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> tuple[Relaxation, ...]:
    """Find larger regions, and a larger size, for the same kind of shape."""
    space = answer.space
    classes = classes_among(alike_links(space.linkage), stocks)
    changes = [_larger_regions(answer, stocks, choices, alike) for alike in classes]
    if not any(changes) and len(classes) > 1:
        changes = [_larger_regions(answer, stocks, choices, tuple(stocks))]
    if len(choices) == 1:
        changes.append(_larger_size(answer, stocks, choices[0]))
    helpful = [change for change in changes if change]
    growths = [change.factor or 0.0 for change in helpful]
    return tuple(helpful[k] for k in rank_least_first(growths, relative=MASS_GAP))


def _larger_regions(
    answer: Counterweights,
    stocks: Mapping[int, Stock],
    choices: Sequence[WeightShape],
    bodies: Sequence[int],
) -> Relaxation | None:
    """Find the smallest cylinders about the regions of some links that hold the shapes."""
    space, largest = answer.space, max(choices, key=lambda shape: shape.size)

    def cylinders(radius: float) -> dict[int, Stock]:
        return {
            b: stocks[b]._replace(region=_cylinder(space, b, stocks[b].region, largest, radius))
            for b in bodies
        }

    size = max(stocks[b].region.size for b in bodies)
    for radius in _preferred_above(size):
        try:
            larger = {**stocks, **cylinders(radius)}
        except UsageError:
            return None
        # All links with one size are tried first: all choices of several take long.
        if not any(balancing_shape_mass(answer, larger, [shape]) for shape in choices):
            continue
        mass = balancing_shape_mass(answer, larger, choices)
        if mass is not None:
            regions = {space.bodies[b]: larger[b].region.text for b in bodies}
            return Relaxation(tuple(regions), radius / size, mass, regions)
    return None


def _larger_size(
    answer: Counterweights, stocks: Mapping[int, Stock], shape: WeightShape
) -> Relaxation | None:
    """Find the least size of a shape, in the given regions, that balances."""
    for size in _preferred_above(shape.size):
        larger = [shape._replace(size=size)]
        mass = balancing_shape_mass(answer, stocks, larger)
        if mass is not None:
            return Relaxation((), size / shape.size, mass, shape=shape_text(larger))
    return None


def balancing_shape_mass(
    answer: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> float | None:
    """Compute the mass of shapes that balance, kg; None if none were found.

    Args:
        answer: a request of the same linkage.
        stocks: regions and densities by position of the body.
        choices: the shape in each of its sizes.
    """
    try:
        shaped = decide_shaped(answer, stocks, choices)
    except UsageError:
        return None
    balances = shaped.verdict == "feasible" and decide_filled(answer.space, stocks).weights
    return shaped.added_mass if balances else None


def _cylinder(
    space: DesignSpace, body: int, region: Region, shape: WeightShape, radius: float
) -> Region:
    """Make a cylinder about the middle of a region, as thick as a shape that is flat.

    Raises:
        UsageError: the region holds no such shape at any height.
    """
    axes, plane = axes_and_height(space, body)
    height = height_within(region, shape, axes[2], plane)
    at = axes[:2].T @ axes[:2] @ region.centre + height * axes[2]
    length = shape.size if shape.flat else 2.0 * radius
    centre, axis = _rounded(at, PLACE_DECIMALS), _rounded(axes[2], AXIS_DECIMALS)
    return cylinder_region(centre, axis, radius, length)


def _rounded(numbers: Array, decimals: int) -> Array:
    """Round numbers, without a negative zero."""
    return np.asarray(round_decimals(numbers, decimals) + 0.0)


def _preferred_above(size: float) -> list[float]:
    """List the preferred numbers above a size, up to some times as large."""
    decade = int(np.floor(np.log10(size)))
    numbers = [float(f"{number:g}e{decade + k}") for k in range(2) for number in R10]
    return [number for number in numbers if size < number <= LARGEST_CHANGE * size]
