"""Displacements of links: products of exponentials and adjoints, compiled.

A displacement is ``H = [[R, d], [0, 1]]``, 4 by 4 in space and 3 by 3 in the plane. The pose of
a link is the product of the exponentials of the joints before it (R. W. Brockett, 1984);
screws are carried to the pose by the adjoint. Planar screws are ``[ω; v_x; v_y]``. Lengths are
in chain units.
"""

from __future__ import annotations

import numpy as np

from kinematics.model.spatial.screws import skew
from kinematics.numerics.compiled.jit import kernel


@kernel(reference_counting=False)
def _exponential(s, q, E):
    """Compute the displacement exp(q ŝ) of a unit screw: one formula for every kind of joint.

    ``E = 1 + q ŝ + (1 - cos q) ŝ² + (q - sin q) ŝ³``, with ``1 - cos q = 2 sin²(q/2)``.

    Args:
        s: in; a unit screw (6 or 3,).
        q: in; the joint position, radians or chain units.
        E: out; the displacement (4, 4) or (3, 3).
    """
    half = np.sin(0.5 * q)
    c2, c3 = 2.0 * half * half, q - np.sin(q)
    m = E.shape[0]
    for i in range(m):
        for j in range(m):
            E[i, j] = 1.0 if i == j else 0.0
    if m == 3:
        a = s[0]  # 1 for a revolute joint, 0 for a prismatic one
        E[0, 0] -= c2 * a * a
        E[1, 1] -= c2 * a * a
        E[1, 0] = (q - c3 * a * a) * a
        E[0, 1] = -E[1, 0]
        E[0, 2] = q * s[1] - c2 * a * s[2] - c3 * a * a * s[1]
        E[1, 2] = q * s[2] + c2 * a * s[1] - c3 * a * a * s[2]
        return
    size = s[0] * s[0] + s[1] * s[1] + s[2] * s[2]
    along = s[0] * s[3] + s[1] * s[4] + s[2] * s[5]
    for i in range(3):
        u, v = (i + 1) % 3, (i + 2) % 3  # component i of a × b is a_u b_v - a_v b_u
        # ŝ² of a twist is (ω ωᵀ - 1, ω × v), and ŝ³ is -ŝ but for the part of v along ω.
        for j in range(3):
            E[i, j] += c2 * s[i] * s[j]
        E[i, i] -= c2 * size
        E[v, u] += (q - c3 * size) * s[i]
        E[u, v] -= (q - c3 * size) * s[i]
        E[i, 3] = (
            q * s[3 + i]
            + c2 * (s[u] * s[3 + v] - s[v] * s[3 + u])
            + c3 * (along * s[i] - size * s[3 + i])
        )


@kernel(reference_counting=False)
def multiply_displacements(A, B, out):
    """Compute the product ``A B`` of small square matrices.

    Args:
        A: in; (m, m).
        B: in; (m, m).
        out: out; (m, m), neither A nor B.
    """
    m = A.shape[0]
    for i in range(m):
        for j in range(m):
            total = 0.0
            for k in range(m):
                total += A[i, k] * B[k, j]
            out[i, j] = total


@kernel(reference_counting=False)
def _carry_screw(H, s, out):
    """Compute ``Ad(H) s``: the screw s, carried along by the displacement H.

    ``Ad(H) [ω; v] = [R ω; R v + d × R ω]``.

    Args:
        H: in; a displacement (4, 4) or (3, 3).
        s: in; a screw (6 or 3,).
        out: out; the screw carried (6 or 3,).
    """
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


def _place_links_by_arrays(parent, screws, q, H, s, E):
    """Place links as `place_links` does, with the exponentials of all joints at once."""
    n, m = parent.size, H.shape[1]
    twists = np.zeros((n, m, m))
    twists[:, :-1, -1] = screws[:, 1 - m :]
    if m == 4:
        twists[:, :3, :3] = skew(screws[:, :3])
    else:
        twists[:, 1, 0], twists[:, 0, 1] = screws[:, 0], -screws[:, 0]
    squares, half, angle = twists @ twists, np.sin(0.5 * q), q[:, None, None]
    places = np.eye(m) + angle * twists + (2.0 * half * half)[:, None, None] * squares
    places += (angle - np.sin(angle)) * (squares @ twists)
    for j, before in enumerate(parent.tolist()):
        H[j] = H[before] @ places[j] if before >= 0 else places[j]
    s[:n] = screws
    moved = np.flatnonzero(parent >= 0)
    R, d = H[parent[moved], :-1, :-1], H[parent[moved], :-1, -1]
    if m == 4:
        turned = R @ screws[moved, :3, None]
        s[moved, :3] = turned[:, :, 0]
        s[moved, 3:] = (R @ screws[moved, 3:, None] + skew(d) @ turned)[:, :, 0]
    else:
        turned = (R @ screws[moved, 1:, None])[:, :, 0]
        s[moved, 1:] = turned + screws[moved, :1] * d[:, ::-1] * [1.0, -1.0]


@kernel(reference_counting=False, uncompiled=_place_links_by_arrays)
def place_links(parent, screws, q, H, s, E):
    """Compute the displacement of every link, and carry every screw to the pose.

    ``H_j = H_parent exp(q_j ŝ_j)`` and ``s_j(q) = Ad(H_parent) s_j``.

    Args:
        parent: in; link before each joint, -1 for the ground (n,).
        screws: in; joint screws at the reference pose (n, 6 or 3).
        q: in; joint positions (n,).
        H: out; displacements (n, 4, 4) or (n, 3, 3).
        s: out; joint screws at the pose (n, 6 or 3).
    """
    for j in range(parent.size):
        if parent[j] >= 0:
            _carry_screw(H[parent[j]], screws[j], s[j])
            _exponential(screws[j], q[j], E)
            multiply_displacements(H[parent[j]], E, H[j])
        else:
            for i in range(screws.shape[1]):
                s[j, i] = screws[j, i]
            _exponential(screws[j], q[j], H[j])


@kernel(reference_counting=False)
def invert_displacement(H, out):
    """Compute the inverse of a displacement: ``[[Rᵀ, -Rᵀ d], [0, 1]]``.

    Args:
        H: in; the displacement (4, 4) or (3, 3).
        out: out; its inverse, not H itself.
    """
    m = H.shape[0] - 1
    out[:] = 0.0
    out[m, m] = 1.0
    for i in range(m):
        for j in range(m):
            out[i, j] = H[j, i]
            out[i, m] -= H[j, i] * H[j, m]
