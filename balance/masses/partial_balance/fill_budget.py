"""Matter of limited density by Newton's method: the least load, the least mass without load.

With R = [A a] over matter s of limited density, whose support functions are h_b, and its masses
``m·s``, half the square of ``|A s + a|`` within a budget B has the dual

    maximise u·a - λ B - ½ |u|² - Σ_b h_b(-(Aᵀ u + λ m)_b)

over u and λ ≥ 0. Where the budget counts, it is smooth and strictly concave in u, and at its
maximum, where ``u = A s + a`` and ``m·s = B``, matter is where the forms are positive.

Where the budget is enough for no load at all, the least mass with ``A s = -a`` is that of the
dual of `balance.masses.counterweights.volume.fill_program`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.volume.dual_ascent import fill_by_newton
from balance.masses.partial_balance.motion_loads import COORDINATES
from balance.masses.partial_balance.shaking_program import ShakingProgram
from balance.support.clarabel_adapter import triangles
from balance.support.tolerances import FIXED_RANK_RELATIVE
from kinematics.numerics.array_types import Array


class FilledBudget(NamedTuple):
    """The matter of the least load among that whose mass is the budget.

    Attributes:
        s: coordinates of the added matter (count,).
        price: λ over ``|u|``: load that a kilogram more would save.
        forms: matrices (links, 4, 4), positive where matter is.
    """

    s: Array
    price: float
    forms: Array


class _Conditions(NamedTuple):
    """Conditions on what fills the regions, as `maximise_dual` has them.

    Attributes:
        rows: ``-[A; m]``, or A, by links (links, conditions, 10), per unit of mass.
        target: ``[a; -B]``, B in units of mass, or ``-a``.
        unit: kilograms per unit of mass.
    """

    rows: Array
    target: Array
    unit: float


def fill_budget(
    program: ShakingProgram, budget: float, load: Array, price: float
) -> FilledBudget | None:
    """Minimise ``|R [s; 1]|`` over matter of limited density that uses a budget up.

    Args:
        program: without caps, for the root of the mean, and with no matter that may be moved.
        budget: kilograms; masses are computed in units of it.
        load: about ``R [s; 1]`` at the minimum (rows,).
        price: about the load that a kilogram more would save there.

    Returns:
        The minimiser; None if Newton's method does not end at one.
    """
    # Loads in units of that of the file, mass in units of the budget.
    scale, links = program.scale, len(program.stocks)
    columns, given = program.factor[:, :-1] / scale, program.factor[:, -1] / scale
    flat = -budget * np.vstack([columns, program.matter.masses / budget])
    rows = flat.reshape(len(flat), links, COORDINATES).swapaxes(0, 1)
    target = np.append(given, -1.0)
    conditions = _Conditions(np.ascontiguousarray(rows), target, budget)
    none, quadratic = np.zeros((links, COORDINATES)), np.append(np.ones(len(columns)), 0.0)
    size = float(np.linalg.norm(load)) / scale
    start = np.append(load / scale, price * size * budget / scale)
    filling = fill_by_newton(conditions, program.stocks, none, start, quadratic=quadratic)
    price = float(filling.y[-1])
    if price <= 0.0 or not filling.balances:
        return None
    s = budget * triangles(filling.moments).reshape(-1)
    return FilledBudget(s, price * scale * scale / (program.value(s) * budget), filling.forms)


def fill_without_load(
    program: ShakingProgram, mass: float, multipliers: Array, price: float
) -> tuple[Array, Array] | None:
    """Minimise the mass of matter of limited density that leaves no load.

    Args:
        program: see `fill_budget`.
        mass: an estimate of the least, kilograms; masses are computed in units of it.
        multipliers: an estimate of u (rows,): the polynomials of the links are
            ``Aᵀ u + price · masses``.
        price: of mass in them.

    Returns:
        Coordinates s (count,), and matrices (links, 4, 4), positive where matter is; None if
        Newton's method does not end at a minimum.
    """
    scale, links = program.scale, len(program.stocks)
    A, given = program.factor[:, :-1] / scale, program.factor[:, -1] / scale
    U, values, V = np.linalg.svd(A, full_matrices=False)
    kept = values > FIXED_RANK_RELATIVE * values[0]
    U, flat = U[:, kept], mass * values[kept, None] * V[kept]
    rows = flat.reshape(len(flat), links, COORDINATES).swapaxes(0, 1)
    conditions = _Conditions(np.ascontiguousarray(rows), -given @ U, mass)
    cost = program.matter.masses.reshape(links, COORDINATES)
    start = -scale * (multipliers @ U) / (price * mass)
    filling = fill_by_newton(conditions, program.stocks, cost, start)
    if not filling.balances:
        return None
    return mass * triangles(filling.moments).reshape(-1), filling.forms
