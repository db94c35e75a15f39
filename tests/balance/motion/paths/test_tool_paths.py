"""Where paths take a tool: by the geometry of a five-bar in closed form, and by Pinocchio."""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.app.answers.html.paths import paths_page, paths_picture
from balance.app.answers.text.paths import path_rows, paths_facts
from balance.motion import FloatingBase
from balance.motion.paths.tool_paths import tool_paths
from kinematics.errors import BodyError
from tests.support.floating_arms import arm_in_line, model_on_satellite, turning_rates
from tests.support.fuga import Masses, angles, elbows, fuga
from tests.support.page_elements import Elements

SATELLITE = FloatingBase(10.0, 1.0)
START, LINK = np.array([0.5, -1.0, 0.8]), 0.4


def tips(arm, u):
    """The end of the last link (N, 3) of an arm on a satellite at rest, by Pinocchio."""
    import pinocchio as pin

    model = model_on_satellite(arm, SATELLITE)
    data, still = model.createData(), np.array([0, 0, 0, 0, 0, 0, 1.0])
    ends = []
    for q in u:
        pin.forwardKinematics(model, data, np.append(still, q))
        ends.append(data.oMi[model.njoints - 1].act(np.array([LINK, 0.0, 0.0])))
    return np.array(ends)


@pytest.mark.slow
def test_a_fan_of_paths_spans_the_reactionless_workspace():
    """An arm of three joints, whose satellite does not turn: two rates are free."""
    arm, count = arm_in_line(3), 6
    options = {"kept": "attitude", "base": SATELLITE, "fan": count, "length": 0.1}
    solution = balance.find_paths(arm, [START], **options)
    assert solution.dimension == 2 and len(solution.paths) == count
    tool = tool_paths(arm, solution.paths, "link3", (LINK, 0.0, 0.0), poses=343)
    for path, way in zip(solution.paths, tool.ways, strict=True):
        assert way == pytest.approx(tips(arm, path.u), abs=1e-12)
        turned = turning_rates(arm, SATELLITE, path.u[::10], path.rates[::10])
        held = turning_rates(arm, SATELLITE, path.u[::10], np.abs(path.rates[::10]))
        assert np.abs(turned).max() < 1e-9 * np.abs(held).max()
    # The ends lie all around the start: no half plane is free of them.
    start = tips(arm, [START])[0]
    ends = np.concatenate([way[[0, -1]] - start for way in tool.ways])
    around = np.sort(np.arctan2(ends[:, 1], ends[:, 0]))
    assert np.diff(np.append(around, around[0] + 2.0 * np.pi)).max() < np.pi
    # Complete: within 1.2 m of the first joint, and up to there.
    reach = np.linalg.norm(tool.workspace - [0.5, 0.0, 0.0], axis=1)
    assert len(reach) == 343 and reach.max() == pytest.approx(3 * LINK, abs=1e-12)


@pytest.mark.slow
def test_ways_and_strokes_of_a_five_bar_are_those_of_its_geometry(tmp_path):
    """[J] Fig. 3.6: by angles of arms from circles that cross, and finite differences.

    Limits of 0.4 rad keep both elbows on their side.
    """
    text = fuga(0.0, Masses((0.104, 90.0), (0.06982, 149.982), 1.479e-3)).to_urdf()
    limits = '<limit lower="-0.4" upper="0.4" velocity="1" effort="1"/></joint>'
    text = text.replace('type="continuous"', 'type="revolute"').replace("</joint>", limits)
    (tmp_path / "fuga.urdf").write_text(text, encoding="utf-8")
    linkage = kinematics.load(tmp_path / "fuga.urdf")
    point = (*(-elbows([0.0, 0.0])[0]), 0.0)
    solution = balance.find_paths(linkage, length=0.15)
    tool = tool_paths(
        linkage,
        solution.paths,
        "left_lower",
        _in_frame(linkage, point),
        components="both",
        poses=400,
    )
    first = angles([0.0, 0.0])[0]
    for path, way in zip(solution.paths, tool.ways, strict=True):
        assert angles(way[:, :2])[0] - first == pytest.approx(path.u, abs=1e-9)
    step = 1e-5
    assert len(tool.strokes) > 50
    for at, way in tool.strokes[::7]:
        u = angles(at[:2])[0] - first
        beside = [angles(at[:2] + side * step * way[:2])[0] for side in (-1.0, 1.0)]
        M, turned = balance.pose.momentum_matrix(linkage, u), beside[1] - beside[0]
        # Other directions have up to 1e-2 kg m²; rounded masses leave 3e-7.
        assert np.linalg.norm(M @ turned) < 1e-6 * np.linalg.norm(turned)


def _in_frame(linkage, point):
    """A point at the reference pose, in the frame of the left lower arm."""
    pose = linkage.places["left_lower"].pose
    return np.linalg.solve(pose, [*(np.add(point, [*elbows([0.0, 0.0])[0], 0.0])), 1.0])[:3]


@pytest.mark.slow
def test_an_arm_whose_reactionless_workspace_is_a_plane_of_its_inputs():
    """12 u1 + 4 u2 + u3 = 0 (the file of the arm), its wrist by two turned lengths."""
    linkage = kinematics.load("zero_reaction_arm")
    solution = balance.find_paths(linkage, fan=4, length=0.05)
    tool = tool_paths(linkage, solution.paths, "hand", poses=27)
    assert len(solution.paths) == 4
    upper, fore = complex(0.3, 0.4), complex(0.45, -0.1)
    for path, way in zip(solution.paths, tool.ways, strict=True):
        assert np.abs(path.u @ [12.0, 4.0, 1.0]).max() < 1e-9
        wrist = np.exp(1j * path.u[:, 0]) * upper + np.exp(1j * path.u[:, 1]) * fore
        assert way[:, 0] + 1j * way[:, 1] == pytest.approx(wrist, abs=1e-9)


@pytest.mark.slow
def test_pages_pictures_and_tables_show_the_tool():
    arm = arm_in_line(2)
    solution = balance.find_paths(arm, [[0.4, 0.9]], kept="moment", length=0.05)
    with_tool = solution.with_tool("link2")
    row, before = path_rows(with_tool), path_rows(solution)
    assert row[0][5] == "tool way (m)" and row[1][:5] == before[1][:5]
    way = with_tool.tool.ways[0]
    long = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    assert float(row[1][5]) == pytest.approx(long, rel=6e-3)
    assert dict(paths_facts(with_tool))["tool"].startswith("link2, its point at (0.9, 0, 0) m")
    page = Elements(paths_page(with_tool)).data("run")
    assert page["tool"]["ways"][0]["x"] == pytest.approx(way[:, 0], abs=1e-5)
    assert page["paths"][0]["trace"]["x"][-1] == pytest.approx(way[-1, 0], abs=1e-5)
    assert "tool" not in dict(paths_facts(solution))
    assert Elements(paths_page(solution)).data("run")["tool"] is None
    assert b"ways of link2" in paths_picture(with_tool, "svg")
    assert with_tool.to_dict()["tool"]["link"] == "link2" and solution.to_dict()["tool"] is None


def test_a_tool_that_does_not_exist_is_refused():
    with pytest.raises(BodyError, match="ghost"):
        balance.find_paths(arm_in_line(2), length=0.05).with_tool("ghost")
