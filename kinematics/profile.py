"""Loop matrices factorised within their profile: what couples few loops costs little.

Each loop gives a block of rows, each mimic relation one row. They are put into an order in
which neighbours share joints (E. Cuthill and J. McKee, 1969), and columns into the order in
which they first occur; then Householder's reflections stay within a profile of the matrix,
and only that is stored: of each column the rows ``TOP`` to ``BELOW``. (A. George and J.
W.-H. Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981.)

A profile is one array of whole numbers, whose lines are named by the constants below: the
first row of each block of rows, the joint of each column, the rows between which it has
entries, and the column at which its reflection ends. The last lines are room.
"""

from __future__ import annotations

import numpy as np

from kinematics.kernels import kernel

__all__ = ["JOINT", "ROW", "factor", "fill", "pivots", "profile", "solve"]

# Up to as many blocks of rows a matrix is taken as full.
FEW = 8
ROW, JOINT, TOP, BELOW, RIGHT, PLACE, SEEN, MET = range(8)


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


@kernel
def profile(parent, ends, mimics, dependent, dim):
    """The profile of the loop matrix of the dependent joints.

    Returns:
        The profile, room for the entries by columns (dependent joints, height), and the
        number of rows.
    """
    loops, count = ends.shape[0], dependent.size
    blocks = loops + mimics.shape[0]
    height = rows = loops * dim + mimics.shape[0]
    lines = np.empty((8, max(parent.size, rows)), np.int64)
    for block in range(blocks):
        lines[ROW, block] = block * dim if block < loops else loops * dim + block - loops
    for c in range(count):
        lines[JOINT, c], lines[TOP, c] = dependent[c], 0
        lines[BELOW, c], lines[RIGHT, c] = rows, count
    if blocks > FEW:
        height = _ordered(parent, ends, mimics, dependent, dim, lines)
    return lines, np.empty((count, height)), rows


@kernel
def _ordered(parent, ends, mimics, dependent, dim, lines):
    """Order rows and columns so that the profile is narrow; returns its height."""
    loops, count = ends.shape[0], dependent.size
    rows = loops * dim + mimics.shape[0]
    row, joints = lines[ROW], lines[JOINT]
    top, below, right = lines[TOP], lines[BELOW], lines[RIGHT]
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
    touched, height = 0, 1
    for k in range(count):
        end = max(last[k], min(k + 1, rows))
        below[k] = max(end, below[k - 1]) if k > 0 else end
        right[k] = max(reach[below[k] - 1], k + 1)
        # The first reflection that reaches a column gives it its first entry.
        while touched < right[k]:
            top[touched] = k
            touched += 1
    for k in range(count):
        height = max(height, below[k] - top[k])
    return height


@kernel(borrows=True)
def fill(parent, screws, ends, mimics, lines, F):
    """Loop matrix S_0 and mimic relations in the order of a profile, by columns.

    Args:
        parent: as in `kinematics.linkage.Chain`, as are the next three.
        screws: joint screws.
        ends: loops.
        mimics: relations.
        lines: the profile.
        F: takes the entries of each column from its top on (dependent joints, height).
    """
    n, dim = screws.shape
    row, joints, top = lines[ROW], lines[JOINT], lines[TOP]
    place, seen, met = lines[PLACE], lines[SEEN], lines[MET]
    for j in range(n):
        place[j] = seen[j] = -1
    for c in range(F.shape[0]):
        place[joints[c]] = c
        for i in range(F.shape[1]):
            F[c, i] = 0.0
    for loop in range(ends.shape[0]):
        count, turned = _ways(parent, ends[loop, 0], ends[loop, 1], seen, loop, met)
        for m in range(count):
            c, sign = place[met[m]], -1.0 if m < turned else 1.0
            if c >= 0:
                for i in range(dim):
                    F[c, row[loop] - top[c] + i] = sign * screws[met[m], i]
    for relation in range(mimics.shape[0]):
        i = row[ends.shape[0] + relation]
        for c in range(F.shape[0]):
            if mimics[relation, joints[c]] != 0.0:
                F[c, i - top[c]] = mimics[relation, joints[c]]


@kernel(borrows=True)
def factor(F, lines, diagonal):
    """Householder QR in place, within the profile; R's diagonal goes to ``diagonal``."""
    top, below, right = lines[TOP], lines[BELOW], lines[RIGHT]
    for k in range(F.shape[0]):
        x = F[k, k - top[k] : below[k] - top[k]]
        norm = 0.0
        for i in range(x.size):
            norm += x[i] * x[i]
        norm = np.sqrt(norm)
        if norm == 0.0:
            diagonal[k] = 0.0
            continue
        if x[0] > 0.0:
            norm = -norm
        diagonal[k] = norm
        x[0] -= norm
        scale = 1.0 / (norm * x[0])
        for j in range(k + 1, right[k]):
            y = F[j, k - top[j] :]
            dot = 0.0
            for i in range(x.size):
                dot += x[i] * y[i]
            dot *= scale
            for i in range(x.size):
                y[i] += dot * x[i]


@kernel
def pivots(parent, screws, ends, mimics, dependent):
    """Distances of the columns of the loop matrix from those before them, with signs."""
    lines, F, _ = profile(parent, ends, mimics, dependent, screws.shape[1])
    diagonal = np.empty(dependent.size)
    fill(parent, screws, ends, mimics, lines, F)
    factor(F, lines, diagonal)
    return diagonal


@kernel(borrows=True)
def solve(F, lines, diagonal, b):
    """Least-squares solution of the factored system, in the head of b; returns the residual.

    The tail of b keeps the residual in the rotated rows; its norm is returned.
    """
    top, below = lines[TOP], lines[BELOW]
    columns = F.shape[0]
    for k in range(columns):
        if diagonal[k] == 0.0:
            continue
        x, y = F[k, k - top[k] : below[k] - top[k]], b[k:]
        dot = 0.0
        for i in range(x.size):
            dot += x[i] * y[i]
        dot /= diagonal[k] * x[0]
        for i in range(x.size):
            y[i] += dot * x[i]
    for k in range(columns - 1, -1, -1):
        b[k] = b[k] / diagonal[k] if diagonal[k] != 0.0 else 0.0
        x, y = F[k], b[top[k] : k]
        for i in range(y.size):
            y[i] -= b[k] * x[i]
    residual = 0.0
    for i in range(columns, b.size):
        residual += b[i] * b[i]
    return np.sqrt(residual)
