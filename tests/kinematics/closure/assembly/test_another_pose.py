"""Another reference pose (``--at``): the answers of the file that is written at that pose."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance import certify, design_space
from balance.app.cli.main import main
from balance.checks import exact_ranks
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import CoordinateError, PoseError
from kinematics.files.urdf.write_closed_pose import write_at_reference_pose
from tests.support.chains import jointed, robot, written
from tests.support.json_answers import json_answer
from tests.support.laws import altered
from tests.support.rounded_four_bar import four_bar

# Poses that no digits of the file are behind, planar and spatial, with one input or several.
POSES = {
    "four_bar_general": {"u1": 0.3},
    "four_bar_kite": {"u1": -0.2},
    "slider_crank": {"u1": 0.3},
    "five_bar": {"u1": 0.25, "u2": -0.4},
    "three_rrr": {"u1": 0.1, "u3": -0.15},
    "six_bar_watt": {"u1": 0.2},
    "bennett": {"u1": 0.4},
    "three_rsr": {"u1": 0.05, "u2": -0.1, "u3": 0.07},
    "hprs": {"helical": 0.5, "prismatic": 0.2, "revolute": -0.9},
    "stewart_6ups": {"slide1": 0.02, "slide4": -0.03},
}


def written_at(name, at, folder):
    """The linkage at a pose, and the path of its file written at that pose."""
    linkage = kinematics.load(name, at=at)
    path = folder / "posed.urdf"
    path.write_bytes(write_at_reference_pose(linkage).data)
    return linkage, path


@pytest.mark.parametrize("name", POSES)
def test_it_is_the_linkage_of_the_file_at_that_pose(name, tmp_path):
    linkage, path = written_at(name, POSES[name], tmp_path)
    other = kinematics.load(path, inputs=linkage.inputs)
    assert other.at is None and other.displaced is None
    for ours, theirs in zip(linkage.joints, other.joints, strict=True):
        # Joints of a loop of several degrees are laid along axes of its frame, where it is.
        if not (ours.in_loop and ours.numbered):
            np.testing.assert_allclose(ours.screw, theirs.screw, atol=1e-12)
    for ours, theirs in zip(linkage.bodies, other.bodies, strict=True):
        np.testing.assert_allclose(ours.inertia, theirs.inertia, atol=1e-11)
    for link, place in linkage.places.items():
        np.testing.assert_allclose(place.pose, other.places[link].pose, atol=1e-12)


@pytest.mark.parametrize("name", POSES)
def test_inputs_stand_where_they_were_put(name):
    """Counted from the pose of the file, those not named at zero; the loops are closed."""
    linkage, home = kinematics.load(name, at=POSES[name]), kinematics.load(name)
    assert linkage.inputs == home.inputs and tuple(linkage.at) == home.inputs
    for name_, value in linkage.at.items():
        assert value == POSES[name].get(name_, 0.0)
    here = dict(zip((j.name for j in linkage.joints), linkage.displaced, strict=True))
    assert [here[x] for x in linkage.inputs] == pytest.approx([*linkage.at.values()], abs=1e-14)
    # Positions of all joints are accepted only if they close the loops.
    joint_positions(home, linkage.displaced)


def test_a_mimic_joint_follows_by_its_ratio(tmp_path):
    """Its offset belongs to the pose of the file, from which displacements count."""
    mimic = '<mimic joint="j1" multiplier="-2" offset="0.4"/>'
    text = robot(jointed(1, "0 0 0"), jointed(2, "0.3 0 0", mimic))
    linkage = kinematics.load(written(tmp_path, text), at={"j1": 0.25})
    np.testing.assert_allclose(linkage.displaced, [0.25, -0.5], atol=1e-15)


def test_the_crank_has_turned_by_the_angle():
    """By the plain rotation of its frame, and the inertia of a link that is elsewhere."""
    home, there = (kinematics.load("four_bar_general", at=at) for at in (None, {"u1": 0.3}))
    c, s = np.cos(0.3), np.sin(0.3)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    ours, theirs = there.bodies[0], home.bodies[0]
    np.testing.assert_allclose(ours.frame[:3, :3], turn @ theirs.frame[:3, :3], atol=1e-15)
    pivot = home.joints[0].point
    centre = turn @ (theirs.inertia[1:4] / theirs.inertia[0] - pivot) + pivot
    np.testing.assert_allclose(ours.inertia[1:4] / ours.inertia[0], centre, atol=1e-14)


@pytest.mark.table(1)
@pytest.mark.parametrize("name", ["four_bar_general", "five_bar", "three_rsr"])
def test_poses_add_up(name, tmp_path):
    """Of a file at one pose, another pose is the sum of both."""
    half = {key: 0.5 * value for key, value in POSES[name].items()}
    linkage, path = written_at(name, half, tmp_path)
    twice = kinematics.load(path, inputs=linkage.inputs, at=half)
    whole = kinematics.load(name, at=POSES[name])
    for link, place in twice.places.items():
        np.testing.assert_allclose(place.pose, whole.places[link].pose, atol=1e-11)


@pytest.mark.slow
@pytest.mark.table
@pytest.mark.parametrize("name", POSES)
def test_the_space_is_that_of_the_written_file(name, tmp_path):
    linkage, path = written_at(name, POSES[name], tmp_path)
    space = certify(design_space(linkage))
    other = certify(design_space(kinematics.load(path, inputs=linkage.inputs)))
    assert space.differences(other) == ()
    assert space.orders == other.orders
    assert not space.certainty.doubts
    assert space.certainty.level == other.certainty.level != "estimated"


@pytest.mark.parametrize("name", ["four_bar_general", "five_bar", "six_bar_watt"])
def test_exact_ranks_at_a_pose_that_is_not_rational(name):
    """Those of the pose of the file, since both are generic, and every number is told of."""
    home, there = kinematics.load(name), kinematics.load(name, at=POSES[name])
    exact = exact_ranks(there, max_order=6)
    assert exact.ranks == exact_ranks(home, max_order=6).ranks
    told = [n.message for n in exact.notices if n.code == "not_exact"]
    assert any("'u1': placed by Newton's method at" in text for text in told)


def test_an_open_file_counts_from_its_own_pose(tmp_path):
    """Coordinates are not counted from the pose at which its loops were closed."""

    def opened(tree):
        origin = tree.find("joint[@name='u1']/origin")
        origin.set("rpy", "0 0 0.02")

    path = altered("four_bar_general", tmp_path, opened)
    closed = kinematics.load(path)
    (u1,) = closed.displaced[closed.positions_of(["u1"])]
    assert abs(u1) > 1e-4
    same = kinematics.load(path, at={"u1": float(u1)})
    np.testing.assert_allclose(same.displaced, closed.displaced, atol=1e-12)
    there = kinematics.load(path, at={"u1": 0.1})
    assert there.displaced[0] == pytest.approx(0.1, abs=1e-14)
    assert kinematics.load(path, at={"u1": 0.0}).displaced[0] == pytest.approx(0.0, abs=1e-14)


def run(capsys, *words):
    """Exit code and JSON of a command."""
    return json_answer(capsys, *map(str, words))


def test_the_command_reports_the_pose_and_writes_its_file(tmp_path, capsys):
    path = tmp_path / "posed.urdf"
    words = ["report", "five_bar", "--at", "u1=0.25,u2=-0.4", "--inputs", "u1,u2"]
    code, report = run(capsys, *words, "--write-closed", path)
    assert code == 0 and report["at"] == {"u1": 0.25, "u2": -0.4}
    code, other = run(capsys, "report", path, "--inputs", "u1,u2")
    assert code == 0 and other["at"] is None
    for key in ("orders", "rank", "nullity", "serial", "parallel", "inputs", "algebra"):
        assert report[key] == other[key]
    assert report["as_given"]["residual"] == pytest.approx(other["as_given"]["residual"])
    assert main(words) == 0
    assert "pose          u1 = 0.25 rad, u2 = -0.4 rad from the pose of the file" in (
        capsys.readouterr().out
    )


def test_a_saved_space_says_at_which_pose_it_is(tmp_path):
    there = design_space(kinematics.load("four_bar_general", at={"u1": 0.3}))
    balance.space.save_space(there, tmp_path / "s.npz")
    notice = balance.space.load_space(tmp_path / "s.npz").notices[-1]
    assert notice.code == "reference_pose" and "u1 = 0.3 rad from the pose" in notice.message


@pytest.mark.slow
def test_motions_start_from_the_pose(tmp_path, capsys):
    """The same random motions from the pose shake as they do for the file written there."""
    _, path = written_at("four_bar_general", {"u1": 0.3}, tmp_path)
    words = ["--trajectories", "2", "--seed", "5"]
    code, report = run(capsys, "verify", "four_bar_general", "--at", "u1=0.3", *words)
    other_code, other = run(capsys, "verify", path, *words)
    home_code, home = run(capsys, "verify", "four_bar_general", *words)
    assert code == other_code == home_code == 1
    assert (report["at"], other["at"]) == ({"u1": 0.3}, None)
    for part in ("force", "moment"):
        assert report["shaking"][part] == pytest.approx(other["shaking"][part], rel=1e-9)
        assert report["shaking"][part] != pytest.approx(home["shaking"][part], rel=1e-3)


def test_displacements_count_from_the_pose(capsys):
    """Two steps lead where one does."""
    _, step = run(capsys, "motion", "four_bar_general", "--at", "u1=0.2", "--to", "u1=0.1")
    _, whole = run(capsys, "motion", "four_bar_general", "--to", "u1=0.3")
    before = kinematics.load("four_bar_general", at={"u1": 0.2}).displaced
    assert step["at"] == {"u1": 0.2}
    total = before + np.array(step["poses"][0]["corrected"])
    np.testing.assert_allclose(total, whole["poses"][0]["corrected"], atol=1e-12)


@pytest.mark.parametrize("pose", ["u1=0.4", "u1=-0.7"])
def test_a_design_at_one_pose_is_balanced_from_another(pose, tmp_path, capsys, caplog):
    path = tmp_path / "designed.urdf"
    words = ["design", "four_bar_antiparallelogram", "--at", pose, "--out", path]
    code, report = run(capsys, *words)
    assert code == 0 and report["verdict"] == "feasible"
    name, _, value = pose.partition("=")
    assert report["at"] == {name: float(value)}
    assert f"--at {pose}" in caplog.messages[-1]
    for words in ([], ["--at", "u1=0.2"]):
        code, report = run(capsys, "verify", path, "--trajectories", "1", *words)
        assert code == 0 and report["balanced"] is True


def test_both_readings_of_rounded_angles_are_at_the_pose(tmp_path, capsys):
    code, report = run(capsys, "report", four_bar(tmp_path), "--at", "u1=0.3")
    assert code == 0 and report["rank"] == 8
    (warning,) = report["warnings"]
    assert "as written: loop 'q3': does not close" in warning["message"]


def test_two_linkages_are_at_one_pose(capsys):
    words = ["--trajectories", "1", "--at", "u1=0.1"]
    pair = ["four_bar_kite", "--against", "four_bar_kite_balanced"]
    _, report = run(capsys, "verify", *pair, *words)
    assert report["at"] == report["against"]["at"] == {"u1": 0.1}


# --- what cannot be -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "fragment"),
    [
        (["four_bar_kite", "--inputs", "q4", "--at", "q4=3"], "the loops cannot be closed"),
        (["four_bar_general", "--at", "no=0.1"], "choose from u1"),
        (["four_bar_general", "--at", "u1=1e9"], "give a nearer pose"),
    ],
)
@pytest.mark.parametrize("verb", ["report", "verify", "design", "motion"])
def test_a_pose_that_cannot_be_is_one_line(verb, words, fragment, capsys):
    assert main([verb, *words, "--json"]) == 3
    streams = capsys.readouterr()
    assert streams.out == "" and len(streams.err.splitlines()) == 1
    assert fragment in streams.err


@pytest.mark.parametrize("word", ["", "u1", "u1=", "=1", "u1=nan", "u1=inf", "u1=1,u1=2", "1"])
def test_words_that_are_no_pose(word, capsys):
    assert main(["report", "four_bar_general", "--at", word]) == 2
    assert "with each name once" in capsys.readouterr().err


def test_errors_of_the_module():
    with pytest.raises(CoordinateError) as caught:
        kinematics.load("five_bar", at={"u1": 0.1, "q9": 1.0})
    assert caught.value.names == ("q9",)
    assert caught.value.valid == tuple(j.name for j in kinematics.load("five_bar").joints)
    with pytest.raises(PoseError, match="finite"):
        kinematics.load("five_bar", at={"u1": np.nan})
    assert kinematics.load("five_bar", at={}).at is None


# Angles of the crank, from the pose of the file, at which all links are in one line.
IN_LINE = {
    "four_bar_parallelogram": -np.arctan2(0.4, 0.3),
    "four_bar_kite": -np.arctan2(0.3, 0.6),
}


@pytest.mark.parametrize("off", [1e-1, 1e-2, 1e-3])
@pytest.mark.parametrize("name", IN_LINE)
def test_a_pose_next_to_a_singular_one_stays_as_it_is_given(name, off):
    """By its input alone, and by the positions of all joints, which close the loops."""
    asked = IN_LINE[name] + off
    linkage = kinematics.load(name, at={"u1": asked})
    q = dict(zip((joint.name for joint in linkage.joints), linkage.displaced, strict=True))
    assert abs(q["u1"] - asked) < 1e-12 and linkage.at == {
        "u1": pytest.approx(asked, abs=1e-12)
    }
    assert "left_singular_pose" not in {notice.code for notice in linkage.notices}
    again = kinematics.load(name, at=q)
    np.testing.assert_allclose(again.displaced, linkage.displaced, atol=1e-9)


def test_the_ranks_next_to_a_singular_pose_are_those_of_the_file():
    name = "four_bar_kite"
    expected = [order.rank for order in certify(design_space(name)).orders]
    for off in (1e-1, 1e-2):
        linkage = kinematics.load(name, at={"u1": IN_LINE[name] + off})
        found = certify(design_space(linkage))
        if found.level != "estimated":
            assert [order.rank for order in found.orders] == expected
        else:
            assert found.doubts or [order.rank for order in found.orders] == expected
