"""Plot style of all curves, for Matplotlib and for pages."""

from __future__ import annotations

import re
from collections.abc import Callable
from colorsys import hls_to_rgb, rgb_to_hls
from io import BytesIO
from typing import Any
from xml.etree import ElementTree

import numpy as np

from kinematics.errors import PackageError
from kinematics.numerics.array_types import Array

GRID = "#e6e9ec"
INK = "#1b1e22"
INKED = ("text.color", "axes.labelcolor", "axes.edgecolor", "xtick.color", "ytick.color")
# Groups of an SVG file of Matplotlib whose colours mean numbers.
MAPS = ("QuadMesh", "PathCollection")


def image(size: tuple[float, float], kind: str, draw: Callable[[Any], None]) -> bytes:
    """Draw a Matplotlib figure into a file, with the same bytes for the same figure.

    An SVG file has no background, and on a dark screen the colours that pages have there.

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
    style: dict[Any, Any] = dict.fromkeys(INKED, INK)
    with rc_context(style | {"svg.hashsalt": "balance", "font.size": 9.0}):
        figure = Figure(figsize=size, layout="constrained")
        draw(figure)
        file = BytesIO()
        undated = {"Date": None} if kind == "svg" else {}
        clear = kind == "svg"
        figure.savefig(file, format=kind, dpi=150, metadata=undated, transparent=clear)
    content = file.getvalue()
    return _with_dark_colours(content.decode()).encode() if kind == "svg" else content


def _with_dark_colours(svg: str) -> str:
    """Add the colours of a dark screen to an SVG file, except to maps."""
    used: dict[str, None] = {}

    def collect(part: ElementTree.Element) -> None:
        if not part.get("id", "").startswith(MAPS):
            used.update(dict.fromkeys(re.findall(r"\w+: #[0-9a-f]{6}", part.get("style", ""))))
            for inner in part:
                collect(inner)

    collect(ElementTree.fromstring(svg))
    rules = []
    for pair in used:
        name, colour = pair.split(": ")
        rules.append(f'[style*="{pair}"] {{{name}: {dark_colour(colour)} !important}}')
    sheet = "@media (prefers-color-scheme: dark) {" + " ".join(rules) + "}"
    return svg.replace("</style>", f"\n{sheet}</style>", 1)


def dark_colour(colour: str) -> str:
    """Turn the lightness of a colour ``#rrggbb`` around, as pages do on a dark screen."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    hue, light, saturation = rgb_to_hls(red, green, blue)
    turned = hls_to_rgb(hue, 0.96 - 0.86 * light, saturation)
    return "#" + "".join(f"{round(255 * min(max(c, 0.0), 1.0)):02x}" for c in turned)


def tidy(ax: Any) -> None:
    """Give Matplotlib axes a light grid and no frame."""
    ax.grid(color=GRID, linewidth=0.6)
    ax.spines[["top", "right"]].set_visible(False)


def short(values: Array) -> list[float | None]:
    """Round numbers to six digits for JSON; numbers that are not finite become None."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]
