"""Results of a synthesis: mechanisms through positions, and what confirms them."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from balance.motion.motion_tolerances import SYNTHESIS_ANGLE_MET
from balance.studies.synthesis.confirm import Confirmation
from balance.studies.synthesis.constrained_motion import Defect, MotionTable
from balance.studies.synthesis.construction import Construction
from balance.studies.synthesis.couplings import Coupling
from balance.studies.synthesis.error_map import AngleErrorMap
from balance.studies.synthesis.four_bars import FOUR_BARS
from balance.studies.synthesis.function_four_bars import FunctionPoint
from balance.studies.synthesis.positions import Position
from balance.studies.synthesis.three_positions import CrossingMap
from balance.support.result_files import WithPage, WithPicture, write_file
from kinematics.errors import UsageError
from kinematics.wording import count_noun, html_facts, number_text, repr_lines

SYNTHESIS_SCHEMA = "balance.synthesize/1"


@dataclass(frozen=True, eq=False)
class SynthesizedMechanism:
    """A balanced mechanism whose tool passes through positions.

    Attributes:
        kind: ``"pantograph"``, ``"kite"``, ``"antiparallelogram"``, ``"slider-crank"``,
            ``"geared four-bar"``, ``"six-bar"`` or ``"stack"``.
        pivots: by name, at the first position; metres, inertial frame, complex.
        link_turns: turn of the first link, or of the crank, from the first position to each,
            radians.
        tool_turns: of the tool, or of the rocker of a function.
        position_error: largest distance of the tool from its positions, metres.
        angle_error: largest difference of its angle from theirs, or of that of the rocker from
            the function, radians.
        meets: whether it meets the positions, or is as near as was asked.
        path: of the tool (N,), metres, complex.
        outlines: lines along the links at each position, with the tool, metres, complex.
        defects: branch, order and reversal defects of the motion.
        urdf: the file.
        coupling: what couples both links of a pantograph: a belt, which is in the file, or a
            slot, which no URDF file can have; None for the others, whose gears are in the file.
        table: motion of its inputs, in the nonlinear case and of a stack.
        confirmation: what the core says of the file.
        numbers: lengths, masses and reduced inertias by name, SI units.
        first_position: displacements of the inputs from the pose of the file to position 1 by
            name, radians; empty if that is the pose of the file.
        input_turns: of several inputs that are free: the turn of each from the first position
            to each position, by name, radians; empty if there is one.
        positions: of the tool that were asked for, if the coupler or the rocker carries it;
            empty for the others.
    """

    kind: str
    pivots: dict[str, complex]
    link_turns: tuple[float, ...]
    tool_turns: tuple[float, ...]
    position_error: float
    angle_error: float
    meets: bool
    path: NDArray[np.complex128]
    outlines: tuple[tuple[complex, ...], ...]
    defects: tuple[Defect, ...]
    urdf: bytes
    coupling: Coupling | None
    table: MotionTable | None
    confirmation: Confirmation
    numbers: dict[str, float] = field(default_factory=dict)
    first_position: dict[str, float] = field(default_factory=dict)
    input_turns: dict[str, tuple[float, ...]] = field(default_factory=dict)
    positions: tuple[Position, ...] = ()

    def to_urdf(self, path: str | PathLike[str] | None = None) -> bytes:
        """Return the file of the mechanism with its masses.

        Args:
            path: file to write it to; None for none.

        Raises:
            FileError: it cannot be written.
        """
        return write_file(path, self.urdf)

    @property
    def good(self) -> bool:
        """Whether it is confirmed, without defects, and meets the positions."""
        return self.confirmation.confirmed and self.meets and not self.defects

    def __repr__(self) -> str:
        """Two lines: the mechanism, and what the core says."""
        words = "; ".join(defect.words for defect in self.defects) or "no defects"
        state = "confirmed" if self.confirmation.confirmed else self.confirmation.reason
        return repr_lines(f"SynthesizedMechanism: {self.kind}, {words}", state)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "kind": self.kind,
            "pivots": {name: [z.real, z.imag] for name, z in self.pivots.items()},
            "link_turns": list(self.link_turns),
            "tool_turns": list(self.tool_turns),
            "position_error": self.position_error,
            "angle_error": self.angle_error,
            "meets": self.meets,
            "defects": [defect._asdict() for defect in self.defects],
            "coupling": self.coupling.to_dict() if self.coupling else None,
            "confirmation": self.confirmation._asdict(),
            "numbers": self.numbers,
            "first_position": self.first_position,
            "input_turns": {name: list(turns) for name, turns in self.input_turns.items()},
            "urdf": self.urdf.decode(),
        }


@dataclass(frozen=True, eq=False)
class Synthesis(WithPage, WithPicture):
    """Result of `synthesize`.

    Attributes:
        positions: of the tool; of a function, those of the tip of the rocker of the best
            mechanism.
        kind: that was asked for, see `synthesize`.
        ratio: k of the linear case; None otherwise.
        mechanisms: the best ones first.
        count: how many were found; the best are in ``mechanisms``.
        remarks: what was changed of the given masses, and where was searched.
        map: of the nonlinear case.
        construction: drawing of the linear case for two positions.
        within: distance up to which positions count as met, metres, or error of the rocker of a
            function, radians; 0 if they are met exactly.
        density: density of the matter of four-bars at most, kg/m³; None without a limit.
        thickness: of the plates that were asked for, metres.
        timed: whether the angles of the positions are those of the crank.
        function: angles of crank and rocker, instead of positions; empty for none.
    """

    page_maker = "synthesis:synthesis_page"
    picture_maker = "synthesis:synthesis_picture"

    positions: tuple[Position, ...]
    kind: str
    ratio: float | None
    mechanisms: tuple[SynthesizedMechanism, ...]
    count: int
    remarks: tuple[str, ...] = ()
    map: AngleErrorMap | CrossingMap | None = None
    construction: Construction | None = None
    within: float = 0.0
    density: float | None = None
    thickness: float | None = None
    timed: bool = False
    function: tuple[FunctionPoint, ...] = ()

    @property
    def case(self) -> str:
        """``"linear"`` or ``"nonlinear"`` for a pantograph, else the kind."""
        if self.kind != "pantograph":
            return self.kind
        return "nonlinear" if self.ratio is None else "linear"

    @property
    def verdict(self) -> str:
        """``"feasible"`` if a mechanism is confirmed and has no defects."""
        if any(mechanism.good for mechanism in self.mechanisms):
            return "feasible"
        unsure = any(
            not (mechanism.defects or mechanism.confirmation.confirmed) and mechanism.meets
            for mechanism in self.mechanisms
        )
        unsure = unsure or (not self.mechanisms and (self.count > 0 or self._sampled))
        return "undecided" if unsure or self._near else "infeasible"

    @property
    def _sampled(self) -> bool:
        """Whether there may be others than were tried: stacks, and turns of a free tool."""
        return self.kind == "stack" or self.timed or bool(self.function)

    @property
    def _near(self) -> bool:
        """Whether the best one is near, and others that were not tried may meet all."""
        return self._sampled and bool(self.mechanisms) and not self.mechanisms[0].meets

    @property
    def words(self) -> str:
        """The verdict in words."""
        if not self.mechanisms and self.count:
            return f"undecided: {self._without_matter()}"
        if not self.mechanisms and self._sampled:
            return f"undecided: {self._none_tried}"
        if not self.mechanisms:
            return "infeasible: no such mechanism passes through the positions"
        first = self.mechanisms[0]
        defects = "; ".join(defect.words for defect in first.defects)
        sentences = {
            "feasible": f"{count_noun(self.count, 'mechanism')} {self._through}",
            "undecided": self._nearest()
            if self._near
            else f"not confirmed: {first.confirmation.reason}",
            "infeasible": defects if first.meets else self._nearest(),
        }
        return f"{self.verdict}: {sentences[self.verdict]}"

    @property
    def _through(self) -> str:
        """Say where mechanisms pass."""
        if self.function:
            follows = "nearly follows" if self.within else "follows"
            return f"whose rocker {follows} the function"
        return f"{'near' if self.within else 'through'} the positions"

    @property
    def _none_tried(self) -> str:
        """Say that none of those that were tried will do."""
        tried = "stacks" if self.kind == "stack" else "four-bars"
        reaches = "follows the function" if self.function else "reaches all positions"
        return f"none of the {tried} that were tried {reaches}"

    def _without_matter(self) -> str:
        """Say that mechanisms pass through the positions, and have no masses."""
        matter = (
            "masses" if self.density is None else f"matter of at most {self.density:g} kg/m³"
        )
        thick = "" if self.thickness is None else f" in plates {self.thickness:g} m thick"
        return (
            f"{count_noun(self.count, 'mechanism')} {self._through}, but no "
            f"{matter}{thick} balances those that were tried: allow denser or thicker matter"
        )

    def _nearest(self) -> str:
        """Say by how much the nearest mechanism misses the positions."""
        nearest = min(self.mechanisms, key=lambda mechanism: mechanism.position_error)
        names = " or ".join(FOUR_BARS) if self.kind == "four-bar" else self.kind
        who = self._none_tried if self._sampled else f"no {names} meets all positions"
        angle = f"{number_text(math.degrees(nearest.angle_error))}°"
        miss = f"{number_text(1e3 * nearest.position_error)} mm"
        if self.function:
            miss = angle
        elif nearest.angle_error > SYNTHESIS_ANGLE_MET:
            miss += f" and {angle}"
        limit = "an angle" if self.function else "a distance"
        return (
            f"{who}; the nearest misses by up to {miss}: more is accepted within {limit} that "
            "is given"
        )

    def __repr__(self) -> str:
        """Up to five lines: the positions and the best mechanisms."""
        return repr_lines(
            f"Synthesis of a {self.kind} "
            + (
                f"for {len(self.function)} points of a function"
                if self.function
                else f"through {len(self.positions)} positions"
            ),
            f"  {self.words}",
            *(
                f"  {mechanism.kind} on {_point(z)}"
                for mechanism in self.mechanisms[:3]
                for z in list(mechanism.pivots.values())[:1]
            ),
        )

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        rows = (
            (mechanism.kind, repr(mechanism).partition("\n")[2])
            for mechanism in self.mechanisms
        )
        return html_facts(f"Synthesis: {self.words}", *rows)

    def to_urdf(self, path: str | PathLike[str] | None = None) -> bytes:
        """Return the file of the best mechanism; `SynthesizedMechanism.to_urdf` has the others.

        Args:
            path: file to write it to; None for none.

        Raises:
            UsageError: there is no mechanism.
            FileError: the file cannot be written.
        """
        if not self.mechanisms:
            raise UsageError(f"no file: {self.words}")
        return self.mechanisms[0].to_urdf(path)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``schemas/synthesize.schema.json``."""
        return {
            "schema": SYNTHESIS_SCHEMA,
            "positions": [each._asdict() for each in self.positions],
            "kind": self.kind,
            "case": self.case,
            "ratio": self.ratio,
            "verdict": self.verdict,
            "words": self.words,
            "remarks": list(self.remarks),
            "within": self.within,
            "density": self.density,
            "thickness": self.thickness,
            "timed": self.timed,
            "function": [each._asdict() for each in self.function],
            "count": self.count,
            "mechanisms": [mechanism.to_dict() for mechanism in self.mechanisms],
            "contour": _contour(self.map),
        }


def _point(z: complex) -> str:
    """Write a point."""
    return f"({number_text(z.real)}, {number_text(z.imag)}) m"


def _contour(pivot_map: AngleErrorMap | CrossingMap | None) -> list[dict[str, float]]:
    """List the designs on the zero contour of a map over a pivot line."""
    if not isinstance(pivot_map, AngleErrorMap):
        return []
    points = pivot_map.contour.points
    fixed, moving = pivot_map.line.pivots(points[:, 0])
    return [
        {
            "offset": tau,
            "inertia_ratio": ratio,
            "fixed_x": G.real,
            "fixed_y": G.imag,
            "moving_x": W.real,
            "moving_y": W.imag,
            "error": error,
        }
        for (tau, ratio), G, W, error in zip(
            points.tolist(),
            fixed.tolist(),
            moving.tolist(),
            pivot_map.contour.residuals.tolist(),
            strict=True,
        )
    ]
