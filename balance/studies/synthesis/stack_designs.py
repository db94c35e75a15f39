"""Stacks of three antiparallelograms whose tool passes through positions.

Three cranks make a tool free in the plane, so that every position within reach has angles of
the cranks. With the middle of the lowest base b, its angle ψ, the angles γ_2, γ_3 of the other
bases and that of the tool from the couplers that carry them, and the angles α of the cranks at
each of n positions, there are 3 n equations in 3 n + 6 unknowns, solved by least squares near a
start within bounds on α: each crank stays on one side of its change points. The ratio of base
and crank and the size are taken from lists, the smallest size that does for each ratio. The six
are then rounded, and the angles of the cranks follow anew.

A coupler turns by at most ``2 arcsin(1 / r)`` for a base of r cranks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from balance.motion.motion_tolerances import SYNTHESIS_MET
from balance.studies.synthesis.four_bar_stack import (
    StackedFourBar,
    StackPoints,
    bare_stack,
    coupler_turn,
    place_stack,
)
from balance.studies.synthesis.positions import Position, size_of
from kinematics.errors import SynthesisError
from kinematics.numerics.array_types import Array

Complex = NDArray[np.complex128]

KIND = "antiparallelogram"
COUNT = 3
"""Four-bars of a stack: freedoms of a tool in the plane."""
RATIOS = (3.0, 2.4, 2.0, 1.7)
"""Bases over cranks that are tried: long ones are light, short ones turn the tool further."""
# Cranks of the three, over that of the lowest.
CRANKS = (1.0, 0.7, 0.5)
# Length of the lowest crank that is tried, over the size of the positions.
SIZES = (0.35, 0.6, 1.0, 2.0)
# How near a crank may come to a change point in the search and in a design, radians.
CLEAR, CLEAREST = 0.5, 0.45
# Angles γ_2, γ_3 and ψ with which the search starts, and the sides of the cranks.
STARTS = ((1.2, -0.8, 0.0), (-1.0, 2.0, 2.1))
SIDES = tuple(product((1.0, -1.0), repeat=COUNT))
# Decimals of the angles of a design, and of its place over the size of the positions.
DECIMALS = 3
# Most evaluations of a search, and largest condition number of the tool at a position.
EVALUATIONS, CONDITION = 25, 200.0
# Weight that keeps a search near its start, and misses up to which it has come near positions.
NEAR, CLOSE = 0.01, 0.05
# Steps of Newton's method.
STEPS = 12
# Poses along each line between two positions.
SAMPLES = 50
# Angles of a crank of which the range of its coupler is taken.
RANGE_SAMPLES = 2000


@dataclass(frozen=True)
class StackDesign:
    """A stack whose last coupler carries the tool through positions.

    Attributes:
        positions: of the tool.
        modules: the four-bars; the pose of their angles is position 1.
        middle: of the lowest base, metres.
        crank_angles: of all cranks from their bases at each position (positions, 3), radians.
    """

    positions: tuple[Position, ...]
    modules: tuple[StackedFourBar, ...]
    middle: complex
    crank_angles: Array

    def place(self, crank_angles: Array) -> StackPoints:
        """Compute the points of the stack for angles of the cranks (…, 3)."""
        return place_stack(self.modules, crank_angles, self.middle)

    @cached_property
    def placed(self) -> StackPoints:
        """The stack at the positions."""
        return self.place(self.crank_angles)

    @property
    def urdf(self) -> bytes:
        """The file without masses, at position 1."""
        return bare_stack(self.place(self.crank_angles[0]), self.positions[0], "stack")

    @property
    def turns(self) -> Array:
        """Turns of the cranks from position 1 (positions, 3), radians."""
        return self.crank_angles - self.crank_angles[0]

    @property
    def tool(self) -> complex:
        """Tool point from the middle of the last coupler, at position 1, metres."""
        return self.positions[0].point - complex(self.placed.middle[0])

    @property
    def error(self) -> float:
        """Largest distance of the tool from its positions, metres."""
        arms = self.tool * np.exp(1j * (self.placed.turn - self.placed.turn[0]))
        points = np.array([each.point for each in self.positions])
        return float(np.abs(self.placed.middle + arms - points).max())

    @property
    def angle_error(self) -> float:
        """Largest difference of its turn from theirs, radians; whole turns count."""
        wanted = np.array([each.angle for each in self.positions])
        turns = self.placed.turn - self.placed.turn[0]
        return float(np.abs(turns - (wanted - wanted[0])).max())

    def way(self) -> Complex:
        """Compute the path of the tool, all cranks on straight lines; metres, (N,)."""
        placed = self.place(self._way_angles())
        arms = self.tool * np.exp(1j * (placed.turn - self.placed.turn[0]))
        return np.asarray(placed.middle + arms)

    @property
    def transmission(self) -> float:
        """Least angle between coupler and rocker, or its supplement, on the way, radians."""
        _, rockers, tips, ends = np.moveaxis(self.place(self._way_angles()).pins, 1, 0)
        between = np.sin(np.angle((ends - tips) / (ends - rockers)))
        return float(np.arcsin(np.abs(between).min()))

    def _way_angles(self) -> Array:
        """Compute the angles of the cranks along the way (N, 3)."""
        share = np.linspace(0.0, 1.0, SAMPLES)[:, None, None]
        start, end = self.crank_angles[:-1], self.crank_angles[1:]
        return np.asarray((start + share * (end - start)).swapaxes(0, 1).reshape(-1, COUNT))

    def outline(self, index: int) -> tuple[complex, ...]:
        """Compute a line along the links of each four-bar at a position, and to the tool."""
        line: list[complex] = []
        for base, rocker, tip, end in self.placed.pins[:, :, index].tolist():
            line += [base, tip, end, rocker, complex(np.nan, np.nan)]
        return (*line, complex(self.placed.middle[index]), self.positions[index].point)

    @property
    def pivots(self) -> dict[str, complex]:
        """Where each four-bar stands at position 1, metres."""
        names = ("crank_base", "rocker_base")
        return {
            f"{name}_{k}": complex(pins[j])
            for k, pins in enumerate(self.placed.pins[:, :, 0], 1)
            for j, name in enumerate(names)
        }


def stack_designs(positions: Sequence[Position]) -> Iterator[StackDesign]:
    """Find stacks of antiparallelograms through positions, the lightest kind first.

    Args:
        positions: two to twenty positions of the tool.

    Returns:
        One for each ratio of base and crank and each size with which the positions were met,
        small ones first, as they are found.

    Raises:
        SynthesisError: the tool turns further than three couplers.
    """
    angles = [each.angle for each in positions]
    turn, ranges = max(angles) - min(angles), [COUNT * _turn_range(ratio) for ratio in RATIOS]
    if turn >= max(ranges):
        raise SynthesisError(
            f"the tool of a stack turns by up to {math.degrees(max(ranges)):.0f}°, and the "
            f"positions differ by {math.degrees(turn):.0f}°",
            "give positions whose angles differ less",
        )
    ratios = [ratio for ratio, most in zip(RATIOS, ranges, strict=True) if turn < most]
    return _designs(tuple(positions), ratios)


def _designs(positions: tuple[Position, ...], ratios: Sequence[float]) -> Iterator[StackDesign]:
    """Search all sizes of the ratios."""
    for ratio, size in product(ratios, SIZES):
        searches = (
            _Search(positions, ratio, size, np.array(sides)).run(start)
            for sides, start in product(SIDES, STARTS)
        )
        design = next((each for each in searches if each is not None), None)
        if design is not None:
            yield design


def _turn_range(ratio: float) -> float:
    """Compute how far a coupler turns within the bounds of its crank, radians."""
    room = np.linspace(CLEAR, math.pi - CLEAR, RANGE_SAMPLES)
    return float(np.ptp(coupler_turn(KIND, ratio, room)))


class _Search:
    """The search for a stack of a ratio, a size and sides of its cranks.

    Unknowns are x and y of the lowest base over the size of the positions, ψ, γ_2, γ_3, the
    angle of the tool from the last coupler, and the angles of the cranks at each position.
    """

    def __init__(
        self, positions: tuple[Position, ...], ratio: float, size: float, sides: Array
    ) -> None:
        """Take what stays the same in a search."""
        self.positions, self.ratio, self.sides = positions, ratio, sides
        self.size = size_of(positions)
        self.centre = sum(each.point for each in positions) / len(positions)
        self.points = (np.array([each.point for each in positions]) - self.centre) / self.size
        self.angles = np.array([each.angle for each in positions])
        self.modules = [
            StackedFourBar(KIND, crank * size, ratio, float(side) * 0.5 * math.pi)
            for crank, side in zip(CRANKS, sides, strict=True)
        ]

    def run(self, start: tuple[float, float, float]) -> StackDesign | None:
        """Search from angles γ_2, γ_3 and ψ; None if no stack is met there."""
        from scipy.optimize import least_squares

        x = self._start(start)
        rooms = np.abs(self.sides) * np.array([[CLEAR], [math.pi - CLEAR]])
        ends = np.sort(self.sides * rooms, axis=0)
        limits = [
            np.concatenate([np.full(6, sign * np.inf), np.tile(end, len(self.angles))])
            for sign, end in zip((-1.0, 1.0), ends, strict=True)
        ]
        # There are more unknowns than equations: of the stacks that pass, one near the start.
        near = NEAR * np.eye(x.size)
        solution = least_squares(
            lambda y: np.concatenate([self._misses(y), NEAR * (y - x)]),
            x,
            lambda y: np.vstack([self._jacobian(y), near]),
            bounds=limits,
            max_nfev=EVALUATIONS,
        )
        if np.abs(self._misses(solution.x)).max() > CLOSE:
            return None
        fixed = solution.x[:6].round(DECIMALS)
        return self._finish(fixed, solution.x[6:].reshape(-1, COUNT))

    def _start(self, start: tuple[float, float, float]) -> Array:
        """Place the stack so that its last coupler is in the middle of the positions."""
        second, third, first = start
        alpha = np.tile(0.5 * math.pi * self.sides, (len(self.angles), 1))
        placed = place_stack(self.modules, alpha[0], 0j, (first, second, third))
        tool = 0.5 * (self.angles.min() + self.angles.max()) - float(placed.turn)
        at = complex(placed.middle)
        return np.array([-at.real, -at.imag, first, second, third, tool, *alpha.ravel()])

    def _misses(self, x: Array) -> Array:
        """Compute how far the tool is from its positions, in their size and radians."""
        placed = self._place(x[:6], x[6:].reshape(-1, COUNT))
        apart = placed.middle - self.points
        return np.concatenate([apart.real, apart.imag, placed.turn + x[5] - self.angles])

    def _place(self, fixed: Array, alpha: Array) -> StackPoints:
        """Place the stack at angles of the cranks (…, 3)."""
        x, y, first, second, third = fixed[:5].tolist()
        return place_stack(self.modules, alpha, complex(x, y), (first, second, third))

    def _jacobian(self, x: Array) -> Array:
        """Compute the derivatives; an angle of a base turns all that it carries."""
        count, alpha = len(self.angles), x[6:].reshape(-1, COUNT)
        placed = self._place(x[:6], alpha)
        J = np.zeros((3, count, x.size))
        J[0, :, 0] = J[1, :, 1] = J[2, :, 2:6] = 1.0
        for k, pins in enumerate(placed.pins):
            arm = 1j * (placed.middle - 0.5 * (pins[0] + pins[1]))
            J[0, :, 2 + k], J[1, :, 2 + k] = arm.real, arm.imag
        for j, by_crank in enumerate(self._by_cranks(x[:6], alpha)):
            J[:, j, 6 + COUNT * j : 6 + COUNT * (j + 1)] = by_crank
        return J.reshape(3 * count, x.size)

    def _by_cranks(self, fixed: Array, alpha: Array) -> Array:
        """Compute x, y and turn of the tool by the cranks, at each position (n, 3, 3)."""
        step = 1e-6 * np.eye(COUNT)[:, None]
        ahead, behind = self._place(fixed, alpha + step), self._place(fixed, alpha - step)
        moved, turned = ahead.middle - behind.middle, ahead.turn - behind.turn
        return np.stack([moved.real, moved.imag, turned]).transpose(2, 0, 1) / 2e-6

    def _finish(self, fixed: Array, alpha: Array) -> StackDesign | None:
        """Find the angles of the cranks for rounded dimensions, and check their bounds."""
        for _ in range(STEPS):
            J = self._by_cranks(fixed, alpha)
            if np.linalg.cond(J).max() > CONDITION:
                return None
            misses = self._misses(np.concatenate([fixed, alpha.ravel()]))
            alpha = alpha - np.linalg.solve(J, misses.reshape(3, -1).T[..., None])[..., 0]
            room = self.sides * alpha
            if not np.all((room > CLEAREST) & (room < math.pi - CLEAREST)):
                return None
        if np.abs(misses).max() > SYNTHESIS_MET:
            return None
        return self._design(fixed, alpha)

    def _design(self, fixed: Array, alpha: Array) -> StackDesign:
        """Write the stack in metres, with its angles at position 1."""
        x, y, first, second, third = fixed[:5].tolist()
        # The angle of a base is that of the one below, the turn of its coupler, and γ.
        placed = [
            float(place_stack(self.modules[:k], alpha[0, :k], 0j, (0.0,) * k).turn)
            for k in range(COUNT)
        ]
        bases = (first, *(g + placed[k] - placed[k - 1] for k, g in ((1, second), (2, third))))
        modules = tuple(
            module._replace(
                crank=module.crank * self.size,
                crank_angle=float(alpha[0, k]),
                base_angle=bases[k],
            )
            for k, module in enumerate(self.modules)
        )
        middle = self.centre + self.size * complex(x, y)
        return StackDesign(self.positions, modules, middle, alpha)
