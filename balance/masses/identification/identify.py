"""Identify the masses of a linkage from a measured motion and measured loads."""

from __future__ import annotations

from os import PathLike

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.identification.combinations import Combination, relevant_combinations
from balance.masses.identification.identification import (
    ChannelFit,
    Identification,
    Identified,
    IdentifiedMass,
    ShakingOf,
)
from balance.masses.identification.least_squares import (
    LeastSquares,
    condition_number,
    sensor_errors,
    solve,
)
from balance.masses.identification.likeliest_masses import (
    LikeliestMasses,
    likeliest_masses,
    widened_pseudo_inertias,
)
from balance.masses.identification.load_rows import LoadRows, load_rows
from balance.masses.identification.low_pass import LowPass, filter_measurements
from balance.masses.identification.measurements import (
    LoadTable,
    Measurements,
    motion_at,
    read_measurements,
    require_bodies,
)
from balance.motion.verification.given_motions import from_csv, large_angles, rounding_notice
from balance.motion.verification.load_errors import load_errors
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.motion.verification.trajectory import Trajectory
from balance.space.inertial_parameters.conversions import from_chain, to_chain
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import GRAVITY, Balance, point_of
from balance.support.tolerances import EXCITED_OUTSIDE, RESIDUALS_CORRELATED
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import BodyError, LinkageError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage, Notice
from kinematics.numerics.array_types import Array
from kinematics.wording import first_names, number_text

# Standard deviation of the masses of a file, relative to them, by default.
PRIOR = 0.3
# Part of the noise below which residuals are round-off: exact loads have the least noise.
NOISE_FLOOR = 0.5
# Most numbers of the regressor of all loads.
MOST_NUMBERS = 30_000_000


def identify(
    linkage: LinkageLike,
    motion: Trajectory | str | PathLike[str],
    loads: LoadTable,
    *,
    gravity: ArrayLike = GRAVITY,
    about: ArrayLike | None = None,
    on_linkage: bool = False,
    offset: bool = False,
    friction: bool = False,
    rotors: bool = False,
    cutoff: float | None = None,
    prior: float = PRIOR,
    balance: Balance = "dynamic",
    spatial: bool = False,
) -> Identification:
    """Identify the masses of a linkage, as far as balance depends on them, from measurements.

    The wrench of the base on the linkage is ``ḣ - g``, linear in the inertial parameters, and
    so are the torques of the drives. Weighted linear least squares estimate the combinations of
    parameters that these loads determine, with standard errors from the residuals of each
    channel. Of all masses that bodies can have, the likeliest ones are found, too: between the
    loads and the masses of the file.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        motion: the measured motion, or a table of it as ``balance verify --csv`` reads it.
        loads: a table with a column ``time``, some of ``fx``, ``fy``, ``fz`` (N) and ``mx``,
            ``my``, ``mz`` (N m), in inertial axes, and of the inputs by name, for the torques
            of their drives (N m, sliding N): its path, or its columns by name. Its times may
            differ from those of the motion.
        gravity: acceleration of gravity in the inertial frame, m/s²; loads contain the weight.
            Zeros if it was subtracted.
        about: point of the moments in the inertial frame, metres; the inertial origin by
            default.
        on_linkage: whether the wrench is that of the base on the linkage; by default it is
            that of the linkage on its base.
        offset: whether each channel has an unknown constant: a sensor that was set to zero, or
            that carries a frame too.
        friction: whether each drive with a measured torque has viscous and dry friction,
            ``τ = … + a u̇ + b sign u̇``.
        rotors: whether each of these drives has a rotor, of unknown inertia J after the gears,
            ``τ = … + J ü``. Its momentum is not part of that of the linkage.
        cutoff: frequency in Hz below which motion and loads are filtered, without delay; None
            for exact motions. Velocities and accelerations in a table are then not used.
        prior: standard deviation of the masses of the file relative to them, for the likeliest
            masses; combinations and their errors do not depend on it.
        balance: ``"dynamic"``, or ``"force"`` for combinations on which forces alone depend.
        spatial: count ten parameters per body, even if the linkage is planar.

    Returns:
        Combinations with standard errors, likeliest masses, and what they shake.

    Raises:
        FileError: a table cannot be read, or has too few samples.
        UsageError: an option is out of range, or the loads are not those of the motion.
        BodyError: a body has no mass in the file.
        LinkageError: no link that moves has an inertia.
        PoseError: the loops cannot be closed along the motion.

    Source: C. G. Atkeson, C. H. An, J. M. Hollerbach, International Journal of Robotics
        Research 5(3), 1986; T. Lee, P. M. Wensing, F. C. Park, IEEE Transactions on Robotics
        36(2), 2020.

    Example:
        >>> import balance
        >>> run = balance.verify("robot.urdf", trajectories=1).runs[0]
        >>> names = ("mx", "my", "mz", "fx", "fy", "fz")
        >>> loads = {"time": run.trajectory.time, **dict(zip(names, -run.shaking.T))}
        >>> answer = balance.identify("robot.urdf", run.trajectory, loads, gravity=(0, 0, 0))
        >>> answer.verdict, len(answer.combinations)
        ('identified', 8)
    """
    linkage = as_linkage(linkage)
    require_bodies(linkage)
    if not (np.isfinite(prior) and prior > 0.0):
        raise UsageError(f"prior: {prior:g} is not above 0")
    pull, point = point_of(gravity), point_of((0.0, 0.0, 0.0) if about is None else about)
    measured = read_measurements(linkage, loads, on_linkage)
    for name, asked in (("friction", friction), ("rotors", rotors)):
        if asked and not measured.drives:
            raise UsageError(f"{name}: no torque of a drive was measured")
    band: LowPass | None = None
    if cutoff is None:
        given = motion if isinstance(motion, Trajectory) else from_csv(linkage, motion)
        trajectory = motion_at(linkage, given, measured.time)
    else:
        trajectory, measured, band = filter_measurements(linkage, motion, measured, cutoff)
    if not trajectory.moves:
        raise UsageError("motion: nothing moves; give inputs that change with time")
    most = MOST_NUMBERS // (60 * len(linkage.bodies))
    if len(measured.time) > most:
        raise UsageError(
            f"loads: {len(measured.time)} samples of so many links would fill the memory: "
            f"leave out all but {most}"
        )
    space = design_space(linkage, None, balance, spatial=spatial)
    rows = load_rows(linkage, trajectory, pull, point)
    sensors = _sensor_columns(linkage, trajectory, measured, offset, friction, rotors)
    if band is not None:
        rows = LoadRows(*map(band.apply, rows))
        sensors = [(names, band.apply(F)) for names, F in sensors]
        trajectory = band.choose(linkage, trajectory)
        values = band.apply(measured.values)
        measured = measured._replace(time=trajectory.time, values=values)
    Y = _channel_rows(linkage, measured, rows)
    fit = solve(Y, measured.values, [F for _, F in sensors], measured.rounding)
    if fit is None:
        raise UsageError(
            f"loads: {len(measured.time)} samples of {first_names(measured.channels)} are too "
            "few for so many unknowns: measure for longer"
        )
    return _collect_result(
        space, trajectory, measured, rows, Y, fit, sensors, pull, point, prior, cutoff
    )


def _channel_rows(linkage: Linkage, measured: Measurements, rows: LoadRows) -> Array:
    """Select the rows of the measured loads (N, channels, parameters)."""
    drives = [linkage.inputs.index(name) for name in measured.drives]
    return np.concatenate(
        [rows.wrench[:, list(measured.wrench)], rows.drives[:, drives]], axis=1
    )


Sensors = list[tuple[tuple[str, ...], Array]]


def _sensor_columns(
    linkage: Linkage,
    trajectory: Trajectory,
    measured: Measurements,
    offset: bool,
    friction: bool,
    rotors: bool,
) -> Sensors:
    """List names and columns (N, count) of the parameters of each channel's own sensor."""
    sensors: Sensors = []
    count = len(measured.time)
    for name in measured.channels:
        names, columns = [], [np.empty((count, 0))]
        if offset:
            names.append(f"offset {name}")
            columns.append(np.ones((count, 1)))
        if name in measured.drives:
            k = linkage.inputs.index(name)
            rate, change = trajectory.ud[:, [k]], trajectory.udd[:, [k]]
            if friction and np.abs(rate).max() > 0.0:
                names += [f"viscous {name}", f"dry {name}"]
                columns += [rate, np.sign(rate)]
            if rotors and np.abs(change).max() > 0.0:
                names.append(f"rotor {name}")
                columns.append(change)
        sensors.append((tuple(names), np.concatenate(columns, axis=1)))
    return sensors


def _collect_result(
    space: DesignSpace,
    trajectory: Trajectory,
    measured: Measurements,
    rows: LoadRows,
    Y: Array,
    fit: LeastSquares,
    sensors: Sensors,
    gravity: Array,
    point: Array,
    prior: float,
    cutoff: float | None,
) -> Identification:
    """Collect the result of a fit."""
    linkage = space.linkage
    chain = input_chain(linkage)
    file = mass_parameters(linkage)
    x0 = to_chain(file, chain.frame, False, False)
    matter, flat = widened_pseudo_inertias(x0)
    for body, P in zip(linkage.bodies, matter, strict=True):
        if not np.trace(P) > 0.0:
            raise BodyError(
                linkage.source,
                body.name,
                "has no mass in the file, near which the likeliest one could be: give it an "
                "<inertial>, or name it by massless",
            )
    likely = likeliest_masses(fit, matter, prior)
    if likely is None:
        raise LinkageError(
            f"{linkage.source}: round-off keeps the likeliest masses from being found; give "
            "masses of the right size in the file"
        )
    relevant = relevant_combinations(space, fit.directions)
    identified = tuple(
        _evaluate(item, fit, x0.reshape(-1), likely) for item in relevant.combinations
    )
    loads = np.stack([Y @ x0.reshape(-1), Y @ (fit.directions @ fit.estimate)])
    constants: dict[str, float | None] = {}
    spreads: dict[str, float | None] = {}
    for c, (names, F) in enumerate(sensors):
        for k in range(2):
            values = np.linalg.lstsq(F, measured.values[:, c] - loads[k, :, c], rcond=None)[0]
            loads[k, :, c] += F @ values
        errors = sensor_errors(F, Y[:, c], fit, float(fit.noise[c]))
        for name, value, error in zip(names, values.tolist(), errors, strict=True):
            constants[name] = None if error is None else value
            spreads[name] = error
    z = likely.x.reshape(-1, 10) @ from_chain(chain.frame, False, False).T
    force, moment = _rounding(linkage, trajectory, z, point)
    channels = _channel_fits(measured, loads, fit)
    return Identification(
        space, identified, fit.directions.shape[1],
        condition_number(fit.factor, relevant.directions.T @ fit.directions), channels,
        freeze(z), _masses(space, file, z, likely, x0), _shaking(rows, x0.reshape(-1)),
        _shaking(rows, likely.x, fit, likely), (force, moment), prior, gravity, freeze(point),
        trajectory, measured, loads, constants, spreads, cutoff,
        (*linkage.notices, *rounding_notice(trajectory), *large_angles(linkage, trajectory.u),
         *_fit_notices(channels), *_far_notices(likely),
         *_flat_notices(linkage, flat.tolist())),
    )  # fmt: skip


def _evaluate(
    item: Combination, fit: LeastSquares, x0: Array, likely: LikeliestMasses
) -> Identified:
    """Evaluate a combination."""
    file, likeliest = float(item.row @ x0), float(item.row @ likely.x)
    if not item.determined:
        return Identified(item, file, None, None, likeliest)
    row = item.row @ fit.directions
    return Identified(
        item, file, float(row @ fit.estimate), float(fit.spread(row[None])[0]), likeliest
    )


def _masses(
    space: DesignSpace, file: Array, z: Array, likely: LikeliestMasses, x0: Array
) -> tuple[IdentifiedMass, ...]:
    """List the likeliest mass of each link; masses are in kg in the units of the chain too."""
    unit = np.zeros((len(z), *x0.shape))
    unit[range(len(z)), range(len(z)), 0] = 1.0
    errors = likely.spread(unit.reshape(len(z), -1))
    masses = []
    for b, name in enumerate(space.bodies):
        frame = space.frames[b]
        com = frame[:3, :3].T @ (z[b, 1:4] / z[b, 0] - frame[:3, 3])
        masses.append(
            IdentifiedMass(
                name, float(file[b, 0]), float(z[b, 0]), float(errors[b]), freeze(com)
            )
        )
    return tuple(masses)


def _shaking(
    rows: LoadRows,
    x: Array,
    fit: LeastSquares | None = None,
    likely: LikeliestMasses | None = None,
) -> ShakingOf:
    """Compute root mean squares of the shaking, their standard errors, and shares.

    What the loads determine is taken from them alone; else from the likeliest masses.

    Args:
        x: parameters (parameters,), units of the chain.
        fit: what the loads determine; None for masses without errors.
        likely: the likeliest masses, whose parameters are x.
    """
    parts, errors, shares = [], [], []
    for part in (slice(0, 3), slice(3, 6)):
        A = rows.shaking[:, part]
        bodies = (A.reshape(*A.shape[:2], rows.bodies, 10) * x.reshape(-1, 10)).sum(axis=3)
        whole = np.sqrt(np.square(np.linalg.norm(bodies, axis=1).sum(axis=1)).mean())
        load, spread = A @ x, likely.spread if likely else None
        if fit is not None:
            inside = A @ fit.directions
            outside = np.linalg.norm(A - inside @ fit.directions.T)
            if outside <= EXCITED_OUTSIDE * np.linalg.norm(A):
                A, load, spread = inside, inside @ fit.estimate, fit.spread
        rms = float(np.sqrt(np.square(load).sum(axis=1).mean()))
        slope = np.einsum("ki,kip->p", load, A) / (len(load) * (rms or 1.0))
        parts.append(rms)
        errors.append(float(spread(slope[None])[0]) if spread else 0.0)
        shares.append(rms / float(whole) if whole else 0.0)
    return ShakingOf(*parts, *errors, *shares)


def _channel_fits(
    measured: Measurements, loads: Array, fit: LeastSquares
) -> tuple[ChannelFit, ...]:
    """Describe how well each load is explained."""
    fits = []
    for c, name in enumerate(measured.channels):
        values, r = measured.values[:, c], fit.residuals[:, c]
        size, given, residual = (
            float(np.sqrt(np.square(part).mean()))
            for part in (values, values - loads[0, :, c], r)
        )
        power = float(r @ r)
        correlation = float(r[1:] @ r[:-1]) / power if power > 0.0 else 0.0
        fits.append(ChannelFit(name, size, given, residual, float(fit.noise[c]), correlation))
    return tuple(fits)


def _rounding(
    linkage: Linkage, trajectory: Trajectory, z: Array, point: Array
) -> tuple[float, float]:
    """Bound the errors of force and moment, root mean square, of a rounded table."""
    if trajectory.errors is None:
        return 0.0, 0.0
    off = load_errors(linkage, input_chain(linkage), z, trajectory, point)
    moment, force = np.sqrt(np.square(off).mean(axis=1)).tolist()
    return force, moment


def _fit_notices(channels: tuple[ChannelFit, ...]) -> list[Notice]:
    """Warn of residuals that are not white noise."""
    noisy = [c for c in channels if c.residual > NOISE_FLOOR * c.noise]
    sizes = {c.name: abs(c.correlation) for c in noisy}
    names = [name for name, size in sizes.items() if size > RESIDUALS_CORRELATED]
    if not names:
        return []
    most = max(sizes.values())
    text = (
        f"residuals of {first_names(names)} are not white noise: neighbours correlate by up to "
        f"{number_text(most, '.2f')}; standard errors are then too small, and flexible links, "
        "play, friction or filters may be the reason"
    )
    return [Notice("correlated_residuals", text)]


def _far_notices(likely: LikeliestMasses) -> list[Notice]:
    """Say that loads ask for masses that are far from those of the file."""
    if likely.followed:
        return []
    text = (
        "the loads ask for masses unlike any near those of the file, so that the likeliest "
        "masses follow them only roughly: check units, --gravity, --about and --on-linkage"
    )
    return [Notice("far_from_file", text)]


def _flat_notices(linkage: Linkage, flat: list[bool]) -> list[Notice]:
    """Say which bodies of the file were widened."""
    names = [body.name for body, yes in zip(linkage.bodies, flat, strict=True) if yes]
    if not names:
        return []
    text = (
        f"{first_names(names)}: flat, thin or impossible in the file; the likeliest masses are "
        "compared with bodies of some extent"
    )
    return [Notice("widened_prior", text)]
