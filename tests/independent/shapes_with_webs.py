"""Mass and first moment of a shape and its web, by closed formulas of plane geometry."""

import numpy as np


def shape_and_web(kind, half, distance):
    """Area, and its first moment about the joint, of a shape and of the web outside it, m², m³.

    Args:
        kind: disc, cylinder or block, whose side is along the web.
        half: radius, or half the side, m.
        distance: of the joint from the middle of the shape, m; it has no web where it is in it.
    """
    area = (4.0 if kind == "block" else np.pi) * half**2
    if distance <= half:
        return area, area * distance
    h = 0.5 * half
    if kind == "block":
        length = distance - half
        return area + 2.0 * h * length, area * distance + h * length**2
    # Of the disc, the web covers S, from its middle on.
    root = np.sqrt(half**2 - h**2)
    S = h * root + half**2 * np.arcsin(h / half)
    moment = h * distance**2 - distance * S + half**2 * h - h**3 / 3.0
    return area + 2.0 * h * distance - S, area * distance + moment
