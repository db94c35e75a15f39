"""The least mass of weights of a shape that balances the forces of a planar linkage.

Sectors are in `balance.masses.counterweights.shaped.sectors`; discs, blocks and cylinders here.

Of a shape of mass m and first moments h = m c, that reaches ρ(m) across its axis and ζ(m)
along it, a half-space ``n·x ≤ d`` holds all if ``n·h + |n| m ρ(m) + |n_z| m ζ(m) ≤ d m``, with
the sum of absolute components for a block, and a ball or an upright cylinder likewise.
``m ρ(m)`` is a multiple of m, m^{3/2} or m², so that the mass and first moments of all shapes
inside a region are a convex set, and the least mass is a program of second-order cones, with
``m^{3/2} ≤ s`` as ``m² ≤ s w``, ``w² ≤ m``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from math import prod
from typing import TypeVar

import numpy as np

from balance.masses.counterweights.added_program import AddedProgram, build_added_program
from balance.masses.counterweights.counterweight import filled_counterweight
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.decide_points import balance_residual, with_moments
from balance.masses.counterweights.regions import Region, ball_region
from balance.masses.counterweights.shaped.across_plane import axes_and_height, height_within
from balance.masses.counterweights.shaped.sectors import decide_sectors, fan_of
from balance.masses.counterweights.shaped.weight_shape import WeightShape, shape_text
from balance.masses.counterweights.volume.cut_regions import Stock, fill
from balance.support.clarabel_adapter import ConstraintBlock, solve_conic, triangles
from balance.support.tolerances import (
    COUNTERWEIGHT_RESIDUAL,
    PART_ROUND_OFF,
    SHAPE_INSIDE,
    SHAPE_MASS_ZERO,
)
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least
from kinematics.wording import number_text

Rows = list[tuple[str, Array]]
Holding = TypeVar("Holding")

# Most choices of sizes on all links that are compared.
MOST_CHOICES = 256

# Variables of a link: mass, first moments along two axes, mass times what grows, its root in
# the cones, and distances from the middle of its region along the axes times mass.
MASS, X, Y, GROWN, ROOT, AWAY_X, AWAY_Y = range(7)
COUNT = 7
WHOLE = np.diag([0.0, 0.0, 0.0, 1.0])


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
    sizes = choices[0].plural if len(choices) == 1 else f"{kind}s ({shape_text(choices)})"
    blank = free.undecided(
        f"no {sizes} that balance were found in the regions, where "
        f"{number_text(free.added_mass)} kg of other shapes do; larger regions, or another "
        "size or shape, may hold them",
        shape=shape_text(choices),
        least_mass=free.added_mass,
    )
    if kind == "sector":
        fans = _held(free, stocks, choices, fan_of)
        answers = [decide_sectors(blank, dict(chosen)) for chosen in fans]
    else:

        def hold(free: Counterweights, b: int, stock: Stock, shape: WeightShape) -> _Holder:
            return _holder(free, b, stock, shape, program.unit)

        holders = _held(free, stocks, choices, hold)
        answers = [_decide_grown(blank, program, dict(chosen)) for chosen in holders]
    balanced = [answer for answer, _ in answers if answer.weights]
    if not balanced:
        return answers[0][0] if len(answers) == 1 else blank
    best = balanced[first_least([answer.added_mass for answer in balanced])]
    total, bound = best.added_mass, min(bound for _, bound in answers)
    return replace(
        best,
        value=total,
        gap=max(0.0, 1.0 - bound / total),
        words=f"feasible: {number_text(total)} kg of {kind}s added to "
        f"{number_text(free.given_mass)} kg balance it",
    )


def _held(
    free: Counterweights,
    stocks: Mapping[int, Stock],
    choices: Sequence[WeightShape],
    hold: Callable[[Counterweights, int, Stock, WeightShape], Holding],
) -> Iterator[tuple[tuple[int, Holding], ...]]:
    """List every choice of sizes that the regions hold: what holds each, by body."""
    lists: list[list[tuple[int, Holding]]] = []
    for b, stock in stocks.items():
        held, refused = [], None
        for shape in choices:
            try:
                held.append((b, hold(free, b, stock, shape)))
            except UsageError as error:
                refused = error
        if not held:
            raise UsageError(f"link '{free.space.bodies[b]}': {refused}") from None
        lists.append(held)
    if prod(map(len, lists)) > MOST_CHOICES:
        raise UsageError(
            f"{len(choices)} sizes on {len(stocks)} links are {prod(map(len, lists))} choices: "
            f"name fewer sizes or links, for {MOST_CHOICES} at most"
        )
    return product(*lists)


def _decide_grown(
    blank: Counterweights, program: AddedProgram, holders: Mapping[int, _Holder]
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
            weights[b] = filled_counterweight(space.bodies[b], stock, WHOLE, matter)
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


class _Holder:
    """A region that holds a shape at a height: constraints, with lengths over a unit."""

    def __init__(
        self,
        stock: Stock,
        shape: WeightShape,
        axes: Array,
        height: float,
        length: float,
        unit: float,
    ) -> None:
        """Choose the height of the shape in the region.

        Args:
            stock: region and density.
            shape: the shape.
            axes: orthonormal rows (3, 3) of the link frame, the last one normal to the plane.
            height: that of the plane of the linkage along it, m.
            length: unit of length, m.
            unit: kilograms per unit of mass.
        """
        self.region, self.density, self.shape, self.axes = (
            stock.region,
            stock.density,
            shape,
            axes,
        )
        self.length = length
        self.height = height_within(stock.region, shape, axes[2], height)
        per = unit / stock.density
        self.growth = shape.growth * (np.sqrt(per) if shape.flat else per) / length

    def fill(self, mass: float, centre: Array) -> Stock:
        """Make the stock of a mass, kg, whose centre (2,) is given along the axes, m."""
        at = np.append(centre, self.height) @ self.axes
        return Stock(self.shape.place(mass, self.density, at, self.axes), self.density)

    def holds(self, part: Region) -> bool:
        """Whether all points of a part are in the region, but for errors of the solver."""
        turn = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
        rim = np.column_stack([np.cos(turn), np.sin(turn), np.ones(64)])
        points = part.vertices if part.offsets.size else np.vstack([rim, rim * [1, 1, -1]])
        return bool(self.region.contains(part.to_link(points), SHAPE_INSIDE).all())

    def rows(self) -> Rows:
        """Constraints on the variables of the link, as cones and rows (rows, 8).

        The last column is constant.
        """
        unit = np.eye(COUNT + 1)
        grows = [unit[ROOT], unit[MASS], unit[GROWN] / self.growth, unit[COUNT]]
        if self.shape.flat:
            # m² ≤ (s/κ) w and w² ≤ m.
            cones = [_rotated(grows[1], grows[2], grows[0])]
            cones.append(_rotated(grows[0], grows[1], grows[3]))
        else:
            cones = [_rotated(grows[1], grows[2], grows[3])]
        across, along = unit[GROWN], 0.5 * self.shape.size / self.length * unit[MASS]
        if not self.shape.flat:
            across, along = self.shape.size / self.length * unit[MASS], unit[GROWN]
        positive = [unit[MASS], unit[GROWN], unit[ROOT]]
        if self.region.offsets.size:
            return [*cones, ("nonnegative", np.array([*positive, *self._faces(across, along)]))]
        return [*cones, *self._round(across, along, positive)]

    def _faces(self, across: Array, along: Array) -> Array:
        """Constraints of the facets of a box or hull."""
        region, unit = self.region, np.eye(COUNT + 1)
        N = region.normals @ np.linalg.inv(region.place[:3, :3])
        sizes = np.linalg.norm(N, axis=1)
        room = region.offsets + N @ region.centre
        N, room = N / sizes[:, None] @ self.axes.T, room / sizes
        order = 1 if self.shape.kind == "block" else 2
        reach = np.linalg.norm(N[:, :2], order, axis=1)
        constant = (room - N[:, 2] * self.height) / self.length
        return np.asarray(
            np.outer(constant, unit[MASS])
            - N[:, :2] @ unit[[X, Y]]
            - np.outer(reach, across)
            - np.outer(np.abs(N[:, 2]), along)
        )

    def _round(self, across: Array, along: Array, positive: list[Array]) -> Rows:
        """Constraints of a ball, or of a cylinder along the normal."""
        region, unit = self.region, np.eye(COUNT + 1)
        *middle, height = (self.axes @ region.centre / self.length).tolist()
        off = abs(self.height / self.length - height)
        radius = float(np.linalg.norm(region.place[:3, 0])) / self.length
        away = [unit[X] - middle[0] * unit[MASS], unit[Y] - middle[1] * unit[MASS]]
        reach = [unit[AWAY_X] + across]
        if self.shape.kind == "block":
            reach.append(unit[AWAY_Y] + across)
            inside: Rows = []
            for distance, at in zip((AWAY_X, AWAY_Y), away, strict=True):
                positive = [*positive, unit[distance] - at, unit[distance] + at]
        else:
            inside = [("second_order", np.array([unit[AWAY_X], *away]))]
        if region.kind == "ball":
            reach.append(off * unit[MASS] + along)
        else:
            half = float(np.linalg.norm(region.place[:3, 2])) / self.length
            positive = [*positive, (half - off) * unit[MASS] - along]
        inside.append(("second_order", np.array([radius * unit[MASS], *reach])))
        return [*inside, ("nonnegative", np.array(positive))]


def _solve(program: AddedProgram, holders: Mapping[int, _Holder]) -> tuple[Array, Array, float]:
    """Minimise the mass.

    Returns:
        Masses (links,) in units of mass, 0 where there is none or no answer; centres
        (links, 2), m, along the axes of each; and a lower bound, infinite if none balance.
    """
    n, length = len(holders), program.space.length
    A = np.zeros((program.target.size, n, 3))
    for k, holder in enumerate(holders.values()):
        for i, (mass, moment) in enumerate(_basis(holder, length)):
            P = np.zeros((4, 4))
            P[3, 3], P[:3, 3], P[3, :3] = mass, moment, moment
            A[:, k, i] = program.rows[k] @ triangles(P)
    rows, offsets, blocks = [np.zeros((len(A), n, COUNT))], [-program.target], []
    rows[0][:, :, : Y + 1] = A
    blocks.append(ConstraintBlock("zero", len(A)))
    for k, holder in enumerate(holders.values()):
        for kind, part in holder.rows():
            block = np.zeros((len(part), n, COUNT))
            block[:, k] = part[:, :COUNT]
            rows.append(block)
            offsets.append(part[:, COUNT])
            blocks.append(ConstraintBlock(kind, len(part)))  # type: ignore[arg-type]
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


def _basis(holder: _Holder, length: float) -> list[tuple[float, Array]]:
    """List mass and first moments, link frame, m, of units of the first three variables."""
    e1, e2, normal = holder.axes
    return [(1.0, holder.height * normal), (0.0, length * e1), (0.0, length * e2)]


def _feels_inertia(program: AddedProgram) -> bool:
    """Whether second moments count in the conditions."""
    second = np.zeros((4, 4))
    second[:3, :3] = 1.0
    counted = program.rows * (triangles(second) != 0.0)
    return bool(np.abs(counted).max() > PART_ROUND_OFF * np.abs(program.rows).max())


def _rotated(x: Array, y: Array, z: Array) -> tuple[str, Array]:
    """Make the cone ``x² ≤ y z``."""
    return "second_order", np.array([y + z, 2.0 * x, y - z])


def _holder(
    free: Counterweights, body: int, stock: Stock, shape: WeightShape, unit: float
) -> _Holder:
    """Prepare the region of a link to hold a shape."""
    axes, height = axes_and_height(free, body)
    return _Holder(stock, shape, axes, height, free.space.length, unit)
