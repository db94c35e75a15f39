"""Compiled kernels that check joint screws and write them in the frame of each geometry."""

from __future__ import annotations

import numpy as np

from balance.support.tolerances import LENGTH_ROUND_OFF, LENGTH_SHORT, SCREW_ROUNDED
from kinematics.numerics.compiled.jit import kernel
from kinematics.numerics.linalg.pivoted_qr import round_off


@kernel(reference_counting=False)
def points_on_axes(screws, near, points):
    """Find the points of joint axes nearest to given ones: ``n × v + (n · near) n``.

    Args:
        screws: in: joint screws ``[n; v]`` (n, 6), metres.
        near: in: the given points (n, 3), metres; sliding joints have these.
        points: out: (n, 3), metres.
    """
    for j in range(near.shape[0]):
        n, v = screws[j, :3], screws[j, 3:]
        along = n[0] * near[j, 0] + n[1] * near[j, 1] + n[2] * near[j, 2]
        turns = n[0] != 0.0 or n[1] != 0.0 or n[2] != 0.0
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            foot = n[a] * v[b] - n[b] * v[a] + along * n[i]
            points[j, i] = foot if turns else near[j, i]


@kernel(reference_counting=False)
def find_wrong_screw(given, sliding, helical):
    """Find the first screw that is not of the kind of its joint.

    Args:
        given: in: joint screws (g, n, 6), metres.
        sliding: in: whether each joint slides (n,).
        helical: in: whether each joint is helical (n,).

    Returns:
        Its number, counted through all geometries; -1 if there is none.
    """
    count, n = given.shape[:2]
    for g in range(count):
        for j in range(n):
            s, axis, moment, along, largest = given[g, j], 0.0, 0.0, 0.0, 1.0
            for i in range(3):
                axis += s[i] * s[i]
                moment += s[3 + i] * s[3 + i]
                along += s[i] * s[3 + i]
                largest = max(largest, abs(s[3 + i]))
            size = moment if sliding[j] else axis
            # Written so that a NaN fits no joint.
            level = abs(along) < np.inf if helical[j] else abs(along) <= SCREW_ROUNDED * largest
            if not (abs(size - 1.0) <= SCREW_ROUNDED and (axis != 0.0) != sliding[j] and level):
                return g * n + j
    return -1


@kernel(reference_counting=False)
def _frame(screws, points, centres, origin):
    """Find origin and length of the frame, as in `kinematics.model.chain.arrange_loops`.

    The length is the root mean square of ``|v + n × origin - pitch|`` over turning joints.

    Args:
        screws: in: joint screws ``[n; v]`` (n, 6), metres.
        points: in: points on the joint axes (n, 3), metres.
        centres: in: centres of mass (m, 3), metres.
        origin: out: mean of the points (3,), metres.

    Returns:
        The length, metres; 0 if it is too small for the distances.
    """
    n = points.shape[0]
    for i in range(3):
        origin[i] = 0.0
        for j in range(n):
            origin[i] += points[j, i] / n
    largest = far = total = 0.0
    turning = 0
    for j in range(n):
        w, v = screws[j, :3], screws[j, 3:]
        square = size = along = arm = 0.0
        for i in range(3):
            a, b = (i + 1) % 3, (i + 2) % 3
            square += (points[j, i] - origin[i]) ** 2
            largest = max(largest, abs(points[j, i]))
            size += w[i] * w[i]
            moment = v[i] + w[a] * origin[b] - w[b] * origin[a]
            arm += moment * moment
            along += moment * w[i]
        far = max(far, square)
        if size > 0.0:
            turning += 1
            total += arm - along * along
    far = np.sqrt(far)
    for c in range(centres.shape[0]):
        square = 0.0
        for i in range(3):
            square += (centres[c, i] - origin[i]) ** 2
            largest = max(largest, abs(centres[c, i]))
        far = max(far, np.sqrt(square))
    length = np.sqrt(total / turning) if turning else 0.0
    return length if length > max(LENGTH_ROUND_OFF * largest, LENGTH_SHORT * far) else 0.0


@kernel
def place_geometry(
    given, near, centres, R, pivots, relations, screws, mimics, origins, lengths, tolerances
):
    """Write joint screws and mimic relations in the frame of each geometry.

    ``w = n``, ``v = (v + n × origin) / length`` for joints that turn; a plane takes ``R``.

    Args:
        given: in: joint screws (g, n, 6), metres.
        near: in: points near the joint axes (n, 3), metres.
        centres: in: centres of mass (m, 3), metres.
        R: in: axes of the frame as rows (3, 3).
        pivots: in: joint by which each relation is divided (rows,).
        relations: in: mimic relations (rows, n), SI units.
        screws: out: joint screws in the frame (g, n, dim).
        mimics: out: mimic relations in the frame (g, rows, n).
        origins: out: (g, 3), metres.
        lengths: out: (g,), metres; 0 marks a geometry that is special, -1 one that leaves the
            plane.
        tolerances: out: relative size of round-off (g,), where the length is not 0.
    """
    n, dim = screws.shape[1:]
    points, w, v = np.empty((n, 3)), np.empty(3), np.empty(3)
    for g in range(given.shape[0]):
        points_on_axes(given[g], near, points)
        origin = origins[g]
        L = lengths[g] = _frame(given[g], points, centres, origin)
        if L == 0.0:
            continue
        tolerances[g] = round_off(origin, L)
        for j in range(n):
            s = given[g, j]
            turns = s[0] != 0.0 or s[1] != 0.0 or s[2] != 0.0
            unit = L if turns else 1.0
            for i in range(3):
                a, b = (i + 1) % 3, (i + 2) % 3
                w[i] = s[i]
                v[i] = (s[3 + i] + s[a] * origin[b] - s[b] * origin[a]) / unit
            for row in range(relations.shape[0]):
                mimics[g, row, j] = relations[row, j] * (1.0 if turns else L)
            if dim == 6:
                for i in range(3):
                    screws[g, j, i], screws[g, j, 3 + i] = w[i], v[i]
                continue
            for i in range(3):
                turned = R[i, 0] * w[0] + R[i, 1] * w[1] + R[i, 2] * w[2]
                moved = R[i, 0] * v[0] + R[i, 1] * v[1] + R[i, 2] * v[2]
                if i < 2:
                    screws[g, j, 1 + i] = moved
                    if abs(turned) > SCREW_ROUNDED:
                        lengths[g] = -1.0
                else:
                    screws[g, j, 0] = np.rint(turned)
                    if abs(moved) > SCREW_ROUNDED:
                        lengths[g] = -1.0
        for row in range(relations.shape[0]):
            pivot = mimics[g, row, pivots[row]]
            for j in range(n):
                mimics[g, row, j] /= pivot
