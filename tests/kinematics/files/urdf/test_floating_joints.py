"""Floating joints: that of a base is refused or fixed, those of platforms are six joints."""

import numpy as np
import pytest

import kinematics
from balance import certify, design_space
from balance.app.cli.main import main
from kinematics.errors import FileError
from kinematics.files.urdf.write_closed_pose import write_at_reference_pose
from tests.support.dialect_text import answer
from tests.support.urdf_text import UNIT_INERTIA, about, along, joint, link, loop, saved

AXIS = [0, 0, 1]
# A four-bar linkage whose coupler is 1.5 m long, from (0, 1, 0) to (1.5, 1, 0).
LINKS = (link("base"), *(link(name, **UNIT_INERTIA) for name in ("crank", "coupler", "rocker")))
CRANK = joint("j1", "revolute", "base", "crank", axis=AXIS)
ROCKER = joint("j3", "revolute", "base", "rocker", along([2, 0, 0]), AXIS)
LEFT = loop("k1", "revolute", ("crank", "coupler"), (along([0, 1, 0]), np.eye(4)), AXIS)
RIGHT = loop(
    "k2", "revolute", ("coupler", "rocker"), (along([1.5, 0, 0]), along([-0.5, 1, 0])), AXIS
)
FREE = joint("free", "floating", "base", "coupler", along([0, 1, 0]))
HANGING = joint("j2", "revolute", "crank", "coupler", along([0, 1, 0]), AXIS)
PLATFORM = (*LINKS, CRANK, ROCKER, FREE, LEFT, RIGHT)
MJCF = """<mujoco model="four_bar"><compiler autolimits="true"/><worldbody>
<body name="crank"><joint name="j1" axis="0 0 1"/>{mass}</body>
<body name="rocker" pos="2 0 0"><joint name="j3" axis="0 0 1"/>{mass}</body>
<body name="coupler" pos="0 1 0"><freejoint name="free"/>{mass}</body></worldbody><equality>
<connect body1="crank" body2="coupler" anchor="0 1 0"/>
<connect body1="crank" body2="coupler" anchor="0 1 1"/>
<connect body1="coupler" body2="rocker" anchor="1.5 0 0"/>
<connect body1="coupler" body2="rocker" anchor="1.5 0 1"/></equality></mujoco>"""
MASS = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'


def notices(linkage):
    return {notice.code: notice.message for notice in linkage.notices}


@pytest.fixture(params=["urdf", "mjcf"])
def platform(request, tmp_path):
    """The four-bar linkage with a floating coupler, as either format."""
    if request.param == "urdf":
        return saved(tmp_path, *PLATFORM)
    path = tmp_path / "robot.xml"
    path.write_text(MJCF.format(mass=MASS), encoding="utf-8")
    return path


def test_a_platform_that_floats_is_the_same_linkage(platform, tmp_path):
    """As with the tree cut elsewhere: the coupler on the crank, one loop."""
    same = answer(saved(tmp_path, *LINKS, CRANK, HANGING, ROCKER, RIGHT, name="same"))
    ranks, nullity, bodies, level = answer(platform)
    assert (ranks[-1], nullity) == (same[0][-1], same[1])
    assert (same[3], level) == ("proved", "verified")  # two loops out of the plane
    assert set(bodies) == set(same[2])


def test_fixing_the_base_leaves_the_platform_alone(platform):
    linkage = kinematics.load(platform, fix_base=True)
    assert linkage.mobility == 1
    assert "'coupler': 'free' (floating); not a base" in notices(linkage)["floating"]
    assert "base_fixed" not in notices(linkage)


def test_a_body_that_a_hand_holds_floats(tmp_path):
    """By six coordinates, whose screws are independent."""
    parts = (link("base"), link("hand", **UNIT_INERTIA), link("ball", **UNIT_INERTIA))
    arm = joint("j", "revolute", "base", "hand", axis=AXIS)
    path = saved(
        tmp_path, *parts, arm, joint("f", "floating", "hand", "ball", along([1, 0, 0]))
    )
    linkage = kinematics.load(path)
    assert [j.name for j in linkage.joints] == ["j", *(f"f.{k}" for k in range(6))]
    screws = np.array([joint.screw for joint in linkage.joints[1:]])
    assert np.linalg.matrix_rank(screws) == 6 and linkage.mobility == 7


def test_of_two_robots_that_float_both_are_bases(tmp_path):
    """And a body beside them, with nothing on it, is not."""
    names = ("world", "one", "arm1", "two", "arm2", "ball")
    parts = [link("world"), *(link(name, **UNIT_INERTIA) for name in names[1:])]
    parts += [joint(f"f{name}", "floating", "world", name) for name in ("one", "two", "ball")]
    parts += [
        joint(f"j{k}", "revolute", a, f"arm{k}", axis=AXIS) for k, a in ((1, "one"), (2, "two"))
    ]
    path = saved(tmp_path, *parts)
    with pytest.raises(
        FileError, match="joint 'fone'.*a floating joint of the base.*--fix-base"
    ):
        kinematics.load(path)
    linkage = kinematics.load(path, fix_base=True)
    told = notices(linkage)
    assert linkage.mobility == 8 and "'one', 'two' to the ground" in told["base_fixed"]
    assert "'ball'" in told["floating"] and "'two'" not in told["floating"]


def test_a_loop_holds_a_base(tmp_path):
    """It floats as long as the user does not fix it; a weld to the ground makes it no base."""
    parts = [link("world"), *(link(name, **UNIT_INERTIA) for name in ("torso", "leg"))]
    parts += [
        joint("f", "floating", "world", "torso", about([1, 0, 0], 0.3, [0, 0, 1])),
        joint("j", "revolute", "torso", "leg", along([0.3, 0, 0]), AXIS),
    ]
    frame = about([1, 0, 0], 0.3, [0, 0, 1]) @ along([0.3, 0, 0])
    ball = loop("k", "spherical", ("world", "leg"), (frame, np.eye(4)))
    assert kinematics.load(saved(tmp_path, *parts, ball)).mobility == 4
    weld = loop("k", "fixed", ("world", "torso"), (about([1, 0, 0], 0.3, [0, 0, 1]), np.eye(4)))
    for fixed in (False, True):
        assert kinematics.load(saved(tmp_path, *parts, weld), fix_base=fixed).mobility == 1


def test_a_floating_joint_closes_no_loop(tmp_path):
    path = saved(
        tmp_path, *LINKS, CRANK, HANGING, ROCKER, RIGHT.replace("revolute", "floating")
    )
    with pytest.raises(FileError, match="loop 'k2'.*closes no loop"):
        kinematics.load(path)


def test_floating_joints_are_written(tmp_path, caplog):
    """By the writer of linkages, and at the pose at which open loops close."""
    open_too = PLATFORM[:-2] + (LEFT, RIGHT.replace("1.5 0.0", "1.4 0.0"))
    linkage = kinematics.load(saved(tmp_path, *open_too))
    assert 'type="floating"' in linkage.to_urdf()
    for k, data in enumerate(
        (linkage.to_urdf().encode(), write_at_reference_pose(linkage).data)
    ):
        path = tmp_path / f"written{k}.urdf"
        path.write_bytes(data)
        again = kinematics.load(path)
        assert "assembled" not in notices(again), notices(again)
        assert again.mobility == 1
        ranks = [certify(design_space(each)).orders[-1].rank for each in (linkage, again)]
        assert ranks == [8, 8]
    assert main(["report", str(saved(tmp_path, *PLATFORM)), "--fix-base"]) == 0
    assert "not a base, and not fixed" in caplog.text
