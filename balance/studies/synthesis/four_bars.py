"""Balanced four-bars whose coupler passes through two or three positions.

Kite and antiparallelogram can be balanced if their base is longer than √2 times the crank. In
units of the crank, with the base on the real axis from 0 to r and the crank tip ``A = e^(iα)``,
the tip B of the rocker is the mirror image in the line from A to r of

    kite: 0           antiparallelogram: A + r

The turn of the coupler depends on α alone. For a ratio r and a first angle α_1 the turns φ_i
give the other angles α_i, and so the poles p_i of the displacements of the coupler in these
units. A similarity ``z → s z + t`` brings poles to poles: for three positions s and t follow
from two poles, for two from one pole and a chosen pivot. So there is a design for every r and
α_1 for which all φ_i can be had, and the best of a grid is taken.

Source: which four-bars can be balanced, R. Ricard, C. Gosselin, 2000; B. Moore, PhD thesis,
Linz, 2009. The method of G. Becht, MSc thesis, TU Delft, 2020, does not find them.
"""

from __future__ import annotations

import cmath
import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.motion.motion_tolerances import SYNTHESIS_SINGULAR
from balance.studies.synthesis.constrained_motion import Defect
from balance.studies.synthesis.positions import Displacement, Position, displacements, size_of
from balance.studies.synthesis.zero_contour import refine_roots
from kinematics.errors import SynthesisError
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.linalg.ties import rank_least_first

Complex = NDArray[np.complex128]

FOUR_BARS = ("kite", "antiparallelogram")
"""Kinds of four-bars that can be balanced."""
# Ratios of base and crank that are tried; masses exist above √2.
RATIOS = (1.5, 1.7, 2.0, 2.4, 3.0, 4.0)
# Angles of the crank from one change point to the next; the ends are left out.
ANGLES = np.linspace(0.0, math.pi, 122)[6:-6]
# First angles of the crank that are tried: every so many.
STRIDE = 5
# Least length of the crank and largest distance of a pivot, over the size of the positions.
SMALLEST, LARGEST = 0.02, 50.0


class CouplerMotion(ABC):
    """What a linkage whose coupler carries the tool does, and how near it comes to positions.

    Attributes:
        kind: of the mechanism.
        positions: of the tool.
        crank_angles: of the crank at each position, radians.
        tool_link: link that carries the tool.
    """

    kind: str
    positions: tuple[Position, ...]
    crank_angles: tuple[float, ...]
    tool_link: str = "coupler"

    @property
    @abstractmethod
    def defects(self) -> tuple[Defect, ...]:
        """Branch and order defects of the motion."""

    @abstractmethod
    def pivots(self, index: int = 0) -> dict[str, complex]:
        """Compute the pivots at a position, metres, inertial frame."""

    @abstractmethod
    def tool_points(self, crank_angles: ArrayLike) -> Complex:
        """Compute the point of the tool for angles of the crank."""

    @abstractmethod
    def tool_turns(self, crank_angles: ArrayLike) -> Complex:
        """Compute ``e^(iθ)`` of the angle of the tool for angles of the crank."""

    def outline(self, index: int) -> tuple[complex, ...]:
        """Compute a line along the links: crank, coupler with the tool, rocker."""
        at, tool = self.pivots(index), complex(self.tool_points(self.crank_angles[index]))
        A, B = at["crank_tip"], at["rocker_tip"]
        return at["crank_base"], A, tool, B, A, B, at["rocker_base"]

    @property
    def numbers(self) -> dict[str, float]:
        """Lengths of crank and base, metres."""
        at = self.pivots()
        base = at["crank_base"]
        return {
            "crank": abs(at["crank_tip"] - base),
            "base": abs(at["rocker_base"] - base),
        }

    @property
    def error(self) -> float:
        """Largest distance of the tool from its positions, metres."""
        return float(self._distances.max())

    @property
    def _distances(self) -> Array:
        """Distances of the tool from its positions (n,), metres."""
        points = self.tool_points(self.crank_angles)
        return np.abs(points - [each.point for each in self.positions])

    @property
    def angle_error(self) -> float:
        """Largest difference of the angle of the tool from those of its positions, radians."""
        return float(self._angle_errors.max())

    @property
    def _angle_errors(self) -> Array:
        """Sizes of the differences of the angle of the tool from those (n,), radians."""
        wanted = np.exp(-1j * np.array([each.angle for each in self.positions]))
        return np.abs(np.angle(self.tool_turns(self.crank_angles) * wanted))

    @property
    def miss(self) -> float:
        """The larger of both, metres: the angle as an arc of the size of the positions."""
        return max(self.error, size_of(self.positions) * self.angle_error)

    def meets(self, within: float) -> bool:
        """Whether it misses no position by more than a distance, metres."""
        return self.miss <= within

    @property
    def spread(self) -> float:
        """Largest distance of a pivot from the first position of the tool, metres."""
        tool = self.positions[0].point
        return max(abs(z - tool) for z in self.pivots().values())


@dataclass(frozen=True)
class FourBarDesign(CouplerMotion):
    """A four-bar whose coupler carries the tool through positions.

    Attributes:
        kind: ``"kite"`` or ``"antiparallelogram"``.
        positions: of the tool.
        ratio: length of the base over that of the crank.
        crank_angles: α at each position, radians, from the direction of the base.
        scale: s: length of the crank, metres, and direction of the base.
        fixed: pivot of the crank, metres, inertial frame.
        first: pose of the tool at the first angle of the crank; it is the first position unless
            there are more positions than a four-bar can pass.
    """

    kind: str
    positions: tuple[Position, ...]
    ratio: float
    crank_angles: tuple[float, ...]
    scale: complex
    fixed: complex
    first: Position

    def pivots(self, index: int = 0) -> dict[str, complex]:
        """Compute the pivots at a position, metres, inertial frame."""
        A, B = place_four_bar(self.kind, self.ratio, self.crank_angles[index])
        points = {
            "crank_base": 0j,
            "rocker_base": complex(self.ratio),
            "crank_tip": complex(A),
            "rocker_tip": complex(B),
        }
        return {name: self.scale * z + self.fixed for name, z in points.items()}

    def tool_points(self, crank_angles: ArrayLike) -> Complex:
        """Compute the point of the tool for angles α of the crank."""
        A, _ = place_four_bar(self.kind, self.ratio, crank_angles)
        arm = self.first.point - self.pivots()["crank_tip"]
        turns = self._coupler_turns(crank_angles)
        return np.asarray(self.scale * A + self.fixed + turns * arm)

    def _coupler_turns(self, crank_angles: ArrayLike) -> Complex:
        """Compute ``e^(iφ)`` of the coupler from the first angle of the crank to others."""
        A, B = place_four_bar(self.kind, self.ratio, crank_angles)
        start, end = place_four_bar(self.kind, self.ratio, self.crank_angles[0])
        return np.asarray((B - A) / (end - start))

    def tool_turns(self, crank_angles: ArrayLike) -> Complex:
        """Compute ``e^(iθ)`` of the angle of the tool for angles α of the crank."""
        return self._coupler_turns(crank_angles) * cmath.exp(1j * self.first.angle)

    @property
    def defects(self) -> tuple[Defect, ...]:
        """Order defects; branches and circuits are those of one interval of the crank."""
        return order_defects(self.crank_angles)


def order_defects(crank_angles: Sequence[float]) -> tuple[Defect, ...]:
    """Say in which order a crank meets its positions, if in another than the given one."""
    steps = np.diff(crank_angles)
    if steps.size < 2 or np.all(steps > 0.0) or np.all(steps < 0.0):
        return ()
    ranks = np.argsort(crank_angles).tolist()
    ranks = ranks if ranks[0] < ranks[-1] else ranks[::-1]
    order = ", ".join(str(k + 1) for k in ranks)
    return (Defect("order", f"the crank meets the positions in the order {order}"),)


def place_four_bar(kind: str, ratio: float, crank_angle: ArrayLike) -> tuple[Complex, Complex]:
    """Compute the tips A of the crank and B of the rocker, in units of the crank.

    Args:
        kind: ``"kite"`` or ``"antiparallelogram"``.
        ratio: length of the base.
        crank_angle: α, radians, no multiple of π; any shape.
    """
    A = np.exp(1j * np.asarray(crank_angle, dtype=np.float64))
    line = (A - ratio) / np.abs(A - ratio)
    image = A if kind == "antiparallelogram" else np.full(A.shape, -ratio)
    return A, ratio + line**2 * image.conjugate()


def four_bars_through(
    positions: Sequence[Position],
    kind: str,
    *,
    fixed: complex | None = None,
    moving: complex | None = None,
) -> tuple[FourBarDesign, ...]:
    """Find balanced four-bars whose coupler passes through positions.

    Args:
        positions: two or three positions of the tool.
        kind: ``"kite"`` or ``"antiparallelogram"``.
        fixed: pivot of the crank on the base, for two positions; metres, inertial frame.
        moving: or pivot of the crank on the coupler, at the first position.

    Returns:
        The designs, those without defects and with near pivots first; none if the coupler
        cannot turn so far between two change points.

    Raises:
        SynthesisError: two positions have the same angle, or a chosen pivot is the pole.
    """
    steps = displacements(positions)
    poles = [_pole(step, k) for k, step in enumerate(steps, 2)]
    near = SYNTHESIS_SINGULAR * size_of(positions)
    if any(abs(poles[0] - z) < near for z in (fixed, moving) if z is not None):
        raise SynthesisError(
            "the chosen pivot is the pole of the displacement", "choose a pivot away from it"
        )
    if len(poles) == 2 and abs(poles[1] - poles[0]) < near:
        raise SynthesisError("both displacements have one pole", "give other positions")
    designs = [
        _fit(kind, tuple(positions), ratio, angles, steps, poles, fixed, moving)
        for ratio in RATIOS
        for angles in crank_angles(kind, ratio, steps)
    ]
    size = size_of(positions)
    good = [
        each
        for each in designs
        if SMALLEST * size < abs(each.scale) and each.spread < LARGEST * size
    ]
    ranks = rank_least_first([each.spread for each in good])
    return tuple(sorted((good[k] for k in ranks), key=lambda each: len(each.defects)))


def _pole(step: Displacement, number: int) -> complex:
    """Return the pole of a displacement."""
    if step.pole is None:
        raise SynthesisError(
            f"positions 1 and {number} have the same angle: their displacement has no pole",
            "give positions that differ in angle",
        )
    return step.pole


def _coupler_angles(kind: str, ratio: float, angles: Array) -> Array:
    """Compute the angle of the coupler, continued along the last axis."""
    A, B = place_four_bar(kind, ratio, angles)
    return np.unwrap(np.angle(B - A))


def crank_angles(
    kind: str, ratio: float, steps: Sequence[Displacement]
) -> Iterator[tuple[float, ...]]:
    """Yield the angles of the crank at all positions, for first angles of a grid."""
    firsts = np.arange(0, len(ANGLES), STRIDE)
    for angles in (ANGLES, -ANGLES):
        others = [_angles_after(kind, ratio, angles, firsts, step.turn) for step in steps]
        for first, *rests in zip(angles[firsts].tolist(), *others, strict=True):
            for rest in product(*rests):
                yield first, *rest


def _angles_after(
    kind: str, ratio: float, angles: Array, firsts: IntArray, turn: float
) -> list[list[float]]:
    """Find the angles of the crank after a turn of the coupler, for each first angle."""
    coupler_angles = _coupler_angles(kind, ratio, angles)
    gaps = coupler_angles - coupler_angles[firsts, None] - math.remainder(turn, 2.0 * math.pi)
    row, at = np.nonzero(gaps[:, :-1] * gaps[:, 1:] < 0.0)
    A, B = place_four_bar(kind, ratio, angles[firsts])
    goal = ((B - A) * cmath.exp(1j * turn))[row]
    step = angles[1] - angles[0]

    def miss(part: Array) -> Array:
        A, B = place_four_bar(kind, ratio, angles[at] + part * step)
        return np.asarray(np.angle((B - A) / goal))

    roots = angles[at] + refine_roots(miss, len(at)) * step
    return [roots[row == k].tolist() for k in range(len(firsts))]


def _fit(
    kind: str,
    positions: tuple[Position, ...],
    ratio: float,
    angles: tuple[float, ...],
    steps: tuple[Displacement, ...],
    poles: Sequence[complex],
    fixed: complex | None,
    moving: complex | None,
) -> FourBarDesign:
    """Place a four-bar so that the poles of its coupler are those of the positions."""
    A = [complex(place_four_bar(kind, ratio, angle)[0]) for angle in angles]
    unit_poles = [
        (after - step.rotation * A[0]) / (1.0 - step.rotation)
        for after, step in zip(A[1:], steps, strict=True)
    ]
    if len(unit_poles) == 2:
        scale = (poles[1] - poles[0]) / (unit_poles[1] - unit_poles[0])
    elif fixed is not None:
        scale = (poles[0] - fixed) / unit_poles[0]
    else:
        assert moving is not None
        scale = (poles[0] - moving) / (unit_poles[0] - A[0])
    fixed = poles[0] - scale * unit_poles[0]
    return FourBarDesign(kind, positions, ratio, angles, scale, fixed, positions[0])
