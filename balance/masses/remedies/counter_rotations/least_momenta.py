"""The least sum of the momenta of counter-rotors on given joints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from balance.masses.counterweights.program import IDLE_MASS_PRICE
from balance.masses.designs.clarabel_adapter import ConstraintBlock, solve_conic
from balance.masses.designs.pseudo_inertia_cone import cone_of_columns
from balance.masses.remedies.counter_rotations.counter_rotors import RotorConditions
from balance.masses.remedies.counter_rotations.rotor_sets import rotor_basis

Array = NDArray[np.float64]


def least_momenta(conditions: RotorConditions, chosen: Sequence[int]) -> Array:
    """Compute the momenta with the least sum that balance a linkage.

    Every body has at least the matter of the file, ``P_b ⪰ P_b(file)``, so that matter is
    added only. If the file has no masses, ``P_b ⪰ 1`` in kg and characteristic lengths. Without
    a price on the mass the least sum would not be reached: the same counterweight has the less
    inertia, the heavier and the nearer to its joint it is.

    Args:
        chosen: positions of the rotors of a feasible set.

    Returns:
        J of the chosen rotors (s,), kg m².
    """
    if not chosen:
        return np.zeros(0)
    z, J = rotor_basis(conditions, chosen)
    cone = cone_of_columns(conditions.space, z)
    # Masses in units of their mean, as the tolerances of the solver are absolute.
    file = cone_of_columns(conditions.space, conditions.given[:, None]).blocks[:, 0]
    unit = float(file[:, -1, -1].mean()) or 1.0
    least = file / unit if file.any() else np.tile(np.eye(cone.size), (len(file), 1, 1))
    rows = np.concatenate([cone.stack_rows(cone.blocks), J])
    offset = np.concatenate([-cone.rows(least).reshape(-1), np.zeros(len(J))])
    masses = cone.blocks[:, :, -1, -1].sum(axis=0)
    parts = [cone.part] * len(file) + [ConstraintBlock("nonnegative", len(J))]
    solution = solve_conic(J.sum(axis=0) + IDLE_MASS_PRICE * masses, rows, offset, parts)
    return np.maximum(unit * conditions.space.length**2 * (J @ solution.x), 0.0)
