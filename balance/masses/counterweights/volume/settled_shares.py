"""Shares that are moved: in a master program of `fill_program`, and for Newton's method.

That needs equations, and a dual that is smooth. A link whose matter may be moved has one of:

- nothing, or the largest share, is taken and more is placed: the share stays.
- A share between is taken, and more is placed: what is taken is worth nothing,
  ``<Q, P> = -price m``, which is an equation for the multipliers y. They are ``y_0 + N η``
  then, and the share is the multiplier of that equation.
- As much is placed as was taken: the share follows from what is placed.
- As much is placed as may be taken: one more condition.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_program import (
    AddedProgram,
    after_taking,
    orthonormal_conditions,
)
from balance.support.clarabel_adapter import triangles
from balance.support.tolerances import PLACED_AS_TAKEN
from kinematics.numerics.array_types import Array, Flags, IntArray

NO_LINKS = np.empty(0, dtype=np.int64)


class Settled(NamedTuple):
    """A program whose shares are settled.

    Attributes:
        program: the program, in which nothing may be taken, in the multipliers η.
        prices: its polynomials C_b (links, 10).
        start: start of η.
        shares: shares that stay as they are (links,).
        follows: links whose share is what is placed there (links,).
        between: positions (k,) of links whose share is the multiplier of an equation.
        effects: what a whole share of each of these leaves of the conditions (conditions, k).
        origin: multipliers y_0 of the conditions.
        basis: N (conditions, multipliers).
    """

    program: AddedProgram
    prices: Array
    start: Array
    shares: Array
    follows: Flags
    between: IntArray
    effects: Array
    origin: Array
    basis: Array

    def multipliers(self, eta: Array) -> Array:
        """Compute y of the conditions."""
        return np.asarray(self.origin + self.basis @ eta)

    def shares_of(self, asked: AddedProgram, placed: Array) -> Array:
        """Compute the shares (links,) for what is placed (links, 4, 4) in a program."""
        taken = asked.taken
        masses = np.where(self.follows, taken.masses, 1.0)
        shares = np.where(self.follows, placed[:, 3, 3] / masses, self.shares)
        if self.between.size:
            missing = after_taking(asked, shares, NO_LINKS, shares).target
            missing = missing - np.einsum("lrj,lj->r", asked.rows, triangles(placed))
            effects = self.effects[: len(missing)]
            between_shares = -np.linalg.lstsq(effects, missing, rcond=None)[0]
            shares[self.between] = np.clip(between_shares, 0.0, taken.most[self.between])
        return shares


def settled(
    program: AddedProgram,
    prices: Array,
    y: Array,
    shares: Array,
    placed: Array,
    shifts: Array,
    last: bool,
) -> Settled:
    """Settle the shares of a master program.

    Args:
        program: the program.
        prices: its polynomials C_b (links, 10).
        y: its multipliers (conditions,).
        shares: share that is taken from each link (links,).
        placed: mass that is placed on each link (links,).
        shifts: multipliers of ``placed - taken`` (links,).
        last: whether shares between stay as they are too.
    """
    taken = program.taken
    shares = np.where(shares > PLACED_AS_TAKEN, taken.rounded(shares), 0.0)
    largest = shares >= taken.most - PLACED_AS_TAKEN
    tight = (shares > 0.0) & (placed <= shares * taken.masses * (1.0 + PLACED_AS_TAKEN))
    follows, some = tight & ~largest, (shares > 0.0) & ~tight & ~largest
    between = np.flatnonzero(some & (not last))
    stays = np.where(largest, taken.most, shares)
    stays[follows], stays[between] = 0.0, 0.0
    full = np.flatnonzero(tight & largest)
    fixed = after_taking(program, stays, full, taken.most * taken.masses)
    rows, costs, P = fixed.rows.copy(), prices.copy(), triangles(taken.matter)
    unit = triangles(np.diag([0.0, 0.0, 0.0, 1.0]))
    for k in np.flatnonzero(follows):
        mean = P[k] / taken.masses[k]
        rows[k] -= np.outer(rows[k] @ mean, unit)
        costs[k] += (program.price_of_moving - prices[k] @ mean) * unit
    effects = np.array([rows[k] @ P[k] for k in between]).reshape(-1, rows.shape[1]).T
    worth = np.array([prices[k] @ P[k] for k in between])
    worth = worth - program.price_of_moving * taken.masses[between]
    start = np.append(y, shifts[full])
    origin, basis = np.zeros(len(start)), np.eye(len(start))
    if between.size:
        origin = np.linalg.lstsq(effects.T, worth, rcond=None)[0]
        basis = orthonormal_conditions(np.linalg.qr(effects)[0]).T
    return Settled(
        fixed._replace(
            rows=np.einsum("ri,lrj->lij", basis, rows), target=basis.T @ fixed.target
        ),
        costs - np.einsum("r,lrj->lj", origin, rows),
        basis.T @ start,
        stays,
        follows,
        between,
        effects,
        origin,
        basis,
    )


def with_shares(
    program: AddedProgram,
    cost: Array,
    price: float,
    master: tuple[Array, Array, Array],
    masses: Array,
) -> tuple[Array, Array, Array]:
    """Add shares that may be taken to a master program, behind its variables and its rows.

    Args:
        program: the program.
        cost: polynomials of the objective (links, 10).
        price: price of a unit of mass that is taken.
        master: objective, rows and offset; the first rows are the conditions, and the last,
            if the largest moment of inertia is minimised, those of the moments of inertia.
        masses: masses of the parts (parts, links), whose shares are the first variables.

    Returns:
        The same with the shares; the further rows are not negative.
    """
    taken, (q, rows, offset) = program.taken, master
    n, links, heavy = masses.size, taken.links, len(q) > masses.size and price > 0.0
    P, more = triangles(taken.matter), np.zeros((len(rows), len(links)))
    limits = np.zeros((3 * len(links), len(q) + len(links)))
    for i, k in enumerate(links):
        more[: program.target.size, i] = -program.rows[k] @ P[k]
        if heavy:
            at = len(rows) - 6 * (masses.shape[1] - k)
            more[at : at + 6, i] = program.inertia[0][k] @ P[k]
        of_link = np.zeros_like(masses)
        of_link[:, k] = masses[:, k] / taken.masses[k]
        limits[3 * i : 3 * i + 2, len(q) + i] = 1.0, -1.0
        limits[3 * i + 2, :n], limits[3 * i + 2, len(q) + i] = of_link.reshape(-1), -1.0
    prices = price * taken.masses - np.einsum("lj,lj->l", cost, P)
    most = np.ravel([[0.0, taken.most[k], 0.0] for k in links])
    rows = np.vstack([np.hstack([rows, more]), limits])
    return np.append(q, prices[links]), rows, np.append(offset, most)
