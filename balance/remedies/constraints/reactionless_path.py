"""Reactionless paths: curves of the inputs along which the total momentum vanishes.

With the momentum ``h_w = X_w(u) z`` of unit rates, a direction d is reactionless if
``Σ_w d_w h_w = 0``. A path follows the null space of that matrix from the reference pose.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.momentum.regressor import momentum_regressor
from balance.tolerances import REACTIONLESS_RELATIVE
from kinematics.errors import PoseError
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion

__all__ = ["ReactionlessPath", "reactionless_path"]

Array = NDArray[np.float64]

# Largest length of the path on either side of the reference pose, radians or metres.
HALF_LENGTH = 0.5
# Length between points: in the range in which neither the spline through them nor the
# rounding of second differences is seen.
STEP = 0.01
# Tolerance of the integration.
INTEGRATION = 1e-13
# Cosine between a direction and the one it is chosen by: below this the path ends.
LEAST_COSINE = 0.5
# Largest curvature of a path, per radian: it is more near singular poses.
SHARPEST = 2.0
# Step of differences of the direction.
NEAR = 1e-3
# Fewest points of a path.
FEWEST_POINTS = 20


class ReactionlessPath(NamedTuple):
    """A curve of the inputs through the reference pose.

    Attributes:
        length: length along the curve from its beginning (N,).
        u: displacements of the inputs there (N, mobility), SI units.
        rates: their derivatives by the length.
        bends: their second derivatives.
        choices: dimension of the reactionless directions.
    """

    length: Array
    u: Array
    rates: Array
    bends: Array
    choices: int


def reactionless_path(
    linkage: Linkage, motion: Motion, force: bool = False
) -> ReactionlessPath | None:
    """Integrate a reactionless path from the reference pose, in both directions.

    Where several directions are reactionless, the path follows the one nearest to a constant
    direction: that which is nearest to a unit rate of one coordinate at the reference pose.

    Args:
        linkage: an assembled linkage, with its masses.
        motion: relations between its inputs.
        force: whether the linear momentum alone must vanish.

    Returns:
        The path, until half a radian on either side or a pose near a singularity; None if
        every direction has momentum.
    """
    first = _null_space(linkage, motion, np.zeros(motion.basis.shape[1]), force)
    if not first.shape[1]:
        return None
    start = first @ first[np.argmax(np.linalg.norm(first, axis=1))]
    start /= np.linalg.norm(start)
    choices = first.shape[1]
    back, on = (_follow(linkage, motion, force, choices, x) for x in (-start, start))
    y, d, bends = (
        np.concatenate([sign * b[:0:-1], a])
        for b, a, sign in zip(back, on, (1.0, -1.0, 1.0), strict=True)
    )
    if len(y) < FEWEST_POINTS:
        return None
    length = np.arange(len(y), dtype=np.float64) * STEP
    across = motion.basis.T
    return ReactionlessPath(length, y @ across, d @ across, bends @ across, choices)


def _follow(
    linkage: Linkage, motion: Motion, force: bool, choices: int, start: Array
) -> tuple[Array, Array, Array]:
    """Integrate one side: displacements of the free coordinates, and two derivatives."""
    from scipy.integrate import solve_ivp

    found, directions = [np.zeros(len(start))], [start]

    def slope(_: float, y: Array) -> Array:
        along = directions[-1] if choices == 1 else start
        return _direction(linkage, motion, force, y, along)

    bends = [_bend(slope, found[0])]
    for _ in range(round(HALF_LENGTH / STEP)):
        try:
            solved = solve_ivp(
                slope, (0.0, STEP), found[-1], "DOP853", first_step=STEP,
                rtol=INTEGRATION, atol=INTEGRATION,
            )  # fmt: skip
            direction = slope(0.0, solved.y[:, -1])
            bend = _bend(slope, solved.y[:, -1])
        except PoseError:
            break
        if np.linalg.norm(bend) > SHARPEST:
            break
        found.append(solved.y[:, -1])
        directions.append(direction)
        bends.append(bend)
    return np.array(found), np.array(directions), np.array(bends)


def _bend(slope: Callable[[float, Array], Array], y: Array) -> Array:
    """Differentiate the direction along the path, by central differences of fourth order."""
    d = slope(0.0, y)
    near, far = (slope(0.0, y + h * d) - slope(0.0, y - h * d) for h in (NEAR, 2.0 * NEAR))
    return (8.0 * near - far) / (12.0 * NEAR)


def _direction(linkage: Linkage, motion: Motion, force: bool, y: Array, along: Array) -> Array:
    """Find the unit reactionless direction nearest to a given one.

    Raises:
        PoseError: the loops do not close there, or no direction is near.
    """
    null = _null_space(linkage, motion, y, force)
    found = null @ (null.T @ along)
    size = float(np.linalg.norm(found))
    if size < LEAST_COSINE:
        raise PoseError(f"{linkage.source}: the reactionless path ends")
    return found / size


def _null_space(linkage: Linkage, motion: Motion, y: Array, force: bool) -> Array:
    """Basis of the reactionless rates of the free coordinates (coordinates, dimension)."""
    z = np.array([body.inertia for body in linkage.bodies])
    X = momentum_regressor(linkage, motion.basis @ y, spatial=True)
    parts = np.einsum("wrbp,bp->wrb", X.reshape(*X.shape[:2], *z.shape), z)
    parts = np.einsum("wrb,wk->krb", parts, motion.basis)[:, 3 if force else 0 :]
    _, sizes, right = np.linalg.svd(parts.sum(axis=2).T)
    own = np.linalg.norm(parts, axis=(0, 1)).sum()
    rank = int((sizes > REACTIONLESS_RELATIVE * own).sum())
    return right[rank:].T
