"""Poses that a motion passes, at times that the plan chooses or at its ends.

A pose is one of all inputs, or one of a tool that may leave inputs free. Near a motion with the
coefficients y, a pose at the time t is missed by

    g(u(t)) ≈ g + G (B Δy + u̇ Δt)        G = ∂g/∂u,   B = ∂u/∂y at t,

in rad and characteristic lengths over the reach of the motion. The times keep their order.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from balance.motion.quiet.motion_space import MotionSpace
from balance.motion.quiet.objective import time_weights
from balance.motion.quiet.sampled_loads import SampledLinkage, SampledPoses
from balance.motion.quiet.tool_point import ToolPose
from balance.motion.verification.input_paths import InputPath
from kinematics.numerics.array_types import Array

# Least distance of two times in order, over the duration.
APART = 0.02
# Newton steps by which passed poses are met exactly, and the part of the reach up to which they
# are.
SETTLED_STEPS, SETTLED = 12, 1e-10
# Weight of positions beside accelerations in the least change of a motion, so that it is one.
POSITION_WEIGHT = 1e-9


class PassedPose(NamedTuple):
    """A pose that a motion passes.

    Attributes:
        u: displacements of the inputs (inputs,); of a pose of a tool that leaves inputs free,
            those of one pose of the inputs that has it.
        tool: the coordinates of the tool; None if all inputs count.
        share: of the duration, at which the pose is passed; None if the plan chooses it.
    """

    u: Array
    tool: ToolPose | None = None
    share: float | None = None

    def miss(
        self, model: SampledLinkage, poses: SampledPoses, units: Array
    ) -> tuple[Array, Array]:
        """Compute how far one pose is from it (m,), in units, and the derivatives (m, w)."""
        if self.tool is not None:
            off, by_u = self.tool.miss(model, poses)
            return off[0], by_u[0]
        inputs = model.linkage.positions_of(model.linkage.inputs)
        return (poses.q[0, inputs] - self.u) / units, np.diag(1.0 / units)


class PassingProblem(Protocol):
    """What of a problem matters here: a linkage, and poses that its motion passes."""

    @property
    def model(self) -> SampledLinkage:
        """The linkage."""
        ...

    @property
    def units(self) -> Array:
        """Units of the inputs: 1 rad, or the characteristic length (inputs,)."""
        ...

    @property
    def passes(self) -> tuple[PassedPose, ...]:
        """The poses, in order."""
        ...

    @property
    def reach(self) -> float:
        """Size of the motion, in units."""
        ...


class Misses(NamedTuple):
    """How far a motion is from the poses that it should pass, over the reach.

    Attributes:
        off: of each pose (m,).
        by_u: derivatives by the inputs (m, w).
        rates: of the inputs there (poses, w).
    """

    off: list[Array]
    by_u: list[Array]
    rates: Array

    @property
    def distances(self) -> Array:
        """Norms of what is off (poses,)."""
        return np.array([np.linalg.norm(off) for off in self.off])


def misses(
    problem: PassingProblem, path: InputPath, at: Array, known: SampledPoses, time: Array
) -> Misses | None:
    """Compute how far a motion is from the poses that it should pass.

    Args:
        at: times of the poses (poses,).
        known: closed poses near those of the motion at some times.
        time: these times (N,), rising.

    Returns:
        The distances; None if the loops cannot be closed there.
    """
    if not problem.passes:
        return Misses([], [], np.empty((0, problem.units.size)))
    u, ud, _ = path.at(at)
    nearest = np.abs(time - at[:, None]).argmin(axis=1)
    poses = problem.model.near(SampledPoses(*(part[nearest] for part in known)), u)
    if poses is None:
        return None
    pairs = [
        passed.miss(
            problem.model, SampledPoses(*(part[k : k + 1] for part in poses)), problem.units
        )
        for k, passed in enumerate(problem.passes)
    ]
    off = [pair[0] / problem.reach for pair in pairs]
    return Misses(off, [pair[1] / problem.reach for pair in pairs], ud)


def settle(
    problem: PassingProblem,
    space: MotionSpace,
    y: Array,
    at: Array,
    known: SampledPoses,
    time: Array,
) -> Array:
    """Change a motion so that it passes all poses exactly, with the least mean acceleration.

    Args:
        y: free coefficients (free, w).
        at: times of the poses.
        known: closed poses near those of the motion at some times.
        time: these times (N,), rising.

    Returns:
        The free coefficients; where the poses cannot be met, those of the last step.
    """
    if not problem.passes:
        return y
    samples = space.times(4)
    weights = time_weights(samples)[:, None]
    accelerations, positions = space.basis(samples, 2), space.basis(samples, 0)
    W = accelerations.T @ (weights * accelerations)
    W += POSITION_WEIGHT * np.trace(W) * (positions.T @ (weights * positions))
    inverse = np.linalg.inv(W)
    B = space.basis(at, 0)
    for _ in range(SETTLED_STEPS):
        off = misses(problem, space.path(y), at, known, time)
        if off is None or off.distances.max(initial=0.0) <= SETTLED:
            break
        # Rows of all poses: by input, then by coefficient.
        rows = [
            (by_u[:, :, None] * b).reshape(len(by_u), -1)
            for by_u, b in zip(off.by_u, B, strict=True)
        ]
        R = np.concatenate(rows).reshape(-1, y.shape[1], y.shape[0])
        lifted = np.einsum("rwf,fg,w->rwg", R, inverse, problem.units**2)
        product = np.einsum("rwf,swf->rs", lifted, R)
        step = -np.linalg.pinv(product, rcond=1e-12) @ np.concatenate(off.off)
        y = y + np.einsum("rwf,r->fw", lifted, step)
    return y


def least_acceleration(space: MotionSpace, inputs: int) -> Array:
    """Compute the coefficients (free, inputs) of the motion of least mean acceleration."""
    time = space.times(4)
    weights = np.sqrt(time_weights(time))[:, None]
    fixed_part = space.functions(time, 2) @ space.fixed
    rows = weights * space.basis(time, 2)
    y = np.linalg.lstsq(rows, -weights * fixed_part, rcond=None)[0]
    return np.asarray(y.reshape(-1, inputs), np.float64)


def order_rows(problem: PassingProblem, at: Array, duration: float) -> tuple[Array, Array]:
    """Build the rows of changes of free times that keep the order of all times.

    Returns:
        Matrix (rows, free) and constants (rows,): none of their sum is negative.
    """
    free = [k for k, passed in enumerate(problem.passes) if passed.share is None]
    place = {k: column for column, k in enumerate(free)}
    fixed = [0.0, *at.tolist(), duration]
    rows, constants = [], []
    for k in range(len(fixed) - 1):
        row = np.zeros(len(free))
        if k in place:
            row[place[k]] += 1.0
        if k - 1 in place:
            row[place[k - 1]] -= 1.0
        if row.any():
            rows.append(row)
            constants.append(fixed[k + 1] - fixed[k] - APART * duration)
    return np.array(rows).reshape(-1, len(free)), np.array(constants)
