"""Compiled kernels: Taylor expansions of closed motions at many poses, one in each lane.

Recursion and symbols are those of `kinematics.closure.taylor.expansion_kernels`, the integers
those of `kinematics.closure.taylor.layout`. There the products of one pose lie side by side;
here those of as many poses as a vector has lanes, which is the last axis of every array.
Products of one degree:

    ω × r, ω × a, a Dq

of each arm r, axis a with its link's angular velocity ω, and slide.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.closure.taylor.lane_vectors import (
    fill_vectors,
    slide_vectors,
    solve_monomials,
    turn_vectors,
)
from kinematics.closure.taylor.layout import SECTION, SIZE, Layout
from kinematics.numerics.array_types import Array
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import (
    VECTOR_WIDTH,
    broadcast,
    lanes,
    load_vector,
    store_vector,
)
from kinematics.numerics.linalg.lane_inverse import lane_pseudo_inverse

# Monomials that are written of one pose before the next: their rates stay in the cache, and
# lines of memory follow each other.
MONOMIALS_AT_ONCE = 8


class ExpansionLanes(NamedTuple):
    """Workspace of an expansion; the last axis is that of the lanes.

    Attributes:
        screws: joint screws (n, 6 or 3, lanes).
        S: loop matrix (rows, n, lanes).
        points: points of the joints, then of the cuts (…, 3 or 2, lanes).
        pitch: pitch of each joint (n, lanes).
        starts: arms, then axes at the pose (arms + axes, 3 or 2, lanes).
        A: rows of S that are solved, and its dependent columns (m, d, lanes).
        reflected: as `lane_pseudo_inverse` takes it (m, d + m, lanes).
        P: pseudo-inverse (d, m, lanes).
        E: as `lane_pseudo_inverse` takes it (d, d + 1, lanes).
        condition: condition number (1, lanes).
        b: right-hand side of one monomial (rows, lanes).
        rates: joint rates (monomials, n, lanes).
        omega: angular velocities of the links (n, monomials, 3 or 1, lanes).
        vectors: arms, then axes (arms + axes, monomials, 3 or 2, lanes).
        turned: ``ω × r`` of arms, then axes, products of lower degrees, likewise.
        slid: ``a Dq`` of axes, likewise (axes, monomials, 3 or 2, lanes).
    """

    screws: Array
    S: Array
    points: Array
    pitch: Array
    starts: Array
    A: Array
    reflected: Array
    P: Array
    E: Array
    condition: Array
    b: Array
    rates: Array
    omega: Array
    vectors: Array
    turned: Array
    slid: Array


def lane_expansion_workspace(layout: Layout, dim: int) -> ExpansionLanes:
    """Allocate the workspace of an expansion.

    Args:
        layout: as from `packed_layout`.
        dim: components of a screw, 6 or 3.
    """
    length = dict(zip(SECTION._fields, np.diff(layout.whole[: len(SECTION) + 1]), strict=True))
    (M, n), (space, turns) = layout.shape, (3, 3) if dim == 6 else (2, 1)
    width = layout.whole[layout.whole[SECTION.sizes] + SIZE.width]
    loops, arms, axes = length["ends"] // 2, length["arms"] // 3, length["axes"] // 5
    rows = loops * dim + (layout.real.size - n * width) // max(n, 1)
    m, nd, vectors = length["equations"], length["dependent"], arms + axes
    return ExpansionLanes(
        lanes(n, dim),
        lanes(rows, n),
        lanes(n + length["cuts"], space),
        lanes(n),
        lanes(vectors, space),
        lanes(m, nd),
        lanes(m, nd + m),
        lanes(nd, m),
        lanes(nd, nd + 1),
        lanes(1),
        lanes(rows),
        lanes(M, n),
        lanes(n, M, turns),
        lanes(vectors, M, space),
        lanes(vectors, M, space),
        lanes(axes, M, space),
    )


@kernel(reference_counting=False)
def _fill_loops(parent, ends, mimics, equations, dependent, screws, S, A):
    """Fill the loop matrix of every lane, and its part that is solved; see `fill_loop_matrix`.

    Args:
        parent: in; link before each joint (n,).
        ends: in; links on side A and side B of each weld (L, 2).
        mimics: in; relations (g, n).
        equations: in; rows that are solved (m,).
        dependent: in; dependent joints (d,).
        screws: in; (n, 6 or 3, lanes).
        S: out; (rows, n, lanes).
        A: out; (m, d, lanes).
    """
    dim = screws.shape[1]
    for r in range(S.shape[0]):
        relation = r - ends.shape[0] * dim
        for j in range(S.shape[1]):
            value = mimics[relation, j] if relation >= 0 else 0.0
            store_vector(S[r, j], 0, broadcast(value))
    for loop in range(ends.shape[0]):
        for side in range(2):
            sign, j = broadcast(1.0 - 2.0 * side), ends[loop, side]
            while j >= 0:
                for i in range(dim):
                    at = S[loop * dim + i, j]
                    entry = sign * load_vector(screws[j, i], 0)
                    store_vector(at, 0, load_vector(at, 0) + entry)
                j = parent[j]
    for r in range(A.shape[0]):
        for d in range(A.shape[1]):
            store_vector(A[r, d], 0, load_vector(S[equations[r], dependent[d]], 0))


@kernel(reference_counting=False)
def _fill_starts(parent, cuts, arms, axes, screws, points, pitch, starts):
    """Compute points, pitches, and arms and axes at the pose; see `fill_points`.

    Args:
        parent: in; link before each joint (n,).
        cuts: in; link whose joint has the point of a cut, -1 for the origin (L,).
        arms: in; as in `kinematics.closure.taylor.layout`, as are the axes.
        axes: in.
        screws: in; (n, 6 or 3, lanes).
        points: out; (n + L, 3 or 2, lanes).
        pitch: out; (n, lanes).
        starts: out; (arms + axes, 3 or 2, lanes).
    """
    n, dim, space, zero = parent.size, screws.shape[1], points.shape[1], broadcast(0.0)
    first = dim - space
    for j in range(n):
        s, rise = screws[j], zero
        # A joint turns in all lanes, or in none.
        turns = s[0, 0] != 0.0 or (dim == 6 and (s[1, 0] != 0.0 or s[2, 0] != 0.0))
        for i in range(space):
            point = zero
            if turns and space == 3:
                u, v = (i + 1) % 3, (i + 2) % 3
                point = load_vector(s[u], 0) * load_vector(s[3 + v], 0)
                point = point - load_vector(s[v], 0) * load_vector(s[3 + u], 0)
                rise = rise + load_vector(s[i], 0) * load_vector(s[3 + i], 0)
            elif turns:
                point = load_vector(s[0], 0) * load_vector(s[2 - i], 0)
                point = zero - point if i == 0 else point
            elif parent[j] >= 0:
                point = load_vector(points[parent[j], i], 0)
            store_vector(points[j, i], 0, point)
        store_vector(pitch[j], 0, rise if turns else broadcast(1.0))
    for cut in range(cuts.size):
        for i in range(space):
            at = load_vector(points[max(cuts[cut], 0), i], 0)
            store_vector(points[n + cut, i], 0, at if cuts[cut] >= 0 else zero)
    for i in range(space):
        for h in range(arms.shape[0]):
            end, begin = points[arms[h, 1], i], points[arms[h, 0], i]
            store_vector(starts[h, i], 0, load_vector(end, 0) - load_vector(begin, 0))
        for h in range(axes.shape[0]):
            # the angular part of the screw of a joint that turns, or else the linear part
            part = screws[axes[h, 1], i + (0 if axes[h, 2] > 0 else first)]
            store_vector(starts[arms.shape[0] + h, i], 0, load_vector(part, 0))


@kernel(reference_counting=False)
def _fill_degree_1(columns, equations, dependent, S, P, rates):
    """Compute the joint rates of degree 1: ``Dq = C - S_0⁺ S_0 C`` with the columns C.

    Args:
        columns: in; rates of the independent joints (n, width).
        equations: in; rows that are solved (m,).
        dependent: in; dependent joints (d,).
        S: in; (rows, n, lanes).
        P: in; (d, m, lanes).
        rates: out; the monomials of degree 1 are 1, 2, … (monomials, n, lanes).
    """
    for w in range(columns.shape[1]):
        for j in range(columns.shape[0]):
            store_vector(rates[1 + w, j], 0, broadcast(columns[j, w]))
        for r in range(equations.size):
            b = broadcast(0.0)
            for j in range(columns.shape[0]):
                b = b - load_vector(S[equations[r], j], 0) * broadcast(columns[j, w])
            for d in range(dependent.size):
                at = rates[1 + w, dependent[d]]
                store_vector(at, 0, load_vector(at, 0) + load_vector(P[d, r], 0) * b)


@kernel(reference_counting=False)
def _put_coefficients(rates, units, joints, out):
    """Write the coefficients of the poses in use, some monomials of one pose after the other.

    Args:
        rates: in; joint rates (monomials, n, lanes).
        units: in; a factor of every coefficient (monomials, n).
        joints: in; column of each joint in the result (n,).
        out: out; (poses, monomials, columns).
    """
    M, n = units.shape
    for first in range(0, M, MONOMIALS_AT_ONCE):
        for pose in range(out.shape[0]):
            for t in range(first, min(first + MONOMIALS_AT_ONCE, M)):
                for j in range(n):
                    out[pose, t, joints[j]] = rates[t, j, pose] * units[t, j]


def _lanes_kernel(dim):
    """Make the kernel for screws of ``dim`` components: 6 in space, 3 in a plane."""
    space = 3 if dim == 6 else 2

    @kernel(reference_counting=False)
    def expand(whole, real, screws, units, numbers, out, conditions, work):
        """Compute the coefficients of the joint positions at all poses.

        Args:
            whole: in; integers, in the sections of `kinematics.closure.taylor.layout`.
            real: in; columns (n, width), then mimic relations (g, n), flat.
            screws: in; joint screws (poses, n, 6 or 3).
            units: in; a factor of the rates ``Dq`` in every coefficient (monomials, n).
            numbers: in; column of each joint in the result (n,).
            out: in, zeros, and out; coefficients beyond the constant (poses, monomials,
                columns).
            conditions: out; condition number of the equations at each pose (poses,).
            work: workspace, as from `lane_expansion_workspace`.
        """
        sizes = whole[whole[SECTION.sizes] : whole[SECTION.sizes + 1]]
        parent = whole[whole[SECTION.parent] : whole[SECTION.parent + 1]]
        ends = whole[whole[SECTION.ends] : whole[SECTION.ends + 1]].reshape(-1, 2)
        dependent = whole[whole[SECTION.dependent] : whole[SECTION.dependent + 1]]
        equations = whole[whole[SECTION.equations] : whole[SECTION.equations + 1]]
        joints = whole[whole[SECTION.joints] : whole[SECTION.joints + 1]].reshape(-1, 3)
        arms = whole[whole[SECTION.arms] : whole[SECTION.arms + 1]].reshape(-1, 3)
        axes = whole[whole[SECTION.axes] : whole[SECTION.axes + 1]].reshape(-1, 5)
        terms = whole[whole[SECTION.terms] : whole[SECTION.terms + 1]].reshape(-1, 3)
        cuts = whole[whole[SECTION.cuts] : whole[SECTION.cuts + 1]]
        degrees = whole[whole[SECTION.degrees] : whole[SECTION.degrees + 1]]
        places = whole[whole[SECTION.places] : whole[SECTION.places + 1]].reshape(-1, 2)
        pairs = whole[whole[SECTION.pairs] : whole[SECTION.pairs + 1]].reshape(-1, 2)
        n, width, order = sizes[SIZE.joints], sizes[SIZE.width], degrees.size - 2
        columns, mimics = real[: n * width].reshape(n, width), real[n * width :].reshape(-1, n)
        s, S, points, pitch, starts, A, reflected, P, E, condition = work[:10]
        b, rates, omega, vectors, turned, slid = work[10:]
        few, count = arms.shape[0], arms.shape[0] + axes.shape[0]
        for block in range(0, screws.shape[0], VECTOR_WIDTH):
            for lane in range(VECTOR_WIDTH):
                here = screws[min(block + lane, screws.shape[0] - 1)]
                condition[0, lane] = 1.0
                for j in range(n):
                    for i in range(dim):
                        s[j, i, lane] = here[j, i]
            _fill_loops(parent, ends, mimics, equations, dependent, s, S, A)
            if dependent.size > 0:
                lane_pseudo_inverse(A, reflected, P, E, condition[0])
            _fill_starts(parent, cuts, arms, axes, s, points, pitch, starts)
            _fill_degree_1(columns, equations, dependent, S, P, rates)
            for k in range(1, order + 1):
                begin, end = degrees[k], degrees[k + 1]
                # The last degree needs no turned axes.
                for h in range(count if 1 < k < order else few if k > 1 else 0):
                    link = arms[h, 0] if h < few else axes[h - few, 0]
                    turn_vectors(
                        begin,
                        end,
                        places,
                        pairs,
                        space,
                        omega[link].reshape(-1),
                        vectors[h].reshape(-1),
                        turned[h].reshape(-1),
                    )
                for h in range(count - few if k > 1 else 0):
                    slide_vectors(
                        begin,
                        end,
                        places,
                        pairs,
                        space,
                        axes[h, 1],
                        n,
                        rates.reshape(-1),
                        vectors[few + h].reshape(-1),
                        slid[h].reshape(-1),
                    )
                if k > 1:
                    solve_monomials(
                        begin,
                        end,
                        axes,
                        terms,
                        points,
                        pitch,
                        turned,
                        slid,
                        P,
                        dependent,
                        equations,
                        b,
                        rates,
                    )
                if k < order:
                    fill_vectors(
                        k,
                        begin,
                        end,
                        joints,
                        arms,
                        axes,
                        s,
                        starts,
                        pitch,
                        rates,
                        turned,
                        slid,
                        omega,
                        vectors,
                    )
            used = min(VECTOR_WIDTH, screws.shape[0] - block)
            for lane in range(used):
                conditions[block + lane] = condition[0, lane]
            _put_coefficients(rates, units, numbers, out[block : block + used])

    return expand


spatial_lanes, planar_lanes = _lanes_kernel(6), _lanes_kernel(3)
