"""Kernels of `kinematics.closure.taylor.lane_expansion` for the vectors of links at many poses.

Formulas and symbols are those of `kinematics.closure.taylor.vector_kernels`; sections of
integers (joints, arms, axes, terms) are those of `kinematics.closure.taylor.layout`. The last
axis of arrays is that of the lanes.
"""

from __future__ import annotations

from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import VECTOR_WIDTH, broadcast, load_vector, store_vector


@kernel(reference_counting=False)
def turn_vectors(begin, end, places, pairs, space, omega, vector, out):
    """Compute products of lower degrees in ``ω × r``, for the monomials of one degree.

    Arrays are flat: what the indices of these loops cost would be most of the time.

    Args:
        end: monomial after the last one.
        places: in; as in `Monomials`.
        pairs: in; as in `Monomials`.
        space: components of r, 3 or 2.
        omega: in; angular velocity, of 3 or 1 components (monomials, components, lanes).
        vector: in; r (monomials, components, lanes).
        out: out; likewise.
    """
    W = VECTOR_WIDTH
    for t in range(begin, end):
        x, y, z = broadcast(0.0), broadcast(0.0), broadcast(0.0)
        # A square has a root; others have the constant term, which is 0.
        i = j = places[t, 1]
        for p in range(places[t, 0] - 1, places[t + 1, 0]):
            if p >= places[t, 0]:
                i, j = pairs[p, 0], pairs[p, 1]
            # Both ways, but for a square.
            for _ in range(1 if i == j else 2):
                if space == 2:
                    u = load_vector(omega, i * W)
                    x = x - u * load_vector(vector, (2 * j + 1) * W)
                    y = y + u * load_vector(vector, 2 * j * W)
                else:
                    u, v = load_vector(omega, 3 * i * W), load_vector(omega, (3 * i + 1) * W)
                    a, b = load_vector(vector, 3 * j * W), load_vector(vector, (3 * j + 1) * W)
                    w = load_vector(omega, (3 * i + 2) * W)
                    c = load_vector(vector, (3 * j + 2) * W)
                    x = x + v * c - w * b
                    y = y + w * a - u * c
                    z = z + u * b - v * a
                i, j = j, i
        store_vector(out, space * t * W, x)
        store_vector(out, (space * t + 1) * W, y)
        if space == 3:
            store_vector(out, (space * t + 2) * W, z)


@kernel(reference_counting=False)
def slide_vectors(begin, end, places, pairs, space, joint, n, rates, vector, out):
    """Compute products of lower degrees in ``a Dq``, for the monomials of one degree.

    Args:
        begin: first monomial, as in `turn_vectors`, as are the next four.
        end: monomial after the last one.
        places: in.
        pairs: in.
        space: components of the axis.
        rates: in; joint rates (monomials, n, lanes), flat.
        vector: in; its axis (monomials, components, lanes), flat.
        out: out; likewise.
    """
    W = VECTOR_WIDTH
    for t in range(begin, end):
        root = places[t, 1]
        for c in range(space):
            rate = load_vector(rates, (root * n + joint) * W)
            total = rate * load_vector(vector, (root * space + c) * W)
            for p in range(places[t, 0], places[t + 1, 0]):
                i, k = pairs[p, 0], pairs[p, 1]
                rate = load_vector(rates, (i * n + joint) * W)
                other = load_vector(rates, (k * n + joint) * W)
                total = total + rate * load_vector(vector, (k * space + c) * W)
                total = total + other * load_vector(vector, (i * space + c) * W)
            store_vector(out, (t * space + c) * W, total)


@kernel(reference_counting=False)
def _put(at, sign, entry):
    """Add ``sign entry`` to a line of lanes.

    Args:
        at: in and out; (lanes,).
        entry: in; (lanes,).
    """
    store_vector(at, 0, load_vector(at, 0) + broadcast(sign) * load_vector(entry, 0))


@kernel(reference_counting=False)
def solve_monomials(
    begin, end, axes, terms, points, pitch, turned, slid, P, dependent, equations, b, rates
):
    """Compute the rates of the dependent joints for some monomials: ``Dq = -S_0⁺ b``.

    Args:
        end: monomial after the last one.
        axes: in; as in `kinematics.closure.taylor.layout`, as are the terms.
        terms: in.
        points: in; points of the joints (n or more, 3 or 2, lanes).
        pitch: in; (n, lanes).
        turned: in; ``ω × r`` of arms, then axes (arms + axes, monomials, 3 or 2, lanes).
        slid: in; ``a Dq`` of axes (axes, monomials, 3 or 2, lanes).
        P: in; pseudo-inverse (d, m, lanes).
        dependent: in; dependent joints (d,).
        equations: in; rows that are solved (m,).
        b: workspace (rows, lanes).
        rates: out; (monomials, n, lanes).
    """
    space, nd, m = points.shape[1], P.shape[0], P.shape[1]
    inverse, right = P.reshape(P.size), b.reshape(b.size)
    for t in range(begin, end):
        for r in range(b.shape[0]):
            store_vector(b[r], 0, broadcast(0.0))
        for q in range(terms.shape[0]):
            row, sign, vector = terms[q, 0], 1.0 * terms[q, 1], terms[q, 2]
            linear = row + (1 if space == 2 else 3)
            if vector >= 0:
                for i in range(space):
                    _put(b[linear + i], sign, turned[vector, t, i])
                continue
            axis = axes.shape[0] + vector
            j = axes[axis, 1]
            for i in range(space):
                y = slid[axis, t, i]
                if space == 2:
                    _put(b[linear + i], sign, y)
                    continue
                u, v = (i + 1) % 3, (i + 2) % 3
                z = broadcast(sign) * load_vector(y, 0)
                at = b[linear + i]
                store_vector(at, 0, load_vector(at, 0) + z * load_vector(pitch[j], 0))
                if axes[axis, 2] > 0:
                    # a slide turns about its point: r × a
                    _put(b[row + i], sign, y)
                    at, to = b[linear + u], b[linear + v]
                    store_vector(at, 0, load_vector(at, 0) + z * load_vector(points[j, v], 0))
                    store_vector(to, 0, load_vector(to, 0) - z * load_vector(points[j, u], 0))
        for d in range(nd):
            total, row = broadcast(0.0), d * m * VECTOR_WIDTH
            for r in range(m):
                entry = load_vector(right, equations[r] * VECTOR_WIDTH)
                total = total - load_vector(inverse, row + r * VECTOR_WIDTH) * entry
            store_vector(rates[t, dependent[d]], 0, total)


@kernel(reference_counting=False)
def fill_vectors(
    k,
    begin,
    end,
    joints,
    arms,
    axes,
    screws,
    starts,
    pitch,
    rates,
    turned,
    slid,
    omega,
    vectors,
):
    """Compute the vectors of the monomials of degree k.

    Args:
        k: the degree.
        end: monomial after the last one.
        joints: in; as in `kinematics.closure.taylor.layout`, as are arms and axes.
        arms: in.
        axes: in.
        screws: in; joint screws (n, 6 or 3, lanes).
        starts: in; arms, then axes at the pose (arms + axes, 3 or 2, lanes).
        pitch: in; (n, lanes).
        rates: in; joint rates (monomials, n, lanes).
        turned: in; products of lower degrees, as in `solve_monomials`.
        slid: in; likewise.
        omega: out; angular velocities of the links (n, monomials, 3 or 1, lanes).
        vectors: out; arms, then axes (arms + axes, monomials, 3 or 2, lanes).
    """
    few, part, space = arms.shape[0], broadcast(1.0 / k), starts.shape[1]
    for t in range(begin, end):
        # ω_j = ω_parent + a_j Dq_j
        for h in range(joints.shape[0]):
            j, p, axis = joints[h, 0], joints[h, 1], joints[h, 2]
            for i in range(omega.shape[2]):
                total = load_vector(screws[j, i], 0) * load_vector(rates[t, j], 0)
                if p >= 0:
                    total = total + load_vector(omega[p, t, i], 0)
                if axis >= 0 and axes[axis, 2] > 0:
                    total = total + load_vector(slid[axis, t, i], 0)
                store_vector(omega[j, t, i], 0, total)
        # r_k = (ω × r + λ a Dq)_k / k, then a_k = (ω × a)_k / k
        for h in range(few + axes.shape[0]):
            axis = arms[h, 2] if h < few else -1
            w = omega[arms[h, 0] if h < few else axes[h - few, 0], t]
            for i in range(space):
                u, v = (i + 1) % 3, (i + 2) % 3
                change = load_vector(turned[h, t, i], 0)
                if space == 2:
                    side = load_vector(w[0], 0) * load_vector(starts[h, 1 - i], 0)
                    change = change - side if i == 0 else change + side
                else:
                    change = change + load_vector(w[u], 0) * load_vector(starts[h, v], 0)
                    change = change - load_vector(w[v], 0) * load_vector(starts[h, u], 0)
                if axis >= 0:
                    j = axes[axis, 1]
                    slide = load_vector(starts[few + axis, i], 0) * load_vector(rates[t, j], 0)
                    slide = slide + load_vector(slid[axis, t, i], 0)
                    change = change + load_vector(pitch[j], 0) * slide
                store_vector(vectors[h, t, i], 0, part * change)
