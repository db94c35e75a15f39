"""Loops that are far open: the nearest pose, the branch that starting values choose, errors."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from balance.motion.verification.trajectory import random_motions
from kinematics.closure.assembly.nearest_pose import motion_weights
from kinematics.closure.joint_positions import joint_positions
from kinematics.closure.mobility.components import split_components
from kinematics.errors import CoordinateError, OpenLoopError, PoseError
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.files.urdf.write_closed_pose import write_at_reference_pose
from tests.independent.nearest_closed import Search, cases, compare, opened
from tests.support.covering import number_of_cases
from tests.support.laws import altered, posed

# Loops so far open that Newton's method alone does not decide.
FAR = {"u1": -0.9, "q2": -1.0, "q4": 0.9}


def positions(linkage):
    """Positions of all joints from the pose of the file, by name."""
    return dict(zip((j.name for j in linkage.joints), linkage.displaced, strict=True))


def opened_pantograph(folder):
    """A file between two branches."""
    source = kinematics.gallery()["pantograph"]
    return opened(source, folder / "pantograph.urdf", np.random.default_rng(2))


def codes(linkage):
    return {notice.code for notice in linkage.notices}


@pytest.mark.slow
def test_the_nearest_branch_is_taken(tmp_path):
    """By an exhaustive search in arrays of its own; three or six linkages of eight families."""
    found = []
    for path, seed in cases(tmp_path, 3):
        case = compare(path, seed, 60)
        found += [] if case is None else [case]
        if len(found) == number_of_cases(3, 6):
            break
    assert all(case.branches > 1 for case in found)
    assert [case.name for case in found if not case.right] == []


@pytest.mark.parametrize("name", ["four_bar_general", "delta"])
def test_the_motion_is_that_of_its_definition(name):
    """Two programs for the distances of what joints carry."""
    draft = read_unassembled(kinematics.gallery()[name])
    (part,) = split_components(draft)
    search = Search(draft)
    np.testing.assert_allclose(
        motion_weights(part) * part.chain.units / search.units, search.weights, rtol=1e-9
    )


def test_nearly_closed_files_are_closed_by_newton_steps_alone(tmp_path, monkeypatch):
    import kinematics.closure.assembly.close_loops as module

    monkeypatch.setattr(module, "closed_poses", None)
    path = altered("four_bar_general", tmp_path, posed({"u1": 0.02, "q2": -0.02}))
    linkage = kinematics.load(path)
    assert "assembled" in codes(linkage) and linkage.other_poses == ()


def test_other_poses_close_the_loops(tmp_path):
    linkage = kinematics.load(opened_pantograph(tmp_path))
    assert linkage.other_poses
    for q in linkage.other_poses:
        joint_positions(linkage, q - linkage.displaced)  # refused unless they close the loops
        assert np.abs(q - linkage.displaced).max() > 0.2


# --- branches that differ -----------------------------------------------------------------


def test_branches_of_another_rank_are_told_and_reached(tmp_path, capsys):
    """A pantograph has a parallelogram, unless it closes as an antiparallelogram."""
    path = opened_pantograph(tmp_path)
    assert main(["report", str(path), "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    (text,) = (w["message"] for w in report["warnings"] if w["code"] == "other_branch")
    assert f"needs {report['rank']} conditions" in text
    words = [part.split()[0] for part in text.split("--at ")[1:]]
    other = int(text.split("another one nearby ")[1].split(":")[0])
    for at, rank in zip(words, (report["rank"], other), strict=True):
        assert main(["report", str(path), "--json", "--at", at]) == 0
        assert json.loads(capsys.readouterr().out)["rank"] == rank
    assert report["rank"] != other


# --- starting values ----------------------------------------------------------------------


def test_a_passive_joint_chooses_the_branch():
    """The rocker on the other side of the same crank: where the bars have their lengths."""
    home = kinematics.load("four_bar_general")
    there = kinematics.load("four_bar_general", at={"q4": -2.5})
    q = positions(there)
    assert there.at == {"u1": 0.0} and q["u1"] == 0.0
    assert abs(q["q4"]) > 1.0
    joint_positions(home, there.displaced)
    (notice,) = (n.message for n in there.notices if n.code == "starting_values")
    within = np.remainder(q["q4"] + np.pi, 2 * np.pi) - np.pi
    assert f"'q4' is at {within:.6g} rad" in notice
    assert f"{np.remainder(q['q4'] + 2.5 + np.pi, 2 * np.pi) - np.pi:.3g} rad from" in notice


def test_starting_values_that_close_the_loops_stay():
    """No notice where the joint ends where it was put; inputs are kept exactly."""
    there = kinematics.load("four_bar_general", at={"u1": 0.3})
    again = kinematics.load("four_bar_general", at={"u1": 0.3, "q4": positions(there)["q4"]})
    np.testing.assert_allclose(again.displaced, there.displaced, atol=1e-12)
    assert again.at == {"u1": 0.3} and "starting_values" not in codes(again)


def test_starting_values_guide_the_closing_of_an_open_file(tmp_path):
    path = altered("four_bar_general", tmp_path, posed(FAR))
    linkage = kinematics.load(path)
    for q in linkage.other_poses:
        tree = [j for j, joint in enumerate(linkage.joints) if not joint.in_loop]
        at = {linkage.joints[j].name: float(q[j]) for j in tree}
        there = kinematics.load(path, at=at)
        turned = (there.displaced - q)[tree] / (2 * np.pi)
        np.testing.assert_allclose(turned, np.rint(turned), atol=1e-9)


def test_a_branch_survives_in_the_written_file(tmp_path, capsys):
    out = tmp_path / "out.urdf"
    words = ["report", "four_bar_general", "--at", "q4=-2.5", "--json"]
    assert main([*words, "--write-closed", str(out)]) == 0
    first = json.loads(capsys.readouterr().out)
    assert main(["report", str(out), "--json"]) == 0
    second = json.loads(capsys.readouterr().out)
    assert [o["rank"] for o in first["orders"]] == [o["rank"] for o in second["orders"]]
    one = kinematics.load("four_bar_general", at={"q4": -2.5})
    other = kinematics.load(out)
    assert other.displaced is None
    for link, place in one.places.items():
        np.testing.assert_allclose(place.pose, other.places[link].pose, atol=1e-12)


def test_inputs_and_a_starting_value_set_a_pose():
    there = kinematics.load("five_bar", at={"u1": 0.2, "u2": -0.1, "q3": 0.4})
    assert there.at == {"u1": 0.2, "u2": -0.1}
    joint_positions(kinematics.load("five_bar"), there.displaced)


def test_names_and_poses_that_cannot_be():
    with pytest.raises(CoordinateError, match="no such joint; the closest are"):
        kinematics.load("four_bar_general", at={"q9": 1.0})
    with pytest.raises(PoseError, match="do not close at q4=3"):
        kinematics.load("four_bar_kite", inputs=["q4"], at={"q4": 3.0, "u1": 0.1})


# --- numbers that overflow ----------------------------------------------------------------


@pytest.mark.parametrize("name", ["svd", "lstsq", "solve"])
def test_a_decomposition_that_does_not_converge_does_not_close(
    name, tmp_path, monkeypatch, capsys
):
    path = altered("four_bar_general", tmp_path, posed(FAR))

    def fail(*_, **__):
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr(np.linalg, name, fail)
    with pytest.raises(OpenLoopError, match="does not close"):
        kinematics.load(path)
    assert main(["report", str(path), "--json"]) == 3
    streams = capsys.readouterr()
    assert streams.out == "" and len(streams.err.splitlines()) == 1


def test_one_start_that_overflows_leaves_the_others(tmp_path, monkeypatch):
    """Newton's method fails at its first step; damped steps still close the loops."""
    path, count = altered("four_bar_general", tmp_path, posed(FAR)), []
    lstsq = np.linalg.lstsq

    def fail_once(*arguments, **options):
        count.append(1)
        if len(count) == 1:
            raise np.linalg.LinAlgError("SVD did not converge in Linear Least Squares")
        return lstsq(*arguments, **options)

    monkeypatch.setattr(np.linalg, "lstsq", fail_once)
    assert "assembled" in codes(kinematics.load(path))


# --- motions ------------------------------------------------------------------------------


@pytest.mark.slow
def test_motions_are_found_where_the_inputs_are_nearly_singular(tmp_path):
    """A rocker near its dead centre drives the crank: it turns hardly, the others much."""
    home = kinematics.load("four_bar_general")
    best, at = 0.0, 0.0
    for angle in np.linspace(-2.5, 2.5, 201):  # where the rocker is slowest
        try:
            q = joint_positions(home, {"u1": float(angle)})
            ahead = joint_positions(home, {"u1": float(angle) + 1e-5})
        except PoseError:
            continue
        ratio = 1e-5 / max(abs(ahead[2] - q[2]), 1e-12)
        if best < ratio < 1e4:
            best, at = ratio, float(angle)
    path = tmp_path / "dead.urdf"
    path.write_bytes(
        write_at_reference_pose(kinematics.load("four_bar_general", at={"u1": at})).data
    )
    linkage = kinematics.load(Path(path), inputs=["q4"])
    assert best > 30.0
    (motion,) = random_motions(linkage, 1, 50)
    assert motion.moves and motion.closure < 1e-9
