"""Two Taylor jobs: inverse kinematics of a five-bar, and of a 6R arm along a line.

The inputs of the five-bar are the coordinates (x, y) of its tip; the input of the 6R arm is the
distance along a straight line at constant orientation. Coefficients of degree k are those of
x^k, x^(k-1) y, … y^k.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import acos, atan2, cos, sin

import numpy as np

from benchmarks.peers import library

# Five-bar: lengths of the links, pivots, sides of the elbows, and the tip; metres.
LOWER, UPPER = 0.19, 0.18
BASES, ELBOWS = (-0.2, 0.2), (-1, 1)
TIP = (0.0, 0.25)
# 6R arm at zero angles: axes, points on them, flange; then angles and direction of the line.
AXES = np.array(
    [[0, 0, 1], [0, -1, 0], [0, -1, 0], [1, 0, 0], [0, -1, 0], [1, 0, 0]], dtype=float
)
POINTS = np.array(
    [
        [0, 0, 0],
        [0.03, 0, 0.35],
        [0.03, 0.05, 0.75],
        [0.03, 0.05, 0.8],
        [0.45, 0.02, 0.8],
        [0.45, 0.02, 0.8],
    ]
)
FLANGE = np.array([0.55, 0.02, 0.8])
POSE = np.array([0.3, 0.5, -0.7, 0.4, 0.8, -0.2])
DIRECTION = np.array([0.6, -0.5, 0.3])
# Orders, samples of a period, radius and digits of the reference.
HIGHEST, SAMPLES, RADIUS, DIGITS = 10, 16, "1e-6", 110


def _angles() -> np.ndarray:
    """Angles of the five-bar: lower and upper, of the left and of the right arm."""
    found = []
    for base, elbow in zip(BASES, ELBOWS, strict=True):
        x, y = TIP[0] - base, TIP[1]
        bend = elbow * acos((x * x + y * y - LOWER**2 - UPPER**2) / (2 * LOWER * UPPER))
        found += [atan2(y, x) - atan2(UPPER * sin(bend), LOWER + UPPER * cos(bend)), bend]
    return np.array(found)


ANGLES = _angles()


def cross_matrix(n: np.ndarray) -> np.ndarray:
    """The matrix of the cross product with n."""
    return np.cross(np.eye(3), n)


def exponents(order: int) -> list[tuple[int, int]]:
    """Exponents of x and y, by degree."""
    return [(k - j, j) for k in range(order + 1) for j in range(k + 1)]


def degrees(width: int, order: int) -> np.ndarray:
    """Degree of each monomial of one or two variables."""
    return np.repeat(np.arange(order + 1), np.arange(order + 1) + 1 if width == 2 else 1)


def error(job: str, found: np.ndarray, order: int) -> float:
    """Compute the largest relative error of a coefficient beyond the constant one.

    Errors of coefficients that are exactly 0 are relative to the largest of their degree.
    """
    degree = degrees(2 if job == "five_bar" else 1, order)
    true = exact(job)[:, : degree.size]
    largest = np.array([np.abs(true[:, degree == k]).max() for k in range(order + 1)])[degree]
    size = np.where(np.abs(true) > 1e-12 * largest, np.abs(true), largest)
    return float((np.abs(found - true) / size)[:, 1:].max())


@cache
def exact(job: str) -> np.ndarray:
    """Compute coefficients up to order 10 with mpmath: Cauchy's integrals, 110 digits."""
    mp = library("mpmath").mp
    with mp.workdps(DIGITS):
        return _exact_five_bar(mp) if job == "five_bar" else _exact_six_r(mp)


def _circle(mp) -> list:
    return [mp.expjpi(mp.mpf(2 * i) / SAMPLES) for i in range(SAMPLES)]


def _term(mp, values: list, circle: list, k: int):
    """Coefficient k of a series, times the radius to the power k, from values on a circle."""
    turned = [v * mp.conj(circle[i * k % SAMPLES]) for i, v in enumerate(values)]
    return mp.fsum(turned) / SAMPLES


def _exact_five_bar(mp) -> np.ndarray:
    circle, radius = _circle(mp), mp.mpf(RADIUS)
    rows = []
    for base, elbow in zip(BASES, ELBOWS, strict=True):
        grid = [
            [
                _arm_angles(mp, elbow, TIP[0] - mp.mpf(base) + radius * a, TIP[1] + radius * b)
                for b in circle
            ]
            for a in circle
        ]
        for angle in range(2):
            lines = [[value[angle] for value in line] for line in grid]
            inner = [[_term(mp, line, circle, j) for line in lines] for j in range(HIGHEST + 1)]
            rows.append(
                [
                    float(mp.re(_term(mp, inner[j], circle, i) / radius ** (i + j)))
                    for i, j in exponents(HIGHEST)
                ]
            )
    return np.array(rows)


def _arm_angles(mp, elbow: int, x, y) -> tuple:
    """Compute the angles of an arm from complex coordinates of its tip about its pivot."""
    lower, upper = mp.mpf(LOWER), mp.mpf(UPPER)
    bend = elbow * mp.acos((x * x + y * y - lower**2 - upper**2) / (2 * lower * upper))
    return -1j * mp.log((x + 1j * y) / (lower + upper * mp.expj(bend))), bend


def _exact_six_r(mp) -> np.ndarray:
    circle, radius = _circle(mp), mp.mpf(RADIUS)
    start = [mp.mpf(float(q)) for q in POSE]
    line = [mp.mpf(float(v)) for v in DIRECTION]
    at, turned = _flange(mp, start)

    def mismatch(q: list, u) -> object:
        p, R = _flange(mp, q)
        B = turned.T * R
        shift = [p[i] - at[i] - u * line[i] for i in range(3)]
        return mp.matrix([*shift, B[2, 1] - B[1, 2], B[0, 2] - B[2, 0], B[1, 0] - B[0, 1]])

    inverse = _jacobian(mp, lambda q: mismatch(q, mp.mpf(0)), start) ** -1
    values = [
        _newton(mp, lambda q, u=radius * a: mismatch(q, u), inverse, start) for a in circle
    ]
    return np.array(
        [
            [
                float(mp.re(_term(mp, [v[i] for v in values], circle, k) / radius**k))
                for k in range(HIGHEST + 1)
            ]
            for i in range(6)
        ]
    )


def _flange(mp, q: list) -> tuple:
    """Position and rotation of the flange, from the last joint to the first."""
    p, R = mp.matrix(FLANGE.tolist()), mp.eye(3)
    for i in range(5, -1, -1):
        K = mp.matrix(cross_matrix(AXES[i]).tolist())
        turn = mp.eye(3) + mp.sin(q[i]) * K + (1 - mp.cos(q[i])) * K * K
        centre = mp.matrix(POINTS[i].tolist())
        p, R = turn * (p - centre) + centre, turn * R
    return p, R


def _jacobian(mp, function: Callable, q: list):
    step = mp.mpf("1e-40")
    columns = []
    for i in range(6):
        ahead, behind = list(q), list(q)
        ahead[i] += step
        behind[i] -= step
        columns.append((function(ahead) - function(behind)) / (2 * step))
    return mp.matrix(6, 6) + mp.matrix([[column[r] for column in columns] for r in range(6)])


def _newton(mp, function: Callable, inverse, start: list) -> list:
    q = mp.matrix(start)
    for _ in range(80):
        step = inverse * function(list(q))
        q -= step
        if mp.norm(step) < mp.mpf("1e-95"):
            return list(q)
    raise ArithmeticError("Newton's method did not converge")
