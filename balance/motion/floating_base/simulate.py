"""Simulation of a linkage on a base that floats, or stands on springs.

Unknowns are the motion of the base and, if they are driven by torques, of the inputs: poses of
the linkage follow from its inputs by Newton's method, so that loops cannot drift. The solver is
DOP853 (E. Hairer, S. Norsett, G. Wanner, Solving Ordinary Differential BaseEquations I, 1993).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.floating_base.base import BaseInChain, FloatingBase
from balance.motion.floating_base.dynamics import CarriedBodies
from balance.motion.floating_base.equations import BaseEquations, Drive
from balance.motion.floating_base.floating_base_motion import FloatingBaseMotion
from balance.motion.floating_base.pose_follower import PoseFollower
from balance.motion.floating_base.requested_motion import (
    checked_duration,
    free_drive,
    initial_rates,
    prescribed_drive,
)
from balance.motion.floating_base.samples import take_samples
from balance.motion.motion_tolerances import (
    BASE_AT_REST_RELATIVE,
    BASE_STEP_RELATIVE,
    FREQUENCY_ZERO,
    MASS_MATRIX_SINGULAR,
)
from balance.motion.verification.given_motions import MotionLike
from balance.motion.verification.input_paths import InputPath, RestToRest, SteadyPath
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import LinkageError, PoseError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import GROUND, Linkage, Notice
from kinematics.model.motion import Motion, motion_of
from kinematics.numerics.array_types import Array
from kinematics.numerics.integration import Integration, StalledError
from kinematics.wording import first_names

# Samples of a prescribed motion that show its speed.
SPEED_SAMPLES = 200
# Fewest steps, for smooth pictures.
FEWEST_STEPS = 100
# Most evaluations of the equations.
MAX_EVALUATIONS = 300_000
# The least that one vibration takes.
EVALUATIONS_PER_VIBRATION = 150.0
# Shortest step, as a part of the duration.
SHORTEST_STEP = 1e-9


def simulate_floating_base(
    linkage: LinkageLike,
    base: FloatingBase,
    z: ArrayLike | None = None,
    *,
    motions: MotionLike | InputPath | None = None,
    torques: Mapping[str, float] | None = None,
    initial: Mapping[str, float] | None = None,
    motion: Motion | str | Sequence[str] | None = None,
    duration: float | None = None,
    seed: int = 0,
    spatial: bool = False,
    tolerance: float = BASE_AT_REST_RELATIVE,
    progress: Callable[[int, int], None] | None = None,
) -> FloatingBaseMotion:
    """Simulate a linkage on a base that floats, or stands on springs (free-flying robot).

    Momentum balance ``d/dt (M_t b + A u̇) = w`` of linkage and base with the wrench w of the
    springs, without gravity. The base of a planar linkage moves in the plane. The inputs move
    as prescribed, or freely with constant torques.

    Args:
        linkage: an assembled linkage, or an argument of `kinematics.load`.
        base: the base.
        z: inertial parameters as in `shaking`; those of the file by default.
        motions: the motion of the inputs: a function of time from 0 on, samples, or a table. By
            default the first random motion of `verify`,
            from rest to rest in 2 s, again and again.
        torques: N m or N on inputs that are then free, by name; 0 for others.
        initial: velocities at the start by name: ``wx``, ``wy``, ``wz`` of the base, rad/s,
            ``vx``, ``vy``, ``vz`` of its centre of mass, m/s, inertial axes; and of free
            inputs.
        motion: restriction of the inputs; free by default.
        duration: seconds; by default that of a table, or 10.
        seed: seed of the random motion.
        spatial: whether the base of a planar linkage may leave the plane.
        tolerance: speed of a base that counts as at rest, over the speed of the bodies.
        progress: called with the hundredths done, and 100.

    Returns:
        The motion of base and inputs, energy and momentum along it, and the verdict.

    Raises:
        UsageError: the base cannot be, or the request contradicts itself.
        LinkageError: nothing with a mass moves, or torques leave a motion undetermined.
        PoseError: the linkage cannot follow the motion.
        MotionError: a relation is wrong.

    Source: J. J. de Jong, PhD thesis, University of Twente, section 2.4.

    Example:
        >>> import balance
        >>> base = balance.motion.FloatingBase(mass=10, inertia=1)
        >>> motion = balance.motion.simulate_floating_base("robot.urdf", base, duration=1)
        >>> motion.verdict, motion.energy_drift < 1e-9
        ('the base moves', True)
    """
    base.check()
    linkage = as_linkage(linkage)
    if torques is not None and motions is not None:
        raise UsageError("give either a motion of the inputs or torques on them")
    limits = motion_of(linkage, motion) or Motion.free(linkage.inputs)
    chain = input_chain(linkage)
    axes = None if spatial or not linkage.planar else linkage.chain.frame.R
    span = 0.0, checked_duration(duration)
    if torques is None:
        drive, span = prescribed_drive(linkage, chain, motions, limits, seed, duration)
    else:
        drive = free_drive(linkage, chain, torques, limits)
    equations = _equations(linkage, chain, BaseInChain.of(base, chain, axes), drive, span[0], z)
    beta, rates = initial_rates(linkage, chain, equations.base, drive, initial or {})
    first = equations.start(beta, rates)
    frequencies = _frequencies(equations, span[0], first)
    _check_frequencies(frequencies, span[1] - span[0])
    limits_of_error = _tolerances(linkage, equations, span, first)
    times, states = _integrate_steps(equations, first, limits_of_error, span, progress)
    equations.follower.restart()
    samples = take_samples(equations, chain, times, states)
    held = samples.twist
    if samples.speed.any():
        held = _hold_inputs(linkage, chain, equations, beta, limits_of_error, times, z)
    return FloatingBaseMotion(
        linkage,
        base,
        chain.frame.length,
        tolerance,
        freeze(times),
        samples,
        freeze(held),
        frequencies,
        None if torques is None else {**torques},
        {**(initial or {})},
        (*linkage.notices, *_ground_mass_notices(linkage)),
        drive.path,
    )


def _ground_mass_notices(linkage: Linkage) -> tuple[Notice, ...]:
    """Tell of masses in the file that are fixed to the ground: they are not of the base."""
    names = (
        []
        if linkage.tree is None
        else [
            link.name
            for link in linkage.tree.children
            if link.tag == "link"
            and any(child.tag == "inertial" for child in link.children)
            and link.name in linkage.places
            and linkage.places[link.name].link == GROUND
        ]
    )
    if not names:
        return ()
    text = (
        f"masses of the file on the ground are not counted ({first_names(names)}): the base "
        "has the mass and inertia that are given"
    )
    return (Notice("ground_mass", text),)


def simulate_second(
    first: FloatingBaseMotion, linkage: LinkageLike, **options: Any
) -> FloatingBaseMotion:
    """Simulate a second linkage on the base of a first one, with the same motion of its inputs.

    It gets a random motion of its own if its inputs have other names, or if it cannot follow
    the random motion of the first one.

    Args:
        first: the simulation of the first linkage.
        linkage: the second linkage.
        options: keyword arguments of `simulate_floating_base`.

    Returns:
        The simulation of the second linkage.
    """
    linkage, path = as_linkage(linkage), first.path
    options |= {"duration": first.duration}
    if path is not None and linkage.inputs == first.linkage.inputs:
        if not isinstance(path, RestToRest):
            return simulate_floating_base(linkage, first.base, motions=path, **options)
        with suppress(PoseError):
            return simulate_floating_base(linkage, first.base, motions=path, **options)
    return simulate_floating_base(linkage, first.base, **options)


def _equations(
    linkage: Linkage,
    chain: Chain,
    base: BaseInChain,
    drive: Drive,
    time: float,
    z: ArrayLike | None,
) -> BaseEquations:
    """Make the equations of motion, with the linkage at its pose at the start.

    Raises:
        LinkageError: no moving link has a mass.
    """
    bodies = CarriedBodies(linkage, chain, drive.basis, z)
    if not bodies.mass > 0.0:
        raise LinkageError(
            f"{linkage.source}: no moving link has a mass; give the links that move an "
            "<inertial>"
        )
    start = np.zeros(drive.units.size)
    if drive.path is not None:
        start = drive.prescribed(time)[0]
    return BaseEquations(base, bodies, PoseFollower(linkage, chain, start), drive)


def _tolerances(
    linkage: Linkage, equations: BaseEquations, span: tuple[float, float], first: Array
) -> Array:
    """Compute the absolute tolerances of the state from the speeds to be expected.

    Raises:
        LinkageError: torques do not determine the motion.
    """
    drive, base = equations.drive, equations.base
    now = equations.read(span[0], first)
    M = now.bodies.mass_matrix(base)
    inertias = np.diagonal(M)[6:]
    speeds = [np.abs(now.b).max(), np.abs(now.rates).max(initial=0.0)]
    if drive.path is not None:
        ud = drive.path.at(np.linspace(*span, SPEED_SAMPLES))[1]
        speeds.append(np.abs(ud / drive.units).max(initial=0.0))
    elif not _is_regular(M):
        raise LinkageError(
            f"{linkage.source}: an input moves nothing that has a mass: torques do not "
            "determine its motion; prescribe it"
        )
    else:
        # Each torque alone, after 1 radian or characteristic length.
        speeds += np.sqrt(np.abs(drive.torques / inertias)).tolist()
    carried, total = equations.mass, equations.mass + float(base.M[5, 5])
    speed = max(speeds) or 1.0
    return equations.tolerances(BASE_STEP_RELATIVE, speed, carried / total)


def _is_regular(M: Array) -> bool:
    """Whether a mass matrix can be inverted."""
    diagonal = np.diagonal(M)
    if not diagonal.min() > 0.0:
        return False
    scale = 1.0 / np.sqrt(diagonal)
    return bool(np.linalg.eigvalsh(scale[:, None] * M * scale)[0] > MASS_MATRIX_SINGULAR)


def _hold_inputs(
    linkage: Linkage,
    chain: Chain,
    moving: BaseEquations,
    beta: Array,
    tolerances: Array,
    times: Array,
    z: ArrayLike | None,
) -> Array:
    """Compute the twist of the base (N, 6), if all inputs stay where they are at the start.

    Args:
        moving: the equations with moving inputs.
        beta: rates of the freedoms of the base at the start.
        tolerances: absolute tolerances of the state of ``moving``.
        times: times (N,).
    """
    if not beta.any():
        return np.zeros((times.size, 6))
    units, path = moving.drive.units, moving.drive.path
    start = np.zeros(units.size) if path is None else path.at(times[:1])[0][0]
    still = SteadyPath(start, np.zeros(units.size))
    drive = Drive(np.eye(units.size), units, still, np.zeros(units.size))
    held = _equations(linkage, chain, moving.base, drive, times[0], z)
    kept = held.start(beta, np.zeros(0))
    states = _integrate_at(held, kept, np.full(kept.size, tolerances.min()), times)
    return held.rates_of_base(states) @ held.base.freedoms.T


def _frequencies(equations: BaseEquations, time: float, first: Array) -> tuple[float, ...]:
    """Compute the natural frequencies of the base on its springs, hertz, inputs held.

    ``det(K - ω² M_t) = 0`` at the pose at the start, in the freedoms of the base.
    """
    base, S = equations.base, equations.base.freedoms
    M = S.T @ equations.read(time, first).bodies.mass_matrix(base)[:6, :6] @ S
    root = np.linalg.inv(np.linalg.cholesky(M))
    squares = np.linalg.eigvalsh(root @ S.T @ base.stiffness_matrix @ S @ root.T)
    kept = squares[squares > FREQUENCY_ZERO * squares.max()]
    return tuple((np.sqrt(kept) / (2.0 * np.pi)).tolist())


def _check_frequencies(frequencies: tuple[float, ...], duration: float) -> None:
    """Refuse vibrations that would take too many steps.

    Args:
        frequencies: natural frequencies of the base, hertz.
        duration: seconds.

    Raises:
        PoseError: there are too many vibrations.
    """
    count = duration * max(frequencies, default=0.0)
    if not count * EVALUATIONS_PER_VIBRATION < MAX_EVALUATIONS:
        raise PoseError(
            f"the base vibrates {count:.0f} times on its springs in {duration:g} s: give a "
            "shorter duration, a heavier base or softer springs"
        )


def _integrate_steps(
    equations: BaseEquations,
    state: Array,
    tolerances: Array,
    span: tuple[float, float],
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Array, Array]:
    """Integrate the equations by DOP853, from one corner of the path to the next.

    Args:
        state: state at the start.
        tolerances: absolute ones of the state.
        span: times of start and end, seconds.
        progress: called with the hundredths done, and 100.

    Returns:
        Times (N,) and states (N, size) of all steps.

    Raises:
        PoseError: the loops cannot be closed, or the steps become too many or too small.
    """
    start, end = span
    corners = () if equations.drive.path is None else equations.drive.path.corners
    stops = [*(time for time in corners if start < time < end), end]
    times, states, step = [start], [state], None
    for stop in stops:
        while times[-1] < stop:
            # Numbers that overflow end the integration below.
            with np.errstate(over="ignore", invalid="ignore"):
                step = _advance(equations, times, states, stop, tolerances, step, end - start)
            if progress is not None:
                progress(int(100.0 * (times[-1] - start) / (end - start)), 100)
    return np.array(times), np.array(states)


def _advance(
    equations: BaseEquations,
    times: list[float],
    states: list[Array],
    stop: float,
    tolerances: Array,
    step: float | None,
    duration: float,
) -> float:
    """Integrate up to a stop, append all steps, and return the length of the next one.

    The last step may be cut short to end at the stop: what the solver proposes after it is then
    no measure of the motion, and the longest of the proposals before and after it counts.
    """
    now = times[-1]
    first = None if step is None else min(step, stop - now)
    integration = Integration(
        equations,
        now,
        states[-1],
        stop,
        rtol=BASE_STEP_RELATIVE,
        atol=tolerances,
        max_step=duration / FEWEST_STEPS,
        first_step=first,
    )
    solver, stalled = integration.solver, False
    while integration.running:
        try:
            integration.step()
        except PoseError as error:
            raise PoseError(f"{error} beyond {solver.t:.6g} s of the motion") from None
        except StalledError:
            stalled = True
        short = solver.t < stop and not solver.step_size > SHORTEST_STEP * duration
        if stalled or short or equations.evaluations > MAX_EVALUATIONS:
            raise PoseError(
                f"the motion needs too many steps beyond {solver.t:.6g} s: it is near a "
                "singular pose, or a spring is stiff; give a shorter duration, smaller "
                "displacements or a softer spring"
            )
        times.append(float(solver.t))
        states.append(solver.y.copy())
    return max(integration.proposed, float(solver.h_abs))


def _integrate_at(
    equations: BaseEquations, state: Array, tolerances: Array, times: Array
) -> Array:
    """Integrate smooth equations and return the states at given times (N, size).

    Args:
        equations: the equations, whose path has no corners.
        state: state at the first time.
        tolerances: absolute ones of the state.
        times: times (N,), seconds.
    """
    from scipy.integrate import solve_ivp

    solution = solve_ivp(
        equations,
        (times[0], times[-1]),
        state,
        method="DOP853",
        t_eval=times,
        rtol=BASE_STEP_RELATIVE,
        atol=tolerances,
    )
    return np.asarray(solution.y.T)
