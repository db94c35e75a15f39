"""Loop matrices factorised within their profile: what couples few loops costs little.

Each loop gives a block of rows, each mimic relation one row. They are put into an order in
which neighbours share joints (E. Cuthill and J. McKee, 1969), and columns into the order in
which they first occur; then Householder's reflections stay within a profile of the matrix,
and only that is stored: row i from column ``start[i]`` on. (A. George and J. W.-H. Liu,
Computer Solution of Large Sparse Positive Definite Systems, 1981.)
"""

from __future__ import annotations

import numpy as np

from kinematics.kernels import kernel

__all__ = ["FEW", "factor_profile", "fill_profile", "full", "profile", "solve_profile"]

# Up to as many blocks of rows a matrix is taken as full.
FEW = 8


@kernel(borrows=True)
def _ways(parent, end, successor, seen, mark, joints):
    """Joints of a loop, without those below both its ends, with the other sign first.

    Returns:
        How many they are, and how many of them have the other sign.
    """
    count = 0
    j = end
    while j >= 0:
        seen[j] = mark
        j = parent[j]
    j = successor
    while j >= 0 and seen[j] != mark:
        joints[count] = j
        count += 1
        j = parent[j]
    meeting, turned = j, count
    j = end
    while j != meeting:
        joints[count] = j
        count += 1
        j = parent[j]
    return count, turned


@kernel
def _entries(parent, ends, mimics, dependent):
    """Columns that occur in each block, as one list and the place where each begins."""
    n, loops = parent.size, ends.shape[0]
    blocks = loops + mimics.shape[0]
    position = np.full(n, -1)
    for c in range(dependent.size):
        position[dependent[c]] = c
    seen = np.full(n, -1)
    joints = np.empty(n, np.int64)
    first = np.zeros(blocks + 1, np.int64)
    columns = np.empty(4 * n, np.int64)
    total = 0
    for block in range(blocks):
        count = n
        if block < loops:
            count = _ways(parent, ends[block, 0], ends[block, 1], seen, block, joints)[0]
        if total + count > columns.size:
            columns = np.concatenate((columns, np.empty(columns.size + count, np.int64)))
        for i in range(count):
            j = joints[i] if block < loops else i
            if position[j] >= 0 and (block < loops or mimics[block - loops, j] != 0.0):
                columns[total] = position[j]
                total += 1
        first[block + 1] = total
    return first, columns


@kernel
def _neighbours_first(first, columns, count):
    """Blocks in an order in which those that share columns are close to each other."""
    blocks = first.size - 1
    begin = np.zeros(count + 1, np.int64)
    for e in range(first[blocks]):
        begin[columns[e] + 1] += 1
    for c in range(count):
        begin[c + 1] += begin[c]
    users, filled = np.empty(first[blocks], np.int64), begin.copy()
    for block in range(blocks):
        for e in range(first[block], first[block + 1]):
            users[filled[columns[e]]] = block
            filled[columns[e]] += 1
    order = np.empty(blocks, np.int64)
    # The second time each group begins with the block that came last, at its far end.
    for turn in range(2):
        starts = order[::-1].copy() if turn else np.arange(blocks)
        taken, placed, done = np.zeros(blocks, np.bool_), 0, 0
        for start in starts:
            if not taken[start]:
                taken[start] = True
                order[placed] = start
                placed += 1
            while done < placed:
                block = order[done]
                done += 1
                for e in range(first[block], first[block + 1]):
                    for u in range(begin[columns[e]], begin[columns[e] + 1]):
                        if not taken[users[u]]:
                            taken[users[u]] = True
                            order[placed] = users[u]
                            placed += 1
    return order


@kernel(borrows=True)
def full(dependent, row, joints, start, below, right, dim, loops):
    """The profile of a matrix that is taken as full; see `profile`."""
    for block in range(row.size):
        row[block] = block * dim if block < loops else loops * dim + block - loops
    for i in range(start.size):
        start[i] = 0
    for c in range(dependent.size):
        joints[c], below[c], right[c] = dependent[c], start.size, dependent.size


@kernel
def profile(parent, ends, mimics, dependent, dim, row, joints, start, below, right):
    """Order and profile of the loop matrix of the dependent joints.

    Args:
        parent: as in `kinematics.linkage.Chain`, as are the next three.
        ends: loops.
        mimics: relations.
        dependent: joints.
        dim: components of a twist.
        row: takes the first row of each block.
        joints: takes the dependent joints in the order of the columns.
        start: takes the column at which each row begins.
        below: takes the row at which the reflection of each column ends.
        right: takes the column at which it ends.

    Returns:
        The width of the profile.
    """
    loops, count, rows = ends.shape[0], dependent.size, start.size
    full(dependent, row, joints, start, below, right, dim, loops)
    first, columns = _entries(parent, ends, mimics, dependent)
    order = _neighbours_first(first, columns, count)
    place = np.full(count, -1)
    last, reach = np.zeros(count, np.int64), np.empty(rows, np.int64)
    placed = at = furthest = 0
    for block in order:
        row[block] = at
        size = dim if block < loops else 1
        for e in range(first[block], first[block + 1]):
            c = columns[e]
            if place[c] < 0:
                place[c] = placed
                joints[placed] = dependent[c]
                placed += 1
            furthest = max(furthest, place[c] + 1)
            last[place[c]] = at + size
        for i in range(at, at + size):
            reach[i] = furthest
        at += size
    for c in range(count):
        if place[c] < 0:
            joints[placed] = dependent[c]
            placed += 1
    touched = 0
    for k in range(count):
        end = max(last[k], min(k + 1, rows))
        below[k] = max(end, below[k - 1]) if k > 0 else end
        right[k] = max(reach[below[k] - 1], k + 1)
        for i in range(touched, below[k]):
            start[i] = k
        touched = below[k]
    width = 1
    for i in range(rows if count else 0):
        width = max(width, right[min(i, count - 1)] - start[i])
    return width


@kernel
def fill_profile(parent, screws, ends, mimics, row, joints, start, A):
    """Put loop matrix S_0 and mimic relations in the order of `profile` into A, which is zero.

    It has the shape (rows, width).
    """
    n, dim = screws.shape
    whole = np.full((3, n), -1)
    position, seen, met = whole[0], whole[1], whole[2]
    for c in range(joints.size):
        position[joints[c]] = c
    for loop in range(ends.shape[0]):
        count, turned = _ways(parent, ends[loop, 0], ends[loop, 1], seen, loop, met)
        for m in range(count):
            c, sign = position[met[m]], -1.0 if m < turned else 1.0
            if c >= 0:
                for i in range(row[loop], row[loop] + dim):
                    A[i, c - start[i]] = sign * screws[met[m], i - row[loop]]
    for relation in range(mimics.shape[0]):
        i = row[ends.shape[0] + relation]
        for c in range(joints.size):
            if mimics[relation, joints[c]] != 0.0:
                A[i, c - start[i]] = mimics[relation, joints[c]]


@kernel(borrows=True)
def factor_profile(A, start, below, right, diagonal):
    """Householder QR in place, within the profile; R's diagonal goes to ``diagonal``."""
    for k in range(diagonal.size):
        norm = 0.0
        for i in range(k, below[k]):
            norm += A[i, k - start[i]] * A[i, k - start[i]]
        norm = np.sqrt(norm)
        if norm == 0.0:
            diagonal[k] = 0.0
            continue
        if A[k, k - start[k]] > 0.0:
            norm = -norm
        diagonal[k] = norm
        A[k, k - start[k]] -= norm
        scale = 1.0 / (norm * A[k, k - start[k]])
        for j in range(k + 1, right[k]):
            dot = 0.0
            for i in range(k, below[k]):
                dot += A[i, k - start[i]] * A[i, j - start[i]]
            dot *= scale
            for i in range(k, below[k]):
                A[i, j - start[i]] += dot * A[i, k - start[i]]


@kernel(borrows=True)
def solve_profile(A, start, below, right, diagonal, b):
    """Least-squares solution of the factored system, in the head of b; returns the residual.

    The tail of b keeps the residual in the rotated rows; its norm is returned.
    """
    columns = diagonal.size
    for k in range(columns):
        if diagonal[k] == 0.0:
            continue
        dot = 0.0
        for i in range(k, below[k]):
            dot += A[i, k - start[i]] * b[i]
        dot /= diagonal[k] * A[k, k - start[k]]
        for i in range(k, below[k]):
            b[i] += dot * A[i, k - start[i]]
    for k in range(columns - 1, -1, -1):
        for j in range(k + 1, right[k]):
            b[k] -= A[k, j - start[k]] * b[j]
        b[k] = b[k] / diagonal[k] if diagonal[k] != 0.0 else 0.0
    residual = 0.0
    for i in range(columns, b.size):
        residual += b[i] * b[i]
    return np.sqrt(residual)
