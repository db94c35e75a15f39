"""Transfers through joints between which there are no bodies: compiled kernels.

Links without parameters must pass on what they take, and each body takes its share.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.support.tolerances import TRANSFER_DIRECTION_EQUAL
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.null_space import null_space

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


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
    """Joints between which there are no bodies, as from `cluster`.

    Attributes:
        start, joints: rigid part from which they are met; how many they are.
        before: the place of the joint before each, or -1 (≥ joints,).
        target: rigid part after each, or -1 (≥ joints,).
        body: the first body on each rigid part, or -1 (n + 1,).
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
