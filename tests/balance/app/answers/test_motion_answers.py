"""The answers of ``balance motion`` in words, on the page and as data."""

from __future__ import annotations

import re

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import UnreachedError
from tests.independent import reference
from tests.support.five_bar_tip import TIP, two_links
from tests.support.motion_command import named, refused, run, table
from tests.support.robots import SIX, arm

# The tip of the five-bar in the frame of its link, and as inputs of inverse kinematics.
INSIDE = "0.7,0.5,0"
TIP_OF_THE_FIVE_BAR = ["five_bar", "--tool", "left_upper", "--along", "x,y", "--point", INSIDE]


def written(capsys, folder, *arguments):
    """Exit code, lines of the text, and the page without its scripts and data."""
    page = folder / "page.html"
    code = main(["motion", *arguments, "--html", str(page)])
    text = capsys.readouterr().out
    shown = re.sub(r"<(script|style).*?</\1>", "", page.read_text("utf-8"), flags=re.DOTALL)
    return code, text.splitlines(), shown


def in_lines(lines, joint):
    """The words after a joint's name, in the table of joints."""
    (found,) = (line.split() for line in lines if line.startswith(f"{joint} "))
    return found[1:]


def in_page(page, joint):
    """Cells after a joint's name in the table of joints of a page."""
    (row,) = re.findall(rf'<tr><td data-head="joint" >{joint}</td>(.*?)</tr>', page)
    return [cell.replace("−", "-") for cell in re.findall(r"<td.*?>(.*?)</td>", row)]


def angles_at(x, y):
    """The four joint angles of the five-bar with its tip displaced, in closed form."""
    tips = np.array(TIP[:2]) + [[0.0, 0.0], [x, y]]
    found = {}
    for base, elbow, names in (
        ((0.0, 0.0), (-0.2, 0.6), ("u1", "q2")),
        ((0.9, 0.1), (1.2, 0.5), ("u2", "q4")),
    ):
        for name, angle in zip(names, two_links(np.array(base), tips, elbow), strict=True):
            found[name] = angle[1] - angle[0]
    return found


# --- inverse kinematics ----------------------------------------------------------------------


def test_the_joint_angles_are_in_the_table_on_the_page_and_in_the_json(tmp_path, capsys):
    words = [*TIP_OF_THE_FIVE_BAR, "--to", "x=0.1,y=-0.05"]
    code, lines, page = written(capsys, tmp_path, *words)
    _, report = run(capsys, *words)
    corrected = named(report, report["poses"][0]["corrected"])
    assert code == 0 and report["point"] == [0.7, 0.5, 0.0]
    for joint, angle in angles_at(0.1, -0.05).items():
        assert in_lines(lines, joint)[:2] == ["rad", f"{angle:.9f}"]
        assert in_page(page, joint)[:2] == ["rad", f"{angle:.9f}"]
        assert corrected[joint] == pytest.approx(angle, abs=1e-12)
    said = "tool         left_upper, its point (0.7, 0.5, 0) m in the frame of the link"
    assert said in lines
    assert "Joints at the target" in page


def test_the_joint_angles_along_a_path_too(tmp_path, capsys):
    """A column for each pose; columns of the file by their short names, in any order."""
    goals = [(0.02, 0.1), (0.05, 0.0), (-0.05, -0.1)]
    path = table(tmp_path / "a.csv", ["y", "left_upper.x"], np.array(goals)[:, ::-1])
    code, lines, page = written(capsys, tmp_path, *TIP_OF_THE_FIVE_BAR, "--path", path)
    assert code == 0
    expected = [angles_at(*goal) for goal in goals]
    for joint in expected[0]:
        angles = [f"{each[joint]:.6f}" for each in expected]
        assert in_lines(lines, joint) == ["rad", *angles]
        assert in_page(page, joint) == ["rad", *angles]
    assert "Joints at these poses" in page


def test_short_names_are_those_of_the_tool(capsys):
    words = TIP_OF_THE_FIVE_BAR
    poses = [
        run(capsys, *words, "--to", to)[1]["poses"][0]["corrected"]
        for to in (
            "left_upper.x=0.1,left_upper.y=0.02",
            "x=0.1,y=0.02",
            "y=0.02,left_upper.x=0.1",
            "0.1,0.02",
        )
    ]
    assert poses[0] == poses[1] and np.ptp(poses, axis=0).max() < 1e-14
    for to, said in (
        ("rz=0.1", "input rz: not an independent coordinate; choose from left_upper.x"),
        ("x=0.1,left_upper.x=0.2", "left_upper.x: named twice, as left_upper.x too"),
    ):
        assert said in refused(capsys, 3, *words, "--to", to)
    assert "u1: not an independent" in refused(capsys, 3, *words, "--to", "u1=0.1")
    assert "x: not an independent" in refused(capsys, 3, "five_bar", "--to", "x=0.1")


def seven_joints(folder, name):
    """An arm of seven joints, the one that a tool leaves free being called by a name."""
    points, axes = SIX
    path = arm(folder, [*points, (0.6, 0.1, 0.5)], [*axes, (0, 1, 0.5)])
    free = kinematics.tool(kinematics.load(path), "l7", "x,y,z,rx,ry,rz").inputs[-1]
    text = path.read_text("utf-8").replace(f'"{free}"', f'"{name}"')
    path.write_text(text, encoding="utf-8")
    return [str(path), "--tool", "l7", "--along", "x,y,z,rx,ry,rz"]


def test_a_joint_called_like_a_direction_is_not_mistaken_for_it(tmp_path, capsys):
    words = seven_joints(tmp_path, "x")
    said = "x: a joint, and a direction of the tool: for the tool write l7.x; choose"
    assert said in refused(capsys, 3, *words, "--to", "x=0.01")
    _, report = run(capsys, *words, "--to", "x=0.01,l7.x=0.02,y=0.03")
    pose = dict(zip(report["independent"], report["poses"][0]["inputs"], strict=True))
    found = [pose[name] for name in ("x", "l7.x", "l7.y", "l7.z")]
    assert found == pytest.approx([0.01, 0.02, 0.03, 0.0], abs=1e-15)


def test_ambiguous_joint_angles_are_told(tmp_path, capsys):
    """Another posture may do; a seventh joint is not determined at all."""
    words = seven_joints(tmp_path, "free")
    _, lines, page = written(capsys, tmp_path, *words, "--to", "x=0.01")
    (posture,) = (line for line in lines if line.startswith("posture "))
    assert "others may take the tool there too, for it does not determine free" in posture
    assert posture.split(maxsplit=1)[1] in page
    _, lines, _ = written(capsys, tmp_path, *TIP_OF_THE_FIVE_BAR)
    (posture,) = (line for line in lines if line.startswith("posture "))
    assert posture.endswith("others may take the tool there too")
    _, lines, _ = written(capsys, tmp_path, "five_bar")
    assert not [line for line in lines if line.startswith("posture")]


def test_the_point_moves_as_it_is_told(tmp_path, capsys):
    """By the forward route of the reference, in space; the link turns about it."""
    path = arm(tmp_path, *SIX)
    point, sent, turned = (0.1, -0.2, 0.3), (0.02, -0.01, 0.03), 0.2
    goal = "x={},y={},z={},rz={}".format(*sent, turned)
    _, report = run(
        capsys,
        str(path),
        "--tool",
        "l6",
        "--along",
        "x,y,z,rx,ry,rz",
        "--point",
        "0.1,-0.2,0.3",
        "--to",
        goal,
    )
    corrected = report["poses"][0]["corrected"]
    linkage = kinematics.load(path)
    (start,) = (body.frame for body in linkage.bodies if body.name == "l6")
    moved = reference.displacements(reference.load(path), np.array(corrected[:6]))[0][5] @ start
    before, after = (pose[:3, :3] @ point + pose[:3, 3] for pose in (start, moved))
    assert after - before == pytest.approx(sent, abs=1e-12)
    R = moved[:3, :3] @ start[:3, :3].T
    assert np.arctan2(R[1, 0], R[0, 0]) == pytest.approx(turned, abs=1e-12)
    assert R[2, 2] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    "point", ["1,2", "1,2,3,4", "a,b,c", "1,2,nan", "0,inf,0", "1e9,0,0", "", "1;2;3", "1,,2"]
)
def test_wrong_points_are_usage(point, capsys):
    words = ["five_bar", "--tool", "left_upper", "--along", "x", "--point", point]
    said = refused(capsys, 2, *words)
    assert "three numbers, metres" in said


def test_a_point_wants_a_tool(capsys):
    said = refused(capsys, 2, "five_bar", "--point", "0,0,0")
    assert "--point is a point of the tool: name that by --tool and --along" in said
    assert main(["motion", "--help"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "--tool LINK" in text and "its point in its frame, m (default: the origin)" in text


# --- poses that are not reached --------------------------------------------------------------


@pytest.mark.parametrize(
    "words",
    [
        ["five_bar", "--to", "u1=40"],
        ["five_bar", "--to", "u1=40", "--order", "12"],
        [*TIP_OF_THE_FIVE_BAR, "--to", "x=9,y=7"],
    ],
)
def test_what_is_not_reached_has_no_numbers_without_meaning(words, tmp_path, capsys):
    """How far it was followed, the joints there, and what to try."""
    code, lines, page = written(capsys, tmp_path, *words)
    _, report = run(capsys, *words)
    (pose,), share = report["poses"], report["poses"][0]["share"]
    assert code == 1 and 0.0 < share < 0.2
    for key in ("error", "predicted", "corrected", "within_turn", "turns", "difference"):
        assert pose[key] is None
    said = (
        f"cannot be closed beyond {share:.0%} of the way to .*; give a nearer pose, take other "
        "inputs, or start from another reference pose"
    )
    assert re.search(said, pose["reason"]) and re.search(said, "\n".join(lines))
    furthest = named(report, pose["furthest"])
    for name, value in zip(report["independent"], pose["inputs"], strict=True):
        assert furthest[name] == pytest.approx(share * value, abs=1e-9)
    assert in_lines(lines, "q2") == in_page(page, "q2") == ["rad", f"{furthest['q2']:.9f}"]
    assert "Joints at the furthest pose on the way to the target" in page
    for text in ("\n".join(lines), re.sub(r"<svg.*?</svg>", "", page)):
        numbers = re.findall(r"[-−]?\d+\.?\d*(?:e[+-]\d+)?", text)
        assert max(abs(float(x.replace("−", "-"))) for x in numbers) < 1000.0


def test_a_path_that_is_not_reached_leaves_its_column_empty(tmp_path, capsys):
    path = table(tmp_path / "a.csv", ["u1", "u2"], [[0.1, 0.1], [40.0, 0.0]])
    code, lines, page = written(capsys, tmp_path, "five_bar", "--path", path)
    assert code == 1
    assert in_lines(lines, "u1") == in_page(page, "u1") == ["rad", "0.100000", "-"]
    assert lines[-8].split()[-2:] == ["not", "reached"]


def test_steps_that_are_used_up_are_told_from_loops_that_end(capsys):
    code, report = run(capsys, "four_bar_general", "--to", "u1=5000")
    (pose,) = report["poses"]
    assert code == 1 and 0.05 < pose["share"] < 0.5
    assert f"2000 steps lead {pose['share']:.0%} of the way to u1=5000; give" in pose["reason"]


@pytest.mark.parametrize(
    ("share", "part"), [(0.436, "44%"), (0.99997, "99.99%"), (0.0012, "0.12%"), (0.0, "0.00%")]
)
def test_a_share_is_neither_none_nor_all(share, part):
    error = UnreachedError("a.urdf", "u1=1", share, [0.0])
    assert f"a.urdf: the loops cannot be closed beyond {part} of the way to u1=1;" in str(error)
    assert (error.share, error.positions) == (share, (0.0,))


# --- full turns ------------------------------------------------------------------------------


@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("goal", "turns"),
    [(0.3, ""), (7.5, " + 1 turn"), (-19.0, " - 3 turns"), (13.0, " + 2 turns")],
)
def test_full_turns_are_counted(goal, turns, tmp_path, capsys):
    """The crank of a four-bar; its coupler and its rocker, by another route."""
    words = ["four_bar_general", "--to", f"u1={goal}"]
    code, lines, page = written(capsys, tmp_path, *words)
    _, report = run(capsys, *words)
    (pose,) = report["poses"]
    mechanism = reference.load(kinematics.gallery()["four_bar_general"])
    q = np.zeros(len(mechanism.joints))
    for share in np.linspace(0.0, 1.0, 100):  # no jump to another branch
        q = reference.follow(mechanism, q, np.array([share * goal]))
    expected = dict(zip(mechanism.joints, q, strict=True))
    corrected, within, count = (
        named(report, pose[key]) for key in ("corrected", "within_turn", "turns")
    )
    assert code == 0 and corrected["u1"] == goal
    for joint, value in expected.items():
        assert corrected[joint] == pytest.approx(value, abs=1e-9)
    for joint in corrected:
        assert isinstance(count[joint], int) and abs(within[joint]) <= np.pi
        assert within[joint] + 2 * np.pi * count[joint] == pytest.approx(corrected[joint])
    told = f"{within['u1']:.9f}{turns}"
    assert "rad " + told in " ".join(["rad", *in_lines(lines, "u1")[1:]])
    assert in_page(page, "u1")[1] == told
    others = [joint for joint in corrected if count[joint] == 0]
    assert others and not any("turn" in " ".join(in_lines(lines, each)) for each in others)


def test_what_does_not_turn_is_not_wrapped(tmp_path, capsys):
    """A slider at 7 m, and a screw, which is elsewhere after a full turn."""
    words = ["hprs", "--to", "prismatic=7,helical=7,revolute=7"]
    _, lines, _ = written(capsys, tmp_path, *words)
    _, report = run(capsys, *words)
    (pose,) = report["poses"]
    assert {key: named(report, pose["turns"])[key] for key in ("prismatic", "helical")} == {
        "prismatic": 0,
        "helical": 0,
    }
    assert named(report, pose["turns"])["revolute"] == 1
    assert in_lines(lines, "prismatic")[:2] == ["m", "7.000000000"]
    assert in_lines(lines, "helical")[:2] == ["rad", "7.000000000"]
    assert in_lines(lines, "revolute")[1:4] == [f"{7 - 2 * np.pi:.9f}", "+", "1"]


def test_an_open_chain_goes_anywhere(capsys):
    """It needs no steps, however many turns it makes."""
    code, report = run(capsys, "hprs", "--to", "revolute=1e5")
    assert code == 0 and named(report, report["poses"][0]["corrected"])["revolute"] == 1e5
    linkage = kinematics.load("hprs")
    goal = np.linspace(-1e4, 1e4, linkage.mobility)
    assert joint_positions(linkage, goal) == pytest.approx(goal, rel=1e-12)
