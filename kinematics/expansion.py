"""The closed motion as polynomials in the inputs: the compiled kernel of Taylor expansions.

Every quantity is a power series in the independent coordinates u, sorted by degree. The
radial derivative ``D = Σ u_i ∂/∂u_i`` multiplies degree k by k, so that the recursion along a
ray (see `kinematics.closure`) holds with polynomials for numbers and D for d/dt:

    V_j      = V_parent + s_j Dq_j
    k s_{j,k} = Σ_{a=1..k} ad(V_{parent,a}) s_{j,k-a}
    S_0 Dq_k = -Σ_{a≥1} S_a Dq_{k-a}              (each loop, A minus B)

The columns of C are not needed, as they are the derivatives of q. All products of one degree
are formed at once, each a *lane*: those in ad(V) s, component by component, and those in
``s Dq``, of all joints whose screws move. (J. J. de Jong, PhD thesis, University of Twente,
Eq. 4.30, has the same derivatives with Kronecker products and without symmetry.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinematics.chain import path
from kinematics.closure import factor, fill_loop_matrix, solve
from kinematics.kernels import kernel
from kinematics.linkage import Chain, IntArray, frozen
from kinematics.polynomials import Monomials, multiply

__all__ = ["Layout", "layout", "polynomials"]

Array = NDArray[np.float64]


class Layout(NamedTuple):
    """Which joints take part in products, and which equations close the loops.

    Attributes:
        slots: number of each joint among those whose screws change on the way from the ground
            to a loop, otherwise -1 (n,).
        signs: 1 if such a joint is on side B of a loop, -1 if on side A, otherwise 0
            (loops, such joints).
        links: those that carry such joints, and all before them.
        equations: rows of the loop matrix that are solved, in the least-squares sense.
    """

    slots: IntArray
    signs: Array
    links: IntArray
    equations: IntArray


def layout(chain: Chain, equations: IntArray | None = None) -> Layout:
    """The layout of a chain; all equations count by default."""
    n, dim = chain.screws.shape
    rows = len(chain.ends) * dim + len(chain.mimics)
    sides = np.zeros((len(chain.ends), n))
    inside, carrying = np.zeros(n, bool), np.zeros(n, bool)
    for loop, pair in enumerate(chain.ends.tolist()):
        for end, sign in zip(pair, (-1.0, 1.0), strict=True):
            way = path(chain.parent, end)
            sides[loop, way] += sign
            inside[way] = True
            carrying[way[1:]] = True
    carried = inside & (chain.parent >= 0)
    every = np.arange(rows) if equations is None else equations
    return Layout(
        slots=frozen(np.where(carried, np.cumsum(carried) - 1, -1), np.int64),
        signs=frozen(sides[:, carried]),
        links=frozen(np.flatnonzero(carrying), np.int64),
        equations=frozen(every, np.int64),
    )


@kernel
def _inverse(S, dependent, equations):
    """Pseudo-inverse of the dependent columns of a loop matrix (rows, n), transposed.

    Equations that do not count have rows of zeros, and joints that are not dependent columns
    of zeros. The condition number is the product of
    both Frobenius norms; it is infinite if the dependent joints are not determined, and 1
    without any.
    """
    nd, count = dependent.size, equations.size
    G = np.zeros(S.shape)
    A, diagonal, b = np.empty((count, nd)), np.zeros(nd), np.zeros(count)
    if nd == 0:
        return G, 1.0
    size = inverse = 0.0
    for r in range(count):
        for d in range(nd):
            A[r, d] = S[equations[r], dependent[d]]
            size += A[r, d] * A[r, d]
    if count >= nd:
        factor(A, diagonal)
    for d in range(nd):
        if diagonal[d] == 0.0:
            return G, np.inf
    for r in range(count):
        b[:] = 0.0
        b[r] = 1.0
        solve(A, diagonal, b)
        for d in range(nd):
            G[equations[r], dependent[d]] = b[d]
            inverse += b[d] * b[d]
    return G, np.sqrt(size * inverse)


@kernel
def _planar_screws(k, begin, end, joints, parent, screws, V, rates, Z, F):
    """Screws of degree k of the carried joints; they, and what multiplies them, are laid out.

    The lanes of joint c are ``s_x Dq, s_y Dq`` and, after those of all joints, ``ω s_x`` and
    ``ω s_y``.
    """
    half = F.shape[1] // 2
    for c in range(joints.size):
        j, p = joints[c], parent[joints[c]]
        y, x = 2 * c, 2 * (joints.size + c)
        n, mx, my = screws[j, 0], screws[j, 1], screws[j, 2]
        for m in range(begin, end):
            omega = V[m, p, 0]
            sx = (n * V[m, p, 2] - omega * my - Z[m, x + 1]) / k
            sy = (omega * mx - n * V[m, p, 1] + Z[m, x]) / k
            F[m, y] = F[m, half + x] = sx
            F[m, y + 1] = F[m, half + x + 1] = sy
            F[m, x] = F[m, x + 1] = omega
            F[m, half + y] = F[m, half + y + 1] = rates[m, j]


@kernel
def _spatial_screws(k, begin, end, joints, parent, screws, V, rates, Z, F):
    """As `_planar_screws`, in space.

    The lanes of joint c are six of ``s Dq`` and, after those of all joints, the products in
    the cross products of ω and n, of ω and m, and of v and n, where the screw is ``[n; m]``.
    """
    half = F.shape[1] // 2
    s = np.empty(6)
    for c in range(joints.size):
        j, p = joints[c], parent[joints[c]]
        y, x = 6 * c, 6 * joints.size + 18 * c
        for m in range(begin, end):
            for i in range(3):
                u, v = (i + 1) % 3, (i + 2) % 3
                wu, wv, vu, vv = V[m, p, u], V[m, p, v], V[m, p, 3 + u], V[m, p, 3 + v]
                nu, nv, mu, mv = screws[j, u], screws[j, v], screws[j, 3 + u], screws[j, 3 + v]
                z = x + i
                turn = wu * nv - wv * nu + Z[m, z] - Z[m, z + 3]
                shift = wu * mv - wv * mu + Z[m, z + 6] - Z[m, z + 9]
                shift += vu * nv - vv * nu + Z[m, z + 12] - Z[m, z + 15]
                s[i], s[3 + i] = turn / k, shift / k
                F[m, z] = F[m, z + 6] = wu
                F[m, z + 3] = F[m, z + 9] = wv
                F[m, z + 12], F[m, z + 15] = vu, vv
            for i in range(6):
                F[m, y + i], F[m, half + y + i] = s[i], rates[m, j]
            for i in range(3):
                u, v = (i + 1) % 3, (i + 2) % 3
                z = half + x + i
                F[m, z] = F[m, z + 12] = s[v]
                F[m, z + 3] = F[m, z + 15] = s[u]
                F[m, z + 6], F[m, z + 9] = s[3 + v], s[3 + u]


def _loop_kernels(dim):
    """Kernels for twists of ``dim`` components: 6 in space, 3 in a plane, where ω is linear."""
    changing = 6 if dim == 6 else 2
    still = dim - changing

    @kernel
    def twists(begin, end, links, parent, screws, slots, Z, rates, V):
        """Twists of links from the rates of the joints, for some monomials."""
        for j in links:
            p, y = parent[j], changing * slots[j]
            for m in range(begin, end):
                for i in range(dim):
                    component = screws[j, i] * rates[m, j]
                    if p >= 0:
                        component += V[m, p, i]
                    if y >= 0 and i >= still:
                        component += Z[m, y + i - still]
                    V[m, j, i] = component

    @kernel
    def close(begin, end, signs, G, Z, b, rates):
        """Rates of the dependent joints, from the products along the loops."""
        n = rates.shape[1]
        for m in range(begin, end):
            for loop in range(signs.shape[0]):
                for i in range(changing):
                    b[i] = 0.0
                for c in range(signs.shape[1]):
                    sign = signs[loop, c]
                    if sign != 0.0:
                        for i in range(changing):
                            b[i] += sign * Z[m, changing * c + i]
                for i in range(changing):
                    for j in range(n):
                        rates[m, j] += G[dim * loop + still + i, j] * b[i]

    return twists, close


_spatial_twists, _spatial_close = _loop_kernels(6)
_planar_twists, _planar_close = _loop_kernels(3)


@kernel
def _polynomials(
    parent, screws, ends, mimics, dependent, columns, slots, signs, links, equations,
    starts, places, pairs,
):  # fmt: skip
    """Coefficients (M, n) of q, and the condition number; see `polynomials`."""
    n, width = columns.shape
    dim = screws.shape[1]
    # Components of a screw that change, and products in its bracket with a twist.
    changing, brackets = (6, 18) if dim == 6 else (2, 2)
    order, M = starts.size - 2, places.shape[0] - 1
    rates = np.zeros((M, n))
    S = np.empty((ends.shape[0] * dim + mimics.shape[0], n))
    fill_loop_matrix(parent, screws, ends, mimics, np.arange(n), S)
    G, condition = _inverse(S, dependent, equations)
    for w in range(width):
        for j in range(n):
            rates[1 + w, j] += columns[j, w]
            if columns[j, w] != 0.0:
                for r in range(S.shape[0]):
                    for d in range(n):
                        rates[1 + w, d] -= G[r, d] * S[r, j] * columns[j, w]
    joints, b = np.flatnonzero(slots >= 0), np.empty(changing)
    few, lanes = changing * joints.size, (changing + brackets) * joints.size
    F, Z, V = np.empty((M, 2 * lanes)), np.empty((M, lanes)), np.empty((M, n, dim))
    for k in range(1, order + 1):
        begin, end = starts[k], starts[k + 1]
        # The last degree needs no screws, and so neither brackets nor twists.
        multiply(begin, end, few if k == order else lanes, places, pairs, F, Z)
        if dim == 3:
            _planar_close(begin, end, signs, G, Z, b, rates)
        else:
            _spatial_close(begin, end, signs, G, Z, b, rates)
        if k == order:
            break
        if dim == 3:
            _planar_twists(begin, end, links, parent, screws, slots, Z, rates, V)
            _planar_screws(k, begin, end, joints, parent, screws, V, rates, Z, F)
        else:
            _spatial_twists(begin, end, links, parent, screws, slots, Z, rates, V)
            _spatial_screws(k, begin, end, joints, parent, screws, V, rates, Z, F)
    for k in range(2, order + 1):
        for m in range(starts[k], starts[k + 1]):
            for j in range(n):
                rates[m, j] /= k
    return rates, condition


def polynomials(chain: Chain, which: Layout, table: Monomials) -> tuple[Array, float]:
    """The joint positions of the closed motion as polynomials in the chain's coordinates.

    Args:
        chain: the linkage at its reference pose, as arrays.
        which: from `layout`.
        table: the monomials of as many variables as the chain has columns.

    Returns:
        Coefficients of the positions, in the units of the chain (M, n), and the condition
        number of the equations that are solved, infinite if they determine no motion.
    """
    found: tuple[Array, float] = _polynomials(
        chain.parent, chain.screws, chain.ends, chain.mimics, chain.dependent, chain.columns,
        which.slots, which.signs, which.links, which.equations,
        table.starts, table.places, table.pairs,
    )  # fmt: skip
    return found
