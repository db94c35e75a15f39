"""Measured loads over time: the wrench at the base, and the torques of the drives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.verification.input_paths import SplinePath
from balance.motion.verification.table_rounding import InputErrors
from balance.motion.verification.trajectory import Trajectory, drive
from balance.support.csv_columns import read_table, refuse_row
from kinematics.error_text import clean
from kinematics.errors import FileError, UsageError
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Components of the wrench, forces first, and their names in tables of `balance.verify`.
FORCES, MOMENTS = ("fx", "fy", "fz"), ("mx", "my", "mz")
WRENCH = FORCES + MOMENTS
LONG_NAMES = {
    f"{part}_{axis}": f"{part[0]}{axis}" for part in ("force", "moment") for axis in "xyz"
}
# Fewest samples: a fit of fewer says nothing about the noise.
FEWEST_SAMPLES = 12
# Part of the duration by which the loads may begin before the motion, or end after it.
TIME_BEYOND = 1e-9

LoadTable = str | PathLike[str] | Mapping[str, ArrayLike]
"""A table of measured loads: its file, or its columns by name."""


class Measurements(NamedTuple):
    """Measured loads, SI units.

    Attributes:
        time: seconds (N,).
        channels: names of the columns: some of `WRENCH`, then inputs whose torques were
            measured.
        values: loads (N, channels), N and N m: of the base on the linkage.
        rounding: bounds on their errors, since the table is rounded (channels,).
    """

    time: Array
    channels: tuple[str, ...]
    values: Array
    rounding: Array

    @property
    def wrench(self) -> tuple[int, ...]:
        """Components of the wrench that were measured, as indices in `WRENCH`."""
        return tuple(WRENCH.index(name) for name in self.channels if name in WRENCH)

    @property
    def drives(self) -> tuple[str, ...]:
        """Inputs whose torques were measured."""
        return tuple(name for name in self.channels if name not in WRENCH)


def read_measurements(linkage: Linkage, source: LoadTable, on_linkage: bool) -> Measurements:
    """Read measured loads.

    Args:
        linkage: the linkage that was measured.
        source: a table with a column ``time``, and some of ``fx``, …, ``mz`` and of the inputs,
            for the torques of their drives.
        on_linkage: whether the wrench is that of the base on the linkage, instead of that of
            the linkage on its base.

    Raises:
        FileError: the file is no such table.
        UsageError: columns are no such table.
    """
    units = _quantities(linkage)
    if isinstance(source, Mapping):
        time, channels, values = _columns(source, list(units))
        rounding = np.finfo(np.float64).eps * np.abs(values).max(axis=0)
    else:
        table = read_table(source, ["time"], FEWEST_SAMPLES, LONG_NAMES, some=units)
        time, values, channels = table.values[:, 0], table.values[:, 1:], table.names[1:]
        rounding = table.rounding[:, 1:].max(axis=0)
        if not np.all(np.diff(time) > 0.0):
            raise refuse_row(source, "", "its times do not increase")
    if not on_linkage:
        values = values * np.array([-1.0 if name in WRENCH else 1.0 for name in channels])
    return Measurements(freeze(time), channels, freeze(values), freeze(rounding))


def require_bodies(linkage: Linkage) -> None:
    """Raise FileError for a linkage of which no link has inertial parameters."""
    if not linkage.bodies:
        problem, remedy = "no moving link has a mass", "give the links that move an <inertial>"
        raise FileError(clean(linkage.source, 1000), "", problem, remedy)


def _quantities(linkage: Linkage) -> dict[str, tuple[str, ...]]:
    """Return the quantities of the units of all columns that a table may have."""
    drives = {
        name: ("force",) if name in linkage.sliding else ("torque",) for name in linkage.inputs
    }
    return {
        **dict.fromkeys(FORCES, ("force",)),
        **dict.fromkeys(MOMENTS, ("torque",)),
        **drives,
    }


def _columns(
    columns: Mapping[str, ArrayLike], known: Sequence[str]
) -> tuple[Array, tuple[str, ...], Array]:
    """Return time, names of channels and values of columns by name.

    Raises:
        UsageError: columns are missing, unknown, of different lengths or not finite.
    """
    given = {
        LONG_NAMES.get(name, name): np.asarray(column, np.float64)
        for name, column in columns.items()
    }
    channels = tuple(name for name in known if name in given)
    if not channels or set(given) != {"time", *channels}:
        raise UsageError(f"loads: give the columns time and some of {', '.join(known)}")
    time = given["time"]
    if any(column.shape != time.shape or column.ndim != 1 for column in given.values()):
        raise UsageError("loads: all columns must have one number for each time")
    values = np.column_stack([given[name] for name in channels])
    if not (np.isfinite(values).all() and np.isfinite(time).all()):
        raise UsageError("loads: all numbers must be finite")
    if time.size < FEWEST_SAMPLES or not np.all(np.diff(time) > 0.0):
        raise UsageError(f"loads: give {FEWEST_SAMPLES} or more times that increase")
    return time, channels, values


def motion_at(linkage: Linkage, motion: Trajectory, time: Array) -> Trajectory:
    """Compute a motion at the times of measured loads.

    Args:
        linkage: the linkage that moves.
        motion: the motion, sampled at times of its own.
        time: times of the loads (N,), seconds.

    Returns:
        The motion at these times; itself, if its times are the same.

    Raises:
        UsageError: the loads begin before the motion, or end after it.
        PoseError: the loops cannot be closed.
    """
    beyond = TIME_BEYOND * motion.duration
    if motion.time.size == time.size and np.abs(motion.time - time).max() <= beyond:
        return motion
    refuse_times_outside(motion.time, time)
    path = motion.path or SplinePath.through(motion.time, motion.u)
    moved = drive(linkage, time, *path.at(time))
    if motion.errors is None:
        return replace(moved, path=path)
    kinds = (motion.errors.u, motion.errors.ud, motion.errors.udd)
    errors = (
        np.column_stack([np.interp(time, motion.time, column) for column in bound.T])
        for bound in kinds
    )
    return replace(moved, path=path, errors=InputErrors(motion.errors.decimals, *errors))


def refuse_times_outside(motion: Array, time: Array) -> None:
    """Raise UsageError for loads that begin before the motion, or end after it.

    Args:
        motion: times of the motion (N,), seconds.
        time: times of the loads (n,), seconds.
    """
    first, last = float(motion[0]), float(motion[-1])
    beyond = TIME_BEYOND * (last - first)
    if time[0] < first - beyond or time[-1] > last + beyond:
        ends = (number_text(float(x)) for x in (time[0], time[-1], first, last))
        raise UsageError(
            "loads: they are from {} to {} s, and the motion is known from {} to {} s: "
            "leave out the others".format(*ends)
        )
