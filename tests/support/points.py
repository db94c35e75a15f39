"""Added matter in the limit of infinite density: point masses, for laws that hold there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from balance.masses.counterweights.counterweights import counterweights
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.regions import Region
from balance.masses.partial_balance.budgets import partial
from balance.masses.partial_balance.partial_balance import PartialBalance
from balance.space.spaces.design_space import DesignSpace
from kinematics.loading.model_gallery import LinkageLike


def point_counterweights(
    space: DesignSpace | LinkageLike,
    links: Sequence[str],
    regions: Mapping[str, Region | str] | None = None,
    **options: object,
) -> Counterweights:
    """Find the least point masses that balance; see `balance.counterweights`."""
    return counterweights(space, links, regions, density=None, **options)


def point_partial(
    space: DesignSpace | LinkageLike, links: Sequence[str], budget: float, **options: object
) -> PartialBalance:
    """Find the point masses of the least shaking; see `balance.partial`."""
    return partial(space, links, budget, density=None, **options)
