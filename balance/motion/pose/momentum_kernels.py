"""Momentum of given masses per unit rate of the inputs, at many poses: compiled kernels.

At a closed pose, column w of the momentum matrix is ``Σ_b X_{b,w} z_b``, with the regressor X
of `balance.space.momentum.regressor`. A grid of poses is filled outwards from one cell: each
new cell is reached from a neighbour by steps along the power series of the motion, closed by
Newton's method (`kinematics.closure.newton_kernels.follow_series`), so that no branch is left.
"""

from __future__ import annotations

import numpy as np

from balance.space.momentum.regressor import (
    moments_workspace,
    parameters_per_body,
    rows_per_column,
)
from balance.space.momentum.regressor_kernels import spatial_regressor
from kinematics.closure.newton_kernels import follow_series, newton_workspace
from kinematics.closure.series import series_workspace, spatial_series
from kinematics.model.arrays import Chain
from kinematics.model.spatial.displacements import place_links
from kinematics.numerics.compiled.jit import kernel

# Order of the series that predicts the next pose.
SERIES_ORDER = 3
# Most steps from a cell to its neighbour.
MAX_CELL_STEPS = 30
# Entry of `seen` of a cell that is not, or cannot yet be, reached; in the queue or done.
UNSEEN, SEEN = 0, 1


@kernel
def _regressor(chain, links, q, workspace):
    """Compute the regressor at a closed pose, in the workspace.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        q: in: joint positions (n,), chain units.
        workspace: as from `pose_workspace`.

    Returns:
        The regressor (1, 1, width, 6, bodies, 10).
    """
    parent, screws, _, _, _, moves, _ = chain
    series, (H, N, X, _), _, (pose, carried, ray, scratch) = workspace
    place_links(parent, screws, q, pose, carried, scratch)
    spatial_series(0, 0, 0, 1, chain, carried, ray, series)
    X[:] = 0.0
    V, T = series[3][:, :1], series[5][:, :1]
    spatial_regressor(0, 0, 0, 1, pose, links, moves, V, T, H, N, X)
    return X


@kernel
def _momentum(chain, links, z, q, workspace, M, magnitudes):
    """Compute the momentum matrix at a closed pose, and the sizes that its entries cancel from.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        z: in: parameters of the bodies (bodies, 10), chain units.
        q: in: joint positions (n,), chain units.
        workspace: as from `pose_workspace`.
        M: out: ``[ξ; p]`` for unit rates (6, width), chain units.
        magnitudes: out: ``Σ_b |h_b|``, entry by entry (6, width).
    """
    X = _regressor(chain, links, q, workspace)
    for w in range(M.shape[1]):
        for i in range(6):
            total = size = 0.0
            for b in range(links.size):
                part = 0.0
                for k in range(10):
                    part += X[0, 0, w, i, b, k] * z[b, k]
                total += part
                size += abs(part)
            M[i, w], magnitudes[i, w] = total, size


@kernel
def fill_momenta(chain, links, z, q, workspace, M, magnitudes):
    """Compute the momentum matrices at closed poses.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        z: in: parameters of the bodies (bodies, 10), chain units.
        q: in: joint positions (poses, n), chain units.
        workspace: as from `pose_workspace`.
        M: out: (poses, 6, width); see `_momentum`.
        magnitudes: out: (poses, 6, width).
    """
    for k in range(q.shape[0]):
        _momentum(chain, links, z, q[k], workspace, M[k], magnitudes[k])


@kernel
def fill_body_momenta(chain, links, z, q, workspace, h):
    """Compute the momenta of single bodies at closed poses.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        z: in: parameters of the bodies (bodies, 10), chain units.
        q: in: joint positions (poses, n), chain units.
        workspace: as from `pose_workspace`.
        h: out: ``[ξ; p]`` for unit rates (poses, 6, width, bodies), chain units.
    """
    for k in range(q.shape[0]):
        X = _regressor(chain, links, q[k], workspace)
        for i in range(6):
            for w in range(h.shape[2]):
                for b in range(links.size):
                    total = 0.0
                    for j in range(10):
                        total += X[0, 0, w, i, b, j] * z[b, j]
                    h[k, i, w, b] = total


@kernel
def _walk(chain, ray, length, q, scratch_q, workspace):
    """Move a closed pose along a straight line of coordinates.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        ray: in: unit direction (width,).
        length: how far, chain units.
        q: in, out: joint positions (n,); the last pose found, if the end is not reached.
        scratch_q: workspace (n,).
        workspace: as from `pose_workspace`.

    Returns:
        Whether the end was reached.
    """
    parent, screws, _, _, columns, _, _ = chain
    series, _, steps, (pose, carried, rays, scratch) = workspace
    rays[0] = ray
    if series[0].shape[0] == 0:  # no loops: q = C u
        for j in range(q.size):
            for w in range(ray.size):
                q[j] += columns[j, w] * ray[w] * length
        return True
    place_links(parent, screws, q, pose, carried, scratch)
    remaining_length = length
    for _ in range(MAX_CELL_STEPS):
        spatial_series(0, SERIES_ORDER, 0, 1, chain, carried, rays, series)
        step = follow_series(
            chain, q, series[4][0], ray, remaining_length, scratch_q, pose, carried, steps
        )
        if step == 0.0:
            return False
        q[:] = scratch_q
        remaining_length -= step
        if remaining_length <= 0.0:
            return True
    return False


@kernel
def fill_cells(chain, links, z, grid, state, momenta, count, workspace):
    """Fill cells of a grid of poses, from those in the queue outwards.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        z: in: parameters of the bodies (bodies, 10), chain units.
        grid: in: coordinates of the cells (cells, width), chain units; number of cells along
            each axis of the grid, and from one cell to the next along it (axes,).
        state: in, out: joint positions of reached cells (cells, n); whether each is reached
            (cells,); the queue of reached cells (cells,); how many of it are done, and how
            many are in it (2,).
        momenta: out: momentum matrices and sizes of cells (cells, 6, width).
        count: most cells to take from the queue now.
        workspace: as from `pose_workspace`, then positions (2, n) and a direction (width,).
    """
    points, shape, strides = grid
    q, seen, queue, ends = state
    M, magnitudes = momenta
    places, numbers, ray = workspace
    for _ in range(count):
        if ends[0] == ends[1]:
            return
        cell = queue[ends[0]]
        ends[0] += 1
        _momentum(chain, links, z, q[cell], places, M[cell], magnitudes[cell])
        for axis in range(shape.size):
            position = (cell // strides[axis]) % shape[axis]
            for side in (-1, 1):
                if position + side < 0 or position + side >= shape[axis]:
                    continue
                other = cell + side * strides[axis]
                if seen[other] == SEEN:
                    continue
                length = 0.0
                for w in range(ray.size):
                    ray[w] = points[other, w] - points[cell, w]
                    length += ray[w] * ray[w]
                length = np.sqrt(length)
                for w in range(ray.size):
                    ray[w] /= length
                numbers[0] = q[cell]
                if _walk(chain, ray, length, numbers[0], numbers[1], places):
                    q[other] = numbers[0]
                    seen[other] = SEEN
                    queue[ends[1]] = other
                    ends[1] += 1


def pose_workspace(chain: Chain) -> tuple[tuple[object, ...], ...]:
    """Allocate the workspace for momenta at poses, and for steps between them.

    Returns:
        Workspaces of a series along one ray, of the regressor, of Newton's method; the
        displacements of the links, their screws, a direction and a displacement.
    """
    n, bodies = chain.parent.size, chain.links.size
    series = series_workspace(chain, 1, SERIES_ORDER)
    per, size = rows_per_column(False, False), parameters_per_body(False, False)
    moments = moments_workspace(series[3][:, :1], chain.links, chain.moves, per, size)
    places = np.empty((n, 4, 4)), np.empty((n, 6)), np.zeros((1, chain.width)), np.empty((4, 4))
    assert moments[2].shape == (1, 1, chain.width, per, bodies, size)
    return series, moments, newton_workspace(chain, SERIES_ORDER + 1), places
