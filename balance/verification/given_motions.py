"""Motions of a linkage from given poses or from a table of the inputs."""

from __future__ import annotations

from dataclasses import replace
from os import PathLike

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.tolerances import RELATION_RESIDUAL
from balance.verification.csv_motion import read_columns, refuse_row
from balance.verification.input_paths import SplinePath
from balance.verification.trajectory import Trajectory, drive, order_inputs
from kinematics.errors import PoseError
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion

__all__ = ["from_csv", "rest_to_rest"]

Array = NDArray[np.float64]

# Fewest rows of a table: a spline of degree five needs six.
FEWEST_ROWS = 6


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

    The spline of degree five through the rows gives velocities and accelerations.

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
    table = read_columns(path, ["time", *linkage.inputs], FEWEST_ROWS)
    time, u = table[:, 0], table[:, 1:]
    if not np.all(np.diff(time) > 0.0):
        raise refuse_row(path, "", "its times do not increase")
    if motion is not None:
        basis = np.linalg.qr(order_inputs(motion, linkage))[0]
        if np.abs(u - u @ basis @ basis.T).max() > RELATION_RESIDUAL * max(
            1.0, np.abs(u).max()
        ):
            raise refuse_row(path, "", f"its rows are not on {', '.join(motion.relations)}")
    spline = SplinePath.through(time, u)
    trajectory = drive(linkage, time, u, *spline.at(time)[1:])
    if trajectory.moves:
        return replace(trajectory, path=spline)
    raise refuse_row(path, "", "nothing moves", "give inputs that change with time")
