"""A second, independent route to every figure: finite poses instead of derivatives.

Nothing here comes from the packages under test, so that a shared error cannot hide. Links
move by products of matrix exponentials, loops close by Newton's method on the coincidence
of points and axes, and the momentum is that of point masses. The rank by order comes from
Cauchy's integral formula: the same finite poses, at complex inputs on a small circle.

Conventions: a twist is a 4 × 4 matrix ``[[ω^, v], [0, 0]]`` in the inertial frame; link
``i`` is carried by joint ``i`` of the tree, and -1 is the ground; momentum rows are
``[ξx, ξy, ξz, px, py, pz]``; inertial parameters are
``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the origin. SI units.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
from scipy.linalg import expm, null_space

from tests.independent.reference_model import (
    GROUND,
    Array,
    Cut,
    Mechanism,
    point_mass,
)
from tests.independent.reference_model import load as load

RELATIVE_TOLERANCE = 1e-11


# A function of mechanism, positions, rates, balance and spatial.
Rows = Callable[..., Array]


class Decision(NamedTuple):
    """A rank with the singular values on both sides of the gap, relative to the largest."""

    rank: int
    kept: float
    dropped: float


def displacements(mechanism: Mechanism, q: Array) -> tuple[Array, Array]:
    """Displacements of all links, and the twist of each joint where it has moved to.

    Args:
        mechanism: the linkage, n joints.
        q: joint positions, real or complex; shape (n,).

    Returns:
        ``H`` of every link, the ground last so that ``H[GROUND]`` is it; and the twists,
        shapes (n + 1, 4, 4) and (n, 4, 4).
    """
    steps = expm(mechanism.twists * q[:, None, None])
    placed = np.empty((len(q) + 1, 4, 4), steps.dtype)
    placed[GROUND] = np.eye(4)
    for i, parent in enumerate(mechanism.parents):
        placed[i] = placed[parent] @ steps[i]
    before = placed[list(mechanism.parents)]
    return placed, before @ mechanism.twists @ np.linalg.inv(before)


def carriers(mechanism: Mechanism, links: Sequence[int]) -> Array:
    """Whether each joint is between the ground and each of some links; shape (links, n)."""
    found = np.zeros((len(mechanism.parents) + 1, len(mechanism.parents)), bool)
    for i, parent in enumerate(mechanism.parents):
        found[i] = found[parent]
        found[i, i] = True
    return found[list(links)]


def closure(mechanism: Mechanism, q: Array) -> tuple[Array, Array]:
    """Residual of cuts and mimics, and its derivative by q; shapes (rows,) and (rows, n)."""
    placed, moved = displacements(mechanism, q)
    hinges = [cut for cut in mechanism.cuts if cut.axis is not None]
    points = [[*cut.point, 1] for cut in mechanism.cuts]
    ends, rates = carried(mechanism, placed, moved, mechanism.cuts, points)
    gap, slope = ends[0] - ends[1], rates[0] - rates[1]
    ends, rates = carried(mechanism, placed, moved, hinges, [[*cut.axis, 0] for cut in hinges])
    turn = cross(ends[0], ends[1])
    slip = cross(rates[0], ends[1][:, None]) + cross(ends[0][:, None], rates[1])
    slopes = [x.swapaxes(1, 2).reshape(-1, len(q)) for x in (slope, slip)]
    rows = mechanism.relations
    return np.concatenate([gap.ravel(), turn.ravel(), rows @ q]), np.concatenate(
        [*slopes, rows.astype(slope.dtype)]
    )


def cross(a: Array, b: Array) -> Array:
    """``a × b``, row by row: NumPy's own takes most of the time of a small linkage."""
    x, y = [1, 2, 0], [2, 0, 1]
    return a[..., x] * b[..., y] - a[..., y] * b[..., x]


def carried(
    mechanism: Mechanism, placed: Array, moved: Array, cuts: Sequence[Cut], vectors: Sequence
) -> tuple[list[Array], list[Array]]:
    """A point or an axis of each cut as each of its links carries it, and its rates.

    Vectors are homogeneous; two arrays (cuts, 3) and two (cuts, n, 3).
    """
    x = np.array(vectors).reshape(-1, 4, 1)
    ends, rates = [], []
    for links in ([cut.first for cut in cuts], [cut.second for cut in cuts]):
        end = placed[links] @ x
        rate = (moved @ end[:, None])[..., :3, 0] * carriers(mechanism, links)[..., None]
        ends.append(end[:, :3, 0])
        rates.append(rate)
    return ends, rates


def velocities(mechanism: Mechanism, q: Array, basis: Array) -> Array:
    """Joint rates when the inputs move with the columns of ``basis``; shape (n, nw)."""
    inputs, others = split(mechanism)
    slope = closure(mechanism, q)[1]
    rates = np.zeros((len(q), basis.shape[1]), slope.dtype)
    rates[inputs] = basis
    rates[others] = np.linalg.lstsq(slope[:, others], -slope[:, inputs] @ basis, rcond=None)[0]
    return rates


def split(mechanism: Mechanism) -> tuple[list[int], list[int]]:
    """The joints that are inputs, and the others."""
    inputs = list(mechanism.inputs)
    return inputs, [i for i in range(len(mechanism.joints)) if i not in inputs]


def follow(mechanism: Mechanism, q: Array, goal: Array) -> Array:
    """Carry the pose ``q`` to the inputs ``goal`` without leaving its assembly branch.

    A step is taken along the velocity and then corrected. If the correction is not small
    against the step, the pose may have jumped to another branch: the step is halved.

    Raises:
        ValueError: no step is short enough, as at a singular pose.
    """
    inputs, others = split(mechanism)
    share = 1.0
    while np.abs(remaining := goal - q[inputs]).max() > 1e-14:
        change = velocities(mechanism, q, share * remaining[:, None])[:, 0]
        guess = q + change
        moved = guess.copy()
        for _ in range(12):
            residual, slope = closure(mechanism, moved)
            fix = np.linalg.lstsq(slope[:, others], -residual, rcond=None)[0]
            moved[others] += fix
            if np.linalg.norm(fix) < 1e-14:
                break
        if np.linalg.norm(moved - guess) <= 0.1 * np.linalg.norm(change):
            q, share = moved, min(1.0, 2 * share)
        elif (share := share / 2) < 1e-4:
            raise ValueError(f"{mechanism.name}: cannot follow the branch to {goal}")
    return q


# Ten masses whose parameters span all inertial parameters of a rigid body.
CLOUD = np.array(
    [[0, 0, 0], *np.eye(3), *-np.eye(3), *(1 - np.eye(3))],
)
FROM_CLOUD = np.linalg.inv(np.array([point_mass(position) for position in CLOUD]).T)


def regressor(
    mechanism: Mechanism, q: Array, rates: Array, balance: str = "dynamic", spatial: bool = True
) -> Array:
    """Momentum per inertial parameter, ``Σ x × v`` and ``Σ v`` over unit point masses.

    Args:
        mechanism: the linkage, nb bodies.
        q: joint positions; shape (n,).
        rates: joint rates, one motion per column; shape (n, nw).
        balance: ``"dynamic"``, or ``"force"`` for the linear momentum alone.
        spatial: False keeps ``[ξz, px, py]`` and ``[m, mcx, mcy, Ezz]``.

    Returns:
        Shape (nw · rows, nb · parameters): motions below each other, bodies side by side.
        Force balance has neither ``ξ`` nor ``E``.
    """
    placed, moved = displacements(mechanism, q)
    rows, columns = selection(balance, spatial)
    links = list(mechanism.links)
    cloud = np.column_stack([CLOUD, np.ones(10)]) @ placed[links].swapaxes(1, 2)
    path = carriers(mechanism, links)
    twists = np.einsum("bj,jw,jac->wbac", path, rates, moved, optimize=True)
    speed = (cloud @ twists.swapaxes(2, 3))[..., :3]
    moment = np.cross(cloud[..., :3], speed)
    full = np.concatenate([moment, speed], axis=3).swapaxes(2, 3) @ FROM_CLOUD
    full = full[:, :, rows][..., columns].swapaxes(1, 2)
    return full.reshape(rates.shape[1] * len(rows), len(links) * len(columns))


def decoupling_rows(
    mechanism: Mechanism, q: Array, rates: Array, balance: str = "dynamic", spatial: bool = True
) -> Array:
    """The regressor, and below it the change of the inertia on the base since the pose 0.

    That of a body is linear in its parameters, those of a cloud of points that it carries.
    """
    _, columns = selection(balance, spatial)
    change = carried_parameters(mechanism, q) - carried_parameters(mechanism, 0 * q)
    change = change[:, columns][..., columns].swapaxes(0, 1).reshape(len(columns), -1)
    return np.vstack([regressor(mechanism, q, rates, balance, spatial), change])


def carried_parameters(mechanism: Mechanism, q: Array) -> Array:
    """Parameters that each body has where it is carried, by parameter; shape (nb, 10, 10)."""
    placed = displacements(mechanism, q)[0][list(mechanism.links)]
    cloud = np.column_stack([CLOUD, np.ones(10)]) @ placed.swapaxes(1, 2)
    x, y, z = np.moveaxis(cloud[..., :3], 2, 0)
    moments = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z]
    return np.stack([np.ones_like(x), x, y, z, *moments], axis=1) @ FROM_CLOUD


def selection(balance: str, spatial: bool) -> tuple[list[int], list[int]]:
    """Rows of the momentum and columns of the parameters that a question keeps."""
    rows = [0, 1, 2, 3, 4, 5] if spatial else [2, 3, 4]
    columns = list(range(10)) if spatial else [0, 1, 2, 6]
    if balance == "force":
        return [row for row in rows if row > 2], [column for column in columns if column < 4]
    return rows, columns


def motion_basis(mechanism: Mechanism, relations: Sequence[str] = ()) -> Array:
    """Orthonormal basis of the input rates that obey relations like ``"u2=u3"``.

    Each side is a Python expression of the inputs, whose values are unit vectors.
    """
    names = [mechanism.joints[i] for i in mechanism.inputs]
    units = dict(zip(names, np.eye(len(names)), strict=True))
    sides = [[eval(side, {}, units) for side in text.split("=")] for text in relations]
    conditions = np.array([left - right for left, right in sides])
    return null_space(conditions) if relations else np.eye(len(names))


def decide(matrix: Array) -> Decision:
    """Rank by singular values above ``RELATIVE_TOLERANCE`` of the largest."""
    values = np.linalg.svd(matrix, compute_uv=False)
    values = np.append(values / values[0], 0.0)
    rank = int((values > RELATIVE_TOLERANCE).sum())
    return Decision(rank, float(values[rank - 1]), float(values[rank]))


def rank_over_poses(
    mechanism: Mechanism,
    motion: Sequence[str] = (),
    balance: str = "dynamic",
    spatial: bool = True,
    poses: int = 16,
    reach: float = 0.3,
    seed: int = 1,
    rows: Rows = regressor,
) -> Decision:
    """Rank of the momentum regressors of random poses, stacked.

    Args:
        mechanism: the linkage.
        motion: relations between its inputs.
        balance: as in `regressor`.
        spatial: as in `regressor`.
        poses: how many poses to draw.
        reach: largest input, in radians, or in lengths of the scaled mechanism.
        seed: of the random poses.
        rows: what is stacked: `regressor`, or `decoupling_rows`.
    """
    mechanism = mechanism.scaled()
    basis = motion_basis(mechanism, motion)
    rng = np.random.default_rng(seed)
    start = np.zeros(len(mechanism.joints))
    stack = []
    for _ in range(poses):
        q = follow(mechanism, start, basis @ rng.uniform(-reach, reach, basis.shape[1]))
        rates = velocities(mechanism, q, basis)
        stack.append(rows(mechanism, q, rates, balance, spatial))
    return decide(np.vstack(stack))


def ranks_by_order(
    mechanism: Mechanism,
    orders: int,
    motion: Sequence[str] = (),
    balance: str = "dynamic",
    spatial: bool = True,
    rays: int = 12,
    radius: float = 0.08,
    samples: int = 32,
    seed: int = 2,
    rows: Rows = regressor,
) -> list[Decision]:
    """Rank of the derivatives of the momentum regressor up to each order.

    Along a ray ``u = δ t`` the k-th Taylor coefficient is the mean of ``X(t) t^-k`` over
    a circle ``|t| = radius`` of complex t, which is exact up to round-off and to aliasing
    with order ``k + samples``. Coefficients are left in units of ``radius^-k``.

    Args:
        mechanism: the linkage.
        orders: the last order.
        motion: relations between its inputs.
        balance: as in `regressor`.
        spatial: as in `regressor`.
        rays: random directions δ; one if the motion has a single freedom.
        radius: of the circle, in radians, or in lengths of the scaled mechanism.
        samples: points on the circle.
        seed: of the directions.
        rows: whose series it is: `regressor`, or `decoupling_rows`.

    Raises:
        ValueError: the series does not converge on the circle.
    """
    mechanism = mechanism.scaled()
    basis = motion_basis(mechanism, motion)
    rng = np.random.default_rng(seed)
    # Opposite points are conjugate: half the circle is enough.
    turns = np.exp(2j * np.pi * np.arange(samples // 2 + 1) / samples)
    coefficients = []
    for _ in range(rays if basis.shape[1] > 1 else 1):
        weights = rng.standard_normal(basis.shape[1])
        direction = basis @ weights / np.linalg.norm(weights)
        q = np.zeros(len(mechanism.joints), complex)
        circle = []
        for turn in turns:
            q = follow(mechanism, q, radius * turn * direction)
            rates = velocities(mechanism, q, basis)
            circle.append(rows(mechanism, q, rates, balance, spatial))
        series = np.fft.hfft(circle, samples, axis=0) / samples
        if np.abs(series[samples // 2 :]).max() > 1e-9 * np.abs(series).max():
            raise ValueError(f"{mechanism.name}: a circle of radius {radius} is too large")
        coefficients.append(series[: orders + 1])
    by_order = np.concatenate(coefficients, axis=1)
    return [decide(np.concatenate(list(by_order[: k + 1]))) for k in range(orders + 1)]
