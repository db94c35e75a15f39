"""Sweeps whose cost for a geometry is measured: model, what varies, and quantities."""

from __future__ import annotations

from typing import Any, NamedTuple


class SweepCase(NamedTuple):
    """A study of one number of a model.

    Attributes:
        model: name in the gallery.
        path: the number that varies.
        span: its least and its greatest value.
        quantities: what is computed, with options.
        balance: of forces alone, or of moments too.
        answered: whether all geometries have an answer; else none has.
    """

    model: str
    path: str
    span: tuple[float, float]
    quantities: dict[str, dict[str, Any]]
    balance: str = "dynamic"
    answered: bool = True


SPEED = 10.0
"""Speed of cranks, rad/s."""
TURN = {"shaking": {"speed": SPEED}}
WEIGHTS = {"links": ["crank", "rocker"], "density": "none"}
CASES = {
    "four-bar, turn": SweepCase("four_bar_general", "q4.origin.x", (1.05, 1.15), TURN),
    "slider-crank, turn": SweepCase("slider_crank", "q2.origin.x", (0.27, 0.3), TURN),
    "slider-crank, no turn": SweepCase(
        "slider_crank", "q2.origin.x", (0.32, 0.34), TURN, answered=False
    ),
    "RUSR, turn": SweepCase("rusr", "r4.origin.x", (1.08, 1.1), TURN),
    "five-bar, poses": SweepCase(
        "five_bar",
        "u2.origin.x",
        (0.89, 0.91),
        {"shaking": {"poses": [[0.0, 0.0], [0.2, -0.1]]}},
    ),
    "four-bar, inertia": SweepCase(
        "four_bar_general", "q4.origin.x", (1.05, 1.15), {"input_inertia": {}}
    ),
    "four-bar, counterweights": SweepCase(
        "four_bar_general",
        "q4.origin.x",
        (1.05, 1.15),
        {"counterweights": WEIGHTS, **TURN},
        "force",
    ),
    "four-bar, steel": SweepCase(
        "four_bar_general",
        "q4.origin.x",
        (1.05, 1.15),
        {"counterweights": {**WEIGHTS, "density": "steel"}, **TURN},
        "force",
    ),
}
"""By name. Counterweights are point masses, which the first sweeps had alone, or of steel."""
