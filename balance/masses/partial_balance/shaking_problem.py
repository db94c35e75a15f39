"""What partial balance minimises: shaking along motions, or vibration of an elastic frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.counterweights.link_regions import regions_of
from balance.masses.counterweights.moved_matter import moved_links, taken_from
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.shaped.weight_shape import WeightShape, wanted_shapes
from balance.masses.counterweights.volume.mirror_images import halved_where_loads_are_even
from balance.masses.counterweights.volume.plates import density_limits, stocks_of
from balance.masses.partial_balance.elastic_frame import ElasticFrame, vibration
from balance.masses.partial_balance.least_shaking import (
    CapsConflict,
    LeastShaking,
    least_shaking,
)
from balance.masses.partial_balance.motion_loads import (
    AddedParameters,
    MotionLoads,
    motion_loads,
)
from balance.masses.partial_balance.shaking_objectives import (
    PartialObjective,
    check_objective,
    harmonic_rows,
    objective_in_words,
)
from balance.masses.partial_balance.shaking_program import (
    NO_SAMPLES,
    Cap,
    ShakingProgram,
    quadratic_factor,
)
from balance.masses.partial_balance.shaped_shaking import least_shaped_shaking
from balance.motion.verification.given_motions import Motions, read_motions
from balance.motion.verification.load_errors import load_errors
from balance.motion.verification.trajectory import Trajectory, random_motions
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import point_of
from kinematics.error_text import did_you_mean
from kinematics.errors import PoseError, UsageError
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array

# Motions, and samples of each, if none are given, as `balance.verify` has them.
RANDOM_MOTIONS, SAMPLES = 10, 200


@dataclass(frozen=True)
class ShakingOptions:
    """What may shake how, and what may be added; None for what `partial` does by default.

    Attributes:
        regions: where matter may be added, by link; see
            `balance.masses.counterweights.link_regions.regions_of`.
        motions: one or several, as for `balance.verify`.
        weight_moment: a moment of so many newton metres counts as a force of one newton.
        max_bearing: largest force in joints, N.
        max_torque: largest drive torque of inputs, N m, for sliding ones N.
        frame: an elastic frame whose vibration is minimised instead of the shaking.
        about: point in the inertial frame for moments, metres.
        density: density that added matter nowhere exceeds, kg/m³; None for point masses.
        thickness: that of plates of added matter, m.
        minimise: the objective; see `PartialObjective`.
        move: largest share of the given mass of links that may be moved, by name.
        shape: shape of the counterweights, such as ``disc=0.02``; see `partial`.
    """

    regions: Mapping[str, Region | str] | None = None
    motions: Motions | None = None
    weight_moment: float | None = None
    max_bearing: Mapping[str, float] | None = None
    max_torque: Mapping[str, float] | None = None
    frame: ElasticFrame | None = None
    about: ArrayLike | None = None
    density: float | Mapping[str, float] | None = None
    thickness: float | None = None
    minimise: PartialObjective = "rms"
    move: Mapping[str, float] | None = None
    shape: str | None = None


class ShakingFigures(NamedTuple):
    """What a linkage with some masses does along the motions, without gravity.

    Attributes:
        objective: what is minimised, N, for an elastic frame m.
        force: root mean square of the shaking force, N.
        moment: the same of the shaking moment, N m.
        peak_force: largest shaking force, N.
        peak_moment: largest shaking moment, N m.
        vibration: root mean square of the vibration of the frame, m; None without a frame.
        inertia: inertia that each input feels at the reference pose, kg m², sliding kg.
        torque: largest drive torque of each input, N m, sliding N.
        bearing: largest force in each joint, N.
        force_off: how far ``force`` can be off, since tables of the motions are rounded, N.
        moment_off: the same of ``moment``, N m.
    """

    objective: float
    force: float
    moment: float
    peak_force: float
    peak_moment: float
    vibration: float | None
    inertia: dict[str, float]
    torque: dict[str, float]
    bearing: dict[str, float]
    force_off: float = 0.0
    moment_off: float = 0.0


@dataclass(frozen=True, eq=False)
class ShakingProblem:
    """The question of partial balance, factorised: each budget is one small conic program.

    Attributes:
        space: a design space of the linkage.
        matter: regions of the links, and inertial parameters as functions of added matter.
        loads: loads along each motion.
        program: objective and caps.
        factors: triangular factors of the mean squares of the moment and of the force.
        weight_moment: metres; see `ShakingOptions`.
        frame: the elastic frame, if there is one.
        point: point of the inertial frame that moments are about (3,), metres.
        minimise: see `ShakingOptions`.
        shapes: the shape of the counterweights in its sizes; empty for matter of any shape.
    """

    space: DesignSpace
    matter: AddedParameters
    loads: tuple[MotionLoads, ...]
    program: ShakingProgram
    factors: tuple[Array, Array]
    weight_moment: float
    frame: ElasticFrame | None
    point: Array
    minimise: PartialObjective = "rms"
    shapes: tuple[WeightShape, ...] = ()

    @property
    def objective(self) -> str:
        """What is minimised, in words."""
        return objective_in_words(self.minimise) if self.frame is None else "vibration"

    @property
    def motions(self) -> tuple[Trajectory, ...]:
        """The motions."""
        return tuple(motion.trajectory for motion in self.loads)

    def solve(self, budget: float) -> LeastShaking | CapsConflict:
        """Find the least shaking for a budget, kilograms.

        Nothing is added without a budget or matter to move, nor to what is balanced and keeps
        its caps, nor where the solver finds nothing better.
        """
        s, room = np.zeros(self.matter.count), budget + self.program.taken.heaviest
        over = self.program.exceeded_caps(s)
        value = self.program.value(s)
        none = np.zeros(len(self.matter.regions))
        if room > 0.0 and (over or not self.program.balanced):
            answer = least_shaking(self.program, budget)
            if self.shapes and isinstance(answer, LeastShaking):
                return least_shaped_shaking(
                    self.space, self.program, self.shapes, budget, answer
                )
            if over or isinstance(answer, CapsConflict) or answer.value <= value:
                return answer
            bound = min(answer.bound, value)
            return answer._replace(s=s, value=value, bound=bound, shares=none)
        if over:
            return CapsConflict(True, tuple(over))
        return LeastShaking(s, value, 0.0 if room > 0.0 else value, 0, none)

    def least_caps(self, budget: float) -> float:
        """Compute the least factor by which all caps have to be larger for a budget.

        Infinite if the solver finds none.
        """
        caps = self.program.caps
        relative = [cap.columns / cap.most for cap in caps]
        program = replace(self.program, caps=(), samples=_stacked(relative))
        s = np.zeros(self.matter.count)
        if not budget + program.taken.heaviest > 0.0:
            return program.value(s)
        answer = least_shaking(program, budget)
        return answer.value if isinstance(answer, LeastShaking) else inf

    def figures(self, designs: Sequence[Array]) -> list[ShakingFigures]:
        """Compute what designs, given as coordinates s, do along the motions."""
        points = np.vstack([np.array(designs).T, np.ones(len(designs))])
        linkage, peaks = self.space.linkage, np.zeros((2, len(designs)))
        torque = np.zeros((linkage.mobility, len(designs)))
        bearing = np.zeros((len(linkage.joints), len(designs)))
        for motion in self.loads:
            sizes = _part_sizes(motion.wrench_columns @ points)
            peaks = np.maximum(peaks, sizes.max(axis=0))
            reactions = motion.reactions(points)
            torque = np.maximum(torque, np.abs(motion.torques(reactions)).max(axis=0))
            forces = (motion.bearings(reactions, j) for j in range(len(bearing)))
            peak_forces = [np.linalg.norm(force, axis=1).max(axis=0) for force in forces]
            bearing = np.maximum(bearing, peak_forces)
        rms = np.array([np.linalg.norm(R @ points, axis=0) for R in self.factors])
        objective = [self.program.value(s) for s in designs]
        names = [joint.name for joint in linkage.joints]
        inertia = self.matter.input_inertia() @ points
        return [
            ShakingFigures(
                float(objective[k]),
                float(rms[1, k]),
                float(rms[0, k]),
                float(peaks[1, k]),
                float(peaks[0, k]),
                float(objective[k]) if self.frame else None,
                dict(zip(linkage.inputs, inertia[:, k].tolist(), strict=True)),
                dict(zip(linkage.inputs, torque[:, k].tolist(), strict=True)),
                dict(zip(names, bearing[:, k].tolist(), strict=True)),
                *self._rounding(designs[k]),
            )
            for k in range(len(designs))
        ]

    def _rounding(self, design: Array) -> tuple[float, float]:
        """Bound the errors of root mean square force, N, and moment, N m, of a design.

        The root mean square of a sum is at most the sum of those of its parts.
        """
        z, squares = self.matter.parameters(design), np.zeros(2)
        for motion in self.loads:
            if motion.trajectory.errors is not None:
                off = load_errors(
                    self.space.linkage, self.matter.chain, z, motion.trajectory, self.point
                )
                squares += off**2 @ motion.weights / len(self.loads)
        moment, force = np.sqrt(squares)
        return float(force), float(moment)


def build_problem(
    space: DesignSpace,
    links: Sequence[str],
    options: ShakingOptions,
    progress: Callable[[int, int], None] | None = None,
) -> ShakingProblem:
    """Compute the loads along motions and factorise the objective.

    Args:
        space: a design space; one for force balance does not count moments.
        links: names of the links that may get matter.
        progress: called with the number of motions done and the number of all.

    Raises:
        BodyError: a link is unknown, or its region cannot be found.
        PoseError: nothing moves.
        UsageError: a number is out of range, or a joint is unknown.
    """
    frame, about = options.frame, options.about
    max_bearing, max_torque = options.max_bearing or {}, options.max_torque or {}
    asked = read_motions(space.linkage, options.motions, space.motion)
    chosen = regions_of(space, links, options.regions or {})
    limits = density_limits(space, chosen, options.density, options.thickness)
    stocks = stocks_of(space, chosen, limits) if limits else {}
    shapes = _wanted_shapes(space, options)
    chosen = {b: stocks[b].region if stocks else region for b, region in chosen.items()}
    weight = _weight_of_moments(space, options.weight_moment)
    _check_caps(space, max_bearing, max_torque)
    check_objective(options.minimise, frame)
    matter = AddedParameters.of(space, chosen)
    if about is not None and frame is not None:
        raise UsageError("an elastic frame turns about the middle: leave out about")
    middle = space.linkage.spatial_chain.frame.origin
    point = middle if about is None else point_of(about)
    loads = _loads(space, matter, asked, progress, point - middle)
    blocks = [np.sqrt(motion.weights / len(loads))[:, None, None] for motion in loads]
    wrenches = [
        root * motion.wrench_columns for root, motion in zip(blocks, loads, strict=True)
    ]
    factors = tuple(
        quadratic_factor([_flat(rows[:, part]) for rows in wrenches])
        for part in (slice(0, 3), slice(3, 6))
    )
    if frame is None and isinstance(options.minimise, str):
        whole = quadratic_factor([factors[0] / weight, factors[1]])
    else:
        counted = [_counted(motion.wrench_columns, motion, weight, frame) for motion in loads]
        whole = quadratic_factor(_objective_rows(space, loads, blocks, counted, options))
    caps = _caps(space, loads, max_bearing, max_torque)
    single = _single_bodies(loads, blocks, weight, frame)
    samples = _minimax_loads(space, loads, weight, options)
    taken = taken_from(space, chosen, moved_links(space, chosen, options.move))
    if stocks and not (shapes or taken.links):
        counted = [whole, *([samples] if samples.size else []), *(cap.columns for cap in caps)]
        stocks = halved_where_loads_are_even(space, stocks, counted)
    program = ShakingProgram(
        matter, whole, single, taken, caps, tuple(stocks.values()), samples
    )
    return ShakingProblem(
        space,
        matter,
        tuple(loads),
        program,
        (factors[0], factors[1]),
        weight,
        frame,
        freeze(point),
        options.minimise,
        shapes,
    )


def _wanted_shapes(space: DesignSpace, options: ShakingOptions) -> tuple[WeightShape, ...]:
    """Read a shape, which goes with the shaking force alone; see `partial`."""
    feels_inertia = options.frame or options.max_bearing or options.max_torque
    clash = ""
    if options.thickness is not None:
        clash = "shapes have their thickness: leave out that of plates"
    elif feels_inertia or options.minimise in ("torque", "bearing"):
        clash = (
            "shapes are found for the shaking force, of which the program is convex: leave out "
            "torques, bearing forces and the frame, which feel moments of inertia, or the shape"
        )
    return wanted_shapes(options.shape, space, options.density, options.move, clash)


def _weight_of_moments(space: DesignSpace, weight: float | None) -> float:
    """Return the moment that counts as much as a unit force, metres; see `ShakingOptions`."""
    length = space.linkage.spatial_chain.frame.length if weight is None else float(weight)
    if not (isfinite(length) and length > 0.0):
        raise UsageError(f"a moment cannot weigh {length:g} m: give a length above 0")
    return inf if space.balance == "force" else length


def _loads(
    space: DesignSpace,
    matter: AddedParameters,
    motions: Sequence[Trajectory] | None,
    progress: Callable[[int, int], None] | None,
    about: Array,
) -> list[MotionLoads]:
    """Compute the loads along given or random motions."""
    linkage = space.linkage
    if motions is not None and not any(trajectory.moves for trajectory in motions):
        raise PoseError(f"{linkage.source}: nothing moves; give inputs that change with time")
    count = RANDOM_MOTIONS if motions is None else len(motions)
    followed: Iterable[Trajectory] = motions or ()
    if motions is None:
        followed = random_motions(linkage, count, SAMPLES, motion=space.motion)
    loads = []
    for done, trajectory in enumerate(followed, 1):
        loads += motion_loads(matter, [trajectory], about)
        if progress is not None:
            progress(done, count)
    return loads


def _objective_rows(
    space: DesignSpace,
    loads: Sequence[MotionLoads],
    roots: Sequence[Array],
    counted: Sequence[Array],
    options: ShakingOptions,
) -> list[Array]:
    """List rows whose sum of squares is the mean square of all motions, or of harmonics.

    Args:
        roots: of the weights of the samples of each motion (N, 1, 1).
        counted: what counts of the wrenches of each (N, 6, columns).
    """
    if isinstance(options.minimise, str):
        return [_flat(root * rows) for root, rows in zip(roots, counted, strict=True)]
    share = 1.0 / np.sqrt(len(loads))
    return [
        share * harmonic_rows(space.linkage, motion.trajectory, rows, options.minimise)
        for motion, rows in zip(loads, counted, strict=True)
    ]


def _minimax_loads(
    space: DesignSpace,
    loads: Sequence[MotionLoads],
    weight: float,
    options: ShakingOptions,
) -> Array:
    """List the loads whose largest is minimised (N, k, count + 1); none for the mean.

    Raises:
        UsageError: torques of turning inputs stand beside forces of sliding ones.
    """
    if options.minimise == "rms" or not isinstance(options.minimise, str):
        return NO_SAMPLES
    if options.minimise == "peak":
        rows = [_counted(motion.wrench_columns, motion, weight, None) for motion in loads]
        return np.concatenate(rows)
    kinds = {joint.name: joint.kind == "prismatic" for joint in space.linkage.joints}
    inputs = space.linkage.inputs if options.minimise == "torque" else ()
    if len({kinds[name] for name in inputs}) > 1:
        raise UsageError("inputs that turn and that slide have no largest torque: cap each")
    bearings = dict.fromkeys(kinds, inf) if options.minimise == "bearing" else {}
    caps = _caps(space, loads, bearings, dict.fromkeys(inputs, inf))
    return _stacked([cap.columns for cap in caps])


def _stacked(loads: Sequence[Array]) -> Array:
    """Stack loads of several kinds (N, k, count + 1); missing components are zero."""
    size = max(rows.shape[1] for rows in loads)
    return np.concatenate(
        [np.pad(rows, ((0, 0), (0, size - rows.shape[1]), (0, 0))) for rows in loads]
    )


def _caps(
    space: DesignSpace,
    loads: Sequence[MotionLoads],
    bearings: Mapping[str, float],
    torques: Mapping[str, float],
) -> tuple[Cap, ...]:
    """Build the caps on bearing forces and drive torques."""
    if not (bearings or torques):
        return ()
    names = [joint.name for joint in space.linkage.joints]
    forces: dict[str, list[Array]] = {name: [] for name in bearings}
    drives: dict[str, list[Array]] = {name: [] for name in torques}
    for motion in loads:
        reactions = motion.reactions()
        for name, parts in forces.items():
            parts.append(motion.bearings(reactions, names.index(name)))
        drive_torques = motion.torques(reactions)
        for name, parts in drives.items():
            parts.append(drive_torques[:, [space.linkage.inputs.index(name)]])
    limits = [*bearings.items(), *torques.items()]
    columns = [np.concatenate(parts) for parts in (*forces.values(), *drives.values())]
    return tuple(
        Cap(name, float(most), rows) for (name, most), rows in zip(limits, columns, strict=True)
    )


def _check_caps(
    space: DesignSpace, bearings: Mapping[str, float], torques: Mapping[str, float]
) -> None:
    """Raise UsageError for joints that do not exist or do not drive, and for wrong caps."""
    joints = [joint.name for joint in space.linkage.joints]
    for caps, names, what in (
        (bearings, joints, "joint"),
        (torques, list(space.linkage.inputs), "input"),
    ):
        for name, most in caps.items():
            if name not in names:
                meant = did_you_mean(name, names)
                raise UsageError(
                    f"there is no {what} '{name}'{meant}; they are {', '.join(names)}"
                )
            if not (isfinite(most) and most > 0.0):
                raise UsageError(f"joint '{name}' has a cap of {most:g}: give more than 0")


def _counted(
    wrenches: Array, motion: MotionLoads, weight: float, frame: ElasticFrame | None
) -> Array:
    """Compute what counts of wrenches along a motion (N, 6, columns): newtons or metres."""
    if frame is None:
        return wrenches / np.array([weight] * 3 + [1.0] * 3)[:, None]
    arm = 0.0 if weight == inf else weight
    response = vibration(frame, motion.trajectory, wrenches)
    return response * np.array([arm] * 3 + [1.0] * 3)[:, None]


def _single_bodies(
    loads: Sequence[MotionLoads],
    blocks: Sequence[Array],
    weight: float,
    frame: ElasticFrame | None,
) -> float:
    """Sum the loads of the bodies of the file, each one alone."""
    squares = sum(
        np.square(root * _counted(motion.single_wrenches, motion, weight, frame)).sum(
            axis=(0, 1)
        )
        for root, motion in zip(blocks, loads, strict=True)
    )
    return float(np.sqrt(squares).sum())


def _flat(rows: Array) -> Array:
    """Stack rows (N, k, columns) below each other."""
    return rows.reshape(-1, rows.shape[-1])


def _part_sizes(wrenches: Array) -> Array:
    """Compute the sizes of moments and forces (N, 2, columns) of wrenches (N, 6, columns)."""
    parts = wrenches.reshape(len(wrenches), 2, 3, -1)
    return np.asarray(np.linalg.norm(parts, axis=2))
