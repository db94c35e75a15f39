"""What is asked of a synthesis, and whether it contradicts itself."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

from balance.masses.designs.density import STEEL
from balance.studies.synthesis.circle_points import MOST_POSITIONS
from balance.studies.synthesis.pantograph import PantographMasses
from balance.studies.synthesis.positions import FARTHEST, Position
from kinematics.errors import UsageError

# Kinds whose coupler is that of any four-bar.
GENERAL = ("geared-four-bar", "six-bar")
# Fewest positions at given angles of the crank.
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
        within: distance up to which four-bars may miss four or more positions, metres.
        density: density of the matter of four-bars at most, kg/m³; None for points.
        thickness: of plates that this matter is, metres; None to have it chosen.
        timed: whether the angles are those of the crank, and the tool turns as it may.
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

    def check(self) -> None:
        """Refuse a request that contradicts itself.

        Raises:
            UsageError: the number of pivots does not fit that of positions, or an option is for
                another kind.
        """
        chosen = (self.fixed is not None) + (self.moving is not None)
        if self.timed:
            self._check_timing()
        if self.kind == "stack":
            self._check_stack(chosen)
        elif len(self.positions) == 2 and chosen != 1:
            raise UsageError(
                "two positions leave one pivot free: choose the fixed or the moving one, by "
                "--fixed or --moving"
            )
        elif len(self.positions) > 2 and chosen:
            raise UsageError("three positions and more determine both pivots: choose none")
        if len(self.positions) > 3 and self.kind == "pantograph":
            raise UsageError(
                "a pantograph passes through two or three positions: --kind four-bar goes "
                "through four, and near more"
            )
        if len(self.positions) > MOST_POSITIONS and self.kind in GENERAL:
            raise UsageError(
                f"a {self.kind} passes through up to five positions: "
                "--kind four-bar goes near more"
            )
        if self.within and self.kind in GENERAL:
            raise UsageError(f"a {self.kind} meets its positions: leave out 'within'")
        if self.within and len(self.positions) < 4:
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
        if not FEWEST_TIMED <= len(self.positions) <= MOST_POSITIONS:
            raise UsageError(
                f"{len(self.positions)} timed positions: give {FEWEST_TIMED} to "
                f"{MOST_POSITIONS}"
            )
        turns = [each.angle - self.positions[0].angle for each in self.positions]
        if turns[-1] < 0.0:
            turns = [-turn for turn in turns]
        if not all(a < b < math.tau for a, b in pairwise(turns)):
            raise UsageError(
                "the angles of timed positions are those of the crank: they rise or fall from "
                "each to the next, by less than a turn in all"
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
