"""Poses near, far and out of reach: what is said of them does not depend on the order."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from balance.motion.taylor_poses.prediction import predict
from kinematics import taylor_motion, tool
from kinematics.closure.newton import forward_kinematics
from kinematics.model.chain import arrange_loops
from tests.independent import reference
from tests.support.covering import ALL_CASES, spread
from tests.support.urdf_text import UNIT_INERTIA, along, joint, link, loop, saved

# The first, the last, and some between; all with ``ALL_CASES=1``.
ORDERS = range(1, 13) if ALL_CASES else (1, 2, 3, 5, 8, 12)
# Distances of targets, in radii of convergence or in units where that is larger.
SHARES = 2 * (0.3, 0.9, 1.2, 2.0, 4.0)
PLATFORM = Path(__file__).parents[3] / "data" / "near_special" / "rrr_platform_p120.urdf"


def nearly_dead(folder, angle=0.03):
    """A slider-crank driven by its slider, its arms almost in line; and its stroke."""
    elbow = np.array([np.cos(angle), np.sin(angle), 0.0])
    stroke = elbow[0] + np.sqrt(2.25 - elbow[1] ** 2)
    limits = '<limit lower="-9" upper="9" effort="1" velocity="1"/>'
    ends = along([stroke, 0, 0] - elbow), np.eye(4)
    parts = [link("base"), *(link(name, **UNIT_INERTIA) for name in ("crank", "rod", "block"))]
    parts += [
        joint("a", "continuous", "base", "crank", axis=[0, 0, 1]),
        joint("b", "continuous", "crank", "rod", along(elbow), [0, 0, 1]),
        joint("s", "prismatic", "base", "block", along([stroke, 0, 0]), [1, 0, 0], limits),
        loop("k", "revolute", ("rod", "block"), ends, [0, 0, 1]),
    ]
    return saved(folder, *parts), stroke


def asked(capsys, *words):
    """Exit code, JSON and text of ``balance motion``."""
    code = main(["motion", *map(str, words), "--json"])
    report = json.loads(capsys.readouterr().out)
    assert main(["motion", *map(str, words)]) == code
    return code, report, capsys.readouterr().out


def test_a_pose_far_beyond_the_radius_is_the_same_at_every_order(tmp_path, capsys):
    """By the law of cosines; predictions beyond the radius grow with the order."""
    path, stroke = nearly_dead(tmp_path)
    x = stroke - 0.4
    angle = np.arccos((1 + x * x - 2.25) / (2 * x))
    for order in ("2", "6", "12"):
        words = ["--inputs", "s", "--to", "s=-0.4", "--order", order]
        code, report, text = asked(capsys, path, *words)
        (pose,), names = report["poses"], [each["name"] for each in report["joints"]]
        corrected = dict(zip(names, pose["corrected"], strict=True))
        assert code == 0 and corrected["a"] == pytest.approx(angle - 0.03, abs=1e-10)
        assert report["radius"] < 0.01
        assert pose["error"] is None and pose["share"] == 1.0 and pose["furthest"] is None
        assert "error        no estimate beyond the radius of convergence, " in text
        assert "predicted" not in text and "estimated\n" not in text.split("error ")[1]
        assert f"{angle - 0.03:.9f}" in text
    assert max(np.abs(pose["predicted"])) > 1e9


def test_within_the_radius_there_is_an_estimate(capsys):
    _, report, text = asked(capsys, "five_bar", "--to", "u1=0.3")
    assert report["poses"][0]["error"] > 0.0 and "no estimate" not in text
    motion = taylor_motion(kinematics.load("five_bar"), 3)
    at = motion.radius * np.array([[0.99, 0.0], [1.01, 0.0]]) * motion.scales
    assert np.isnan(motion.error(at)).tolist() == [False, True]
    assert np.isfinite(motion.error(at[0])) and np.isnan(motion.error(at[1]))


@pytest.mark.slow
def test_a_sum_that_is_no_number_is_null(tmp_path, capsys):
    """Order 50 millions of radii away; the pose is reached all the same."""
    path, _ = nearly_dead(tmp_path, 1e-4)
    words = ["--inputs", "s", "--to", "s=-1.8", "--order", "50"]
    files = ["--html", tmp_path / "a.html", "--plot", tmp_path / "a.svg"]
    code, report, _ = asked(capsys, path, *words, *files)
    assert all(file.stat().st_size for file in files[1::2])
    (pose,) = report["poses"]
    assert (code, pose["predicted"], pose["difference"], pose["error"]) == (0, None, None, None)
    low, _ = asked(capsys, path, *words[:-1], "1")[1:]
    assert low["poses"][0]["predicted"] is not None
    assert low["poses"][0]["corrected"] == pose["corrected"]


def test_a_path_that_leads_beyond_the_radius_says_where_its_estimate_holds(tmp_path, capsys):
    path = tmp_path / "a.csv"
    for rows, said in (
        ("0.1,0\n0.3,0", r"up to \S+ estimated, \S+ to"),
        ("0.1,0\n0.7,0", r"up to \S+ estimated within the radius of convergence, \S+ to"),
        ("0.6,0\n0.7,0", r"no estimate beyond the radius of convergence, \S+ to"),
    ):
        path.write_text(f"u1,u2\n{rows}\n", encoding="utf-8")
        code, report, text = asked(capsys, "five_bar", "--path", path)
        assert code == 0 and re.search(rf"^error +{said} the corrected pose$", text, re.M)
        beyond = [pose["distance"] > report["radius"] for pose in report["poses"]]
        assert [pose["error"] is None for pose in report["poses"]] == beyond


# --- whether a pose is reached ---------------------------------------------------------------


def targets(motion, seed):
    """Points at each distance, in random directions (count, w)."""
    rng = np.random.default_rng(seed)
    rays = rng.standard_normal((len(SHARES), motion.scales.size))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    return np.outer(np.array(SHARES) * min(motion.radius, 3.0), motion.scales) * rays


def agreed(linkage, points):
    """Poses at points, the same at all orders: all joints if they are reached, or None."""
    motions = [taylor_motion(linkage, order) for order in ORDERS]
    for point in points:
        poses = [predict(motion, point) for motion in motions]
        first = poses[0]
        for pose in poses[1:]:
            assert (pose.corrected is None) == (first.corrected is None)
            assert (pose.reason, pose.share) == (first.reason, first.share)
            if pose.corrected is not None:
                assert pose.corrected == pytest.approx(first.corrected, abs=1e-12)
        yield first


LINKAGES = ("five_bar", "three_rsr", "three_rrr", "slider_crank", "rusr", "six_bar_stephenson")


@pytest.mark.slow
@pytest.mark.parametrize("name", spread(LINKAGES, 2))
def test_all_orders_reach_the_same_poses(name):
    """Which, and the poses themselves, are those of the Newton steps of `reference`."""
    linkage, mechanism = kinematics.load(name), reference.load(kinematics.gallery()[name])
    motion = taylor_motion(linkage, 1)
    inputs = [linkage.inputs.index(mechanism.joints[i]) for i in mechanism.inputs]
    points = targets(motion, 3)
    ends = set()
    for point, pose in zip(points, agreed(linkage, points), strict=True):
        q = np.zeros(len(mechanism.joints))
        try:
            for share in np.linspace(0.0, 1.0, 40):  # no jump to another branch
                q = reference.follow(mechanism, q, share * point[inputs])
        except ValueError:
            q = None
        ends.add((q is None, bool(motion.distance(point) > motion.radius)))
        assert (pose.corrected is None) == (q is None)
        if q is not None:
            found = [pose.corrected[motion.joints.index(each)] for each in mechanism.joints]
            assert found == pytest.approx(q, abs=1e-10)
    assert {(False, False), (False, True)} <= ends
    assert ((True, True) in ends) == (name in ("five_bar", "three_rrr", "six_bar_stephenson"))


@pytest.mark.table(1)
@pytest.mark.parametrize(
    ("model", "link", "directions", "point"),
    [
        ("five_bar", "left_upper", "x,y", (0.5, 1.1, 0.0)),
        (PLATFORM, "plat", "ry,y", None),
        ("delta", "platform", "z", None),
    ],
)
def test_all_orders_take_a_tool_to_the_same_poses(model, link, directions, point):
    """Where it is sent, loops closed, or where the line ends; the reference pose is (0, …)."""
    linkage = tool(kinematics.load(model), link, directions, point)
    chain, inputs = arrange_loops(linkage), linkage.positions_of(linkage.inputs)
    motion = taylor_motion(linkage, 1)
    points = targets(motion, 5) * (3.0 if motion.radius > 0.01 else 60.0)
    reached = []
    for point, pose in zip(points, agreed(linkage, points), strict=True):
        reached.append(pose.corrected is not None)
        q = pose.corrected if reached[-1] else pose.furthest
        assert q[inputs] == pytest.approx(pose.share * point, abs=1e-9)
        assert forward_kinematics(chain, q / chain.units).error < 1e-10
        assert (pose.share == 1.0) == reached[-1]
    assert {*reached} == {True, False}


def test_the_platform_on_which_orders_disagreed(capsys):
    """Through the command; all joints to the last digit printed."""
    goal = ["--tool", "plat", "--along", "ry,y", "--to=plat.ry=-0.0500755,plat.y=-0.0455308"]
    answers = set()
    for order in ORDERS:
        code, report, text = asked(capsys, PLATFORM, *goal, "--order", order)
        assert code == 0 and report["poses"][0]["error"] is None
        answers.add(text[text.index("\njoint") :])
    (answer,) = answers
    assert "lp1       rad  -0.834384047\n" in answer
