"""``balance verify``: exit codes, the contract of its JSON, motions from tables, pictures."""

from __future__ import annotations

import json
import re
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from jsonschema import Draft202012Validator, ValidationError

import kinematics
from balance.app.answers.html.verification import (
    MAX_LINES,
    panels,
    verification_picture,
)
from balance.app.answers.html.verification_page import verification_page
from balance.app.cli.main import main
from balance.bodies import mass_properties
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.motion.verification.trajectory import random_motions
from balance.motion.verification.verify_motions import verify
from tests.support.command_runs import asked
from tests.support.json_answers import read_schema
from tests.support.laws import altered, off_axis, sums, words
from tests.support.rounded_four_bar import four_bar
from tests.support.verify_command import BALANCED, FEW, SHAKING, run

KEYS = (
    "schema model file at balance balanced tolerance trajectories samples seed inputs duration "
    "amplitude speed length about shaking rms range worst plotted residual inertia "
    "bearing ratio agreement closure remarks warnings against sentence"
).split()


@pytest.mark.slow
def test_exit_codes_tell_the_verdict(capsys, monkeypatch):
    assert main(["verify", BALANCED, *FEW]) == 0
    assert capsys.readouterr().out.splitlines()[-1].split()[:2] == ["verdict", "balanced"]
    assert main(["verify", SHAKING, *FEW]) == 1
    assert "not balanced" in capsys.readouterr().out
    assert main(["verify", SHAKING, *FEW, "--tolerance", "0.99"]) == 0
    assert main(["verify", "three_rsr", *FEW]) == 1
    assert main(["verify", "three_rsr", *FEW, "--motion", "u2=u3"]) == 0
    assert main(["verify", "three_rsr", *FEW, "--balance", "force"]) == 0
    capsys.readouterr()
    monkeypatch.setattr("balance.motion.verification.verification.AGREEMENT_RELATIVE", 0.0)
    assert main(["verify", BALANCED, *FEW]) == 4
    assert "no verdict" in capsys.readouterr().out


def test_json_keeps_its_keys(capsys):
    code, report = run(capsys, SHAKING, "--trajectories", "2", "--seed", "4")
    assert code == 1 and list(report) == KEYS
    assert report["schema"] == "balance.verify/1"
    assert (report["trajectories"], report["samples"], report["seed"]) == (2, 400, 4)
    assert report["balanced"] is False and report["against"] is None
    assert report["agreement"] < 1e-12 and report["closure"] < 1e-12
    assert report["bearing"]["undetermined"] == 3
    assert report["bearing"]["joint"] in ("u1", "q2", "q3", "q4")
    assert report["shaking"]["force"] == pytest.approx(
        report["ratio"]["force"] * report["bearing"]["force"]
    )
    with pytest.raises(ValidationError):
        Draft202012Validator(read_schema("verify")).validate({**report, "surprise": 1})
    same = verify(kinematics.load(SHAKING), trajectories=2, seed=4).to_dict()
    assert {**same, "against": None, "sentence": None} == report


@pytest.mark.parametrize("link", range(3))
def test_one_per_cent_in_the_file_is_noticed(link, tmp_path, capsys):
    linkage = kinematics.load(BALANCED)
    body, z = linkage.bodies[link], mass_parameters(linkage)[link]
    rng = np.random.default_rng(link)
    heavier = mass_properties(z + sums([0.01 * z[0]], [off_axis(linkage, body, rng)]))

    def change(robot):
        (element,) = (x for x in robot.findall("link") if x.get("name") == body.name)
        element.remove(element.find("inertial"))
        inertial = ElementTree.SubElement(element, "inertial")
        frame = np.linalg.inv(body.frame)
        R, inertia = frame[:3, :3], heavier.inertia
        inertia = R @ inertia @ R.T
        centre = R @ heavier.com + frame[:3, 3]
        ElementTree.SubElement(inertial, "origin", xyz=words(centre), rpy="0 0 0")
        ElementTree.SubElement(inertial, "mass", value=repr(float(heavier.mass)))
        entries = {
            f"i{'xyz'[i]}{'xyz'[j]}": repr(float(inertia[i, j]))
            for i in range(3)
            for j in range(i, 3)
        }
        ElementTree.SubElement(inertial, "inertia", entries)

    code, report = run(capsys, str(altered(BALANCED, tmp_path, change)), *FEW)
    assert code == 1 and max(report["residual"].values()) > 1e-5


def test_a_table_drives_the_linkage(tmp_path, capsys):
    path = tmp_path / "motion.csv"
    time = np.linspace(0.0, 2.0, 50)
    rows = "".join(f"{t!r},{float(np.sin(t))!r}\n" for t in time.tolist())
    path.write_text(f"time,u1\n{rows}", encoding="utf-8")
    code, report = run(capsys, BALANCED, "--csv", str(path))
    assert code == 0
    assert (report["trajectories"], report["samples"], report["seed"]) == (1, 50, None)
    code, report = run(capsys, SHAKING, "--csv", str(path), "--against", BALANCED)
    assert code == 1 and report["balanced"] is False
    assert report["against"]["balanced"] is True and report["against"]["seed"] is None
    assert main(["verify", BALANCED, "--csv", str(tmp_path / "none.csv")]) == 3
    assert capsys.readouterr().err.startswith("balance: ")


def test_two_linkages_stand_side_by_side(capsys):
    assert main(["verify", SHAKING, *FEW, "--against", "four_bar_antiparallelogram"]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert re.fullmatch(
        r"Shaking force [\d.]+ → [\d.]+ N peak \(\d+ % less\), moment .* N m peak \(.* more\), "
        rf"from four_bar_antiparallelogram to {SHAKING}\.",
        lines[0],
    )
    assert re.match(rf"linkage +{SHAKING}, dynamic .*four_bar_antiparallelogram, ", lines[2])
    assert lines[-3].split() == "verdict both: not balanced (tolerance 1.0e-09)".split()
    assert re.match("note +both: the linkage is overconstrained", lines[-2])
    assert re.match("note +the moment grows", lines[-1])


def test_notices_on_two_linkages_are_told_once(tmp_path, capsys, caplog):
    """One on both has no file; others follow the name of theirs."""
    link = (
        '<link name="bare"/><joint name="w" type="continuous"><parent link="base"/>'
        '<child link="bare"/><axis xyz="0 0 1"/><mimic joint="u1"/></joint></robot>'
    )
    text = Path(kinematics.load(SHAKING).source).read_text("utf-8")
    for name, changed in (("after", link), ("before", link), ("other", "</robot>")):
        path = tmp_path / f"{name}.urdf"
        path.write_text(text.replace("</robot>", changed), encoding="utf-8")
    pair = [str(tmp_path / "after.urdf"), "--against", str(tmp_path / "before.urdf")]
    assert main(["verify", *pair, *FEW]) == 1
    assert main(["verify", pair[0], "--against", str(tmp_path / "other.urdf"), *FEW]) == 1
    said = [line for line in caplog.messages if line.startswith("massless: ")]
    assert [line.split(": ")[1] for line in said] == ["both", "after.urdf"]


@pytest.mark.slow
def test_both_readings_of_rounded_angles_are_told(tmp_path, capsys, caplog):
    rounded = str(four_bar(tmp_path))
    code, report = run(capsys, rounded, *FEW)
    assert code == 1
    (warning,) = report["warnings"]
    assert warning["code"] == "rounded_angles"
    names = r", the default: 1\.5708 in .*; write all"
    short = ", the default (balance report names them); write all"
    told, count = re.subn(names, short, warning["message"])
    assert count == 1 and f"rounded_angles: {told}" in caplog.messages
    share = report["residual"]["force"]
    assert f"; nominal: not balanced, shaking force {share:.2f} and" in warning["message"]
    assert "; as written: loop 'q3': does not close: " in warning["message"]
    code, report = run(capsys, SHAKING, *FEW, "--against", rounded)
    assert report["warnings"] == [] and len(report["against"]["warnings"]) == 1
    assert main(["verify", rounded, *FEW, "--as-written"]) == 3
    streams = capsys.readouterr()
    assert streams.out == "" and "; nominal: not balanced, shaking" in streams.err


def test_a_missing_library_costs_a_line(monkeypatch, tmp_path, capsys):
    for name, package, option in (
        ("pinocchio", "pin", []),
        ("matplotlib", "matplotlib", ["--plot", str(tmp_path / "a.png")]),
    ):
        with monkeypatch.context() as patch:
            patch.setitem(sys.modules, name, None)
            assert main(["verify", BALANCED, *FEW, *option]) == 2
            streams = capsys.readouterr()
            assert streams.out == "" and streams.err.count("\n") == 1
            assert f"pip install {package}'" in streams.err
            assert main(["report", "four_bar_kite"]) == 0
            capsys.readouterr()
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ["--trajectories", "0"],
        ["--trajectories", "many"],
        ["--seed", "-1"],
        ["--tolerance", "nan"],
        ["--tolerance", "2"],
        ["--plot", "a.gif"],
        [],
    ],
)
def test_usage_errors_exit_with_2(words, capsys):
    model = [BALANCED] if words else []
    assert main(["verify", *model, *words]) == 2
    assert capsys.readouterr().err.startswith("balance verify: error: ")


@pytest.mark.slow
def test_pictures_are_written(tmp_path, capsys):
    image, drawing, page = (tmp_path / f"a.{kind}" for kind in ("png", "svg", "html"))
    pair = ["verify", SHAKING, "--against", BALANCED, *FEW]
    assert main([*pair, "--plot", str(image), "--html", str(page)]) == 1
    assert main([*pair, "--plot", str(drawing)]) == 1
    assert image.read_bytes().startswith(b"\x89PNG\r\n")
    root = ElementTree.fromstring(drawing.read_bytes())
    assert root.tag.endswith("svg")
    text = page.read_text(encoding="utf-8")
    assert "{{" not in text and not re.search(r'(?:src|href)="(?!data:)', text)
    capsys.readouterr()


def test_a_line_of_equal_bearing_forces_names_both_joints():
    """A bar without mass between two joints carries one force through both."""
    z = np.stack([body.inertia for body in kinematics.load("four_bar_general").bodies])
    z[1] = 0.0
    found = verify(kinematics.load("four_bar_general"), z, trajectories=1, samples=20)
    *_, bearing = panels(found)
    assert bearing.names == ("u1", "q2, q3", "q4")


def test_panels_show_what_was_found():
    linkage = kinematics.load("stewart_6ups")
    found = verify(linkage, trajectories=1, samples=20)
    run = found.runs[0]
    inputs, force, moment, bearing = panels(found)
    assert inputs.names == linkage.inputs
    assert np.array_equal(inputs.lines, run.trajectory.u.T)
    # What the linkage does to its base, about the middle of the mechanism.
    o = linkage.spatial_chain.frame.origin
    assert np.array_equal(force.lines, -run.shaking[:, 3:].T)
    about = run.shaking[:, :3] - np.cross(o, run.shaking[:, 3:])
    assert np.allclose(moment.lines, -about.T, rtol=1e-12)
    assert bearing.lines.shape == (MAX_LINES, 20)
    assert bearing.lines.max() == pytest.approx(run.bearing.max(), rel=1e-6)
    # What joints in series carry alike, as the axes of one of them do, is one line.
    lines = bearing.lines / bearing.lines.max()
    assert all(
        np.abs(lines[i] - lines[j]).max() > 1e-6 for i in range(MAX_LINES) for j in range(i)
    )


@pytest.mark.slow
def test_the_page_holds_the_report_and_escapes_names():
    found = verify(kinematics.load(BALANCED), trajectories=1, samples=20)
    hostile = '</script><script>alert("x")</script>'
    found = replace(found, linkage=replace(found.linkage, name=hostile))
    text = verification_page(found, found)
    assert hostile not in text
    (report,) = re.findall(r'id="report">(.*?)</script>', text, re.DOTALL)
    assert json.loads(report) == [found.to_dict()] * 2
    (models,) = re.findall(r'id="models">(.*?)</script>', text, re.DOTALL)
    for drawing in (way["chart"] for model in json.loads(models) for way in model["runs"]):
        # The pivots of a force-balanced four-bar carry the same force: one line for both.
        assert [trace["yaxis"] for trace in drawing["data"]] == [
            "y",
            *["y2"] * 3,
            *["y3"] * 3,
            *["y4"] * 3,
        ]
    assert verification_picture(found) == verification_picture(found)


@pytest.mark.slow
def test_random_motions_reach_as_far_as_their_remark_says():
    """Less than they begin with where loops would not close so far."""
    done = asked(["verify", "delta"])
    reach = "^amplitude +(.*), so that loops close .--csv FILE goes further.$"
    (reach,) = re.findall(reach, done.out, re.MULTILINE)
    assert f"random motions of 1 s, of at most {reach}: " in done.err
    sizes = [abs(each.u).max() for each in random_motions(kinematics.load("delta"))]
    assert reach.startswith(f"u1 {max(sizes):.3g} rad") and max(sizes) < 0.7


def test_a_crank_without_a_motion_is_asked_for_its_speed(capsys, caplog):
    """Random motions swing it; the verdict is the same."""
    linkage = kinematics.load(BALANCED)
    for options, is_asked in (([], True), (FEW, False), (["--seed", "1", *FEW], False)):
        caplog.clear()
        assert main(["verify", BALANCED, *options]) == 0
        moved = f"random motions of 1 s, of at most {linkage.inputs[0]} "
        assert (moved in caplog.text) == is_asked
        assert ("--speed 300rpm" in caplog.text) == is_asked
    capsys.readouterr()


def test_a_bar_appears_when_it_takes_long(monkeypatch, capsys):
    """Not in a notebook, whose kernel sets ``FORCE_COLOR`` and reads a pipe."""
    monkeypatch.setattr("balance.app.cli.progress.BAR_PATIENCE", -1.0)
    monkeypatch.setenv("FORCE_COLOR", "1")
    assert main(["verify", BALANCED, *FEW]) == 0
    assert capsys.readouterr().err == ""
    monkeypatch.setattr("balance.app.cli.progress.os.isatty", lambda _: True)
    assert main(["verify", BALANCED, "--trajectories", "2"]) == 0
    streams = capsys.readouterr()
    assert "motions" in streams.err and "motions" not in streams.out.partition("motions  ")[0]
    monkeypatch.setattr("balance.app.cli.progress.BAR_PATIENCE", 1e9)
    assert main(["verify", BALANCED, *FEW]) == 0
    assert capsys.readouterr().err == ""
