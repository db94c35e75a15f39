"""A serial robot with six joints, and a pick-and-place cycle for it."""

from __future__ import annotations

import numpy as np

from tests.support.robots import arm

# Stops of the cycle: above the part, at it, above it, above the place, at it, above it.
STOPS = [
    (0, -0.4, 0.7, -0.3, 0, 0),
    (0, -0.2, 0.9, -0.7, 0, 0),
    (0, -0.4, 0.7, -0.3, 0, 0),
    (1.5, -0.3, 0.5, -0.2, 0, 1.5),
    (1.5, -0.1, 0.7, -0.6, 0, 1.5),
    (1.5, -0.3, 0.5, -0.2, 0, 1.5),
    (0, -0.4, 0.7, -0.3, 0, 0),
]
POINTS = [
    [0, 0, 0.09],
    [0, 0.14, 0.09],
    [0.42, 0.02, 0.09],
    [0.82, 0.02, 0.09],
    [0.82, 0.11, 0.09],
    [0.82, 0.11, 0],
]
AXES = [[0, 0, 1], [0, 1, 0], [0, 1, 0], [0, 1, 0], [0, 0, -1], [0, 1, 0]]


def robot_arm(folder):
    """Write the robot to a folder, and return its path."""
    return arm(folder, POINTS, AXES)


def write_cycle(path, inputs):
    """A pick-and-place cycle of two seconds at rest at its stops, as a table."""
    tau = np.linspace(0.0, len(STOPS) - 1.0, 121)
    leg = np.minimum(tau.astype(int), len(STOPS) - 2)
    x = (tau - leg)[:, None]
    stops = np.array(STOPS)
    u = stops[leg] + np.diff(stops, axis=0)[leg] * (10 * x**3 - 15 * x**4 + 6 * x**5)
    table = np.column_stack([tau / 3.0, u - u[0]])
    names = ",".join(["time", *inputs])
    path.write_text("\n".join([names, *(",".join(map(repr, row)) for row in table.tolist())]))
    return path
