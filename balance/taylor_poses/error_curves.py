"""How far the poses of a Taylor motion are right: the true error of every order.

The true error is the distance of a prediction from the pose that closes the loops. Poses on
a straight line are followed step by step from the reference pose, without the expansion.
Distances and errors are in radians and characteristic lengths, errors those of the joint that
is worst off. (After J. J. de Jong, PhD thesis, University of Twente, Figs. 4.1 to 4.3.)
"""

from __future__ import annotations

from itertools import islice
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.taylor_poses.prediction import Predictions, offset_of
from kinematics.closure.continuation import continue_along
from kinematics.taylor.monomials import monomial_powers
from kinematics.taylor.taylor_motion import TaylorMotion

__all__ = ["Curves", "error_curves"]

Array = NDArray[np.float64]

# Most lines and most rows of a path: further ones are left out.
LINES, ROWS = 6, 400
# Samples of a line, how far it goes in radii of convergence, and how far without a radius.
SAMPLES, FAR, WHOLE = 120, 1.4, 1.0


class Curves(NamedTuple):
    """Errors of all orders along one line or path.

    Attributes:
        title: what it leads along.
        axis: name of its abscissa.
        x: way from the reference pose, or along the path (N,).
        errors: true errors of order 1, 2, … (order, N).
        estimate: estimated error of the highest order (N,); NaN beyond the radius.
        beyond: intervals of x that are beyond the radius of convergence.
        closed: ends of x where the loops stop closing.
        target: the x of the pose that was asked for, or None.
    """

    title: str
    axis: str
    x: Array
    errors: Array
    estimate: Array
    beyond: tuple[tuple[float, float], ...]
    closed: tuple[float, ...] = ()
    target: float | None = None


def error_curves(found: Predictions) -> list[Curves]:
    """The error along the line or the path that was asked for, or along each coordinate."""
    motion = found.motion
    if found.line and found.poses[0].distance > 0.0:
        pose = found.poses[0]
        far = max(1.1 * pose.distance, _far(motion))
        ray = pose.y / motion.scales / pose.distance
        return [_line(motion, "straight to the target", ray, (far,), pose.distance)]
    if found.poses and not found.line:
        return [_path(found)]
    far = _far(motion)
    directions = np.eye(motion.scales.size)[:LINES]
    return [_line(motion, _along(motion, ray), ray, (-far, far)) for ray in directions]


def _far(motion: TaylorMotion) -> float:
    """How far a line goes."""
    return FAR * motion.radius if np.isfinite(motion.radius) else WHOLE


def _along(motion: TaylorMotion, ray: Array) -> str:
    """The inputs that move in a direction of the coordinates."""
    moved = motion.motion.basis @ ray != 0.0
    names = [name for name, used in zip(motion.motion.inputs, moved, strict=True) if used]
    return f"along {' and '.join(names)}"


def _line(
    motion: TaylorMotion, title: str, ray: Array, ends: tuple[float, ...],
    target: float | None = None,
) -> Curves:  # fmt: skip
    """Errors along a ray in units of the radius, from the reference pose to its ends."""
    ways = [_walked(motion, np.sign(end) * ray, abs(end)) for end in ends]
    closed = tuple(
        float(np.sign(end) * s[-1]) for end, (s, _) in zip(ends, ways, strict=True)
        if s[-1] < (1.0 - 1e-9) * abs(end)
    )  # fmt: skip
    sides = [np.sign(end) * s for end, (s, _) in zip(ends, ways, strict=True)]
    x, order = np.unique(np.concatenate(sides), return_index=True)
    q = np.concatenate([q for _, q in ways])[order]
    points = x[:, None] * ray * motion.scales
    first, last = min(*ends, 0.0), max(*ends, 0.0)
    outside = [(first, -motion.radius), (motion.radius, last)]
    beyond = tuple(pair for pair in outside if pair[0] < pair[1])
    errors, estimate = _errors(motion, points, q), motion.error(points)
    return Curves(title, "distance", x, errors, estimate, beyond, closed, target)


def _walked(motion: TaylorMotion, ray: Array, far: float) -> tuple[Array, Array]:
    """Distances (N,) and joint positions (N, n) of closed poses along a ray.

    Poses crowd before a singularity, where the way ends.
    """
    chain = motion.chain
    rates = chain.columns @ ray
    way = continue_along(chain, ray, longest_step=far / SAMPLES)
    s, q = [0.0], [np.zeros(len(motion.joints))]
    for pose in islice(way, 2 * SAMPLES):
        done = float(pose.q @ rates / (rates @ rates))
        if done > (1.0 + 1e-9) * far:
            break
        s.append(done)
        q.append(np.zeros(len(motion.joints)))
        q[-1][chain.joints] = pose.q * chain.units
    return np.array(s), np.array(q)


def _path(found: Predictions) -> Curves:
    """Errors along a path, at its rows; where there is no closed pose is a gap."""
    motion = found.motion
    poses = found.poses[:: -(-len(found.poses) // ROWS)]
    points = np.array([pose.y for pose in poses])
    steps = np.linalg.norm(np.diff(points, axis=0) / motion.scales, axis=1)
    x = np.concatenate([[0.0], np.cumsum(steps)])
    gap = np.full(len(motion.joints), np.nan)
    q = np.array([gap if pose.corrected is None else pose.corrected for pose in poses])
    estimate = np.array([np.nan if pose.error is None else pose.error for pose in poses])
    outside = np.array([pose.distance > motion.radius for pose in poses])
    title, axis = "along the path", "way along the path"
    return Curves(title, axis, x, _errors(motion, points, q), estimate, _spans(x, outside))


def _spans(x: Array, outside: NDArray[np.bool_]) -> tuple[tuple[float, float], ...]:
    """Intervals of x in which a condition holds; they end halfway to where it does not."""
    between = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2.0, x[-1:]])
    edges = np.flatnonzero(np.diff(np.concatenate([[False], outside, [False]])))
    return tuple((float(between[a]), float(between[b])) for a, b in edges.reshape(-1, 2))


def _errors(motion: TaylorMotion, points: Array, q: Array) -> Array:
    """True errors of every order from 1 on at points (N, w) with closed poses q (N, n).

    Sums that are too large to be numbers have none.
    """
    degree, sums, found = motion.exponents.sum(axis=1), np.zeros_like(q), []
    with np.errstate(over="ignore", invalid="ignore"):
        terms = monomial_powers(motion.exponents, points)
        for k in range(1, motion.order + 1):
            sums = sums + terms[:, degree == k] @ motion.coefficients[degree == k]
            found.append(offset_of(motion, sums, q))
    return np.array(found)
