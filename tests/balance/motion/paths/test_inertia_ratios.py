"""Paths over ratios of inertia, and through poses: two links in closed form, and a five-bar.

Of two links the moment about the first joint vanishes if M11 q1' + M12 q2' = 0, so that q1 is
an integral over q2.
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from balance.app.answers.html.path_inertia import chart_picture
from balance.motion import inertia_chart, moments_through_poses
from balance.motion.paths.inertia_ratios import with_moments
from kinematics.errors import LinkageError
from tests.support.planned_arms import planar_arm
from tests.support.two_links import LENGTHS, MASSES, tip, turned


@pytest.mark.slow
def test_a_chart_of_two_links():
    factors = (0.25, 4.0)
    chart = inertia_chart(
        planar_arm(2), "link2", factors, [0.1, 0.7], kept="moment", length=0.2
    )
    assert chart.factors == factors
    for factor, solution in zip(factors, chart.solutions, strict=True):
        (path,) = solution.paths
        (a, b), (c, d) = path.u[[0, -1]]
        assert c - a == pytest.approx(turned(b, d, second=factor), abs=1e-9)
        mass, com, _ = balance.bodies.mass_properties(solution.linkage.bodies[1].inertia)
        assert mass == MASSES[1] and com[0] == pytest.approx(0.7)
    assert [entry["factor"] for entry in chart.to_dict()["charts"]] == list(factors)


def test_one_pose_more_determines_one_moment_of_inertia():
    target = [turned(0.4, 1.6, second=2.5), 1.6]
    answer = moments_through_poses(
        planar_arm(2), ["link2"], [[0.0, 0.4], target], kept="moment"
    )
    assert answer.reason == "" and answer.residual < 1e-9
    assert answer.factors == {"link2": pytest.approx(2.5, rel=1e-6)}
    assert answer.u[[0, -1]] == pytest.approx(np.array([[0.0, 0.4], target]), abs=1e-12)
    by_hand = [turned(0.4, q2, second=2.5) for q2 in answer.u[::40, 1]]
    assert answer.u[::40, 0] == pytest.approx(by_hand, abs=1e-8)


def test_a_point_of_the_tool_determines_it_too():
    """The tip on a path in closed form, with 2.5 of the inertia of the second link."""
    x, y = tip(turned(0.4, 1.6, second=2.5), 1.6) - (sum(LENGTHS), 0.0)
    answer = moments_through_poses(
        planar_arm(2),
        ["link2"],
        [[0.0, 0.4], {"x": x, "y": y}],
        kept="moment",
        tool=("link2", (LENGTHS[1], 0, 0)),
    )
    assert answer.factors == {"link2": pytest.approx(2.5, rel=1e-6)}
    assert tip(*answer.u[-1]) - (sum(LENGTHS), 0.0) == pytest.approx([x, y], abs=1e-9)


@pytest.mark.slow
def test_two_poses_more_determine_two_moments_of_inertia():
    """Those of a path in closed form; and the path of the new linkage, integrated."""
    given = {"first": 0.5, "second": 3.0}
    poses = [[0.0, 0.4], *([turned(0.4, q2, **given), q2] for q2 in (1.2, 2.4))]
    answer = moments_through_poses(planar_arm(2), ["link1", "link2"], poses, kept="moment")
    assert answer.factors == {
        "link1": pytest.approx(0.5, rel=1e-4),
        "link2": pytest.approx(3.0, rel=1e-4),
    }
    start = [poses[0]]
    (path,) = balance.find_paths(answer.linkage, start, kept="moment", length=3.0).paths
    order = np.argsort(path.u[:, 1])
    for first, second in poses[1:]:
        assert path.u[order[0], 1] < second < path.u[order[-1], 1]
        reached = np.interp(second, path.u[order, 1], path.u[order, 0])
        assert reached == pytest.approx(first, abs=1e-5)


@pytest.mark.slow
def test_a_path_of_a_five_bar_gives_its_masses_back():
    """A path that is integrated, step by step, with 1.7 of the inertia of a link."""
    linkage = kinematics.load("five_bar")
    scaled = with_moments(linkage, {"left_lower": 1.7})
    (path,) = balance.find_paths(scaled, kept="moment", length=0.3).paths
    middle = int(np.abs(path.s).argmin())
    poses = path.u[[middle, -1]]
    answer = moments_through_poses(linkage, ["left_lower"], poses, kept="moment")
    assert answer.factors == {"left_lower": pytest.approx(1.7, rel=1e-5)}
    distances = np.linalg.norm(answer.u[:, None] - path.u[middle:], axis=2)
    assert distances.min(axis=1).max() < 5e-3


@pytest.mark.slow
def test_why_there_is_no_such_path():
    """Two links on a fixed base always shake it by a force."""
    answer = moments_through_poses(planar_arm(2), ["link2"], [[0.0, 0.4], [0.1, 0.9]])
    assert "no such path was found: the least momentum is" in answer.reason


@pytest.mark.parametrize(
    ("links", "poses", "options", "words"),
    [
        (["ghost"], [[0, 0], [1, 1]], {}, "ghost"),
        ([], [[0, 0], [1, 1]], {}, "give links"),
        (["link2"], [[0, 0]], {}, "two poses or more"),
        (["link2"], [[0, 0], [0, 0]], {}, "are one"),
        (["link2"], [[0, 0], [1]], {}, "2 displacements"),
        (["link2"], [[0, 0], [1, 1]], {"kept": "force"}, "no moments of inertia"),
    ],
)
def test_requests_that_are_refused(links, poses, options, words):
    with pytest.raises(LinkageError, match=words):
        moments_through_poses(planar_arm(2), links, poses, **options)


def test_factors_that_are_refused():
    with pytest.raises(LinkageError, match="one above 0"):
        inertia_chart(planar_arm(2), "link1", [0.0])
    with pytest.raises(LinkageError, match="give factors"):
        inertia_chart(planar_arm(2), "link1", [])


@pytest.mark.slow
def test_a_picture_of_a_chart():
    chart = inertia_chart(
        planar_arm(2), "link2", [0.5, 2.0], [0.1, 0.7], kept="moment", length=0.1, tool="link2"
    )
    picture = chart_picture(chart, "svg")
    assert b"0.5 of the inertia of link2" in picture and b"2 of the inertia" in picture
    ways = [solution.tool.ways[0] for solution in chart.solutions]
    assert np.linalg.norm(ways[0][-1] - ways[1][-1]) > 1e-4
