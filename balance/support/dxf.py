"""Drawings as DXF, in mm, without a date: the same drawing is the same file."""

from __future__ import annotations

from collections.abc import Iterable
from io import StringIO

import numpy as np

from kinematics.numerics.array_types import Array


def polylines_dxf(lines: Iterable[Array], closed: bool) -> bytes:
    """Write polylines as the bytes of a DXF file.

    Args:
        lines: corners of each (n, 2), mm; or (n, 3) with the bulge of the arc to the next.
        closed: whether their ends are joined.
    """
    from ezdxf.addons.r12writer import r12writer

    text = StringIO(newline="")
    with r12writer(text) as drawing:
        for line in lines:
            corners = np.asarray(line)
            columns = "xyb"[: corners.shape[1]]
            drawing.add_polyline_2d(corners.tolist(), format=columns, closed=closed)
    return text.getvalue().encode()
