"""Poses predicted by a Taylor motion, and the corrected poses that close the loops.

The prediction is the polynomial q(u). The corrected pose closes the loops; continuation from
the reference pose reaches it, whatever the order of the polynomial. Distances and errors are
in radians and characteristic lengths. Errors are maxima over the joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import RELATION_RESIDUAL
from kinematics.errors import PoseError, UnreachedError
from kinematics.model.arrays import freeze
from kinematics.model.full_turns import unit_of_joint, wrap_turns
from kinematics.model.linkage import Notice
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.tolerances import POSE_DETERMINED
from kinematics.wording import count_noun, number_text, repr_lines, size_text, vector_text

if TYPE_CHECKING:
    from kinematics.closure.taylor.taylor_motion import TaylorMotion
    from kinematics.model.linkage import Linkage


SCHEMA = "balance.motion/1"
# Largest displacement of an input, SI units: sums of powers of larger ones overflow.
MAX_DISPLACEMENT = 1e9


@dataclass(frozen=True, eq=False)
class Prediction:
    """One predicted pose and its corrected pose.

    Attributes:
        u: displacements of the inputs from the reference pose (inputs,), SI units.
        y: the same in the coordinates of the motion (w,).
        distance: distance from the reference pose, comparable with the radius of convergence.
        error: estimated error of the prediction; None beyond the radius of convergence, and if
            the pose is not reached.
        predicted: positions of all joints by the series (n,), SI units; None if the pose is
            not reached, or the sum of the series is too large to be a number.
        corrected: positions that close the loops (n,), or None if the pose is not reached.
        difference: the true error, their largest difference; None without one of them.
        share: part of the straight line to the pose that was followed; 1 if it is reached.
        furthest: positions of all joints at the end of that part (n,), or None if the pose is
            reached.
        reason: reason why there is no corrected pose; empty if there is one.
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
        """One line: the displacements, and whether the pose was reached."""
        if self.corrected is None:
            return f"Prediction at {vector_text(self.u)}: not reached"
        error = size_text(self.difference or 0.0, ".2g", floor=POSE_DETERMINED)
        return f"Prediction at {vector_text(self.u)}: reached, true error {error}"


def predict(motion: TaylorMotion, y: ArrayLike) -> Prediction:
    """Predict a pose by a Taylor motion, and correct it so that the loops close.

    Args:
        y: coordinates of the motion at the pose (w,), SI units.

    Returns:
        The predicted and the corrected pose, from `TaylorMotion.evaluate` and `polish`.

    Raises:
        PoseError: the pose is too far away to compute with.
    """
    y = np.asarray(y, dtype=np.float64)
    u = motion.motion.basis @ y
    if not np.abs(u).max(initial=0.0) <= MAX_DISPLACEMENT:
        raise PoseError(
            f"{motion.linkage.source}: the pose at {assign_inputs(motion, u)} is too far away "
            "to compute with; give a nearer pose"
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
    """Compute the largest difference of joint positions over the joints.

    Args:
        q: positions of all joints (..., n), SI units.
        other: other positions (..., n).

    Returns:
        The largest difference (...), radians and characteristic lengths.
    """
    apart = (q - other)[..., motion.chain.joints] / motion.chain.units
    offset: Array = np.abs(apart).max(axis=-1, initial=0.0)
    return offset


def input_values(
    motion: TaylorMotion, rows: ArrayLike, named: ArrayLike
) -> tuple[Array, Array]:
    """Compute coordinates of a motion at which inputs have given displacements.

    The coordinates have minimum norm: other inputs move only as far as the relations require.

    Args:
        rows: displacements from the reference pose (N, named), SI units.
        named: indices of the displaced inputs (named,).

    Returns:
        The coordinates y (N, w), and whether the relations allow each row (N,).
    """
    rows = np.asarray(rows, dtype=np.float64)
    basis = motion.motion.basis[np.asarray(named)]
    y = np.linalg.lstsq(basis, rows.T, rcond=None)[0].T
    residual = np.abs(y @ basis.T - rows).max(axis=1)
    return y, residual <= RELATION_RESIDUAL * np.maximum(1.0, np.abs(rows).max(axis=1))


def assign_inputs(motion: TaylorMotion, u: Array) -> str:
    """Format displacements of the inputs: ``u1=0.3, u2=-0.1``.

    Args:
        u: displacements of its inputs (inputs,), SI units.
    """
    pairs = zip(motion.motion.inputs, u, strict=True)
    return ", ".join(f"{name}={number_text(value, '.6g')}" for name, value in pairs)


@dataclass(frozen=True, eq=False)
class Predictions:
    """A Taylor motion and the poses predicted by it.

    Attributes:
        motion: the Taylor motion.
        tool: the link whose displacements are the inputs, or None.
        line: whether there is one pose, at the end of a straight line, and no path.
        poses: the poses.
        notices: notices for the user.
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
            f"convergence {number_text(self.motion.radius, '.3g')}",
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
        """Characteristic length, the unit of sliding distances and errors, metres."""
        return self.motion.chain.frame.length

    @property
    def brief(self) -> str:
        """Summary in one line."""
        missed = sum(pose.corrected is None for pose in self.poses)
        radius = f"radius of convergence {number_text(self.motion.radius, '.3g')}"
        text = f"mobility {self.linkage.mobility}, {radius}"
        return f"{text}, {missed} of {len(self.poses)} poses not reached" if missed else text

    @property
    def dependent(self) -> tuple[str, ...]:
        """Names of the dependent joints."""
        chain = self.motion.chain
        return tuple(self.motion.joints[j] for j in chain.joints[chain.dependent])

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of the position of each joint, ``"rad"`` or ``"m"``."""
        return tuple(unit_of_joint(joint) for joint in self.linkage.joints)

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; see ``balance/app/schemas/motion.schema.json``."""
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
            "poses": [self._pose_data(pose) for pose in self.poses],
            "reached": self.reached,
            "warnings": [notice.to_dict() for notice in self.notices],
        }

    def _pose_data(self, pose: Prediction) -> dict[str, object]:
        """Return one pose as plain data."""
        q = pose.corrected
        within, turns = (None, None) if q is None else wrap_turns(self.linkage.joints, q)
        return {
            "inputs": pose.u.tolist(),
            "distance": pose.distance,
            "error": pose.error,
            "predicted": _as_list(pose.predicted),
            "corrected": _as_list(q),
            "within_turn": _as_list(within),
            "turns": _as_list(turns),
            "difference": pose.difference,
            "share": pose.share,
            "furthest": _as_list(pose.furthest),
            "reason": pose.reason or None,
        }


def _as_list(values: Array | IntArray | None) -> list[float] | None:
    """Return numbers for JSON; None stays None."""
    return None if values is None else values.tolist()


def _finite(value: float) -> float | None:
    """Return a finite number for JSON; None for others."""
    return value if np.isfinite(value) else None
