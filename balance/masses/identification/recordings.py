"""Recordings of a linkage: motions, the loads measured with each, and what explains these.

Loads of one channel in several recordings are those of one sensor or drive: friction and rotor
of the drive are the same in all of them. The offset is another in each, since sensors drift,
and are set to zero between recordings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations
from os import PathLike
from typing import NamedTuple, TypeAlias

import numpy as np

from balance.masses.identification.least_squares import ChannelRows
from balance.masses.identification.load_rows import LoadRows, load_rows
from balance.masses.identification.low_pass import LowPass, filter_measurements
from balance.masses.identification.measurements import (
    WRENCH,
    LoadTable,
    Measurements,
    motion_at,
    read_measurements,
)
from balance.motion.verification.given_motions import MotionLike, Motions, from_csv
from balance.motion.verification.trajectory import Trajectory
from kinematics.errors import LinkageError, UsageError
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun

LoadTables: TypeAlias = "LoadTable | Sequence[LoadTable]"
"""One table of measured loads, or one for each motion."""

# Most numbers of the regressor of all loads.
MOST_NUMBERS = 30_000_000


class Recorded(NamedTuple):
    """A motion at the times of its loads, and these; before `LowPass.apply`, if it is filtered.

    Attributes:
        trajectory: the motion.
        measured: the loads.
        band: the filter; None for none.
    """

    trajectory: Trajectory
    measured: Measurements
    band: LowPass | None


class DriveTerms(NamedTuple):
    """What drives with a measured torque add to it.

    Attributes:
        friction: whether each has viscous and dry friction.
        rotors: whether each has a rotor.
    """

    friction: bool
    rotors: bool


class RecordedRows(NamedTuple):
    """A recording, and the rows that give its loads from parameters.

    Attributes:
        trajectory: the motion at the times of the loads.
        measured: the loads.
        rows: of wrench and torques.
        drives: what friction and rotors exert for unit parameters (N,), by channel and name.
    """

    trajectory: Trajectory
    measured: Measurements
    rows: LoadRows
    drives: Mapping[str, Mapping[str, Array]]

    def rows_of(self, linkage: Linkage, name: str) -> Array:
        """Select the rows of a channel (N, parameters)."""
        if name in WRENCH:
            return self.rows.wrench[:, WRENCH.index(name)]
        return self.rows.drives[:, linkage.inputs.index(name)]


class Channel(NamedTuple):
    """A channel in all recordings that have it.

    Attributes:
        name: of the load.
        terms: names of the parameters of its sensor and drive, as columns of `data.sensor`.
        data: loads and rows.
    """

    name: str
    terms: tuple[str, ...]
    data: ChannelRows


def read_recordings(
    linkage: Linkage,
    motions: Motions,
    loads: LoadTables,
    on_linkage: bool,
    cutoff: float | None,
) -> list[Recorded]:
    """Read motions and the loads that were measured with them.

    Args:
        motions: one or several.
        loads: a table for each.
        on_linkage: whether wrenches are those of the base on the linkage.
        cutoff: frequency below which motions and loads are filtered, Hz; None for none.

    Raises:
        FileError: a table cannot be read.
        UsageError: there is not one table of loads for each motion, or one cannot be used.
        PoseError: the loops cannot be closed along a motion.
    """
    listed = [motions] if isinstance(motions, Trajectory | str | PathLike) else list(motions)
    tables = [loads] if isinstance(loads, str | PathLike | Mapping) else list(loads)
    if not listed or len(listed) != len(tables):
        raise UsageError(
            f"loads: give one table for each motion, not {count_noun(len(tables), 'table')} "
            f"for {count_noun(len(listed), 'motion')}"
        )
    recordings = []
    for k, (motion, table) in enumerate(zip(listed, tables, strict=True), 1):
        try:
            recordings.append(_read_recording(linkage, motion, table, on_linkage, cutoff))
        except LinkageError as error:
            if len(listed) > 1:
                error.add_note(f"in recording {k} of {len(listed)}")
            raise
    _refuse_repeated([recording.measured for recording in recordings])
    samples = sum(len(recording.measured.time) for recording in recordings)
    most = MOST_NUMBERS // (60 * len(linkage.bodies))
    if samples > most:
        raise UsageError(
            f"loads: {samples} samples of so many links would fill the memory: leave out all "
            f"but {most}"
        )
    return recordings


def _read_recording(
    linkage: Linkage,
    motion: MotionLike,
    loads: LoadTable,
    on_linkage: bool,
    cutoff: float | None,
) -> Recorded:
    """Read one recording; see `read_recordings`."""
    measured = read_measurements(linkage, loads, on_linkage)
    if not measured.values.any():
        raise UsageError("loads: all numbers are 0, so that nothing was measured")
    band: LowPass | None = None
    if cutoff is None:
        given = motion if isinstance(motion, Trajectory) else from_csv(linkage, motion)
        trajectory = motion_at(linkage, given, measured.time)
    else:
        trajectory, measured, band = filter_measurements(linkage, motion, measured, cutoff)
    if not trajectory.moves:
        raise UsageError("motion: nothing moves; give inputs that change with time")
    return Recorded(trajectory, measured, band)


def _refuse_repeated(measured: Sequence[Measurements]) -> None:
    """Refuse loads that are given twice, which would count as new ones."""
    for (k, one), (j, other) in combinations(enumerate(measured, 1), 2):
        if one.channels == other.channels and np.array_equal(one.values, other.values):
            raise UsageError(
                f"recordings {k} and {j} have the same loads: leave out one, which tells "
                "nothing more"
            )


def explain_recording(
    linkage: Linkage, recorded: Recorded, drives: DriveTerms, gravity: Array, about: Array
) -> RecordedRows:
    """Compute the rows of the loads of a recording, filtered as these are.

    Args:
        drives: what drives add to the loads.
        gravity: acceleration of gravity (3,), m/s².
        about: point of the moments (3,), metres.
    """
    trajectory, measured, band = recorded
    rows = load_rows(linkage, trajectory, gravity, about)
    terms = {
        name: _drive_columns(linkage, trajectory, name, drives) for name in measured.drives
    }
    if band is not None:
        rows = LoadRows(*map(band.apply, rows))
        terms = {
            name: {term: band.apply(column) for term, column in columns.items()}
            for name, columns in terms.items()
        }
        trajectory = band.choose(linkage, trajectory)
        values = band.apply(measured.values)
        measured = measured._replace(time=trajectory.time, values=values)
    return RecordedRows(trajectory, measured, rows, terms)


def _drive_columns(
    linkage: Linkage, trajectory: Trajectory, name: str, drives: DriveTerms
) -> dict[str, Array]:
    """Compute what friction and rotor of a drive exert, by name of their parameter (N,)."""
    k = linkage.inputs.index(name)
    rate, change = trajectory.ud[:, k], trajectory.udd[:, k]
    columns = {}
    if drives.friction and np.abs(rate).max() > 0.0:
        columns = {f"viscous {name}": rate, f"dry {name}": np.sign(rate)}
    if drives.rotors and np.abs(change).max() > 0.0:
        columns[f"rotor {name}"] = change
    return columns


def stack_channels(
    linkage: Linkage, recordings: Sequence[RecordedRows], offset: bool
) -> list[Channel]:
    """Stack the loads of each channel over the recordings that have it.

    Args:
        offset: whether each channel has an unknown constant in each recording.

    Returns:
        The channels, those of the wrench first.
    """
    measured = {name for recording in recordings for name in recording.measured.channels}
    return [
        _stack_channel(linkage, recordings, name, offset)
        for name in (*WRENCH, *linkage.inputs)
        if name in measured
    ]


def _stack_channel(
    linkage: Linkage, recordings: Sequence[RecordedRows], name: str, offset: bool
) -> Channel:
    """Stack the loads of one channel; see `stack_channels`."""
    having = [k for k, x in enumerate(recordings) if name in x.measured.channels]
    parts = [recordings[k] for k in having]
    counts = [len(part.measured.time) for part in parts]
    recording = np.repeat(having, counts)
    columns: dict[str, Array] = {}
    if offset:
        for k in having:
            told = f"offset {name}" + (f", recording {k + 1}" if len(recordings) > 1 else "")
            columns[told] = (recording == k).astype(np.float64)
    drives = [part.drives.get(name, {}) for part in parts]
    for term in dict.fromkeys(term for part in drives for term in part):
        columns[term] = np.concatenate(
            [part.get(term, np.zeros(n)) for part, n in zip(drives, counts, strict=True)]
        )
    measured = [(part.measured, part.measured.channels.index(name)) for part in parts]
    loads = [table.values[:, c] for table, c in measured]
    rounding = [table.rounding[c] for table, c in measured]
    data = ChannelRows(
        np.concatenate([part.rows_of(linkage, name) for part in parts]),
        np.concatenate(loads),
        np.column_stack([np.empty((len(recording), 0)), *columns.values()]),
        recording,
        np.repeat(rounding, counts),
    )
    return Channel(name, tuple(columns), data)
