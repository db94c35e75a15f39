"""The least shaking force of weights of a shape: discs, blocks, cylinders and sectors.

Shaking forces feel mass and first moments alone. Those of all shapes inside a region are a
convex set (`balance.masses.counterweights.shaped.shape_holder`), so that the least root mean
square of the force, or its lowest peak, over the shapes within a budget is one program of
second-order cones for each choice of sizes. Moments of inertia of shapes grow with the square
of their mass: where shaking moments, torques or bearing forces count, that set is not convex.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.shaped.sectors import fan_of, sector_about
from balance.masses.counterweights.shaped.shape_holder import (
    COUNT,
    MASS,
    ShapeHolder,
    X,
    Y,
    held_choices,
    holding_rows,
)
from balance.masses.counterweights.shaped.webs import (
    settle_webs,
    shape_weight,
    web_coordinates,
)
from balance.masses.counterweights.shaped.weight_shape import WeightShape
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.masses.partial_balance.least_shaking import (
    LeastShaking,
    bounded_rows,
    least_shaking,
    loosened_limit,
)
from balance.masses.partial_balance.motion_loads import AddedParameters
from balance.masses.partial_balance.shaking_program import ShakingProgram
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import (
    TRIANGLES,
    ConstraintBlock,
    solve_conic,
    triangles,
)
from balance.support.tolerances import (
    PRICE_ZERO,
    SHAPE_INSIDE,
    SHAPE_MASS_ZERO,
    WEBBED_INSIDE,
)
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least

# Least part of the budget that is left beside webs while they settle, and rounds in which
# shapes with webs are fitted into it.
LEAST_ROOM, FITTED = 1e-3, 20


def least_shaped_shaking(
    space: DesignSpace,
    program: ShakingProgram,
    choices: Sequence[WeightShape],
    budget: float,
    free: LeastShaking,
) -> LeastShaking:
    """Minimise the shaking force over weights of a shape, whose size may be one of several.

    Args:
        space: a design space of the linkage for force balance.
        program: the loads, the regions and the densities, without caps.
        choices: the shape in each of its sizes, of which every link gets one.
        budget: most mass to add, kilograms; above 0.
        free: the least shaking of matter of any shape.

    Raises:
        UsageError: a region holds no size of the shape, or there are too many choices.
    """
    stocks = dict(zip(program.matter.regions, program.stocks, strict=True))
    if choices[0].kind == "sector":
        fans = held_choices(space, stocks, choices, partial(fan_of, space))
        answers = [_minimise_sectors(space, program, dict(chosen), budget) for chosen in fans]
    else:
        unit = min(budget, program.unit)

        def hold(b: int, stock: Stock, shape: WeightShape) -> ShapeHolder:
            return ShapeHolder(space, b, stock, shape, unit)

        holders = held_choices(space, stocks, choices, hold)
        answers = [
            _minimise_held(space, program, dict(chosen), budget, unit) for chosen in holders
        ]
    joined = [
        answer
        for answer in answers
        if answer.weights and not any(weight.floats for weight in answer.weights)
    ]
    built = joined or answers
    best = built[first_least([answer.value for answer in built])]
    best = best._replace(any_shape=free.value)
    bound = max(free.bound, min(answer.bound for answer in answers))
    if best.value <= program.given:
        return best._replace(bound=min(bound, best.value))
    none = np.zeros(program.matter.count)
    return best._replace(
        s=none, value=program.given, bound=min(bound, program.given), weights=()
    )


def _minimise_held(
    space: DesignSpace,
    program: ShakingProgram,
    holders: Mapping[int, ShapeHolder],
    budget: float,
    unit: float,
) -> LeastShaking:
    """Minimise the shaking over discs, blocks or cylinders of given sizes, with their webs.

    Where webs do not settle, they are not counted.
    """
    task = _HeldTask(space, program, holders, budget, unit)
    none = np.zeros((len(holders), 3))
    x, bound = task.minimise(none)
    plain = task.judge(x, bound, webbed=False)
    if not any(weight.floats for weight in plain.weights) or not task.webs(x).any():
        return plain
    settled = settle_webs(task.webs, task.minimise, x)
    if settled is None:
        return plain
    answer = task.judge(*settled, webbed=True)
    return answer if answer.weights else plain


class _HeldTask(NamedTuple):
    """The search for discs, blocks or cylinders of given sizes within a budget.

    Attributes:
        space: a design space of the linkage.
        program: the loads.
        holders: what holds the shapes, by position of the body.
        budget: most mass to add, kg.
        unit: kilograms per unit of mass.
    """

    space: DesignSpace
    program: ShakingProgram
    holders: Mapping[int, ShapeHolder]
    budget: float
    unit: float

    def coordinates(self) -> Array:
        """Compute coordinates s as a function of the variables (count, links, 7)."""
        n = len(self.holders)
        T = np.zeros((n, 10, n, COUNT))
        regions = self.program.matter.regions.values()
        for k, (holder, region) in enumerate(zip(self.holders.values(), regions, strict=True)):
            for i, P in enumerate(holder.moment_matrices()):
                T[k, :, k, i] = self.unit * _in_region(region, P)
        return T.reshape(-1, n, COUNT)

    def webs(self, x: Array) -> Array:
        """Compute mass and first moments (links, 3) of the webs of shapes."""
        return web_coordinates(self.space, self.holders, self.unit, x)

    def minimise(self, webs: Array) -> tuple[Array, float]:
        """Minimise the shaking of shapes beside webs (links, 3), and among minimisers the mass.

        Returns:
            The variables (links, 7), and a lower bound of the load.
        """
        program, each, T = self.program, list(self.holders.values()), self.coordinates()
        fixed = np.einsum("cki,ki->c", T[:, :, : Y + 1], webs)
        flat = T.reshape(len(T), -1)
        whole = self.budget / self.unit
        room = max(whole - float(webs[:, MASS].sum()), LEAST_ROOM * whole)
        x, bound, price = _solve(program, each, flat, fixed, room, None)
        if price <= PRICE_ZERO:
            limit = loosened_limit(program.value(flat @ x.reshape(-1) + fixed) / program.scale)
            x = _solve(program, each, flat, fixed, room, limit)[0]
        return x, program.scale * bound

    def judge(self, x: Array, bound: float, webbed: bool) -> LeastShaking:
        """Make the shapes, none heavier than the budget lets them be, and compute their load.

        Args:
            x: the variables (links, 7).
            bound: lower bound of the load.
            webbed: whether their webs are counted.
        """
        total = float(x[:, MASS].sum())
        weights: dict[int, Counterweight] = {}
        share = 1.0
        for _ in range(FITTED if webbed else 1):
            mass = self.unit * share * total
            if webbed:
                mass += self.unit * float(self.webs(share * x)[:, MASS].sum())
            share *= min(1.0, self.budget / mass) if mass > 0.0 else 1.0
        for (b, holder), row in zip(self.holders.items(), x, strict=True):
            if row[MASS] > max(0.0, SHAPE_MASS_ZERO * total):
                centre = self.space.length * row[X : Y + 1] / row[MASS]
                stock = holder.fill(share * self.unit * float(row[MASS]), centre)
                region = holder.region if webbed else None
                weights[b] = shape_weight(self.space, b, stock, region)[0]
        inside = WEBBED_INSIDE if webbed else SHAPE_INSIDE
        if not all(self.holders[b].holds(x.region, inside) for b, x in weights.items()):
            weights = {}
        return _judge_weights(self.program, weights, bound)


def _in_region(region: Region, moments: Array) -> Array:
    """Convert moments (4, 4) in the link frame to coordinates (10,) of a region."""
    inverse = np.linalg.inv(region.place)
    return triangles(inverse @ moments @ inverse.T)


def _solve(
    program: ShakingProgram,
    holders: Sequence[ShapeHolder],
    T: Array,
    fixed: Array,
    room: float,
    limit: float | None,
) -> tuple[Array, float, float]:
    """Minimise the relative load; or, with a limit on it, the mass.

    Args:
        T: coordinates as a function of the variables.
        fixed: coordinates (count,) of what is there besides.
        room: most mass, over the unit of mass.

    Returns:
        The variables (links, 7); the value of the dual; and the price of the whole budget.
    """
    n = len(holders)
    mass = np.zeros((n, COUNT))
    mass[:, MASS] = 1.0
    samples = range(len(program.samples))
    loads = [
        bounded_rows(_beside(A, fixed) / program.scale, 0.0 if limit is None else limit, T)
        for A in program.blocks(samples)
    ]
    rows, offsets, parts = holding_rows(holders)
    whole = np.vstack(
        [
            -mass.reshape(1, -1) / room,
            *(A for A, _ in loads),
            *(row.reshape(len(row), -1) for row in rows),
        ]
    )
    offset = np.concatenate([[1.0], *(b for _, b in loads), *offsets])
    blocks = [ConstraintBlock("nonnegative", 1)]
    blocks += [ConstraintBlock("second_order", len(b)) for _, b in loads]
    q = mass.reshape(-1)
    if limit is None:
        column = np.zeros((len(whole), 1))
        column[1 + np.cumsum([0, *(len(b) for _, b in loads[:-1])])] = 1.0
        whole, q = np.hstack([whole, column]), np.append(0.0 * q, 1.0)
    solution = solve_conic(q, whole, offset, [*blocks, *parts])
    x = solution.x[: n * COUNT].reshape(n, COUNT)
    return x, -float(offset @ solution.dual), float(solution.dual[0])


def _beside(columns: Array, fixed: Array) -> Array:
    """Add the load of fixed coordinates (count,) to columns of a load (k, count + 1)."""
    return np.column_stack([columns[:, :-1], columns[:, -1] + columns[:, :-1] @ fixed])


def _minimise_sectors(
    space: DesignSpace, program: ShakingProgram, fans: Mapping[int, Stock], budget: float
) -> LeastShaking:
    """Minimise the shaking over sectors of given sizes: matter in the directions of fans."""
    regions = {b: stock.region for b, stock in fans.items()}
    blocks = [
        np.array([_in_region(region, P) for P in _list_basis(regions[b])]).T
        for b, region in program.matter.regions.items()
    ]
    T = np.zeros((program.matter.count + 1,) * 2)
    T[-1, -1] = 1.0
    for k, block in enumerate(blocks):
        T[10 * k : 10 * k + 10, 10 * k : 10 * k + 10] = block
    fanned = program.restate_over(AddedParameters.of(space, regions), T, tuple(fans.values()))
    answer = least_shaking(fanned, budget)
    assert isinstance(answer, LeastShaking)
    weights = {}
    total = float(fanned.matter.masses @ answer.s)
    for (b, stock), part in zip(fans.items(), fanned.matter.parts(answer.s), strict=True):
        matter = (TRIANGLES[4] @ part).reshape(4, 4)
        if matter[3, 3] > max(0.0, SHAPE_MASS_ZERO * total):
            weights[b] = sector_about(space.bodies[b], stock, matter)
    return _judge_weights(program, weights, answer.bound)


def _list_basis(region: Region) -> list[Array]:
    """List the moments (4, 4) in the link frame of units of the coordinates of a region."""
    basis = TRIANGLES[4].T.reshape(10, 4, 4)
    return [region.place @ S @ region.place.T for S in basis]


def _judge_weights(
    program: ShakingProgram, weights: Mapping[int, Counterweight], bound: float
) -> LeastShaking:
    """Compute what weights do, as they are."""
    s = np.zeros((len(program.matter.regions), 10))
    for k, (b, region) in enumerate(program.matter.regions.items()):
        if b in weights:
            s[k] = _in_region(region, weights[b].moments)
    flat = s.reshape(-1)
    none = np.zeros(len(s))
    return LeastShaking(
        flat, program.value(flat), max(0.0, bound), 1, none, weights=tuple(weights.values())
    )
