"""What is proposed where no shapes in the regions balance: thicker plates, room, links."""

import json
import re
import shlex

import numpy as np
import pytest
from scipy.optimize import brentq

import balance
from tests.support.command_runs import asked

STEEL = 7850.0
NEEDED = 0.05  # kg m, what the link of the fixture arm needs on its other side


@pytest.fixture
def five_bar(tmp_path):
    """A symmetric five-bar of flat bars, whose default regions are too small for discs."""
    path = tmp_path / "five_bar.urdf"
    points = "A=0,0; B=500mm,0; C=A+200mm@120deg; D=B+200mm@60deg; E=C:400mm,D:400mm"
    links = "left_crank=A,C; left_arm=C,E; right_crank=B,D; right_arm=D,E"
    made = asked(
        ["new", str(path), "--points", points, "--links", links]
        + ["--section", "25mmx8mm", "--density", "steel"]
    )
    assert made.code == 0
    return path


def preferred(least):
    """The next number of the series R''10."""
    series = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
    return min(x for k in range(-4, 2) for n in series if (x := n * 10.0**k) >= least)


def test_sectors_that_are_too_thin_say_how_thick_they_must_be(arm):
    space, region = balance.design_space(arm, balance="force"), {"l1": "ball(0,0,0,0.12)"}
    answer = balance.counterweights(space, ["l1"], region, shape="sector=0.005,0.1")
    least = NEEDED / (2.0 / 3.0 * STEEL * 0.1**3)
    assert answer.verdict == "infeasible" and answer.z is None and answer.check.accepted
    (change,) = answer.relaxations
    thickness = preferred(least)
    assert change.shape == f"sector={1e3 * thickness:g}mm,100mm" and not change.regions
    assert f"; {change.shape} would do (" in answer.words
    thicker = balance.counterweights(space, ["l1"], region, shape=change.shape)
    assert thicker.verdict == "feasible"
    assert thicker.added_mass == pytest.approx(change.mass, rel=1e-9)


@pytest.mark.table(2)
@pytest.mark.parametrize("shape", ["disc=0.02", "block=0.02"])
def test_the_region_that_is_proposed_is_the_least_of_the_textbook(shape, arm):
    """Of half size a, ``p a²`` kg, at the rim of a circle of radius R about (-c, 0)."""
    space = balance.design_space(arm, balance="force")
    given = {"l1": "box(-0.1:0,-0.03:0.03,-0.01:0.01)"}
    answer = balance.counterweights(space, ["l1"], given, density=STEEL, shape=shape)
    larger = next(change for change in answer.relaxations if change.regions)
    disc = shape.startswith("disc")
    per = STEEL * 0.02 * (np.pi if disc else 4.0)

    def most(R):
        a = np.linspace(0.0, R if disc else R / np.sqrt(2.0), 20001)
        outwards = R - a if disc else np.sqrt(R * R - a * a) - a
        return (per * a * a * (0.05 + outwards)).max()

    least = brentq(lambda R: most(R) - NEEDED, 0.01, 0.3)
    radius = preferred(max(least, 0.05 * (1.0 + 1e-9)))
    assert larger.regions == {"l1": f"cylinder(-0.05,0,0,0,0,1,{radius:g},0.02)"}
    tried = balance.counterweights(
        space, ["l1"], larger.regions, density=STEEL, shape=shape, relax=False
    )
    assert tried.verdict == "feasible"
    assert tried.added_mass == pytest.approx(larger.mass, rel=1e-9)


@pytest.mark.slow
def test_discs_that_no_region_helps_name_the_link_that_does():
    """The crank alone cannot balance a four-bar: discs on crank and rocker do."""
    space = balance.design_space("four_bar_general", balance="force")
    none = balance.counterweights(space, ["crank"], shape="disc=0.02")
    assert none.verdict == "infeasible" and not none.depends_on_regions
    assert "in these regions" not in none.sentence
    (change,) = none.relaxations
    assert change.links == ("rocker",) and "adding matter to 'rocker' too" in none.words
    both = balance.counterweights(space, ["crank", "rocker"], shape="disc=0.02")
    assert both.added_mass == pytest.approx(change.mass, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "shape", ["sector=20mm", "sector=20mm,90mm", "disc=20mm", "cylinder=40mm"]
)
def test_the_command_that_is_proposed_balances(shape, five_bar):
    command = f"counterweights {five_bar} --balance force --links all"
    words = f"{command} --shape {shape} --parts made --out balanced.urdf"
    unbalanced = asked(shlex.split(words))
    assert unbalanced.code == (4 if shape.startswith("cylinder") else 1)
    proposed = shlex.split(re.search(r"^Next: balance (.*)$", unbalanced.out, re.MULTILINE)[1])
    assert not {"--out", "--parts"} & set(proposed)
    data = json.loads(asked([*shlex.split(f"{command} --shape {shape}"), "--json"]).out)
    told = [change["mass"] for change in data["relaxations"]]
    assert not re.search("cylinder[(]|ball[(]", " ".join(proposed))
    answer = asked(proposed)
    assert answer.code == 0
    added = float(re.search(r"^added +([\d.]+) kg", answer.out, re.MULTILINE)[1])
    assert added in [pytest.approx(mass, rel=1e-3) for mass in told]
