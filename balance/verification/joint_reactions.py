"""Joint reaction wrenches of a closed linkage that is driven at its inputs.

Each link obeys ``ḣ = Σ wrenches on it``. The wrench W_j in the joints of the opened linkage
follows from the links that it carries. The weld of loop l adds λ_l. With σ_jl = ±1 on the two
paths from the ground to the weld,

    w_j = W_j - Σ_l σ_jl λ_l        s_j·w_j = Σ_g m_gj μ_g   for every joint without a motor

or ``Aᵀ [λ; μ] = s·W`` with the loop matrix A of the dependent joints and the forces μ of
mimic relations. An overconstrained linkage, such as every planar one with six components,
does not determine all of λ: it depends on elasticity. The solution of least norm is used, with
moments about the middle of the mechanism, in characteristic lengths.
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

    They are linear in the loads. If the loads have more axes, all arrays have them too.

    Attributes:
        joints: wrench of each joint on the link that it carries (N, n, 6).
        welds: wrench of each loop's successor on its end (N, loops, 6).
        motors: forces or torques of the joints (N, n), zero except at the inputs.
        open: number of components of the weld wrenches that rigid bodies do not determine.
    """

    joints: Array
    welds: Array
    motors: Array
    open: int


def joint_reactions(chain: Chain, loads: Loads) -> JointReactions:
    """Compute the reaction wrenches of all joints, with motors at the inputs only.

    Args:
        chain: all joints of a spatial chain, from
            `kinematics.closure.joint_positions.input_chain`.
        loads: from `balance.verification.shaking_wrench.inertia_loads`; the rates may have
            more axes (N, bodies, 6, …).

    Returns:
        The wrenches, about the origin of the chain, in its units.
    """
    samples, n = loads.screws.shape[:2]
    more = loads.rate.shape[3:]
    wrenches = np.zeros((samples, n, 6, *more))
    for body, link in enumerate(chain.links.tolist()):
        if link >= 0:
            wrenches[:, link] += loads.rate[:, body]
    for j in range(n - 1, -1, -1):
        if chain.parent[j] >= 0:
            wrenches[:, chain.parent[j]] += wrenches[:, j]
    signs, loops = loop_signs(chain.parent, chain.ends), len(chain.ends)
    torque = np.einsum("tji,tji...->tj...", loads.screws, wrenches)
    A = np.einsum("lj,tji->tlij", signs, loads.screws).reshape(samples, 6 * loops, n)
    mimics = np.broadcast_to(chain.mimics, (samples, *chain.mimics.shape))
    A = np.concatenate([A, mimics], axis=1)
    if chain.dependent.size == 0:
        return JointReactions(wrenches, np.zeros((samples, loops, 6, *more)), torque, 0)
    Q, R = np.linalg.qr(A[:, :, chain.dependent])
    right = torque[:, chain.dependent].reshape(samples, chain.dependent.size, -1)
    least = (Q @ np.linalg.solve(R.transpose(0, 2, 1), right)).reshape(samples, -1, *more)
    welds = least[:, : 6 * loops].reshape(samples, loops, 6, *more)
    joints = wrenches - np.einsum("lj,tli...->tji...", signs, welds)
    motors = torque - np.einsum("trj,tr...->tj...", A, least)
    motors[:, chain.dependent] = 0.0
    return JointReactions(joints, welds, motors, A.shape[1] - chain.dependent.size)
