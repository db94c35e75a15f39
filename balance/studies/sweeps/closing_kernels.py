"""Compiled kernels that close the loops of many geometries, one after the other.

Newton's method takes the steps ``(Jᵀ J + μ 1) Δ = -Jᵀ b`` with the closure residual b and
its derivatives J by the positions of some joints. With the sign σ of joint a on loop l, the
entries of ``Jᵀ J`` are ``(Σ_l σ_la σ_lc) s_a · s_c``, and those of mimic relations.
"""

from __future__ import annotations

import numpy as np

from kinematics.closure.newton_kernels import fill_closure_residual
from kinematics.model.spatial.displacements import place_links
from kinematics.numerics.array_types import Array
from kinematics.numerics.compiled.jit import kernel


@kernel(reference_counting=False)
def _solve_normal(N, x):
    """Solve ``N x = b`` by Cholesky's method, in place.

    Args:
        N: in: symmetric matrix (d, d), lower half; out: its factor.
        x: in: b (d,); out: the solution.

    Returns:
        Whether N is positive definite.
    """
    d = x.size
    for i in range(d):
        for j in range(i + 1):
            total = N[i, j]
            for k in range(j):
                total -= N[i, k] * N[j, k]
            if i > j:
                N[i, j] = total / N[j, j]
            elif total > 0.0:
                N[i, i] = np.sqrt(total)
            else:
                return False
    for i in range(d):
        for k in range(i):
            x[i] -= N[i, k] * x[k]
        x[i] /= N[i, i]
    for i in range(d - 1, -1, -1):
        for k in range(i + 1, d):
            x[i] -= N[k, i] * x[k]
        x[i] /= N[i, i]
    return True


@kernel(reference_counting=False)
def _newton_step(topology, s, b, damping, N, x):
    """Compute ``(Jᵀ J + μ 1)⁻¹ Jᵀ b``; see the head of this module.

    Args:
        topology: in: as for `close_each`.
        s: in: joint screws at the pose (n, 6).
        b: in: closure residual of loops, then of relations (rows,).
        damping: μ over the mean of the diagonal.
        N: workspace (d, d).
        x: out: the step (d,).

    Returns:
        Whether there is one.
    """
    _, _, signs, mimics, shared, joints = topology
    d, loops, mean = joints.size, signs.shape[0], 0.0
    for a in range(d):
        ja = joints[a]
        for c in range(a + 1):
            jc, dot = joints[c], 0.0
            if shared[ja, jc] != 0.0:
                for i in range(6):
                    dot += s[ja, i] * s[jc, i]
            N[a, c] = shared[ja, jc] * dot
            for r in range(mimics.shape[0]):
                N[a, c] += mimics[r, ja] * mimics[r, jc]
        mean += N[a, a] / d
        x[a] = 0.0
        for loop in range(loops):
            if signs[loop, ja] != 0.0:
                for i in range(6):
                    x[a] += signs[loop, ja] * s[ja, i] * b[6 * loop + i]
        for r in range(mimics.shape[0]):
            x[a] += mimics[r, ja] * b[6 * loops + r]
    for a in range(d):
        N[a, a] += damping * mean
    return _solve_normal(N, x)


@kernel(reference_counting=False)
def close_each(topology, geometries, limits, q, good, workspace):
    """Close the loops of each geometry by Newton's method, where it stays on its branch.

    Args:
        topology: in: parents (n,), ends of the welds (loops, 2), signs of joints on loops
            (loops, n) and mimic relations (relations, n); products ``Σ_l σ_la σ_lc`` (n, n);
            the joints that move (d,).
        geometries: in: joint screws (g, n, 6) and gaps (g, loops, 4, 4), chain units.
        limits: in: damping; closure residual of closed loops; last step but one; distance from
            the first step, over its length; most steps.
        q: in: joint positions (g, n) from which to start; out: those that close the loops.
        good: out: whether they do (g,).
        workspace: as from `closing_workspace`.
    """
    parent, ends, _, mimics, _, joints = topology
    screws, gaps = geometries
    damping, closed, done, branch, steps = limits
    H, s, b, N, numbers, scratch = workspace
    x, first, start = numbers[0], numbers[1], numbers[2]
    loops, d = ends.shape[0], joints.size
    for g in range(q.shape[0]):
        good[g] = False
        last = np.inf
        for a in range(d):
            first[a], start[a] = 0.0, q[g, joints[a]]
        for count in range(steps):
            place_links(parent, screws[g], q[g], H, s, scratch[0])
            fill_closure_residual(H, ends, gaps[g], b, 6, scratch)
            for r in range(mimics.shape[0]):
                b[6 * loops + r] = 0.0
                for j in range(parent.size):
                    b[6 * loops + r] += mimics[r, j] * q[g, j]
            size = 0.0
            for i in range(b.size):
                size = max(size, abs(b[i])) if abs(b[i]) < np.inf else np.inf
            if last <= done and size <= closed:
                good[g] = True
                break
            if not size < np.inf or not _newton_step(topology, s, b, damping, N, x[:d]):
                break
            last = 0.0
            for a in range(d):
                q[g, joints[a]] -= x[a]
                last = max(last, abs(x[a]))
                if count == 0:
                    first[a] = -x[a]
        off = length = 0.0
        for a in range(d):
            off += (q[g, joints[a]] - start[a] - first[a]) ** 2
            length += first[a] * first[a]
        if not off <= branch * branch * length + closed * closed:
            good[g] = False


@kernel(reference_counting=False)
def place_each(parent, screws, q, H, s, E):
    """Compute displacements of the links and screws of each geometry; see `place_links`.

    Args:
        parent: in: link before each joint, -1 for the ground (n,).
        screws: in: joint screws at the reference pose (g, n, 6).
        q: in: joint positions (g, n).
        H: out: displacements (g, n + 1, 4, 4); the last is the ground's, and stays.
        s: out: joint screws at the pose (g, n, 6).
    """
    for g in range(q.shape[0]):
        place_links(parent, screws[g], q[g], H[g], s[g], E)


def closing_workspace(joints: int, loops: int, relations: int) -> tuple[Array, ...]:
    """Allocate the workspace of `close_each`.

    Args:
        joints: how many there are.
        relations: likewise, of mimic joints.
    """
    return (
        np.empty((joints, 4, 4)),
        np.empty((joints, 6)),
        np.empty(6 * loops + relations),
        np.empty((joints, joints)),
        np.empty((3, joints)),
        np.empty((4, 4, 4)),
    )
