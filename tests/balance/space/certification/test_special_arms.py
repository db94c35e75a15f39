"""Arms whose axes are parallel, perpendicular, or meet up to the rounding of an exporter."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinematics
from balance import certify, design_space
from tests.independent.reference import load, rank_over_poses

QUARTER = np.pi / 2
# Joint, kind, link before and after, origin, rotation about x, y, z, and whom it mimics.
ARM = (
    ("yaw", "revolute", "base", "turret", (0, 0, 0), (QUARTER, 0, -QUARTER), None),
    ("p0", "revolute", "turret", "arm", (0, 0, 0), (-QUARTER, -QUARTER, QUARTER), None),
    ("p1", "revolute", "arm", "rod", (-0.098, -0.209, 0), (0, 0, QUARTER - 0.3), ("p0", 1)),
    ("p2", "revolute", "rod", "yoke", (0.3, 0, 0), (0, 0, 0.3), ("p0", -1)),
    ("p3", "revolute", "yoke", "tip", (0.31, 0.05, 0), (0, 0, 0.1), ("p0", 1)),
    ("ins", "prismatic", "tip", "slide", (0.05, 0.1, 0), (QUARTER, 0, -QUARTER), None),
    ("roll", "revolute", "slide", "tool", (0, 0, 0.383), (0, 0, 0), None),
)


def displacement(xyz, rpy):
    H = np.eye(4)
    H[:3, :3], H[:3, 3] = Rotation.from_euler("xyz", rpy).as_matrix(), xyz
    return H


def arm(folder, digits, tilt, off=0.0):
    """The arm in SDF, in absolute poses of so many digits, on a base that is tilted."""
    poses = {"base": displacement((0, 0, 0), (0, tilt, tilt / 2))}
    for name, _, before, after, xyz, rpy, _ in ARM:
        turn = np.add(rpy, (off, 0, 0)) if name == "p1" else rpy
        poses[after] = poses[before] @ displacement(xyz, turn)
    lines = [
        "<sdf version='1.6'><model name='arm'><joint name='fix' type='fixed'>"
        "<parent>world</parent><child>base</child></joint>"
    ]
    for k, (link, H) in enumerate(poses.items()):
        numbers = (*H[:3, 3], *Rotation.from_matrix(H[:3, :3]).as_euler("xyz"))
        text = " ".join(f"{x:.{digits}g}" for x in numbers)
        lines.append(
            f"<link name='{link}'><pose>{text}</pose><inertial><mass>{1 + k / 10}</mass>"
            "<pose>0.01 0.02 -0.03 0 0 0</pose><inertia><ixx>0.01</ixx><iyy>0.012</iyy>"
            "<izz>0.009</izz><ixy>0.001</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial></link>"
        )
    for name, kind, before, after, *_, source in ARM:
        mimic = (
            ""
            if source is None
            else (
                f"<mimic joint='{source[0]}'><multiplier>{source[1]}</multiplier>"
                "<offset>0</offset><reference>0</reference></mimic>"
            )
        )
        lines.append(
            f"<joint name='{name}' type='{kind}'><parent>{before}</parent>"
            f"<child>{after}</child><axis><xyz>0 0 1</xyz>{mimic}</axis></joint>"
        )
    path = folder / "arm.sdf"
    path.write_text("\n".join([*lines, "</model></sdf>"]))
    return path


def space_of(path, **options):
    return certify(design_space(kinematics.load(str(path), **options)))


def message(space, code):
    (text,) = [n.message for n in space.notices if n.code == code and "conditions" in n.message]
    return text


# All axes along those of the frame, so that the rounding of rotations makes no difference.
SPECIAL = 32


@pytest.mark.filterwarnings("ignore:Gimbal lock")
def test_the_rank_of_the_arm_with_axes_along_those_of_the_frame(tmp_path):
    assert space_of(arm(tmp_path, 17, 0.0)).rank == SPECIAL


@pytest.mark.slow
def test_an_arm_in_all_digits_of_doubles_is_special_and_both_ranks_are_told(tmp_path):
    path = arm(tmp_path, 17, 0.4)
    space = space_of(path)
    assert space.rank == SPECIAL and space.level in ("proved", "verified")
    text = message(space, "special_as_meant")
    assert f"{SPECIAL} are meant" in text and "ins perpendicular to p3" in text
    as_written = space_of(path, angles="as_written")
    assert as_written.rank > SPECIAL
    assert f"{as_written.rank} conditions" in text


@pytest.mark.slow
@pytest.mark.parametrize("digits", [6, 9])
def test_an_arm_in_fewer_digits_tells_both_ranks(tmp_path, digits):
    space = space_of(arm(tmp_path, digits, 0.4))
    if space.rank != SPECIAL:
        text = message(space, "near_special")
        assert f"with {SPECIAL} conditions" in text and f"{space.rank} conditions" in text


@pytest.mark.slow
def test_an_arm_that_is_tilted_on_purpose_is_general(tmp_path):
    space = space_of(arm(tmp_path, 17, 0.4, off=1e-3))
    assert space.rank > SPECIAL
    assert not [
        n
        for n in space.notices
        if n.code in ("special_as_meant", "near_special") and f"{SPECIAL} " in n.message
    ]


def two_drives(folder, turn, digits):
    """A slide, and beside it an arm of two joints whose first turns as the slide moves."""
    slide, across = Rotation.from_rotvec(turn).apply([[0, 0, 1], [1, 0, 0]])
    places = Rotation.from_rotvec(turn).apply([[0.3, 0, 0], [2, 0.4, 0.5], [0, 1.2, 0.9]])
    joints = (
        ("lift", "prismatic", "base", "table", slide, ""),
        ("swing", "continuous", "base", "arm", across, '<mimic joint="lift"/>'),
        ("turn", "continuous", "arm", "hand", slide, ""),
    )

    def text(values):
        return " ".join(f"{x + 0.0:.{digits}g}" for x in np.round(values, 15))

    lines = ['<robot name="two"><link name="base"/>']
    for (name, kind, before, after, axis, mimic), place in zip(joints, places, strict=True):
        lines.append(
            f'<link name="{after}"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="1"/>'
            '<inertia ixx="0.2" iyy="0.25" izz="0.3" ixy="0.01" ixz="0" iyz="0"/></inertial>'
            f'</link><joint name="{name}" type="{kind}"><origin xyz="{text(place)}"/>'
            f'<parent link="{before}"/><child link="{after}"/><axis xyz="{text(axis)}"/>{mimic}'
            "</joint>"
        )
    path = folder / "two.urdf"
    path.write_text("".join(lines) + "</robot>")
    return path


@pytest.mark.parametrize("digits", [6, 9, 12])
def test_joints_of_one_link_are_perpendicular_where_a_turned_file_rounds_it(tmp_path, digits):
    def space(turn, digits):
        path = two_drives(tmp_path, turn, digits)
        return certify(design_space(path, motion="turn=1*lift", spatial=True))

    along = space((0, 0, 0), 17)
    turned = space((0.3, -0.5, 0.7), digits)
    assert along.level in ("proved", "verified")
    assert (turned.rank, turned.level) == (along.rank, "verified")


def gripper(folder, second_axis, fingers=12):
    """A wrist of two joints, and fingers along axes of many directions that follow one."""
    rng = np.random.default_rng(38)
    axes = rng.standard_normal((fingers, 3))
    joints = [
        ("first", "base", "forearm", (0, 0, 0.2), "0.6 0 0.8", ""),
        ("second", "forearm", "palm", (0.1, 0.3, 0.1), second_axis, ""),
    ]
    for k, axis in enumerate(axes / np.linalg.norm(axes, axis=1)[:, None]):
        words = " ".join(f"{x:.10f}" for x in axis)
        mimic = f'<mimic joint="f0" multiplier="{(-1) ** k}"/>' if k else ""
        joints.append((f"f{k}", "palm", f"finger{k}", rng.uniform(-0.2, 0.2, 3), words, mimic))
    lines = ['<robot name="gripper"><link name="base"/>']
    for name, before, after, place, axis, mimic in joints:
        lines.append(
            f'<link name="{after}"><inertial><origin xyz="0.03 0.02 0.05"/><mass value="1"/>'
            '<inertia ixx="0.2" iyy="0.25" izz="0.3" ixy="0.01" ixz="0" iyz="0"/></inertial>'
            f'</link><joint name="{name}" type="continuous"><parent link="{before}"/>'
            f'<origin xyz="{" ".join(f"{x:.4f}" for x in place)}"/>'
            f'<child link="{after}"/><axis xyz="{axis}"/>{mimic}</joint>'
        )
    path = folder / "gripper.urdf"
    path.write_text("".join(lines) + "</robot>")
    return path


def test_joints_of_many_directions_that_follow_one_are_exact_where_others_are_read_as_parallel(
    tmp_path,
):
    """Their rates compare lengths of axes: irrational ones needed a root for each direction."""
    rounded = space_of(gripper(tmp_path, "0.60000000002 0 0.79999999998"))
    assert rounded.level in ("proved", "verified"), rounded.certainty.reason
    parallel = load(gripper(tmp_path, "0.6 0 0.8"), ("first", "second", "f0"))
    assert rounded.rank == rank_over_poses(parallel).rank
    assert rounded.certainty.rank == rounded.rank
