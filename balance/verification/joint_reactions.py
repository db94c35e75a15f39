"""Wrenches in the joints of a closed linkage that is driven at its inputs.

Each link obeys ``ḣ = Σ wrenches on it``. The wrench W_j in the joints of the opened linkage
follows from the links beyond; a weld that closes loop l adds λ_l, and with σ_jl = ±1 on the
two ways from the ground to the weld

    w_j = W_j - Σ_l σ_jl λ_l        s_j·w_j = Σ_g m_gj μ_g   for every joint without a motor

or ``Aᵀ [λ; μ] = s·W`` with the loop matrix A of the dependent joints and the forces μ of
mimic relations. In an overconstrained linkage, and that is every planar one with its six
components, this leaves part of λ open: elasticity would decide. Here the solution of least
norm is taken, moments about the middle of the mechanism and in characteristic lengths.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.verification.shaking_wrench import Loads
from kinematics.model.arrays import Chain
from kinematics.model.chain import loop_signs

__all__ = ["JointReactions", "joint_reactions"]

Array = NDArray[np.float64]


class JointReactions(NamedTuple):
    """Joint wrenches along a motion, in the frame and units of a spatial chain.

    Attributes:
        joints: wrench of each joint on the link that it carries (N, n, 6).
        welds: wrench of each loop's successor on its end (N, loops, 6).
        motors: forces or torques of the joints, zero but for the inputs (N, n).
        open: components of the weld wrenches that rigid bodies leave undetermined.
    """

    joints: Array
    welds: Array
    motors: Array
    open: int


def joint_reactions(chain: Chain, loads: Loads) -> JointReactions:
    """Wrenches in all joints, with motors at the inputs only.

    Args:
        chain: all joints of a spatial chain; see
        `kinematics.closure.joint_positions.input_chain`.
        loads: what `balance.verification.shaking_wrench.inertia_loads` gives.
    """
    samples, n = loads.screws.shape[:2]
    wrenches = np.zeros((samples, n, 6))
    for body, link in enumerate(chain.links.tolist()):
        if link >= 0:
            wrenches[:, link] += loads.rate[:, body]
    for j in range(n - 1, -1, -1):
        if chain.parent[j] >= 0:
            wrenches[:, chain.parent[j]] += wrenches[:, j]
    ways, loops = loop_signs(chain.parent, chain.ends), len(chain.ends)
    torque = np.einsum("tji,tji->tj", loads.screws, wrenches)
    A = np.einsum("lj,tji->tlij", ways, loads.screws).reshape(samples, 6 * loops, n)
    mimics = np.broadcast_to(chain.mimics, (samples, *chain.mimics.shape))
    A = np.concatenate([A, mimics], axis=1)
    if chain.dependent.size == 0:
        return JointReactions(wrenches, np.zeros((samples, loops, 6)), torque, 0)
    Q, R = np.linalg.qr(A[:, :, chain.dependent])
    right = torque[:, chain.dependent, None]
    least = (Q @ np.linalg.solve(R.transpose(0, 2, 1), right))[..., 0]
    welds = least[:, : 6 * loops].reshape(samples, loops, 6)
    joints = wrenches - np.einsum("lj,tli->tji", ways, welds)
    motors = torque - np.einsum("trj,tr->tj", A, least)
    motors[:, chain.dependent] = 0.0
    return JointReactions(joints, welds, motors, A.shape[1] - chain.dependent.size)
