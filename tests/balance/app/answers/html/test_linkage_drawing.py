"""Drawings of linkages: no name lies over the ground."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

import kinematics
from balance.app.answers.html.linkage_drawing import linkage_drawing
from kinematics import gallery

CROWDED = ["four_bar_chain", "four_rrr", "four_rrr_side_by_side", "three_four_bars_platform"]
NUMBER = r"(-?[\d.]+)"
GROUND = rf"M{NUMBER} {NUMBER}L{NUMBER} {NUMBER}L{NUMBER} {NUMBER}ZM.*l-4 5$"


def boxes(svg):
    """Boxes (2, 2) of all grounds, and of all texts by name; a letter is 6.5 wide at least."""
    grounds, texts = [], []
    for element in ElementTree.fromstring(svg).iter():
        ground = re.match(GROUND, element.get("d", ""))
        if ground:
            points = np.array(ground.groups(), dtype=float).reshape(3, 2)
            grounds.append([points.min(axis=0) - (4, 0), points.max(axis=0) + (0, 5)])
        if element.tag.endswith("text"):
            x, y = float(element.get("x")), float(element.get("y"))
            wide = 6.5 * len(element.text)
            x -= wide * {"start": 0.0, "middle": 0.5, "end": 1.0}[element.get("text-anchor")]
            texts.append((element.text, [[x, y - 9.0], [x + wide, y]]))
    return grounds, texts


def cover(one, other):
    (a, b), (c, d) = np.array(one), np.array(other)
    return (a < d).all() and (c < b).all()


@pytest.mark.parametrize(
    "model", [pytest.param(m, marks=[pytest.mark.slow] * (m not in CROWDED)) for m in gallery()]
)
def test_no_name_lies_over_the_ground(model):
    linkage = kinematics.load(model)
    grounds, texts = boxes(linkage_drawing(linkage))
    assert {*linkage.inputs} <= {name for name, _ in texts}
    assert not [name for name, box in texts if any(cover(box, ground) for ground in grounds)]
