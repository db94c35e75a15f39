"""What the masses of the file leave of the conditions of a design space."""

from __future__ import annotations

from itertools import islice
from typing import NamedTuple

import numpy as np

from balance.space.conditions.order_kernels import generic_directions
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.momentum.regressor import rows_at
from balance.support.tolerances import AS_GIVEN_RESIDUAL
from kinematics.closure.continuation import continue_in_directions
from kinematics.closure.newton import forward_kinematics
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Finite poses at which the linear momentum is checked, beside the reference pose.
CHECKED_POSES = 3


class AsGiven(NamedTuple):
    """Residual of the masses in the file, and whether they lie in the design space.

    Attributes:
        balanced: residual up to 1e-9; None if no body has mass or inertia in the file.
        residual: size of the conditions' residual over the sum of the bodies' parts in it;
            None likewise.
    """

    balanced: bool | None
    residual: float | None

    @property
    def verdict(self) -> str:
        """The verdict in words."""
        if self.balanced is None:
            return "no masses"
        return "balanced" if self.balanced else "not balanced"


def residual_of(
    linkage: Linkage, chain: Chain, planar: bool, force: bool, rows: Array
) -> float | None:
    """Compute the residual of conditions for the masses of the file.

    Args:
        linkage: the linkage, with its masses.
        chain: its joints that move, and the units of the conditions.
        planar: whether planar parameters are counted.
        force: whether only linear momentum counts.
        rows: conditions (count, parameters) in the units of the chain.

    Returns:
        Size of what is left over the sum of the bodies' parts in it; None without masses.
    """
    given = np.array([body.inertia for body in linkage.bodies])
    return _residual(given, chain, planar, force, rows) if given.any() else None


def keeps_centre_of_mass(linkage: Linkage, chain: Chain, planar: bool) -> bool:
    """Whether the masses of the file leave their common centre of mass at rest.

    Their linear momentum is computed at the reference pose, and if it vanishes there, at
    finite poses in generic directions.
    """
    given = np.array([body.inertia for body in linkage.bodies])
    if not given.any():
        return False
    reference = forward_kinematics(chain, np.zeros(chain.parent.size))
    rays = generic_directions(101, 101 + chain.width, chain.width)
    far = islice(continue_in_directions(chain, rays), CHECKED_POSES)
    rows = rows_at(chain, reference, force=True)
    residuals = [_residual(given, chain, planar, True, rows)]
    if residuals[0] <= AS_GIVEN_RESIDUAL:
        residuals += [
            _residual(given, chain, planar, True, rows_at(moved, pose, force=True))
            for moved, pose in far
        ]
    return len(residuals) > CHECKED_POSES and max(residuals) <= AS_GIVEN_RESIDUAL


def _residual(given: Array, chain: Chain, planar: bool, force: bool, rows: Array) -> float:
    """Compute the residual of conditions for parameters (bodies, 10), SI units."""
    z = to_chain(given, chain.frame, planar, force)
    by_body = np.einsum("rbp,bp->rb", rows.reshape(-1, *z.shape), z)
    total = float(np.sqrt(np.einsum("rb,rb->b", by_body, by_body)).sum())
    remainder = by_body.sum(axis=1)
    residual = float(np.sqrt(remainder @ remainder)) / total if total > 0.0 else 0.0
    # Lengths that no double precision can square.
    return residual if np.isfinite(residual) else 1.0
