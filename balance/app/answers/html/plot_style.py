"""Plot style of all curves, for Matplotlib and for pages."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinematics.errors import PackageError

Array = NDArray[np.float64]

GRID = "#e6e9ec"


def image(size: tuple[float, float], kind: str, draw: Callable[[Any], None]) -> bytes:
    """Draw a Matplotlib figure into a file, with the same bytes for the same figure.

    Args:
        size: width and height, inches.
        kind: ``"png"`` or ``"svg"``.
        draw: function that draws into the figure.

    Returns:
        The bytes of the file.

    Raises:
        PackageError: Matplotlib is missing.
    """
    try:
        from matplotlib import rc_context
        from matplotlib.figure import Figure
    except ImportError:
        raise PackageError("a picture", "Matplotlib", "pip install matplotlib") from None
    with rc_context({"svg.hashsalt": "balance", "font.size": 9.0}):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        file = BytesIO()
        undated = {"Date": None} if kind == "svg" else {}
        figure.savefig(file, format=kind, dpi=150, metadata=undated)
    return file.getvalue()


def tidy(ax: Any) -> None:
    """Give Matplotlib axes a light grid and no frame."""
    ax.grid(color=GRID, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)


def short(values: Array) -> list[float | None]:
    """Round numbers to six digits for JSON; numbers that are not finite become None."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]
