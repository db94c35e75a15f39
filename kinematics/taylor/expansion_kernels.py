"""The closed motion as polynomials in the inputs: the compiled kernel of Taylor expansions.

Every quantity is a power series in the independent coordinates u, sorted by degree. The
radial derivative ``D = Σ u_i ∂/∂u_i`` multiplies degree k by k, so that the recursion along a
ray (see `kinematics.closure.series`) holds with polynomials for numbers and D for d/dt. The
fewest products are needed if links carry vectors instead of screws: the axes a_j of their
joints, and arms r_j from a point of the joint before a link to one of the joint after it:

    ω_j   = ω_parent + a_j Dq_j                   (j turns)
    D a_j = ω_parent × a_j
    D r_j = ω_parent × r_j + λ_j a_j Dq_j         (λ_j: pitch; revolute 0, prismatic 1)
    0     = Σ a_j Dq_j, Σ D r_j                   (each loop, A minus B; j turns in the first)

Of degree k, products of parts of lower degrees are known; the matrix of the unknown Dq is the
loop matrix S_0 of the screws, and its pseudo-inverse answers each product. All products of
one degree are formed at once, each on a *lane* of its own. (J. J. de Jong, PhD thesis,
University of Twente, Eq. 4.30, has the same derivatives with Kronecker products and without
symmetry.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinematics.closure.series import fill_loop_matrix
from kinematics.compiled.jit import kernel
from kinematics.compiled.simd import LANES, load, spread, store
from kinematics.linalg.pseudo_inverse import pseudo_inverse
from kinematics.taylor.layout import Layout
from kinematics.taylor.monomials import multiply

__all__ = ["polynomials"]

Array = NDArray[np.float64]


@kernel
def _fill_points(parent, screws, cuts, points, pitch):
    """Points of the joints, then of the cuts; a slider has that of the joint before it."""
    n, space = parent.size, points.shape[1]
    for j in range(n):
        s, at = screws[j], points[j]
        if space == 2:
            turns = s[0] != 0.0
            at[0], at[1] = -s[0] * s[2], s[0] * s[1]
        else:
            turns = s[0] != 0.0 or s[1] != 0.0 or s[2] != 0.0
            pitch[j] = s[0] * s[3] + s[1] * s[4] + s[2] * s[5]
            for i in range(3):
                u, v = (i + 1) % 3, (i + 2) % 3
                at[i] = s[u] * s[3 + v] - s[v] * s[3 + u]
        if not turns:
            pitch[j] = 1.0
            for i in range(space):
                at[i] = points[parent[j], i] if parent[j] >= 0 else 0.0
    for loop in range(cuts.size):
        for i in range(space):
            points[n + loop, i] = points[cuts[loop], i] if cuts[loop] >= 0 else 0.0


@kernel
def _add(factor, G, row, K, lane, width):
    """Add a row of G to that of a lane in K."""
    for d in range(width):
        K[lane * width + d] += factor * G[row * width + d]


@kernel
def _spatial_responses(G, width, axes, terms, points, pitch, K):
    """Rates of the dependent joints that each product of known parts calls for."""
    for q in range(terms.shape[0]):
        row, sign, vector = terms[q, 0], float(terms[q, 1]), terms[q, 2]
        if vector >= 0:
            for i in range(3):
                _add(-sign, G, row + 3 + i, K, 6 * vector + i, width)
                _add(sign, G, row + 3 + i, K, 6 * vector + 3 + i, width)
            continue
        j, slide = axes[vector, 1], axes[vector, 4]
        for i in range(3):
            u, v = (i + 1) % 3, (i + 2) % 3
            _add(-sign * pitch[j], G, row + 3 + i, K, slide + i, width)
            if axes[vector, 2] > 0:
                _add(-sign, G, row + i, K, slide + i, width)
                _add(-sign * points[j, v], G, row + 3 + u, K, slide + i, width)
                _add(sign * points[j, u], G, row + 3 + v, K, slide + i, width)


@kernel
def _planar_responses(G, width, axes, terms, K):
    """As `_spatial_responses`, in a plane."""
    for q in range(terms.shape[0]):
        row, sign, vector = terms[q, 0], float(terms[q, 1]), terms[q, 2]
        if vector >= 0:
            _add(-sign, G, row + 2, K, 2 * vector, width)
            _add(sign, G, row + 1, K, 2 * vector + 1, width)
        else:
            slide = axes[vector, 4]
            _add(-sign, G, row + 1, K, slide, width)
            _add(-sign, G, row + 2, K, slide + 1, width)


@kernel
def _solve(begin, end, few, lanes, Z, K, dependent, x, rates):
    """Rates of the dependent joints (M, n) from the products of known parts."""
    for t in range(begin, end):
        for y in range(0, x.size, LANES):
            total = spread(0.0)
            for lane in range(few):
                total = total + spread(Z[t * lanes + lane]) * load(K, lane * x.size + y)
            store(x, y, total)
        for d in range(dependent.size):
            rates[t, dependent[d]] = x[d]


@kernel
def _planar_vectors(
    k, begin, end, lanes, joints, arms, axes, screws, starts, rates, omega, Z, left, right
):
    """As `_spatial_vectors`, in a plane."""
    few, part = arms.shape[0], 1.0 / k
    for t in range(begin, end):
        here = slice(t * lanes, (t + 1) * lanes)
        one, two, z = left[here], right[here], Z[here]
        for h in range(joints.shape[0]):
            j, p = joints[h, 0], joints[h, 1]
            omega[j, 0] = screws[j, 0] * rates[t, j] + (omega[p, 0] if p >= 0 else 0.0)
        for h in range(few):
            w, axis, x, y = omega[arms[h, 0], 0], arms[h, 2], 2 * h, 2 * h + 1
            rx, ry = -(w * starts[h, 1] + z[y]), w * starts[h, 0] + z[x]
            if axis >= 0:
                rate, slide = rates[t, axes[axis, 1]], axes[axis, 4]
                rx += starts[few + axis, 0] * rate + z[slide]
                ry += starts[few + axis, 1] * rate + z[slide + 1]
            one[x], one[y], two[x], two[y] = w, w, part * rx, part * ry
        for h in range(axes.shape[0]):
            w, rate = omega[axes[h, 0], 0], rates[t, axes[h, 1]]
            x, slide = axes[h, 3], axes[h, 4]
            one[x] = one[x + 1] = w
            one[slide] = one[slide + 1] = rate
            two[x] = two[slide] = -part * (w * starts[few + h, 1] + z[x + 1])
            two[x + 1] = two[slide + 1] = part * (w * starts[few + h, 0] + z[x])


@kernel
def _spatial_vectors(
    k, begin, end, lanes, joints, arms, axes, screws, starts, pitch, rates, omega, Z, left,
    right,
):  # fmt: skip
    """Vectors of degree k, and what they are multiplied with, each on its lanes.

    The lanes of a cross product are the three products that count, then the three that are
    subtracted.
    """
    few, part = arms.shape[0], 1.0 / k
    for t in range(begin, end):
        base = t * lanes
        for h in range(joints.shape[0]):
            j, p, axis = joints[h, 0], joints[h, 1], joints[h, 2]
            for i in range(3):
                omega[j, i] = screws[j, i] * rates[t, j]
                if p >= 0:
                    omega[j, i] += omega[p, i]
                if axis >= 0 and axes[axis, 2] > 0:
                    omega[j, i] += Z[base + axes[axis, 4] + i]
        for h in range(few + axes.shape[0]):
            axis = arms[h, 2] if h < few else -1
            link = arms[h, 0] if h < few else axes[h - few, 0]
            z = base + (6 * h if h < few else axes[h - few, 3])
            for i in range(3):
                u, v = (i + 1) % 3, (i + 2) % 3
                change = omega[link, u] * starts[h, v] - omega[link, v] * starts[h, u]
                change += Z[z + i] - Z[z + 3 + i]
                if axis >= 0:
                    j, y = axes[axis, 1], base + axes[axis, 4]
                    change += pitch[j] * (starts[few + axis, i] * rates[t, j] + Z[y + i])
                change *= part
                left[z + v] = left[z + 3 + u] = omega[link, i]
                right[z + u] = right[z + 3 + v] = change
                if h >= few:
                    y = base + axes[h - few, 4]
                    left[y + i], right[y + i] = rates[t, axes[h - few, 1]], change


def _polynomials_kernel(dim):
    """The kernel for screws of ``dim`` components: 6 in space, 3 in a plane."""
    space = 3 if dim == 6 else 2

    @kernel
    def fill(whole, real, screws, rates, room):
        """Put the coefficients of q into rates; returns the condition number."""
        sizes = whole[whole[0] : whole[1]]
        parent = whole[whole[1] : whole[2]]
        ends = whole[whole[2] : whole[3]].reshape(-1, 2)
        dependent = whole[whole[3] : whole[4]]
        equations = whole[whole[4] : whole[5]]
        joints = whole[whole[5] : whole[6]].reshape(-1, 3)
        arms = whole[whole[6] : whole[7]].reshape(-1, 3)
        axes = whole[whole[7] : whole[8]].reshape(-1, 5)
        terms = whole[whole[8] : whole[9]].reshape(-1, 3)
        cuts = whole[whole[9] : whole[10]]
        degrees = whole[whole[10] : whole[11]]
        places = whole[whole[11] : whole[12]].reshape(-1, 2)
        pairs = whole[whole[12] : whole[13]].reshape(-1, 2)
        n, width, few, lanes = sizes[0], sizes[1], sizes[2], sizes[3]
        columns = real[: n * width].reshape(n, width)
        mimics = real[n * width :].reshape(-1, n)
        order, M = degrees.size - 2, places.shape[0] - 1

        rows, m, nd = ends.shape[0] * dim + mimics.shape[0], equations.size, dependent.size
        wide, arrows = -(-nd // LANES) * LANES, arms.shape[0] + axes.shape[0]
        left, room = room[: M * lanes], room[M * lanes :]
        right, room = room[: M * lanes], room[M * lanes :]
        Z, room = room[: M * lanes], room[M * lanes :]
        K, room = room[: few * wide], room[few * wide :]
        G, room = room[: rows * wide], room[rows * wide :]
        S, room = room[: rows * n].reshape(rows, n), room[rows * n :]
        points, room = room[: (n + cuts.size) * space], room[(n + cuts.size) * space :]
        points = points.reshape(n + cuts.size, space)
        starts, room = room[: arrows * space].reshape(arrows, space), room[arrows * space :]
        omega, room = room[: n * (dim - space)].reshape(n, -1), room[n * (dim - space) :]
        x, pitch, v, W = room[:wide], room[wide:], room[wide + n :], room[wide + n + m :]

        fill_loop_matrix(parent, screws, ends, mimics, S)
        condition = pseudo_inverse(S, equations, dependent, G, W, v)
        _fill_points(parent, screws, cuts, points, pitch)
        for i in range(space):
            for h in range(arms.shape[0]):
                starts[h, i] = points[arms[h, 1], i] - points[arms[h, 0], i]
            for h in range(axes.shape[0]):
                first = 0 if axes[h, 2] > 0 else dim - space
                starts[arms.shape[0] + h, i] = screws[axes[h, 1], first + i]
        if dim == 6:
            _spatial_responses(G, wide, axes, terms, points, pitch, K)
        else:
            _planar_responses(G, wide, axes, terms, K)
        for w in range(width if order > 0 else 0):
            for r in range(S.shape[0]):
                b = 0.0
                for j in range(n):
                    b -= S[r, j] * columns[j, w]
                for d in range(dependent.size):
                    rates[1 + w, dependent[d]] += b * G[r * wide + d]
            for j in range(n):
                rates[1 + w, j] += columns[j, w]
        for k in range(1, order + 1):
            begin, end = degrees[k], degrees[k + 1]
            if k > 1:
                # The last degree needs no turned axes.
                count = few if k == order else lanes
                multiply(begin, end, count, lanes, places, pairs, left, right, Z)
                _solve(begin, end, few, lanes, Z, K, dependent, x, rates)
            if k < order and dim == 6:
                _spatial_vectors(
                    k, begin, end, lanes, joints, arms, axes, screws, starts, pitch, rates,
                    omega, Z, left, right,
                )  # fmt: skip
            elif k < order:
                _planar_vectors(
                    k, begin, end, lanes, joints, arms, axes, screws, starts, rates, omega, Z,
                    left, right,
                )  # fmt: skip
        flat = rates.reshape(rates.size)
        for k in range(2, order + 1):
            part = 1.0 / k
            for i in range(degrees[k] * n, degrees[k + 1] * n):
                flat[i] *= part
        return condition

    return fill


_fill_spatial, _fill_planar = _polynomials_kernel(6), _polynomials_kernel(3)


@kernel(inline=True)
def _room(whole):
    """Room for the vectors and all else, from a line of the cache on."""
    room = np.zeros(whole[whole[0] + 4])
    # Vectors are fast where they do not straddle lines of the cache, of 64 bytes.
    return room[-(room.ctypes.data // 8) % 8 :]


@kernel
def _spatial(whole, real, screws, rates):
    return _fill_spatial(whole, real, screws, rates, _room(whole))


@kernel
def _planar(whole, real, screws, rates):
    return _fill_planar(whole, real, screws, rates, _room(whole))


def polynomials(screws: Array, which: Layout) -> tuple[Array, float]:
    """The joint positions of the closed motion as polynomials in a chain's coordinates.

    Args:
        screws: unit screws of the chain's joints (n, 6 or 3), in its units.
        which: all else, from `layout`.

    Returns:
        Coefficients of the positions, in the units of the chain (M, n), and the condition
        number of the equations that are solved, infinite if they determine no motion.
    """
    expand = _spatial if screws.shape[1] == 6 else _planar
    rates = np.zeros(which.shape)
    return rates, float(expand(which.whole, which.real, screws, rates))
