"""Kernels for the vectors of links, for `kinematics.closure.taylor.expansion_kernels`.

Formulas and symbols are those of `kinematics.closure.taylor.expansion_kernels`; sections of
integers (joints, arms, axes, terms, cuts) are those of `kinematics.closure.taylor.layout`. A
monomial t has a row of ``stride`` lanes in the flat arrays ``left_factors``, ``right_factors``
and ``product``. Lengths are in chain units.

Kernels of the plane and of space are two: a cross product takes 2 lanes in the plane,
``ω (-r_y, r_x)``, and 6 in space, and only the axes of sliders change in the plane. Expanding a
planar linkage by the kernel of space takes 2 (five-bar, order 5) to 11 times as long (3-RRR).
"""

from __future__ import annotations

from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.compiled.simd import (
    VECTOR_WIDTH,
    broadcast,
    load_broadcast,
    load_vector,
    quarter_turn,
    store_vector,
)


@kernel(inline=True, reference_counting=False)
def fill_points(parent, screws, cuts, points, pitch):
    """Compute points of the joints, then of the cuts, and the pitch of each joint.

    The point of a turning joint is ``ω × v``, the one of its axis nearest to the origin, and
    its pitch ``ω · v``; a slider has pitch 1 and the point of the joint before it.

    Args:
        parent: in; link before each joint, -1 for the ground (n,).
        screws: in; joint screws (n, 6 or 3).
        cuts: in; link whose joint has the point of a cut, -1 for the origin (L,).
        points: out; (n + L, 3 or 2).
        pitch: in, zeros; out; (n,).
    """
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


@kernel(inline=True, reference_counting=False)
def fill_starts(dim, arms, axes, screws, points, starts):
    """Compute arms and axes at the reference pose, their terms of degree 0.

    Args:
        dim: components of a screw, 6 or 3.
        arms: in; link, point where it ends, axis or -1 (arms, 3).
        axes: in; link, joint, whether it turns, its lanes (axes, 5).
        screws: in; joint screws (n, dim).
        points: in; as from `fill_points`.
        starts: out; arms, then axes (arms + axes, 3 or 2).
    """
    space = points.shape[1]
    for i in range(space):
        for h in range(arms.shape[0]):
            starts[h, i] = points[arms[h, 1], i] - points[arms[h, 0], i]
        for h in range(axes.shape[0]):
            # the angular part of the screw of a joint that turns, or else the linear part
            first = 0 if axes[h, 2] > 0 else dim - space
            starts[arms.shape[0] + h, i] = screws[axes[h, 1], first + i]


@kernel(inline=True, reference_counting=False)
def _add(factor, inverse, row, response, lane, width):
    """Add a multiple of a row of the pseudo-inverse to the response to a lane.

    Args:
        factor: in; a number.
        inverse: in; the pseudo-inverse, transposed, flat.
        row: the row of the loop matrix.
        response: in and out; flat.
        width: length of the rows of both, whole vectors.
    """
    for d in range(0, width, VECTOR_WIDTH):
        total = load_vector(response, lane * width + d)
        total = total + broadcast(factor) * load_vector(inverse, row * width + d)
        store_vector(response, lane * width + d, total)


@kernel(inline=True, reference_counting=False)
def spatial_responses(inverse, width, axes, terms, points, pitch, response):
    """Compute the response of the dependent joints to each product of known parts.

    A product p on a lane stands in the equations of a loop as a moment m and a force f: those
    rows of the pseudo-inverse, weighted, and with the sign of the other side of the equation.
    The cross product of an arm counts in the rows of the translation; a slide ``a_j Dq_j``
    counts there with the pitch, and if it turns, in those of the rotation and, at the point
    r_j of the axis, as ``r_j × a_j``.

    Args:
        inverse: in; the pseudo-inverse, transposed, flat.
        width: length of its rows, and of those of ``response``.
        axes: in; link, joint, whether it turns, its lanes (axes, 5).
        terms: in; first row of a loop, ±1, arm, or axis - axes (terms, 3): a negative number
            is an axis, counted from the end as an index.
        points: in; points of the joints (n or more, 3).
        pitch: in; pitch of each joint (n,).
        response: in, zeros; out; a row for each lane of the loops.
    """
    for q in range(terms.shape[0]):
        row, sign, vector = terms[q, 0], float(terms[q, 1]), terms[q, 2]
        if vector >= 0:
            for i in range(3):
                _add(-sign, inverse, row + 3 + i, response, 6 * vector + i, width)
                _add(sign, inverse, row + 3 + i, response, 6 * vector + 3 + i, width)
            continue
        j, slide = axes[vector, 1], axes[vector, 4]
        for i in range(3):
            u, v = (i + 1) % 3, (i + 2) % 3
            _add(-sign * pitch[j], inverse, row + 3 + i, response, slide + i, width)
            if axes[vector, 2] > 0:
                _add(-sign, inverse, row + i, response, slide + i, width)
                _add(-sign * points[j, v], inverse, row + 3 + u, response, slide + i, width)
                _add(sign * points[j, u], inverse, row + 3 + v, response, slide + i, width)


@kernel(inline=True, reference_counting=False)
def planar_responses(inverse, width, axes, terms, response):
    """Compute responses in a plane: all axes are those of sliders; see `spatial_responses`.

    Args:
        inverse: in; the pseudo-inverse, transposed, flat.
        width: length of its rows, and of those of ``response``.
        axes: in; link, joint, 0, its lanes (axes, 5).
        terms: in; first row of a loop, ±1, arm, or axis - axes (terms, 3).
        response: in, zeros; out; a row for each lane of the loops.
    """
    for q in range(terms.shape[0]):
        row, sign, vector = terms[q, 0], float(terms[q, 1]), terms[q, 2]
        if vector >= 0:
            _add(-sign, inverse, row + 2, response, 2 * vector, width)
            _add(sign, inverse, row + 1, response, 2 * vector + 1, width)
        else:
            slide = axes[vector, 4]
            _add(-sign, inverse, row + 1, response, slide, width)
            _add(-sign, inverse, row + 2, response, slide + 1, width)


@kernel(inline=True, reference_counting=False)
def multiply_lanes(begin, end, count, stride, weights, width, matrix, out):
    """Multiply rows by a matrix: ``out[t] = Σ_i weights[t, i] matrix[i]``, in vectors.

    Args:
        begin: the first row.
        end: the row after the last one.
        count: how many numbers of a row count.
        stride: length of the rows of ``weights``.
        weights: in; flat (end * stride or more,).
        width: length of the rows of the others, whole vectors.
        matrix: in; flat (count * width,).
        out: out; flat (end * width or more,).
    """
    for t in range(begin, end):
        for x in range(0, width, VECTOR_WIDTH):
            total, other = broadcast(0.0), broadcast(0.0)
            for i in range(0, count - 1, 2):
                factor = load_broadcast(weights, t * stride + i)
                total = total + factor * load_vector(matrix, i * width + x)
                factor = load_broadcast(weights, t * stride + i + 1)
                other = other + factor * load_vector(matrix, i * width + width + x)
            if count % 2 == 1:
                factor = load_broadcast(weights, t * stride + count - 1)
                total = total + factor * load_vector(matrix, (count - 1) * width + x)
            store_vector(out, t * width + x, total + other)


@kernel(inline=True, reference_counting=False)
def fill_turning(parent, screws, arms, axes, starts, stride, turning, turned):
    """Fill what gives the factors of all lanes from joint rates, in a plane.

    Lanes of arms and of turned axes have the angular velocity of their link on the left,
    ``ω = Σ_j s_j Dq_j`` of the joints before it; those of sliding have the joint's rate. For
    degrees above 1 these follow from the products at once, by the responses of the joints.

    Args:
        parent: in; link before each joint, -1 for the ground (n,).
        screws: in; joint screws (n, 3).
        arms: in; link, point where it ends, axis or -1 (arms, 3).
        axes: in; link, joint, 0, first lane if turned, if slid along (axes, 5).
        starts: in; arms and axes at the reference pose (arms + axes, 2).
        stride: lanes of each monomial.
        turning: in, zeros; out; factor of each joint's rate on each lane, flat (n * stride,).
        turned: in, zeros; out; arms and axes at the reference pose, turned by a right angle
            (stride,).
    """
    few = arms.shape[0]
    for h in range(few + axes.shape[0]):
        j, x = (arms[h, 0], 2 * h) if h < few else (axes[h - few, 0], axes[h - few, 3])
        turned[x], turned[x + 1] = -starts[h, 1], starts[h, 0]
        while j >= 0:
            turning[j * stride + x] = turning[j * stride + x + 1] = screws[j, 0]
            j = parent[j]
    for h in range(axes.shape[0]):
        slide = axes[h, 1] * stride + axes[h, 4]
        turning[slide] = turning[slide + 1] = 1.0


@kernel(inline=True, reference_counting=False)
def planar_vectors(
    k,
    begin,
    end,
    stride,
    arms,
    axes,
    turned,
    starts,
    product,
    left_factors,
    right_factors,
):
    """Compute vectors of degree k, in a plane; see `spatial_vectors`.

    ``D r = ω (-r_y, r_x)``: x and y of each are one lane each.

    Args:
        k: the degree.
        end: monomial after the last one.
        stride: lanes of each monomial.
        arms: in; link, point where it ends, axis or -1 (arms, 3).
        axes: in; link, joint, 0, first lane if turned, if slid along (axes, 5).
        turned: in; as from `fill_turning`.
        starts: in; arms and axes at the reference pose (arms + axes, 2).
        product: in; sums of products of degree k.
        left_factors: in; angular velocities and joint rates of degree k, on their lanes.
        right_factors: out; arms and axes of degree k.
    """
    few, part = arms.shape[0], 1.0 / k
    for t in range(begin, end):
        # r_k = (ω × r)_k / k and a_k = (ω × a)_k / k, with the products of lower degrees
        for x in range(0, stride, VECTOR_WIDTH):
            change = load_vector(left_factors, t * stride + x) * load_vector(turned, x)
            change = change + quarter_turn(load_vector(product, t * stride + x))
            store_vector(right_factors, t * stride + x, broadcast(part) * change)
        if axes.shape[0] == 0:
            continue
        here = slice(t * stride, (t + 1) * stride)
        omegas, two, z = left_factors[here], right_factors[here], product[here]
        # r_k = (ω × r + a Dq)_k / k, of arms that lengthen
        for h in range(few):
            w, axis, x, y = omegas[2 * h], arms[h, 2], 2 * h, 2 * h + 1
            if axis >= 0:
                rx, ry = -(w * starts[h, 1] + z[y]), w * starts[h, 0] + z[x]
                slide = axes[axis, 4]
                rate = omegas[slide]
                rx += starts[few + axis, 0] * rate + z[slide]
                ry += starts[few + axis, 1] * rate + z[slide + 1]
                two[x], two[y] = part * rx, part * ry
        # Axes that are slid along are those that are turned.
        for h in range(axes.shape[0]):
            x, slide = axes[h, 3], axes[h, 4]
            two[slide], two[slide + 1] = two[x], two[x + 1]


@kernel(inline=True, reference_counting=False)
def spatial_vectors(
    k,
    begin,
    end,
    stride,
    joints,
    arms,
    axes,
    screws,
    starts,
    pitch,
    rates,
    omega,
    product,
    left_factors,
    right_factors,
):
    """Compute vectors of degree k and their factors, each on its lanes.

    The lanes of a cross product are the three products that are added, ``ω_u r_v``, then the
    three that are subtracted, ``ω_v r_u``, with (i, u, v) in cyclic order. ``product`` has
    those of lower degrees; the terms of degree 0 and k are added here.

    Args:
        k: the degree.
        end: monomial after the last one.
        stride: lanes of each monomial.
        joints: in; joint, parent, axis or -1 (joints, 3).
        arms: in; link, point where it ends, axis or -1 (arms, 3).
        axes: in; link, joint, whether it turns, first lane if turned, if slid along (axes, 5).
        screws: in; joint screws (n, 6).
        starts: in; arms and axes at the reference pose (arms + axes, 3).
        pitch: in; pitch of each joint (n,).
        rates: in; joint rates up to degree k (monomials, n).
        omega: workspace; angular velocities of the links (n, 3).
        product: in; sums of products of degree k, flat.
        left_factors: out; angular velocities and joint rates of degree k, on their lanes.
        right_factors: out; arms and axes of degree k.
    """
    few, part = arms.shape[0], 1.0 / k
    for t in range(begin, end):
        base = t * stride
        # ω_j = ω_parent + a_j Dq_j
        for h in range(joints.shape[0]):
            j, p, axis = joints[h, 0], joints[h, 1], joints[h, 2]
            for i in range(3):
                omega[j, i] = screws[j, i] * rates[t, j]
                if p >= 0:
                    omega[j, i] += omega[p, i]
                if axis >= 0 and axes[axis, 2] > 0:
                    omega[j, i] += product[base + axes[axis, 4] + i]
        # r_k = (ω × r + λ a Dq)_k / k, then a_k = (ω × a)_k / k
        for h in range(few + axes.shape[0]):
            axis = arms[h, 2] if h < few else -1
            link = arms[h, 0] if h < few else axes[h - few, 0]
            z = base + (6 * h if h < few else axes[h - few, 3])
            for i in range(3):
                u, v = (i + 1) % 3, (i + 2) % 3
                change = omega[link, u] * starts[h, v] - omega[link, v] * starts[h, u]
                change += product[z + i] - product[z + 3 + i]
                if axis >= 0:
                    j, y = axes[axis, 1], base + axes[axis, 4]
                    slid = starts[few + axis, i] * rates[t, j] + product[y + i]
                    change += pitch[j] * slid
                change *= part
                left_factors[z + v] = left_factors[z + 3 + u] = omega[link, i]
                right_factors[z + u] = right_factors[z + 3 + v] = change
                if h >= few:
                    y = base + axes[h - few, 4]
                    left_factors[y + i], right_factors[y + i] = (
                        rates[t, axes[h - few, 1]],
                        change,
                    )
