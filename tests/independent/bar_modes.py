"""Closed poses of planar bars next to a flat one, by their own Newton method on points.

Pins of a linkage of bars are points of the plane, and bars are distances between them. Poses
come from random starts next to the flat one; the freedoms at each are the null space of the
matrix of distances. Nothing is shared with the product: neither screws nor joint angles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np


def bars_of(pins: Sequence[tuple[str, str, str, float]]) -> tuple[list[float], list[list[int]]]:
    """Places of the points on the line, and the points of each link; the ground first.

    Pins at one place that the same link joins are one point.
    """
    points: list[tuple[float, set[str]]] = []
    for _, one, other, x in pins:
        known = next((p for p in points if p[0] == x and p[1] & {one, other}), None)
        if known is None:
            points.append((x, {one, other}))
        else:
            known[1].update((one, other))
    links = dict.fromkeys(["g", *(name for pin in pins for name in pin[1:3])])
    members = [[k for k, p in enumerate(points) if name in p[1]] for name in links]
    return [x for x, _ in points], members


def _equations(z, x, members):
    """Errors of squared distances within links, and of the ground; and their derivatives."""
    errors, rows = [], []
    for k in members[0]:
        for axis, goal in enumerate((x[k], 0.0)):
            row = np.zeros((len(x), 2))
            row[k, axis] = 1.0
            errors.append(z[k, axis] - goal)
            rows.append(row.ravel())
    for member in members[1:]:
        for i, j in combinations(member, 2):
            row = np.zeros((len(x), 2))
            row[i], row[j] = 2 * (z[i] - z[j]), 2 * (z[j] - z[i])
            errors.append((z[i] - z[j]) @ (z[i] - z[j]) - (x[i] - x[j]) ** 2)
            rows.append(row.ravel())
        for i, j, k in combinations(member, 3):  # three points of a bar stay on a line
            row = np.zeros((len(x), 2))
            turned = np.array([[0.0, 1.0], [-1.0, 0.0]])
            u, v = z[j] - z[i], z[k] - z[i]
            errors.append(u[0] * v[1] - u[1] * v[0])
            row[j], row[k] = turned @ v, -turned @ u
            row[i] = -row[j] - row[k]
            rows.append(row.ravel())
    return np.array(errors), np.array(rows)


def freedoms(points: np.ndarray, x: Sequence[float], members: Sequence[Sequence[int]]) -> int:
    """Dimension of the null space of the distances at points (k, 2) that are not flat."""
    values = np.linalg.svd(_equations(points, x, members)[1], compute_uv=False)
    return 2 * len(x) - int(np.sum(values > 1e-6 * values[0]))


def poses_near(
    x: Sequence[float], members: Sequence[Sequence[int]], distance: float, count: int, seed: int
) -> Mapping[int, list[np.ndarray]]:
    """Closed poses (points, 2) next to the flat one, by the number of their freedoms."""
    rng, found = np.random.default_rng(seed), {}
    flat = np.column_stack([x, np.zeros(len(x))])
    for _ in range(count):
        z = flat + distance * rng.standard_normal(flat.shape) * [0.1, 1.0]
        for _ in range(200):
            errors, rows = _equations(z, x, members)
            if np.abs(errors).max() < 1e-15:
                break
            z = z - np.linalg.lstsq(rows, errors, rcond=1e-9)[0].reshape(z.shape)
        off = np.abs(z - flat).max()
        if np.abs(errors).max() < 1e-13 and 0.05 * distance < off < 10 * distance:
            found.setdefault(freedoms(z, x, members), []).append(z)
    return found
