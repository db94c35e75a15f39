"""Long rows of bodies as arrays: serial chains and coupled four-bars."""

from __future__ import annotations

import numpy as np

from kinematics.model.arrays import Chain, Frame, freeze


def serial(bodies: int, width: int = 1, seed: int = 0) -> Chain:
    """Make a spatial chain of revolute joints with ``width`` coordinates."""
    rng = np.random.default_rng(seed)
    axes = rng.standard_normal((bodies, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    points = np.cumsum(rng.standard_normal((bodies, 3)), axis=0) / bodies
    screws = np.concatenate([axes, np.cross(points, axes)], axis=1)
    columns = rng.standard_normal((bodies, width)) / np.sqrt(bodies)
    return _chain(np.arange(-1, bodies - 1), screws, [], [], columns, bodies)


def coupled_four_bars(count: int, seed: int = 0) -> Chain:
    """Make a row of planar four-bars, nearly parallelograms, with 2 count + 1 bodies.

    The rocker of each is the crank of the next. Joints of the tree come first, then those of
    the loops, as from a file.
    """
    rng = np.random.default_rng(seed)
    parent, points, ends, foot = [-1], [np.zeros(2)], [], np.zeros(2)
    angle = rng.uniform(0.0, 2.0 * np.pi, count)
    base = np.column_stack([np.cos(angle), np.sin(angle)])
    between = rng.uniform(0.8, 2.2, (2, count + 1))
    crank, loops = 0, []
    tips = [None] * (count + 1)
    tips[0] = _rotate(base[0], between[0, 0])
    for k in range(count):
        rocker = _rotate(base[k], between[0, k] + 0.02 * between[1, k])
        parent += [crank, -1]
        points += [foot + tips[k], foot + base[k]]
        loops.append((2 * k + 1, foot + base[k] + rocker, 2 * k + 2))
        foot, crank = foot + base[k], 2 * k + 2
        tips[k + 1] = _rotate(base[min(k + 1, count - 1)], between[0, k + 1])
    bodies = len(parent)
    for coupler, point, rocker in loops:
        ends.append((len(parent), rocker))
        parent.append(coupler)
        points.append(point)
    x, y = (np.array(points) - np.mean(points, axis=0)).T
    columns = np.zeros((len(parent), 1))
    columns[0] = 1.0
    screws = np.column_stack([np.ones(len(parent)), y, -x])
    return _chain(parent, screws, ends, range(1, len(parent)), columns, bodies)


def _rotate(vector: np.ndarray, angle: float) -> np.ndarray:
    """Rotate a vector of the plane by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]]) @ vector


def _chain(parent, screws, ends, dependent, columns, bodies) -> Chain:
    """Make a chain without frame and mimic joints, with links that may all move."""
    n, whole = len(parent), np.int64
    return Chain(
        frame=Frame(),
        joints=freeze(range(n), whole),
        units=freeze(np.ones(n)),
        parent=freeze(parent, whole),
        screws=freeze(screws),
        ends=freeze(np.reshape(ends, (-1, 2)), whole),
        mimics=freeze(np.zeros((0, n))),
        dependent=freeze(dependent, whole),
        columns=freeze(columns),
        moves=freeze(np.ones(columns.shape), np.bool_),
        links=freeze(range(bodies), whole),
    )
