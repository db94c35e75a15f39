"""Newton's method on the loops of a chain, and steps along a series: compiled kernels.

A pose is closed by ``q ← q - S_0⁺ b(q)`` on the dependent joints, with the loop matrix S_0 and
the closure residual b. A step along a ray starts it from the sum of a power series.
"""

from __future__ import annotations

import numpy as np

from kinematics.model.arrays import Chain
from kinematics.model.spatial.displacements import (
    invert_displacement,
    multiply_displacements,
    place_links,
)
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
from kinematics.numerics.tolerances import (
    BRANCH_DISTANCE_SQUARED,
    FOLLOWED_POSE_RESIDUAL,
    NEWTON_DIVERGED,
    NEWTON_ROUND_OFF,
    NEWTON_STALL_RESIDUAL,
)

# Most steps: Newton's method converges quadratically, or does not converge.
MAX_NEWTON_STEPS = 30
# Largest part of the radius of convergence that one step covers.
RADIUS_SHARE = 0.4
# How often a step is halved before it is given up.
MAX_HALVINGS = 6


@kernel(reference_counting=False)
def fill_closure_residual(H, ends, gaps, b, dim, scratch):
    """Compute the small twists by which the loops are open at a pose.

    With ``D = H_A gap⁻¹ H_B⁻¹``, which is 1 if the loop is closed, it is the skew part of the
    rotation and the translation of D: a twist to first order.

    Args:
        H: in; displacements of the links (n, 4, 4), or (n, 3, 3) in the plane.
        ends: in; links on side A and side B of each weld, -1 for the ground (L, 2).
        gaps: in; displacements of the welds at the reference pose (L, 4, 4) or (L, 3, 3). An
            array of length 0 if the loops are closed there.
        b: out; the twists, one loop below the other (dim L or more,), chain units.
        dim: components of a twist, 6 or 3.
    """
    m = H.shape[1]
    identity, inverse, product, D = scratch[0], scratch[1], scratch[2], scratch[3]
    for i in range(m):
        for j in range(m):
            identity[i, j] = 1.0 if i == j else 0.0
    for loop in range(ends.shape[0]):
        e, f = ends[loop, 0], ends[loop, 1]
        invert_displacement(H[f] if f >= 0 else identity, inverse)
        multiply_displacements(H[e] if e >= 0 else identity, inverse, D)
        if gaps.shape[0] > 0:
            invert_displacement(gaps[loop], D)
            multiply_displacements(H[e] if e >= 0 else identity, D, product)
            multiply_displacements(product, inverse, D)
        r = loop * dim
        # rotation: half of D - Dᵀ
        if dim == 3:
            b[r] = 0.5 * (D[1, 0] - D[0, 1])
        else:
            b[r] = 0.5 * (D[2, 1] - D[1, 2])
            b[r + 1] = 0.5 * (D[0, 2] - D[2, 0])
            b[r + 2] = 0.5 * (D[1, 0] - D[0, 1])
        # translation: the last column of D
        for i in range(m - 1):
            b[r + dim - m + 1 + i] = D[i, m - 1]


@kernel
def place_poses(chain, positions, screws, errors, workspace):
    """Carry the joint screws to many poses, and compute how far the loops are open there.

    Args:
        chain: in; arrays of the chain, as `Chain.walked`.
        positions: in; joint positions (poses, n), chain units.
        screws: out; joint screws at each pose (poses, n, 6 or 3).
        errors: out; closure residual of loops and mimic relations (poses,).
        workspace: displacements of the links (n, 4, 4) or (n, 3, 3), four more of them, and
            the closure residual (rows,).
    """
    parent, first, ends, mimics, _, _, _ = chain
    H, displacements, b = workspace
    dim = first.shape[1]
    for k in range(positions.shape[0]):
        place_links(parent, first, positions[k], H, screws[k], displacements[0])
        fill_closure_residual(H, ends, H[:0], b, dim, displacements)
        square = 0.0
        for i in range(ends.shape[0] * dim):
            square += b[i] * b[i]
        for relation in range(mimics.shape[0]):
            total = 0.0
            for j in range(parent.size):
                total += mimics[relation, j] * positions[k, j]
            square += total * total
        errors[k] = np.sqrt(square)


@kernel(inline=True, reference_counting=False)
def _negate_by_envelope(b, dim, loops, envelope, out):
    """Sort the rows of ``-b`` into those of the envelope of the loop matrix.

    Args:
        b: in; rows of loops, then of relations.
        dim: components of a twist, 6 or 3.
        loops: how many there are.
        envelope: in; the table of `kinematics.numerics.linalg.skyline_qr`.
        out: out; ``-b`` by rows of the envelope.
    """
    for i in range(b.size):
        # Blocks of loops have dim rows, those of relations have one.
        block = i // dim if i < loops * dim else i - loops * (dim - 1)
        first = block * dim if block < loops else i
        out[envelope[ROW, block] + i - first] = -b[i]


@kernel(reference_counting=False)
def solve_closure(chain, q, H, s, steps, workspace):
    """Close the loops by Newton's method on the dependent joints of q, in place.

    ``q_dependent ← q_dependent - S_0⁺ b(q)`` with the closure residual b; the independent
    joints stay.

    Args:
        chain: in; arrays of the chain, as `Chain.walked`.
        q: in, joint positions from which to start (n,); out, those of the closed pose.
        H: out; displacements of the links at the last pose looked at.
        s: out; joint screws there (n, 6 or 3).
        steps: how many at most.
        workspace: as from `newton_workspace`.

    Returns:
        The size of the closure residual at the last pose looked at; it is q unless the steps
        were used up.
    """
    parent, screws, ends, mimics, _, _, envelope = chain
    F, numbers, _, displacements = workspace
    dim, loops, nd = screws.shape[1], ends.shape[0], F.shape[0]
    rows = envelope[COUNT, ROWS]
    diagonal, b, step = numbers[:nd], numbers[nd : nd + rows], numbers[nd + rows :]
    best = error = np.inf
    for _ in range(steps):
        place_links(parent, screws, q, H, s, displacements[0])
        # H[:0]: no gaps, the loops are closed at the reference pose
        fill_closure_residual(H, ends, H[:0], b, dim, displacements)
        # errors of the mimic relations Σ_j mimics[r, j] q_j
        for relation in range(mimics.shape[0]):
            total = 0.0
            for j in range(q.size):
                total += mimics[relation, j] * q[j]
            b[loops * dim + relation] = total
        square = 0.0
        for i in range(rows):
            square += b[i] * b[i]
        error = np.sqrt(square)
        stalled = error < NEWTON_STALL_RESIDUAL and error >= 0.5 * best
        # The negated comparison also ends the loop at a NaN.
        if not error < NEWTON_DIVERGED or stalled or error < NEWTON_ROUND_OFF:
            return error
        best = min(best, error)
        fill_envelope(s, mimics, envelope, F)
        factor_envelope(F, envelope, diagonal)
        _negate_by_envelope(b, dim, loops, envelope, step)
        solve_least_norm(F, envelope, diagonal, step)
        for d in range(nd):
            q[envelope[JOINT, d]] += step[d]
    return error


@kernel(reference_counting=False)
def radius_along(C, ray, rates):
    """Estimate the radius of convergence along a ray; see `radius_of_convergence`.

    ``q̇_k = C_k δ``; the radius is ``1 / max(1, |q̇_0|, (|q̇_k| / |q̇_0|)^(1/k))``.

    Args:
        C: in; joint rates for unit rates of the coordinates (orders, n, width).
        ray: in; the direction δ (width,).
        rates: out; joint rates along the ray (orders or more, n).

    Returns:
        The radius, in steps of the ray.
    """
    limit, first = 1.0, 0.0
    for k in range(C.shape[0]):
        square = 0.0
        for j in range(C.shape[1]):
            rate = 0.0
            for w in range(ray.size):
                rate += C[k, j, w] * ray[w]
            rates[k, j] = rate
            square += rate * rate
        size = np.sqrt(square)
        first = size if k == 0 else first
        limit = max(limit, size if k == 0 else (size / first) ** (1.0 / k))
    return 1.0 / limit


@kernel(reference_counting=False)
def follow_series(chain, start, C, ray, longest, q, H, s, workspace):
    """Find a closed pose along a ray, predicted by the series; see `follow_ray`.

    The prediction is ``q - start = Σ_k q̇_k step^(k+1) / (k+1)``, by Horner's scheme.

    Args:
        chain: in; arrays of the chain, as `Chain.walked`.
        start: in; joint positions from which to start (n,).
        C: in; the series there, of one ray (orders, n, width).
        ray: in; its direction (width,).
        q: out; joint positions (n,).
        H: out; displacements of the links.
        s: out; joint screws (n, 6 or 3).
        workspace: as from `newton_workspace`, for as many orders.

    Returns:
        The length of the step, 0 if there is none.
    """
    (orders, n), rates = C.shape[:2], workspace[2]
    predicted = rates[orders]  # the line after those of the orders
    step = min(longest, RADIUS_SHARE * radius_along(C, ray, rates))
    for _ in range(MAX_HALVINGS + 1):
        for j in range(n):
            moved = 0.0
            for k in range(orders - 1, -1, -1):
                moved = (moved + rates[k, j] / (k + 1)) * step
            predicted[j] = moved
            q[j] = start[j] + moved
        error = solve_closure(chain, q, H, s, MAX_NEWTON_STEPS, workspace)
        off = size = 0.0
        for j in range(n):
            off += (q[j] - start[j] - predicted[j]) ** 2
            size += predicted[j] * predicted[j]
        if error < FOLLOWED_POSE_RESIDUAL and off <= BRANCH_DISTANCE_SQUARED * size:
            return step
        step *= 0.5
    return 0.0


def newton_workspace(chain: Chain, orders: int = 0) -> tuple[Array, ...]:
    """Make the workspace of Newton's method, and of a prediction by a series.

    Args:
        chain: the linkage as arrays.
        orders: how many orders the series has at most.

    Returns:
        The loop matrix in its envelope (dependent joints, height); its diagonal, the closure
        residual and the step; joint rates by order and the prediction (orders + 1, n); four
        displacements.
    """
    height, rows = chain.envelope[COUNT, HEIGHT : ROWS + 1].tolist()
    nd, n = chain.dependent.size, chain.parent.size
    m = 3 if chain.planar else 4
    numbers = np.empty(nd + 2 * rows)
    return np.empty((nd, height)), numbers, np.empty((orders + 1, n)), np.empty((4, m, m))
