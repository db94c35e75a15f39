"""Regions that hold a shape: its mass and first moments as second-order cones.

Of a shape of mass m and first moments h = m c, that reaches ρ(m) across its axis and ζ(m)
along it, a half-space ``n·x ≤ d`` holds all if ``n·h + |n| m ρ(m) + |n_z| m ζ(m) ≤ d m``, with
the sum of absolute components for a block, and a ball or an upright cylinder likewise.
``m ρ(m)`` is a multiple of m, m^{3/2} or m², so that the mass and first moments of all shapes
inside a region are a convex set, with ``m^{3/2} ≤ s`` as ``m² ≤ s w``, ``w² ≤ m``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from math import prod
from typing import TypeVar

import numpy as np

from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.shaped.across_plane import axes_and_height, height_within
from balance.masses.counterweights.shaped.weight_shape import WeightShape
from balance.masses.counterweights.volume.cut_regions import Stock
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import ConstraintBlock
from balance.support.tolerances import SHAPE_INSIDE
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array

Rows = list[tuple[str, Array]]
Holding = TypeVar("Holding")

# Most choices of sizes on all links that are compared.
MOST_CHOICES = 256

# Variables of a link: mass, first moments along two axes, mass times what grows, its root in
# the cones, and distances from the middle of its region along the axes times mass.
MASS, X, Y, GROWN, ROOT, AWAY_X, AWAY_Y = range(7)
COUNT = 7
# The form that is positive everywhere.
WHOLE = np.diag([0.0, 0.0, 0.0, 1.0])


def held_choices(
    space: DesignSpace,
    stocks: Mapping[int, Stock],
    choices: Sequence[WeightShape],
    hold: Callable[[int, Stock, WeightShape], Holding],
) -> Iterator[tuple[tuple[int, Holding], ...]]:
    """List every choice of sizes that the regions hold: what holds each, by body.

    Raises:
        UsageError: a region holds no size of the shape, or there are too many choices.
    """
    lists: list[list[tuple[int, Holding]]] = []
    for b, stock in stocks.items():
        held, refused = [], None
        for shape in choices:
            try:
                held.append((b, hold(b, stock, shape)))
            except UsageError as error:
                refused = error
        if not held:
            raise UsageError(f"link '{space.bodies[b]}': {refused}") from None
        lists.append(held)
    if prod(map(len, lists)) > MOST_CHOICES:
        raise UsageError(
            f"{len(choices)} sizes on {len(stocks)} links are {prod(map(len, lists))} choices: "
            f"name fewer sizes or links, for {MOST_CHOICES} at most"
        )
    return product(*lists)


class ShapeHolder:
    """A region that holds a shape at a height: constraints, with lengths over a unit.

    Attributes:
        region: the region.
        density: kg/m³.
        shape: the shape.
        axes: orthonormal rows (3, 3) of the link frame, the last one normal to the plane.
        height: that of the shape along the last one, m.
        length: unit of length, m.
    """

    def __init__(
        self,
        space: DesignSpace,
        body: int,
        stock: Stock,
        shape: WeightShape,
        unit: float,
    ) -> None:
        """Choose the height of the shape in the region.

        Args:
            space: a design space of the linkage, which is planar.
            body: position of the body.
            stock: region and density.
            shape: the shape, no sector.
            unit: kilograms per unit of mass.

        Raises:
            UsageError: the region holds no such shape.
        """
        axes, height = axes_and_height(space, body)
        self.region, self.density, self.shape, self.axes = (
            stock.region,
            stock.density,
            shape,
            axes,
        )
        self.length = space.length
        self.height = height_within(stock.region, shape, axes[2], height)
        per = unit / stock.density
        self.growth = shape.growth * (np.sqrt(per) if shape.flat else per) / self.length

    def fill(self, mass: float, centre: Array) -> Stock:
        """Make the stock of a mass, kg, whose centre (2,) is given along the axes, m."""
        at = np.append(centre, self.height) @ self.axes
        return Stock(self.shape.place(mass, self.density, at, self.axes), self.density)

    def holds(self, part: Region, tolerance: float = SHAPE_INSIDE) -> bool:
        """Whether all points of a part are in the region, but for errors of the solver."""
        return bool(self.region.contains(part.rim, tolerance).all())

    def moment_matrices(self) -> list[Array]:
        """List mass and first moments (4, 4), link frame, of units of `MASS`, `X` and `Y`."""
        e1, e2, normal = self.axes
        matrices = []
        for mass, moment in (
            (1.0, self.height * normal),
            (0.0, self.length * e1),
            (0.0, self.length * e2),
        ):
            P = np.zeros((4, 4))
            P[3, 3], P[:3, 3], P[3, :3] = mass, moment, moment
            matrices.append(P)
        return matrices

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


def holding_rows(
    holders: Sequence[ShapeHolder],
) -> tuple[list[Array], list[Array], list[ConstraintBlock]]:
    """Stack the constraints of all links: rows (rows, links, 7), constants, and cones."""
    rows, offsets, blocks = [], [], []
    for k, holder in enumerate(holders):
        for kind, part in holder.rows():
            block = np.zeros((len(part), len(holders), COUNT))
            block[:, k] = part[:, :COUNT]
            rows.append(block)
            offsets.append(part[:, COUNT])
            blocks.append(ConstraintBlock(kind, len(part)))  # type: ignore[arg-type]
    return rows, offsets, blocks


def _rotated(x: Array, y: Array, z: Array) -> tuple[str, Array]:
    """Make the cone ``x² ≤ y z``."""
    return "second_order", np.array([y + z, 2.0 * x, y - z])
