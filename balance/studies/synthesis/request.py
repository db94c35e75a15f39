"""What is asked of a synthesis, and whether it contradicts itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from balance.masses.designs.density import STEEL
from balance.motion.motion_tolerances import SYNTHESIS_ANGLE_MET, SYNTHESIS_MET
from balance.studies.synthesis.circle_points import MOST_POSITIONS
from balance.studies.synthesis.function_four_bars import FunctionPoint
from balance.studies.synthesis.pantograph import PantographMasses
from balance.studies.synthesis.positions import FARTHEST, MOST, Position, size_of
from kinematics.errors import UsageError

# Kinds whose coupler is that of any four-bar.
GENERAL = ("geared-four-bar", "six-bar")
# Shortest base of a function, metres.
NEAREST = 1.0 / FARTHEST
# Fewest positions at given angles of the crank, and points of a function.
FEWEST_TIMED = 3


@dataclass(frozen=True)
class SynthesisRequest:
    """What is asked of a synthesis; see `synthesize`.

    Attributes:
        positions: of the tool.
        kind: one of `KINDS` of `balance.studies.synthesis.synthesize`.
        ratio: k of the linear case; None in the nonlinear one and for four-bars.
        fixed: the fixed pivot, if it is chosen.
        moving: the moving pivot, if it is chosen.
        masses: of the pantograph; by default in proportion to it.
        window: range of x of the free pivot, and of y for three positions, metres.
        progress: called with the number of steps done and of all steps.
        within: distance up to which four-bars may miss four or more positions, metres; or error
            of the rocker up to which they may miss a function, radians.
        density: density of the matter of four-bars at most, kg/m³; None for points.
        thickness: of plates that this matter is, metres; None to have it chosen.
        timed: whether the angles are those of the crank, and the tool turns as it may.
        function: angles of crank and rocker, instead of positions; empty for none.
        start: angles of both from the base at the first of three points, radians.
        base: length of the base of a function, metres.
    """

    positions: tuple[Position, ...]
    kind: str = "pantograph"
    ratio: float | None = None
    fixed: complex | None = None
    moving: complex | None = None
    masses: PantographMasses | None = None
    window: tuple[float, ...] | None = None
    progress: Callable[[int, int], None] | None = None
    within: float = 0.0
    density: float | None = STEEL
    thickness: float | None = None
    timed: bool = False
    function: tuple[FunctionPoint, ...] = ()
    start: tuple[float, float] | None = None
    base: float | None = None

    @property
    def count(self) -> int:
        """Number of positions, or of points of the function."""
        return len(self.function or self.positions)

    @property
    def tolerance(self) -> float:
        """Distance, metres, or angle of a rocker, radians, up to which the request is met."""
        if self.function:
            return max(self.within, SYNTHESIS_MET)
        return max(self.within, SYNTHESIS_MET * size_of(self.positions))

    def check(self) -> None:
        """Refuse a request that contradicts itself.

        Raises:
            UsageError: the number of pivots does not fit that of positions, or an option is for
                another kind.
        """
        chosen = (self.fixed is not None) + (self.moving is not None)
        approximate = (self.timed or bool(self.function)) and self.count > MOST_POSITIONS
        if self.function:
            self._check_function(chosen)
        elif self.start is not None or self.base is not None:
            raise UsageError("start angles and the length of the base are for a function")
        elif self.timed:
            self._check_timing()
        if self.kind == "stack":
            self._check_stack(chosen)
        elif self.count == 2 and chosen != 1:
            raise UsageError(
                "two positions leave one pivot free: choose the fixed or the moving one, by "
                "--fixed or --moving"
            )
        elif self.count > 2 and chosen:
            raise UsageError("three positions and more determine both pivots: choose none")
        if self.count > 3 and self.kind == "pantograph":
            raise UsageError(
                "a pantograph passes through two or three positions: --kind four-bar goes "
                "through four, and near more"
            )
        if self.count > MOST_POSITIONS and self.kind in GENERAL and not approximate:
            raise UsageError(
                f"a {self.kind} passes through up to five positions: "
                "--kind four-bar goes near more"
            )
        if self.within and self.kind in GENERAL and not approximate:
            raise UsageError(f"a {self.kind} meets its positions: leave out 'within'")
        if self.within and self.count < 4:
            raise UsageError("two and three positions are met exactly: leave out 'within'")
        if not 0.0 <= self.within <= FARTHEST:
            raise UsageError(f"within = {self.within:g}: give a distance up to {FARTHEST:g} m")
        pivots = [pivot for pivot in (self.fixed, self.moving) if pivot is not None]
        if not all(abs(x) <= FARTHEST for pivot in pivots for x in (pivot.real, pivot.imag)):
            raise UsageError(f"the pivot is not of finite numbers up to {FARTHEST:g} m")
        if self.kind != "pantograph" and self.masses is not None:
            raise UsageError("masses are for a pantograph: those of a four-bar follow")
        self._check_matter()
        nonlinear = self.kind == "pantograph" and self.ratio is None
        if self.window is not None:
            wanted = 2 if len(self.positions) == 2 else 4
            if not nonlinear or len(self.window) != wanted:
                raise UsageError(
                    "a window is for the nonlinear case: x from and to for two positions, and "
                    "y from and to for three"
                )
            pairs = zip(self.window[::2], self.window[1::2], strict=True)
            if not all(-FARTHEST <= low < high <= FARTHEST for low, high in pairs):
                raise UsageError(
                    f"a window goes from a number to a larger one, both up to {FARTHEST:g} m"
                )

    def _check_stack(self, chosen: int) -> None:
        """Refuse what a stack of three freedoms has no use for."""
        if chosen:
            raise UsageError(
                "a stack meets its positions wherever it stands: leave out the fixed and the "
                "moving pivot"
            )
        if self.within:
            raise UsageError("a stack meets its positions: leave out 'within'")

    def _check_timing(self) -> None:
        """Refuse angles through which no crank leads a point of a general four-bar."""
        if self.kind not in GENERAL:
            raise UsageError(
                f"timed positions are for the kinds {' and '.join(GENERAL)}: choose one of them"
            )
        _check_count(len(self.positions), "timed positions")
        _check_crank([each.angle for each in self.positions], "timed positions")

    def _check_function(self, chosen: int) -> None:
        """Refuse a function that no rocker of a general four-bar can follow."""
        if self.positions or self.timed or chosen:
            raise UsageError("a function has neither positions nor pivots: give either")
        if self.kind not in GENERAL:
            raise UsageError(
                f"a function is for the kinds {' and '.join(GENERAL)}: choose one of them"
            )
        _check_count(self.count, "points of a function")
        crank, rocker = np.array(self.function).T
        if not (np.abs(self.function) <= FARTHEST).all():
            raise UsageError(f"the angles of a function are finite numbers up to {FARTHEST:g}")
        _check_crank(crank.tolist(), "a function")
        if not SYNTHESIS_ANGLE_MET < np.ptp(rocker) < math.tau:
            raise UsageError("the rocker of a function turns, by less than a turn")
        if self.start is not None and self.count != FEWEST_TIMED:
            raise UsageError(
                f"start angles are for three points: they follow from {self.count} points"
            )
        if self.start is not None and not (np.abs(self.start) <= FARTHEST).all():
            raise UsageError(f"start angles are finite numbers up to {FARTHEST:g}")
        if self.base is not None and not NEAREST <= self.base <= FARTHEST:
            raise UsageError(
                f"base {self.base:g} m: give a length from {NEAREST:g} to {FARTHEST:g} m"
            )

    def _check_matter(self) -> None:
        """Refuse a density or a thickness that matter cannot have."""
        for name, value in (("density", self.density), ("thickness", self.thickness)):
            if value is not None and not 0.0 < value < float("inf"):
                raise UsageError(f"{name} {value:g}: give a positive number")
        if self.kind == "pantograph" and (self.thickness or self.density != STEEL):
            raise UsageError(
                "density and thickness are for four-bars and slider-cranks: the masses of a "
                "pantograph are given"
            )
        if self.thickness is not None and self.density is None:
            raise UsageError("a thickness is for matter with a density: points have none")


def _check_count(count: int, what: str) -> None:
    """Refuse too few or too many points."""
    if not FEWEST_TIMED <= count <= MOST:
        raise UsageError(f"{count} {what}: give {FEWEST_TIMED} to {MOST}")


def _check_crank(angles: list[float], what: str) -> None:
    """Refuse angles of a crank that it does not pass one after the other within a turn."""
    turns = [angle - angles[0] for angle in angles]
    if turns[-1] < 0.0:
        turns = [-turn for turn in turns]
    if not all(a < b < math.tau for a, b in pairwise(turns)):
        raise UsageError(
            f"the angles of {what} are those of the crank: they rise or fall from each to the "
            "next, by less than a turn in all"
        )
