"""Momentum as a function of the pose, and as lines in space.

- ``momentum_regressor``: regressor of the total momentum at a finite pose
- ``momentum_taylor``: the regressor as a polynomial about the reference pose
- ``MomentumTaylor``: that polynomial
- ``momentum_wrenches``: momentum of each body for unit rates of the coordinates
- ``momentum_lines``: the same as lines with a pitch
- ``meeting``: the point nearest to lines
- ``common_normal``: the line that lines meet at right angles
- ``screw_figure``: a picture of the lines at a pose
- ``Meeting``: the point nearest to several lines
- ``ScrewLine``: the line of a body's momentum
"""

from __future__ import annotations

from balance.space.momentum.momentum_figure import screw_figure
from balance.space.momentum.momentum_lines import (
    Meeting,
    ScrewLine,
    common_normal,
    meeting,
    momentum_lines,
    momentum_wrenches,
)
from balance.space.momentum.regressor import momentum_regressor
from balance.space.momentum.regressor_polynomial import MomentumTaylor, momentum_taylor

__all__ = [
    "Meeting",
    "MomentumTaylor",
    "ScrewLine",
    "common_normal",
    "meeting",
    "momentum_lines",
    "momentum_regressor",
    "momentum_taylor",
    "momentum_wrenches",
    "screw_figure",
]
