"""Shares that are moved, as a master program of `fill_program` finds them, for Newton's method.

It needs equations, and a dual that is smooth. A link whose matter may be moved has one of three:
more is placed than was taken, and the share stays as it is; as much is placed as was taken, and
the share follows; or as much as may be taken is placed, which is one more condition.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.program import AddedProgram, after_taking
from balance.support.clarabel_adapter import triangles
from balance.support.tolerances import PLACED_AS_TAKEN
from kinematics.numerics.array_types import Array, Flags


class Settled(NamedTuple):
    """A program whose shares are settled.

    Attributes:
        program: the program, in which nothing may be taken.
        prices: its polynomials C_b (links, 10).
        more: start of the multipliers of its further conditions.
        shares: shares that stay as they are (links,).
        follows: links whose share is what is placed there (links,).
    """

    program: AddedProgram
    prices: Array
    more: Array
    shares: Array
    follows: Flags

    def shares_of(self, placed: Array) -> Array:
        """Compute the shares (links,) for what is placed (links, 4, 4)."""
        masses = np.where(self.follows, self.program.taken.masses, 1.0)
        return np.where(self.follows, placed[:, 3, 3] / masses, self.shares)


def settled(
    program: AddedProgram, prices: Array, shares: Array, placed: Array, shifts: Array
) -> Settled:
    """Settle the shares of a master program.

    Args:
        program: the program.
        prices: its polynomials C_b (links, 10).
        shares: share that is taken from each link (links,).
        placed: mass that is placed on each link (links,).
        shifts: multipliers of ``placed - taken`` (links,).
    """
    taken = program.taken
    shares = taken.rounded(shares)
    largest = shares >= taken.most - PLACED_AS_TAKEN
    tight = (shares > 0.0) & (placed <= shares * taken.masses * (1.0 + PLACED_AS_TAKEN))
    follows, stays = tight & ~largest, np.where(largest, taken.most, shares)
    stays = np.where(follows, 0.0, stays)
    full = np.flatnonzero(tight & largest)
    fixed = after_taking(program, stays, full, taken.most * taken.masses)
    rows, prices = fixed.rows.copy(), prices.copy()
    unit = triangles(np.diag([0.0, 0.0, 0.0, 1.0]))
    for k in np.flatnonzero(follows):
        mean = triangles(taken.matter[k]) / taken.masses[k]
        rows[k] -= np.outer(rows[k] @ mean, unit)
        prices[k] += (program.price_of_moving - prices[k] @ mean) * unit
    return Settled(fixed._replace(rows=rows), prices, shifts[full], stays, follows)
