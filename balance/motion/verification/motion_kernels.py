"""All samples of a motion at once: positions and rates of all joints, and momenta of bodies.

These kernels do for a whole motion what `kinematics.closure.newton.follow_ray`,
`kinematics.closure.series.expand_from` and `balance.space.momentum.regressor` do for a pose:
thousands of calls from Python would take longer than the numbers.
"""

from __future__ import annotations

import numpy as np

from balance.space.momentum.regressor import (
    moments_workspace,
    parameters_per_body,
    rows_per_column,
)
from balance.space.momentum.regressor_kernels import spatial_regressor
from kinematics.closure.newton_kernels import (
    fill_closure_residual,
    follow_series,
    newton_workspace,
)
from kinematics.closure.series import planar_series, series_workspace, spatial_series
from kinematics.model.arrays import Chain
from kinematics.model.spatial.displacements import place_links
from kinematics.numerics.array_types import Array
from kinematics.numerics.compiled.jit import kernel

# Order of the series that predicts the next sample.
PREDICTION_ORDER = 3
# Most steps between two samples; the first sample may be far from the reference pose.
MAX_STEPS = 200


def _make_follower(dim):
    """Make the kernel for twists of ``dim`` components: 6 in space, 3 in a plane."""

    @kernel(reference_counting=False)
    def follow_samples(chain, path, limits, pose, motion, workspace):
        """Follow inputs from sample to sample, on one branch.

        Args:
            chain: in: arrays of the chain, as `Chain.walked`.
            path: in: from each sample to the next, the motion of the joints along a line of
                the inputs (N, n, 1), which links it moves (n, 1), and its length (N,);
                velocities and accelerations of the inputs (N, 1, width).
            limits: in: bound on joint rates for unit rates of the inputs, bound on the smallest
                pivot of the loop matrix, over that of the reference pose, this pivot, and the
                shortest step of the inputs (4,).
            pose: in, out: joint positions of the first sample (n,), displacements (n, 4, 4)
                or (n, 3, 3) and screws (n, dim) there; workspace (n,).
            motion: out: positions, velocities and accelerations of all joints (N, n); in, out:
                largest closure residual, the smallest pivot over that of the reference, and the
                share of the way to the next sample behind which the motion ends (3,).
            workspace: as from `motion_workspace`.

        Returns:
            The first sample beyond which the motion cannot be followed; N if there is none.
        """
        parent, screws, ends, mimics, _, _, envelope = chain
        lines, narrow, lengths, speeds, changes = path
        q, H, s, scratch_q = pose
        positions, velocities, accelerations, extremes = motion
        near, far, steps, ray, b = workspace
        C, diagonal, width = near[4][0], near[1], speeds.shape[2]
        for k in range(lengths.size):
            if dim == 3:
                planar_series(0, 1, 0, 1, chain, s, speeds[k], near)
            else:
                spatial_series(0, 1, 0, 1, chain, s, speeds[k], near)
            pivot = 1.0
            for d in range(near[0].shape[0]):  # the first numbers are the diagonal of R
                pivot = abs(diagonal[d]) if d == 0 else min(pivot, abs(diagonal[d]))
            extremes[1] = min(extremes[1], pivot / limits[2])
            if not extremes[1] >= limits[1]:
                return k
            for j in range(q.size):
                speed = change = 0.0
                for w in range(width):
                    # The negated comparison also ends the motion at a NaN.
                    if not abs(C[0, j, w]) <= limits[0]:
                        return k
                    speed += C[0, j, w] * speeds[k, 0, w]
                    change += C[0, j, w] * changes[k, 0, w] + C[1, j, w] * speeds[k, 0, w]
                positions[k, j], velocities[k, j], accelerations[k, j] = q[j], speed, change
            # H[:0]: no gaps, the loops are closed at the reference pose
            fill_closure_residual(H, ends, H[:0], b, dim, steps[3])
            square = 0.0
            for i in range(ends.shape[0] * dim):
                square += b[i] * b[i]
            for relation in range(mimics.shape[0]):
                total = 0.0
                for j in range(q.size):
                    total += mimics[relation, j] * q[j]
                square += total * total
            extremes[0] = max(extremes[0], np.sqrt(square))
            line = (parent, screws, ends, mimics, lines[k], narrow, envelope)
            remaining = lengths[k]
            for _ in range(MAX_STEPS):
                if remaining == 0.0:
                    break
                if dim == 3:
                    planar_series(0, PREDICTION_ORDER, 0, 1, line, s, ray, far)
                else:
                    spatial_series(0, PREDICTION_ORDER, 0, 1, line, s, ray, far)
                step = follow_series(
                    line, q, far[4][0], ray[0], remaining, scratch_q, H, s, steps
                )
                if step == 0.0 or (step < limits[3] and step < remaining):
                    extremes[2] = 1.0 - remaining / lengths[k]
                    return k
                for j in range(q.size):
                    q[j] = scratch_q[j]
                remaining -= step
            if remaining > 0.0:
                extremes[2] = 1.0 - remaining / lengths[k]
                return k
        return lengths.size

    return follow_samples


follow_samples, follow_planar_samples = _make_follower(6), _make_follower(3)


def motion_workspace(chain: Chain) -> tuple[object, ...]:
    """Allocate the workspace of `follow_samples`.

    Args:
        chain: the linkage as arrays. Samples are predicted along one coordinate.

    Returns:
        Workspaces of both series and of Newton's method, the ray (1, 1), and the residual of
        the loops.
    """
    # Sizes of the workspace alone follow from the column.
    narrow = chain if chain.width == 1 else chain.with_columns(chain.columns[:, :1])
    return (
        series_workspace(chain, 1, 1),
        series_workspace(narrow, 1, PREDICTION_ORDER),
        newton_workspace(chain, PREDICTION_ORDER + 1),
        np.ones((1, 1)),
        np.zeros(len(chain.ends) * chain.screws.shape[1]),
    )


def _regressors_at_by_arrays(chain, links, sample, workspace, carried):
    """Compute regressors as `_regressors_at` does: those of all bodies at once."""
    q, speed, change = sample
    series, (H, N, X, _), (pose, scratch, both) = workspace
    place_links(chain[0], chain[1], q, pose, carried, scratch)
    spatial_series(0, 1, 0, 1, chain, carried, speed, series)
    X[:] = 0.0
    spatial_regressor(0, 1, 0, 1, pose, links, chain[5], series[3], series[5], H, N, X)
    rates = X[0, 0].T @ change[0] + X[1, 0].T @ speed[0]
    both[0], both[1] = (X[0, 0].T @ speed[0]).transpose(1, 2, 0), rates.transpose(1, 2, 0)


@kernel(reference_counting=False, uncompiled=_regressors_at_by_arrays)
def _regressors_at(chain, links, sample, workspace, carried):
    """Compute the regressors of momentum and rate at one sample, in the workspace.

    Arrays are copied number by number here and below: an assignment of whole arrays compiles a
    text for the case that shapes differ, which takes as long as the rest.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        sample: in: joint positions (n,), velocities and accelerations of the inputs (1, width).
        workspace: as from `load_workspace`; its last part holds the result.
        carried: out: joint screws (n, 6).
    """
    parent, screws, _, _, _, moves, _ = chain
    q, speed, change = sample
    series, (H, N, X, _), (pose, scratch, both) = workspace
    place_links(parent, screws, q, pose, carried, scratch)
    spatial_series(0, 1, 0, 1, chain, carried, speed, series)
    X[:] = 0.0
    spatial_regressor(0, 1, 0, 1, pose, links, moves, series[3], series[5], H, N, X)
    for b in range(links.size):
        for i in range(6):
            for p in range(10):
                momentum = rate = 0.0
                for w in range(speed.shape[1]):
                    steady, changing = X[0, 0, w, i, b, p], X[1, 0, w, i, b, p]
                    momentum += speed[0, w] * steady
                    rate += change[0, w] * steady + speed[0, w] * changing
                both[0, b, i, p], both[1, b, i, p] = momentum, rate


@kernel(reference_counting=False)
def fill_load_regressors(chain, links, samples, workspace, screws, loads):
    """Compute the regressors of momentum and rate of each body, at all samples.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        samples: in: joint positions (N, n), velocities and accelerations of the inputs
            (N, 1, width).
        workspace: as from `load_workspace`.
        screws: out: joint screws (N, n, 6).
        loads: out: ``[momentum, rate]`` per unit of each parameter (2, N, bodies, 6, 10).
    """
    positions, speeds, changes = samples
    both = workspace[2][2]
    for k in range(positions.shape[0]):
        sample = positions[k], speeds[k], changes[k]
        _regressors_at(chain, links, sample, workspace, screws[k])
        for b in range(links.size):
            for i in range(6):
                for p in range(10):
                    loads[0, k, b, i, p] = both[0, b, i, p]
                    loads[1, k, b, i, p] = both[1, b, i, p]


@kernel(reference_counting=False)
def fill_loads(chain, links, z, samples, workspace, screws, loads):
    """Compute the momentum of each body and its rate, at all samples.

    Args:
        chain: in: arrays of a spatial chain, as `Chain.walked`.
        links: in: link of each body (bodies,).
        z: in: parameters of the bodies (bodies, 10), chain units.
        samples: in: see `fill_load_regressors`, as for the next two.
        workspace: as from `load_workspace`.
        screws: out: joint screws (N, n, 6).
        loads: out: ``[momentum, rate]`` (2, N, bodies, 6).
    """
    positions, speeds, changes = samples
    both = workspace[2][2]
    for k in range(positions.shape[0]):
        sample = positions[k], speeds[k], changes[k]
        _regressors_at(chain, links, sample, workspace, screws[k])
        for b in range(links.size):
            for i in range(6):
                momentum = rate = 0.0
                for p in range(10):
                    momentum += both[0, b, i, p] * z[b, p]
                    rate += both[1, b, i, p] * z[b, p]
                loads[0, k, b, i], loads[1, k, b, i] = momentum, rate


def load_workspace(chain: Chain) -> tuple[tuple[Array, ...], ...]:
    """Allocate the workspace of `fill_loads` and `fill_load_regressors`.

    Args:
        chain: the linkage as arrays of a spatial chain.

    Returns:
        The workspace of a series of order 1; that of the regressor; displacements (n, 4, 4),
        one displacement more, and both regressors (2, bodies, 6, 10).
    """
    series = series_workspace(chain, 1, 1)
    per, size = rows_per_column(False, False), parameters_per_body(False, False)
    moments = moments_workspace(series[3], chain.links, chain.moves, per, size)
    n = chain.parent.size
    places = np.empty((n, 4, 4)), np.empty((4, 4))
    return series, moments, (*places, np.zeros((2, chain.links.size, 6, 10)))
