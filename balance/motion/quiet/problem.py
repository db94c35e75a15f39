"""What a plan minimises between which poses, read from the words of a user."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.quiet.convex_steps import QuietProblem
from balance.motion.quiet.limits import InputLimits
from balance.motion.quiet.objective import Measure, Part, QuietObjective, time_weights
from balance.motion.quiet.sampled_loads import SampledLinkage, SampledPoses
from kinematics.closure.joint_positions import joint_positions, values_by_input
from kinematics.errors import PoseError, UsageError
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

PoseLike = Mapping[str, float] | ArrayLike
"""Displacements of inputs by name, or of all in order."""

# Largest displacement of an input, rad and m.
MOST = 1e4


def quiet_problem(
    linkage: Linkage,
    limits: InputLimits,
    minimise: Part,
    measure: Measure,
    about: Sequence[float] | None,
    weight_moment: float | None,
    gravity: Sequence[float],
    frequencies: Sequence[float] = (),
) -> QuietProblem:
    """Collect what is minimised.

    Raises:
        UsageError: an option is none.
    """
    frame = linkage.spatial_chain.frame
    for name, value, words in (
        ("minimise", minimise, ("force", "moment", "both")),
        ("measure", measure, ("rms", "peak")),
    ):
        if value not in words:
            raise UsageError(f"{name}: '{value}' is none of {', '.join(words)}")
    length = frame.length if weight_moment is None else weight_moment
    if not 0.0 < length < np.inf:
        raise UsageError("the length that weighs moments must be above 0")
    if not all(0.0 < frequency < np.inf for frequency in frequencies):
        raise UsageError("natural frequencies of the base must be above 0")
    point = frame.origin if about is None else np.array(about, dtype=np.float64)
    model = SampledLinkage.of(linkage, np.array(gravity, dtype=np.float64))
    kinds = [linkage.joints[j].kind for j in linkage.positions_of(linkage.inputs)]
    units = np.array([frame.length if kind == "prismatic" else 1.0 for kind in kinds])
    omega = tuple(2.0 * np.pi * frequency for frequency in frequencies)
    objective = QuietObjective(minimise, measure, point, float(length))
    return QuietProblem(model, objective, limits, units, omega)


def scaled_problem(
    problem: QuietProblem, value: float, time: Array, udd: Array
) -> QuietProblem:
    """Return the problem with the sizes of a first motion as units.

    Args:
        value: size of its shaking.
        time: samples (N,).
        udd: its accelerations (N, inputs).
    """
    squares = ((udd / problem.units) ** 2).sum(axis=1)
    acceleration = float(np.sqrt(time_weights(time) @ squares))
    length = problem.model.linkage.spatial_chain.frame.length
    inertia_force = problem.model.mass * length * max(1.0, length) * acceleration
    return replace(
        problem,
        inertia_force=inertia_force,
        acceleration=acceleration or 1.0,
        scale=max(value, SHAKING_RELATIVE * inertia_force) or 1.0,
    )


def check_duration(duration: float) -> None:
    """Check that a duration is positive and finite.

    Raises:
        UsageError: it is not.
    """
    if not 0.0 < duration < np.inf:
        raise UsageError("the duration must be above 0")


def end_poses(linkage: Linkage, start: PoseLike, end: PoseLike) -> tuple[Array, Array]:
    """Read both poses: displacements of the inputs.

    Raises:
        PoseError: they are no poses, or the same one.
    """
    first = read_pose(linkage, start, np.zeros(linkage.mobility))
    last = read_pose(linkage, end, first)
    if np.array_equal(first, last):
        raise PoseError(f"{linkage.source}: the two poses are one: nothing moves")
    return first, last


def read_pose(linkage: Linkage, given: PoseLike, defaults: Array) -> Array:
    """Read displacements of the inputs; those that are not named are those of another pose."""
    if isinstance(given, Mapping):
        given = values_by_input(linkage, given, defaults.tolist())
    values = np.asarray(given, dtype=np.float64)
    if values.shape != (linkage.mobility,) or not (np.abs(values) <= MOST).all():
        raise PoseError(
            f"{linkage.source}: give {linkage.mobility} displacements of the inputs "
            f"({', '.join(linkage.inputs)}), of at most {MOST:g} rad or m"
        )
    return values


def follow_poses(model: SampledLinkage, u: Array) -> SampledPoses:
    """Compute closed poses along a path of the inputs, each close to the one before.

    Args:
        u: displacements of the inputs (N, inputs); the first is reached from the reference
            pose on a straight line.

    Raises:
        PoseError: the loops cannot be closed on it.
    """
    linkage = model.linkage
    if model.chain.dependent.size == 0:
        return model.at(u @ model.chain.columns.T)
    pose = model.close(joint_positions(linkage, u[0])[None])
    followed = []
    for k in range(len(u)):
        pose = pose if k == 0 or pose is None else model.near(pose, u[k : k + 1])
        if pose is None:
            raise PoseError(
                f"{linkage.source}: the loops cannot be closed beyond {k / len(u):.2g} of the "
                "path of the inputs between the poses"
            )
        followed.append(pose)
    return SampledPoses(*(np.concatenate(part) for part in zip(*followed, strict=True)))


def nearest_poses(problem: QuietProblem, known: SampledPoses, u: Array) -> SampledPoses:
    """Pick those of known poses that are nearest to displacements of the inputs (N, inputs)."""
    linkage = problem.model.linkage
    there = known.q[:, linkage.positions_of(linkage.inputs)]
    distance = (((u[:, None] - there) / problem.units) ** 2).sum(axis=2)
    nearest = distance.argmin(axis=1)
    return SampledPoses(*(part[nearest] for part in known))
