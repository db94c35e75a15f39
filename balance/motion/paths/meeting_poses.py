"""Poses near a given one in which several paths meet, by Newton's method.

Let k be the dimension of the null space in general. Several paths meet where it is larger: the
block of A between its smallest left and right singular vectors vanishes there,

    U_0ᵀ A(y) V_0 = 0,    V_0 the last k + 1 right, U_0 the left ones beyond the rank w - k - 1,

and so does its first-order change ``U_0ᵀ ∂A V_0`` with the step that the method takes, the one
of least norm.
"""

from __future__ import annotations

import numpy as np

from balance.motion.motion_tolerances import MOMENTUM_NULL
from balance.motion.paths.rest_equations import RestEquations, RowsAtPose
from kinematics.errors import PoseError
from kinematics.numerics.array_types import Array

# Most Newton steps, and the longest one, radians and characteristic lengths.
STEPS = 25
LONGEST = 0.2
# Singular values of the system below this part of the largest count as zero.
RCOND = 1e-7


def meeting_pose(
    equations: RestEquations, start: RowsAtPose, generic: int, reach: float
) -> tuple[RowsAtPose, float] | None:
    """Find the nearest pose in which the null space is larger than in general.

    Args:
        equations: the equations of the linkage.
        start: the pose from which to look.
        generic: dimension of the null space in general, at least 1.
        reach: largest distance, radians and characteristic lengths.

    Returns:
        The equations in that pose, and its distance in the coordinates; None if there is none.
    """
    here, gone = start, np.zeros(equations.width)
    for _ in range(STEPS):
        F, J = _block(equations, here, generic + 1)
        if F.size == 0:
            return None
        step = np.asarray(np.linalg.lstsq(J, -F, rcond=RCOND)[0], np.float64)
        size = float(np.linalg.norm(step))
        arrived = np.abs(F).max() <= MOMENTUM_NULL * 1e-3 * here.scale
        if arrived and size <= 1e-9:
            return here, float(np.linalg.norm(gone))
        step *= min(1.0, LONGEST / max(size, 1e-300))
        try:
            here = equations.at(equations.move(here, step))
        except PoseError:
            return None
        gone = np.asarray(gone + step)
        if np.linalg.norm(gone) > reach:
            return None
    return None


def _block(equations: RestEquations, here: RowsAtPose, null: int) -> tuple[Array, Array]:
    """Compute the block that vanishes, and its derivative along the coordinates."""
    U, _, Vt = np.linalg.svd(here.rows, full_matrices=True)
    rank = equations.width - null
    if rank < 0:
        return np.empty(0), np.empty((0, equations.width))
    left, right = U[:, rank:], Vt[rank:].T
    F = left.T @ here.rows @ right
    J = np.einsum("rl,ria,ap->lpi", left, equations.derivative(here.q), right)
    return F.ravel(), J.reshape(-1, equations.width)
