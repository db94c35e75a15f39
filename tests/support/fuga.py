"""Fuga I, a planar five-bar: its geometry in closed form, and three of its paths.

[J] J. J. de Jong, PhD thesis, University of Twente, section 3.3 and table 3.2. Base pivots at
y = ∓0.2 m, elbows both at x > 0, end point between them; the symmetry line is the x axis. Arms
are mirror images: an angle of a centre of mass is measured from its arm, towards the left (+1)
on the left arm.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics import ScrewJoint, from_screws

BASE, UPPER, LOWER = 0.4, 0.19, 0.18
UPPER_MASS, LOWER_MASS, LOWER_MOMENT = 0.66, 0.21, 1.66e-3
PIVOTS = np.array([[0.0, -BASE / 2], [0.0, BASE / 2]])
SIDES = np.array([1.0, -1.0])
# Second-order profile of [J] section 3.4: 0.2 m in 0.4 s, at 5 m/s².
TIME, LENGTH, ACCELERATION = 0.4, 0.2, 5.0
PATHS = {1: (1.0, 0.0), 2: (0.0, 1.0), 3: (np.sqrt(0.5), np.sqrt(0.5))}
STEP = 2e-4


class Masses(NamedTuple):
    """Distance and angle (degrees) of the centres of mass, moment of inertia of upper arms."""

    lower: tuple[float, float]
    upper: tuple[float, float]
    moment: float


def elbows(end):
    """Both elbows (…, 2, 2) for end points (…, 2)."""
    way = np.asarray(end)[..., None, :] - PIVOTS
    d = np.linalg.norm(way, axis=-1, keepdims=True)
    along = (UPPER**2 - LOWER**2 + d**2) / (2 * d)
    u = way / d
    across = np.stack([u[..., 1], -u[..., 0]], axis=-1) * SIDES[:, None]
    return PIVOTS + along * u + np.sqrt(UPPER**2 - along**2) * across


def angles(end):
    """Angles of the arms in the plane: uppers (…, 2), lowers (…, 2)."""
    B = elbows(end)
    arms = B - PIVOTS, np.asarray(end)[..., None, :] - B
    return tuple(np.arctan2(arm[..., 1], arm[..., 0]) for arm in arms)


def centres(start, angle, place):
    """Centres of mass (2, 2) of the arms from their starts, at ``place`` (distance, angle)."""
    t = angle + SIDES * np.radians(place[1])
    return start + place[0] * np.stack([np.cos(t), np.sin(t)], axis=-1)


def fuga(x, masses):
    """The linkage with the end point at (x, 0)."""
    end = np.array([x, 0.0])
    B, (first, second) = elbows(end), angles(end)
    joints, bodies = [], {}
    for k, side in enumerate(("left", "right")):
        joints += [
            ScrewJoint(("u1", "u3")[k], "base", f"{side}_upper", point=[*PIVOTS[k], 0.0]),
            ScrewJoint(("q2", "q4")[k], f"{side}_upper", f"{side}_lower", point=[*B[k], 0.0]),
        ]
        upper = centres(PIVOTS, first, masses.upper)[k]
        lower = centres(B, second, masses.lower)[k]
        bodies[f"{side}_upper"] = UPPER_MASS, [*upper, 0.0], flat(masses.moment)
        bodies[f"{side}_lower"] = LOWER_MASS, [*lower, 0.0], flat(LOWER_MOMENT)
    loop = ScrewJoint("q5", "left_lower", "right_lower", point=[*end, 0.0])
    return from_screws(joints, [loop], bodies, ["u1", "u3"], name="fuga")


def flat(moment):
    """Tensor of a flat body."""
    return np.diag([0.5, 0.5, 1.0]) * moment


def positions(end, x):
    """Positions of u1, q2, u3, q4, q5 (…, 5) from the pose with the end point at (x, 0)."""

    def turned(point):
        first, second = angles(point)
        return np.stack(
            [
                first[..., 0],
                second[..., 0] - first[..., 0],
                first[..., 1],
                second[..., 1] - first[..., 1],
                second[..., 1] - second[..., 0],
            ],
            axis=-1,
        )

    return np.angle(np.exp(1j * (turned(end) - turned(np.array([x, 0.0])))))


def travel(samples=201):
    """Time, way, speed and acceleration (samples,) of the profile, from end to end."""
    t = np.linspace(0.0, TIME, samples)
    back = t > TIME / 2
    a = np.where(back, -ACCELERATION, ACCELERATION)
    v = ACCELERATION * np.where(back, TIME - t, t)
    s = 0.5 * ACCELERATION * np.where(back, TIME - t, t) ** 2
    return t, np.where(back, LENGTH - s, s) - LENGTH / 2, v, a


def driven(path, x, samples=201):
    """Joint positions, and rates and accelerations of the inputs, along one of the paths."""
    _, s, v, a = travel(samples)
    direction = np.array(PATHS[path])

    def at(way):
        return positions(np.array([x, 0.0]) + way[:, None] * direction, x)

    there = [at(s + k * STEP)[:, [0, 2]] for k in range(-2, 3)]
    first = (there[0] - 8 * there[1] + 8 * there[3] - there[4]) / (12 * STEP)
    second = -(there[0] - 16 * there[1] + 30 * there[2] - 16 * there[3] + there[4])
    second /= 12 * STEP**2
    return at(s), v[:, None] * first, a[:, None] * first + v[:, None] ** 2 * second
