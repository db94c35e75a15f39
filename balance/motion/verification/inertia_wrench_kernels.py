"""Inertia wrenches of all bodies at all samples of a motion: one kernel, and its arrays."""

from __future__ import annotations

import numpy as np

from kinematics.closure.series import add_bracket
from kinematics.model.arrays import Chain
from kinematics.model.spatial.displacements import place_links
from kinematics.model.spatial.inertia import spatial_inertias
from kinematics.model.spatial.screws import (
    bracket_twists,
    carry_twists,
    exp,
    turn_momenta,
)
from kinematics.numerics.array_types import Array
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.vectors import cross_products


def _fill_inertia_wrenches_by_arrays(parent, screws, links, z, motion, workspace, wrenches):
    """Compute inertia wrenches at all samples at once; see `fill_inertia_wrenches`."""
    q, qd, qdd = motion
    H = np.empty((parent.size, len(q), 4, 4))
    V, A = np.empty((2, *H.shape[:2], 6))
    for j, before in enumerate(parent.tolist()):
        speed, change = qd[:, j, None], qdd[:, j, None]
        s, H[j] = screws[j], exp(screws[j], q[:, j])
        if before < 0:
            V[j], A[j] = s * speed, s * change
            continue
        s, H[j] = carry_twists(H[before], s), H[before] @ H[j]
        V[j] = V[before] + s * speed
        A[j] = A[before] + s * change + bracket_twists(V[before], s) * speed
    moving = links >= 0
    links, M = links[moving], spatial_inertias(z[moving])
    H = H[links]
    R, p = H[..., :3, :3], H[..., :3, 3]
    back = H.copy()
    back[..., :3, :3], back[..., :3, 3] = R.mT, -(p[..., None, :] @ R)[..., 0, :]
    v, a = carry_twists(back, V[links]), carry_twists(back, A[links])
    carried = (a @ M + turn_momenta(v, v @ M)).reshape(*v.shape[:-1], 2, 3) @ R.mT
    carried[..., 0, :] += cross_products(p, carried[..., 1, :])
    wrenches[:], wrenches[:, moving] = 0.0, carried.reshape(v.shape).swapaxes(0, 1)


@kernel(reference_counting=False)
def _cross(a, b, out):
    """Add a cross product of vectors: ``out += a × b`` (3,)."""
    out[0] += a[1] * b[2] - a[2] * b[1]
    out[1] += a[2] * b[0] - a[0] * b[2]
    out[2] += a[0] * b[1] - a[1] * b[0]


@kernel(reference_counting=False, uncompiled=_fill_inertia_wrenches_by_arrays)
def fill_inertia_wrenches(parent, screws, links, z, motion, workspace, wrenches):
    """Compute the inertia wrench of each body, at all samples.

    See `balance.motion.verification.shaking_wrench.inertia_wrenches` for the formulas.

    Args:
        parent: in: link before each joint, -1 for the ground (n,).
        screws: in: joint screws at the reference pose (n, 6).
        links: in: link of each body (bodies,).
        z: in: parameters of the bodies (bodies, 10), chain units.
        motion: in: positions, velocities and accelerations of all joints (N, n).
        workspace: as from `wrench_workspace`.
        wrenches: out: ``[moment; force]`` (N, bodies, 6), zero for bodies at rest.
    """
    q, qd, qdd = motion
    H, s, twists, local = workspace
    V, A = twists[0], twists[1]
    n = parent.size
    for k in range(q.shape[0]):
        place_links(parent, screws, q[k], H, s, H[n])
        for j in range(n):
            before = parent[j] if parent[j] >= 0 else n  # the last twists are 0
            for i in range(6):
                V[j, i] = V[before, i] + s[j, i] * qd[k, j]
                A[j, i] = A[before, i] + s[j, i] * qdd[k, j]
            add_bracket(V[before], s[j], qd[k, j], A[j])
        for b in range(links.size):
            wrench = wrenches[k, b]
            wrench[:] = 0.0
            if links[b] >= 0:
                pose = H[links[b]]
                _carry_back(pose, V[links[b]], local[0], local[1])
                _carry_back(pose, A[links[b]], local[2], local[3])
                _fill_body_wrench(z[b], local)
                for i in range(3):
                    for r in range(3):
                        wrench[i] += pose[i, r] * local[6, r]
                        wrench[3 + i] += pose[i, r] * local[7, r]
                for r in range(3):
                    local[0, r] = pose[r, 3]
                _cross(local[0], wrench[3:], wrench[:3])


@kernel(reference_counting=False)
def _carry_back(H, t, turning, moving):
    """Compute ``Ad(H)⁻¹ t`` of a twist (6,): ``[Rᵀ ω; Rᵀ (v + ω × d)]``."""
    x = t[3] + t[1] * H[2, 3] - t[2] * H[1, 3]
    y = t[4] + t[2] * H[0, 3] - t[0] * H[2, 3]
    z = t[5] + t[0] * H[1, 3] - t[1] * H[0, 3]
    for i in range(3):
        turning[i] = H[0, i] * t[0] + H[1, i] * t[1] + H[2, i] * t[2]
        moving[i] = H[0, i] * x + H[1, i] * y + H[2, i] * z


@kernel(reference_counting=False)
def _fill_body_wrench(z, local):
    """Compute ``M a - ad(v)ᵀ M v`` in the coordinates of a body.

    Args:
        z: in: its parameters (10,).
        local: in: ω, v, their rates (rows 0 to 3); out: momentum and its rate, each
            ``[moment; force]`` (rows 4 to 7).
    """
    for part in range(2):
        omega, v = local[2 * part], local[2 * part + 1]
        moment, force = local[4 + 2 * part], local[5 + 2 * part]
        moment[0] = z[4] * omega[0] + z[7] * omega[1] + z[8] * omega[2]
        moment[1] = z[7] * omega[0] + z[5] * omega[1] + z[9] * omega[2]
        moment[2] = z[8] * omega[0] + z[9] * omega[1] + z[6] * omega[2]
        for i in range(3):
            force[i] = z[0] * v[i]
        _cross(z[1:4], v, moment)
        _cross(omega, z[1:4], force)
    _cross(local[0], local[4], local[6])
    _cross(local[1], local[5], local[6])
    _cross(local[0], local[5], local[7])


def wrench_workspace(chain: Chain) -> tuple[Array, ...]:
    """Allocate the workspace of `fill_inertia_wrenches`.

    Args:
        chain: the linkage as arrays of a spatial chain.

    Returns:
        Displacements (n + 1, 4, 4), screws (n, 6), twists and their rates, zero after those
        of the links (2, n + 1, 6), and eight vectors (8, 3).
    """
    n = chain.parent.size
    return np.empty((n + 1, 4, 4)), np.empty((n, 6)), np.zeros((2, n + 1, 6)), np.empty((8, 3))
