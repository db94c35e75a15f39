"""Counterweights of any shape lead to plates that a workshop cuts, and say where they are."""

import re
import shlex
from xml.etree import ElementTree

import numpy as np
import pytest

import balance
from balance.app.answers.text.counterweights import PLATES
from balance.masses.counterweights.shaped.propose_shape import propose_shape
from tests.support.command_runs import asked


@pytest.fixture
def five_bar(tmp_path):
    """A symmetric five-bar of flat bars, in whose default regions no sectors balance."""
    path = tmp_path / "five_bar.urdf"
    points = "A=0,0; B=400mm,0; C=A+250mm@120deg; D=B+250mm@60deg; E=C:350mm,D:350mm"
    links = "left_crank=A,C; left_arm=C,E; right_crank=B,D; right_arm=D,E"
    words = ["new", str(path), "--points", points, "--links", links]
    assert asked([*words, "--section", "30mmx10mm", "--density", "aluminium"]).code == 0
    return str(path)


@pytest.mark.slow
def test_the_plates_that_come_next_balance_and_are_joined_to_their_links(five_bar, tmp_path):
    command = f"counterweights {five_bar} --balance force --links all"
    least = asked(shlex.split(command))
    (proposed,) = re.findall(r"^Next, as plates to cut: balance (.*)$", least.out, re.MULTILINE)
    assert proposed.startswith(command) and not re.search("cylinder[(]|ball[(]", proposed)
    plates = asked([*shlex.split(proposed), "--parts", str(tmp_path / "parts")])
    told = (tmp_path / "parts" / "README.txt").read_text()
    assert "layer a\npart is in, and whether it collides" in told
    assert plates.code == 0 and "Next" not in plates.out and PLATES not in plates.out
    assert len(re.findall("fills 100 % of a", plates.out)) == 4
    assert not re.search("^(arm|sliver) ", plates.out, re.MULTILINE)
    added = [
        float(re.search(r"^added +([\d.]+) kg", answer.out, re.MULTILINE)[1])
        for answer in (least, plates)
    ]
    assert added[0] < added[1] < 2.0 * added[0]


@pytest.mark.slow
def test_shapes_are_only_an_option_where_none_was_tried():
    words = ["counterweights", "six_bar_watt", "--balance", "force", "--links", "all"]
    many = asked(words)
    assert many.code == 0 and "Next" not in many.out and PLATES in many.out
    plates = asked([*words, "--thickness", "20mm"])
    points = asked([*words, "--points"])
    assert PLATES not in plates.out and PLATES not in points.out


@pytest.mark.slow
@pytest.mark.parametrize(
    "wishes",
    [
        {"shape": "sector=20mm"},
        {"density": None},
        {"thickness": 0.02},
        {"minimise": "rotor"},
        {"move": {"crank": 1.0}},
        {"regions": {"crank": "box(-0.3:0.1,-0.3:-0.1,-0.1:0.1)"}},
    ],
)
def test_no_plates_are_proposed_that_cannot_be_asked_for_or_float(wishes):
    space = balance.design_space("four_bar_general", balance="force")
    assert propose_shape(balance.counterweights(space, ["crank", "rocker"])) is not None
    answer = balance.counterweights(space, ["crank", "rocker"], **wishes)
    assert answer.verdict == "feasible" and propose_shape(answer) is None


def places(text):
    """The words of the line ``place`` on each link, by its name."""
    line = re.search("^place +centre of mass (.*)$", text, re.MULTILINE)[1]
    return {re.search("'(.*)'", words)[1]: words for words in line.split("; ")}


@pytest.mark.slow
def test_places_are_those_of_the_file(tmp_path):
    """Frames of links are at the joints that carry them: angles by atan2 of their origins."""
    made = tmp_path / "made.urdf"
    words = ["counterweights", "four_bar_general", "--balance", "force", "--links", "all"]
    text = asked([*words, "--region", "all=0.4", "--out", str(made)]).out
    robot = ElementTree.parse(made).getroot()
    origins = {
        (joint.find("parent").get("link"), joint.get("name")): np.array(
            joint.find("origin").get("xyz").split(), float
        )
        for joint in robot.iter("joint")
    }
    assert {*places(text)} >= {"crank", "rocker"}
    for link, words in places(text).items():
        weight = origins[link, f"{link}_counterweight_joint"]
        size = float(re.match(r"([\d.]+) mm from ", words)[1])
        assert size == pytest.approx(1e3 * np.linalg.norm(weight), rel=1e-3)
        direction = float(re.search(r"at (\S+)° of its frame", words)[1])
        assert direction == pytest.approx(np.degrees(np.arctan2(*weight[1::-1])), abs=0.1)
        for angle, name in re.findall(r", ([\d.]+)° from (\w+)", words):
            if (link, name) in origins:
                joint = origins[link, name]
                cosine = weight @ joint / np.linalg.norm(weight) / np.linalg.norm(joint)
                assert float(angle) == pytest.approx(np.degrees(np.arccos(cosine)), abs=0.1)


@pytest.mark.slow
def test_a_weight_in_line_with_a_joint_is_opposite_to_it(five_bar):
    """The mass of each link is on the line of its joints: so is what balances it."""
    words = ["counterweights", five_bar, "--balance", "force", "--links", "all"]
    said = places(asked(words).out)
    ends = {"left_crank": "A C", "left_arm": "C E", "right_crank": "B D", "right_arm": "D E"}
    for link, joints in ends.items():
        carrying, other = joints.split()
        assert re.fullmatch(
            rf"[\d.]+ mm from {carrying} on '{link}', opposite {other}", said[link]
        )
    reduced = asked(["reduce", *words[1:], "--shape", "disc=20mm", "--budget", "1kg"])
    assert {*places(reduced.out)} <= {*ends}
