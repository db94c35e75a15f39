"""Gallery files written as MJCF in several styles are read as the same linkages.

Each model is written in one style, and each style has all types of joints; all styles of all
models with ``ALL_CASES=1``.
"""

from pathlib import Path

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from kinematics.files.formats.robot_files import read_robot
from kinematics.model.document.element import Document
from tests.support.covering import covering_pairs, joint_types
from tests.support.mjcf_text import STYLES, Unwritable, mjcf_text

pytest.importorskip("mujoco")

MODELS = kinematics.gallery()
# MJCF has no screw joint, and the writer of these tests no relations of joints and no massless
# links that carry several others.
BRANCHES = {
    "principal_vector_linkage",
    "principal_vector_linkage_slider",
    "three_four_bars_platform",
    "two_rrr_bisector",
    "slider_pantograph",
    "pantograph_reaction_wheel",
}
WRITTEN = sorted(
    name
    for name, path in MODELS.items()
    if "<mimic" not in (text := path.read_text("utf-8"))
    and "<screw_thread_pitch" not in text
    and name not in BRANCHES
)
PAIRS = covering_pairs({name: joint_types(MODELS[name]) for name in WRITTEN}, STYLES)


@pytest.fixture(scope="module")
def spaces():
    """The linkage of each file, and its design space."""
    known = {}

    def find(name):
        if name not in known:
            linkage = kinematics.load(MODELS[name])
            known[name] = linkage, certify(design_space(linkage))
        return known[name]

    return find


@pytest.mark.table(1)
@pytest.mark.parametrize(("name", "style"), PAIRS)
def test_linkages_are_those_of_the_urdf_files(name, style, spaces, tmp_path):
    path = tmp_path / "model.xml"
    path.write_text(mjcf_text(Path(MODELS[name]).read_text(), style))
    (expected, space), found = spaces(name), kinematics.load(path)
    again = certify(design_space(found))
    assert found.mobility == expected.mobility
    assert [order.rank for order in again.orders] == [order.rank for order in space.orders]
    assert (again.planar, again.parts) == (space.planar, space.parts)
    # A spatial loop turned into frames of its own does not close in decimals: a doubt says so.
    assert again.certainty.level in ("proved", "verified") or again.certainty.doubts
    masses = {body.name: body.inertia for body in found.bodies}
    assert set(masses) == {body.name for body in expected.bodies}
    for body in expected.bodies:
        off = np.abs(masses[body.name] - body.inertia).max()
        assert off <= 1e-12 * np.abs(body.inertia).max()


@pytest.mark.table(4)
@pytest.mark.parametrize("style", STYLES)
@pytest.mark.parametrize("name", ["four_bar_general", "three_rsr_rational"])
def test_nothing_is_lost_to_exact_arithmetic(name, style, spaces, tmp_path):
    """Right angles and decimals come back, so that the same level of certainty is reached."""
    path = tmp_path / "model.xml"
    path.write_text(mjcf_text(Path(MODELS[name]).read_text(), style))
    found = certify(design_space(kinematics.load(path)))
    assert found.certainty.level == spaces(name)[1].certainty.level


def test_screw_joints_have_no_mjcf():
    with pytest.raises(Unwritable):
        mjcf_text(Path(MODELS["hprs"]).read_text(), "quats")


POINTS = """<mujoco><compiler {compiler}/><worldbody>
<body name="a" pos="{pos}" {turn}><joint name="j" {joint}/><geom size=".1"/></body>
</worldbody></mujoco>"""


def joint_of(**parts):
    values = {"compiler": "", "pos": "0.1 0.2 0.3", "turn": "", "joint": 'axis="0 0 1"'}
    text = POINTS.format(**{**values, **parts})
    tree = read_robot(Document("model", text.encode())).tree
    return next(joint for joint in tree.every("joint") if joint.name == "j")


@pytest.mark.parametrize(
    ("turn", "rpy"),
    [
        ('euler="90 0 0"', "1.5707963267948966 0 0"),
        ('euler="0 -90 0"', "0 -1.5707963267948966 0"),
        ('euler="0 0 15"', "0 0 0.2617993877991494"),
        ('axisangle="0 0 1 180"', "0 0 3.141592653589793"),
        ('quat="1 0 0 1"', "0 0 1.5707963267948966"),
        ('zaxis="1 0 0"', "0 1.5707963267948966 0"),
        ('euler="0 0 0"', None),
    ],
)
def test_right_angles_have_all_digits(turn, rpy):
    assert joint_of(turn=turn).first("origin").attributes.get("rpy") == rpy


def test_decimals_are_those_of_the_file():
    joint = joint_of(
        compiler='angle="radian"',
        turn='euler="0 0 0.3"',
        joint='axis="1 2 0" ref="1" range="-1 1"',
    )
    assert dict(joint.first("origin").attributes) == {"xyz": "0.1 0.2 0.3", "rpy": "0 0 0.3"}
    assert joint.first("axis").attributes["xyz"] == "1 2 0"


def test_frames_leave_no_round_off():
    text = """<mujoco><worldbody><frame pos="1 2 3" euler="90 0 0">
    <body pos="0 0 0.3"><joint name="j"/><geom size="1"/></body></frame></worldbody></mujoco>"""
    tree = read_robot(Document("model", text.encode())).tree
    (joint,) = tree.every("joint")
    assert joint.first("origin").attributes["xyz"] == "1 1.7 3"
