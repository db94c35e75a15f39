"""Finite poses of many planar geometries side by side, one in each lane: compiled kernels.

Steps along a series and Newton's method are those of `kinematics.closure.newton_kernels`. The
last axis of every array is that of the lanes. Displacements of links are ``[cos, sin, x, y]``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.closure.newton_kernels import MAX_NEWTON_STEPS, RADIUS_SHARE
from kinematics.model.arrays import Chain
from kinematics.numerics.array_types import Array
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import (
    VECTOR_WIDTH,
    broadcast,
    choose_greater,
    lanes,
    load_vector,
    square_root,
    store_vector,
)
from kinematics.numerics.linalg.lane_loop_qr import factor_loops, solve_loops
from kinematics.numerics.linalg.skyline_qr import JOINT, ROW
from kinematics.numerics.tolerances import (
    BRANCH_DISTANCE_SQUARED,
    FOLLOWED_POSE_RESIDUAL,
    NEWTON_DIVERGED,
    NEWTON_ROUND_OFF,
    NEWTON_STALL_RESIDUAL,
)


class LanePoses(NamedTuple):
    """Poses in lanes and their workspace.

    Attributes:
        H: displacements of the links, and last that of the ground (n + 1, 4, lanes).
        screws: joint screws at the pose (n, 3, lanes).
        start: joint positions from which the step begins (n, lanes).
        q: joint positions (n, lanes).
        predicted: what the series predicts of the step (n, lanes).
        sine: sine and half-angle sine of a joint position (2, lanes).
        numbers: error, best error, whether Newton's method goes on, residual (4, lanes).
    """

    H: Array
    screws: Array
    start: Array
    q: Array
    predicted: Array
    sine: Array
    numbers: Array


def lane_poses_workspace(chain: Chain) -> LanePoses:
    """Allocate poses in lanes.

    Args:
        chain: one of the linkages.
    """
    n = chain.parent.size
    H = lanes(n + 1, 4)
    H[n, 0] = 1.0
    return LanePoses(
        H,
        lanes(n, 3),
        lanes(n),
        lanes(n),
        lanes(n),
        lanes(2),
        lanes(4),
    )


@kernel(reference_counting=False)
def _place(parent, screws, poses):
    """Compute displacements and screws at joint positions q; see `place_links`.

    Args:
        parent: in; link before each joint, -1 for the ground (n,).
        screws: in; joint screws at the reference pose (n, 3, lanes).
        poses: in and out; a `LanePoses`.
    """
    H, s, _, q, _, sine, _ = poses
    for j in range(parent.size):
        before = H[parent[j]]  # -1 finds the ground
        for lane in range(VECTOR_WIDTH):
            sine[0, lane], sine[1, lane] = np.sin(q[j, lane]), np.sin(0.5 * q[j, lane])
        a, u = load_vector(screws[j, 0], 0), load_vector(screws[j, 1], 0)
        v, angle = load_vector(screws[j, 2], 0), load_vector(q[j], 0)
        half = load_vector(sine[1], 0)
        c, d = load_vector(before[0], 0), load_vector(before[1], 0)
        x, y = load_vector(before[2], 0), load_vector(before[3], 0)
        # Ad(H_parent) s
        store_vector(s[j, 0], 0, a)
        store_vector(s[j, 1], 0, c * u - d * v + a * y)
        store_vector(s[j, 2], 0, d * u + c * v - a * x)
        # H_parent exp(q ŝ), with 1 - cos q = 2 sin²(q/2)
        c2 = broadcast(2.0) * half * half
        c3 = (angle - load_vector(sine[0], 0)) * a * a
        cosine, turn = broadcast(1.0) - c2 * a * a, (angle - c3) * a
        ex = (angle - c3) * u - c2 * a * v
        ey = (angle - c3) * v + c2 * a * u
        store_vector(H[j, 0], 0, c * cosine - d * turn)
        store_vector(H[j, 1], 0, d * cosine + c * turn)
        store_vector(H[j, 2], 0, c * ex - d * ey + x)
        store_vector(H[j, 3], 0, d * ex + c * ey + y)


@kernel(reference_counting=False)
def _fill_closure_residual(ends, mimics, envelope, poses, b):
    """Fill ``-b(q)`` by rows of the envelope: how far loops and relations are open.

    Args:
        ends: in; links on side A and side B of each weld (L, 2).
        mimics: in; relations (g, n, lanes).
        envelope: in; the table.
        poses: in; a `LanePoses`, whose first line of numbers is out: the size of b.
        b: out; (rows, lanes).
    """
    H, _, _, q, _, _, numbers = poses
    row, loops, squares = envelope[ROW], ends.shape[0], broadcast(0.0)
    for loop in range(loops):
        # D = H_A H_B⁻¹: sine of its angle, and its translation
        A, B, at = H[ends[loop, 0]], H[ends[loop, 1]], row[loop]
        c, d = load_vector(A[0], 0), load_vector(A[1], 0)
        e, f = load_vector(B[0], 0), load_vector(B[1], 0)
        x, y = load_vector(B[2], 0), load_vector(B[3], 0)
        cosine, sine = c * e + d * f, d * e - c * f
        dx = cosine * x - sine * y - load_vector(A[2], 0)
        dy = sine * x + cosine * y - load_vector(A[3], 0)
        squares = squares + sine * sine + dx * dx + dy * dy
        store_vector(b[at], 0, broadcast(0.0) - sine)
        store_vector(b[at + 1], 0, dx)
        store_vector(b[at + 2], 0, dy)
    for relation in range(mimics.shape[0]):
        total = broadcast(0.0)
        for j in range(mimics.shape[1]):
            total = total - load_vector(mimics[relation, j], 0) * load_vector(q[j], 0)
        squares = squares + total * total
        store_vector(b[row[loops + relation]], 0, total)
    store_vector(numbers[0], 0, square_root(squares))


@kernel(reference_counting=False)
def _count_open(numbers):
    """Count the lanes in which Newton's method goes on; see `solve_closure`.

    Args:
        numbers: in and out; as in `LanePoses`.
    """
    count = 0
    for lane in range(VECTOR_WIDTH):
        error, best = numbers[0, lane], numbers[1, lane]
        stalled = error < NEWTON_STALL_RESIDUAL and error >= 0.5 * best
        if not error < NEWTON_DIVERGED or stalled or error < NEWTON_ROUND_OFF:
            numbers[2, lane] = 0.0
        elif numbers[2, lane] > 0.0:
            numbers[1, lane] = min(best, error)
            count += 1
    return count


@kernel(reference_counting=False)
def _close_loops(chain, screws, mimics, factor, poses):
    """Close the loops of all lanes by Newton's method, in place.

    Args:
        chain: in; arrays of the chain, as `Chain.walked`.
        screws: in; joint screws at the reference pose (n, 3, lanes).
        mimics: in; relations (g, n, lanes).
        factor: workspace; a `LoopFactor`.
        poses: in and out; a `LanePoses`.
    """
    parent, ends, envelope = chain[0], chain[2], chain[6]
    q, numbers, zero = poses.q, poses.numbers, broadcast(0.0)
    store_vector(numbers[1], 0, broadcast(np.inf))
    store_vector(numbers[2], 0, broadcast(1.0))
    for _ in range(MAX_NEWTON_STEPS):
        _place(parent, screws, poses)
        _fill_closure_residual(ends, mimics, envelope, poses, factor.b)
        if _count_open(numbers) == 0:
            break
        factor_loops(poses.screws, mimics, envelope, factor)
        solve_loops(envelope, factor, numbers[3])
        go = load_vector(numbers[2], 0)
        for d in range(factor.diagonal.shape[0]):
            at = q[envelope[JOINT, d]]
            step = choose_greater(go, zero, load_vector(factor.b[d], 0), zero)
            store_vector(at, 0, load_vector(at, 0) + step)


@kernel(reference_counting=False)
def radius_lanes(C, orders, numbers):
    """Estimate the radius of convergence of every lane; see `radius_along`.

    Args:
        C: in; joint rates (≥ orders, n, lanes).
        orders: how many orders count.
        numbers: out; the radius, and the least rate of a joint over the largest; then workspace
            (4, lanes).
    """
    zero, limit = broadcast(0.0), numbers[0]
    first, least, most = zero, broadcast(np.inf), zero
    store_vector(limit, 0, broadcast(1.0))
    for k in range(orders):
        squares = zero
        for j in range(C.shape[1]):
            x = load_vector(C[k, j], 0)
            squares = squares + x * x
            size = choose_greater(zero, x, zero - x, x)
            least = choose_greater(least, size, size, least) if k == 0 else least
            most = choose_greater(size, most, size, most) if k == 0 else most
        size, power = square_root(squares), load_vector(limit, 0)
        first = size if k == 0 else first
        # limit = max(limit, |q̇_0|, (|q̇_k| / |q̇_0|)^(1/k)): the root only where it is larger
        for _ in range(k - 1):
            power = power * load_vector(limit, 0)
        store_vector(numbers[2], 0, size if k == 0 else size / first)
        store_vector(numbers[3], 0, power)
        for lane in range(VECTOR_WIDTH):
            if numbers[2, lane] > numbers[3, lane]:
                limit[lane] = numbers[2, lane] ** (1.0 / max(k, 1))
    store_vector(limit, 0, broadcast(1.0) / load_vector(limit, 0))
    store_vector(numbers[1], 0, least / most)


@kernel(reference_counting=False)
def follow_lanes(chain, screws, mimics, C, orders, radius, factor, poses, active):
    """Find a closed pose of every lane along its series, from ``poses.start``.

    A lane in which the step fails is no longer active: `follow_series` tries shorter ones.

    Args:
        chain: in; arrays of the chain, as `Chain.walked`.
        screws: in; joint screws at the reference pose (n, 3, lanes).
        mimics: in; relations (g, n, lanes).
        C: in; joint rates of the series (≥ orders, n, lanes).
        orders: how many orders count.
        radius: in; radius of convergence (lanes,).
        factor: workspace; a `LoopFactor`.
        poses: in and out; a `LanePoses`.
        active: in and out; which lanes count (lanes,).
    """
    step = broadcast(RADIUS_SHARE) * load_vector(radius, 0)
    off, size = broadcast(0.0), broadcast(0.0)
    # q - start = Σ_k q̇_k step^(k+1) / (k+1), by Horner's scheme
    for j in range(chain[0].size):
        moved = broadcast(0.0)
        for k in range(orders - 1, -1, -1):
            moved = (moved + load_vector(C[k, j], 0) * broadcast(1.0 / (k + 1))) * step
        store_vector(poses.predicted[j], 0, moved)
        store_vector(poses.q[j], 0, load_vector(poses.start[j], 0) + moved)
        size = size + moved * moved
    _close_loops(chain, screws, mimics, factor, poses)
    for j in range(chain[0].size):
        deviation = load_vector(poses.q[j], 0) - load_vector(poses.start[j], 0)
        deviation = deviation - load_vector(poses.predicted[j], 0)
        off = off + deviation * deviation
    store_vector(poses.numbers[1], 0, broadcast(BRANCH_DISTANCE_SQUARED) * size - off)
    for lane in range(VECTOR_WIDTH):
        closed = poses.numbers[0, lane] < FOLLOWED_POSE_RESIDUAL
        if not (closed and poses.numbers[1, lane] >= 0.0):
            active[lane] = 0
