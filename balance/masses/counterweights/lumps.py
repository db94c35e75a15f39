"""Lumps: few point masses inside a region with a given pseudo-inertia.

In a ball or ellipsoid at most four are enough: of the products ``p pᵀ`` of a matrix
``ΔP ⪰ 0`` with ``tr(G ΔP) ≥ 0``, two with ``pᵀ G p`` on different sides of the mean are turned
in their plane until one has the mean, which is not negative (J. F. Sturm, S. Zhang,
Mathematics of Operations Research 28(2), 2003). So it is in other regions for matrices of low
rank whose lumps are inside. Otherwise lumps are found one by one: each is where a linear
functional of the error is least, and all masses are fitted again.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import homogeneous
from balance.masses.counterweights.quadratic_minimum import minimise_in_region
from balance.masses.counterweights.regions import Region
from balance.support.clarabel_adapter import TRIANGLES, triangles
from balance.support.tolerances import (
    FIXED_RANK_RELATIVE,
    INSIDE_REGION,
    LUMP_FIT,
    LUMP_MASS_ZERO,
    LUMP_ON_SURFACE,
    LUMP_RESIDUAL,
    LUMP_SPREAD,
    LUMPS_ALIKE,
)
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest, first_least

# Most lumps that are tried one after the other.
MOST_TRIALS = 60
# Most steps that refine all lumps.
MOST_STEPS = 30
# Most of them that do not halve the error.
MOST_STALLS = 3


class Lumps(NamedTuple):
    """Point masses in the unit coordinates of a region.

    Attributes:
        masses: masses (n,).
        points: positions (n, 3).
    """

    masses: Array
    points: Array

    @property
    def moments(self) -> Array:
        """Their pseudo-inertia (4, 4)."""
        p = homogeneous(self.points)
        return np.asarray((self.masses * p.T) @ p)


def lumps_of(region: Region, P: Array, force: bool, least: float = 0.0) -> Lumps:
    """Find lumps inside a region with a pseudo-inertia.

    Args:
        P: pseudo-inertia (4, 4) of a measure in the region, in unit coordinates.
        force: whether only mass and first moments count: one lump is then enough.
        least: mass up to which there is no lump.

    Returns:
        At most four lumps in a ball or ellipsoid, at most ten in other regions.
    """
    mass = float(P[3, 3])
    if not mass > least:
        return Lumps(np.empty(0), np.empty((0, 3)))
    centre = P[:3, 3] / mass
    spread = float(np.trace(P[:3, :3])) / mass - float(centre @ centre)
    if force or spread <= LUMP_SPREAD:
        return Lumps(np.array([mass]), _inside(region, centre[None]))
    products = _products(P)
    # Lumps of a matrix of low rank lie in a plane or on a line, which a fit leaves.
    low = products.masses.size < len(P)
    if region.ellipsoidal or (low and region.excess(products.points).max() <= INSIDE_REGION):
        return Lumps(products.masses, _inside(region, products.points))
    return _fitted(region, P)


def refine_lumps(
    regions: Sequence[Region], rows: Array, target: Array, lumps: Sequence[Lumps]
) -> list[Lumps]:
    """Move lumps slightly so that they fulfil the conditions to round-off.

    Each step is the least change of masses and positions to first order, along the surface
    for lumps that are on it. Lumps stay in their regions, and masses stay positive.

    Args:
        regions: region of each link.
        rows: conditions (links, ρ, 10) on the coordinates `triangles` of each ΔP.
        target: their values (ρ,).
        lumps: lumps of each link.
    """
    owner = np.repeat(np.arange(len(lumps)), [cluster.masses.size for cluster in lumps])
    if not owner.size:
        return list(lumps)
    kinds, conditions = [regions[int(k)] for k in owner], rows[owner]
    trial = Lumps(*(np.concatenate(part) for part in zip(*lumps, strict=True)))
    best, least, stalls = trial, np.inf, 0
    for _ in range(MOST_STEPS):
        p = homogeneous(trial.points)
        values = trial.masses[:, None] * _values(conditions, p[:, :, None] * p[:, None, :])
        error = target - values.sum(axis=0)
        size = float(np.linalg.norm(error))
        stalls += size > 0.5 * least
        if size < least:
            best, least = trial, size
        terms = float(np.linalg.norm(target)) + float(np.linalg.norm(values, axis=1).sum())
        if stalls > MOST_STALLS or size <= LUMP_RESIDUAL * terms:
            break
        along = _along(kinds, trial.points)
        slopes = trial.masses[:, None, None] * (along @ _slopes(conditions, p))
        J = np.concatenate([values[:, None], slopes], axis=1).reshape(-1, target.size).T
        step = np.linalg.lstsq(J, error, rcond=FIXED_RANK_RELATIVE)[0]
        trial = _moved(kinds, trial, step.reshape(-1, 4), along)
    ends = np.cumsum([cluster.masses.size for cluster in lumps])[:-1]
    return list(map(Lumps, np.split(best.masses, ends), np.split(best.points, ends)))


def fewer_lumps(rows: Array, costs: Array, lumps: Sequence[Lumps]) -> list[Lumps]:
    """Leave out lumps that the conditions do not need, without a higher cost.

    Masses move along null vectors of the conditions, in the direction that does not raise the
    cost, until one of them is zero. At most as many lumps are left as there are conditions
    (C. Carathéodory, 1911). Of lumps that replace each other at the same cost, such as those of
    two rods that do not turn against each other, the first is kept.

    Args:
        rows: conditions (links, ρ, 10) on the coordinates `triangles` of each ΔP.
        costs: cost of each ΔP, likewise (links, 10).
        lumps: lumps of each link that fulfil the conditions.
    """
    owner = np.repeat(np.arange(len(lumps)), [cluster.masses.size for cluster in lumps])
    if not owner.size:
        return list(lumps)
    points = np.concatenate([cluster.points for cluster in lumps])
    masses, p = np.concatenate([cluster.masses for cluster in lumps]), homogeneous(points)
    products = triangles(p[:, :, None] * p[:, None, :])
    A = np.einsum("nrj,nj->rn", rows[owner], products)
    prices = np.einsum("nj,nj->n", costs[owner], products)
    while True:
        kept = np.flatnonzero(masses)
        change = _first_exchange(A[:, kept])
        if change is None:
            break
        terms = prices[kept] * change
        change *= -1.0 if terms.sum() > LUMPS_ALIKE * np.abs(terms).sum() else 1.0
        falling = change < 0.0
        if not falling.any():
            break
        step = np.full(kept.size, np.inf)
        step[falling] = -masses[kept][falling] / change[falling]
        first = first_least(step)
        masses[kept] = np.maximum(masses[kept] + step[first] * change, 0.0)
        masses[kept[first]] = 0.0
    masks = [(owner == k) & (masses > 0.0) for k in range(len(lumps))]
    return [Lumps(masses[mask], points[mask]) for mask in masks]


def _first_exchange(columns: Array) -> Array | None:
    """Compute the null vector (n,) that takes the first column which those before it replace.

    Args:
        columns: the conditions of unit masses (ρ, n).

    Returns:
        It, with an entry of -1 for that column and none behind it; None if all columns are
        independent, to the accuracy of the lumps.
    """
    sizes = np.linalg.norm(columns, axis=0)
    for k in range(columns.shape[1]):
        weights = np.linalg.lstsq(columns[:, :k], columns[:, k], rcond=LUMPS_ALIKE)[0]
        rest = columns[:, k] - columns[:, :k] @ weights
        if float(np.linalg.norm(rest)) <= LUMPS_ALIKE * sizes[k]:
            return np.concatenate([weights, [-1.0], np.zeros(columns.shape[1] - k - 1)])
    return None


def _values(conditions: Array, P: Array) -> Array:
    """Compute the conditions (n, ρ, 10) of pseudo-inertias (n, 4, 4): values (n, ρ)."""
    return np.asarray((conditions @ triangles(P)[:, :, None])[:, :, 0])


def _slopes(conditions: Array, p: Array) -> Array:
    """Compute derivatives (n, 3, ρ) of the conditions in moves of unit masses at p (n, 4)."""
    turn = np.zeros((len(p), 3, 4, 4))
    turn[:, range(3), range(3)] = p[:, None]
    return np.asarray(triangles(turn + turn.mT) @ conditions.mT)


def _along(kinds: Sequence[Region], points: Array) -> Array:
    """Compute projections (n, 3, 3) onto the moves along the surfaces that points are on.

    Args:
        kinds: region of each point.
        points: points (n, 3) in unit coordinates.
    """
    projections = np.tile(np.eye(3), (len(points), 1, 1))
    for P, region, u in zip(projections, kinds, points, strict=True):
        normals = region.outward(u, LUMP_ON_SURFACE)
        if len(normals) == 1:
            P -= np.outer(normals[0], normals[0])
        elif len(normals):
            V = np.linalg.svd(normals, full_matrices=True)[2]
            free = V[np.linalg.matrix_rank(normals, tol=INSIDE_REGION) :]
            P[:] = free.T @ free
    return projections


def _moved(kinds: Sequence[Region], lumps: Lumps, step: Array, along: Array) -> Lumps:
    """Change masses, relative to them, and positions by a step (n, 4)."""
    masses = lumps.masses * np.maximum(0.5, 1.0 + step[:, 0])
    moves = (step[:, None, 1:] @ along)[:, 0]
    sizes = np.linalg.norm(moves, axis=1, keepdims=True)
    points = lumps.points + moves * (0.5 / np.maximum(sizes, 0.5))
    gauges = [region.gauge(u) for region, u in zip(kinds, points, strict=True)]
    return Lumps(masses, points / np.maximum(gauges, 1.0)[:, None])


def _inside(region: Region, points: Array) -> Array:
    """Move points (n, 3) that are outside towards the centre, onto the surface."""
    gauge = np.maximum(region.gauge(points), 1.0)
    return np.asarray(points / gauge[:, None])


def _products(P: Array) -> Lumps:
    """Split a matrix into products ``p pᵀ``, of points in the unit ball if it is of a ball."""
    w, V = np.linalg.eigh(P)
    kept = w > LUMP_MASS_ZERO * w[-1]
    pending = list((V[:, kept] * np.sqrt(w[kept])).T)
    G = np.diag([-1.0, -1.0, -1.0, 1.0])
    mean = sum(float(p @ G @ p) for p in pending) / len(pending)
    done: list[Array] = []
    while len(pending) > 1:
        squares = [float(p @ G @ p) for p in pending]
        size = max(map(abs, squares))
        low, high = first_least(squares, size), first_largest(squares, size)
        if low == high or squares[high] - squares[low] <= 0.0:
            break
        p, q = pending[low], pending[high]
        # (q·Gq - mean) t² + 2 (p·Gq) t + (p·Gp - mean) = 0
        roots = np.roots([squares[high] - mean, 2.0 * float(p @ G @ q), squares[low] - mean])
        t = float(roots.real[0]) if roots.size else 0.0
        size = np.hypot(1.0, t)
        done.append((p + t * q) / size)
        pending = [x for k, x in enumerate(pending) if k not in (low, high)] + [
            (q - t * p) / size
        ]
    vectors = np.array(done + pending)
    vectors = vectors[vectors[:, 3] ** 2 > LUMP_MASS_ZERO * P[3, 3]]
    return Lumps(vectors[:, 3] ** 2, vectors[:, :3] / vectors[:, 3:])


def _fitted(region: Region, P: Array) -> Lumps:
    """Fit lumps one by one to a pseudo-inertia."""
    from scipy.optimize import nnls

    wanted = triangles(P) / P[3, 3]
    points = _inside(region, np.vstack([P[:3, 3] / P[3, 3], region.vertices]))
    masses = np.ones(len(points))
    for _ in range(MOST_TRIALS):
        p = homogeneous(points)
        columns = triangles(p[:, :, None] * p[:, None, :]).T
        masses, error = nnls(columns, wanted)
        residual = wanted - columns @ masses
        points, masses = points[masses > 0.0], masses[masses > 0.0]
        value, at = minimise_in_region(region, -(TRIANGLES[4] @ residual).reshape(4, 4))
        if error <= LUMP_FIT or value >= -LUMP_FIT:
            break
        points = np.vstack([points, at])
    rough = Lumps(masses * float(P[3, 3]), points[: len(masses)])
    return refine_lumps([region], np.eye(10)[None], triangles(P), [rough])[0]
