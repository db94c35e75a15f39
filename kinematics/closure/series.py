"""Loop closure as power series: the compiled kernels of the motion.

Take a ray ``u(t) = u0 + t δ`` in the independent coordinates and write every quantity as a
power series in t, with the order as its index. Screws are carried by their parents and the
loops are welded at every order, so nothing but the Lie bracket is needed:

    V_j         = V_parent + s_j q̇_j
    k s_{j,k}   = Σ_{a<k} ad(V_{parent,a}) s_{j,k-1-a}
    S_0 C_k     = -Σ_{a≥1} S_a C_{k-a}         (each loop, A minus B)
    q̇           = C δ

Column w of C is the motion of all joints for a unit rate of coordinate w. The link twists
``T_w`` that belong to it are accumulated along the tree, so that the right-hand side above
is the difference of two link twists. (A. Müller, "Higher derivatives of the kinematic
mapping and some applications", Mech. Mach. Theory 76, 2014; J. J. de Jong, PhD thesis,
University of Twente, chapter 4.)

Planar linkages use the same text with three components ``[ω; v_x; v_y]``.

The steps are inlined kernels: they cost no call, and where ``dim``, the components of a twist,
6 or 3, is a constant of the caller, they have no branch on it and unroll loops over it. In
them, j is a joint and the link behind it, k the order, w a column: the motion for a unit rate
of coordinate w. Arguments of several, in chain units; of the series along one ray:

    s       joint screws (orders, n, dim)
    v       link twists along the ray (orders, n, dim)
    c       joint rates C for unit rates of the coordinates (orders, n, width)
    t       link twists T for unit rates of the coordinates (orders, n, width, dim)

and of the chain, see `kinematics.model.arrays.Chain`: ``parent`` (n,), ``ends`` (L, 2),
``mimics`` (g, n), ``columns`` (n, width), ``moves`` (n, width).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.model.arrays import Chain, freeze, read_only
from kinematics.numerics.array_types import Array
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.skyline_qr import (
    COUNT,
    HEIGHT,
    JOINT,
    ROW,
    ROWS,
    factor_envelope,
    fill_envelope,
    solve_least_norm,
)
from kinematics.numerics.tolerances import SERIES_RESIDUAL


@kernel(reference_counting=False)
def fill_loop_matrix(parent, screws, ends, mimics, S):
    """Fill the loop matrix S_0 of all joints, with the mimic relations below.

    ``S_0[loop, j] = ± s_j``: plus if joint j leads to side A of the loop's weld, minus if it
    leads to side B; joints that lead to both cancel.

    Args:
        parent: in; link before each joint, -1 for the ground (n,).
        screws: in; joint screws (n, 6 or 3), chain units.
        ends: in; links on side A and side B of each weld, -1 for the ground (L, 2).
        mimics: in; relations between joint positions (g, n), chain units.
        S: in, zeros; out, the matrix (6 L + g or 3 L + g, n).
    """
    dim, base = screws.shape[1], ends.shape[0] * screws.shape[1]
    for loop in range(ends.shape[0]):
        for side in range(2):
            sign = 1.0 - 2.0 * side  # +1 on side A, -1 on side B
            j = ends[loop, side]
            while j >= 0:
                for i in range(dim):
                    S[loop * dim + i, j] += sign * screws[j, i]
                j = parent[j]
    for relation in range(mimics.shape[0]):
        for j in range(parent.size):
            S[base + relation, j] = mimics[relation, j]


@kernel(reference_counting=False)
def add_bracket(V, s, factor, out):
    """Add the Lie bracket of two twists: ``out += factor ad(V) s``.

    See `kinematics.closure.series.bracket` for the formula.

    Args:
        V: in; a twist (6 or 3,), chain units.
        s: in; another one.
        factor: in; a number.
        out: in and out; a twist of as many components.
    """
    bracket(s.size, V, s, factor, out)


def _make_series_kernel(dim):
    """Make the kernel for twists of ``dim`` components: 6 in space, 3 in a plane.

    One text for both, compiled twice.
    """

    @kernel(reference_counting=False)
    def series(first, last, begin, end, chain, screws, rays, workspace):
        """Compute orders first … last of the closed motion along rays.

        See the head of this file for the formulas.

        Args:
            first: the first order; those before must be in the workspace.
            last: the last order.
            begin: the first ray; all rays share order 0 of ray 0, which comes before others.
            end: the ray after the last one.
            chain: in; arrays of the chain, as `Chain.walked`.
            screws: in; joint screws at the pose (n, dim), chain units.
            rays: in; directions δ (count, width).
            workspace: in and out; as from `series_workspace`, for these rays and orders.
        """
        parent, _, ends, mimics, columns, moves, envelope = chain
        F, numbers, S, V, C, T, residual = workspace
        nd, rows, joints = F.shape[0], envelope[COUNT, ROWS], envelope[JOINT]
        diagonal, b, correction = numbers[:nd], numbers[nd : nd + rows], numbers[nd + rows :]
        if begin == 0:
            if first == 0:
                fill_envelope(screws, mimics, envelope, F)
                factor_envelope(F, envelope, diagonal)
            for k in range(first, last + 1):
                residual[k] = 0.0
        for ray in range(begin, end):
            s, v, c, t = S[ray], V[ray], C[ray], T[ray]
            for k in range(first, last + 1):
                carry_screws(dim, k, parent, screws, v, s)
                if k == 0 and ray > 0:
                    copy_order_0(dim, C[0], T[0], c, t)
                else:
                    add_known_twists(dim, k, parent, columns, moves, s, c, t)
                    for w in range(rays.shape[1] if nd > 0 else 0):
                        opens = fill_right_side(
                            dim, k, w, ends, mimics, columns, envelope, t, b
                        )
                        if opens:
                            gap = solve_least_norm(F, envelope, diagonal, b)
                            residual[k] = max(residual[k], gap)
                        # The solution, by columns of the envelope, is C_k.
                        for d in range(nd):
                            c[k, joints[d], w] = b[d]
                        if opens:
                            complete_twists(
                                dim, k, w, parent, screws, columns, moves, c, correction, t
                            )
                sum_columns(dim, k, moves, rays[ray], t, v)

    return series


spatial_series, planar_series = _make_series_kernel(6), _make_series_kernel(3)


def series_workspace(chain: Chain, rays: int, order: int) -> tuple[Array, ...]:
    """Make the workspace of a series.

    Args:
        chain: the linkage as arrays.
        rays: how many there are at most.

    Returns:
        Scratch arrays F (dependent joints, height of the envelope), numbers (dependent joints
        + rows + n dim,) and S (rays, order + 1, n, dim); then V, C, T and residual as in
        `Series`. Entries of C and T that the topology makes zero are never written: they
        must be zero.
    """
    V, C, T = _series_shapes(chain, rays, order)
    return (
        *_make_scratch(chain, rays, order),
        np.zeros(V),
        np.zeros(C),
        np.zeros(T),
        np.zeros(order + 1),
    )


def _series_shapes(chain: Chain, rays: int, order: int) -> tuple[tuple[int, ...], ...]:
    """Return the shapes of V, C and T."""
    n, dim = chain.screws.shape
    orders = rays, order + 1, n
    return (*orders, dim), (*orders, chain.width), (*orders, chain.width, dim)


def _make_scratch(chain: Chain, rays: int, order: int) -> tuple[Array, Array, Array]:
    """Make the arrays of a series that are not part of its result: F, numbers, S."""
    n, dim = chain.screws.shape
    height, rows = chain.envelope[COUNT, HEIGHT : ROWS + 1].tolist()
    nd = chain.dependent.size
    numbers = np.empty(nd + rows + n * dim)
    return np.empty((nd, height)), numbers, np.zeros((rays, order + 1, n, dim))


class Series(NamedTuple):
    """Power series of the motion along rays, in the frame and units of the chain.

    Attributes:
        C: joint rates for unit rates of the coordinates; (rays, order + 1, n, width).
        V: link twists along the rays; (rays, order + 1, n, 6 or 3).
        T: link twists for unit rates; (rays, order + 1, n, width, 6 or 3).
        residual: largest closure residual that no joint rate removes, by order; it
            is round-off if the linkage moves along the rays.
    """

    C: Array
    V: Array
    T: Array
    residual: Array

    @property
    def order(self) -> int:
        """Highest order."""
        return self.C.shape[1] - 1

    @property
    def open_order(self) -> int:
        """First order of the motion along ray 0 at which loops do not close; 0 if they do."""
        sizes = np.abs(self.C[0]).max(axis=(1, 2))
        for order, (residual, size) in enumerate(zip(self.residual, sizes, strict=True)):
            if residual > SERIES_RESIDUAL * max(1.0, size, sizes[0] ** (order + 1)):
                return order + 1
        return 0


def expand(chain: Chain, rays: Array, order: int) -> Series:
    """Expand the closed motion along ``u = t δ`` as power series, at the reference pose.

    Args:
        chain: the linkage as arrays.
        rays: directions δ in the coordinates of the chain; (rays, width).
        order: highest order.

    Returns:
        Joint rates and link twists by order, in the frame and units of the chain.
    """
    return expand_from(chain, chain.screws, rays, order)


def expand_from(chain: Chain, screws: Array, rays: Array, order: int) -> Series:
    """Expand the closed motion along ``u = u0 + t δ`` as power series, at another pose.

    Args:
        chain: the linkage as arrays.
        screws: joint screws carried to that pose (n, 6 or 3), chain units.
        rays: directions δ in the coordinates of the chain; (rays, width).
        order: highest order.

    Returns:
        As `expand`.
    """
    count = len(rays)
    purpose = "series", count, order
    # The scratch arrays are borrowed; the result has arrays of its own.
    borrowed = chain.borrow(
        purpose,
        lambda: (_make_scratch(chain, count, order), _series_shapes(chain, count, order)),
    )
    scratch, shapes = borrowed
    V, C, T = np.empty(shapes[0]), np.zeros(shapes[1]), np.zeros(shapes[2])
    residual = np.empty(order + 1)
    series = planar_series if screws.shape[1] == 3 else spatial_series
    workspace = (*scratch, V, C, T, residual)
    series(0, order, 0, count, chain.walked, screws, read_only(rays), workspace)
    chain.give_back(purpose, borrowed)
    return Series(C, V, T, residual)


def loop_matrix(chain: Chain, screws: Array | None = None) -> Array:
    """Compute the loop matrix S_0 of all joints, with the mimic relations below; (rows, n).

    ``S_0 q̇ = 0`` for joint rates that close the loops. Each loop has six or three rows, each
    relation has one.

    Args:
        chain: the linkage as arrays.
        screws: joint screws of another pose (n, 6 or 3); by default of the reference pose.
    """
    at = chain.screws if screws is None else freeze(screws)
    S = np.zeros((len(chain.ends) * at.shape[1] + len(chain.mimics), len(at)))
    fill_loop_matrix(chain.parent, at, chain.ends, chain.mimics, S)
    return S


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


def _add_known_twists_by_arrays(dim, k, parent, columns, moves, s, c, t):
    """Compute as `add_known_twists` does: all columns and orders of a joint at once."""
    if k == 0:
        c[0][moves] = columns[moves]
    first = min(k, 1)
    rates = np.where(moves, c[k - first :: -1] if k else c[:1], 0.0)
    for j, p in enumerate(parent.tolist()):
        t[k, j] = np.einsum("aw,ai->wi", rates[:, j], s[first : k + 1, j])
        if p >= 0:
            t[k, j] += t[k, p]


@kernel(inline=True, reference_counting=False, uncompiled=_add_known_twists_by_arrays)
def add_known_twists(dim, k, parent, columns, moves, s, c, t):
    """Compute order k of the link twists of all columns, without the unknown ``S_0 C_k``.

    ``T_{j,k} = T_{parent,k} + Σ_{1≤a≤k} s_{j,a} C_{j,k-a}``; in order 0, the rates of the
    independent joints are known and count: ``T_{j,0} = T_{parent,0} + s_{j,0} C_{j,0}``.

    Args:
        parent: in; link before each joint (n,).
        columns: in; rates of the independent joints (n, width).
        moves: in; whether a column can move a link (n, width).
        s: in; screws up to order k.
        c: in, lower orders; out in order 0, the rates of the independent joints.
        t: out; order k.
    """
    for j in range(parent.size):
        p = parent[j]
        for w in range(moves.shape[1]):
            if not moves[j, w]:
                continue
            now = t[k, j, w]
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


def _fill_right_side_by_arrays(dim, k, w, ends, mimics, columns, envelope, t, b):
    """Fill the right-hand side as `fill_right_side` does: all mimic relations at once."""
    row, loops = envelope[ROW], len(ends)
    b[:] = 0.0
    for loop, (before, after) in enumerate(ends.tolist()):
        side = b[row[loop] : row[loop] + dim]
        if before >= 0:
            side -= t[k, before, w, :dim]
        if after >= 0:
            side += t[k, after, w, :dim]
    if k == 0:
        b[row[loops : loops + len(mimics)]] -= mimics @ columns[:, w]
    return b.any()


@kernel(inline=True, reference_counting=False, uncompiled=_fill_right_side_by_arrays)
def fill_right_side(dim, k, w, ends, mimics, columns, envelope, t, b):
    """Fill the right-hand side of ``S_0 C_k = -Σ_{a≥1} S_a C_{k-a}``, by rows of the envelope.

    It is the twist of side B less that of side A of each weld. A mimic relation is constant:
    its right-hand side is 0 but for order 0, where the independent joints are known.

    Args:
        ends: in; links on side A and side B of each weld (L, 2).
        mimics: in; relations (g, n).
        columns: in; rates of the independent joints (n, width).
        envelope: in; the table of `kinematics.numerics.linalg.skyline_qr`.
        t: in; known part of the link twists of order k.
        b: out; the right-hand side (rows,), chain units.

    Returns:
        Whether it is not 0: whether column w moves a loop, or joints that others mimic.
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
    for i in range(b.size):
        if b[i] != 0.0:
            return True
    return False


@kernel(inline=True, reference_counting=False)
def complete_twists(dim, k, w, parent, screws, columns, moves, c, correction, t):
    """Add ``S_0 C_k`` of the dependent joints, now known, to the link twists of order k.

    Args:
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


def _sum_columns_by_arrays(dim, k, moves, ray, t, v):
    """Compute as `sum_columns` does: all links at once."""
    np.matmul(ray, t[k], out=v[k])


@kernel(inline=True, reference_counting=False, uncompiled=_sum_columns_by_arrays)
def sum_columns(dim, k, moves, ray, t, v):
    """Compute order k of the link twists along a ray: ``V_j = Σ_w T_{j,w} δ_w``.

    Args:
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
