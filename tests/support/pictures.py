"""Curves of SVG pictures, to compare a picture that is kept with one that is drawn anew."""

from __future__ import annotations

import re

import numpy as np


def curves(picture: str) -> list[np.ndarray]:
    """Points of all lines in an SVG picture."""
    paths = re.findall(r'<g id="line2d_\d+">\s*<path d="([^"]*)"', picture)
    return [np.array(re.findall(r"-?\d+\.\d+", path), float) for path in paths]


def curves_agree(one: str, two: str) -> bool:
    """Whether two pictures have the same lines, more than forty.

    A hundredth of a point cannot be seen, and other versions draw so.
    """
    pairs = list(zip(curves(one), curves(two), strict=True))
    assert len(pairs) > 40
    return all(a.shape == b.shape and abs(a - b).max() < 0.01 for a, b in pairs)
