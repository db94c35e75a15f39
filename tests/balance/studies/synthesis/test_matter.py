"""Matter of synthesised four-bars: what is drawn of it is steel, and does not shake."""

from __future__ import annotations

import json
import math
from xml.etree import ElementTree

import numpy as np
import pytest

from balance import synthesize, verify
from balance.app.cli.main import main
from kinematics import load
from kinematics.errors import UsageError
from kinematics.model.document.element import Document

STEEL = 7850.0
PLACES = [(0.3, 0.1, 0.19), (0.1, 0.4, -0.7), (-0.1, 0.5, -1.22)]
WORDS = ["synthesize", "--positions", "0.3,0.1,11; 0.1,0.4,-40; -0.1,0.5,-70"]


def numbers(element, name):
    return np.array(element.get(name).split(), dtype=float)


def plates_of(urdf, thickness):
    """Mass, middle and semi-axes (2, 2) of an elliptic plate for each link with mass."""
    for link in ElementTree.fromstring(urdf).iter("link"):
        inertial = link.find("inertial")
        if inertial is None:
            continue
        mass = float(inertial.find("mass").get("value"))
        word = {key: float(value) for key, value in inertial.find("inertia").attrib.items()}
        across = mass * thickness**2 / 12.0
        # Second moments in the plane: those of the moments of inertia less what is across.
        C = np.array([[word["iyy"], -word["ixy"]], [-word["ixy"], word["ixx"]]])
        C -= across * np.eye(2)
        sigma, axes = np.linalg.eigh(C)
        assert word["izz"] == pytest.approx(word["ixx"] + word["iyy"] - 2.0 * across, rel=1e-4)
        middle = numbers(inertial.find("origin"), "xyz")[:2]
        yield link.get("name"), mass, middle, 2.0 * np.sqrt(sigma / mass) * axes


def drawn(mass, middle, semi):
    """Points of equal mass on an ellipse whose moments are those of the elliptic plate."""
    turns = 2.0 * np.pi * np.arange(8) / 8.0
    circle = np.sqrt(0.5) * np.array([np.cos(turns), np.sin(turns)])
    x, y = middle[:, None] + semi @ circle
    return x + 1j * y, mass / 8.0


@pytest.mark.slow
def test_a_kite_of_steel_plates_fits_and_does_not_shake():
    """Plates are drawn from the file, and moved by the crossing of two circles."""
    synthesis = synthesize(PLACES, kind="four-bar", thickness=0.02)
    best = synthesis.mechanisms[0]
    assert synthesis.verdict == "feasible" and best.numbers["thickness"] == 0.02
    matter = {}
    for name, mass, middle, semi in plates_of(best.urdf, 0.02):
        area = math.pi * abs(np.linalg.det(semi))
        assert mass <= STEEL * area * 0.02 * (1.0 + 1e-6), name
        matter[name] = drawn(mass, middle, semi)
    assert set(matter) == {"crank", "coupler", "rocker"}
    assert 8.0 * matter["coupler"][1] >= 1.0 - 1e-6
    at = best.pivots
    G, H, W, Z = (at[name] for name in ("crank_base", "rocker_base", "crank_tip", "rocker_tip"))
    sense = math.copysign(1.0, ((H - W).conjugate() * (Z - W)).imag)

    def places(turn):
        """All points, from the frames of the file, which are parallel at the first position."""
        A = G + (W - G) * np.exp(1j * turn)
        gap = abs(H - A)
        along = (abs(Z - W) ** 2 - abs(Z - H) ** 2 + gap**2) / (2.0 * gap)
        beside = sense * np.sqrt(abs(Z - W) ** 2 - along**2)
        B = A + (along + 1j * beside) * (H - A) / gap
        turned = {"crank": (A - G) / (W - G), "coupler": (B - A) / (Z - W)}
        turned["rocker"] = (B - H) / (Z - H)
        start = {"crank": G, "coupler": A, "rocker": H}
        return {name: start[name] + turned[name] * matter[name][0] for name in matter}

    step, largest = 1e-5, 0.0
    for turn in np.linspace(*sorted((best.link_turns[0], best.link_turns[-1])), 12):
        before, now, after = (places(turn + k * step) for k in (-1, 0, 1))
        force = moment = force_size = moment_size = 0.0
        for name, (_, mass) in matter.items():
            speed = (after[name] - before[name]) / (2.0 * step)
            spin = (now[name].conjugate() * speed).imag
            force, moment = force + mass * speed.sum(), moment + mass * spin.sum()
            force_size += mass * abs(speed).sum()
            moment_size += mass * abs(spin).sum()
        largest = max(largest, abs(force) / force_size, abs(moment) / moment_size)
    assert largest < 1e-8


@pytest.mark.slow
def test_rotors_and_counterweights_are_plates_that_balance():
    """All that is added is flat about the plane, and Pinocchio finds nothing that shakes."""
    synthesis = synthesize(PLACES, kind="geared-four-bar", thickness=0.03)
    best = synthesis.mechanisms[0]
    linkage = load(Document("geared", best.urdf))
    checked = verify(linkage, trajectories=1)
    assert linkage.mobility == 1 and checked.balanced
    assert max(checked.force_residual, checked.moment_residual) < 1e-10
    added = 0.0
    for name, mass, _, semi in plates_of_added(best.urdf):
        assert mass <= STEEL * math.pi * abs(np.linalg.det(semi)) * 0.03 * (1.0 + 1e-6), name
        added += mass
    assert added == pytest.approx(best.numbers["added_mass"], rel=1e-9)


def plates_of_added(urdf):
    """Those of the links that the synthesis adds."""
    root = ElementTree.fromstring(urdf)
    for link in list(root.iter("link")):
        name = link.get("name")
        if not (name.endswith("_counterweight") or name.endswith("_rotor")):
            root.remove(link)
    yield from plates_of(ElementTree.tostring(root), 0.03)


@pytest.mark.slow
def test_steel_weighs_more_than_points():
    solid, points = (
        synthesize(PLACES, kind="geared-four-bar", density=density).mechanisms[0].numbers
        for density in (STEEL, None)
    )
    assert points["added_mass"] < 0.99 * solid["added_mass"]


def test_what_no_matter_balances_is_undecided(capsys):
    """Few four-bars are tried: that none of them fits does not say that none does."""
    words = [*WORDS, "--kind", "four-bar", "--density", "20", "--thickness", "1mm"]
    assert main([*words, "--json"]) == 4
    answer = json.loads(capsys.readouterr().out)
    assert (answer["verdict"], answer["mechanisms"]) == ("undecided", [])
    assert "no matter of at most 20 kg/m³ in plates 0.001 m thick" in answer["words"]


@pytest.mark.parametrize(
    "options",
    [
        {"density": 2700.0},
        {"thickness": 0.01},
        {"kind": "four-bar", "density": None, "thickness": 0.01},
        {"kind": "four-bar", "density": -1.0},
    ],
)
def test_matter_that_cannot_be_is_refused(options):
    with pytest.raises(UsageError, match="density|thickness"):
        synthesize(PLACES, **options)
