"""Steps of the closed motion as a power series: kernels inlined by `kinematics.closure.series`.

Formulas and symbols are those of `kinematics.closure.series`; j is a joint and the link behind
it, k the order, w a column: the motion for a unit rate of coordinate w. Inlined kernels cost no
call, and where ``dim`` is a constant of the caller, they have no branch on it and loops over
the components of a twist are unrolled.

Arguments that several of them have, in chain units; of the series along one ray:

    s       joint screws (orders, n, dim)
    v       link twists along the ray (orders, n, dim)
    c       joint rates C for unit rates of the coordinates (orders, n, width)
    t       link twists T for unit rates of the coordinates (orders, n, width, dim)

and of the chain, see `kinematics.model.arrays.Chain`: ``parent`` (n,), ``ends`` (L, 2),
``mimics`` (g, n), ``columns`` (n, width), ``moves`` (n, width).
"""

from __future__ import annotations

from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.skyline_qr import ROW


@kernel(inline=True, reference_counting=False)
def bracket(dim, V, s, factor, out):
    """Add the Lie bracket of two twists: ``out += factor ad(V) s``.

    In space ``ad([ω; v]) [a; b] = [ω × a; ω × b + v × a]``; in the plane the first of three
    components is 0. Where ``dim`` is a constant of the caller, inlining removes the branch.

    Args:
        dim: components of a twist, 6 or 3.
        V: in; a twist (dim,), chain units.
        s: in; another one.
        factor: in; a number.
        out: in and out; a twist (dim,).
    """
    if dim == 3:
        out[1] += factor * (s[0] * V[2] - V[0] * s[2])
        out[2] += factor * (V[0] * s[1] - s[0] * V[1])
    else:
        out[0] += factor * (V[1] * s[2] - V[2] * s[1])
        out[1] += factor * (V[2] * s[0] - V[0] * s[2])
        out[2] += factor * (V[0] * s[1] - V[1] * s[0])
        out[3] += factor * (V[4] * s[2] - V[5] * s[1] + V[1] * s[5] - V[2] * s[4])
        out[4] += factor * (V[5] * s[0] - V[3] * s[2] + V[2] * s[3] - V[0] * s[5])
        out[5] += factor * (V[3] * s[1] - V[4] * s[0] + V[0] * s[4] - V[1] * s[3])


@kernel(inline=True, reference_counting=False)
def carry_screws(dim, k, parent, screws, v, s):
    """Compute order k of the joint screws.

    ``k s_{j,k} = Σ_{a<k} ad(V_{parent,a}) s_{j,k-1-a}``.

    Args:
        dim: components of a twist, 6 or 3.
        k: the order.
        parent: in; link before each joint (n,).
        screws: in; joint screws at the pose, order 0 (n, dim).
        v: in; twists of lower orders.
        s: in, lower orders; out, order k.
    """
    for j in range(parent.size):
        now = s[k, j]
        for i in range(dim):
            now[i] = screws[j, i] if k == 0 else 0.0
        # The screws of joints on the ground are constant.
        for a in range(k if parent[j] >= 0 else 0):
            bracket(dim, v[a, parent[j]], s[k - 1 - a, j], 1.0 / k, now)


@kernel(inline=True, reference_counting=False)
def copy_order_0(dim, C, T, c, t):
    """Copy order 0 of the first ray, which all rays share.

    Args:
        dim: components of a twist, 6 or 3.
        C: in; joint rates along the first ray.
        T: in; link twists along it.
        c: out; joint rates along another ray.
        t: out; link twists along it.
    """
    for j in range(C.shape[1]):
        for w in range(C.shape[2]):
            c[0, j, w] = C[0, j, w]
            for i in range(dim):
                t[0, j, w, i] = T[0, j, w, i]


@kernel(inline=True, reference_counting=False)
def add_known_twists(dim, k, w, parent, columns, moves, s, c, t):
    """Compute order k of the link twists of column w, without the unknown ``S_0 C_k``.

    ``T_{j,k} = T_{parent,k} + Σ_{1≤a≤k} s_{j,a} C_{j,k-a}``; in order 0, the rates of the
    independent joints are known and count: ``T_{j,0} = T_{parent,0} + s_{j,0} C_{j,0}``.

    Args:
        dim: components of a twist, 6 or 3.
        k: the order.
        w: the column.
        parent: in; link before each joint (n,).
        columns: in; rates of the independent joints (n, width).
        moves: in; whether a column can move a link (n, width).
        s: in; screws up to order k.
        c: in, lower orders; out in order 0, the rates of the independent joints.
        t: out; order k.
    """
    for j in range(parent.size):
        if not moves[j, w]:
            continue
        now, p = t[k, j, w], parent[j]
        if p >= 0:
            for i in range(dim):
                now[i] = t[k, p, w, i]
        else:
            for i in range(dim):
                now[i] = 0.0
        if k == 0:
            c[0, j, w] = columns[j, w]
        for a in range(min(k, 1), k + 1):
            rate = c[k - a, j, w]
            if rate != 0.0:
                for i in range(dim):
                    now[i] += s[a, j, i] * rate


@kernel(inline=True, reference_counting=False)
def fill_mismatch(dim, k, w, ends, mimics, columns, envelope, t, b):
    """Fill the right-hand side of ``S_0 C_k = -Σ_{a≥1} S_a C_{k-a}``, by rows of the envelope.

    It is the twist of side B less that of side A of each weld. A mimic relation is constant:
    its right-hand side is 0 but for order 0, where the independent joints are known.

    Args:
        dim: components of a twist, 6 or 3.
        k: the order.
        w: the column.
        ends: in; links on side A and side B of each weld (L, 2).
        mimics: in; relations (g, n).
        columns: in; rates of the independent joints (n, width).
        envelope: in; the table of `kinematics.numerics.linalg.skyline_qr`.
        t: in; known part of the link twists of order k.
        b: out; the right-hand side (rows,), chain units.
    """
    row, loops = envelope[ROW], ends.shape[0]
    for i in range(b.size):
        b[i] = 0.0
    for loop in range(loops):
        for side in range(2):
            j, sign = ends[loop, side], 2.0 * side - 1.0  # -1 on side A, +1 on side B
            if j >= 0:
                for i in range(dim):
                    b[row[loop] + i] += sign * t[k, j, w, i]
    for relation in range(mimics.shape[0] if k == 0 else 0):
        for j in range(mimics.shape[1]):
            b[row[loops + relation]] -= mimics[relation, j] * columns[j, w]


@kernel(inline=True, reference_counting=False)
def complete_twists(dim, k, w, parent, screws, columns, moves, c, correction, t):
    """Add ``S_0 C_k`` of the dependent joints, now known, to the link twists of order k.

    Args:
        dim: components of a twist, 6 or 3.
        k: the order.
        w: the column.
        parent: in; link before each joint (n,).
        screws: in; joint screws at the pose (n, dim).
        columns: in; rates of the independent joints (n, width), already counted.
        moves: in; whether a column can move a link (n, width).
        c: in; joint rates of order k.
        correction: workspace (n * dim,): what is added to each link.
        t: in and out; order k.
    """
    for j in range(parent.size):
        if not moves[j, w]:
            continue
        rate = c[k, j, w] - (columns[j, w] if k == 0 else 0.0)
        p = parent[j]
        for i in range(dim):
            correction[j * dim + i] = screws[j, i] * rate
            if p >= 0 and moves[p, w]:
                correction[j * dim + i] += correction[p * dim + i]
            t[k, j, w, i] += correction[j * dim + i]


@kernel(inline=True, reference_counting=False)
def sum_columns(dim, k, moves, ray, t, v):
    """Compute order k of the link twists along a ray: ``V_j = Σ_w T_{j,w} δ_w``.

    Args:
        dim: components of a twist, 6 or 3.
        k: the order.
        moves: in; whether a column can move a link (n, width).
        ray: in; the direction δ (width,).
        t: in; link twists for unit rates.
        v: out; order k.
    """
    for j in range(moves.shape[0]):
        for i in range(dim):
            v[k, j, i] = 0.0
        for w in range(moves.shape[1]):
            if moves[j, w]:
                for i in range(dim):
                    v[k, j, i] += t[k, j, w, i] * ray[w]
