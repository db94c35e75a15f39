"""Loop matrices factorised within their profile: what couples few loops costs little.

Each loop gives a block of rows, each mimic relation one row. They are put into an order in
which neighbours share joints (E. Cuthill and J. McKee, 1969), and columns into the order in
which they first occur; then Householder's reflections stay within a profile of the matrix,
and only that is stored: of each column the rows ``TOP`` to ``BELOW``. (A. George and J.
W.-H. Liu, Computer Solution of Large Sparse Positive Definite Systems, 1981.)

A profile is one array of whole numbers, whose lines are named by the constants below: the
first row of each block of rows, the joint of each column, the rows between which it has
entries, and the column at which its reflection ends. Four lines list the entries: the joint,
the column, the row within it, and the sign with which the joint's screw is put there; those of
mimic relations come last, with the relation in the place of the sign. The last line counts
entries of loops, all entries, the height and the rows. It depends on who is joined to whom
alone, so that it is made once for a chain, without a kernel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinematics.compiled.jit import kernel

__all__ = [
    "COUNT", "HEIGHT", "JOINT", "ROW", "ROWS", "factor", "fill", "pivots", "profile", "solve",
]  # fmt: skip

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# Up to as many blocks of rows a matrix is taken as full.
FEW = 8
ROW, JOINT, TOP, BELOW, RIGHT, MEMBER, COLUMN, PLACE, SIGN, COUNT = range(10)
# Entries of the last line.
IN_LOOPS, ENTRIES, HEIGHT, ROWS = range(4)


def profile(
    parent: IntArray, ends: IntArray, mimics: Array, dependent: IntArray, dim: int
) -> IntArray:
    """The profile of the loop matrix of the dependent joints.

    Args:
        parent: as in `kinematics.model.arrays.Chain`, as are the next three.
        ends: loops.
        mimics: relations.
        dependent: joints that have columns.
        dim: components of a twist, 6 or 3.
    """
    loops, count = len(ends), dependent.size
    position = {j: c for c, j in enumerate(dependent.tolist())}
    above = parent.tolist()
    blocks = [_members(above, *pair) for pair in ends.tolist()]
    blocks += [[(j, r) for j in np.flatnonzero(row).tolist()] for r, row in enumerate(mimics)]
    blocks = [[member for member in block if member[0] in position] for block in blocks]
    sizes = [dim] * loops + [1] * len(mimics)
    used = [[position[j] for j, _ in block] for block in blocks]
    order = _neighbours_first(used, count) if len(blocks) > FEW else list(range(len(blocks)))
    row = np.cumsum([0] + [sizes[block] for block in order]).tolist()
    rows = row.pop()
    first = dict(zip(order, row, strict=True))
    if len(blocks) > FEW:
        columns, top, below, right = _narrow(used, sizes, order, count, rows)
    else:
        columns, top, below, right = (
            list(range(count)),
            [0] * count,
            [rows] * count,
            [count] * count,
        )
    place = {c: k for k, c in enumerate(columns)}
    entries = [
        (j, place[position[j]], first[b] - top[place[position[j]]], sign)
        for b, block in enumerate(blocks) for j, sign in block
    ]  # fmt: skip
    in_loops = sum(map(len, blocks[:loops]))
    height = max((end - begin for begin, end in zip(top, below, strict=True)), default=0)
    lines = np.zeros((10, max(4, rows, count, len(entries))), np.int64)
    lines[ROW, : len(blocks)] = [first[b] for b in range(len(blocks))]
    lines[JOINT, :count] = dependent[columns]
    lines[TOP, :count], lines[BELOW, :count], lines[RIGHT, :count] = top, below, right
    lines[MEMBER : SIGN + 1, : len(entries)] = np.reshape(entries, (-1, 4)).T
    lines[COUNT, :4] = in_loops, len(entries), height, rows
    return lines


def _members(parent: list[int], end: int, successor: int) -> list[tuple[int, int]]:
    """Joints of a loop, without those below both its ends, and their signs."""
    ways: list[dict[int, int]] = []
    for j, sign in (successor, -1), (end, 1):
        way = {}
        while j >= 0:
            way[j] = sign
            j = parent[j]
        ways.append(way)
    other, way = ways
    return [m for m in other.items() if m[0] not in way] + [
        m for m in way.items() if m[0] not in other
    ]


def _neighbours_first(used: list[list[int]], count: int) -> list[int]:
    """Blocks in an order in which those that share columns are close to each other."""
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


def _narrow(
    used: list[list[int]], sizes: list[int], order: list[int], count: int, rows: int
) -> tuple[list[int], list[int], list[int], list[int]]:
    """Columns in the order in which they occur, and the profile of each, which is narrow."""
    place: dict[int, int] = {}
    last, reach, at = [0] * count, [0] * rows, 0
    for block in order:
        for c in used[block]:
            last[place.setdefault(c, len(place))] = at + sizes[block]
        furthest = len(place)
        reach[at : at + sizes[block]] = [furthest] * sizes[block]
        at += sizes[block]
    top, below, right = [0] * count, [0] * count, [0] * count
    touched = 0
    for k in range(count):
        below[k] = max(last[k], min(k + 1, rows), below[k - 1] if k else 0)
        right[k] = max(reach[below[k] - 1], k + 1)
        # The first reflection that reaches a column gives it its first entry.
        while touched < right[k]:
            top[touched] = k
            touched += 1
    unused = [c for c in range(count) if c not in place]
    return [*place, *unused], top, below, right


@kernel(reference_counting=False)
def fill(screws, mimics, lines, F):
    """Loop matrix S_0 and mimic relations in the order of a profile, by columns.

    Args:
        screws: joint screws.
        mimics: relations, as in `kinematics.model.arrays.Chain`.
        lines: the profile.
        F: takes the entries of each column from its top on (dependent joints, height).
    """
    for c in range(F.shape[0]):
        for i in range(F.shape[1]):
            F[c, i] = 0.0
    for e in range(lines[COUNT, ENTRIES]):
        c, at, j, sign = lines[COLUMN, e], lines[PLACE, e], lines[MEMBER, e], lines[SIGN, e]
        if e >= lines[COUNT, IN_LOOPS]:
            F[c, at] = mimics[sign, j]
            continue
        for i in range(screws.shape[1]):
            F[c, at + i] = sign * screws[j, i]


@kernel(reference_counting=False)
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


def pivots(screws: Array, mimics: Array, lines: IntArray, count: int) -> Array:
    """Distances of the columns of the loop matrix from those before them, with signs.

    Args:
        screws: joint screws.
        mimics: relations.
        lines: the profile.
        count: how many columns there are.
    """
    F, diagonal = np.empty((count, lines[COUNT, HEIGHT])), np.empty(count)
    fill(screws, mimics, lines, F)
    factor(F, lines, diagonal)
    return diagonal


@kernel(reference_counting=False)
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
