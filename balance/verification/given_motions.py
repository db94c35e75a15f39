"""Motions of a linkage from given poses or from a table of the inputs."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.motion_tolerances import RATE_RESIDUAL_RELATIVE, RELATION_RESIDUAL
from balance.verification.csv_motion import read_columns, refuse_row
from balance.verification.input_paths import SplinePath
from balance.verification.trajectory import Trajectory, drive, order_inputs
from kinematics.errors import PoseError
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion

__all__ = ["from_csv", "rate_columns", "rates_off", "rest_to_rest"]

Array = NDArray[np.float64]

# Fewest rows of a table: a spline of degree five needs six.
FEWEST_ROWS = 6
DEGREE = 5


def rest_to_rest(
    linkage: Linkage, poses: ArrayLike, duration: float = 1.0, samples: int = 200
) -> Trajectory:
    """Compute a motion that rests at given poses, on straight lines of the inputs.

    On each line ``s(τ) = 10 τ³ - 15 τ⁴ + 6 τ⁵``: velocity and acceleration vanish at both
    ends.

    Args:
        linkage: an assembled linkage.
        poses: displacements of the inputs from the reference pose (poses, mobility), at least
            two, SI units.
        duration: duration of each line, seconds.
        samples: samples of the whole motion.

    Returns:
        The motion of all joints.

    Raises:
        PoseError: the poses have a wrong shape, or the loops cannot be closed along the motion.
    """
    stops = np.asarray(poses, dtype=np.float64)
    if stops.ndim != 2 or len(stops) < 2 or stops.shape[1] != linkage.mobility:
        raise PoseError(
            f"{linkage.source}: give two or more poses of {linkage.mobility} inputs "
            f"({', '.join(linkage.inputs)})"
        )
    tau = np.linspace(0.0, len(stops) - 1.0, samples)
    leg = np.minimum(tau.astype(np.int64), len(stops) - 2)
    x = (tau - leg)[:, None]
    line = np.diff(stops, axis=0)[leg]
    u = stops[leg] + line * (x**3 * (10.0 - 15.0 * x + 6.0 * x * x))
    ud = line * (30.0 * x * x * (1.0 - x) ** 2) / duration
    udd = line * (60.0 * x * (1.0 - x) * (1.0 - 2.0 * x)) / duration**2
    return drive(linkage, duration * tau, u, ud, udd)


def from_csv(
    linkage: Linkage, path: str | PathLike[str], motion: Motion | None = None
) -> Trajectory:
    """Read a motion from a table with a column ``time`` and one for each input by its name.

    The spline of degree five through the rows gives velocities and accelerations, unless the
    table has them in columns named as by `rate_columns`. Differences of displacements with 16
    digits are right to about 1e-9 only; columns are, if those agree with them.

    Args:
        linkage: an assembled linkage.
        path: file of comma-separated values; displacements from the reference pose, SI.
        motion: relations that the inputs must fulfil.

    Returns:
        The motion of all joints.

    Raises:
        FileError: the file is no such table, or nothing moves in it.
        PoseError: the loops cannot be closed along the motion.
    """
    further = rate_columns(linkage)
    table = read_columns(path, ["time", *linkage.inputs], FEWEST_ROWS, further=further)
    time, groups = table[:, 0], (table.shape[1] - 1) // linkage.mobility
    u, *rates = np.split(table[:, 1:], groups, axis=1)
    if not np.all(np.diff(time) > 0.0):
        raise refuse_row(path, "", "its times do not increase")
    if motion is not None:
        basis = np.linalg.qr(order_inputs(motion, linkage))[0]
        if np.abs(u - u @ basis @ basis.T).max() > RELATION_RESIDUAL * max(
            1.0, np.abs(u).max()
        ):
            raise refuse_row(path, "", f"its rows are not on {', '.join(motion.relations)}")
    if rates and rates_off(time, u, *rates) > RATE_RESIDUAL_RELATIVE:
        problem = "its velocities or accelerations are not those of its displacements"
        raise refuse_row(path, "", problem, "write closer samples, or displacements only")
    spline = SplinePath.through(time, u)
    trajectory = drive(linkage, time, u, *(rates or spline.at(time)[1:]))
    if trajectory.moves:
        return replace(trajectory, path=spline)
    raise refuse_row(path, "", "nothing moves", "give inputs that change with time")


def rate_columns(linkage: Linkage) -> list[str]:
    """Name the columns of velocities and accelerations that a table of a motion may have.

    Args:
        linkage: an assembled linkage.

    Returns:
        ``velocity u1`` for each input u1, then ``acceleration u1`` for each.
    """
    return [
        f"{rate} {name}" for rate in ("velocity", "acceleration") for name in linkage.inputs
    ]


def rates_off(time: Array, u: Array, ud: Array, udd: Array) -> float:
    """Compare velocities and accelerations with those of the spline through displacements.

    Args:
        time: seconds (N,), rising.
        u: displacements (N, mobility).
        ud: velocities.
        udd: accelerations.

    Returns:
        The largest difference, over the largest velocity, and over the largest acceleration.
    """
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(time, u, k=DEGREE)
    return max(
        float(np.abs(spline(time, order) - given).max() / (np.abs(given).max() or 1.0))
        for order, given in ((1, ud), (2, udd))
    )
