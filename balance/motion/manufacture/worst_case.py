"""The largest norm of an affine function over a box, between two bounds.

Of ``F + C v`` with ``|v_k| ≤ 1`` the largest component along a unit vector n is
``n·F + Σ_k |n·C_k|``. The largest norm is the maximum of this over n, to be maximised. Let
n be the direction of the maximum, and n' one within the angle θ of it: along n', the same v has
at least ``cos θ`` times the norm. So over a grid of directions that covers the sphere up to θ,

    max over the grid  ≤  largest norm  ≤  max over the grid / cos θ,

and the v of the best direction reaches the norm ``|F + C v|``, which is the lower bound here.
"""

from __future__ import annotations

from functools import cache
from math import atan, cos, sqrt
from typing import NamedTuple

import numpy as np

from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.tolerances import TIE_RELATIVE

# Cells along an edge of the cube whose grid is projected to the sphere.
CELLS = 40
# Steps from the best direction of the grid to that of a vertex.
MAX_STEPS = 20


class WorstCase(NamedTuple):
    """The largest norm over all samples and the whole box.

    Attributes:
        least: a norm that is reached.
        most: a bound that none exceeds.
        sample: where.
        direction: unit vector there (3,).
        vertex: v of the norm that is reached (k,), each 1 or -1.
    """

    least: float
    most: float
    sample: int
    direction: Array
    vertex: Array


@cache
def directions() -> tuple[Array, float]:
    """Return unit vectors (count, 3) that cover the sphere, and the cosine of the angle θ.

    A point of the cube of edge 2 is within the half-diagonal ``√2 / CELLS`` of a corner of its
    cell. Both are on a plane at the distance 1 from the centre, so that the angle between them
    is at most that of two points to both sides of its foot, ``2 atan(1 / (√2 CELLS))``.
    """
    ticks = np.linspace(-1.0, 1.0, CELLS + 1)
    a, b = (x.ravel() for x in np.meshgrid(ticks, ticks))
    faces = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            face = np.empty((a.size, 3))
            face[:, axis] = side
            face[:, axis - 2], face[:, axis - 1] = a, b
            faces.append(face)
    points = np.unique(np.concatenate(faces), axis=0)
    units = points / np.linalg.norm(points, axis=1)[:, None]
    return freeze(units), cos(2.0 * atan(sqrt(0.5) / CELLS))


def worst_case(F: Array, C: Array, extra: Array) -> WorstCase:
    """Find the largest ``|F + C v| + extra`` over samples and ``|v_k| ≤ 1``.

    Args:
        F: constant vectors (N, 3).
        C: columns (N, 3, k).
        extra: sizes that are added to the bound (N,).
    """
    units, cosine = directions()
    best = 0.0, 0, 0
    most = 0.0
    for k in range(len(F)):
        support = units @ F[k] + np.abs(units @ C[k]).sum(axis=1)
        at = first_largest(support)
        most = max(most, float(support.max()) / cosine + float(extra[k]))
        if support[at] > (1.0 + TIE_RELATIVE) * best[0]:
            best = float(support[at]), k, at
    _, sample, at = best
    vertex, reached = _ascend(F[sample], C[sample], units[at])
    size = float(np.linalg.norm(reached))
    direction = reached / size if size > 0.0 else units[at]
    return WorstCase(size, max(most, size), sample, freeze(direction), freeze(vertex))


def _ascend(F: Array, C: Array, n: Array) -> tuple[Array, Array]:
    """Go from a direction to its vertex and back, until the norm of the load grows no more."""
    vertex = np.where(C.T @ n >= 0.0, 1.0, -1.0)
    for _ in range(MAX_STEPS):
        reached = F + C @ vertex
        after = np.where(C.T @ reached >= 0.0, 1.0, -1.0)
        if np.linalg.norm(F + C @ after) <= np.linalg.norm(reached):
            break
        vertex = after
    return vertex, F + C @ vertex
