"""The page of a synthesis: what it moves, and where its pivots are."""

from __future__ import annotations

import re

import numpy as np
import pytest

from balance import synthesize
from balance.app.answers.html.synthesis import synthesis_page
from kinematics.loading.model_gallery import load
from kinematics.model.document.element import Document
from tests.support.design_space_pages import links
from tests.support.page_elements import Elements

PLACES = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "wish",
    [
        {"kind": "four-bar", "moving": 0.2 - 0.1j},
        {"kind": "slider-crank", "moving": 0.2 - 0.1j},
        {"kind": "six-bar", "moving": 0.2 - 0.1j},
        {"ratio": -0.5, "moving": 0.2 - 0.1j},
        {"nonlinear": True, "moving": 0.4 + 0.4j},
    ],
    ids=lambda wish: wish.get("kind", next(iter(wish))),
)
def test_the_motion_passes_through_the_positions(wish):
    """The joints of the file are where the outlines of the construction have them."""
    found = synthesize(PLACES, **wish)
    best = found.mechanisms[0]
    elements = Elements(synthesis_page(found))
    motion = elements.data("motion")
    (run,) = motion["runs"]
    linkage = load(Document("best", best.urdf))
    assert [k for k, _ in zip(motion["at"], PLACES, strict=True)] == [0, len(run["q"]) - 1]
    for k, outline, (x, y, _) in zip(motion["at"], best.outlines, PLACES, strict=True):
        H = links(linkage, np.array(run["q"][k]))
        whole = {-1: np.eye(4), **dict(enumerate(H))}
        joints = np.array([whole[j.parent] @ [*j.point, 1.0] for j in linkage.joints])[:, :2]
        corners = np.array([[z.real, z.imag] for z in outline if not np.isnan(z)])
        away = np.linalg.norm(corners[:, None] - joints, axis=2).min(axis=1)
        away = np.minimum(away, np.hypot(*(corners - [x, y]).T))  # or the tool
        assert away.max() < 1e-5
    # The tool rides on its link to every position, and never far from one to the next.
    body = next(b for b in linkage.bodies if b.name in ("coupler", "link2"))
    point = [*motion["tool"]["point"], 1.0]
    way = np.array([(links(linkage, np.array(q))[body.link] @ point)[:2] for q in run["q"]])
    assert np.abs(way[[0, -1]] - [place[:2] for place in PLACES]).max() < 1e-5
    assert np.linalg.norm(np.diff(way, axis=0), axis=1).max() < 0.1


@pytest.mark.slow
def test_pivots_are_in_the_first_sentence_and_in_the_figure():
    found = synthesize(PLACES, ratio=-0.5, moving=0.2 - 0.1j)
    elements = Elements(synthesis_page(found))
    figure = elements.data("figures")[0]
    (marks,) = [trace for trace in figure["data"] if trace["name"] == "pivots at position 1"]
    pivots = found.mechanisms[0].pivots
    assert marks["text"] == list(pivots)
    places = [complex(*pair) for pair in zip(marks["x"], marks["y"], strict=True)]
    assert places == pytest.approx(list(pivots.values()), rel=1e-5)
    lede = elements.text.partition("Motion")[0].replace("\u2212", "-")
    assert all(f"{z.real:.4g}, {z.imag:.4g}" in lede for z in pivots.values())
    assert not re.search(r"\{\{", elements.text)
