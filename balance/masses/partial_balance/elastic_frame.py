"""Vibration of a linear elastic frame that carries a linkage.

The frame has mass m and moment of inertia I, and stands on springs and dampers that act alike
in all directions. They are spread like its mass, so that it turns about the middle of the
mechanism with stiffness ``k I/m`` and damping ``c I/m``. The shaking force F and moment M drive
it:

    m ẍ + c ẋ + k x = -F        I θ̈ + c (I/m) θ̇ + k (I/m) θ = -M

Both are one filter, of natural frequency √(k/m), of the wrench ``[m/I M; F]``. The frame is
taken to move so little that it does not change the shaking wrench.

Between samples the wrench is a cubic spline, for which the equation is solved exactly. A motion
whose end joins its start is repeated for ever, and the vibration is the periodic one. Any other
motion is made once, with the frame at rest before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.motion.verification.trajectory import Trajectory
from balance.support.tolerances import MOTION_JOINS
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array


class ElasticFrame(NamedTuple):
    """A frame on springs and dampers.

    Attributes:
        mass: kg.
        inertia: moment of inertia about any axis through the middle of the mechanism, kg m².
        stiffness: N/m.
        damping: N s/m.
    """

    mass: float
    inertia: float
    stiffness: float
    damping: float

    @property
    def frequency(self) -> float:
        """Natural frequency without damping, Hz."""
        return float(np.sqrt(self.stiffness / self.mass) / (2.0 * np.pi))

    def check(self) -> None:
        """Refuse a frame that cannot be.

        Raises:
            UsageError: a number is not finite, mass, inertia or stiffness is not positive, or
                the damping is negative.
        """
        if not (np.isfinite(self).all() and min(self[:3]) > 0.0 and self.damping >= 0.0):
            raise UsageError(
                f"no frame has mass {self.mass:g} kg, inertia {self.inertia:g} kg m², "
                f"stiffness {self.stiffness:g} N/m and damping {self.damping:g} N s/m: give "
                "three numbers above 0 and a damping from 0 up"
            )


def is_periodic(trajectory: Trajectory) -> bool:
    """Whether the end of a motion joins its start: positions up to full turns, and rates."""
    joined = True
    for x in (trajectory.q, trajectory.qd, trajectory.qdd):
        change = np.abs(x[-1] - x[0])
        if x is trajectory.q:
            turns = np.round(change / (2.0 * np.pi))
            change = np.abs(change - 2.0 * np.pi * turns)
        joined &= bool(np.all(change <= MOTION_JOINS * (np.abs(x).max(initial=0.0) or 1.0)))
    return joined


def vibration(frame: ElasticFrame, trajectory: Trajectory, wrenches: Array) -> Array:
    """Compute the vibration of a frame under shaking wrenches along a motion.

    Args:
        frame: the frame.
        wrenches: shaking moment about the middle of the mechanism and force (N, 6, columns),
            N m and N, of the base on the linkage.

    Returns:
        Rotation and displacement of the frame (N, 6, columns), radians and metres; linear in
        the wrenches.

    Raises:
        UsageError: a frame without damping is driven at a natural frequency for ever.
    """
    from scipy.interpolate import CubicSpline

    scale = np.array([frame.mass / frame.inertia] * 3 + [1.0] * 3)
    drive = -(wrenches * scale[:, None]).reshape(len(wrenches), -1)
    periodic = is_periodic(trajectory)
    if periodic:
        drive[-1] = drive[0]
    ends = "periodic" if periodic else "not-a-knot"
    spline = CubicSpline(trajectory.time, drive, bc_type=ends)
    # Coefficients of powers 0 … 3 of the time since the last sample.
    powers = spline.c[::-1].swapaxes(0, 1)
    response = _respond(frame, np.diff(trajectory.time), powers, periodic)
    return response.reshape(wrenches.shape)


def _respond(frame: ElasticFrame, steps: Array, powers: Array, periodic: bool) -> Array:
    """Solve ``m ẍ + c ẋ + k x = Σ_p powers[k, p] (t - t_k)^p`` for all columns at once.

    Args:
        frame: the frame.
        steps: times between samples (N - 1,).
        powers: coefficients (N - 1, 4, columns).
        periodic: whether the state at the end is that at the start; otherwise the frame is at
            rest at the start.

    Returns:
        Displacements x (N, columns).
    """
    transitions: dict[float, tuple[Array, Array]] = {}
    states = np.zeros((len(steps) + 1, 2, powers.shape[2]))
    whole = np.eye(2)
    for k, step in enumerate(steps.tolist()):
        key = float(f"{step:.12g}")
        if key not in transitions:
            transitions[key] = _transition(frame, step)
        free, driven = transitions[key]
        states[k + 1] = free @ states[k] + driven @ powers[k]
        whole = free @ whole
    if periodic:
        states += _periodic_part(frame, steps, transitions, whole, states[-1])
    return states[:, 0]


def _periodic_part(
    frame: ElasticFrame,
    steps: Array,
    transitions: dict[float, tuple[Array, Array]],
    whole: Array,
    end: Array,
) -> Array:
    """Compute the free vibration that makes a forced one periodic (N, 2, columns)."""
    if np.linalg.cond(np.eye(2) - whole) > 1.0 / MOTION_JOINS:
        raise UsageError(
            f"a frame without damping at {frame.frequency:g} Hz resonates with the motion: "
            "give it damping"
        )
    states = np.empty((len(steps) + 1, *end.shape))
    states[0] = np.linalg.solve(np.eye(2) - whole, end)
    for k, step in enumerate(steps.tolist()):
        states[k + 1] = transitions[float(f"{step:.12g}")][0] @ states[k]
    return states


def _transition(frame: ElasticFrame, step: float) -> tuple[Array, Array]:
    """Compute how the state ``[x, ẋ]`` after a step follows from that before and the drive.

    The drive ``Σ_p f_p t^p`` is part of the state: ``g_p = p! f_p`` and its own derivatives.

    Returns:
        Factors of the state (2, 2) and of the coefficients f (2, 4).
    """
    from scipy.linalg import expm

    A = np.zeros((6, 6))
    A[0, 1] = 1.0
    A[1, :3] = -frame.stiffness / frame.mass, -frame.damping / frame.mass, 1.0 / frame.mass
    A[[2, 3, 4], [3, 4, 5]] = 1.0
    whole = expm(A * step)
    return whole[:2, :2], whole[:2, 2:] * np.array([1.0, 1.0, 2.0, 6.0])
