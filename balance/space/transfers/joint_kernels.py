"""Inertia transfers: what links can exchange across a joint while no momentum changes.

Let joint j, with screw s, carry a link on another whose attainable twists span V. Take the
parameters z from the one and give them to the other. At displacement q of the joint the
momentum changes by ``M(e^{qL} z) s`` per rate of the joint, and by ``(M(e^{qL} z) - M(z)) t``
per rate of a twist t below it, where ``L z`` is the rate of the parameters of a body that
moves with s: ``P' = ŝ P + P ŝᵀ`` for the pseudo-inertia P. Both vanish for every q iff

    M(Lᵏ z) s = 0  for k ≥ 0,     M(Lᵏ z) t = 0  for k ≥ 1 and t in V,

and beyond the joint the twists ``Σ ad(s)ᵏ V + ⟨s⟩`` can be attained. What passes through
links without parameters of their own must pass through all the joints at them. (J. J. de
Jong, PhD thesis, University of Twente, section 5.5; the recursion in the manner of P. M.
Wensing, G. Niemeyer and J.-J. E. Slotine, 2017.)

Where several joints meet without bodies between them, links without parameters must pass on
what they take, and each body takes its share.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.support.tolerances import TRANSFER_DIRECTION_EQUAL
from kinematics.closure.series import add_bracket
from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.null_space import null_space


@kernel(inline=True, reference_counting=False)
def _momentum(t, z, h):
    """Compute the momentum ``h = M(z) t`` of parameters at a twist.

    Args:
        t: in: the twist ``[ω; v]`` (6,), or ``[ω; v_x; v_y]`` (3,).
        z: in: the parameters (10,) or (4,) in space, (4,) or (3,) in a plane.
        h: out: the momentum ``[ξ; p]`` (6,) or (3,), or p alone (3,) or (2,).
    """
    if t.size == 3:
        p = h.size - 2
        h[p] = z[0] * t[1] - t[0] * z[2]
        h[p + 1] = z[0] * t[2] + t[0] * z[1]
        if p:
            h[0] = z[3] * t[0] + z[1] * t[2] - z[2] * t[1]
        return
    p = h.size - 3
    m, x, y, c = z[0], z[1], z[2], z[3]
    h[p] = m * t[3] + t[1] * c - t[2] * y
    h[p + 1] = m * t[4] + t[2] * x - t[0] * c
    h[p + 2] = m * t[5] + t[0] * y - t[1] * x
    if p:
        h[0] = z[4] * t[0] + z[7] * t[1] + z[8] * t[2] + y * t[5] - c * t[4]
        h[1] = z[7] * t[0] + z[5] * t[1] + z[9] * t[2] + c * t[3] - x * t[5]
        h[2] = z[8] * t[0] + z[9] * t[1] + z[6] * t[2] + x * t[4] - y * t[3]


@kernel(inline=True, reference_counting=False)
def _rate(s, z, d):
    """Compute the rate ``d = L z`` of the parameters of a body that moves with a twist.

    Args:
        s: in: the twist (6,) or (3,).
        z: in: the parameters; see `_momentum`.
        d: out: their rate, of the shape of z.
    """
    d[0] = 0.0
    if s.size == 3:
        d[1] = z[0] * s[1] - s[0] * z[2]
        d[2] = z[0] * s[2] + s[0] * z[1]
        if z.size == 4:
            d[3] = 2.0 * (z[1] * s[1] + z[2] * s[2])
        return
    a, b, c, u, v, w = s[0], s[1], s[2], s[3], s[4], s[5]
    m, x, y, k = z[0], z[1], z[2], z[3]
    d[1] = m * u + b * k - c * y
    d[2] = m * v + c * x - a * k
    d[3] = m * w + a * y - b * x
    if z.size == 10:
        d[4] = 2.0 * (b * z[8] - c * z[7] + y * v + k * w)
        d[5] = 2.0 * (c * z[7] - a * z[9] + x * u + k * w)
        d[6] = 2.0 * (a * z[9] - b * z[8] + x * u + y * v)
        d[7] = b * z[9] - c * z[5] + c * z[4] - a * z[8] - x * v - y * u
        d[8] = b * z[6] - c * z[9] + a * z[7] - b * z[4] - x * w - k * u
        d[9] = c * z[8] - a * z[6] + a * z[5] - b * z[7] - y * w - k * v


@kernel(reference_counting=False)
def passing_parameters(s, V, size, rows, tolerance, A, order, out, gap):
    """Find the parameters that can pass a joint: ``M(Lᵏ z) s = 0``, ``M(Lᵏ⁺¹ z) t = 0``.

    Args:
        s: in: screw of the joint (dim,).
        V: in: twists t that are attainable below it, orthonormal (v, dim).
        size: parameters of each body.
        rows: momentum components that count.
        tolerance: relative size of round-off.
        A: workspace (≥ rows (v + 1) + 2 size, size).
        order: workspace (≥ size,).
        out: out: the parameters, orthonormal rows (size, size).
        gap: in, out: smallest size that was kept, and largest that was dropped (2,).

    Returns:
        Their number.
    """
    # Where every twist can be attained, the rate itself must vanish.
    every = V.shape[0] == s.size
    m = rows + (size if every else rows * V.shape[0])
    z, d, h = out[0], out[1], out[2]
    for p in range(size):
        z[p] = 0.0
    # Column c of A: M(e_c) s, and M(L e_c) t for every t, or L e_c itself.
    for c in range(size):
        z[c] = 1.0
        _momentum(s, z, h[:rows])
        for r in range(rows):
            A[r, c] = h[r]
        _rate(s, z, d)
        if every:
            for p in range(size):
                A[rows + p, c] = d[p]
        for i in range(0 if every else V.shape[0]):
            _momentum(V[i], d, h[:rows])
            for r in range(rows):
                A[rows * (1 + i) + r, c] = h[r]
        z[c] = 0.0
    count = null_space(A, m, size, tolerance, order, out, gap)
    while count > 0 and not every:
        # The part of L K that leaves the span of K must vanish.
        largest = 0.0
        d = A[size]
        for c in range(count):
            _rate(s, out[c], d)
            largest = max(largest, remove_span(out[:count], d))
            for p in range(size):
                A[p, c] = d[p]
        if largest <= tolerance:
            gap[1] = max(gap[1], largest)
            break
        stays = A[size:]
        kept = null_space(A, size, count, tolerance, order, stays, gap)
        if kept == count:
            break
        # K becomes the combinations of K that stay: out_i = Σ_c stays_ic out_c.
        for p in range(size):
            for i in range(kept):
                A[i, p] = 0.0
                for c in range(count):
                    A[i, p] += stays[i, c] * out[c, p]
        count = kept
        for i in range(count):
            for p in range(size):
                out[i, p] = A[i, p]
    return count


@kernel(reference_counting=False)
def remove_span(W, x):
    """Subtract from x its part in a span, twice: ``x -= Wᵀ W x``.

    Args:
        W: in: orthonormal rows (count, ≥ size of x).
        x: in, out: a vector.

    Returns:
        The size of the rest.
    """
    for _ in range(2):
        for i in range(W.shape[0]):
            dot = 0.0
            for j in range(x.size):
                dot += W[i, j] * x[j]
            for j in range(x.size):
                x[j] -= dot * W[i, j]
    total = 0.0
    for j in range(x.size):
        total += x[j] * x[j]
    return np.sqrt(total)


@kernel(reference_counting=False)
def attainable_beyond(s, V, tolerance, W, gap):
    """Find the twists attainable beyond a joint: ``Σ ad(s)ᵏ V + ⟨s⟩``.

    Args:
        s: in: screw of the joint (dim,).
        V: in: twists attainable below it, orthonormal (v, dim).
        tolerance: relative size of round-off.
        W: out: the twists, orthonormal rows (≥ dim, dim).
        gap: in, out: as in `passing_parameters`.

    Returns:
        Their number.
    """
    dim, count = s.size, V.shape[0]
    for i in range(count):
        for c in range(dim):
            W[i, c] = V[i, c]
    # Candidates: s, and then s × w for every twist w found.
    i = -1
    while i < count and count < dim:
        x = W[count]
        for c in range(dim):
            x[c] = s[c] if i < 0 else 0.0
        if i >= 0:
            add_bracket(s, W[i], 1.0, x)
        size = remove_span(W[:count], x)
        if size > tolerance:
            gap[0] = min(gap[0], size)
            for c in range(dim):
                x[c] /= size
            count += 1
        else:
            gap[1] = max(gap[1], size)
        i += 1
    return count


@kernel(reference_counting=False)
def span_contains(V, U, x, gap):
    """Decide whether the span of the rows of V contains that of the rows of U.

    Args:
        V: in: orthonormal rows (v, dim).
        U: in: orthonormal rows (u, dim).
        x: workspace (dim,).
        gap: in, out: as in `passing_parameters`.
    """
    if U.shape[0] > V.shape[0]:
        return False
    for i in range(U.shape[0]):
        for c in range(U.shape[1]):
            x[c] = U[i, c]
        size = remove_span(V, x)
        if size > TRANSFER_DIRECTION_EQUAL:
            gap[0] = min(gap[0], size)
            return False
        gap[1] = max(gap[1], size)
    return True


class FoundTransfers(NamedTuple):
    """The transfers found so far, as kernels pass them to each other.

    Attributes:
        rows: the transfers (≥ count, parameters).
        owners: the owner of each (≥ count,).
        gap: smallest size that a decision kept, and largest that one dropped (2,).
    """

    rows: Array
    owners: IntArray
    gap: Array


class Cluster(NamedTuple):
    """Joints between which there are no bodies; `find_cluster` lists them.

    Attributes:
        start: rigid part from which they are met.
        before: the place of the joint before each, or -1 (≥ joints,).
        target: rigid part after each, or -1 (≥ joints,).
        body: the first body on each rigid part, or -1 (n + 1,).
        joints: how many they are.
    """

    start: int
    before: IntArray
    target: IntArray
    body: IntArray
    joints: int


@kernel(reference_counting=False)
def add_transfers(transfers, count, owner, shares, combinations, through):
    """Add transfers through a cluster to those of its owner, if they are not in their span.

    Share k goes to the body after joint k, and the share of the first joint is taken from the
    body at the start. Transfers are orthonormal for each owner, which takes two rounds (B. N.
    Parlett, 1980).

    Args:
        transfers: in, out: a `FoundTransfers`.
        count: number of transfers that it holds.
        owner: number of the cluster's owner.
        shares: in: parameters that pass each joint (≥ joints, ≥ combinations, size).
        combinations: number of transfers to add.
        through: in: a `Cluster`.

    Returns:
        Number of transfers after that.
    """
    rows, owners, gap = transfers
    start, _, target, body, joints = through
    size = shares.shape[2]
    for c in range(combinations):
        x = rows[count]
        for j in range(x.size):
            x[j] = 0.0
        # x = Σ_k share_k at the body after joint k, less share_0 at the body before.
        for k in range(joints):
            b = body[target[k]] if target[k] >= 0 else -1
            for p in range(size):
                if b >= 0:
                    x[b * size + p] += shares[k, c, p]
                if k == 0 and body[start] >= 0:
                    x[body[start] * size + p] -= shares[k, c, p]
        # x -= (rows_r · x) rows_r, twice.
        for _ in range(2):
            for r in range(count):
                if owners[r] == owner:
                    dot = 0.0
                    for j in range(x.size):
                        dot += rows[r, j] * x[j]
                    for j in range(x.size):
                        x[j] -= dot * rows[r, j]
        remainder = 0.0
        for j in range(x.size):
            remainder += x[j] * x[j]
        remainder = np.sqrt(remainder)
        if remainder <= TRANSFER_DIRECTION_EQUAL:
            gap[1] = max(gap[1], remainder)
        else:
            gap[0] = min(gap[0], remainder)
            for j in range(x.size):
                x[j] /= remainder
            owners[count] = owner
            count += 1
    return count


@kernel(reference_counting=False)
def add_shared_transfers(
    transfers, transfer_count, owner, passes, passed, through, tolerance, numbers, workspace
):
    """Add the transfers through a cluster that leave its links without bodies empty.

    For every link without a body inside, ``Σ c_in pass_in - Σ c_out pass_out = 0``.

    Args:
        transfers: in, out: a `FoundTransfers`.
        transfer_count: number of transfers that it holds.
        owner: number of the cluster's owner.
        passes: in: parameters that can pass each joint (≥ joints, size, size).
        passed: in: number of them for each joint (≥ joints,).
        through: in: a `Cluster`.
        tolerance: relative size of round-off.
        numbers: workspace (3, ≥ joints * size).

    Returns:
        Number of transfers after that, or -1 if there is too little workspace.
    """
    start, before, target, body, count = through
    size = passes.shape[2]
    first, row, order = numbers[0], numbers[1], numbers[2]
    n = inner = 0
    for k in range(count):
        first[k], row[k] = n, inner * size
        n += passed[k]
        if target[k] >= 0 and body[target[k]] < 0:
            inner += 1
    m = inner * size
    if n > order.size or n * (m + n) + count * n * size > workspace.size:
        return -1
    A = workspace[: m * n].reshape((m, n))
    mixed = workspace[m * n : (m + n) * n].reshape((n, n))
    # A: a block of rows for each inner link, a column for everything that passes a joint.
    for i in range(m):
        for j in range(n):
            A[i, j] = 0.0
    for k in range(count):
        for c in range(passed[k]):
            for p in range(size):
                if body[target[k]] < 0:
                    A[row[k] + p, first[k] + c] = passes[k, c, p]
                if before[k] >= 0:
                    A[row[before[k]] + p, first[k] + c] = -passes[k, c, p]
    combinations = null_space(A, m, n, tolerance, order, mixed, transfers.gap)
    out = workspace[(m + n) * n :][: count * combinations * size]
    out = out.reshape((count, combinations, size))
    # out_ki = Σ_c mixed_ic passes_kc: what combination i sends through joint k.
    for i in range(combinations):
        for k in range(count):
            for p in range(size):
                total = 0.0
                for c in range(passed[k]):
                    total += mixed[i, first[k] + c] * passes[k, c, p]
                out[k, i, p] = total
    return add_transfers(transfers, transfer_count, owner, out, combinations, through)
