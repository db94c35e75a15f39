"""No size at a bound without a word of it, in all rows of nine models.

Where matter lies is read from the files alone: lumps that are fixed to the links.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from balance.masses.remedies.compare import compare_request
from balance.masses.remedies.request import RemedyRequest
from kinematics.loading.model_gallery import as_linkage, robots

MODELS = (
    "four_bar_general",
    "slider_crank",
    pytest.param(
        "double_pendulum",
        marks=pytest.mark.skipif(not robots(), reason="needs example-robot-data"),
    ),
    "five_bar",
    "four_bar_kite",
    "four_bar_parallelogram",
    "four_bar_antiparallelogram",
    "principal_vector_linkage",
    "zero_reaction_arm",
)
# Models that are balanced but for a relation: no row has matter at a rim.
BALANCED = ("principal_vector_linkage",)
# What a row says of a size that is one of these.
SIZED = {
    "with wheels of": ("a bound",),
    "with levers of": ("a bound", "not sought"),
    "counter-arm of": ("bounds:",),
    "as large": ("a bound:",),
    "rotor radius": ("a bound",),
}
LUMP = re.compile(r"(.+)_counterweight(_\d+)?")
AT_RIM = 0.999


def links_at_rim(urdf, links, radius):
    """Links with a lump at the rim of a ball about the frame of the link."""
    at_rim = set()
    for joint in ElementTree.fromstring(urdf).findall("joint"):
        lump, link = (joint.find(end).get("link") for end in ("child", "parent"))
        if joint.get("type") == "fixed" and LUMP.fullmatch(lump) and link in links:
            place = np.array(joint.find("origin").get("xyz").split(), dtype=float)
            reach = float(np.linalg.norm(place)) / radius
            assert reach < 1.0 + 1e-6, f"{lump} is outside of its region"
            at_rim |= {link} if reach > AT_RIM else set()
    return at_rim


def sized_parts(words):
    """Sizes that words of a row name, and what they should say beside."""
    parts = {key: said for key, said in SIZED.items() if key in words}
    return parts if "times as large" not in words else {}


@pytest.mark.slow
@pytest.mark.parametrize("name", MODELS)
def test_rows_say_which_sizes_are_bounds(name):
    linkage = as_linkage(name)
    radius = 0.5 * RemedyRequest(linkage).space.length
    regions = {body.name: f"ball(0,0,0,{radius!r})" for body in linkage.bodies}
    comparison = compare_request(RemedyRequest(linkage, regions=regions))
    names, checked = [body.name for body in linkage.bodies], 0
    for row in comparison.results:
        for key, said in sized_parts(row.words).items():
            assert any(text in row.words for text in said), (key, row.words)
        if row.urdf is None:
            continue
        named = row.reason.partition("at the rim of the regions of ")[2].partition(":")[0]
        for link in links_at_rim(row.urdf, names, radius):
            assert link in named.split(", "), (row.remedy, link, row.reason)
            checked += 1
    assert checked or name in BALANCED, "no row has matter at a rim: the test checks nothing"


def test_a_lump_at_the_rim_is_noticed():
    lump = (
        '<joint name="j{0}" type="fixed"><origin xyz="{1}"/><parent link="a"/>'
        '<child link="a_counterweight{0}"/></joint>'
    )
    inside, outside = lump.format("", "0.1 0 0"), lump.format("_2", "0 0.3 0")
    for joints, at_rim in ((inside, set()), (inside + outside, {"a"})):
        assert links_at_rim(f"<robot>{joints}</robot>", ["a", "b"], 0.3) == at_rim
