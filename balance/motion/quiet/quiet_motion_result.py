"""Results of plans: the motion that shakes least, beside the laws that it replaces."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from balance.motion.motion_tolerances import (
    BOUND_REACHED,
    SHAKING_RELATIVE,
)
from balance.motion.quiet.limits import InputLimits, LimitExceeded
from balance.motion.quiet.objective import QuietObjective, overall
from balance.motion.verification.given_motions import table_of_motion
from balance.motion.verification.input_paths import (
    InputPath,
    input_path_data,
    sample_input_path,
)
from balance.motion.verification.shaking_wrench import move_wrenches
from balance.motion.verification.trajectory import Trajectory, drive
from balance.support.options import GRAVITY
from balance.support.result_files import WithPage, WithPicture
from kinematics.model.linkage import Linkage, Notice
from kinematics.numerics.array_types import Array
from kinematics.wording import html_facts, number_text, repr_lines, size_text

SCHEMA = "balance.quiet/1"


class MotionFigures(NamedTuple):
    """What a motion shakes, and what it asks of the inputs.

    Attributes:
        value: size of the shaking that is minimised, N or N m.
        force_rms: root mean square of the shaking force, N.
        force_peak: its peak, N.
        moment_rms: that of the moment about the point, N m.
        moment_peak: its peak, N m.
        velocity: peak by input (inputs,), rad/s or m/s.
        acceleration: likewise.
        torque: likewise, with gravity, N m or N.
    """

    value: float
    force_rms: float
    force_peak: float
    moment_rms: float
    moment_peak: float
    velocity: Array
    acceleration: Array
    torque: Array

    @classmethod
    def of(
        cls,
        objective: QuietObjective,
        time: Array,
        inputs: tuple[Array, Array, Array],
        loads: Array,
    ) -> MotionFigures:
        """Compute the figures.

        Args:
            time: samples (N,).
            inputs: positions, velocities, accelerations (N, inputs).
            loads: ``[wrench; torque]`` (N, 6 + inputs) about the inertial origin.
        """
        wrench = move_wrenches(loads[:, :6], objective.point)
        force, moment = (
            np.linalg.norm(wrench[:, part], axis=1) for part in (slice(3, 6), slice(0, 3))
        )
        return cls(
            objective.value(time, loads[:, :6]),
            overall("rms", time, force),
            overall("peak", time, force),
            overall("rms", time, moment),
            overall("peak", time, moment),
            *(np.abs(x).max(axis=0) for x in (inputs[1], inputs[2], loads[:, 6:])),
        )

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        pairs = self._asdict().items()
        return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in pairs}


class ComparedLaw(NamedTuple):
    """A law on the straight lines between the poses, or on the given path, for comparison.

    Attributes:
        name: ``"quintic"`` or ``"trapezoidal"``.
        figures: what it shakes; None if its loops cannot be closed.
        exceeded: the limit that it exceeds most, or None.
        path: the motion of the inputs.
    """

    name: str
    figures: MotionFigures | None
    exceeded: LimitExceeded | None
    path: InputPath

    @property
    def within(self) -> bool:
        """Whether the law can be run within the limits."""
        return self.figures is not None and self.exceeded is None


class PassedPoint(NamedTuple):
    """A pose that a motion passes on its way, or at an end that a tool leaves free.

    Attributes:
        time: seconds.
        u: displacements of the inputs there (inputs,).
        tool: the coordinates of the tool that are asked for, in words; empty if the inputs
            are.
    """

    time: float
    u: Array
    tool: str

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {"time": self.time, "inputs": self.u.tolist(), "tool": self.tool or None}


@dataclass(frozen=True, eq=False)
class QuietMotion(WithPage, WithPicture):
    """Result of `quiet_motion` and `quiet_timing`.

    Attributes:
        linkage: the linkage.
        objective: what is minimised.
        limits: of the inputs.
        duration: seconds.
        start: displacements of the inputs at the start (inputs,).
        end: at the end; of a cycle, again those at the start.
        frequencies: of the base, Hz, that are not excited.
        convex: whether a convex program found a motion within the limits, so that no other
            timing shakes less.
        path: the motion of the inputs.
        law: ``"planned"``, or the name of the law that shakes less.
        after: what the motion shakes.
        laws: the laws that it is compared with.
        bound: no motion from rest to rest between the poses shakes less; None if none is known.
        exceeded: the limit that no motion was found to keep, or None.
        inertia_force: size of the inertia forces, N and N m; a small part is round-off.
        shortest: the shortest duration of the path within the limits, seconds, if computed.
        front: durations, and the size of the least shaking in each.
        notices: remarks for the user.
        passed: poses that are passed on the way, in order; all poses of a cycle.
        harmonics: of a cycle; None if the motion is from rest to rest.
        gravity: acceleration (3,), m/s², for torques alone.
    """

    page_maker = "quiet_page:quiet_page"
    picture_maker = "quiet:quiet_picture"

    linkage: Linkage
    objective: QuietObjective
    limits: InputLimits
    duration: float
    start: Array
    end: Array
    frequencies: tuple[float, ...]
    convex: bool
    path: InputPath
    law: str
    after: MotionFigures
    laws: tuple[ComparedLaw, ...]
    bound: float | None
    exceeded: LimitExceeded | None
    inertia_force: float
    shortest: float | None = None
    front: tuple[tuple[float, float], ...] = ()
    notices: tuple[Notice, ...] = ()
    passed: tuple[PassedPoint, ...] = ()
    harmonics: int | None = None
    gravity: tuple[float, ...] = GRAVITY

    def __repr__(self) -> str:
        """Two lines: the linkage, and the verdict."""
        return repr_lines(self._title, self.words)

    def _repr_html_(self) -> str:
        """Table of the same facts, and of the shaking, for notebooks."""
        rows = [("verdict", self.words)]
        if self.exceeded is None:
            for part, unit in (("force", "N"), ("moment", "N m")):
                peak, rms = (
                    f"{self.size_text(getattr(self.after, f'{part}_{kind}'))} {unit}"
                    for kind in ("peak", "rms")
                )
                rows.append((f"shaking {part}", f"peak {peak}, rms {rms}"))
        return html_facts(self._title, *rows)

    @property
    def _title(self) -> str:
        """What it is, in words."""
        return f"QuietMotion of {self.linkage.name} in {number_text(self.duration)} s"

    @property
    def feasible(self) -> bool:
        """Whether a motion within the limits was found."""
        return self.exceeded is None

    @property
    def quintic(self) -> MotionFigures | None:
        """What the quintic law shakes."""
        return next((law.figures for law in self.laws if law.name == "quintic"), None)

    @property
    def trapezoidal(self) -> MotionFigures | None:
        """What the law of trapezoidal speed shakes."""
        return next((law.figures for law in self.laws if law.name == "trapezoidal"), None)

    @property
    def verdict(self) -> str:
        """``"optimal"``, ``"locally optimal"``, ``"feasible"`` or ``"infeasible"``.

        It is feasible where a law takes the place of a plan.
        """
        if not self.feasible:
            return "infeasible"
        if self.balanced or self.at_bound or self.convex:
            return "optimal"
        return "locally optimal" if self.law == "planned" else "feasible"

    @property
    def balanced(self) -> bool:
        """Whether the motion does not shake the base but for round-off."""
        return self.is_round_off(self.after.value)

    def is_round_off(self, size: float) -> bool:
        """Whether a size of shaking is round-off beside the inertia forces."""
        return size <= SHAKING_RELATIVE * self.inertia_force

    @property
    def at_bound(self) -> bool:
        """Whether the motion shakes as little as the bound, up to its discretisation."""
        return self.bound is not None and self.after.value <= (1.0 + BOUND_REACHED) * self.bound

    @property
    def words(self) -> str:
        """The verdict, in words."""
        if self.exceeded is not None:
            words = f"infeasible: {self.exceeded.words}"
            if self.shortest is None:
                return words
            return f"{words}; the path takes at least {number_text(self.shortest)} s"
        if self.balanced:
            size = self.size_text(self.after.value)
            return f"optimal: {size} {self.objective.unit}, round-off"
        value = f"{number_text(self.after.value)} {self.objective.unit}"
        if self.convex:
            return f"optimal: no other timing of this path shakes less than {value}"
        if self.bound is None:
            reason = " for the moment" if self.objective.part == "moment" else ""
            return f"{self.verdict}: {value}; no bound is known{reason}"
        if self.at_bound:
            near = number_text(100.0 * BOUND_REACHED, ".0f")
            return (
                f"optimal: {value}, within {near} % of the bound "
                f"{number_text(self.bound)} {self.objective.unit}"
            )
        return (
            f"{self.verdict}: {value}; no motion shakes less than "
            f"{number_text(self.bound)} {self.objective.unit}"
        )

    def size_text(self, size: float) -> str:
        """Write a size of shaking, or a bound where it is round-off."""
        if self.is_round_off(size):
            return size_text(size, ".4g", self.inertia_force, SHAKING_RELATIVE)
        return number_text(size)

    def samples(self, count: int) -> tuple[Array, ...]:
        """Compute time, inputs, velocities and accelerations at even times.

        Args:
            count: number of samples.
        """
        return sample_input_path(self.path, self.duration, count)

    def trajectory(self, count: int = 201) -> Trajectory:
        """Compute the motion of all joints.

        Args:
            count: number of samples.
        """
        return drive(self.linkage, *self.samples(count))

    def table(self) -> bytes:
        """Write the motion as a table that ``balance verify --csv`` reads.

        Returns:
            Comma-separated values: ``time`` and the inputs (displacements in rad and m); and
            their velocities and accelerations, unless these jump.
        """
        return table_of_motion(self.linkage, self.samples)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON; see ``balance/app/schemas/quiet.schema.json``."""
        return {
            "schema": SCHEMA,
            "model": self.linkage.name,
            "at": self.linkage.at,
            "inputs": list(self.linkage.inputs),
            "duration": self.duration,
            "from": self.start.tolist(),
            "to": self.end.tolist(),
            "passed": [point.to_dict() for point in self.passed],
            "harmonics": self.harmonics,
            "minimised": {
                "part": self.objective.part,
                "measure": self.objective.measure,
                "about": self.objective.point.tolist(),
                "weight_moment": self.objective.length,
            },
            "frequencies": list(self.frequencies),
            "limits": _limits_data(self.limits),
            "verdict": self.verdict,
            "words": self.words,
            "law": self.law,
            "bound": self.bound,
            "after": self.after.to_dict(),
            "laws": [
                {
                    "name": law.name,
                    "figures": None if law.figures is None else law.figures.to_dict(),
                    "exceeded": None if law.exceeded is None else law.exceeded._asdict(),
                }
                for law in self.laws
            ],
            "exceeded": None if self.exceeded is None else self.exceeded._asdict(),
            "shortest": self.shortest,
            "front": [{"duration": at, "value": value} for at, value in self.front],
            "motion": input_path_data(*self.samples(101)),
            "warnings": [notice.to_dict() for notice in self.notices],
        }


def _limits_data(limits: InputLimits) -> dict[str, object]:
    """Return limits as plain data; null where there is none."""

    def plain(values: Array) -> list[float | None]:
        return [value if isfinite(value) else None for value in values.tolist()]

    return {
        "lower": plain(limits.lower[0]),
        "upper": plain(limits.upper[0]),
        "velocity": plain(limits.upper[1]),
        "acceleration": plain(limits.upper[2]),
        "jerk": plain(limits.upper[3]),
        "torque": plain(limits.upper[4]),
    }
