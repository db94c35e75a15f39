"""One wheel on the base that takes the angular momentum: passive, or with a motor of its own.

Counterweights balance the force first; the moment is then the same about every point. A
wheel about the normal of a planar linkage, of inertia J, takes it at the speed ``-h / J``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from balance.masses.remedies.applied import AppliedRemedy, refused
from balance.masses.remedies.balancers.crank_sweep import (
    crank_joint,
    crank_rates,
    refuse_several_freedoms,
    sweep_crank,
)
from balance.masses.remedies.balancers.on_base import (
    NO_MOMENT,
    SEED,
    Balancer,
    BalancerDrive,
    ForceBalanced,
    NoBalancer,
    Wheel,
    balance_force,
    build_or_refuse,
    fine_motion,
    has_momentum,
    make_wheel,
    motion_columns,
    random_force_balanced_motions,
    refuse_other_moments,
    verify_with_balancers,
    with_input_inertia,
)
from balance.masses.remedies.balancers.varying_ratio import (
    CsvFiles,
    PitchCurves,
    VaryingRatio,
    integrate,
)
from balance.masses.remedies.momentum_along import (
    Momentum,
    MovedMasses,
    momentum_along,
    move_masses,
)
from balance.masses.remedies.request import MOTIONS, POSES, RemedyRequest
from balance.motion.motion_tolerances import CONDITIONING_NOTICE, RELATION_RESIDUAL
from balance.motion.verification.trajectory import (
    Trajectory,
    drive,
    random_motions,
)
from kinematics.model.linkage import GROUND, Linkage
from kinematics.model.motion import motion_of
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

# Steps between the rows of tables in the details; the files have all rows.
STRIDE = 10


def apply_passive_wheel(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a planar linkage of one freedom by a wheel that its crank drives.

    The wheel's ratio to the crank varies: ``i(u) = -h(u) / J`` with the angular momentum h for
    a unit rate of the crank.

    Yields:
        One result.
    """
    yield _wheel_remedy("passive_wheel", request, _build_geared_wheel)


def apply_active_wheel(request: RemedyRequest) -> Iterator[AppliedRemedy]:
    """Balance a linkage by a wheel with a motor of its own, or by three if it is spatial.

    Speed ``-h / J``, torque ``-ḣ`` and power ``h ḣ / J``.

    Yields:
        One result.
    """
    yield _wheel_remedy("active_wheel", request, _build_motor_wheels)


def _wheel_remedy(
    remedy: str, request: RemedyRequest, build: Callable[[RemedyRequest], AppliedRemedy]
) -> AppliedRemedy:
    """Build wheels, or say why there are none."""
    if request.balance == "force":
        return refused(remedy, "a wheel takes a moment, and only the force is to be balanced")
    return build_or_refuse(remedy, build, request)


def _build_motor_wheels(request: RemedyRequest) -> AppliedRemedy:
    """Build a wheel with a motor for each axis along which a moment is left.

    The force is balanced by counterweights. The axes are the normal of a planar linkage, and
    where its centres of mass are in different planes two across it; or those of the root. The
    speed is ``-h / J``, the torque ``-ḣ``, the power ``h ḣ / J`` along random motions of one
    second. J is the mean of ``|h|`` over the mean speed of the fastest input (radians and
    characteristic lengths per second) and over the gear of the request; the torque does not
    depend on it. Each wheel is a thin ring of the rotor radius ρ, of mass ``J / ρ²``.

    Returns:
        The result; a file has time, inputs, and the wheels' motion at the greatest power, and
        one a motion with the wheels for ``balance verify --csv``.

    Raises:
        NoBalancer: the force cannot be balanced, or no moment is left.
        LinkageError: the linkage cannot be moved.
    """
    balanced = balance_force(request)
    runs = random_force_balanced_motions(request)
    wheels = _wheels(request, balanced, runs)
    mass = number_text(sum(wheel.mass for wheel in wheels))
    built = f"a wheel of {mass} kg"
    if len(wheels) > 1:
        built = f"{len(wheels)} wheels about perpendicular axes, {mass} kg together,"
    blank = AppliedRemedy(
        "active_wheel",
        f"{built} on the base, with motors",
        "undecided",
        "",
    )
    done = with_motors(request, blank, balanced, wheels, [*runs, fine_motion(request)])
    return replace(
        done, details={"wheels": [wheel.details() for wheel in wheels], **done.details}
    )


def with_motors(
    request: RemedyRequest,
    blank: AppliedRemedy,
    balanced: ForceBalanced,
    balancers: Sequence[Balancer],
    runs: Sequence[MovedMasses],
) -> AppliedRemedy:
    """Write balancers with motors into the file, verify it, and list what the motors need.

    Args:
        blank: the result so far.
        balanced: the linkage without balancers.
        runs: motions of the linkage without them; the last is that of the file.
    """
    done, (*moved, shown) = verify_with_balancers(request, blank, balanced, balancers, runs)
    inputs, first = balanced.linkage.inputs, balanced.linkage.mobility
    drives = [driven for balancer in balancers for driven in balancer.drives]
    peaks = [
        [
            driven.peaks(trajectory.ud[:, k], trajectory.udd[:, k])
            for k, driven in enumerate(drives, first)
        ]
        for trajectory in moved
    ]
    worst = max(range(len(moved)), key=lambda k: max(peak["power"] for peak in peaks[k]))
    table = _table(inputs, moved[worst], drives)
    motion = motion_columns((*inputs, *(driven.joint for driven in drives)), shown)
    return replace(
        done,
        files=CsvFiles({"drive.csv": table, "motion.csv": motion}),
        details={
            "motions": [
                {"name": f"random motion {k + 1} of 1 s", "peaks": part}
                for k, part in enumerate(peaks)
            ],
            "worst": worst + 1,
            "peaks": [
                {key: max(part[k][key] for part in peaks) for key in peaks[0][k]}
                for k in range(len(drives))
            ],
        },
    )


def _wheels(
    request: RemedyRequest, balanced: ForceBalanced, runs: Sequence[MovedMasses]
) -> list[Wheel]:
    """Make the wheels; several are at two radii from the origin, along their axes."""
    linkage = balanced.linkage
    momenta = [run.momentum for run in runs]
    candidates = linkage.chain.frame.R[::-1] if linkage.planar else np.eye(3)
    axes = [axis for axis in candidates if has_momentum(linkage, momenta, axis[None])]
    if not axes:
        raise NoBalancer("refused", NO_MOMENT)
    pace = _pace(request, balanced, [run.trajectory for run in runs])
    radius = request.rotor_radius
    several = len(axes) > 1
    return [
        make_wheel(
            balanced.document,
            axis,
            2.0 * radius * axis * several,
            _mean_size(momenta, axis) / (pace * request.gear),
            radius,
            f"_{k}" if several else "",
        )
        for k, axis in enumerate(axes, 1)
    ]


def _mean_size(momenta: Sequence[Momentum], axis: Array) -> float:
    """Compute the mean of ``|h|`` about an axis."""
    return float(np.mean([np.abs(momentum.total[:, :3] @ axis).mean() for momentum in momenta]))


def _pace(request: RemedyRequest, balanced: ForceBalanced, runs: Sequence[Trajectory]) -> float:
    """Compute the mean speed of the fastest input, rad/s and characteristic lengths/s."""
    slides = [name in balanced.linkage.sliding for name in balanced.linkage.inputs]
    units = np.where(slides, request.space.length, 1.0)
    return float(
        np.mean([np.abs(trajectory.ud / units).max(axis=1).mean() for trajectory in runs])
    )


def _table(
    inputs: Sequence[str], motion: Trajectory, drives: Sequence[BalancerDrive]
) -> dict[str, Array]:
    """List time, inputs, and position, speed, force or torque, and power of each drive."""
    columns = {"time": motion.time}
    columns |= {name: motion.u[:, k] for k, name in enumerate(inputs)}
    for k, driven in enumerate(drives, len(inputs)):
        columns |= driven.columns(motion.u[:, k], motion.ud[:, k], motion.udd[:, k])
    return columns


def _build_geared_wheel(request: RemedyRequest) -> AppliedRemedy:
    """Build the wheel that the crank drives at the ratio ``i(u) = -h(u) / J``.

    The force is balanced by counterweights; h is the angular momentum that is left for a unit
    rate of the crank, over a full turn of it, or over 90 % of the reachable range either way,
    and less if a singular pose is on the way. J is the mean of ``|h|`` there over the gear N of
    the request, so that the mean of ``|i|`` is N, and a full turn turns the wheel by N turns if
    the ratio keeps its sign. The wheel is a thin ring of the rotor radius ρ, of mass
    ``J / ρ²``, its centre ``2 ρ`` from the axis of the crank. Gears there have the pitch curves
    of `balance.masses.remedies.balancers.varying_ratio`, if the crank turns on the base and the
    ratio keeps its sign; otherwise a cam moves the wheel. The crank feels ``J i²`` besides the
    linkage.

    The wheel is an input of its own in the file, which is verified along random motions, and
    over the table unless that passes a singular pose, where round-off is amplified.

    Returns:
        The result; its files have a random motion with the wheel, the ratio and the pitch
        curves.

    Raises:
        NoBalancer: the linkage is spatial or has several freedoms, its force cannot be
            balanced, no moment is left, or one about other axes.
        LinkageError: the linkage cannot be moved.
    """
    refuse_several_freedoms(request)
    balanced = balance_force(request)
    linkage, normal = balanced.linkage, balanced.linkage.chain.frame.R[2]
    limits = motion_of(linkage, request.motion or None)
    crank, rates = crank_rates(linkage, limits)
    way, turns = sweep_crank(linkage, limits, crank, rates)
    fine, sweep = fine_motion(request), move_masses(linkage, way)
    randomly = random_motions(linkage, MOTIONS, POSES, seed=SEED, motion=limits)
    runs = [fine, *(move_masses(linkage, trajectory) for trajectory in randomly)]
    if regular := way.conditioning > CONDITIONING_NOTICE:
        runs.append(sweep)
    momenta = [run.momentum for run in runs]
    refuse_other_moments(linkage, momenta, "this wheel does not take; active wheels do")
    table = _ratio_table(request, linkage, sweep, crank, turns)
    radius, centre = request.rotor_radius, crank_joint(linkage, crank).point
    point = centre + 2.0 * radius * linkage.chain.frame.R[0]
    wheel = make_wheel(balanced.document, normal, point, table.inertia, radius)
    words = (
        f"a wheel of {number_text(wheel.mass)} kg on the base that {crank} drives at "
        "a varying ratio"
    )
    blank = AppliedRemedy("passive_wheel", words, "undecided", "")
    done, moved = verify_with_balancers(request, blank, balanced, [wheel], runs)
    motion = motion_columns((*linkage.inputs, wheel.joint), moved[0])
    at_start = drive(linkage, [0.0], [0.0 * rates], [rates], [0.0 * rates])
    h = float(momentum_along(linkage, at_start).total[0, :3] @ normal)
    done = with_input_inertia(request, done, {crank: h**2 / table.inertia})
    return _with_tables(linkage, done, table, wheel, regular, motion)


def _with_tables(
    linkage: Linkage,
    done: AppliedRemedy,
    table: VaryingRatio,
    wheel: Wheel,
    regular: bool,
    motion: Mapping[str, Array],
) -> AppliedRemedy:
    """Add the ratio, the pitch curves and the peaks to a result, as files and as data."""
    curves, words = _pitch_curves(linkage, table, 2.0 * wheel.radius)
    files = {"motion.csv": motion, "ratio.csv": table.columns()}
    if curves is not None:
        files["pitch_curves.csv"] = curves.columns()
    peaks = wheel.drives[0].peaks(table.ratio, table.slope)
    details = {
        "wheel": wheel.details(),
        "crank": table.crank,
        "full_turn": table.turns,
        "range": [float(table.u[0]), float(table.u[-1])],
        "cycle": table.cycle,
        "singular": not regular,
        "drive": words,
        **_tables(table, curves),
        "peaks": {"at": "unit rate of the crank", **peaks},
    }
    return replace(done, files=CsvFiles(files), details=details)


def _ratio_table(
    request: RemedyRequest, linkage: Linkage, sweep: MovedMasses, crank: str, turns: bool
) -> VaryingRatio:
    """Compute the ratio along a motion at a unit rate of the crank."""
    momentum, normal = sweep.momentum, linkage.chain.frame.R[2]
    h, change = (x[:, :3] @ normal for x in (momentum.total, momentum.rate))
    u = sweep.trajectory.u[:, linkage.inputs.index(crank)]
    mean = float(np.trapezoid(np.abs(h), u)) / float(u[-1] - u[0])
    inertia = mean / request.gear
    ratio, slope = -h / inertia, -change / inertia
    angle = integrate(u, ratio, slope)
    return VaryingRatio(crank, turns, inertia, u, ratio, slope, angle)


def _pitch_curves(
    linkage: Linkage, table: VaryingRatio, distance: float
) -> tuple[PitchCurves | None, str]:
    """Compute the pitch curves, and say what drives the wheel."""
    joint = crank_joint(linkage, table.crank)
    if joint.kind != "revolute" or joint.parent != GROUND:
        return None, "a cam: the crank does not turn on the base, so that no gear does either"
    curves = table.pitch_curves(distance)
    if curves is None:
        return None, "a cam: the ratio changes its sign or comes near 0, so that no gears roll"
    words = "non-circular gears"
    if np.ptp(table.ratio) <= RELATION_RESIDUAL * np.abs(table.ratio).max():
        words = "circular gears"
    if curves.reversed:
        words += " and a pair of equal wheels that reverse"
    if not table.turns:
        return curves, f"{words}: segments, since the crank does not turn fully"
    ends = "close" if curves.closed else "do not close: the wheel makes no n-th part of a turn"
    return curves, f"{words}, whose pitch curves {ends}"


def _tables(table: VaryingRatio, curves: PitchCurves | None) -> dict[str, object]:
    """Describe ratio and pitch curves as plain data, by every tenth row."""
    tables: dict[str, object] = {
        "ratio": {name: x[::STRIDE].tolist() for name, x in table.columns().items()},
        "pitch_curves": None,
    }
    if curves is not None:
        tables["pitch_curves"] = {
            "distance": curves.distance,
            "closed": curves.closed,
            "reversed": curves.reversed,
            "rolled": list(curves.rolled),
            **{name: x[::STRIDE].tolist() for name, x in curves.columns().items()},
        }
    return tables
