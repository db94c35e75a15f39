"""Identify the masses of a linkage from measured motions and measured loads."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.identification.combinations import Combination, relevant_combinations
from balance.masses.identification.identification import (
    ChannelFit,
    Identification,
    Identified,
    IdentifiedMass,
    Recording,
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
from balance.masses.identification.measurements import require_bodies
from balance.masses.identification.recordings import (
    Channel,
    DriveTerms,
    LoadTables,
    RecordedRows,
    explain_recording,
    read_recordings,
    stack_channels,
)
from balance.motion.verification.given_motions import Motions, large_angles, rounding_notice
from balance.motion.verification.load_errors import load_errors
from balance.motion.verification.shaking_wrench import mass_parameters
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


def identify(
    linkage: LinkageLike,
    motion: Motions,
    loads: LoadTables,
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
    channel in each recording. Of all masses that bodies can have, the likeliest ones are found,
    too: between the loads and the masses of the file.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        motion: the measured motion, or a table of it as ``balance verify --csv`` reads it; or
            several, each a recording of its own.
        loads: a table for each motion, with a column ``time``, some of ``fx``, ``fy``, ``fz``
            (N) and ``mx``, ``my``, ``mz`` (N m), in inertial axes, and of the inputs by name,
            for the torques of their drives (N m, sliding N): its path, or its columns by name.
            Its times may differ from those of the motion.
        gravity: acceleration of gravity in the inertial frame, m/s²; loads contain the weight.
            Zeros if it was subtracted.
        about: point of the moments in the inertial frame, metres; the inertial origin by
            default.
        on_linkage: whether the wrench is that of the base on the linkage; by default it is
            that of the linkage on its base.
        offset: whether each channel has an unknown constant in each recording: a sensor that
            was set to zero, or that carries a frame too.
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
        UsageError: an option is out of range, the loads are not those of the motion, or there
            is not one table of loads for each motion.
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
    recorded = read_recordings(linkage, motion, loads, on_linkage, cutoff)
    for name, asked in (("friction", friction), ("rotors", rotors)):
        if asked and not any(each.measured.drives for each in recorded):
            raise UsageError(f"{name}: no torque of a drive was measured")
    space = design_space(linkage, None, balance, spatial=spatial)
    terms = DriveTerms(friction, rotors)
    recordings = [explain_recording(linkage, each, terms, pull, point) for each in recorded]
    channels = stack_channels(linkage, recordings, offset)
    fit = solve([channel.data for channel in channels])
    if fit is None:
        counts = ", ".join(str(len(each.measured.time)) for each in recordings)
        raise UsageError(
            f"loads: {counts} samples of {first_names([each.name for each in channels])} are "
            "too few for so many unknowns: measure for longer"
        )
    return _collect_result(space, recordings, channels, fit, pull, point, prior, cutoff)


def _collect_result(
    space: DesignSpace,
    recordings: list[RecordedRows],
    channels: list[Channel],
    fit: LeastSquares,
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
    predicted, sensors, errors = _explain_channels(channels, fit, x0.reshape(-1))
    explained = _explain_recordings(recordings, channels, fit, predicted)
    z = likely.x.reshape(-1, 10) @ from_chain(chain.frame, False, False).T
    shaking = np.concatenate([each.rows.shaking for each in recordings])
    return Identification(
        space, identified, fit.directions.shape[1],
        condition_number(fit.factor, relevant.directions.T @ fit.directions), explained,
        freeze(z), _masses(space, file, z, likely, x0), _shaking(shaking, x0.reshape(-1)),
        _shaking(shaking, likely.x, fit, likely), _rounding(linkage, recordings, z, point),
        prior, gravity, freeze(point), sensors, errors, cutoff,
        (*linkage.notices, *_recording_notices(linkage, explained), *_far_notices(likely),
         *_flat_notices(linkage, flat.tolist())),
    )  # fmt: skip


def _explain_channels(
    channels: list[Channel], fit: LeastSquares, x0: Array
) -> tuple[list[Array], dict[str, float | None], dict[str, float | None]]:
    """Compute what masses of the file and combinations explain, each with fitted sensors.

    Returns:
        Loads (2, N) of each channel; parameters of sensors and drives by name, and their
        standard errors.
    """
    predicted = []
    sensors: dict[str, float | None] = {}
    spreads: dict[str, float | None] = {}
    for channel, noise in zip(channels, fit.noise, strict=True):
        data = channel.data
        loads = np.stack([data.rows @ x0, data.rows @ (fit.directions @ fit.estimate)])
        weights = (noise.max() / noise)[:, None]
        left = (data.loads - loads).T
        values = np.linalg.lstsq(weights * data.sensor, weights * left, rcond=None)[0]
        predicted.append(loads + (data.sensor @ values).T)
        errors = sensor_errors(data, fit, noise)
        for name, value, error in zip(
            channel.terms, values[:, 1].tolist(), errors, strict=True
        ):
            sensors[name] = None if error is None else value
            spreads[name] = error
    return predicted, sensors, spreads


def _explain_recordings(
    recordings: list[RecordedRows],
    channels: list[Channel],
    fit: LeastSquares,
    predicted: list[Array],
) -> tuple[Recording, ...]:
    """Describe how well each load of each recording is explained."""
    by_name = {channel.name: c for c, channel in enumerate(channels)}
    explained = []
    for k, (trajectory, measured, *_) in enumerate(recordings):
        loads, fits = [], []
        for values, name in zip(measured.values.T, measured.channels, strict=True):
            c = by_name[name]
            there = channels[c].data.recording == k
            loads.append(predicted[c][:, there])
            residuals, noise = fit.residuals[c][there], float(fit.noise[c][there][0])
            fits.append(_channel_fit(name, values, loads[-1][0], residuals, noise))
        explained.append(
            Recording(trajectory, measured, freeze(np.stack(loads, axis=2)), tuple(fits))
        )
    return tuple(explained)


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
    rows: Array,
    x: Array,
    fit: LeastSquares | None = None,
    likely: LikeliestMasses | None = None,
) -> ShakingOf:
    """Compute root mean squares of the shaking, their standard errors, and shares.

    What the loads determine is taken from them alone; else from the likeliest masses.

    Args:
        rows: of the shaking wrench ``[force; moment]`` of all recordings (N, 6, parameters).
        x: parameters (parameters,), units of the chain.
        fit: what the loads determine; None for masses without errors.
        likely: the likeliest masses, whose parameters are x.
    """
    parts, errors, shares = [], [], []
    for part in (slice(0, 3), slice(3, 6)):
        A = rows[:, part]
        bodies = (A.reshape(*A.shape[:2], -1, 10) * x.reshape(-1, 10)).sum(axis=3)
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


def _channel_fit(
    name: str, values: Array, given: Array, residuals: Array, noise: float
) -> ChannelFit:
    """Describe how well a load is explained, by the masses of the file and as identified."""
    size, file, residual = (
        float(np.sqrt(np.square(part).mean())) for part in (values, values - given, residuals)
    )
    power = float(residuals @ residuals)
    correlation = float(residuals[1:] @ residuals[:-1]) / power if power > 0.0 else 0.0
    return ChannelFit(name, size, file, residual, noise, correlation)


def _rounding(
    linkage: Linkage, recordings: list[RecordedRows], z: Array, point: Array
) -> tuple[float, float]:
    """Bound the errors of force and moment, root mean square, of rounded tables."""
    chain = input_chain(linkage)
    squares = [
        np.square(load_errors(linkage, chain, z, each.trajectory, point))
        if each.trajectory.errors is not None
        else np.zeros((2, len(each.trajectory.time)))
        for each in recordings
    ]
    moment, force = np.sqrt(np.concatenate(squares, axis=1).mean(axis=1)).tolist()
    return force, moment


def _recording_notices(linkage: Linkage, recordings: tuple[Recording, ...]) -> list[Notice]:
    """Say what is doubtful in each recording."""
    notices = []
    for k, (trajectory, _, _, channels) in enumerate(recordings, 1):
        start = f"recording {k}: " if len(recordings) > 1 else ""
        notices += [
            notice._replace(message=start + notice.message)
            for notice in (
                *rounding_notice(trajectory),
                *large_angles(linkage, trajectory.u),
                *_fit_notices(channels),
            )
        ]
    return notices


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
