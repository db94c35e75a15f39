"""Designs whose bodies may be of any density, for laws that hold without a material."""

from __future__ import annotations

from balance.masses.designs.best_design import Design, design
from balance.masses.designs.objectives import Objective
from balance.space.spaces.design_space import DesignSpace
from kinematics.loading.model_gallery import LinkageLike


def design_of_any_density(
    space: DesignSpace | LinkageLike, minimise: Objective | None = None, **options: object
) -> Design:
    """Design masses without a limit of density; see `balance.design`."""
    return design(space, minimise, density=None, **options)
