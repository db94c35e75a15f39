"""The tip of the five-bar of the gallery, and the joint angles that take it to a point."""

from __future__ import annotations

import numpy as np

TIP = (0.5, 1.1, 0.0)


def two_links(base, tip, elbow):
    """Angles of two links that reach from a base to a tip (…, 2); ``elbow`` is its start."""
    first, second = elbow - base, np.array(TIP[:2]) - elbow
    a, b = np.linalg.norm(first), np.linalg.norm(second)
    sign = np.sign(first[0] * second[1] - first[1] * second[0])
    x, y = np.moveaxis(tip - base, -1, 0)
    bend = sign * np.arccos((x * x + y * y - a * a - b * b) / (2 * a * b))
    return np.arctan2(y, x) - np.arctan2(b * np.sin(bend), a + b * np.cos(bend)), bend
