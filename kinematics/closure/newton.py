"""Closed finite poses by Newton's method, and steps to further poses along a ray.

``q ← q - S_0⁺ b(q)`` on the dependent joints, with the closure residual b and the loop matrix
S_0 at the pose.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.closure.newton_kernels import (
    MAX_NEWTON_STEPS,
    fill_closure_residual,
    follow_series,
    newton_workspace,
    solve_closure,
)
from kinematics.closure.series import Series, expand_from
from kinematics.model.arrays import Chain
from kinematics.model.spatial.displacements import place_links
from kinematics.numerics.array_types import Array


class Pose(NamedTuple):
    """A finite pose, in the frame and units of the chain.

    Attributes:
        q: joint positions (n,).
        H: displacements of the links (n, 4, 4), or (n, 3, 3) if planar.
        screws: joint screws at this pose (n, 6 or 3).
        error: size of the closure residual, in radians and units of the chain.
    """

    q: Array
    H: Array
    screws: Array
    error: float


def expand_at(chain: Chain, pose: Pose) -> Series:
    """Expand the motion to order 0 at a finite pose: joint rates and link twists there.

    Args:
        chain: the linkage at its reference pose.
        pose: a closed pose of it.

    Returns:
        Series of order 0 for unit rates of the coordinates, in the units of the chain.
    """
    return expand_from(chain, pose.screws, np.zeros((1, chain.width)), 0)


def radius_of_convergence(rates: Array) -> float:
    """Estimate the radius of convergence of a series from the growth of its joint rates.

    ``1 / max(1, |q̇_0|, (|q̇_k| / |q̇_0|)^(1/k))``: at most 1, and such that no joint moves by
    more than 1 to first order.

    Args:
        rates: joint rates along a ray by order (order + 1, n), chain units.

    Returns:
        The radius, in steps of the ray.
    """
    sizes = np.sqrt(np.einsum("kj,kj->k", rates, rates))
    growth = (sizes[1:] / sizes[0]) ** (1.0 / np.arange(1, sizes.size))
    return float(1.0 / max(1.0, sizes[0], *growth))


def follow_ray(
    chain: Chain, start: Array, series: Series, ray: Array, longest_step: float = np.inf
) -> tuple[Pose, float]:
    """Find a closed pose further along a ray, on the same branch.

    The step is the smaller of ``longest_step`` and 0.4 of the radius of convergence estimated
    from the series, whose sum is the first guess of Newton's method; it is halved until
    the method stays within a tenth of that guess.

    Args:
        chain: the linkage at its reference pose.
        start: joint positions from which to start (n,).
        series: the series there; its last ray is used.
        ray: the direction of that ray (w,).
        longest_step: in the parameter of the ray.

    Returns:
        The pose and the length of the step, 0 if none was found.
    """
    H, screws = _make_pose_arrays(chain)
    q, C = np.empty(start.size), series.C[-1]
    step = follow_series(
        chain.walked,
        start,
        C,
        np.array(ray, dtype=np.float64),  # writable, as in kernels that call this one
        longest_step,
        q,
        H,
        screws,
        newton_workspace(chain, len(C)),
    )
    screws.flags.writeable = False
    return Pose(q, H, screws, 0.0), step


def solve_positions(
    chain: Chain, start: Array, steps: int = MAX_NEWTON_STEPS
) -> tuple[Array, float]:
    """Close the loops by Newton's method on the dependent joints.

    Args:
        chain: the linkage at its reference pose.
        start: joint positions from which to start (n,).
        steps: how many to take at most.

    Returns:
        Joint positions (n,), and how far the loops were open when last looked at.
    """
    q = np.array(start, dtype=np.float64)
    error = solve_closure(
        chain.walked, q, *_make_pose_arrays(chain), steps, newton_workspace(chain)
    )
    return q, float(error)


def _make_pose_arrays(chain: Chain) -> tuple[Array, Array]:
    """Make arrays for the displacements and the screws of a pose."""
    m = 3 if chain.planar else 4
    return np.empty((chain.parent.size, m, m)), np.empty(chain.screws.shape)


def forward_kinematics(chain: Chain, q: Array) -> Pose:
    """Compute the pose at joint positions, whether or not it closes the loops.

    ``H_j = H_parent exp(q_j ŝ_j)``, the product of exponentials of R. W. Brockett (1984).

    Args:
        chain: the linkage at its reference pose.
        q: joint positions (n,), chain units.

    Returns:
        The pose; its ``error`` is how far the loops are open.
    """
    H, screws = _make_pose_arrays(chain)
    place_links(chain.parent, chain.screws, q, H, screws, np.empty(H.shape[1:]))
    screws.flags.writeable = False
    error = closure_residual(chain, H, q)
    return Pose(q, H, screws, float(np.sqrt(error @ error)))


def closure_residual(chain: Chain, H: Array, q: Array, gaps: Array | None = None) -> Array:
    """Compute the twists by which the loops are open, then the errors of mimic relations.

    Args:
        chain: the linkage as arrays.
        H: displacements of the links (n, 4, 4), or (n, 3, 3) in the plane.
        q: joint positions (n,).
        gaps: displacements of the welds at the reference pose (loops, 4, 4), if they are not
            closed.

    Returns:
        Residual of the loops (rows,), radians and chain units.
    """
    dim = chain.screws.shape[1]
    b = np.empty(len(chain.ends) * dim + len(chain.mimics))
    scratch = np.empty((4, *H.shape[1:]))
    fill_closure_residual(H, chain.ends, H[:0] if gaps is None else gaps, b, dim, scratch)
    b[len(chain.ends) * dim :] = chain.mimics @ q
    return b
