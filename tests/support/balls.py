"""Where the masses of a design are to be, written out once more, from the second reading."""

from __future__ import annotations

from itertools import combinations

import numpy as np

from balance.masses.designs.mass_regions import Ball


def smallest_ball(points):
    """Centre and radius of the smallest ball through some points that holds all of them."""
    best = None
    for count in range(1, points.shape[1] + 2):
        for chosen in combinations(points, count):
            c = _equidistant(np.array(chosen))
            radius = np.linalg.norm(points - c, axis=1).max()
            if best is None or radius < best[1] * (1.0 - 1e-12):
                best = c, radius
    return best


def _equidistant(points):
    """The mean of points, with weights that add up to 1, that is as far from all of them.

    ``2 x_j · Σ w_i x_i + β = |x_j|²`` for every j, from an origin among them.
    """
    origin, count = points.mean(axis=0), len(points)
    x = points - origin
    A = np.block([[2.0 * x @ x.T, np.ones((count, 1))], [np.ones(count), 0.0]])
    w = np.linalg.lstsq(A, np.append(np.sum(x * x, axis=1), 1.0), rcond=1e-12)[0][:-1]
    return origin + w @ x


def still(space):
    """The projection (3, 3) on what limits count: the plane of a planar space, or all."""
    n = space.chain.frame.R[2]
    return np.eye(3) - space.planar * np.outer(n, n)


def places(mechanism, name):
    """The joint that carries a body, its other joints, loops, and centre of mass (n, 3)."""
    b = mechanism.bodies.index(name)
    link, z = mechanism.links[b], mechanism.inertias[b]
    found = [mechanism.points[link]]
    found += [mechanism.points[j] for j, p in enumerate(mechanism.parents) if p == link]
    found += [cut.point for cut in mechanism.cuts if link in (cut.first, cut.second)]
    return np.array([*found, z[1:4] / z[0]] if z[0] > 0.0 else found)


def ball(found, within, characteristic):
    """Centre and radius of the ball of a body with these places."""
    length = np.linalg.norm(found - found[0], axis=1).max()
    centre, _ = smallest_ball(found)
    return centre, within * (length if length > 1e-3 * characteristic else characteristic)


def inside(centre, radius, projection):
    """``∫ (r² - |x - c|²) dm`` of places x and c in a projection Π, per parameter (10,).

    The second moments are ``½ tr(E) 1 - E``, so that ``∫ |Π x|² dm`` is
    ``<½ tr(Π) 1 - Π, E>``.
    """
    c = projection @ centre
    value = np.zeros(10)
    value[0], value[1:4] = radius**2 - c @ c, 2.0 * c
    N = 0.5 * np.trace(projection) * np.eye(3) - projection
    value[4:] = [-N[0, 0], -N[1, 1], -N[2, 2], -2 * N[0, 1], -2 * N[0, 2], -2 * N[1, 2]]
    return value


def point_masses_of(P, G):
    """Masses and places of point masses with a pseudo-inertia, all of them in a ball.

    What weighs less than 1e-9 of the whole is left out: its place would be round-off.

    ``P = Σ p pᵀ`` has any number of forms; two vectors of which ``pᵀ G p`` is below and above
    the mean turn into two of which one has it (Sturm and Zhang, 2003).
    """
    values, V = np.linalg.eigh(P)
    p = [np.sqrt(s) * v for s, v in zip(values, V.T, strict=True) if s > 1e-9 * values[-1]]
    mean, done = sum(v @ G @ v for v in p) / len(p), []
    while len(p) > 1:
        p.sort(key=lambda v: v @ G @ v)
        a, b = p[0], p[-1]
        # (a + t b)ᵀ G (a + t b) = mean (1 + t²)
        root = np.roots([b @ G @ b - mean, 2.0 * a @ G @ b, a @ G @ a - mean])
        t = float(root.real.max()) if root.size else 0.0
        done.append((a + t * b) / np.hypot(1.0, t))
        p = [*p[1:-1], (b - t * a) / np.hypot(1.0, t)]
    vectors = np.array([*done, *p])
    vectors = vectors[np.sum(vectors**2, axis=1) > 1e-9 * np.trace(P)]
    return vectors[:, -1] ** 2, vectors[:, :-1] / vectors[:, -1:]


def random_ball(rng, d):
    """Any ball."""
    return Ball(rng.uniform(-1.0, 1.0, d), float(rng.uniform(0.3, 2.0)))


def cloud(rng, ball, count, size=1.0):
    """Point masses in a ball, or in one of ``size`` times its radius (count, d)."""
    away = rng.standard_normal((count, ball.centre.size))
    away *= size * ball.radius * rng.random((count, 1)) / np.linalg.norm(away, axis=1)[:, None]
    return rng.random(count), ball.centre + away


def moments(masses, points):
    """``Σ m [x; 1][x; 1]ᵀ``."""
    p = np.column_stack([points, np.ones(len(points))])
    return (masses[:, None] * p).T @ p
