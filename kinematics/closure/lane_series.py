"""Power series of closed planar motions of many geometries side by side, one in each lane.

The recursion is that of `kinematics.closure.series`, for one coordinate and along its only ray,
so that twists of the column are those along the ray. The last axis of every array is that of
the lanes. Screws are ``[ω; v_x; v_y]``; their angular part is constant.
"""

from __future__ import annotations

from typing import NamedTuple

from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import broadcast, lanes, load_vector, store_vector
from kinematics.numerics.linalg.lane_loop_qr import (
    LoopFactor,
    factor_loops,
    loop_factor_workspace,
    solve_loops,
)
from kinematics.numerics.linalg.skyline_qr import COUNT, JOINT, ROW, ROWS


class LaneSeries(NamedTuple):
    """Series in lanes and their workspace.

    Attributes:
        S: screws (orders, n, 3, lanes).
        C: joint rates for a unit rate of the coordinate (orders, n, lanes).
        T: link twists (orders, n, 3, lanes).
        joint_twists: what joints add to twists, without the unknown rate (n, 2, lanes).
        residual: square of the largest closure residual (lanes,).
        factor: that of the loop matrices.
    """

    S: Array
    C: Array
    T: Array
    joint_twists: Array
    residual: Array
    factor: LoopFactor


def lane_series_workspace(chain: Chain, order: int) -> LaneSeries:
    """Allocate series in lanes.

    Args:
        chain: one of the linkages.
        order: the highest order.
    """
    n = chain.parent.size
    return LaneSeries(
        lanes(order + 1, n, 3),
        lanes(order + 1, n),
        lanes(order + 1, n, 3),
        lanes(n, 2),
        lanes(),
        loop_factor_workspace(chain.envelope, chain.dependent.size),
    )


@kernel(reference_counting=False)
def _carry_screws(k, parent, screws, S, T):
    """Compute order k of the joint screws: ``k s_k = Σ_{a<k} ad(V_parent,a) s_{k-1-a}``.

    Args:
        k: the order.
        parent: in; link before each joint (n,).
        screws: in; joint screws at the pose (n, 3, lanes).
        S: in, lower orders; out, order k.
        T: in; twists of lower orders.
    """
    part = broadcast(1.0 / max(k, 1))
    for j in range(parent.size):
        p = parent[j]
        if k == 0:
            for i in range(3):
                store_vector(S[0, j, i], 0, load_vector(screws[j, i], 0))
        elif p >= 0:
            turn = load_vector(S[0, j, 0], 0)
            x = load_vector(T[k - 1, p, 2], 0) * turn
            y = broadcast(0.0) - load_vector(T[k - 1, p, 1], 0) * turn
            for a in range(k):
                w = load_vector(T[a, p, 0], 0)
                x = x - w * load_vector(S[k - 1 - a, j, 2], 0)
                y = y + w * load_vector(S[k - 1 - a, j, 1], 0)
            store_vector(S[k, j, 1], 0, part * x)
            store_vector(S[k, j, 2], 0, part * y)


@kernel(reference_counting=False)
def _add_known_twists(k, chain, S, C, T, joint_twists):
    """Compute order k of the link twists without the unknown rates.

    Args:
        k: the order.
        chain: in; arrays of the chain, as `Chain.walked`.
        S: in; screws up to order k.
        C: in, lower orders; out in order 0, the rate of the independent joints.
        T: out; order k.
        joint_twists: out; see `LaneSeries`.
    """
    parent, columns, moves = chain[0], chain[4], chain[5]
    for j in range(parent.size):
        if not moves[j, 0]:
            continue
        p, w, x, y = parent[j], broadcast(0.0), broadcast(0.0), broadcast(0.0)
        for a in range(1, k + 1):
            rate = load_vector(C[k - a, j], 0)
            x = x + load_vector(S[a, j, 1], 0) * rate
            y = y + load_vector(S[a, j, 2], 0) * rate
        store_vector(joint_twists[j, 0], 0, x)
        store_vector(joint_twists[j, 1], 0, y)
        if k == 0:
            rate = broadcast(columns[j, 0])
            store_vector(C[0, j], 0, rate)
            w = load_vector(S[0, j, 0], 0) * rate
            x = load_vector(S[0, j, 1], 0) * rate
            y = load_vector(S[0, j, 2], 0) * rate
        if p >= 0:
            w = w + load_vector(T[k, p, 0], 0)
            x = x + load_vector(T[k, p, 1], 0)
            y = y + load_vector(T[k, p, 2], 0)
        store_vector(T[k, j, 0], 0, w)
        store_vector(T[k, j, 1], 0, x)
        store_vector(T[k, j, 2], 0, y)


@kernel(reference_counting=False)
def _fill_right_side(k, chain, mimics, T, b):
    """Fill the right-hand side by rows of the envelope: twist of side B less that of side A.

    Args:
        k: the order.
        chain: in; arrays of the chain, as `Chain.walked`.
        mimics: in; relations (g, n, lanes).
        T: in; known part of the link twists.
        b: out; (rows, lanes).
    """
    _, _, ends, _, columns, _, envelope = chain
    row, loops = envelope[ROW], ends.shape[0]
    for i in range(envelope[COUNT, ROWS]):
        store_vector(b[i], 0, broadcast(0.0))
    for loop in range(loops):
        for side in range(2):
            j, sign = ends[loop, side], broadcast(2.0 * side - 1.0)  # -1 on side A, +1 on B
            for i in range(3 if j >= 0 else 0):
                at = b[row[loop] + i]
                store_vector(at, 0, load_vector(at, 0) + sign * load_vector(T[k, j, i], 0))
    for relation in range(mimics.shape[0] if k == 0 else 0):
        at = b[row[loops + relation]]
        for j in range(mimics.shape[1]):
            entry = load_vector(mimics[relation, j], 0) * broadcast(columns[j, 0])
            store_vector(at, 0, load_vector(at, 0) - entry)


@kernel(reference_counting=False)
def lane_series(first, last, chain, screws, mimics, series):
    """Compute orders first … last of the closed motion of every lane.

    Args:
        first: the first order; those before must be in the series.
        last: the last order.
        chain: in; arrays of the chain, as `Chain.walked`; its screws and mimics are not read.
        screws: in; joint screws at the pose (n, 3, lanes), chain units.
        mimics: in; relations (g, n, lanes).
        series: in and out; a `LaneSeries`.
    """
    S, C, T, joint_twists, residual, factor = series
    parent, moves, envelope = chain[0], chain[5], chain[6]
    if first == 0:
        factor_loops(screws, mimics, envelope, factor)
        store_vector(residual, 0, broadcast(0.0))
    for k in range(first, last + 1):
        _carry_screws(k, parent, screws, S, T)
        _add_known_twists(k, chain, S, C, T, joint_twists)
        _fill_right_side(k, chain, mimics, T, factor.b)
        solve_loops(envelope, factor, residual)
        for d in range(factor.diagonal.shape[0]):
            store_vector(C[k, envelope[JOINT, d]], 0, load_vector(factor.b[d], 0))
        # T_j = T_parent + joint_twist_j + s_j,0 C_j,k
        for j in range(parent.size):
            if not moves[j, 0]:
                continue
            p, rate = parent[j], load_vector(C[k, j], 0)
            for i in range(3):
                twist = load_vector(screws[j, i], 0) * rate
                if i > 0:
                    twist = twist + load_vector(joint_twists[j, i - 1], 0)
                if p >= 0:
                    twist = twist + load_vector(T[k, p, i], 0)
                store_vector(T[k, j, i], 0, twist)
