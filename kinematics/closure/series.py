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
is the mismatch of two link twists. (A. Müller, "Higher derivatives of the kinematic
mapping and some applications", Mech. Mach. Theory 76, 2014; J. J. de Jong, PhD thesis,
University of Twente, chapter 4.)

Planar linkages use the same text with three components ``[ω; v_x; v_y]``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.compiled.jit import kernel
from kinematics.linalg.skyline_qr import COUNT, HEIGHT, JOINT, ROW, ROWS, factor, fill, solve
from kinematics.model.arrays import Chain, frozen, read_only

__all__ = [
    "Series",
    "add_bracket",
    "expand",
    "expand_from",
    "fill_loop_matrix",
    "loop_matrix",
    "planar_series",
    "room",
    "spatial_series",
]

Array = NDArray[np.float64]


@kernel
def fill_loop_matrix(parent, screws, ends, mimics, S):
    """Put the loop matrix S_0 of all joints, with the mimic relations below, into zeros."""
    dim, base = screws.shape[1], ends.shape[0] * screws.shape[1]
    for loop in range(ends.shape[0]):
        for side in range(2):
            sign = 1.0 - 2.0 * side
            j = ends[loop, side]
            while j >= 0:
                for i in range(dim):
                    S[loop * dim + i, j] += sign * screws[j, i]
                j = parent[j]
    for relation in range(mimics.shape[0]):
        for j in range(parent.size):
            S[base + relation, j] = mimics[relation, j]


@kernel(inline=True, reference_counting=False)
def _planar_bracket(V, s, factor, out):
    out[1] += factor * (s[0] * V[2] - V[0] * s[2])
    out[2] += factor * (V[0] * s[1] - s[0] * V[1])


@kernel(inline=True, reference_counting=False)
def _spatial_bracket(V, s, factor, out):
    out[0] += factor * (V[1] * s[2] - V[2] * s[1])
    out[1] += factor * (V[2] * s[0] - V[0] * s[2])
    out[2] += factor * (V[0] * s[1] - V[1] * s[0])
    out[3] += factor * (V[4] * s[2] - V[5] * s[1] + V[1] * s[5] - V[2] * s[4])
    out[4] += factor * (V[5] * s[0] - V[3] * s[2] + V[2] * s[3] - V[0] * s[5])
    out[5] += factor * (V[3] * s[1] - V[4] * s[0] + V[0] * s[4] - V[1] * s[3])


@kernel(reference_counting=False)
def add_bracket(V, s, factor, out):
    """Add ``factor ad(V) s`` to ``out``; spatial or planar by the number of components."""
    if s.size == 3:
        _planar_bracket(V, s, factor, out)
    else:
        _spatial_bracket(V, s, factor, out)


def _series_kernel(dim):
    """The series for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def series(first, last, chain, screws, rays, room):
        """Orders first … last of the series into room, where those before must be.

        Args:
            first: the first order.
            last: the last order.
            chain: arrays of the chain, as `Chain.walked`.
            screws: the joint screws.
            rays: directions (count, width).
            room: as from `room`, for as many rays and orders or more.
        """
        parent, _, ends, mimics, columns, moves, lines = chain
        F, work, S, V, C, T, residual = room
        n, nd, width = parent.size, F.shape[0], rays.shape[1]
        loops, row, joints = ends.shape[0], lines[ROW], lines[JOINT]
        rows = lines[COUNT, ROWS]
        diagonal, b, extra = work[:nd], work[nd : nd + rows], work[nd + rows :]
        if first == 0:
            fill(screws, mimics, lines, F)
            factor(F, lines, diagonal)
        for k in range(first, last + 1):
            residual[k] = 0.0
        for ray in range(rays.shape[0]):
            s, v, c, t = S[ray], V[ray], C[ray], T[ray]
            for k in range(first, last + 1):
                for j in range(n):
                    now = s[k, j]
                    for i in range(dim):
                        now[i] = screws[j, i] if k == 0 else 0.0
                    for a in range(k if parent[j] >= 0 else 0):
                        above, before = v[a, parent[j]], s[k - 1 - a, j]
                        if dim == 3:
                            _planar_bracket(above, before, 1.0 / k, now)
                        else:
                            _spatial_bracket(above, before, 1.0 / k, now)
                for w in range(width):
                    if k == 0 and ray > 0:
                        for j in range(n):
                            c[0, j, w] = C[0, 0, j, w]
                            for i in range(dim):
                                t[0, j, w, i] = T[0, 0, j, w, i]
                        continue
                    # Link twists of order k, as far as they are known without C_k.
                    for j in range(n):
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
                    if nd == 0:
                        continue
                    # Their mismatch at the welds gives C_k.
                    for i in range(rows):
                        b[i] = 0.0
                    for loop in range(loops):
                        for side in range(2):
                            j, sign = ends[loop, side], 2.0 * side - 1.0
                            if j >= 0:
                                for i in range(dim):
                                    b[row[loop] + i] += sign * t[k, j, w, i]
                    for relation in range(mimics.shape[0] if k == 0 else 0):
                        for j in range(n):
                            b[row[loops + relation]] -= mimics[relation, j] * columns[j, w]
                    residual[k] = max(residual[k], solve(F, lines, diagonal, b))
                    for d in range(nd):
                        c[k, joints[d], w] = b[d]
                    # s_0 C_k of the dependent joints completes the twists.
                    for j in range(n):
                        if not moves[j, w]:
                            continue
                        rate = c[k, j, w] - (columns[j, w] if k == 0 else 0.0)
                        p = parent[j]
                        for i in range(dim):
                            extra[j * dim + i] = screws[j, i] * rate
                            if p >= 0 and moves[p, w]:
                                extra[j * dim + i] += extra[p * dim + i]
                            t[k, j, w, i] += extra[j * dim + i]
                for j in range(n):
                    for i in range(dim):
                        v[k, j, i] = 0.0
                    for w in range(width):
                        if moves[j, w]:
                            for i in range(dim):
                                v[k, j, i] += t[k, j, w, i] * rays[ray, w]

    return series


spatial_series, planar_series = _series_kernel(6), _series_kernel(3)


def room(chain: Chain, rays: int, order: int) -> tuple[Array, ...]:
    """Room for a series: the loop matrix and numbers by rows, then S, V, C, T, residual."""
    n, dim = chain.screws.shape
    height, rows = chain.lines[COUNT, HEIGHT : ROWS + 1].tolist()
    nd = chain.dependent.size
    S, V = np.zeros((2, rays, order + 1, n, dim))
    return (
        np.empty((nd, height)), np.empty(nd + rows + n * dim), S, V,
        np.zeros((rays, order + 1, n, chain.width)),
        np.zeros((rays, order + 1, n, chain.width, dim)), np.zeros(order + 1),
    )  # fmt: skip


class Series(NamedTuple):
    """Power series of the motion along rays, in the frame and units of the chain.

    Attributes:
        C: joint rates for unit rates of the coordinates; (rays, order + 1, n, width).
        V: link twists along the rays; (rays, order + 1, n, 6 or 3).
        T: link twists for unit rates; (rays, order + 1, n, width, 6 or 3).
        residual: largest mismatch of the loops that no joint rate removes, by order; it
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


def expand(chain: Chain, rays: Array, order: int) -> Series:
    """Power series of the closed motion along ``u = t δ``, at the reference pose.

    Args:
        chain: the linkage as arrays.
        rays: directions δ in the coordinates of the chain; (rays, width).
        order: highest order.
    """
    return expand_from(chain, chain.screws, rays, order)


def expand_from(chain: Chain, screws: Array, rays: Array, order: int) -> Series:
    """As `expand`, at a pose to which the joint screws (n, 6 or 3) have been carried."""
    space = room(chain, len(rays), order)
    series = planar_series if chain.planar else spatial_series
    series(0, order, chain.walked, screws, read_only(rays), space)
    _, _, _, V, C, T, residual = space
    return Series(C, V, T, residual)


def loop_matrix(chain: Chain, screws: Array | None = None) -> Array:
    """Loop matrix S_0 of all joints, with the mimic relations below; (rows, n).

    Args:
        chain: the linkage as arrays.
        screws: joint screws of another pose; those of the reference pose by default.
    """
    at = chain.screws if screws is None else frozen(screws)
    S = np.zeros((len(chain.ends) * at.shape[1] + len(chain.mimics), len(at)))
    fill_loop_matrix(chain.parent, at, chain.ends, chain.mimics, S)
    return S
