"""True error of every order of a Taylor motion along lines and paths.

The true error is the difference between a prediction and the pose that closes the loops.
Continuation from the reference pose follows a straight line without the expansion. Distances
and errors are in radians and characteristic lengths. Errors are maxima over the joints.
(After J. J. de Jong, PhD thesis, University of Twente, Figs. 4.1 to 4.3.)
"""

from __future__ import annotations

from itertools import islice
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import LINE_END_RELATIVE
from balance.motion.taylor_poses.prediction import Predictions, offset_of
from kinematics.closure.continuation import continue_along
from kinematics.closure.taylor.monomials import monomial_powers
from kinematics.closure.taylor.taylor_motion import TaylorMotion
from kinematics.numerics.array_types import Array, Flags

# Most coordinates with a line of their own: more panels do not fit on a page.
MAX_LINES = 6
# Most rows of a path; rows of a longer path are skipped evenly.
MAX_ROWS = 400
# Samples of a line: enough for a smooth curve.
SAMPLES = 120
# Length of a line in radii of convergence, so that the growth beyond the radius shows.
LENGTH_IN_RADII = 1.4
# Length of a line if the radius is infinite, radians and characteristic lengths.
LENGTH_WITHOUT_RADIUS = 1.0


class Curves(NamedTuple):
    """Errors of all orders along one line or path.

    Attributes:
        title: name of the line or path.
        axis: name of its abscissa.
        x: distance from the reference pose, or along the path (N,).
        errors: true errors of order 1, 2, … (order, N).
        estimate: estimated error of the highest order (N,); NaN beyond the radius.
        beyond: intervals of x that are beyond the radius of convergence.
        closed: values of x beyond which the loops do not close.
        target: the x of the target pose, or None.
    """

    title: str
    axis: str
    x: Array
    errors: Array
    estimate: Array
    beyond: tuple[tuple[float, float], ...]
    closed: tuple[float, ...] = ()
    target: float | None = None


def error_curves(predictions: Predictions) -> list[Curves]:
    """Compute the errors along the line or path of the predictions.

    Without poses, compute them along each coordinate.
    """
    motion = predictions.motion
    if predictions.line and predictions.poses[0].distance > 0.0:
        pose = predictions.poses[0]
        far = max(1.1 * pose.distance, _line_length(motion))
        direction = pose.y / motion.scales / pose.distance
        return [
            _line_curves(motion, "straight to the target", direction, (far,), pose.distance)
        ]
    if predictions.poses and not predictions.line:
        return [_path_curves(predictions)]
    far = _line_length(motion)
    directions = np.eye(motion.scales.size)[:MAX_LINES]
    return [
        _line_curves(motion, _direction_name(motion, direction), direction, (-far, far))
        for direction in directions
    ]


def _line_length(motion: TaylorMotion) -> float:
    """Return the length of a line."""
    return (
        LENGTH_IN_RADII * motion.radius if np.isfinite(motion.radius) else LENGTH_WITHOUT_RADIUS
    )


def _direction_name(motion: TaylorMotion, direction: Array) -> str:
    """Name the inputs that move along a direction of the coordinates."""
    moved = motion.motion.basis @ direction != 0.0
    names = [name for name, used in zip(motion.motion.inputs, moved, strict=True) if used]
    return f"along {' and '.join(names)}"


def _line_curves(
    motion: TaylorMotion,
    title: str,
    direction: Array,
    ends: tuple[float, ...],
    target: float | None = None,
) -> Curves:
    """Compute errors along a direction, from the reference pose to the ends of the line."""
    halves = [_closed_poses_along(motion, np.sign(end) * direction, abs(end)) for end in ends]
    closed = tuple(
        float(np.sign(end) * s[-1])
        for end, (s, _) in zip(ends, halves, strict=True)
        if s[-1] < (1.0 - LINE_END_RELATIVE) * abs(end)
    )
    sides = [np.sign(end) * s for end, (s, _) in zip(ends, halves, strict=True)]
    x, order = np.unique(np.concatenate(sides), return_index=True)
    q = np.concatenate([q for _, q in halves])[order]
    points = x[:, None] * direction * motion.scales
    first, last = min(*ends, 0.0), max(*ends, 0.0)
    outside = [(first, -motion.radius), (motion.radius, last)]
    beyond = tuple(pair for pair in outside if pair[0] < pair[1])
    errors, estimate = _errors(motion, points, q), motion.error(points)
    return Curves(title, "distance", x, errors, estimate, beyond, closed, target)


def _closed_poses_along(
    motion: TaylorMotion, direction: Array, far: float
) -> tuple[Array, Array]:
    """Compute distances (N,) and joint positions (N, n) of closed poses along a direction.

    Steps shrink towards a singularity, where continuation stops.
    """
    chain = motion.chain
    rates = chain.columns @ direction
    poses = continue_along(chain, direction, longest_step=far / SAMPLES)
    s, q = [0.0], [np.zeros(len(motion.joints))]
    for pose in islice(poses, 2 * SAMPLES):
        done = float(pose.q @ rates / (rates @ rates))
        if done > (1.0 + LINE_END_RELATIVE) * far:
            break
        s.append(done)
        q.append(np.zeros(len(motion.joints)))
        q[-1][chain.joints] = pose.q * chain.units
    return np.array(s), np.array(q)


def _path_curves(predictions: Predictions) -> Curves:
    """Compute errors at the rows of a path; rows without a closed pose are gaps."""
    motion = predictions.motion
    poses = predictions.poses[:: -(-len(predictions.poses) // MAX_ROWS)]
    points = np.array([pose.y for pose in poses])
    steps = np.linalg.norm(np.diff(points, axis=0) / motion.scales, axis=1)
    x = np.concatenate([[0.0], np.cumsum(steps)])
    gap = np.full(len(motion.joints), np.nan)
    q = np.array([gap if pose.corrected is None else pose.corrected for pose in poses])
    estimate = np.array([np.nan if pose.error is None else pose.error for pose in poses])
    outside = np.array([pose.distance > motion.radius for pose in poses])
    title, axis = "along the path", "way along the path"
    return Curves(title, axis, x, _errors(motion, points, q), estimate, _spans(x, outside))


def _spans(x: Array, outside: Flags) -> tuple[tuple[float, float], ...]:
    """Compute the intervals of x in which a condition holds.

    They end halfway between samples that fulfil it and samples that do not.
    """
    between = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2.0, x[-1:]])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], outside, [False]])))
    return tuple((float(between[a]), float(between[b])) for a, b in edges.reshape(-1, 2))


def _errors(motion: TaylorMotion, points: Array, q: Array) -> Array:
    """Compute the true errors of all orders at points (N, w) with closed poses q (N, n).

    Sums that overflow have no finite error.
    """
    degree, sums, errors = motion.exponents.sum(axis=1), np.zeros_like(q), []
    with np.errstate(over="ignore", invalid="ignore"):
        terms = monomial_powers(motion.exponents, points)
        for k in range(1, motion.order + 1):
            sums = sums + terms[:, degree == k] @ motion.coefficients[degree == k]
            errors.append(offset_of(motion, sums, q))
    return np.array(errors)
