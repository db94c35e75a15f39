"""The least mass of weights of a shape that balances the forces of a planar linkage.

Sectors are in `balance.masses.counterweights.shaped.sectors`; discs, blocks and cylinders here.

Mass and first moments of the shapes inside a region are a convex set
(`balance.masses.counterweights.shaped.shape_holder`), and the least mass is a program of
second-order cones.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_program import AddedProgram, build_added_program
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.decide_points import balance_residual, with_moments
from balance.masses.counterweights.regions import ball_region
from balance.masses.counterweights.shaped.sectors import decide_sectors, fan_of
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
from balance.masses.counterweights.shaped.weight_shape import (
    WeightShape,
    shape_text,
    shapes_in_words,
)
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic, triangles
from balance.support.tolerances import (
    COUNTERWEIGHT_RESIDUAL,
    PART_ROUND_OFF,
    SHAPE_INSIDE,
    SHAPE_MASS_ZERO,
    WEBBED_INSIDE,
)
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least
from kinematics.wording import number_text

# Rounds in which shapes with webs fulfil the conditions, and the step of differences, over the
# unit of length.
FULFILLED, DIFFERENCE = 4, 1e-6


def decide_shaped(
    free: Counterweights, stocks: Mapping[int, Stock], choices: Sequence[WeightShape]
) -> Counterweights:
    """Find the least mass of counterweights of a shape, whose size may be one of several.

    Args:
        free: the least matter of this density of any shape, which balances.
        stocks: regions and densities by position of the body.
        choices: the shape in each of its sizes, of which every link gets one.

    Raises:
        UsageError: the conditions feel moments of inertia, a region holds no size of the
            shape, or there are too many choices.
    """
    space, kind = free.space, choices[0].kind
    regions = {b: ball_region(np.zeros(3), 1.0) for b in stocks}
    program = build_added_program(space, regions, "mass")
    if _feels_inertia(program):
        raise UsageError("shapes are found for forces, and these conditions feel inertia too")
    sizes = shapes_in_words(choices)
    blank = free.undecided(
        f"no {sizes} that balance were found in the regions, where "
        f"{number_text(free.added_mass)} kg of other shapes do",
        shape=shape_text(choices),
        least_mass=free.added_mass,
    )
    if kind == "sector":
        fans = held_choices(space, stocks, choices, partial(fan_of, space))
        answers = [decide_sectors(blank, dict(chosen)) for chosen in fans]
    else:

        def hold(b: int, stock: Stock, shape: WeightShape) -> ShapeHolder:
            return ShapeHolder(space, b, stock, shape, program.unit)

        holders = held_choices(space, stocks, choices, hold)
        answers = [_decide_grown(blank, program, dict(chosen)) for chosen in holders]
    balanced = [answer for answer, _ in answers if answer.weights]
    if not balanced:
        return blank
    joined = [each for each in balanced if not any(weight.floats for weight in each.weights)]
    built = joined or balanced
    best = built[first_least([answer.added_mass for answer in built])]
    total, bound = best.added_mass, min(bound for _, bound in answers)
    webs = " with webs" * any(weight.web is not None for weight in best.weights)
    return replace(
        best,
        value=total,
        gap=max(0.0, 1.0 - bound / total),
        words=f"feasible: {number_text(total)} kg of {kind}s{webs} added to "
        f"{number_text(free.given_mass)} kg balance it",
    )


class _GrownTask(NamedTuple):
    """The search for discs, blocks or cylinders of given sizes that balance.

    Attributes:
        program: the conditions.
        holders: what holds the shapes, by position of the body.
    """

    program: AddedProgram
    holders: Mapping[int, ShapeHolder]

    def webs(self, x: Array) -> Array:
        """Compute mass and first moments (links, 3) of the webs of shapes."""
        program = self.program
        return web_coordinates(program.space, self.holders, program.unit, x)

    def columns(self) -> Array:
        """Compute the conditions on mass and first moments (ρ, links, 3)."""
        A = np.zeros((self.program.target.size, len(self.holders), Y + 1))
        for k, holder in enumerate(self.holders.values()):
            for i, P in enumerate(holder.moment_matrices()):
                A[:, k, i] = self.program.rows[k] @ triangles(P)
        return A

    def minimise(self, webs: Array) -> tuple[Array, float]:
        """Minimise the mass of shapes that balance beside webs (links, 3).

        Returns:
            Mass and first moments (links, 3), 0 where there is none or no answer; and a lower
            bound of the whole mass, infinite if none balance.
        """
        holders, A = list(self.holders.values()), self.columns()
        n, target = len(holders), self.program.target - np.einsum("rki,ki->r", A, webs)
        balanced = np.zeros((len(A), n, COUNT))
        balanced[:, :, : Y + 1] = A
        rows, offsets, blocks = holding_rows(holders)
        rows, offsets = [balanced, *rows], [-target, *offsets]
        blocks = [ConstraintBlock("zero", len(A)), *blocks]
        q = np.zeros((n, COUNT))
        q[:, MASS] = 1.0
        offset = np.concatenate(offsets)
        solution = solve_conic(
            q.reshape(-1), np.concatenate(rows).reshape(len(offset), -1), offset, blocks
        )
        if solution.infeasible:
            return np.zeros((n, Y + 1)), np.inf
        x = solution.x.reshape(n, COUNT)[:, : Y + 1]
        x = np.where(x[:, :1] > SHAPE_MASS_ZERO * x[:, MASS].sum(), x, 0.0)
        return x, float(webs[:, MASS].sum()) - float(offset @ solution.dual)

    def fulfil(self, x: Array, webbed: bool) -> Array:
        """Change first moments (links, 3), so that they fulfil the conditions to round-off.

        The moments of webs follow by differences.
        """
        A, x, kept = self.columns(), x.copy(), x[:, MASS] > 0.0
        for _ in range(FULFILLED if webbed else 1):
            webs = self.webs(x) if webbed else np.zeros_like(x)
            residual = self.program.target - np.einsum("rki,ki->r", A, x + webs)
            slopes = A[:, :, X:].copy()
            for i in (X, Y) if webbed else ():
                step = np.zeros_like(x)
                step[:, i] = DIFFERENCE * x[:, MASS]
                change = (self.webs(x + step) - webs) / np.where(kept, step[:, i], 1.0)[:, None]
                slopes[:, :, i - X] += np.einsum("rki,ki->rk", A, change)
            shift = np.linalg.lstsq(slopes[:, kept].reshape(len(A), -1), residual, rcond=None)
            x[kept, X:] += shift[0].reshape(-1, 2)
        return x

    def judge(
        self, blank: Counterweights, x: Array, bound: float, webbed: bool
    ) -> tuple[Counterweights, float]:
        """Make the shapes of masses and first moments, and check that they balance.

        Args:
            blank: the answer where they do not.
            x: mass and first moments (links, 3).
            bound: lower bound of the mass.
            webbed: whether their webs are counted.

        Returns:
            The answer, and the bound, kg.
        """
        program, holders = self.program, self.holders
        space, x = program.space, self.fulfil(x, webbed)
        weights, moments = {}, np.zeros((len(holders), 4, 4))
        for k, (b, holder) in enumerate(holders.items()):
            if x[k, MASS] > 0.0:
                centre = space.length * x[k, X:] / x[k, MASS]
                stock = holder.fill(program.unit * x[k, MASS], centre)
                region = holder.region if webbed else None
                weights[b], P = shape_weight(space, b, stock, region)
                moments[k] = P / program.unit
        z = with_moments(program, moments)
        residual = balance_residual(space, z)
        tolerance = WEBBED_INSIDE if webbed else SHAPE_INSIDE
        inside = all(holders[b].holds(each.region, tolerance) for b, each in weights.items())
        if not weights or not residual <= COUNTERWEIGHT_RESIDUAL or not inside:
            return blank, program.unit * bound
        answer = replace(
            blank,
            verdict="feasible",
            z=freeze(z),
            residual=residual,
            weights=tuple(weights.values()),
        )
        return answer, program.unit * bound


def _decide_grown(
    blank: Counterweights, program: AddedProgram, holders: Mapping[int, ShapeHolder]
) -> tuple[Counterweights, float]:
    """Find the least mass of discs, blocks or cylinders with webs, and a bound, kg.

    Where webs do not settle, they are not counted.
    """
    task = _GrownTask(program, holders)
    x, bound = task.minimise(np.zeros((len(holders), Y + 1)))
    plain = task.judge(blank, x, bound, webbed=False)
    if not any(weight.floats for weight in plain[0].weights) or not task.webs(x).any():
        return plain
    settled = settle_webs(task.webs, task.minimise, x)
    if settled is None:
        return plain
    answer = task.judge(blank, *settled, webbed=True)
    return answer if answer[0].weights else plain


def _feels_inertia(program: AddedProgram) -> bool:
    """Whether second moments count in the conditions."""
    second = np.zeros((4, 4))
    second[:3, :3] = 1.0
    counted = program.rows * (triangles(second) != 0.0)
    return bool(np.abs(counted).max() > PART_ROUND_OFF * np.abs(program.rows).max())
