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

from kinematics.kernels import kernel
from kinematics.linkage import Chain, frozen

__all__ = [
    "Pose",
    "Series",
    "expand",
    "expand_at",
    "follow",
    "forward",
    "loop_matrix",
    "mismatch",
    "radius",
]

Array = NDArray[np.float64]


@kernel
def _factor(A, diagonal):
    """Householder QR of A (rows ≥ columns) in place; R's diagonal goes to ``diagonal``."""
    rows, columns = A.shape
    for k in range(columns):
        norm = 0.0
        for i in range(k, rows):
            norm += A[i, k] * A[i, k]
        norm = np.sqrt(norm)
        if norm == 0.0:
            diagonal[k] = 0.0
            continue
        if A[k, k] > 0.0:
            norm = -norm
        diagonal[k] = norm
        A[k, k] -= norm
        for j in range(k + 1, columns):
            dot = 0.0
            for i in range(k, rows):
                dot += A[i, k] * A[i, j]
            dot /= norm * A[k, k]
            for i in range(k, rows):
                A[i, j] += dot * A[i, k]


@kernel
def _solve(A, diagonal, b):
    """Least-squares solution of the factored system, in the head of b; returns the residual.

    The tail of b keeps the residual in the rotated rows; its norm is returned.
    """
    rows, columns = A.shape
    for k in range(columns):
        if diagonal[k] == 0.0:
            continue
        dot = 0.0
        for i in range(k, rows):
            dot += A[i, k] * b[i]
        dot /= diagonal[k] * A[k, k]
        for i in range(k, rows):
            b[i] += dot * A[i, k]
    for k in range(columns - 1, -1, -1):
        for j in range(k + 1, columns):
            b[k] -= A[k, j] * b[j]
        b[k] = b[k] / diagonal[k] if diagonal[k] != 0.0 else 0.0
    residual = 0.0
    for i in range(columns, rows):
        residual += b[i] * b[i]
    return np.sqrt(residual)


@kernel
def _loop_matrix(parent, screws, ends, mimics, joints, A):
    """Columns ``joints`` of the loop matrix S_0, and below them the mimic relations."""
    dim = screws.shape[1]
    position = np.full(parent.size, -1)
    for c in range(joints.size):
        position[joints[c]] = c
    A[:] = 0.0
    for loop in range(ends.shape[0]):
        for side in range(2):
            sign = 1.0 - 2.0 * side
            j = ends[loop, side]
            while j >= 0:
                c = position[j]
                if c >= 0:
                    for i in range(dim):
                        A[loop * dim + i, c] += sign * screws[j, i]
                j = parent[j]
    base = ends.shape[0] * dim
    for row in range(mimics.shape[0]):
        for c in range(joints.size):
            A[base + row, c] = mimics[row, joints[c]]


@kernel
def _add_bracket(V, s, factor, out):
    """Add ``factor ad(V) s`` to ``out``; spatial or planar by the number of components."""
    if s.size == 3:
        out[1] += factor * (s[0] * V[2] - V[0] * s[2])
        out[2] += factor * (V[0] * s[1] - s[0] * V[1])
    else:
        out[0] += factor * (V[1] * s[2] - V[2] * s[1])
        out[1] += factor * (V[2] * s[0] - V[0] * s[2])
        out[2] += factor * (V[0] * s[1] - V[1] * s[0])
        out[3] += factor * (V[4] * s[2] - V[5] * s[1] + V[1] * s[5] - V[2] * s[4])
        out[4] += factor * (V[5] * s[0] - V[3] * s[2] + V[2] * s[3] - V[0] * s[5])
        out[5] += factor * (V[3] * s[1] - V[4] * s[0] + V[0] * s[4] - V[1] * s[3])


def _series_kernel(dim):
    """The series for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel
    def series(parent, screws, ends, mimics, dependent, columns, moves, rays, order):
        """All orders 0 … order of C, V and T along every ray; see `expand`."""
        n = parent.size
        count, width = rays.shape
        loops = ends.shape[0]
        rows = loops * dim + mimics.shape[0]
        nd = dependent.size
        A = np.empty((rows, nd))
        diagonal = np.empty(nd)
        _loop_matrix(parent, screws, ends, mimics, dependent, A)
        _factor(A, diagonal)

        S = np.zeros((count, order + 1, n, dim))
        V = np.zeros((count, order + 1, n, dim))
        C = np.zeros((count, order + 1, n, width))
        T = np.zeros((count, order + 1, n, width, dim))
        residual = np.zeros(order + 1)
        b = np.empty(rows)
        extra = np.zeros((n, dim))
        for ray in range(count):
            s, v, c, t = S[ray], V[ray], C[ray], T[ray]
            for k in range(order + 1):
                for j in range(n):
                    if k == 0:
                        for i in range(dim):
                            s[0, j, i] = screws[j, i]
                    elif parent[j] >= 0:
                        for a in range(k):
                            _add_bracket(v[a, parent[j]], s[k - 1 - a, j], 1.0 / k, s[k, j])
                if k == 0 and ray > 0:
                    c[0] = C[0, 0]
                    t[0] = T[0, 0]
                else:
                    for w in range(width):
                        # Link twists of order k, as far as they are known without C_k.
                        for j in range(n):
                            if not moves[j, w]:
                                continue
                            if parent[j] >= 0:
                                for i in range(dim):
                                    t[k, j, w, i] = t[k, parent[j], w, i]
                            if k == 0:
                                c[0, j, w] = columns[j, w]
                            for a in range(min(k, 1), k + 1):
                                rate = c[k - a, j, w]
                                if rate != 0.0:
                                    for i in range(dim):
                                        t[k, j, w, i] += s[a, j, i] * rate
                        if nd == 0:
                            continue
                        # Their mismatch at the welds gives C_k.
                        b[:] = 0.0
                        for loop in range(loops):
                            for i in range(dim):
                                if ends[loop, 0] >= 0:
                                    b[loop * dim + i] -= t[k, ends[loop, 0], w, i]
                                if ends[loop, 1] >= 0:
                                    b[loop * dim + i] += t[k, ends[loop, 1], w, i]
                        if k == 0:
                            for row in range(mimics.shape[0]):
                                for j in range(n):
                                    b[loops * dim + row] -= mimics[row, j] * columns[j, w]
                        residual[k] = max(residual[k], _solve(A, diagonal, b))
                        for d in range(nd):
                            c[k, dependent[d], w] = b[d]
                        # s_0 C_k of the dependent joints completes the twists.
                        for j in range(n):
                            if not moves[j, w]:
                                continue
                            rate = c[k, j, w] - (columns[j, w] if k == 0 else 0.0)
                            p = parent[j]
                            for i in range(dim):
                                extra[j, i] = screws[j, i] * rate
                                if p >= 0 and moves[p, w]:
                                    extra[j, i] += extra[p, i]
                                t[k, j, w, i] += extra[j, i]
                for j in range(n):
                    for w in range(width):
                        if moves[j, w]:
                            for i in range(dim):
                                v[k, j, i] += t[k, j, w, i] * rays[ray, w]
        return C, V, T, residual

    return series


_spatial_series, _planar_series = _series_kernel(6), _series_kernel(3)


@kernel
def _exponential(s, q, E):
    """Displacement exp(q ŝ) of a unit screw: one formula for every kind of joint."""
    half = np.sin(0.5 * q)
    c2, c3 = 2.0 * half * half, q - np.sin(q)
    m = E.shape[0]
    E[:] = 0.0
    for i in range(m):
        E[i, i] = 1.0
    if m == 3:
        a = s[0]
        E[0, 0] -= c2 * a * a
        E[1, 1] -= c2 * a * a
        E[1, 0] = (q - c3 * a * a) * a
        E[0, 1] = -E[1, 0]
        E[0, 2] = q * s[1] - c2 * a * s[2] - c3 * a * a * s[1]
        E[1, 2] = q * s[2] + c2 * a * s[1] - c3 * a * a * s[2]
        return
    hat = np.zeros((4, 4))
    hat[2, 1], hat[0, 2], hat[1, 0] = s[0], s[1], s[2]
    hat[1, 2], hat[2, 0], hat[0, 1] = -s[0], -s[1], -s[2]
    hat[0, 3], hat[1, 3], hat[2, 3] = s[3], s[4], s[5]
    power = hat.copy()
    product = np.empty((4, 4))
    for coefficient in (q, c2, c3):
        for i in range(3):
            for j in range(4):
                E[i, j] += coefficient * power[i, j]
        _multiply(power, hat, product)
        power[:] = product


@kernel
def _multiply(A, B, out):
    """Matrix product of small square matrices."""
    m = A.shape[0]
    for i in range(m):
        for j in range(m):
            total = 0.0
            for k in range(m):
                total += A[i, k] * B[k, j]
            out[i, j] = total


@kernel
def _carry(H, s, out):
    """Ad(H) s: the screw s, carried along by the displacement H."""
    if s.size == 3:
        out[0] = s[0]
        out[1] = H[0, 0] * s[1] + H[0, 1] * s[2] + s[0] * H[1, 2]
        out[2] = H[1, 0] * s[1] + H[1, 1] * s[2] - s[0] * H[0, 2]
        return
    for i in range(3):
        out[i] = H[i, 0] * s[0] + H[i, 1] * s[1] + H[i, 2] * s[2]
        out[3 + i] = H[i, 0] * s[3] + H[i, 1] * s[4] + H[i, 2] * s[5]
    out[3] += H[1, 3] * out[2] - H[2, 3] * out[1]
    out[4] += H[2, 3] * out[0] - H[0, 3] * out[2]
    out[5] += H[0, 3] * out[1] - H[1, 3] * out[0]


@kernel
def _forward(parent, screws, q, H, s):
    """Displacement of every link, and every screw carried to the pose."""
    m = H.shape[1]
    E = np.empty((m, m))
    for j in range(parent.size):
        if parent[j] >= 0:
            _carry(H[parent[j]], screws[j], s[j])
            _exponential(screws[j], q[j], E)
            _multiply(H[parent[j]], E, H[j])
        else:
            s[j] = screws[j]
            _exponential(screws[j], q[j], H[j])


@kernel
def _invert(H, out):
    """Inverse of a displacement."""
    m = H.shape[0] - 1
    out[:] = 0.0
    out[m, m] = 1.0
    for i in range(m):
        for j in range(m):
            out[i, j] = H[j, i]
            out[i, m] -= H[j, i] * H[j, m]


@kernel
def _mismatch(H, ends, gaps, b, dim):
    """Twists (small) from each loop's successor to its end; zero if the loop is closed.

    Without ``gaps``, the loops are closed at the reference pose.
    """
    m = H.shape[1]
    identity = np.eye(m)
    inverse, product, D = np.empty((m, m)), np.empty((m, m)), np.empty((m, m))
    for loop in range(ends.shape[0]):
        e, f = ends[loop, 0], ends[loop, 1]
        product[:] = H[e] if e >= 0 else identity
        if gaps.shape[0] > 0:
            _invert(gaps[loop], inverse)
            _multiply(H[e] if e >= 0 else identity, inverse, product)
        _invert(H[f] if f >= 0 else identity, inverse)
        _multiply(product, inverse, D)
        r = loop * dim
        if dim == 3:
            b[r] = 0.5 * (D[1, 0] - D[0, 1])
        else:
            b[r] = 0.5 * (D[2, 1] - D[1, 2])
            b[r + 1] = 0.5 * (D[0, 2] - D[2, 0])
            b[r + 2] = 0.5 * (D[1, 0] - D[0, 1])
        for i in range(m - 1):
            b[r + dim - m + 1 + i] = D[i, m - 1]


@kernel
def _close(parent, screws, ends, gaps, mimics, dependent, q, H, s):
    """Newton's method on the dependent joints of q, in place; returns the last mismatch."""
    dim = screws.shape[1]
    rows = ends.shape[0] * dim + mimics.shape[0]
    A = np.empty((rows, dependent.size))
    diagonal = np.empty(dependent.size)
    b = np.empty(rows)
    best = np.inf
    for _ in range(30):
        _forward(parent, screws, q, H, s)
        _mismatch(H, ends, gaps, b, dim)
        for row in range(mimics.shape[0]):
            b[ends.shape[0] * dim + row] = np.sum(mimics[row] * q)
        error = np.sqrt(np.sum(b * b))
        if not error < 1e6 or (error < 1e-12 and error >= 0.5 * best) or error == 0.0:
            return error
        best = min(best, error)
        _loop_matrix(parent, s, ends, mimics, dependent, A)
        _factor(A, diagonal)
        for i in range(rows):
            b[i] = -b[i]
        _solve(A, diagonal, b)
        for d in range(dependent.size):
            q[dependent[d]] += b[d]
    return error


@kernel
def _radius(rates):
    """Radius of convergence of the joint rates (order + 1, n); see `radius`."""
    limit = 1.0
    first = np.sqrt(np.sum(rates[0] ** 2))
    for k in range(rates.shape[0]):
        size = np.sqrt(np.sum(rates[k] ** 2))
        limit = max(limit, size if k == 0 else (size / first) ** (1.0 / k))
    return 1.0 / limit


@kernel
def _follow(parent, screws, ends, mimics, dependent, start, C, ray, reach, H, s):
    """A closed pose along the ray; see `follow`."""
    orders, n, width = C.shape
    rates = np.zeros((orders, n))
    for k in range(orders):
        for j in range(n):
            for w in range(width):
                rates[k, j] += C[k, j, w] * ray[w]
    step = min(reach, 0.4 * _radius(rates))
    gaps = np.empty((0, H.shape[1], H.shape[1]))
    q = np.empty(n)
    for _ in range(7):
        guess = start.copy()
        for k in range(orders):
            guess += step ** (k + 1) / (k + 1) * rates[k]
        q[:] = guess
        error = _close(parent, screws, ends, gaps, mimics, dependent, q, H, s)
        moved, off = np.sum((guess - start) ** 2), np.sum((q - guess) ** 2)
        if error < 1e-10 and off <= 0.01 * moved:
            return q, step
        step *= 0.5
    return q, 0.0


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


class Pose(NamedTuple):
    """A finite pose, in the frame and units of the chain.

    Attributes:
        q: joint positions (n,).
        H: displacements of the links (n, 4, 4), or (n, 3, 3) if planar.
        screws: joint screws at this pose (n, 6 or 3).
        error: mismatch of the loops, in radians and units of the chain.
    """

    q: Array
    H: Array
    screws: Array
    error: float


def expand(chain: Chain, rays: Array, order: int) -> Series:
    """Power series of the closed motion along ``u = t δ``, at the reference pose.

    Args:
        chain: the linkage as arrays.
        rays: directions δ in the coordinates of the chain; (rays, width).
        order: highest order.
    """
    return _expand(chain, chain.screws, rays, order)


def expand_at(chain: Chain, pose: Pose) -> Series:
    """The series of order 0 at a finite pose: rates and link twists there."""
    return _expand(chain, pose.screws, np.zeros((1, chain.width)), 0)


def _expand(chain: Chain, screws: Array, rays: Array, order: int) -> Series:
    series = _planar_series if chain.planar else _spatial_series
    return Series(
        *series(
            chain.parent, screws, chain.ends, chain.mimics, chain.dependent,
            chain.columns, chain.moves, rays, order,
        )
    )  # fmt: skip


def loop_matrix(chain: Chain, screws: Array | None = None) -> Array:
    """Loop matrix S_0 of all joints, with the mimic relations below; (rows, n).

    Args:
        chain: the linkage as arrays.
        screws: joint screws of another pose; those of the reference pose by default.
    """
    joints = frozen(range(chain.parent.size), np.int64)
    rows = len(chain.ends) * chain.screws.shape[1] + len(chain.mimics)
    A = np.empty((rows, joints.size))
    at = chain.screws if screws is None else frozen(screws)
    _loop_matrix(chain.parent, at, chain.ends, chain.mimics, joints, A)
    return A


def radius(rates: Array) -> float:
    """Radius of convergence estimated from the growth of joint rates (order + 1, n).

    At most 1, and such that no joint moves by more than 1 to first order.
    """
    return float(_radius(rates))


def follow(
    chain: Chain, start: Array, series: Series, ray: Array, reach: float = np.inf
) -> tuple[Pose, float]:
    """A closed pose further along a ray, on the same branch.

    The step is the smaller of ``reach`` and 0.4 of the radius of convergence estimated
    from the series, whose sum is the first guess of Newton's method; it is halved until
    the method stays within a tenth of that guess.

    Args:
        chain: the linkage at its reference pose.
        start: joint positions from which to start (n,).
        series: the series there; its last ray is used.
        ray: the direction of that ray (w,).
        reach: longest step.

    Returns:
        The pose and the length of the step, 0 if none was found.
    """
    H, screws = _room(chain)
    q, step = _follow(
        chain.parent, chain.screws, chain.ends, chain.mimics, chain.dependent,
        start, series.C[-1], ray, reach, H, screws,
    )  # fmt: skip
    screws.flags.writeable = False
    return Pose(q, H, screws, 0.0), step


def _room(chain: Chain) -> tuple[Array, Array]:
    """Room for the displacements and the screws of a pose."""
    m = 3 if chain.planar else 4
    return np.empty((chain.parent.size, m, m)), np.empty(chain.screws.shape)


def forward(chain: Chain, q: Array) -> Pose:
    """The pose at given joint positions (n,), whether or not it closes the loops."""
    H, screws = _room(chain)
    _forward(chain.parent, chain.screws, q, H, screws)
    screws.flags.writeable = False
    error = mismatch(chain, H, q)
    return Pose(q, H, screws, float(np.sqrt(error @ error)))


def mismatch(chain: Chain, H: Array, q: Array, gaps: Array | None = None) -> Array:
    """Twists by which the loops are open at a pose, then errors of mimic joints; (rows,).

    Args:
        chain: the linkage as arrays.
        H: displacements of the links.
        q: joint positions.
        gaps: displacements of the welds at the reference pose, if they are not closed.
    """
    dim = chain.screws.shape[1]
    b = np.empty(len(chain.ends) * dim + len(chain.mimics))
    _mismatch(H, chain.ends, np.empty((0, *H.shape[1:])) if gaps is None else gaps, b, dim)
    b[len(chain.ends) * dim :] = chain.mimics @ q
    return b
