"""Planar linkages: the plane in which every link moves, and the chain reduced to it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinematics.model.arrays import Chain, freeze
from kinematics.model.chain import lock_joints
from kinematics.numerics.array_types import Array, Flags
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.linalg.vectors import cross_products, project_out
from kinematics.numerics.tolerances import PLANAR_DEVIATION


def plane_normal(chain: Chain, tolerance: float = PLANAR_DEVIATION) -> Array | None:
    """Find the normal of the plane in which every link moves; None if there is none.

    All axes of rotation must be parallel to it, all translations perpendicular to it.

    Args:
        chain: the linkage as arrays, spatial.
        tolerance: largest deviation: sine of an angle, or length in chain units.

    Returns:
        Unit vector (3,) in the axes of the chain, its largest component positive.
    """
    turning = chain.screws[np.any(chain.screws[:, :3] != 0.0, axis=1)]
    sliding = chain.screws[np.all(chain.screws[:, :3] == 0.0, axis=1), 3:]
    if len(turning):
        n = turning[0, :3]
    elif len(sliding):
        n = np.linalg.svd(sliding)[2][-1]
        if np.linalg.matrix_rank(sliding, tol=tolerance) == 1:
            candidates = np.eye(3) - np.outer(sliding[0], sliding[0])
            n = candidates[2] if abs(sliding[0, 2]) < 0.9 else candidates[0]
            n = n / np.linalg.norm(n)
    else:
        return None
    n = n * np.sign(n[first_largest(np.abs(n))])
    along = np.abs(np.sum(turning[:, :3] * turning[:, 3:], axis=1))
    off_axis = np.linalg.norm(cross_products(turning[:, :3], n), axis=1)
    out_of_plane = np.abs(sliding @ n)
    worst = max(a.max(initial=0.0) for a in (along, off_axis, out_of_plane))
    return n if worst <= tolerance else None


def plane_axes(normal: Array) -> Array:
    """Compute right-handed axes, as rows, of which the last is the normal (3,); shape (3, 3).

    The first is the axis that comes after the one nearest the normal in the cycle x, y, z,
    made perpendicular to the normal.
    """
    helper = np.eye(3)[(first_largest(np.abs(normal)) + 1) % 3]
    x = project_out(helper, normal)
    x /= np.linalg.norm(x)
    return np.array([x, cross_products(normal, x), normal])


def flatten(chain: Chain, normal: Array) -> Chain:
    """Reduce a chain to its plane: axes are turned so that the last one is the normal.

    Args:
        chain: the linkage as arrays, spatial.
        normal: unit normal of the plane (3,), in the axes of the chain.

    Returns:
        The chain with screws ``[ω; v_x; v_y]`` (n, 3).
    """
    R = plane_axes(normal)
    turned = np.concatenate([chain.screws[:, :3] @ R.T, chain.screws[:, 3:] @ R.T], axis=1)
    turned[:, 2] = np.rint(turned[:, 2])
    frame = replace(chain.frame, R=freeze(R))
    return replace(chain, frame=frame, screws=freeze(turned[:, 2:5]))


def reduce_to_plane(
    chain: Chain, idle: Flags, whole: Array | None = None
) -> tuple[Chain, Chain]:
    """Remove idle joints from a chain, and reduce it to its plane if it moves in one.

    Args:
        chain: the linkage as arrays, spatial.
        idle: whether each joint is idle (n,).
        whole: normal of the plane of all its joints, if they have one and it is known.

    Returns:
        The spatial chain without the idle joints, and the planar one; the spatial one twice if
        it does not move in a plane.
    """
    reduced = lock_joints(chain, idle)
    normal = plane_normal(reduced) if whole is None or idle.any() else whole
    return reduced, reduced if normal is None else flatten(reduced, normal)
