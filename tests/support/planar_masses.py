"""Planar masses of linkages, and their momentum at finite poses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from balance.momentum import momentum_regressor
from kinematics.errors import PoseError


def in_plane(z):
    """The planar parameters of (bodies, 10)."""
    return np.asarray(z)[:, [0, 1, 2, 6]]


def with_masses(linkage, z):
    """The linkage with other parameters (bodies, 10)."""
    bodies = [replace(body, inertia=p) for body, p in zip(linkage.bodies, z, strict=True)]
    return replace(linkage, bodies=tuple(bodies))


def momentum(linkage, z, seed=1, count=4):
    """Momenta of planar parameters at random finite poses, and the size of their parts."""
    rng, rows = np.random.default_rng(seed), []
    for _ in range(count):
        u = rng.uniform(-0.15, 0.15, linkage.mobility)
        rows.append(regressor_near(linkage, u).reshape(-1, z.size))
    X = np.concatenate(rows)
    return X @ z.ravel(), np.abs(X * z.ravel()).sum(axis=1).max()


def regressor_near(linkage, u):
    """The regressor at a pose, or on the way there if its loops do not close."""
    try:
        return momentum_regressor(linkage, u)
    except PoseError:
        return regressor_near(linkage, u / 2)
