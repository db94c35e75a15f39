"""Pictures in SVG can be read on white and on a dark screen."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from balance.app.answers.html.plot_style import dark_colour, image, tidy

PAPER = {"light": "#ffffff", "dark": "#1a1a1a"}


def luminance(colour):
    """Relative luminance by the Web Content Accessibility Guidelines 2.1."""
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one, two):
    high, low = sorted((luminance(one), luminance(two)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize(
    "colour", ["#1b1e22", "#08264a", "#b8550a", "#5a626b", "#1f5a94", "#3d7a3d"]
)
def test_a_colour_that_is_clear_on_white_is_clear_on_a_dark_screen(colour):
    assert contrast(colour, PAPER["light"]) > 4.5
    assert contrast(dark_colour(colour), PAPER["dark"]) > 4.5


def test_a_picture_has_no_ground_and_dark_colours():
    pytest.importorskip("matplotlib")

    def draw(figure):
        ax = figure.subplots()
        ax.plot([0, 1], [0, 1], color="#08264a", label="a line")
        ax.scatter([0, 1], [1, 0], c=[0.0, 1.0], cmap="viridis")
        ax.set_xlabel("time")
        tidy(ax)

    text = image((3.0, 2.0), "svg", draw).decode()
    ElementTree.fromstring(text)
    assert "fill: #ffffff" not in text  # neither the figure nor the axes are filled
    sheet = re.search(r"@media \(prefers-color-scheme: dark\) \{(.*)\}</style>", text)[1]
    rules = dict(re.findall(r'\[style\*="(\w+: #\w{6})"\] \{\w+: (#\w{6}) !important\}', sheet))
    assert rules["stroke: #08264a"] == dark_colour("#08264a")
    assert contrast(rules["fill: #1b1e22"], PAPER["dark"]) > 7  # texts
    assert "fill: #440154" in text and "fill: #440154" not in rules  # the first of the map
