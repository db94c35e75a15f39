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

import numpy as np

from balance.masses.counterweights.added_program import AddedProgram, build_added_program
from balance.masses.counterweights.counterweight import filled_counterweight
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.decide_points import balance_residual, with_moments
from balance.masses.counterweights.regions import ball_region
from balance.masses.counterweights.shaped.across_plane import arm_length
from balance.masses.counterweights.shaped.sectors import decide_sectors, fan_of
from balance.masses.counterweights.shaped.shape_holder import (
    COUNT,
    MASS,
    WHOLE,
    ShapeHolder,
    X,
    Y,
    held_choices,
    holding_rows,
)
from balance.masses.counterweights.shaped.weight_shape import (
    WeightShape,
    shape_text,
    shapes_in_words,
)
from balance.masses.counterweights.volume.cut_regions import Stock, fill
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic, triangles
from balance.support.tolerances import (
    COUNTERWEIGHT_RESIDUAL,
    PART_ROUND_OFF,
    SHAPE_MASS_ZERO,
)
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least
from kinematics.wording import number_text


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
    best = balanced[first_least([answer.added_mass for answer in balanced])]
    total, bound = best.added_mass, min(bound for _, bound in answers)
    return replace(
        best,
        value=total,
        gap=max(0.0, 1.0 - bound / total),
        words=f"feasible: {number_text(total)} kg of {kind}s added to "
        f"{number_text(free.given_mass)} kg balance it",
    )


def _decide_grown(
    blank: Counterweights, program: AddedProgram, holders: Mapping[int, ShapeHolder]
) -> tuple[Counterweights, float]:
    """Find the least mass of discs, blocks or cylinders of given sizes, and a bound, kg."""
    space = program.space
    masses, centres, bound = _solve(program, holders)
    weights, moments = {}, np.zeros((len(holders), 4, 4))
    for k, (b, holder) in enumerate(holders.items()):
        if masses[k] > 0.0:
            stock = holder.fill(program.unit * masses[k], centres[k])
            matter, place = fill(stock, WHOLE), stock.region.place
            moments[k] = place @ matter @ place.T / program.unit
            arm = arm_length(space, b, stock.region)
            weights[b] = filled_counterweight(space.bodies[b], stock, WHOLE, matter, arm)
    z = with_moments(program, moments)
    residual = balance_residual(space, z)
    inside = all(holders[b].holds(weight.region) for b, weight in weights.items())
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


def _solve(
    program: AddedProgram, holders: Mapping[int, ShapeHolder]
) -> tuple[Array, Array, float]:
    """Minimise the mass.

    Returns:
        Masses (links,) in units of mass, 0 where there is none or no answer; centres
        (links, 2), m, along the axes of each; and a lower bound, infinite if none balance.
    """
    n, length = len(holders), program.space.length
    A = np.zeros((program.target.size, n, 3))
    for k, holder in enumerate(holders.values()):
        for i, P in enumerate(holder.moment_matrices()):
            A[:, k, i] = program.rows[k] @ triangles(P)
    balanced = np.zeros((len(A), n, COUNT))
    balanced[:, :, : Y + 1] = A
    rows, offsets, blocks = holding_rows(list(holders.values()))
    rows, offsets = [balanced, *rows], [-program.target, *offsets]
    blocks = [ConstraintBlock("zero", len(A)), *blocks]
    q = np.zeros((n, COUNT))
    q[:, MASS] = 1.0
    offset = np.concatenate(offsets)
    solution = solve_conic(
        q.reshape(-1), np.concatenate(rows).reshape(len(offset), -1), offset, blocks
    )
    if solution.infeasible:
        return np.zeros(n), np.zeros((n, 2)), np.inf
    x = solution.x.reshape(n, COUNT)[:, : Y + 1]
    x = np.where(x[:, :1] > SHAPE_MASS_ZERO * x[:, MASS].sum(), x, 0.0)
    kept = x[:, MASS] > 0.0
    # The first moments fulfil the conditions to round-off.
    residual = program.target - np.einsum("rki,ki->r", A, x)
    shift = np.linalg.lstsq(A[:, kept, X:].reshape(len(A), -1), residual, rcond=None)[0]
    x[kept, X:] += shift.reshape(-1, 2)
    centres = length * x[:, X:] / np.where(kept, x[:, MASS], 1.0)[:, None]
    return x[:, MASS], centres, -float(offset @ solution.dual)


def _feels_inertia(program: AddedProgram) -> bool:
    """Whether second moments count in the conditions."""
    second = np.zeros((4, 4))
    second[:3, :3] = 1.0
    counted = program.rows * (triangles(second) != 0.0)
    return bool(np.abs(counted).max() > PART_ROUND_OFF * np.abs(program.rows).max())
