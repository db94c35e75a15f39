"""The compiled loop of `balance.search.many_geometries`: one geometry after the other.

Every array is room that belongs to one thread; see `sweep_workspace`.
"""

from __future__ import annotations

import numpy as np

from balance.conditions.order_kernels import (
    FIRST,
    NEAR,
    planar_conditions_up_to_order,
    spatial_conditions_up_to_order,
    stage_workspace,
)
from balance.transfers.serial_space import (
    DROPPED_CLEARLY,
    KEPT_CLEARLY,
    search_transfers,
    search_workspace,
)
from kinematics.compiled.jit import kernel
from kinematics.linalg.null_space import put_solutions
from kinematics.linalg.pivoted_qr import factor_workspace, refactor, smallest_pivot
from kinematics.linalg.skyline_qr import COUNT, ROWS, factor_envelope, fill_envelope
from kinematics.model.arrays import Chain
from kinematics.tolerances import RANK_MARGIN

__all__ = [
    "closure_residual",
    "place_geometry",
    "planar_sweep",
    "points_on",
    "spatial_sweep",
    "sweep_workspace",
]

# Loops that stay closed to this are those of a linkage that moves.
CLOSED = 1e-11
# Pivots of a loop matrix, and rates of joints, below this part of the largest are left to
# those who look twice.
REGULAR = 1e-2
# Smallest pivots of conditions, relative to the largest, that need no second look.
FIRM = 1e-6
# Axes that deviate by less from those of a plane are rounded.
ROUNDED = 1e-9


@kernel(reference_counting=False)
def points_on(screws, near, points):
    """Find the points of joint axes nearest to given ones: ``n × v + (n · near) n``.

    Args:
        screws: in: joint screws ``[n; v]`` (n, 6), metres.
        near: in: the given points (n, 3), metres; sliding joints have these.
        points: out: (n, 3), metres.
    """
    for j in range(near.shape[0]):
        n, v = screws[j, :3], screws[j, 3:]
        along = n[0] * near[j, 0] + n[1] * near[j, 1] + n[2] * near[j, 2]
        turns = n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            foot = n[a] * v[b] - n[b] * v[a] + along * n[i]
            points[j, i] = foot if turns else near[j, i]


@kernel(reference_counting=False)
def closure_residual(given, sliding, helical):
    """Find the first screw that is not of the kind of its joint.

    Args:
        given: in: joint screws (g, n, 6), metres.
        sliding: in: whether each joint slides (n,).
        helical: in: whether each joint is helical (n,).

    Returns:
        Its number, counted through all geometries; -1 if there is none.
    """
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


@kernel(reference_counting=False)
def _frame(screws, points, centres, origin):
    """Find origin and length of the frame, as in `kinematics.model.chain.arrange_loops`.

    The length is the root mean square of ``|v + n × origin - pitch|`` over turning joints.

    Args:
        screws: in: joint screws ``[n; v]`` (n, 6), metres.
        points: in: points on the joint axes (n, 3), metres.
        centres: in: centres of mass (m, 3), metres.
        origin: out: mean of the points (3,), metres.

    Returns:
        The length, metres; 0 if it is too small for the distances.
    """
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
def place_geometry(
    given, near, centres, R, pivots, relations, screws, mimics, origins, lengths
):
    """Write joint screws and mimic relations in the frame of each geometry.

    ``w = n``, ``v = (v + n × origin) / length`` for joints that turn; a plane takes ``R``.

    Args:
        given: in: joint screws (g, n, 6), metres.
        near: in: points near the joint axes (n, 3), metres.
        centres: in: centres of mass (m, 3), metres.
        R: in: axes of the frame as rows (3, 3).
        pivots: in: joint by which each relation is divided (rows,).
        relations: in: mimic relations (rows, n), SI units.
        screws: out: joint screws in the frame (g, n, dim).
        mimics: out: mimic relations in the frame (g, rows, n).
        origins: out: (g, 3), metres.
        lengths: out: (g,), metres; 0 marks a geometry that is special, -1 one that leaves the
            plane.
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


@kernel(reference_counting=False)
def _regular(screws, mimics, lines, F, diagonal):
    """Decide whether the loop matrix S determines the dependent joints: pivots of its QR.

    Args:
        screws: in: joint screws (n, dim).
        mimics: in: mimic relations (rows, n).
        lines: in: profile of S; see `kinematics.linalg.skyline_qr`.
        F: workspace for its factor.
        diagonal: out: its pivots (nd,).
    """
    fill_envelope(screws, mimics, lines, F)
    factor_envelope(F, lines, diagonal)
    least, largest = np.inf, 0.0
    for d in range(diagonal.size):
        least, largest = min(least, abs(diagonal[d])), max(largest, abs(diagonal[d]))
    return least > REGULAR * largest


@kernel(reference_counting=False)
def _rest(permutation, known, place, left):
    """Sort the entries of a permutation that follow the first ``known`` ones.

    Args:
        permutation: in: (p,).
        known: how many are left out.
        place: workspace (≥ p,).
        left: out: the others, ascending (≥ p - known,).
    """
    for k in range(permutation.size):
        place[permutation[k]] = k
    count = 0
    for j in range(permutation.size):
        if place[j] >= known:
            left[count] = j
            count += 1


def _sweep_kernel(dim):
    """The kernel for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def sweep(topology, geometries, sizes, results, rooms):
        """Find rank, nullity, serial nullity and kmax of each geometry; rank -1 if unsettled.

        Args:
            topology: in: arrays of the chain, as `Chain.walked`; rigid parts, as from `parts`;
                link of each body (bodies,); transfers between bodies of rigid parts (count,
                parameters); directions (rays, width).
            geometries: in: joint screws (g, n, dim), mimic relations (g, rows, n), relative
                sizes of round-off (g,) and lengths of the frames (g,); see `place_geometry`.
            sizes: rays to begin with, momentum components that count, parameters of each body.
            results: out: the four integers (g, 4); smallest pivots, relative to the largest
                (g,); orthonormal bases as rows (g, parameters, parameters), or (0, …).
            rooms: workspace, as from `sweep_workspace`.
        """
        chain, rigid_parts, links, rigid, rays = topology
        screws, mimics, tolerances, lengths = geometries
        fewest, per, size = sizes
        answers, kept, bases = results
        parent, _, ends, _, columns, moves, lines = chain
        to_stage, to_walk, numbers, flat, diagonal, serial, out = rooms
        unknowns, found, nd = links.size * size, to_walk[0], diagonal.size
        own, order, left = numbers[0], numbers[1], numbers[2]
        ranks, permutations = numbers[3], numbers[4]
        F = to_stage[1][0]
        for g in range(screws.shape[0]):
            answers[g, 0] = -1
            s, m, tolerance = screws[g], mimics[g], tolerances[g]
            if (
                lengths[g] <= 0.0 or lines[COUNT, ROWS] < nd
                or not _regular(s, m, lines, F, diagonal)
            ):  # fmt: skip
                continue
            # The serial space: transfers, of which rows of a triangular factor are made.
            count = search_transfers(parent, s, rigid_parts, size, per, tolerance, to_walk)
            gap = to_walk[2]
            if count < 0 or gap[0] < KEPT_CLEARLY or gap[1] > DROPPED_CLEARLY * tolerance:
                continue
            for j in range(unknowns):
                own[j] = j
            height, _, _ = refactor(
                rigid, found[:count], own[:unknowns], tolerance, 1.0, flat, order[:unknowns],
                serial,
            )  # fmt: skip
            _rest(order[:unknowns], height, ranks, left)
            p = unknowns - height
            here = (parent, s, ends, m, columns, moves, lines)
            known = out[:0], own[:p], left[:p], 0.0, 0.0, tolerance, 0
            # The conditions, along twice as many rays each time until they are enough.
            count = fewest
            rank, scale, cut, done, settled = 0, 0.0, 0.0, 0, False
            reach = open = slowest = 1.0
            permutation = permutations[:p]
            result, orders = (ranks, permutation, out), (FIRST, True, 1)
            while count <= rays.shape[0]:
                if dim == 3:
                    rank, scale, cut, done, settled, reach, open, slowest, enough, _ = (
                        planar_conditions_up_to_order(
                            here, links, rays[:count], orders, known, result, to_stage
                        )
                    )
                else:
                    rank, scale, cut, done, settled, reach, open, slowest, enough, _ = (
                        spatial_conditions_up_to_order(
                            here, links, rays[:count], orders, known, result, to_stage
                        )
                    )
                if enough:
                    break
                count *= 2
            # Written so that a NaN is looked at twice.
            if count > rays.shape[0] or not (settled and open <= CLOSED and slowest >= REGULAR):
                continue
            R = out[:rank]
            least = smallest_pivot(R, permutation)
            firm = (
                least >= max(FIRM, RANK_MARGIN * tolerance) * scale
                and cut <= DROPPED_CLEARLY * tolerance * scale
            )
            if reach < NEAR or not firm:
                continue
            kmax = done - 1
            while kmax > 0 and ranks[kmax] == ranks[kmax - 1]:
                kmax -= 1
            answers[g, 0], answers[g, 1] = rank, unknowns - rank
            answers[g, 2], answers[g, 3] = height, kmax
            kept[g] = least / scale if rank > 0 else 1.0
            if bases.shape[0] > 0:
                basis = bases[g, : unknowns - rank]
                put_solutions(serial[:height], R, permutation, left, basis)

    return sweep


spatial_sweep, planar_sweep = _sweep_kernel(6), _sweep_kernel(3)


def sweep_workspace(
    chain: Chain, rays: int, rigid: int, per: int, size: int
) -> tuple[object, ...]:
    """Room for a sweep.

    Args:
        chain: one of the linkages.
        rays: how many there are.
        rigid: transfers between bodies of rigid parts.
        per: momentum components of each column.
        size: parameters of each body.
    """
    n, dim = chain.screws.shape
    unknowns, transfers = chain.links.size * size, 4 * (2 * n + size)
    return (
        stage_workspace(chain, rays, FIRST, per, size, unknowns),
        search_workspace(n, dim, unknowns, size, per, transfers),
        np.empty((5, max(unknowns, FIRST + 1)), np.int64),
        factor_workspace(unknowns, rigid + 2 * transfers), np.empty(chain.dependent.size),
        np.empty((unknowns, unknowns)), np.empty((unknowns, unknowns)),
    )  # fmt: skip
