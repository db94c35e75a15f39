"""Pictures of Taylor motions: the curves are true errors, the page holds them and no more."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from functools import cache
from xml.etree import ElementTree

import numpy as np
import pytest

import kinematics
from balance.app.answers.html.motion import motion_page
from balance.app.cli.main import main
from balance.motion.taylor_poses.error_curves import LENGTH_IN_RADII, MAX_LINES, error_curves
from balance.motion.taylor_poses.prediction import Predictions, predict
from kinematics import taylor_motion
from tests.support.motions import followed


@cache
def expanded(name, order=5, inputs=None, motion=None):
    return taylor_motion(kinematics.load(name, inputs=inputs), order, motion)


def foretold(motion, *points, line=False):
    """The poses at points of a Taylor motion."""
    poses = tuple(predict(motion, y) for y in points)
    return Predictions(motion, None, line, poses, motion.linkage.notices)


# --- curves --------------------------------------------------------------------------------


@pytest.mark.table(1)
@pytest.mark.parametrize(("name", "column"), [("five_bar", 1), ("bennett", 0), ("delta", 2)])
def test_curves_are_errors_against_another_route(name, column):
    """Every order's own expansion, and poses of `reference`, at three distances each way."""
    motion = expanded(name)
    panel = error_curves(foretold(motion))[column]
    assert panel.errors.shape == (5, panel.x.size) and np.all(np.diff(panel.x) > 0.0)
    for share in (-0.9, -0.5, 0.2, 0.8):
        at = int(np.argmin(np.abs(panel.x - share * motion.radius)))
        goal = panel.x[at] * motion.scales * np.eye(motion.scales.size)[column]
        _, expected = followed(name, goal)
        for order in (1, 2, 3, 4, 5):
            q = taylor_motion(motion.linkage, order).evaluate(goal)
            found = max(abs(q[motion.joints.index(j)] - v) for j, v in expected.items())
            # Joints that close the loops are in the curves and not in the tree.
            assert found <= panel.errors[order - 1, at] + 1e-12
            assert found > 0.2 * panel.errors[order - 1, at]


def test_the_error_of_order_k_falls_like_the_next_power():
    """Halfway in, it is 2^-(k + 1) of what it was, to 15 %; checked above round-off."""
    panel, *_ = error_curves(foretold(expanded("four_bar_general", 4)))
    far = 0.04
    whole, half = (
        np.array(
            [np.interp(x, panel.x, np.log(np.maximum(line, 1e-300))) for line in panel.errors]
        )
        for x in (2 * far, far)
    )
    assert np.exp(half - whole) == pytest.approx(0.5 ** np.arange(2, 6), rel=0.15)


def test_the_way_ends_where_the_linkage_does():
    """A slider-crank of two links of 0.5 m, at x = 0.6 m: stretched at 1 m."""
    motion = expanded("slider_crank", 4, ("q4",))
    edge = float(motion.distance([0.4]))
    assert motion.radius < edge < LENGTH_IN_RADII * motion.radius
    (panel,) = error_curves(foretold(motion))
    assert panel.closed == pytest.approx((edge,), rel=1e-3)
    assert panel.x[-1] == panel.closed[0]
    assert panel.x[0] == pytest.approx(-LENGTH_IN_RADII * motion.radius, rel=1e-9)
    assert panel.beyond == (
        (pytest.approx(-LENGTH_IN_RADII * motion.radius), -motion.radius),
        (motion.radius, pytest.approx(LENGTH_IN_RADII * motion.radius)),
    )


def test_a_line_leads_to_its_target_and_past_the_radius():
    motion = expanded("five_bar")
    y = np.array([0.06, 0.08])
    (panel,) = error_curves(foretold(motion, y, line=True))
    assert panel.target == pytest.approx(0.1)
    assert (panel.x[0], panel.x[-1]) == (0.0, pytest.approx(LENGTH_IN_RADII * motion.radius))
    at = int(np.argmin(np.abs(panel.x - 0.1)))
    error = predict(motion, y / 0.1 * panel.x[at]).difference
    assert panel.errors[-1, at] == pytest.approx(error, rel=1e-3)
    # The reference pose has no direction: all are shown.
    assert len(error_curves(foretold(motion, np.zeros(2), line=True))) == 2


def test_a_path_is_shown_as_long_as_it_is():
    """Out along u2 and back, beyond the radius in between; one pose is out of reach."""
    motion = expanded("five_bar")
    r = motion.radius
    u2 = [0.5 * r, 0.9 * r, 1.1 * r, 1.2 * r, 0.8 * r]
    found = foretold(motion, *([0.0, u] for u in u2), [1.8, 0.0])
    (panel,) = error_curves(found)
    steps = np.append(np.abs(np.diff(u2)), np.hypot(0.8 * r, 1.8))
    assert panel.x == pytest.approx([0.0, *np.cumsum(steps)])
    ends = (panel.x[1] + panel.x[2]) / 2, (panel.x[3] + panel.x[4]) / 2
    last = (panel.x[4] + panel.x[5]) / 2, panel.x[5]
    assert panel.beyond == (pytest.approx(ends), pytest.approx(last))
    assert np.isnan(panel.errors[:, 5]).all() and np.isfinite(panel.errors[:, :5]).all()
    assert panel.errors[-1, :5] == pytest.approx([p.difference for p in found.poses[:5]])


def test_a_restricted_motion_has_a_panel_for_each_freedom():
    motion = expanded("three_rsr", 3, None, "u2=u3")
    assert [panel.title for panel in error_curves(foretold(motion))] == [
        "along u1",
        "along u2 and u3",
    ]
    open_chain = foretold(expanded("hprs", 2))
    panels = error_curves(open_chain)
    assert len(panels) == MAX_LINES and all(panel.beyond == () for panel in panels)
    assert max(panel.errors.max() for panel in panels) < 1e-14


# --- pictures ------------------------------------------------------------------------------


@pytest.mark.slow
def test_pictures_are_written(tmp_path, capsys):
    image, drawing, page = (tmp_path / f"a.{kind}" for kind in ("png", "svg", "html"))
    command = ["motion", "five_bar", "--order", "3", "--to", "u1=1.8"]
    assert main([*command, "--plot", str(image), "--html", str(page)]) == 1
    assert main([*command, "--plot", str(drawing)]) == 1
    assert image.read_bytes().startswith(b"\x89PNG\r\n")
    text = drawing.read_text(encoding="utf-8")
    assert ElementTree.fromstring(text).tag.endswith("svg")
    for comment in (
        "order 1",
        "order 3",
        "order 3, estimated",
        "target",
        "beyond the radius",
        "the loops close no further",
    ):
        assert f"<!-- {comment} -->" in text
    assert "<!-- order 4 -->" not in text
    whole = page.read_text(encoding="utf-8")
    assert "{{" not in whole and not re.search(r'(?:src|href)="(?!data:)', whole)
    capsys.readouterr()


def test_the_page_holds_the_report_and_escapes_names():
    motion = expanded("five_bar", 3)
    hostile = '</script><script>alert("x")</script>'
    names = tuple(f"{hostile}{k}" for k in range(5))
    inputs = tuple(names[j] for j in motion.linkage.positions_of(motion.linkage.inputs))
    pairs = zip(motion.linkage.joints, names, strict=True)
    joints = tuple(replace(joint, name=name) for joint, name in pairs)
    linkage = replace(motion.linkage, name=hostile, inputs=inputs, joints=joints)
    whole = replace(motion.motion, inputs=inputs)
    found = foretold(motion, [0.1, 0.2], [0.2, 0.1])
    found = replace(found, motion=replace(motion, linkage=linkage, motion=whole, joints=names))
    text = motion_page(found, error_curves(found))
    assert hostile not in text
    named = replace(found, poses=())
    (figures,) = re.findall(
        r'id="figures">(.*?)</script>', motion_page(named, error_curves(named)), re.S
    )
    for figure in json.loads(figures):
        assert "<script>" in figure["layout"]["title"]["text"]
    (report,) = re.findall(r'id="report">(.*?)</script>', text, re.DOTALL)
    assert json.loads(report) == found.to_dict()
    (figures,) = re.findall(r'id="figures">(.*?)</script>', text, re.DOTALL)
    (figure,) = json.loads(figures)
    names = [trace["name"] for trace in figure["data"]]
    assert names == ["order 1", "order 2", "order 3", "estimated"]
    assert text.count('data-head="pose"') == 2


def moving(text):
    """What a page moves."""
    (found,) = re.findall(r'id="motion">(.*?)</script>', text, re.DOTALL)
    return json.loads(found)


def test_a_tool_is_no_ground():
    """The drawing has the joints that were built, and stands on the pivots of the file."""
    plain = kinematics.load("five_bar")
    led = kinematics.tool(plain, "left_upper", "x,rz")
    motion = taylor_motion(led, 2)
    found = Predictions(motion, "left_upper", False, (), led.notices)
    drawing = moving(motion_page(found, error_curves(found)))["scene"]
    assert [joint["name"] for joint in drawing["joints"]] == [j.name for j in plain.joints]
    ground = np.array(drawing["parts"][0]["corners"])
    pivots = [j.point for j in plain.joints if j.parent < 0]
    assert len(ground) == len(pivots) == 2
    assert sorted(map(tuple, ground)) == sorted(map(tuple, np.round(pivots, 9)))
    # What moves has a name, and the links keep their corners.
    named = [part for part in drawing["parts"] if part["names"]]
    assert [len(part["corners"]) for part in named] == [2] * 4


def test_the_first_sentence_says_whether_the_pose_is_reached():
    motion = expanded("five_bar", 3)
    goals = ([0.1, 0.1], "The pose is reached"), ([2.0, -2.0], "The pose is not reached: ")
    for goal, words in goals:
        found = foretold(motion, goal, line=True)
        assert bool(found.poses[0].reason) == ("not" in words)
        lede = re.findall(r'<p class="lede">(.*?)</p>', motion_page(found, error_curves(found)))
        assert lede[0].startswith(words)


@pytest.mark.browser
def test_curves_are_drawn_offline(request, tmp_path):
    """Two panels side by side on a wide screen, one below the other on a narrow one."""
    helper = pytest.importorskip("tests.support.browser")
    if not (helper.BROWSER and helper.DRIVER):
        pytest.skip("no chromium with its chromedriver on the PATH")
    driver = request.getfixturevalue("browser")
    found = foretold(expanded("five_bar", 4))
    text = motion_page(found, error_curves(found))
    drawn = "return document.querySelectorAll('.errors .line').length"
    tops = "return [0, 1].map((k) => byId(`traces${k}`).getBoundingClientRect().top)"
    for width in (1280, 390):
        with helper.screen(driver, width):
            helper.show(driver, tmp_path, text)
            helper.wait_until(driver, lambda page: page.execute_script(drawn) == 10)
            assert helper.complaints(driver) == []
            first, second = driver.execute_script(tops)
            assert (first == second) == (width == 1280)
            assert helper.too_wide(driver) == 0
