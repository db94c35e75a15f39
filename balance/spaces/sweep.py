"""The compiled loop of `balance.spaces.geometries`: one geometry after the other."""

from __future__ import annotations

import numpy as np

from balance.conditions.elimination import MARGIN, absorbed, others, round_off, smallest_pivot
from balance.conditions.orders import FIRST, NEAR, stage
from balance.conditions.solutions import solutions
from balance.transfers.clusters import parts
from balance.transfers.opening import CLEAR, SURE, search
from kinematics.kernels import kernel
from kinematics.profile import factor, fill, profile

__all__ = ["misfit", "place", "points_on", "sweep"]

# Loops that stay closed to this are those of a linkage that moves.
CLOSED = 1e-11
# Pivots of a loop matrix, and rates of joints, below this part of the largest are left to
# those who look twice.
REGULAR = 1e-2
# Smallest pivots of conditions, relative to the largest, that need no second look.
FIRM = 1e-6
# Axes that deviate by less from those of a plane are rounded.
ROUNDED = 1e-9


@kernel(borrows=True)
def points_on(screws, near, points):
    """Points of the joint axes nearest to those in ``near`` (n, 3)."""
    for j in range(near.shape[0]):
        n, v = screws[j, :3], screws[j, 3:]
        along = n[0] * near[j, 0] + n[1] * near[j, 1] + n[2] * near[j, 2]
        turns = n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            foot = n[a] * v[b] - n[b] * v[a] + along * n[i]
            points[j, i] = foot if turns else near[j, i]


@kernel(borrows=True)
def misfit(given, sliding, helical):
    """The first screw that is not of the kind of its joint, counted through; -1 if none."""
    count, n = given.shape[:2]
    for g in range(count):
        for j in range(n):
            s, axis, moment, along, largest = given[g, j], 0.0, 0.0, 0.0, 1.0
            for i in range(3):
                axis += s[i] * s[i]
                moment += s[3 + i] * s[3 + i]
                along += s[i] * s[3 + i]
                largest = max(largest, abs(s[3 + i]))
            size = moment if sliding[j] else axis
            # Written so that a NaN fits no joint.
            level = abs(along) < np.inf if helical[j] else abs(along) <= ROUNDED * largest
            if not (abs(size - 1.0) <= ROUNDED and (axis != 0.0) != sliding[j] and level):
                return g * n + j
    return -1


@kernel(borrows=True)
def _frame(screws, points, centres, origin):
    """Origin and length of the frame, as in `kinematics.chain.arrange`; 0 for special ones."""
    n = points.shape[0]
    for i in range(3):
        origin[i] = 0.0
        for j in range(n):
            origin[i] += points[j, i] / n
    largest = far = total = 0.0
    turning = 0
    for j in range(n):
        w, v = screws[j, :3], screws[j, 3:]
        square = size = along = arm = 0.0
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            square += (points[j, i] - origin[i]) ** 2
            largest = max(largest, abs(points[j, i]))
            size += w[i] * w[i]
            moment = v[i] + w[a] * origin[b] - w[b] * origin[a]
            arm += moment * moment
            along += moment * w[i]
        far = max(far, square)
        if size > 0.0:
            turning += 1
            total += arm - along * along
    far = np.sqrt(far)
    for c in range(centres.shape[0]):
        square = 0.0
        for i in range(3):
            square += (centres[c, i] - origin[i]) ** 2
            largest = max(largest, abs(centres[c, i]))
        far = max(far, np.sqrt(square))
    length = np.sqrt(total / turning) if turning else 0.0
    return length if length > max(1e-9 * largest, 1e-4 * far) else 0.0


@kernel
def place(given, near, centres, R, pivots, relations, screws, mimics, origins, lengths):
    """Joint screws and mimic relations in the frame of each geometry.

    A length of 0 marks a geometry that is special, and -1 one that leaves the plane.
    """
    n, dim = screws.shape[1:]
    points, w, v = np.empty((n, 3)), np.empty(3), np.empty(3)
    for g in range(given.shape[0]):
        points_on(given[g], near, points)
        origin = origins[g]
        L = lengths[g] = _frame(given[g], points, centres, origin)
        if L == 0.0:
            continue
        for j in range(n):
            s = given[g, j]
            turns = s[0] != 0.0 or s[1] != 0.0 or s[2] != 0.0
            unit = L if turns else 1.0
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                w[i] = s[i]
                v[i] = (s[3 + i] + s[a] * origin[b] - s[b] * origin[a]) / unit
            for row in range(relations.shape[0]):
                mimics[g, row, j] = relations[row, j] * (1.0 if turns else L)
            if dim == 6:
                for i in range(3):
                    screws[g, j, i], screws[g, j, 3 + i] = w[i], v[i]
                continue
            for i in range(3):
                turned = R[i, 0] * w[0] + R[i, 1] * w[1] + R[i, 2] * w[2]
                moved = R[i, 0] * v[0] + R[i, 1] * v[1] + R[i, 2] * v[2]
                if i < 2:
                    screws[g, j, 1 + i] = moved
                    if abs(turned) > ROUNDED:
                        lengths[g] = -1.0
                else:
                    screws[g, j, 0] = np.rint(turned)
                    if abs(moved) > ROUNDED:
                        lengths[g] = -1.0
        for row in range(relations.shape[0]):
            pivot = mimics[g, row, pivots[row]]
            for j in range(n):
                mimics[g, row, j] /= pivot


@kernel(borrows=True)
def _regular(parent, screws, ends, mimics, lines, F, diagonal):
    """Whether the loop matrix determines the dependent joints well."""
    fill(parent, screws, ends, mimics, lines, F)
    factor(F, lines, diagonal)
    least, largest = np.inf, 0.0
    for d in range(diagonal.size):
        least, largest = min(least, abs(diagonal[d])), max(largest, abs(diagonal[d]))
    return least > REGULAR * largest


@kernel
def sweep(
    parent, screws, ends, mimics, dependent, columns, moves, links, rigid, rays, fewest, per,
    size, origins, lengths, answers, kept, bases,
):  # fmt: skip
    """Rank, nullity, serial nullity and kmax of each geometry; rank -1 if not settled."""
    unknowns = links.size * size
    node, body, owner = parts(parent, ends, links)
    lines, S, rows = profile(parent, ends, mimics[0], dependent, screws.shape[2])
    diagonal, own = np.empty(dependent.size), np.arange(unknowns)
    none = np.empty(0, np.int64)
    for g in range(screws.shape[0]):
        answers[g, 0] = -1
        s, m = screws[g], mimics[g]
        if (
            lengths[g] <= 0.0 or rows < dependent.size
            or not _regular(parent, s, ends, m, lines, S, diagonal)
        ):  # fmt: skip
            continue
        floor = round_off(origins[g], lengths[g])
        found, _, count, gap = search(parent, s, node, body, owner, unknowns, size, per, floor)
        if gap[0] < CLEAR or gap[1] > SURE * floor:
            continue
        known, order, _, _ = absorbed(rigid, found[:count], own, floor, 1.0)
        left = others(order, known.shape[0])
        p = left.size
        count = fewest
        while count <= rays.shape[0]:
            R, permutation, scale, cut, ranks, settled, reach, open, slowest, enough, _ = stage(
                parent, s, ends, m, dependent, columns, moves, links, rays[:count], per, size,
                FIRST, True, 1, np.empty((0, p)), own[:p], 0.0, 0.0, left, floor, none,
            )  # fmt: skip
            if enough:
                break
            count *= 2
        # Written so that a NaN is looked at twice.
        if count > rays.shape[0] or not (settled and open <= CLOSED and slowest >= REGULAR):
            continue
        least = smallest_pivot(R, permutation)
        firm = least >= max(FIRM, MARGIN * floor) * scale and cut <= SURE * floor * scale
        if reach < NEAR or not firm:
            continue
        kmax = ranks.size - 1
        while kmax > 0 and ranks[kmax] == ranks[kmax - 1]:
            kmax -= 1
        rank = R.shape[0]
        answers[g, 0], answers[g, 1] = rank, unknowns - rank
        answers[g, 2], answers[g, 3] = known.shape[0], kmax
        kept[g] = least / scale if rank > 0 else 1.0
        if bases.shape[0] > 0:
            basis = solutions(known, R, permutation, left)
            for i in range(unknowns - rank):
                for j in range(unknowns):
                    bases[g, i, j] = basis[i, j]
