"""One revolution of a crank at constant speed in steady state, and the limits of a crank.

With the crank angle ``θ(t) = ω t`` the loops determine all other joints:

    q̇ = C_0 ω        q̈ = C_1 ω

Forces grow with ω². There is no start-up: the motion begins and ends at full speed.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from math import degrees, pi
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import (
    CONDITIONING_SINGULAR,
    CRANK_ADVANCE,
    RELATION_RESIDUAL,
    REVOLUTION_RETURN,
)
from balance.motion.verification.input_paths import SteadyPath
from balance.motion.verification.trajectory import Stop, Trajectory, order_inputs, track
from balance.support.units import read_quantity
from kinematics.closure.continuation import continue_along
from kinematics.closure.joint_positions import input_chain
from kinematics.closure.newton import Pose
from kinematics.errors import CoordinateError, MotionError, PoseError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import freeze
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.linalg.vectors import project_out
from kinematics.wording import number_text

TURN = 2.0 * pi
# Steps of a revolution: half a degree each.
STEPS = 720
# Offsets of the samples, in steps. Where branches of the motion meet, joint rates are not
# determined; if a sample hits such a pose, all samples move by the next offset.
PHASES = (0.0, 0.4)
# Share of a step from a sample within which a pose where the motion ends may be that sample's.
NEAR_SAMPLE = 0.01
# Steps of a revolution that is only tried, and most inputs for which turns are tried.
TRIAL_STEPS, MOST_TRIED = 180, 6
# Speeds outside this range, radians per second, make forces that underflow or overflow.
SLOWEST = 1e-6
FASTEST = 1e6


class Crank(NamedTuple):
    """A joint that turns at constant speed.

    Attributes:
        joint: name of the joint.
        speed: radians per second; negative turns against the axis of the joint.
        periodic: whether every joint returns to its start after one revolution.
    """

    joint: str
    speed: float
    periodic: bool

    @property
    def rpm(self) -> float:
        """Revolutions per minute."""
        return self.speed * 60.0 / TURN

    @property
    def words(self) -> str:
        """The motion in words: one revolution, and its speed."""
        return f"one revolution of {self.joint} at {number_text(self.rpm, '.6g')} rpm"


def revolve_crank(
    linkage: Linkage,
    speed: float | str,
    joint: str | None = None,
    motion: Motion | None = None,
    steps: int = STEPS,
    *,
    explain: bool = True,
    related: str = "",
) -> tuple[Trajectory, Crank]:
    """Compute one revolution of a crank at constant speed, both ends included.

    Args:
        speed: radians per second, or a text with a unit; negative turns against the axis of
            the joint.
        joint: the crank, a revolute input; by default the only input, or the first of those
            that the motion lets turn at one speed only. Other inputs stand still, or follow
            if the motion relates them to the crank.
        motion: restriction of the inputs; free by default.
        steps: steps of the revolution; half a degree each by default.
        explain: whether the message for a crank that cannot turn fully gives its limits, and
            what turns instead, which takes longer than many turns.
        related: what the message adds to relations of the inputs with which a crank turns.

    Returns:
        The motion in time, from the reference pose on, and the crank.

    Raises:
        CoordinateError: the joint is no revolute input, or the crank is not named.
        MotionError: the motion does not let the crank turn.
        PoseError: the crank cannot turn fully (the message gives the limits), or the size of
            the speed is not from 1e-6 to 1e6 rad/s.
    """
    if isinstance(speed, str):
        speed = read_quantity(speed, "angular velocity")
    if not SLOWEST <= abs(speed) <= FASTEST:
        raise PoseError(
            f"{linkage.source}: {speed:g} rad/s is no speed of a crank; give one from "
            f"{SLOWEST:g} to {FASTEST:g} rad/s either way"
        )
    joint = _crank_name(linkage, joint, speed, motion, related)
    rates = _input_rates(linkage, joint, motion)
    for phase in PHASES:
        with suppress(PoseError):
            outcome = _revolution(linkage, speed, rates, phase, steps)
            if isinstance(outcome, Stop):
                if NEAR_SAMPLE < outcome.share < 1.0 - NEAR_SAMPLE:
                    break  # the motion ends between samples, wherever these are
            elif outcome.conditioning > CONDITIONING_SINGULAR:
                return outcome, Crank(joint, speed, _is_periodic(linkage, outcome))
    problem = f"{linkage.source}: the crank {joint} cannot turn fully"
    if not explain:
        raise PoseError(problem)
    low, high = (number_text(degrees(x), ".2f") for x in crank_limits(linkage, joint, rates))
    raise PoseError(
        f"{problem}: only from {low}° to {high}° about the reference pose; "
        f"{_turning_motion_text(linkage, speed, related)}"
    )


def one_turn(
    linkage: LinkageLike,
    speed: float | str,
    crank: str | None = None,
    motion: Motion | None = None,
) -> Trajectory:
    """Compute one turn of a crank at constant speed, as ``--speed`` of the command line does.

    The turn is steady: with the crank angle ``θ = ω t`` the joint rates are ``q̇ = C_0 ω`` and
    ``q̈ = C_1 ω``, and forces grow with ω².

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        speed: ω, radians per second, or a text with a unit, ``"300rpm"``; negative turns
            against the axis of the joint.
        crank: name of a revolute input; by default the only input, or the first of those that
            the motion lets turn at one speed only. Other inputs stand still, or follow if the
            motion relates them to the crank.
        motion: restriction of the inputs; free by default.

    Returns:
        The motion in time, from the reference pose on.

    Raises:
        CoordinateError: the joint is no revolute input, or the crank is not named.
        MotionError: the motion does not let the crank turn.
        PoseError: the crank cannot turn fully (the message gives the limits), or the size of
            the speed is not from 1e-6 to 1e6 rad/s.

    Example:
        >>> import balance
        >>> turn = balance.motion.one_turn("robot.urdf", 10.0)
        >>> round(turn.duration, 4)
        0.6283
    """
    return revolve_crank(as_linkage(linkage), speed, crank, motion)[0]


def _revolution(
    linkage: Linkage, speed: float, rates: Array, phase: float, steps: int
) -> Trajectory | Stop:
    """Compute one revolution from a crank angle of ``phase`` steps on, or where it ends.

    Raises:
        PoseError: the crank cannot reach the first angle.
    """
    time = np.asarray((np.arange(steps + 1) + phase) * (TURN / steps / abs(speed)), float)
    path = SteadyPath(np.zeros(rates.size), speed * rates)
    outcome = track(linkage, (time, *path.at(time)), shortest=CRANK_ADVANCE)
    return outcome if isinstance(outcome, Stop) else replace(outcome, path=path)


def crank_of(linkage: Linkage, trajectory: Trajectory) -> Crank | None:
    """Return the crank of a revolution from `revolve_crank`; None for other motions."""
    if not isinstance(trajectory.path, SteadyPath):
        return None
    rates = trajectory.path.rate
    at = first_largest(np.abs(rates))
    periodic = _is_periodic(linkage, trajectory)
    return Crank(linkage.inputs[at], float(rates[at]), periodic)


def _crank_name(
    linkage: Linkage, joint: str | None, speed: float, motion: Motion | None, related: str
) -> str:
    """Return the name of the crank.

    Raises:
        CoordinateError: it is no revolute input, or there are several and none is named.
    """
    kinds = {item.name: item.kind for item in linkage.joints}
    turning = [name for name, kind in kinds.items() if kind == "revolute"]
    cranks = [name for name in linkage.inputs if name in turning]
    if joint is None and len(linkage.inputs) == 1:
        joint = linkage.inputs[0]
    if joint is None and motion is not None:
        joint = _related_crank(linkage, cranks, motion)
    if joint is None:
        problem = f"which is the crank? {_turning_motion_text(linkage, speed, related)}"
        raise CoordinateError(linkage.source, linkage.inputs, problem, cranks)
    if joint not in linkage.inputs:
        problem = "not an input, so not the crank; --inputs makes it one"
        raise CoordinateError(linkage.source, [joint], problem, cranks)
    if joint not in cranks:
        problem = f"{kinds[joint]}, not revolute, so not a crank; --inputs names another"
        raise CoordinateError(linkage.source, [joint], problem, turning)
    return joint


def _related_crank(linkage: Linkage, cranks: list[str], motion: Motion) -> str | None:
    """Return the first crank that a motion of one degree of freedom turns; else None.

    Raises:
        CoordinateError: it turns cranks at different speeds.
    """
    basis = order_inputs(motion, linkage)
    speeds = dict(zip(linkage.inputs, np.abs(basis).max(axis=1).tolist(), strict=True))
    turned = [name for name in cranks if speeds[name]]
    if basis.shape[1] != 1 or not turned:
        return None
    fastest = max(speeds[name] for name in turned)
    if fastest - min(speeds[name] for name in turned) > RELATION_RESIDUAL * fastest:
        problem = f"which is the crank? name it, as in --speed {turned[0]}=300rpm"
        raise CoordinateError(linkage.source, turned, problem, turned)
    return turned[0]


def _input_rates(linkage: Linkage, joint: str, motion: Motion | None) -> Array:
    """Compute the rates of the inputs (mobility,) for a unit rate of the crank.

    Raises:
        MotionError: the motion does not let the crank turn while other inputs stand still.
    """
    at = linkage.inputs.index(joint)
    single: Array = np.eye(linkage.mobility)[at]
    if motion is None:
        return single
    basis = order_inputs(motion, linkage)
    if basis.shape[1] == 1 and basis[at, 0] != 0.0:
        related: Array = basis[:, 0] / basis[at, 0]
        return related
    if np.abs(project_out(single, np.linalg.qr(basis)[0])).max() > RELATION_RESIDUAL:
        problem = f"does not let {joint} turn while other inputs stand still"
        raise MotionError(", ".join(motion.relations), problem, linkage.inputs, linkage.source)
    return single


def crank_limits(linkage: Linkage, joint: str, rates: Array) -> tuple[float, float]:
    """Compute how far an input can move either way from the reference pose, on its branch.

    Args:
        rates: rates of all inputs (mobility,) for a unit rate of this one, SI units.

    Returns:
        The least and the greatest displacement, in radians, at most a full turn; of an input
        that slides in metres, at most 2π characteristic lengths.
    """
    chain = input_chain(linkage)
    column = chain.columns @ (rates / chain.units[linkage.positions_of(linkage.inputs)])
    crank = int(linkage.positions_of([joint])[0])
    single = replace(
        chain,
        columns=freeze(column[:, None]),
        moves=freeze(chain.moves.any(axis=1, keepdims=True), np.bool_),
    )
    low, high = (
        sign
        * _farthest(continue_along(single, np.array([sign]), longest_step=TURN / STEPS), crank)
        for sign in (-1.0, 1.0)
    )
    return low * float(chain.units[crank]), high * float(chain.units[crank])


def _turning_motion_text(linkage: Linkage, speed: float, related: str) -> str:
    """Name options with which a crank of this linkage turns fully, or other motions of it.

    Tried are each input alone, all of them at one rate, and each second one against it. The
    first of one input and the first of several are named.

    Args:
        related: what follows relations of the inputs.
    """
    names = linkage.inputs
    columns = ",".join(("time", *names))
    otherwise = f"give a motion by --csv FILE with the columns {columns}"
    if len(names) > MOST_TRIED:
        return f"name it, as in --speed {names[0]}=300rpm, or {otherwise}"
    trials: list[tuple[Array, str]] = [(row, "") for row in np.eye(len(names))]
    for sign in ("", "-") if len(names) > 1 else ():
        signs = [sign if k % 2 else "" for k in range(len(names))]
        relations = [
            f"--motion {name}={minus}{names[0]} "
            for minus, name in zip(signs[1:], names[1:], strict=True)
        ]
        rates = np.array([-1.0 if minus else 1.0 for minus in signs])
        trials.append((rates, "".join(relations)))
    kinds = {item.name: item.kind for item in linkage.joints}
    ways: dict[bool, str] = {}
    for rates, options in trials:
        if bool(options) in ways:
            continue
        crank = names[first_largest(np.abs(rates))]
        moved = [name for name, rate in zip(names, rates, strict=True) if rate]
        if all(kinds[name] == "revolute" for name in moved) and _turns(linkage, rates):
            rpm = f"{crank}={number_text(speed * 60.0 / TURN, '.6g')}rpm"
            ways[bool(options)] = f"{options}--speed {rpm}{related if options else ''}"
    if ways:
        return f"what turns fully is {' and '.join(ways.values())}; or {otherwise}"
    if len(names) == 1:
        return f"choose a joint that can with --inputs, or {otherwise}"
    return f"choose inputs that can with --inputs, or {otherwise}"


def _turns(linkage: Linkage, rates: Array) -> bool:
    """Whether inputs can turn at these rates until the crank has made a turn."""
    with suppress(PoseError):
        turn = _revolution(linkage, 1.0, rates, PHASES[1], TRIAL_STEPS)
        return not isinstance(turn, Stop) and turn.conditioning > CONDITIONING_SINGULAR
    return False


def _farthest(poses: Iterable[Pose], joint: int) -> float:
    """Compute the largest displacement of a joint along a continuation, within one revolution.

    Steps shrink towards a dead centre, where the continuation need not end.
    """
    farthest = 0.0
    for pose in poses:
        angle = abs(float(pose.q[joint]))
        if angle >= TURN:
            return TURN
        if angle - farthest < CRANK_ADVANCE:
            break
        farthest = angle
    return farthest


def _is_periodic(linkage: Linkage, trajectory: Trajectory) -> bool:
    """Whether all joints return to their start, revolute ones up to full turns."""
    turns = np.array([item.kind == "revolute" for item in linkage.joints])
    change = trajectory.q[-1] - trajectory.q[0]
    change = np.where(turns, change - TURN * np.round(change / TURN), change)
    return bool(np.all(np.abs(change) <= REVOLUTION_RETURN * input_chain(linkage).units))
