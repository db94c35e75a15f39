"""Skyline Householder QR of loop matrices; the cost grows linearly with loosely coupled loops.

Each loop gives a block of rows, each mimic relation one row. They are put into an order in
which neighbours share joints (E. Cuthill and J. McKee, 1969), and columns into the order in
which they first occur; then Householder's reflections stay within an envelope of the matrix,
and only that is stored: of each column the rows ``TOP`` to ``BELOW``. (A. George and J.
W.-H. Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981.)

An envelope table is one array of integers (10, length), because each array argument adds call
overhead. Its rows are named by the constants below:

    ROW                              first row of each block of rows; loops, then relations
    JOINT, TOP, BELOW, RIGHT         of each column: its joint, the rows between which it has
                                     entries, and the column at which its reflection ends
    MEMBER, COLUMN, PLACE, SIGN      of each entry: its joint, the column, the row within it,
                                     and the sign of the joint's screw; entries of mimic
                                     relations come last, with the relation for the sign
    COUNT                            numbers of entries in loops, of all entries, the height
                                     of the longest column, and the number of rows

It follows from the connections between links alone: it is made once for a chain, without a
kernel.
"""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from kinematics.numerics.array_types import Array, IntArray
from kinematics.numerics.compiled.jit import kernel

# A block of rows: the joints of a loop with their signs, or of a relation with its number.
Block = list[tuple[int, int]]

# Matrices with at most this number of blocks of rows are stored as full.
MAX_FULL_BLOCKS = 8
# Rows of an envelope table.
ROW, JOINT, TOP, BELOW, RIGHT, MEMBER, COLUMN, PLACE, SIGN, COUNT = range(10)
# Entries of its last row.
IN_LOOPS, ENTRIES, HEIGHT, ROWS = range(4)


def envelope_table(
    parent: IntArray, ends: IntArray, mimics: Array, dependent: IntArray, dim: int
) -> IntArray:
    """Make the envelope table of the loop matrix of the dependent joints.

    Args:
        parent: as in `kinematics.model.arrays.Chain`, as are the next three.
        dependent: joints that have columns.
        dim: components of a twist, 6 or 3.
    """
    loops, count = len(ends), dependent.size
    position = {j: c for c, j in enumerate(dependent.tolist())}
    above = parent.tolist()
    blocks = [_loop_members(above, *pair) for pair in ends.tolist()]
    blocks += [[(j, r) for j in np.flatnonzero(row).tolist()] for r, row in enumerate(mimics)]
    blocks = [[member for member in block if member[0] in position] for block in blocks]
    sizes = [dim] * loops + [1] * len(mimics)
    used = [[position[j] for j, _ in block] for block in blocks]
    full = len(blocks) <= MAX_FULL_BLOCKS
    order = list(range(len(blocks))) if full else _order_by_neighbours(used, count)
    row = np.cumsum([0] + [sizes[block] for block in order]).tolist()
    rows = row.pop()
    first = dict(zip(order, row, strict=True))
    if full:
        columns = list(range(count))
        top, below, right = [0] * count, [rows] * count, [count] * count
    else:
        columns, top, below, right = _envelope_columns(used, sizes, order, count, rows)
    place = {c: k for k, c in enumerate(columns)}
    entries = [
        (j, place[position[j]], first[b] - top[place[position[j]]], sign)
        for b, block in enumerate(blocks)
        for j, sign in block
    ]
    in_loops = sum(map(len, blocks[:loops]))
    height = max((end - begin for begin, end in zip(top, below, strict=True)), default=0)
    table = np.zeros((10, max(4, rows, count, len(entries))), np.int64)
    table[ROW, : len(blocks)] = [first[b] for b in range(len(blocks))]
    table[JOINT, :count] = dependent[columns]
    table[TOP, :count], table[BELOW, :count], table[RIGHT, :count] = top, below, right
    table[MEMBER : SIGN + 1, : len(entries)] = np.reshape(entries, (-1, 4)).T
    table[COUNT, :4] = in_loops, len(entries), height, rows
    return table


def _loop_members(parent: list[int], end: int, successor: int) -> Block:
    """List the joints of a loop, without those below both its ends, and their signs."""
    paths: list[dict[int, int]] = []
    for j, sign in (successor, -1), (end, 1):
        path = {}
        while j >= 0:
            path[j] = sign
            j = parent[j]
        paths.append(path)
    other, path = paths
    return [m for m in other.items() if m[0] not in path] + [
        m for m in path.items() if m[0] not in other
    ]


def _order_by_neighbours(used: list[list[int]], count: int) -> list[int]:
    """Sort blocks so that those that share columns are close to each other."""
    users: list[list[int]] = [[] for _ in range(count)]
    for block, columns in enumerate(used):
        for c in columns:
            users[c].append(block)
    order = list(range(len(used)))
    # The second time each group begins with the block that came last, at its far end.
    for starts in order, None:
        taken: dict[int, None] = {}
        met = [False] * count
        for start in order[::-1] if starts is None else starts:
            queue = [] if start in taken else [start]
            taken[start] = None
            for block in queue:
                for c in used[block]:
                    for user in () if met[c] else users[c]:
                        if user not in taken:
                            taken[user] = None
                            queue.append(user)
                    met[c] = True
        order = list(taken)
    return order


def _envelope_columns(
    used: list[list[int]], sizes: list[int], order: list[int], count: int, rows: int
) -> tuple[list[int], list[int], list[int], list[int]]:
    """Sort columns as they occur in the blocks; return them, and top, below, right of each."""
    place: dict[int, int] = {}
    last, rightmost, at = [0] * count, [0] * rows, 0
    for block in order:
        for c in used[block]:
            last[place.setdefault(c, len(place))] = at + sizes[block]
        furthest = len(place)
        rightmost[at : at + sizes[block]] = [furthest] * sizes[block]
        at += sizes[block]
    top, below, right = [0] * count, [0] * count, [0] * count
    touched = 0
    for k in range(count):
        below[k] = max(last[k], min(k + 1, rows), below[k - 1] if k else 0)
        right[k] = max(rightmost[below[k] - 1], k + 1)
        # The first reflection that reaches a column gives it its first entry.
        while touched < right[k]:
            top[touched] = k
            touched += 1
    unused = [c for c in range(count) if c not in place]
    return [*place, *unused], top, below, right


@kernel(reference_counting=False)
def fill_envelope(screws, mimics, envelope, F):
    """Fill the loop matrix S_0 and the mimic relations into an envelope, by columns.

    Args:
        screws: in; joint screws (n, 6 or 3), chain units.
        mimics: in; relations between joint positions (g, n).
        envelope: in; the table.
        F: out; the entries of each column from its top on (dependent joints, height).
    """
    for c in range(F.shape[0]):
        for i in range(F.shape[1]):
            F[c, i] = 0.0
    for e in range(envelope[COUNT, ENTRIES]):
        c, at = envelope[COLUMN, e], envelope[PLACE, e]
        j, sign = envelope[MEMBER, e], envelope[SIGN, e]
        if e >= envelope[COUNT, IN_LOOPS]:
            F[c, at] = mimics[sign, j]  # a relation: SIGN is its number
            continue
        for i in range(screws.shape[1]):
            F[c, at + i] = sign * screws[j, i]


def _factor_envelope_by_arrays(F, envelope, diagonal):
    """Factor as `factor_envelope` does: columns that begin at one row are reflected at once."""
    top, below, right = (envelope[row].tolist() for row in (TOP, BELOW, RIGHT))
    for k in range(len(F)):
        v = F[k, k - top[k] : below[k] - top[k]]
        r = np.sqrt(v @ v)
        diagonal[k] = r = -r if v[0] > 0.0 else r
        if r == 0.0:
            continue
        v[0] -= r
        scaled, j = v / (r * v[0]), k + 1
        while j < right[k]:
            end = bisect_right(top, top[j], j, right[k])
            columns = F[j:end, k - top[j] : k - top[j] + v.size]
            columns += (columns @ v)[:, None] * scaled
            j = end


@kernel(reference_counting=False, uncompiled=_factor_envelope_by_arrays)
def factor_envelope(F, envelope, diagonal):
    """Compute the Householder QR of a matrix in its envelope, in place.

    The reflection of column x has ``v = x - r e_1`` with ``r = -sign(x_1) |x|``, so that
    nothing cancels, and takes each column y to ``y + v (v · y) / (r v_1)``.

    `kinematics.numerics.linalg.pseudo_inverse` has reflections of its own, of whole vectors of
    columns: here columns are stored one by one and begin at different rows. A shared kernel
    that makes reflections would cost the inverse a fifth of its time for 30 unknowns; with one
    that applies them column by column it would take 2.5 times as long.

    Args:
        F: in, columns as from `fill_envelope`; out, R above the diagonal, on and below it the
            vector v of each reflection.
        envelope: in; the table.
        diagonal: out; R's diagonal (dependent joints,), 0 for a column that is 0.
    """
    top, below, right = envelope[TOP], envelope[BELOW], envelope[RIGHT]
    for k in range(F.shape[0]):
        v = F[k, k - top[k] : below[k] - top[k]]
        r = 0.0
        for i in range(v.size):
            r += v[i] * v[i]
        r = np.sqrt(r)
        if r == 0.0:
            diagonal[k] = 0.0
            continue
        if v[0] > 0.0:
            r = -r
        diagonal[k] = r
        v[0] -= r
        scale = 1.0 / (r * v[0])
        # y ← y + v (v · y) / (r v_1) for the columns that share rows with this one
        for j in range(k + 1, right[k]):
            y = F[j, k - top[j] :]
            dot = 0.0
            for i in range(v.size):
                dot += v[i] * y[i]
            dot *= scale
            for i in range(v.size):
                y[i] += dot * v[i]


def pivots(screws: Array, mimics: Array, envelope: IntArray, count: int) -> Array:
    """Compute the diagonal of R: the distance of each column from those before, with a sign.

    Args:
        screws: joint screws (n, 6 or 3), chain units.
        mimics: relations (g, n).
        count: how many columns there are.

    Returns:
        Shape (count,), in the order of the columns of the table.
    """
    F, diagonal = np.empty((count, envelope[COUNT, HEIGHT])), np.empty(count)
    fill_envelope(screws, mimics, envelope, F)
    factor_envelope(F, envelope, diagonal)
    return diagonal


def _solve_least_norm_by_arrays(F, envelope, diagonal, b):
    """Solve as `solve_least_norm` does, column by column."""
    top, below = envelope[TOP].tolist(), envelope[BELOW].tolist()
    columns = len(F)
    for k in range(columns):
        if diagonal[k] != 0.0:
            v, y = F[k, k - top[k] : below[k] - top[k]], b[k : below[k]]
            y += (v @ y / (diagonal[k] * v[0])) * v
    for k in range(columns - 1, -1, -1):
        b[k] = b[k] / diagonal[k] if diagonal[k] != 0.0 else 0.0
        b[top[k] : k] -= b[k] * F[k, : k - top[k]]
    return np.sqrt(b[columns:] @ b[columns:])


@kernel(reference_counting=False, uncompiled=_solve_least_norm_by_arrays)
def solve_least_norm(F, envelope, diagonal, b):
    """Compute the least-squares solution of ``S x = b`` from the factors of S.

    Args:
        F: in; as from `factor_envelope`.
        envelope: in; the table.
        diagonal: in; R's diagonal. Unknowns with a 0 there are set to 0.
        b: in, the right-hand side by rows of the envelope; out, x by its columns, then the
            residual in the reflected rows.

    Returns:
        The norm of the residual.
    """
    top, below = envelope[TOP], envelope[BELOW]
    columns = F.shape[0]
    # b ← Qᵀ b, one reflection after the other
    for k in range(columns):
        if diagonal[k] == 0.0:
            continue
        v, y = F[k, k - top[k] : below[k] - top[k]], b[k:]
        dot = 0.0
        for i in range(v.size):
            dot += v[i] * y[i]
        dot /= diagonal[k] * v[0]
        for i in range(v.size):
            y[i] += dot * v[i]
    # R x = b, by columns, the last one first
    for k in range(columns - 1, -1, -1):
        b[k] = b[k] / diagonal[k] if diagonal[k] != 0.0 else 0.0
        x, y = F[k], b[top[k] : k]
        for i in range(y.size):
            y[i] -= b[k] * x[i]
    residual = 0.0
    for i in range(columns, b.size):
        residual += b[i] * b[i]
    return np.sqrt(residual)
