"""Frames of links along common normals, from the lines of joints alone, and masses in them."""

from __future__ import annotations

import numpy as np


def normal_of(a, b):
    """Foot on the first line, direction, length and twist of the common normal.

    Lines are a point and a direction; the second one is directed so that the sine is positive.
    """
    (p, u), (q, v) = a, b
    across = np.cross(u, v)
    # p + t u and q + r v, with the normal between them: three linear equations.
    t, r, _ = np.linalg.solve(np.array([u, -v, across]).T, q - p)
    foot, end = p + t * u, q + r * v
    x = end - foot
    length = np.linalg.norm(x)
    x = x / length
    if np.cross(u, v) @ x < 0.0:
        v = -v
    return foot, end, x, length, np.arctan2(np.cross(u, v) @ x, u @ v), (q, v)


def frames_along(lines, names):
    """Frames and dimensions of the links between lines of a chain, or of a loop.

    The last link of an open chain has one line: its x-axis is any.

    Returns:
        Origin and axes (rows) of each link, and values by names of the formulas.
    """
    frames, values, before = [], {}, None
    line = lines[0]
    for k, name in enumerate(names):
        if k + 1 < len(lines):
            foot, end, x, length, twist, after = normal_of(line, lines[k + 1])
            values |= {
                f"l_{name}": length,
                f"c_{name}": np.cos(twist),
                f"s_{name}": np.sin(twist),
            }
        else:
            foot, end, after = before, None, None
            x = np.cross(line[1], [0.3, 0.5, 0.7])
            x /= np.linalg.norm(x)
        if before is not None:
            values[f"h_{k}"] = line[1] @ (foot - before)
        frames.append((foot, np.array([x, np.cross(line[1], x), line[1]])))
        line, before = after, end
    return frames, values


def masses_in(frames, space):
    """Balanced masses (parameters, nullity) in frames of bodies, by kind and then by body."""
    count = len(space.labels)
    z = space.basis.reshape(len(space.bodies), count, -1)
    firsts, seconds = [], []
    for (origin, axes), part in zip(frames, z, strict=True):
        m, mc = part[0], part[1:4]
        firsts.append(axes @ (mc - np.outer(origin, m)))
        if count == 10:
            xx, yy, zz, xy, xz, yz = part[4:]
            E = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
            # Of points: E = Σ m (r·r 1 - r rᵀ) with r = origin + axesᵀ ρ.
            o = origin[:, None]
            dot = (origin @ mc)[None, None] * np.eye(3)[:, :, None]
            outer = o[:, None] * mc[None] + mc[:, None] * o[None]
            square = (origin @ origin) * np.eye(3) - np.outer(origin, origin)
            J = E - 2 * dot + outer + square[:, :, None] * m
            J = np.einsum("ia,abn,jb->ijn", axes, J, axes)
            seconds.append([J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]])
    blocks = [np.array(firsts)[:, i] for i in range(3)]
    if seconds:
        blocks += [np.array(seconds)[:, i] for i in range(6)]
    return np.vstack([*blocks, z[:, 0]])


def size_of_violation(rows, z):
    """Largest violation of rows by masses, over the sizes of their terms."""
    rows = np.asarray(rows, float)
    sizes = (abs(rows) @ abs(z)).max(axis=1, keepdims=True)
    return float((abs(rows @ z) / np.maximum(sizes, 1e-3 * abs(z).max())).max())
