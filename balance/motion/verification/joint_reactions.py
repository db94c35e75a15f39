"""Joint reaction wrenches of a closed linkage that is driven at its inputs.

Each link obeys ``ḣ = Σ wrenches on it``. The wrench W_j in the joints of the opened linkage
follows from the links that it carries. The weld of loop l adds λ_l. With σ_jl = ±1 on the two
paths from the ground to the weld,

    w_j = W_j - Σ_l σ_jl λ_l        s_j·w_j = Σ_g m_gj μ_g   for every joint without a motor

or ``Aᵀ [λ; μ] = s·W`` with the loop matrix A of the dependent joints and the forces μ of
mimic relations. An overconstrained linkage, such as every planar one with six components,
does not determine all of λ: it depends on elasticity and on preload, ``λ = λ_0 + N y`` with the
null space N of Aᵀ. The y of least ``Σ_j |w_j|²`` over all joints is used, with moments about
the middle of the mechanism, in characteristic lengths: it does not depend on where loops are
cut.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import PRELOAD_ROUND_OFF
from balance.motion.verification.shaking_wrench import Loads
from kinematics.model.arrays import Chain
from kinematics.model.chain import loop_signs
from kinematics.numerics.array_types import Array, Flags

# Samples at once: the matrices of all of them would fill the memory.
BLOCK = 64


class JointReactions(NamedTuple):
    """Joint wrenches along a motion, in the frame and units of a spatial chain.

    They are linear in the loads. If the loads have more axes, all arrays have them too.

    Attributes:
        joints: wrench of each joint on the link that it carries (N, n, 6).
        welds: wrench of each loop's successor on its end (N, loops, 6).
        motors: forces or torques of the joints (N, n), zero except at the inputs.
        open: number of components of the weld wrenches that rigid bodies do not determine.
        least: least force of each joint under any preload (N, n, …), if the loads have no more
            axes; else empty.
        preloaded: whether preload changes the force of a joint, without limit (n,).
    """

    joints: Array
    welds: Array
    motors: Array
    open: int
    least: Array
    preloaded: Flags


def joint_reactions(chain: Chain, loads: Loads) -> JointReactions:
    """Compute the reaction wrenches of all joints, with motors at the inputs only.

    Args:
        chain: all joints of a spatial chain, from
            `kinematics.closure.joint_positions.input_chain`.
        loads: from `balance.motion.verification.shaking_wrench.inertia_loads`; the rates may
            have more axes (N, bodies, 6, …).

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
    open_rows = A.shape[1] - chain.dependent.size
    if chain.dependent.size == 0:
        welds = np.zeros((samples, loops, 6, *more))
        return _with_range(wrenches, welds, torque, 0, np.zeros((samples, n, 6, 0)))
    torques = torque[:, chain.dependent].reshape(samples, chain.dependent.size, -1)
    flat = wrenches.reshape(samples, 6 * n, -1)
    least, null = np.empty((samples, A.shape[1], flat.shape[2])), []
    for k in range(0, samples, BLOCK):
        block = slice(k, k + BLOCK)
        least[block], effect = _least_norm(
            A[block][:, :, chain.dependent], torques[block], flat[block], signs
        )
        null.append(effect)
    least = least.reshape(samples, -1, *more)
    welds = least[:, : 6 * loops].reshape(samples, loops, 6, *more)
    joints = wrenches - np.einsum("lj,tli...->tji...", signs, welds)
    motors = torque - np.einsum("trj,tr...->tj...", A, least)
    motors[:, chain.dependent] = 0.0
    return _with_range(joints, welds, motors, open_rows, np.concatenate(null))


def _least_norm(A: Array, torques: Array, wrenches: Array, signs: Array) -> tuple[Array, Array]:
    """Solve ``Aᵀ x = torques`` with the least sum of squares of all joint wrenches.

    Args:
        A: loop matrix of the dependent joints (N, rows, dependent).
        torques: right sides (N, dependent, columns).
        wrenches: wrenches in the joints of the opened linkage (N, 6 n, columns).
        signs: of the joints on the paths to the welds (loops, n).

    Returns:
        The solution (N, rows, columns), and the joint wrenches per unit of preload
        (N, n, 6, open).
    """
    samples, rows, rank = A.shape
    Q, triangle = np.linalg.qr(A, mode="complete")
    x = Q[:, :, :rank] @ np.linalg.solve(triangle[:, :rank].transpose(0, 2, 1), torques)
    loops, n = signs.shape
    null = Q[:, :, rank:]
    effect = -np.einsum(
        "lj,tlio->tjio", signs, null[:, : 6 * loops].reshape(samples, loops, 6, rows - rank)
    )
    if rows == rank:
        return x, effect
    carried = np.einsum(
        "lj,tlic->tjic", signs, x[:, : 6 * loops].reshape(samples, loops, 6, -1)
    )
    held = wrenches - carried.reshape(samples, 6 * n, -1)
    U, size, Vt = np.linalg.svd(effect.reshape(samples, 6 * n, -1), full_matrices=False)
    inverse = np.where(size > PRELOAD_ROUND_OFF, 1.0 / np.maximum(size, PRELOAD_ROUND_OFF), 0.0)
    preload = Vt.transpose(0, 2, 1) @ (inverse[:, :, None] * (U.transpose(0, 2, 1) @ held))
    return x - null @ preload, effect


def _with_range(
    joints: Array, welds: Array, motors: Array, rows: int, effect: Array
) -> JointReactions:
    """Complete reactions by what preload can do to the forces of the joints.

    Args:
        joints: wrenches of the joints (N, n, 6, …).
        welds: wrenches of the welds (N, loops, 6, …).
        motors: forces or torques (N, n, …).
        rows: number of components that rigid bodies do not determine.
        effect: joint wrenches per unit of preload (N, n, 6, rows).
    """
    forces = effect[:, :, 3:]
    preloaded = np.linalg.norm(forces, axis=(2, 3)).max(axis=0, initial=0.0)
    preloaded = preloaded > PRELOAD_ROUND_OFF
    if joints.ndim > 3:
        return JointReactions(joints, welds, motors, rows, np.empty(0), preloaded)
    remainder = joints[..., 3:]
    if rows and preloaded.any():
        U, size, _ = np.linalg.svd(forces, full_matrices=False)
        U = U * (size > PRELOAD_ROUND_OFF)[:, :, None]
        remainder = remainder - np.einsum("tjio,tjko,tjk->tji", U, U, remainder)
    least = np.linalg.norm(remainder, axis=2)
    return JointReactions(joints, welds, motors, rows, least, preloaded)
