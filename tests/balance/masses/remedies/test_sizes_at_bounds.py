"""No size at a bound without a word of it, in all rows of nine models.

Where matter lies is read from the files alone: what a link has gained, and its centre.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

import kinematics
from balance.masses.remedies.compare import compare_request
from balance.masses.remedies.request import RemedyRequest
from kinematics.loading.model_gallery import as_linkage

MODELS = (
    "four_bar_general",
    "slider_crank",
    "double_pendulum",
    "five_bar",
    "four_bar_kite",
    "four_bar_parallelogram",
    "four_bar_antiparallelogram",
    "principal_vector_linkage",
    "zero_reaction_arm",
)
# What a row says of a size that is one of these.
SIZED = {
    "with wheels of": ("a bound",),
    "with levers of": ("a bound", "not sought"),
    "counter-arm of": ("bounds:",),
    "as large": ("a bound:",),
    "rotor radius": ("a bound",),
}
AT_RIM, SMALLEST = 0.999, 1e-6


def first_moments(urdf):
    """Mass and first moment ``[m; m c]`` of each link, in its own frame."""
    moments = {}
    for link in ElementTree.fromstring(urdf).findall("link"):
        if (inertial := link.find("inertial")) is not None:
            origin = inertial.find("origin")
            text = "0 0 0" if origin is None else origin.get("xyz", "0 0 0")
            mass = float(inertial.find("mass").get("value"))
            moments[link.get("name")] = mass * np.array([1.0, *map(float, text.split())])
    return moments


def links_at_rim(before, after, radius):
    """Links of which all that they gained has its centre at the rim of a ball at the frame."""
    at_rim = []
    for name, moment in before.items():
        gained = after.get(name, moment) - moment
        if gained[0] > SMALLEST * moment[0]:
            reach = np.linalg.norm(gained[1:] / gained[0]) / radius
            assert reach < 1.0 + 1e-6, f"{name} has matter outside its region"
            at_rim += [name] * (reach > AT_RIM)
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
    before, checked = first_moments(kinematics.gallery()[name].read_bytes()), 0
    for row in comparison.results:
        for key, said in sized_parts(row.words).items():
            assert any(text in row.words for text in said), (key, row.words)
        if row.urdf is None:
            continue
        _, _, rim = row.reason.partition("at the rim of the regions of ")
        for link in links_at_rim(before, first_moments(row.urdf), radius):
            named = rim.partition(":")[0].split(", ")
            assert link in named, (row.remedy, link, row.reason)
            checked += 1
    print(name, len(comparison.results), "rows,", checked, "links at a rim")


def test_a_centre_at_the_rim_is_noticed():
    before = {"a": np.array([1.0, 0.0, 0.0, 0.0]), "b": np.array([1.0, 0.5, 0.0, 0.0])}
    after = {
        "a": before["a"] + 2.0 * np.array([1.0, 0.0, 0.3, 0.0]),
        "b": before["b"] + [1.0, 0.1, 0.0, 0.0],
    }
    assert links_at_rim(before, after, 0.3) == ["a"]
