"""Added matter as counterweights, and the budget that limits it."""

from __future__ import annotations

from math import isfinite

import numpy as np

from balance.masses.counterweights.counterweight import (
    Counterweight,
    counterweight_of,
    filled_counterweight,
)
from balance.masses.counterweights.lumps import lumps_of
from balance.masses.partial_balance.motion_loads import AddedParameters
from balance.masses.partial_balance.shaking_program import ShakingProgram
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import TRIANGLES
from balance.support.tolerances import LUMP_SHARE_LEAST
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array


def counterweights_at(
    space: DesignSpace, matter: AddedParameters, s: Array
) -> tuple[Counterweight, ...]:
    """Describe the matter of each link that gets more than round-off.

    Args:
        space: a design space of the linkage, for the names of its bodies.
        matter: the regions.
        s: coordinates of what is placed (count,).
    """
    weights = []
    total = float(matter.masses @ s)
    for (b, region), part in zip(matter.regions.items(), matter.parts(s), strict=True):
        P = (TRIANGLES[4] @ part).reshape(4, 4)
        if P[3, 3] > LUMP_SHARE_LEAST * total:
            lumps = lumps_of(region, P, False)
            # Lumps fit the matter to about 1e-6; their mass is the one that the budget allows.
            unit = float(P[3, 3] / lumps.masses.sum())
            weights.append(counterweight_of(space.bodies[b], region, lumps, unit))
    return tuple(weights)


def filled_counterweights_at(
    space: DesignSpace, program: ShakingProgram, forms: Array, s: Array
) -> tuple[Counterweight, ...]:
    """Describe the matter of limited density of each link that gets more than round-off.

    Args:
        space: a design space of the linkage, for the names of its bodies.
        program: the regions and densities.
        forms: matrices (links, 4, 4) that are positive about where the matter is.
        s: coordinates of what is placed (count,).
    """
    matter, weights = program.matter, []
    total = float(matter.masses @ s)
    # There are no forms where nothing is added.
    forms = forms if len(forms) else np.zeros((len(program.stocks), 4, 4))
    parts = zip(matter.regions, program.stocks, forms, matter.parts(s), strict=True)
    for b, stock, form, part in parts:
        P = (TRIANGLES[4] @ part).reshape(4, 4)
        if P[3, 3] > LUMP_SHARE_LEAST * total:
            weights.append(filled_counterweight(space.bodies[b], stock, form, P))
    return tuple(weights)


def check_budget(budget: float) -> None:
    """Raise UsageError for a budget that is no mass, kilograms."""
    if not (isfinite(budget) and budget >= 0.0):
        raise UsageError(f"a budget of {budget:g} kg is none: give a mass from 0 up")
