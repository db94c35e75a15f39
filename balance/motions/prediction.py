"""Poses predicted by a Taylor motion, and what Newton's method makes of them.

The prediction is the polynomial q(u); the corrected pose closes the loops. Distances and
errors are in radians and characteristic lengths, errors those of the joint that is worst off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinematics.errors import PoseError
from kinematics.linkage import Notice, frozen

if TYPE_CHECKING:
    from kinematics.linkage import Linkage
    from kinematics.taylor import TaylorMotion

__all__ = ["Predictions", "Prediction", "assigned", "coordinates", "offset", "predict"]

Array = NDArray[np.float64]

SCHEMA = "balance.motion/1"
# How far displacements may be from the relations of a motion.
OFF = 1e-9
# Predictions beyond this, in SI units, are too far away to compute with.
FARTHEST = 1e9


@dataclass(frozen=True, eq=False)
class Prediction:
    """One pose.

    Attributes:
        u: displacements of the inputs from the reference pose (inputs,), SI units.
        y: the same in the coordinates of the motion (w,).
        distance: from the reference pose, to compare with the radius of convergence.
        error: estimated error of the prediction.
        predicted: positions of all joints by the series (n,), SI units.
        corrected: positions that close the loops (n,), or None if none were found.
        difference: of the two, the true error; None without a corrected pose.
        reason: why there is no corrected pose; empty if there is one.
    """

    u: Array
    y: Array
    distance: float
    error: float
    predicted: Array
    corrected: Array | None
    difference: float | None
    reason: str

    def to_dict(self) -> dict[str, object]:
        """The pose as plain data, ready for JSON."""
        return {
            "inputs": self.u.tolist(),
            "distance": self.distance,
            "error": _finite(self.error),
            "predicted": self.predicted.tolist(),
            "corrected": None if self.corrected is None else self.corrected.tolist(),
            "difference": self.difference,
            "reason": self.reason or None,
        }


def predict(motion: TaylorMotion, y: ArrayLike) -> Prediction:
    """The pose at a point y (w,) of a Taylor motion; `TaylorMotion.polish` corrects it.

    Raises:
        PoseError: the pose is too far away to compute with. However far the prediction is
            beyond the radius of convergence, it is not if the linkage can be followed there.
    """
    y = np.asarray(y, dtype=np.float64)
    u = motion.motion.basis @ y
    with np.errstate(over="ignore", invalid="ignore"):
        predicted = motion.evaluate(y)
    too_far = PoseError(
        f"{motion.linkage.source}: the pose at {assigned(motion, u)} is too far away to "
        "compute with; give a nearer pose"
    )
    if not (np.isfinite(predicted).all() and np.abs(u).max() <= FARTHEST):
        raise too_far
    corrected, reason = None, ""
    try:
        corrected = motion.polish(y)
    except PoseError as problem:
        if np.abs(predicted).max() > FARTHEST:
            raise too_far from None
        reason = str(problem)
    difference = None if corrected is None else float(offset(motion, predicted, corrected))
    distance, error = float(motion.distance(y)), float(motion.error(y))
    return Prediction(
        frozen(u), frozen(y), distance, error, frozen(predicted),
        None if corrected is None else frozen(corrected), difference, reason,
    )  # fmt: skip


def offset(motion: TaylorMotion, q: Array, other: Array) -> Array:
    """How far joint positions (..., n) are apart, at the joint that is worst off; (...)."""
    apart = (q - other)[..., motion.chain.joints] / motion.chain.units
    found: Array = np.abs(apart).max(axis=-1, initial=0.0)
    return found


def coordinates(motion: TaylorMotion, rows: ArrayLike, named: ArrayLike) -> tuple[Array, Array]:
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


def assigned(motion: TaylorMotion, u: Array) -> str:
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
    """

    motion: TaylorMotion
    tool: str | None
    line: bool
    poses: tuple[Prediction, ...]
    notices: tuple[Notice, ...]

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
        kinds = (joint.kind for joint in self.linkage.joints)
        return tuple("m" if kind == "prismatic" else "rad" for kind in kinds)

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
            "motion": list(motion.motion.relations),
            "independent": list(motion.motion.inputs),
            "dependent": list(self.dependent),
            "joints": [{"name": name, "unit": unit} for name, unit in joints],
            "order": motion.order,
            "condition": motion.condition,
            "radius": _finite(motion.radius),
            "length": self.length,
            "poses": [pose.to_dict() for pose in self.poses],
            "reached": self.reached,
            "warnings": [notice._asdict() for notice in self.notices],
        }


def _finite(value: float) -> float | None:
    """The number for JSON, which knows no others."""
    return value if np.isfinite(value) else None
