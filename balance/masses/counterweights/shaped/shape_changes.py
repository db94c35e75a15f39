"""Changes of a request for counterweights of a shape, each of which was found to balance.

Sizes are the most rounded preferred numbers of the series R''10 (ISO 3), ten in a decade.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.alike_links import alike_links, classes_among
from balance.masses.counterweights.counterweights_result import Counterweights, Relaxation
from balance.masses.counterweights.link_regions import (
    ALL,
    default_region,
    is_about_joint,
    radius_text,
)
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

ROUNDED = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
# Largest factor by which a region or a size grows.
LARGEST_CHANGE = 5.0
# Further sizes that are tried where some part of a shape is held by nothing.
MORE_SIZES = 2
# Decimals of the centre of a region, m, and of its axis.
PLACE_DECIMALS, AXIS_DECIMALS = 6, 12


def shape_changes(
    answer: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> tuple[Relaxation, ...]:
    """Find larger regions, and a larger size, with which counterweights of a shape balance.

    The regions of links that are alike, or else of all, grow: balls about the joint of their
    link in their radius, and others become cylinders across the plane of the linkage about
    their centres. Where nothing helps sectors of a given radius, they get
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


class ShapeTrial(NamedTuple):
    """A change with which shapes balance, and whether they are whole; see `are_whole`."""

    change: Relaxation
    whole: bool


def _growths(
    answer: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> tuple[Relaxation, ...]:
    """Find larger regions, and a larger size, for the same kind of shape.

    Where some of them give shapes that are joined to their links, the others are left out.
    """
    space = answer.space
    classes = classes_among(alike_links(space.linkage), stocks)
    changes = [larger_regions(answer, stocks, choices, alike) for alike in classes]
    if not any(changes) and len(classes) > 1:
        changes = [larger_regions(answer, stocks, choices, tuple(stocks))]
    if len(choices) == 1:
        changes.append(_larger_size(answer, stocks, choices[0]))
    helpful = [trial for trial in changes if trial]
    helpful = [trial for trial in helpful if trial.whole] or helpful
    growths = [trial.change.factor or 0.0 for trial in helpful]
    return tuple(helpful[k].change for k in rank_least_first(growths, relative=MASS_GAP))


def _first_whole(trials: Iterable[ShapeTrial | None]) -> ShapeTrial | None:
    """Return the first trial whose shapes are whole, of few that balance; else the first."""
    balanced: list[ShapeTrial] = []
    for trial in trials:
        if trial is not None and trial.whole:
            return trial
        balanced += [trial] if trial else []
        if len(balanced) > MORE_SIZES:
            break
    return balanced[0] if balanced else None


def larger_regions(
    answer: Counterweights,
    stocks: Mapping[int, Stock],
    choices: Sequence[WeightShape],
    bodies: Sequence[int],
) -> ShapeTrial | None:
    """Find the smallest balls or cylinders about the regions of links that hold the shapes."""
    space, largest = answer.space, max(choices, key=lambda shape: shape.size)
    size = max(stocks[b].region.size for b in bodies)

    def try_radius(radius: float) -> ShapeTrial | None:
        wide = {b: _wider(space, b, stocks[b].region, largest, radius) for b in bodies}
        larger = {b: stocks[b]._replace(region=wide.get(b, stocks[b].region)) for b in stocks}
        # All links with one size are tried first: all choices of several take long.
        shaped = next(
            filter(None, (balancing_shapes(answer, larger, [shape]) for shape in choices)), None
        )
        if shaped is not None and len(choices) > 1:
            shaped = balancing_shapes(answer, larger, choices)
        if shaped is None:
            return None
        texts = {b: _text_of(space, b, wide[b]) for b in bodies}
        regions = {space.bodies[b]: texts[b] for b in bodies}
        links, linkage = tuple(regions), space.linkage
        same = len({*texts.values()}) == 1 and ALL not in linkage.places
        if same and len(stocks) == len(bodies) > 1:
            regions = {ALL: texts[bodies[0]]}
        change = Relaxation(links, radius / size, shaped.added_mass, regions)
        return ShapeTrial(change, are_whole(shaped))

    try:
        return _first_whole(map(try_radius, _rounded_above(size)))
    except UsageError:
        return None


def _larger_size(
    answer: Counterweights, stocks: Mapping[int, Stock], shape: WeightShape
) -> ShapeTrial | None:
    """Find the least size of a shape, in the given regions, that balances."""

    def try_size(size: float) -> ShapeTrial | None:
        larger = [shape._replace(size=size)]
        shaped = balancing_shapes(answer, stocks, larger)
        if shaped is None:
            return None
        text = shape_text(larger)
        change = Relaxation((), size / shape.size, shaped.added_mass, shape=text)
        return ShapeTrial(change, are_whole(shaped))

    return _first_whole(map(try_size, _rounded_above(shape.size)))


def are_whole(shaped: Counterweights) -> bool:
    """Whether every shape is joined to its link, and none is too narrow to cut."""
    return not any(weight.floats or weight.too_narrow for weight in shaped.weights)


def balancing_shape_mass(
    answer: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> float | None:
    """Compute the mass of shapes that balance, kg; see `balancing_shapes`."""
    shaped = balancing_shapes(answer, stocks, choices)
    return None if shaped is None else shaped.added_mass


def balancing_shapes(
    answer: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> Counterweights | None:
    """Find shapes that balance; None if none were found.

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
    return shaped if balances else None


def _wider(
    space: DesignSpace, body: int, region: Region, shape: WeightShape, radius: float
) -> Region:
    """Make a ball of a radius about the joint of a link, if its region is one, or a cylinder.

    Raises:
        UsageError: the region holds no such shape at any height.
    """
    if is_about_joint(space, body, region):
        return default_region(space, body, radius)
    return _cylinder(space, body, region, shape, radius)


def _text_of(space: DesignSpace, body: int, region: Region) -> str:
    """Write a region as an option: a ball about the joint of its link by its radius."""
    return radius_text(region) if is_about_joint(space, body, region) else region.text


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


def _rounded_above(size: float) -> list[float]:
    """List the rounded numbers above a size, up to some times as large."""
    decade = int(np.floor(np.log10(size)))
    numbers = [float(f"{number:g}e{decade + k}") for k in range(2) for number in ROUNDED]
    return [number for number in numbers if size < number <= LARGEST_CHANGE * size]
