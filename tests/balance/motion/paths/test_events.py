"""Why paths end: limits of joints, edges of the workspace, singular poses, lost directions."""

from __future__ import annotations

import numpy as np
import pytest

import balance
from balance.motion.paths.demand import Demand
from balance.motion.paths.rest_equations import RestEquations
from kinematics import ScrewJoint, from_screws, load
from kinematics.errors import PoseError
from tests.support.crossing_five_bar import crossing_five_bar

LIMITED = """<robot name="arm">
  <link name="base"/>
  <link name="one"><inertial><mass value="1"/><origin xyz="0.2 0 0"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="two"><inertial><mass value="1"/><origin xyz="0.1 0.05 0"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="u1" type="revolute"><parent link="base"/><child link="one"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="0.125" effort="1" velocity="1"/></joint>
  <joint name="u2" type="revolute"><origin xyz="0.4 0 0"/><parent link="one"/>
    <child link="two"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
</robot>"""


def ends(path):
    """Events at both ends of a path."""
    return path.events[0], path.events[-1]


def test_a_path_ends_at_the_limit_of_a_joint(robot):
    """One end at the limit, to 1e-10, the other as long as asked for."""
    found = balance.find_paths(robot(LIMITED), kept="moment", length=0.8)
    (path,) = found.paths
    (limit,) = [event for event in ends(path) if event.kind == "limit"]
    assert "u1" in limit.text and {event.kind for event in ends(path)} == {"limit", "length"}
    at = 0 if limit is path.events[0] else -1
    assert path.u[at, 0] == pytest.approx(0.125, abs=1e-10)
    assert path.u[:, 0].max() <= 0.125 + 1e-10
    assert path.s[at] == pytest.approx(limit.s)


def slider_crank():
    """Links of 1 m, stretched at 2 m; the slider leads, and a wheel turns against the crank."""
    tiny = np.diag([0.01, 0.01, 0.01])
    joints = [
        ScrewJoint("crank", "base", "one"),
        ScrewJoint("elbow", "one", "two", point=(0.8, 0.6, 0)),
        ScrewJoint("slide", "base", "block", axis=(1, 0, 0), kind="prismatic"),
        ScrewJoint("wheel", "base", "disk"),
    ]
    loop = ScrewJoint("pin", "two", "block", point=(1.6, 0, 0))
    bodies = {
        "one": (1.0, (0.1, 0.2, 0), tiny),
        "two": (1.0, (1.0, 0.4, 0), tiny),
        "block": (1.0, (1.6, 0, 0), tiny),
        "disk": (1.0, (0, 0, 0), np.diag([0.1, 0.1, 1.0])),
    }
    return from_screws(joints, [loop], bodies, inputs=["slide", "wheel"], name="slider")


@pytest.mark.slow
def test_a_path_ends_at_the_edge_of_the_workspace():
    """The slider of links of 1 m cannot pass 2 m, 0.4 m from the reference pose."""
    found = balance.find_paths(slider_crank(), kept="moment", length=6.0, step=0.05)
    (path,) = found.paths
    edges = [event for event in ends(path) if event.kind in ("edge", "singular")]
    assert [event.kind for event in edges] == ["singular", "edge"]
    assert path.u[:, 0].max() == pytest.approx(0.4, abs=1e-3)
    assert path.u[:, 0].max() <= 0.4 and path.reactionless


def test_a_start_at_a_singular_pose_is_refused():
    """Just short of stretched: one line that names the pose."""
    with pytest.raises(PoseError, match="singular one of the linkage; start elsewhere"):
        balance.find_paths(slider_crank(), [{"slide": 0.4 - 1e-9}], kept="moment")


def test_the_rank_of_the_momentum_matrix_drops_where_paths_meet():
    """Along the symmetry line of the five-bar, a singular value vanishes at the meeting."""
    robot = crossing_five_bar(-1e-3, 0.10392, 90.0)
    found = balance.find_paths(robot.linkage, [{"u1": 0.2, "u3": -0.2}], length=1.2)
    (path,) = found.paths
    (meeting,) = [event for event in path.events if event.kind == "meeting"]
    equations = RestEquations(robot.linkage, Demand())
    near = np.abs(path.s - meeting.s)
    rows, own = equations.along(path.q / equations.chain.units, path.rates)
    values = np.linalg.svd(rows, compute_uv=False)[:, 0] / own
    assert values[np.argmin(near)] < 1e-2 * values.max()
    assert np.argmin(values) == np.argmin(near)


def test_a_full_rank_matrix_and_an_isolated_pose_have_no_path():
    assert "full column rank in all of 9 poses" in balance.find_paths("five_bar").reason
    # Balanced in this pose alone, with nothing that forces balance around it.
    assert not balance.find_paths(load("four_bar_general")).paths
