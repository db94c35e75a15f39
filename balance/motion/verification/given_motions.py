"""Motions of a linkage from given poses or from a table of the inputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import (
    RATE_RESIDUAL_RELATIVE,
    RELATION_RESIDUAL,
    ROUNDING_NOTICE,
)
from balance.motion.verification.crank_revolution import revolve_crank
from balance.motion.verification.input_paths import SplinePath
from balance.motion.verification.table_rounding import (
    InputErrors,
    SmoothSpline,
    even_times,
    smooth_spline,
)
from balance.motion.verification.trajectory import Trajectory, drive, order_inputs
from balance.support.csv_columns import Table, read_table, refuse_row
from balance.support.csv_text import csv_table
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import PoseError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Linkage, Notice
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Fewest rows of a table: a spline of degree five needs six.
FEWEST_ROWS = 6
DEGREE = 5
# Samples of a table: the fewest, and those with which its spline shows the accelerations.
TABLE_SAMPLES = 401, 801, 1601, 3201, 6401
# Radians above which the numbers of a table may be degrees: eight turns.
MANY_RADIANS = 50.0

MotionLike: TypeAlias = "Trajectory | str | PathLike[str]"
"""A motion of a linkage, or the path of a table of one; see `from_csv`."""
Motions: TypeAlias = "MotionLike | Sequence[MotionLike]"
"""One or several motions."""


def read_motions(
    linkage: Linkage,
    motions: Motions | None,
    motion: Motion | None = None,
) -> list[Trajectory] | None:
    """List the motions that a function is asked about; None stays None.

    Args:
        motions: one or several.
        motion: relations that the inputs of tables must fulfil.

    Raises:
        FileError: a table cannot be used.
        PoseError: the loops cannot be closed along a motion.
    """
    if motions is None:
        return None
    listed = [motions] if isinstance(motions, Trajectory | str | PathLike) else motions
    return [
        each if isinstance(each, Trajectory) else from_csv(linkage, each, motion)
        for each in listed
    ]


def motions_or_turn(
    linkage: Linkage,
    motions: Motions | None,
    speed: float | str | None,
    crank: str | None,
    motion: Motion | None = None,
) -> Motions | None:
    """Return the motions that a function is asked about, or the turn of a crank.

    Args:
        motions: one or several; None for none.
        speed: of the crank, rad/s, or a text with a unit.
        crank: its name, as for `balance.motion.one_turn`.
        motion: restriction of the inputs.

    Raises:
        UsageError: there are motions and a speed, or a crank without a speed.
        PoseError: the crank cannot turn fully.
    """
    if speed is None:
        if crank is not None:
            raise UsageError(f"crank {crank} has no speed: give one, such as '300rpm'")
        return motions
    if motions is not None:
        raise UsageError("give either a speed or motions to move along")
    return revolve_crank(linkage, speed, crank, motion)[0]


def rest_to_rest(
    linkage: LinkageLike, poses: ArrayLike, duration: float = 1.0, samples: int = 200
) -> Trajectory:
    """Compute a motion that rests at given poses, on straight lines of the inputs.

    On each line ``s(τ) = 10 τ³ - 15 τ⁴ + 6 τ⁵``: velocity and acceleration vanish at both
    ends.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        poses: displacements of the inputs from the reference pose (poses, mobility), at least
            two, SI units.
        duration: duration of each line, seconds.
        samples: samples of the whole motion.

    Returns:
        The motion of all joints.

    Raises:
        PoseError: the poses have a wrong shape, or the loops cannot be closed along the motion.

    Source:
        K. M. Lynch, F. C. Park, Modern Robotics, 2017, section 9.2.2.2 (quintic time scaling).

    Example:
        >>> import balance
        >>> balance.motion.rest_to_rest("robot.urdf", [[0.0], [0.4]]).u[-1]
        array([0.4])
    """
    linkage = as_linkage(linkage)
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
    linkage: LinkageLike,
    path: str | PathLike[str],
    motion: Motion | None = None,
    *,
    short: Mapping[str, str] | None = None,
) -> Trajectory:
    """Read a motion from a table with a column ``time`` and one for each input by its name.

    A spline of degree five within the rounding of the numbers gives velocities and
    accelerations (`balance.motion.verification.table_rounding`), unless the table has them in
    columns named as by `rate_columns`. `Trajectory.errors` says how far they can be off.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        path: file of comma-separated values; displacements from the reference pose, SI units,
            or those of the heads of the columns: ``u1 [deg]``.
        motion: relations that the inputs must fulfil.
        short: other names of columns that the file may use, and the inputs for them.

    Returns:
        The motion of all joints.

    Raises:
        FileError: the file is no such table, nothing moves in it, or its decimals leave
            nothing of the accelerations.
        PoseError: the loops cannot be closed along the motion.

    Example:
        >>> import balance
        >>> rows = [f"{0.1 * k:.1f},{0.3 * (0.1 * k) ** 2:.6f}" for k in range(11)]
        >>> with open("motion.csv", "w") as file:
        ...     print("time,u1", *rows, sep=chr(10), file=file)
        >>> balance.motion.from_csv("robot.urdf", "motion.csv")
        Trajectory: 11 samples of 4 joints over 1 s
    """
    linkage = as_linkage(linkage)
    table = read_inputs(linkage, path, short)
    time = table.values[:, 0]
    groups = (table.values.shape[1] - 1) // linkage.mobility
    (u, *rates), (rounding, *rate_rounding) = (
        np.split(part[:, 1:], groups, axis=1) for part in (table.values, table.rounding)
    )
    if motion is not None:
        u, rounding = on_relations(linkage, motion, path, u, rounding)
    if np.ptp(u, axis=0).max() == 0.0:
        raise refuse_row(path, "", "nothing moves", "give inputs that change with time")
    even = even_times(time, table.rounding[:, 0])
    if even is None:
        speed = np.abs(np.gradient(u, time, axis=0))
        smooth = smooth_spline(time, u, rounding + speed * table.rounding[:, :1])
    else:
        time = even[0]
        smooth = smooth_spline(time, u, rounding)
    path_of_inputs = SplinePath(smooth.spline, tuple(np.unique(smooth.spline.t).tolist()))
    errors = smooth.errors
    if rates:
        _check_rates(path, time, smooth, rates, rate_rounding)
        errors = np.stack([rounding, *rate_rounding])
    motions = (u, *rates) if rates else path_of_inputs.at(time)
    if even is not None:
        errors = errors + even[1] * np.abs([0.0 * motions[0], motions[1], 2.0 * motions[2]])
    try:
        trajectory = drive(linkage, time, *motions)
    except PoseError as error:
        for notice in large_angles(linkage, u):
            error.add_note(notice.message)
        raise
    if not trajectory.moves:
        raise refuse_row(path, "", "nothing moves", "give inputs that change with time")
    _refuse_lost_motion(linkage, path, motions, errors)
    return replace(
        trajectory, path=path_of_inputs, errors=InputErrors(_decimals(table, u), *errors)
    )


def read_inputs(
    linkage: Linkage, path: str | PathLike[str], short: Mapping[str, str] | None = None
) -> Table:
    """Read a table of the inputs, as `from_csv` does: time, displacements, perhaps rates.

    Raises:
        FileError: the file is no such table.
    """
    further = rate_columns(linkage)
    table = read_table(path, ["time", *linkage.inputs], FEWEST_ROWS, short, further)
    _refuse_other_units(linkage, path, table)
    if not np.all(np.diff(table.values[:, 0]) > 0.0):
        raise refuse_row(path, "", "its times do not increase")
    return table


def large_angles(linkage: Linkage, u: Array) -> tuple[Notice, ...]:
    """Note inputs that turn so far that their numbers may be degrees.

    Args:
        u: displacements of the inputs (N, mobility), radians and metres.
    """
    kinds = {joint.name: joint.kind for joint in linkage.joints}
    far = {
        name: float(most)
        for name, most in zip(linkage.inputs, np.ptp(u, axis=0), strict=True)
        if kinds[name] == "revolute" and most > MANY_RADIANS
    }
    return tuple(
        Notice(
            "large_angles",
            (
                f"{name} moves over {number_text(most, '.3g')} rad, "
                f"{number_text(most / (2.0 * np.pi), '.2g')} turns: if these are degrees, "
                f"head its column '{name} [deg]'"
            ),
        )
        for name, most in far.items()
    )


def _refuse_other_units(linkage: Linkage, path: str | PathLike[str], table: Table) -> None:
    """Raise FileError for an angle of a joint that slides, or a length of one that turns."""
    kinds = {joint.name: joint.kind for joint in linkage.joints}
    names = [*linkage.inputs, *rate_columns(linkage)]
    for name, quantity in zip(names, table.quantities[1:], strict=False):
        rate, _, joint = name.rpartition(" ") if name not in kinds else ("", "", name)
        slides = kinds[joint] == "prismatic"
        wanted = "length" if slides else "angle"
        if rate:
            wanted = rate if slides else f"angular {rate}"
        if quantity not in ("", wanted):
            raise refuse_row(
                path,
                f"column '{name}'",
                f"has a unit of {quantity}",
                f"give one of {wanted}, or none for SI units",
            )


def on_relations(
    linkage: Linkage, motion: Motion, path: str | PathLike[str], u: Array, rounding: Array
) -> tuple[Array, Array]:
    """Return inputs that fulfil relations, which rounded ones do up to their rounding.

    Raises:
        FileError: the inputs do not fulfil the relations.
    """
    basis = np.linalg.qr(order_inputs(motion, linkage))[0]
    onto = basis @ basis.T
    off = np.abs(u - u @ onto)
    allowed = RELATION_RESIDUAL * max(1.0, np.abs(u).max())
    if np.any(off > allowed + rounding @ np.abs(np.eye(len(onto)) - onto)):
        raise refuse_row(path, "", f"its rows are not on {', '.join(motion.relations)}")
    if off.max() <= allowed:
        return u, rounding
    return u @ onto, rounding @ np.abs(onto)


def _check_rates(
    path: str | PathLike[str],
    time: Array,
    smooth: SmoothSpline,
    rates: list[Array],
    rounding: list[Array],
) -> None:
    """Raise FileError for velocities or accelerations that differ from those of a spline."""
    for order, given in enumerate(rates, 1):
        allowed = RATE_RESIDUAL_RELATIVE * (np.abs(given).max() or 1.0)
        allowed = allowed + smooth.errors[order] + rounding[order - 1]
        if np.any(np.abs(smooth.spline(time, order) - given) > allowed):
            problem = "its velocities or accelerations are not those of its displacements"
            raise refuse_row(path, "", problem, "write closer samples, or displacements only")


def _decimals(table: Table, u: Array) -> int:
    """Return the fewest decimals of the inputs that move."""
    moving = np.ptp(u, axis=0) > 0.0
    inputs = table.decimals[1 : 1 + u.shape[1]]
    return min(count for count, moves in zip(inputs, moving, strict=True) if moves)


def _refuse_lost_motion(
    linkage: Linkage, path: str | PathLike[str], motions: tuple[Array, ...], errors: Array
) -> None:
    """Raise FileError if rounding leaves nothing of the accelerations.

    A crank at constant speed has none, but its speed makes loads of the same kind, so its
    square counts too.
    """
    scale = input_chain(linkage).units[linkage.positions_of(linkage.inputs)]
    ud, udd = (np.abs(x / scale).max() for x in motions[1:])
    off = float((errors[2] / scale).max())
    if off >= ud**2 + udd:
        raise refuse_row(
            path,
            "",
            f"its decimals leave nothing of the accelerations: {number_text(float(udd), '.2g')}"
            f" ± {number_text(off, '.2g')} (radians, characteristic lengths, seconds)",
            "write more decimals, or columns of velocities and accelerations; to identify "
            "masses, give --cutoff",
        )


def rounding_notice(trajectory: Trajectory) -> tuple[Notice, ...]:
    """Say how far the accelerations of a rounded table can be off; nothing for exact motions.

    Args:
        trajectory: a motion.
    """
    if (errors := trajectory.errors) is None:
        return ()
    share = float((errors.udd / (np.abs(trajectory.udd).max(axis=0) + 1e-300)).max())
    if share <= ROUNDING_NOTICE:
        return ()
    text = (
        f"the {errors.decimals} decimals of the table leave accelerations off by up to "
        f"{number_text(100.0 * min(share, 1.0), '.2g')} % of their peak"
    )
    return (Notice("rounded_table", text),)


def rate_columns(linkage: Linkage) -> list[str]:
    """Name the columns of velocities and accelerations that a table of a motion may have.

    Returns:
        ``velocity u1`` for each input u1, then ``acceleration u1`` for each.
    """
    return [
        f"{rate} {name}" for rate in ("velocity", "acceleration") for name in linkage.inputs
    ]


def table_of_motion(linkage: Linkage, samples: Callable[[int], tuple[Array, ...]]) -> bytes:
    """Write a motion as a table that `from_csv` reads.

    Args:
        samples: computes time (N,), displacements, velocities and accelerations (N, mobility)
            at a number of even times.

    Returns:
        Comma-separated values: ``time`` and the inputs (displacements in rad and m); and their
        velocities and accelerations, unless these jump.
    """
    for count in TABLE_SAMPLES:
        motion = samples(count)
        if rates_off(*motion) <= 0.1 * RATE_RESIDUAL_RELATIVE:
            return csv_table(["time", *linkage.inputs, *rate_columns(linkage)], motion)
    return csv_table(["time", *linkage.inputs], motion[:2])


def rates_off(time: Array, u: Array, ud: Array, udd: Array) -> float:
    """Compare velocities and accelerations with those of the spline through displacements.

    Args:
        time: seconds (N,), rising.
        u: displacements (N, mobility).

    Returns:
        The largest difference, over the largest velocity, and over the largest acceleration.
    """
    from scipy.interpolate import make_interp_spline

    spline = make_interp_spline(time, u, k=DEGREE)
    return max(
        float(np.abs(spline(time, order) - given).max() / (np.abs(given).max() or 1.0))
        for order, given in ((1, ud), (2, udd))
    )
