"""Poses predicted by a Taylor motion, and where the loops close.

The prediction is the polynomial q(u); the corrected pose closes the loops, and is reached step
by step from the reference pose, whatever the order of the polynomial. Distances and errors are
in radians and characteristic lengths, errors those of the joint that is worst off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinematics.errors import PoseError, UnreachedError
from kinematics.model.arrays import IntArray, freeze
from kinematics.model.full_turns import unit_of_joint, wrap_turns
from kinematics.model.linkage import Notice
from kinematics.wording import count_noun, repr_lines, vector_text

if TYPE_CHECKING:
    from kinematics.model.linkage import Linkage
    from kinematics.taylor.taylor_motion import TaylorMotion

__all__ = ["Prediction", "Predictions", "assign_inputs", "input_values", "offset_of", "predict"]

Array = NDArray[np.float64]

SCHEMA = "balance.motion/1"
# How far displacements may be from the relations of a motion.
OFF = 1e-9
# Displacements beyond this, in SI units, are too far away to compute with.
FARTHEST = 1e9


@dataclass(frozen=True, eq=False)
class Prediction:
    """One pose.

    Attributes:
        u: displacements of the inputs from the reference pose (inputs,), SI units.
        y: the same in the coordinates of the motion (w,).
        distance: from the reference pose, to compare with the radius of convergence.
        error: estimated error of the prediction; None beyond the radius of convergence, where
            there is no estimate, and if the pose is not reached.
        predicted: positions of all joints by the series (n,), SI units; None if the pose is
            not reached, or the sum of the series is too large to be a number.
        corrected: positions that close the loops (n,), or None if the pose is not reached.
        difference: of the two, the true error; None without either.
        share: how much of the straight line to the pose was followed: 1 if it is reached.
        furthest: positions of all joints where that ended (n,), or None if it is reached.
        reason: why there is no corrected pose; empty if there is one.
    """

    u: Array
    y: Array
    distance: float
    error: float | None
    predicted: Array | None
    corrected: Array | None
    difference: float | None
    share: float
    furthest: Array | None = None
    reason: str = ""

    def __repr__(self) -> str:
        """One line: where, and whether it was reached."""
        if self.corrected is None:
            return f"Prediction at {vector_text(self.u)}: not reached"
        return f"Prediction at {vector_text(self.u)}: reached, true error {self.difference:.2g}"


def predict(motion: TaylorMotion, y: ArrayLike) -> Prediction:
    """The pose at a point y (w,) of a Taylor motion; `TaylorMotion.polish` corrects it.

    Raises:
        PoseError: the pose is too far away to compute with.
    """
    y = np.asarray(y, dtype=np.float64)
    u = motion.motion.basis @ y
    if not np.abs(u).max(initial=0.0) <= FARTHEST:
        raise PoseError(
            f"{motion.linkage.source}: the pose at {assign_inputs(motion, u)} is too far away "
            "to "
            "compute with; give a nearer pose"
        )
    where = freeze(u), freeze(y), float(motion.distance(y))
    try:
        corrected = freeze(motion.polish(y))
    except UnreachedError as stop:
        furthest = freeze(motion.positions(stop.positions))
        return Prediction(*where, None, None, None, None, stop.share, furthest, str(stop))
    predicted = freeze(motion.evaluate(y))
    if not np.isfinite(predicted).all():
        return Prediction(*where, None, None, corrected, None, 1.0)
    estimate, difference = (
        float(motion.error(y)),
        float(offset_of(motion, predicted, corrected)),
    )
    error = estimate if np.isfinite(estimate) else None
    return Prediction(*where, error, predicted, corrected, difference, 1.0)


def offset_of(motion: TaylorMotion, q: Array, other: Array) -> Array:
    """How far joint positions (..., n) are apart, at the joint that is worst off; (...)."""
    apart = (q - other)[..., motion.chain.joints] / motion.chain.units
    found: Array = np.abs(apart).max(axis=-1, initial=0.0)
    return found


def input_values(
    motion: TaylorMotion, rows: ArrayLike, named: ArrayLike
) -> tuple[Array, Array]:
    """Coordinates y (N, w) at which inputs have given displacements (N, named).

    Inputs that are not named move no more than the relations of the motion ask of them.

    Args:
        motion: the motion.
        rows: displacements from the reference pose, SI units.
        named: which inputs they are of, counted from 0.

    Returns:
        The coordinates, and whether the relations allow each row (N,).
    """
    rows = np.asarray(rows, dtype=np.float64)
    basis = motion.motion.basis[np.asarray(named)]
    y = np.linalg.lstsq(basis, rows.T, rcond=None)[0].T
    off = np.abs(y @ basis.T - rows).max(axis=1)
    return y, off <= OFF * np.maximum(1.0, np.abs(rows).max(axis=1))


def assign_inputs(motion: TaylorMotion, u: Array) -> str:
    """Inputs with their displacements."""
    pairs = zip(motion.motion.inputs, u, strict=True)
    return ", ".join(f"{name}={value:.6g}" for name, value in pairs)


@dataclass(frozen=True, eq=False)
class Predictions:
    """A Taylor motion and the poses that were asked of it.

    Attributes:
        motion: the Taylor motion.
        tool: the link whose displacements are the inputs, or None.
        line: whether the one pose is the end of a straight line, not part of a path.
        poses: the poses.
        notices: what there is to tell.
        point: the point of the tool that moves (3,), metres, in the frame of the link; None if
            it is the origin of that frame.
    """

    motion: TaylorMotion
    tool: str | None
    line: bool
    poses: tuple[Prediction, ...]
    notices: tuple[Notice, ...]
    point: tuple[float, ...] | None = None

    def __repr__(self) -> str:
        """Two lines: the motion, and how many poses it reaches."""
        reached = sum(pose.corrected is not None for pose in self.poses)
        return repr_lines(
            f"Predictions for {self.linkage.name}, order {self.motion.order}, radius of "
            f"convergence {self.motion.radius:.3g}",
            f"{count_noun(len(self.poses), 'pose')}, {reached} reached",
        )

    @property
    def linkage(self) -> Linkage:
        """The linkage, with the joints of the tool if there is one."""
        return self.motion.linkage

    @property
    def reached(self) -> bool:
        """Whether the loops close at all poses."""
        return all(pose.corrected is not None for pose in self.poses)

    @property
    def length(self) -> float:
        """Characteristic length in which shifts are measured, metres."""
        return self.motion.chain.frame.length

    @property
    def brief(self) -> str:
        """The answer in short, in words."""
        missed = sum(pose.corrected is None for pose in self.poses)
        radius = f"radius of convergence {self.motion.radius:.3g}"
        text = f"mobility {self.linkage.mobility}, {radius}"
        return f"{text}, {missed} of {len(self.poses)} poses not reached" if missed else text

    @property
    def dependent(self) -> tuple[str, ...]:
        """Names of the joints that follow."""
        chain = self.motion.chain
        return tuple(self.motion.joints[j] for j in chain.joints[chain.dependent])

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of the position of each joint, ``"rad"`` or ``"m"``."""
        return tuple(unit_of_joint(joint) for joint in self.linkage.joints)

    def to_dict(self) -> dict[str, object]:
        """The report as plain data, ready for JSON.

        ``balance/schemas/motion.schema.json`` describes it.
        """
        motion = self.motion
        joints = zip(motion.joints, self.units, strict=True)
        return {
            "schema": SCHEMA,
            "model": self.linkage.name,
            "at": self.linkage.at,
            "tool": self.tool,
            "point": None if self.point is None else list(self.point),
            "motion": list(motion.motion.relations),
            "independent": list(motion.motion.inputs),
            "dependent": list(self.dependent),
            "joints": [{"name": name, "unit": unit} for name, unit in joints],
            "order": motion.order,
            "condition": motion.condition,
            "radius": _finite(motion.radius),
            "length": self.length,
            "poses": [self._plain(pose) for pose in self.poses],
            "reached": self.reached,
            "warnings": [notice._asdict() for notice in self.notices],
        }

    def _plain(self, pose: Prediction) -> dict[str, object]:
        """One pose as plain data."""
        q = pose.corrected
        within, turns = (None, None) if q is None else wrap_turns(self.linkage.joints, q)
        return {
            "inputs": pose.u.tolist(),
            "distance": pose.distance,
            "error": pose.error,
            "predicted": _listed(pose.predicted),
            "corrected": _listed(q),
            "within_turn": _listed(within),
            "turns": _listed(turns),
            "difference": pose.difference,
            "share": pose.share,
            "furthest": _listed(pose.furthest),
            "reason": pose.reason or None,
        }


def _listed(values: Array | IntArray | None) -> list[float] | None:
    """The numbers for JSON."""
    return None if values is None else values.tolist()


def _finite(value: float) -> float | None:
    """The number for JSON, which knows no others."""
    return value if np.isfinite(value) else None
