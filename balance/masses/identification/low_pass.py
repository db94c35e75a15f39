"""Noisy measurements below a frequency: a filter without delay, the same for both sides.

A machine moves slowly, and its noise is fast. Positions are filtered below four times the
cutoff, then give velocities and accelerations. Measured loads and the regressor of these
positions are filtered alike below the cutoff: a linear filter leaves ``y = Y x``. Of the
filtered rows, two for each period of the cutoff are kept, since those between tell nothing new,
and their noise is then white. The filter is that of Butterworth of fourth order, forward and
backward.

(M. Gautier, Dynamic identification of robots with power model, IEEE International Conference on
Robotics and Automation, 1997: parallel filtering and decimation; W. Khalil, E. Dombre,
Modeling, Identification and Control of Robots, 2002, section 12.5.)
"""

from __future__ import annotations

from dataclasses import replace
from os import PathLike
from typing import NamedTuple

import numpy as np

from balance.masses.identification.measurements import Measurements, refuse_times_outside
from balance.motion.verification.given_motions import read_inputs
from balance.motion.verification.input_paths import SplinePath
from balance.motion.verification.trajectory import Trajectory, drive
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

ORDER = 4
# Positions keep this many times the frequencies of the loads.
WIDER = 4.0
# Samples for each period of the cutoff: the fewest of a table, those of the regressor, and
# those that are kept.
FEWEST, DENSE, KEPT = 10.0, 20, 2
# Periods of the cutoff at either end in which a filter knows only one side.
ENDS = 3.0


class LowPass(NamedTuple):
    """A filter of rows on an even grid of times.

    Attributes:
        cutoff: Hz.
        time: grid (N,), seconds.
        kept: the rows that are kept, n of N.
    """

    cutoff: float
    time: Array
    kept: slice

    def apply(self, rows: Array) -> Array:
        """Filter rows (N, …) along the grid, and keep some of them (n, …)."""
        return freeze(low_pass(self.time, rows, self.cutoff)[self.kept].copy())

    def choose(self, linkage: Linkage, trajectory: Trajectory) -> Trajectory:
        """Return the motion at the times of the rows that are kept."""
        at = (trajectory.time, trajectory.u, trajectory.ud, trajectory.udd)
        return replace(drive(linkage, *(x[self.kept] for x in at)), path=trajectory.path)


def low_pass(time: Array, values: Array, cutoff: float) -> Array:
    """Filter values (N, …) at even times (N,) below a frequency in Hz, without delay."""
    from scipy.signal import butter, sosfiltfilt

    rate = (len(time) - 1) / (time[-1] - time[0])
    sections = butter(ORDER, cutoff, fs=rate, output="sos")
    padding = min(len(time) - 1, int(np.ceil(2.0 * rate / cutoff)))
    return np.asarray(sosfiltfilt(sections, values, axis=0, padlen=padding))


def filter_measurements(
    linkage: Linkage,
    motion: Trajectory | str | PathLike[str],
    measured: Measurements,
    cutoff: float,
) -> tuple[Trajectory, Measurements, LowPass]:
    """Filter a motion, and prepare the loads for the same filter as their regressor.

    Args:
        linkage: the linkage that was measured.
        motion: the measured motion, or the path of its table.
        measured: loads.
        cutoff: Hz.

    Returns:
        Motion and loads on the grid, before `LowPass.apply`; and the filter.

    Raises:
        FileError: the table of the motion cannot be read.
        UsageError: tables have too few samples for this frequency, or are too short; or the
            loads are not those of the motion.
        PoseError: the loops cannot be closed.
    """
    if not (np.isfinite(cutoff) and cutoff > 0.0):
        raise UsageError(f"cutoff: {cutoff:g} is not above 0")
    if isinstance(motion, Trajectory):
        given, u = motion.time, motion.u
    else:
        table = read_inputs(linkage, motion).values
        given, u = table[:, 0], table[:, 1 : 1 + linkage.mobility]
    refuse_times_outside(given, measured.time)
    time = measured.time
    count = int(np.ceil(DENSE * cutoff * (time[-1] - time[0]))) + 1
    grid = np.linspace(time[0], time[-1], count)
    step = DENSE // KEPT
    ends = int(np.ceil(ENDS * DENSE))
    if count < 2 * ends + step:
        least = number_text((2.0 * ENDS + 1.0 / KEPT) / cutoff)
        raise UsageError(f"cutoff: {cutoff:g} Hz needs a measurement of {least} s or more")
    path = SplinePath.through(*_even("motion", given, u, cutoff))
    loads = SplinePath.through(*_even("loads", time, measured.values, cutoff)).at(grid)[0]
    trajectory = drive(linkage, grid, *path.at(grid))
    kept = slice(ends, count - ends, step)
    return (
        replace(trajectory, path=path),
        measured._replace(time=freeze(grid), values=freeze(loads)),
        LowPass(cutoff, grid, kept),
    )


def _even(name: str, time: Array, values: Array, cutoff: float) -> tuple[Array, Array]:
    """Return even times, and values there below a multiple of the cutoff.

    Raises:
        UsageError: there are too few samples for the cutoff.
    """
    rate = (len(time) - 1) / float(time[-1] - time[0])
    if rate < FEWEST * cutoff:
        raise UsageError(
            f"cutoff: {cutoff:g} Hz needs {number_text(FEWEST * cutoff)} samples a second, and "
            f"the {name} have {number_text(rate, '.3g')}: give a lower one"
        )
    from scipy.interpolate import make_interp_spline

    even = np.linspace(time[0], time[-1], len(time))
    return even, low_pass(even, make_interp_spline(time, values, k=3)(even), WIDER * cutoff)
