"""Drawings as DXF, in mm, without a date: the same drawing is the same file."""

from __future__ import annotations

from collections.abc import Iterable
from io import StringIO

import numpy as np

from kinematics.numerics.array_types import Array

# The oldest version of DXF whose header names the unit of length.
VERSION = "R2000"


def polylines_dxf(lines: Iterable[Array], closed: bool) -> bytes:
    """Write polylines as the bytes of a DXF file, whose header says mm and metric.

    Args:
        lines: corners of each (n, 2), mm; or (n, 3) with the bulge of the arc to the next.
        closed: whether their ends are joined.
    """
    import ezdxf

    options = ezdxf.options
    as_set = options.write_fixed_meta_data_for_testing
    try:
        # The time and random numbers stay out of the header.
        options.write_fixed_meta_data_for_testing = True
        drawing = ezdxf.new(VERSION, units=ezdxf.units.MM)
        drawing.header["$MEASUREMENT"] = 1
        for line in lines:
            corners = np.asarray(line)
            columns = "xyb"[: corners.shape[1]]
            drawing.modelspace().add_lwpolyline(corners.tolist(), format=columns, close=closed)
        text = StringIO(newline="")
        drawing.write(text)
    finally:
        options.write_fixed_meta_data_for_testing = as_set
    return text.getvalue().encode()
