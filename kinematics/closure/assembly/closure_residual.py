"""The closure residual of a component at a pose, and Newton's method that closes its loops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinematics.closure.mobility.components import Component
from kinematics.closure.mobility.first_order import closure_equations
from kinematics.closure.newton import Pose, forward_kinematics
from kinematics.model.arrays import Chain
from kinematics.model.chain import paths
from kinematics.model.spatial.screws import hat
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.gauss_newton import Iterate, LeastNorm, gauss_newton, step_grows
from kinematics.numerics.tolerances import CLOSING_STEP_RELATIVE, CLOSURE_RESIDUAL


def weld_gaps(part: Component) -> Array:
    """Compute displacements of the welds of a component in its coordinates; (loops, 4, 4)."""
    gaps = [_to_chain_frame(part.chain, loop.gap) for loop in part.draft.loops]
    return np.reshape(gaps, (-1, 4, 4))


def minimise_residual(chain: Chain, gaps: Array, start: Array) -> Array:
    """Find joint positions near ``start`` that leave the loops open as little as possible.

    Args:
        chain: the component as arrays.
        gaps: displacements of its welds at the reference pose (loops, 4, 4).
        start: joint positions (n,), chain units.
    """
    from scipy.optimize import least_squares

    before = paths(chain.parent)
    q: Array = least_squares(
        lambda q: displacement_residual(chain, gaps, forward_kinematics(chain, q)),
        start,
        lambda q: _residual_jacobian(chain, gaps, before, forward_kinematics(chain, q)),
        max_nfev=200,
    ).x
    return q


def newton_closure(chain: Chain, gaps: Array, q: Array) -> Array | None:
    """Close the loops by Newton steps of least norm, as long as they shrink; None if they fail.

    One more step follows after the loops are closed, so that they are closed to round-off.

    Args:
        chain: the component as arrays.
        gaps: displacements of its welds at the reference pose (loops, 4, 4).
        q: joint positions from which to start (n,), chain units.
    """

    def closed(path: Sequence[Iterate]) -> bool:
        pose = forward_kinematics(chain, path[-1].x)
        residual = float(np.abs(displacement_residual(chain, gaps, pose)).max())
        return residual <= CLOSURE_RESIDUAL and (
            len(path) == 1 or path[-2].size <= CLOSURE_RESIDUAL
        )

    equations, rule = closure_equations(chain, gaps), LeastNorm(CLOSING_STEP_RELATIVE)
    last, solved = gauss_newton(equations, q, rule, closed, step_grows(0.5), 10)
    return last.x if solved else None


def displacement_residual(chain: Chain, gaps: Array, pose: Pose) -> Array:
    """Compute the entries of ``D - 1`` for every loop, then the errors of mimic joints.

    D carries the successor side of the weld to its end side. Unlike the twist of D, the entries
    vanish at no other pose than a closed one, not even where D is half a turn.

    Args:
        chain: the component as arrays.
        gaps: displacements of its welds at the reference pose (loops, 4, 4).
    """
    D = _weld_displacements(chain, gaps, pose)
    return np.concatenate([(D - np.eye(4))[:, :3].ravel(), chain.mimics @ pose.q])


def _residual_jacobian(chain: Chain, gaps: Array, before: Array, pose: Pose) -> Array:
    """Compute derivatives of the residual by joint position: ``s D`` to the end, less ``D s``.

    Args:
        chain: the linkage as arrays.
        gaps: displacements of the welds at the reference pose (loops, 4, 4).
        before: that of `kinematics.model.chain.paths`.
    """
    D, s = _weld_displacements(chain, gaps, pose)[:, None], hat(pose.screws)
    ends, successors = (before[side][..., None, None] for side in chain.ends.T)
    entries = (ends * (s @ D) - successors * (D @ s))[..., :3, :]
    return np.concatenate([entries.transpose(0, 2, 3, 1).reshape(-1, len(s)), chain.mimics])


def _weld_displacements(chain: Chain, gaps: Array, pose: Pose) -> Array:
    """Compute displacements D of every loop, from its successor side to its end side."""
    padded = np.concatenate([pose.H, np.eye(4)[None]])  # link -1 is the ground
    ends, successors = padded[chain.ends[:, 0]], padded[chain.ends[:, 1]]
    D: Array = ends @ np.linalg.inv(gaps) @ np.linalg.inv(successors)
    return D


def _to_chain_frame(chain: Chain, H: Array) -> Array:
    """Convert a displacement of inertial space to the coordinates of the chain."""
    out, o = H.copy(), chain.frame.origin
    out[:3, 3] = (H[:3, :3] @ o + H[:3, 3] - o) / chain.frame.length
    return out
