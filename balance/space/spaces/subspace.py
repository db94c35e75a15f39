"""A design space of fewer distributions, all of which another one contains."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np

from balance.space.conditions.collect import relative_tolerance
from balance.space.conditions.rank import Conditions
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.space_data import Order
from kinematics.numerics.array_types import Array


def subspace(
    space: DesignSpace, serial: Array, other: Array, orders: tuple[Order, ...] | None = None
) -> DesignSpace:
    """Replace the distributions of a design space.

    Args:
        serial: columns that span the new serial part (parameters, any), in the units of the
            chain.
        other: columns that span the rest.
        orders: rank and nullity by order; those of ``space`` by default.

    Returns:
        The space that the columns span, with an orthonormal basis; without certainty, and with
        the transfers of ``space``.
    """
    tolerance = relative_tolerance(space.chain)
    columns = np.concatenate([serial, other], axis=1).T
    spanned = Conditions.given(np.empty((0, columns.shape[1])), tolerance).append(columns)
    across = spanned.decide().basis.T
    conditions = Conditions.given(serial.T, tolerance).append(across)
    decision = conditions.decide()
    plain = {item.name: getattr(space, item.name) for item in fields(DesignSpace) if item.init}
    return replace(
        DesignSpace(**plain),
        orders=orders or space.orders,
        serial_nullity=len(conditions.known),
        decision=decision,
    )
