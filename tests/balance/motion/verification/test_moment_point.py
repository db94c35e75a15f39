"""Moments are about one point, which is told: a middle, or --about."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import balance
import kinematics
from balance.app.answers.text.verification import verification_body
from balance.app.cli.main import main
from balance.motion.flexible.flex_data import moment_about
from tests.support.verify_command import FEW, run

MODEL = "four_bar_general"
WHEEL = """
  <link name="wheel"><inertial><mass value="1e-12"/>
    <inertia ixx="1e-14" iyy="1e-14" izz="1e-14" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="w" type="continuous"><origin xyz="10 0 0"/><parent link="base"/>
    <child link="wheel"/><axis xyz="0 0 1"/><mimic joint="u1" multiplier="1"/></joint>
</robot>"""


@pytest.fixture
def with_far_wheel(tmp_path):
    """The same linkage with a disc of 1e-12 kg ten metres away."""
    text = Path(kinematics.load(MODEL).source).read_text("utf-8")
    path = tmp_path / "far.urdf"
    path.write_text(text.replace("</robot>", WHEEL), encoding="utf-8")
    return str(path)


def test_a_far_disc_without_mass_does_not_change_the_ratio(with_far_wheel, capsys):
    """Each moment was about a middle of its own: 20.2 times as much in issue 38."""
    _, found = run(capsys, MODEL, *FEW, "--against", with_far_wheel)
    other = found["against"]
    assert other["about"] == found["about"]
    assert other["shaking"]["moment"] == pytest.approx(found["shaking"]["moment"], rel=1e-6)
    assert main(["verify", MODEL, *FEW, "--against", with_far_wheel]) == 1
    text = capsys.readouterr().out
    assert re.search(r"moment ([\d.]+) → \1 N m peak \(unchanged\)", text)
    assert "\nabout " in text


def test_against_is_about_the_middle_of_the_linkage_before(with_far_wheel, capsys):
    """The moment before is that of its own verification, however large the other one is."""
    _, alone = run(capsys, MODEL, *FEW)
    _, found = run(capsys, with_far_wheel, *FEW, "--against", MODEL)
    assert found["about"] == found["against"]["about"] == alone["about"]
    assert found["against"]["shaking"]["moment"] == pytest.approx(
        alone["shaking"]["moment"], rel=1e-9
    )
    pair = balance.motion.verify_against(with_far_wheel, MODEL, trajectories=1)
    assert pair.after.point.tolist() == pair.before.point.tolist() == alone["about"]


def test_the_sentence_says_which_loads_are_cancelled(tmp_path):
    """It does not contradict the verdict: weights against the force raise the moment."""
    path = tmp_path / "weights.urdf"
    links = ["crank", "rocker"]
    balance.counterweights(MODEL, links, balance="force", density=None).to_urdf(path)

    def against(after, before, **options):
        return balance.motion.verify_against(after, before, trajectories=1, **options)

    pair = against(path, MODEL)
    assert pair.sentence.endswith(": the force is cancelled, the moment is not.")
    assert pair.after.verdict == "not balanced" and not against(MODEL, MODEL).after.outcome
    forces = against(path, MODEL, balance="force")
    assert forces.sentence.endswith(": the force is cancelled, the moment does not count.")
    assert forces.after.verdict == "forces balanced"
    kite = against("four_bar_kite_balanced", "four_bar_kite")
    assert kite.sentence.endswith(": no shaking is left.") and kite.after.balanced
    text = verification_body([pair.after, pair.before])
    rows = {row[0]: row[1:] for row in text[2].rows}
    assert rows["verdict"][0].startswith(
        "not balanced: the force is cancelled, the moment is not"
    )
    assert rows["verdict"][1].startswith("not balanced (tolerance")


def test_several_models_have_one_point(with_far_wheel, capsys):
    main(["verify", MODEL, with_far_wheel, *FEW, "--json"])
    assert len(set(_points(capsys.readouterr().out))) == 1


def _points(text):
    """The points in a JSON of several verifications, as texts."""
    import json

    return [json.dumps(one["about"]) for one in json.loads(text)["results"]]


def test_moments_about_a_point(capsys):
    """M - r × F of the wrench about the inertial origin, by our own series."""
    point = np.array([1.0, -2.0, 0.5])
    linkage = kinematics.load("bennett")
    found = balance.verify(linkage, trajectories=1, about=point)
    (motion,) = found.runs
    way = motion.trajectory
    wrench = balance.motion.shaking(linkage, way.u, way.ud, way.udd)
    moment = np.linalg.norm(wrench[:, :3] - np.cross(point, wrench[:, 3:]), axis=1).max()
    assert found.moment == pytest.approx(moment, rel=1e-9)
    plain = balance.verify(linkage, trajectories=1)
    assert found.moment_residual == plain.moment_residual and found.verdict == plain.verdict
    _, answer = run(capsys, "bennett", *FEW, "--about", "1,-2,0.5")
    assert answer["about"] == point.tolist()
    assert answer["shaking"]["moment"] == pytest.approx(moment, rel=1e-9)


def test_partial_balance_about_a_point():
    linkage = kinematics.load(MODEL)
    point = [0.3, 0.8, 0.0]
    way = [run.trajectory for run in balance.verify(linkage, trajectories=1).runs]
    seen = balance.verify(linkage, motions=way, about=point)
    found = balance.partial(linkage, ["crank"], 0.1, motions=way, about=point)
    assert found.given.moment == pytest.approx(seen.runs[0].rms("moment"), rel=1e-9)
    assert found.given.peak_moment == pytest.approx(seen.moment, rel=1e-9)


def test_flexible_links_about_a_point():
    words = ("four_bar_kite", ["coupler=EI:50,rhoA:1"], {"u1": "spin:1,0.1"}, 0.02)
    found = balance.flexible.simulate_flexible(*words, samples=5, about=[0.2, -0.3, 7.0])
    assert np.allclose(found.moment, moment_about(found.motion, np.array([0.2, -0.3])))


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["verify", MODEL, "--about", "1,2"], "is not"),
        (["verify", MODEL, "--base", "free", "--base-mass", "1", "--base-inertia", "1",
          "--about", "0,0,0"], "--about: not with --base"),
        (["design", MODEL, "--about", "0,0,0"], "unrecognized"),
        (["reduce", MODEL, "--links", "crank", "--budget", "1", "--about", "0,0,0", "--frame",
          "50,4,2e5,100"], "--about: not with --frame"),
    ],
)  # fmt: skip
def test_points_that_do_not_fit_are_refused(words, problem, capsys):
    assert main(words) == 2
    assert problem in capsys.readouterr().err
