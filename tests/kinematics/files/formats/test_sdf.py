"""SDF: poses, axes, screws, mimics, the graph of joints, and what is refused."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest

from kinematics.files.formats.robot_files import read_robot, read_unassembled
from tests.support.urdf_text import about, along, pose_of, refusal, screw

INERTIAL = (
    "<inertial><pose>0.1 0.2 0.3 0 0 0.4</pose><mass>2</mass><inertia><ixx>1</ixx><iyy>2</iyy>"
    "<izz>2.5</izz><ixy>0.1</ixy></inertia></inertial>"
)


def link(name, pose="", inside=INERTIAL, marks=""):
    return f'<link name="{name}"><pose {marks}>{pose}</pose>{inside}</link>'


def joint(name, kind, parent, child, xyz="0 0 1", inside="", marks="", axis=""):
    line = f"<axis><xyz {marks}>{xyz}</xyz>{axis}</axis>" if xyz else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f"{inside}{line}</joint>"
    )


def sdf(*parts, version="1.9", marks=""):
    inside = "".join(parts)
    return f'<sdf version="{version}"><model name="m" {marks}>{inside}</model></sdf>'


@pytest.fixture
def saved(tmp_path):
    def save(text, name="robot.sdf"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return path

    return save


def joints(path):
    return {item.name: item for item in read_unassembled(path).joints}


BASE, ARM = link("base"), link("arm", "1 2 3 0.1 0.2 0.3")
THERE = pose_of([1, 2, 3], [0.1, 0.2, 0.3])


@pytest.mark.parametrize(
    ("pose", "marks", "expected"),
    [
        ("1 2 3 0.1 0.2 0.3", "", THERE),
        ("1 2 3 10 20 30", 'degrees="true"', pose_of([1, 2, 3], np.radians([10, 20, 30]))),
        (
            "1 2 3 0 0 0.6 0.8",
            'rotation_format="quat_xyzw"',
            pose_of([1, 2, 3], [0, 0, 2 * math.atan2(0.6, 0.8)]),
        ),
        (
            "1 2 3 0 0 1.2 1.6",
            'rotation_format="quat_xyzw"',
            pose_of([1, 2, 3], [0, 0, 2 * math.atan2(0.6, 0.8)]),
        ),
        (
            "1 0 0 0 0 0",
            'relative_to="near"',
            pose_of([0, 2, 0], [0, 0, 0.5]) @ along([1, 0, 0]),
        ),
        ("1 0 0 0 0 0", 'relative_to="base"', along([1, 0, 0])),
        ("", "", np.eye(4)),
    ],
)
def test_poses(saved, pose, marks, expected):
    near = '<frame name="near"><pose>0 2 0 0 0 0.5</pose></frame>'
    path = saved(
        sdf(BASE, near, link("arm", pose, marks=marks), joint("j", "revolute", "base", "arm"))
    )
    draft = read_unassembled(path)
    assert np.abs(draft.places["arm"].pose - expected).max() < 1e-12
    found = draft.joints[0].screw
    assert np.abs(found - screw(expected[:3, 2], expected[:3, 3])).max() < 1e-12


@pytest.mark.parametrize("attached", ["base", "j", "arm", "other"])
def test_frames_may_stand_for_links(saved, attached):
    """The pose of a frame is by default in what it is attached to, a joint's in its child."""
    frames = (
        f'<frame name="here" attached_to="{attached}"><pose>0 0 1 0.5 0 0</pose></frame>'
        '<frame name="other" attached_to="base"><pose>5 0 0 0 0 0</pose></frame>'
    )
    tip = link("tip")
    two = joint(
        "k", "revolute", "here", "tip", inside='<pose relative_to="here">1 0 0 0 0 0</pose>'
    )
    path = saved(sdf(BASE, ARM, tip, frames, joint("j", "revolute", "base", "arm"), two))
    at = {"base": np.eye(4), "other": along([5, 0, 0])}.get(attached, THERE)
    frame = at @ pose_of([0, 0, 1], [0.5, 0, 0]) @ along([1, 0, 0])
    k = joints(path)["k"]
    assert np.abs(k.screw - screw(frame[:3, 2], frame[:3, 3])).max() < 1e-12
    assert k.parent == (-1 if attached in ("base", "other") else 0)


@pytest.mark.parametrize("version", ["1.4", "1.5", "1.6", "1.7", "1.12"])
@pytest.mark.parametrize("marks", ["", "model", "base"])
def test_frames_of_axes(saved, version, marks):
    """The model's before 1.5, the joint's since; or the one that is named."""
    flag, name = "", ""
    if marks == "model":
        flag = "<use_parent_model_frame>1</use_parent_model_frame>"
    elif marks:
        name = 'expressed_in="turned"'
    turned = '<frame name="turned"><pose>9 9 9 1 0 0</pose></frame>'
    j = joint(
        "j",
        "prismatic",
        "base",
        "arm",
        "1 0.5 2",
        marks=name,
        axis=flag,
        inside="<pose>0 0 1 0 0.7 0</pose>",
    )
    found = joints(saved(sdf(BASE, ARM, turned, j, version=version)))["j"].screw
    R = (THERE @ pose_of([0, 0, 1], [0, 0.7, 0]))[:3, :3]
    if marks == "model" or version == "1.4":
        R = np.eye(3)
    elif marks:
        R = pose_of([0, 0, 0], [1, 0, 0])[:3, :3]
    n = R @ [1, 0.5, 2]
    assert np.abs(found[3:] - n / np.linalg.norm(n)).max() < 1e-12


@pytest.mark.parametrize(
    ("line", "pitch"),
    [
        ("<screw_thread_pitch>0.01</screw_thread_pitch>", 0.01),
        ("<thread_pitch>-20</thread_pitch>", 2 * math.pi / 20),
        ("<thread_pitch>20</thread_pitch>", -2 * math.pi / 20),
        ("<thread_pitch>5</thread_pitch><screw_thread_pitch>0.3</screw_thread_pitch>", 0.3),
    ],
)
@pytest.mark.parametrize("turned", [False, True])
def test_screws(saved, line, pitch, turned):
    """Right-handed for a positive new pitch: metres per turn; the old one is -rad/m."""
    ends = ("arm", "base") if turned else ("base", "arm")
    world = joint("w", "fixed", "world", "base", "")
    j = joint("j", "screw", *ends, inside=f'{line}<pose relative_to="arm"/>')
    found = joints(saved(sdf(BASE, ARM, world, j, version="1.12")))["j"].screw
    sign = -1 if turned else 1
    expected = screw(sign * THERE[:3, 2], THERE[:3, 3], pitch / (2 * math.pi))
    assert np.abs(found - expected).max() < 1e-12


def test_mimics(saved):
    """Position: multiplier × (that of the leader - reference) + offset."""
    mimic = (
        '<mimic joint="j" axis="axis"><multiplier>-2</multiplier><offset>0.5</offset>'
        "<reference>0.25</reference></mimic>"
    )
    two = joint("k", "revolute", "arm", "tip", axis=mimic)
    path = saved(
        sdf(BASE, ARM, link("tip", "1 2 4 0 0 0"), joint("j", "revolute", "base", "arm"), two)
    )
    draft = read_unassembled(path)
    (found,) = draft.mimics
    assert (draft.joints[found.joint].name, found.ratio) == ("k", -2.0)
    tip = draft.places["tip"].pose
    at = along([1, 2, 4]) @ about([0, 0, 1], 1.0)
    assert np.abs(tip - at).max() < 1e-12


def test_inertias(saved):
    """In frames of their own, about the centre of mass; moved with the frame of a joint."""
    place = "<pose>0.3 0.1 0.2 0.4 -0.3 0.2</pose>"
    path = saved(sdf(BASE, ARM, joint("j", "revolute", "base", "arm", inside=place)))
    (body,) = read_unassembled(path).bodies
    frame = THERE @ pose_of([0.1, 0.2, 0.3], [0, 0, 0.4])
    inertia = frame[:3, :3] @ [[1, 0.1, 0], [0.1, 2, 0], [0, 0, 2.5]] @ frame[:3, :3].T
    com = frame[:3, 3]
    E = inertia + 2 * (com @ com * np.eye(3) - np.outer(com, com))
    expected = [2, *(2 * com), E[0, 0], E[1, 1], E[2, 2], E[0, 1], E[0, 2], E[1, 2]]
    assert np.abs(body.inertia - expected).max() < 1e-12
    assert "link_frames" in dict(read_robot(path).remarks)


def test_missing_masses_are_told(saved):
    """No ``<inertial>``: no mass; parts of it: the defaults of SDF."""
    half = link("half", inside="<inertial><mass>3</mass></inertial>")
    auto = link("auto", inside='<inertial auto="true"/>')
    made = [joint(f"to_{n}", "revolute", "base", n) for n in ("arm", "half", "auto", "none")]
    path = saved(sdf(BASE, ARM, half, auto, link("none", inside=""), *made))
    remarks = dict(read_robot(path).remarks)
    assert "'auto', 'none'" in remarks["no_inertial"]
    assert "'half'" in remarks["default_inertial"] and "'arm'" not in str(remarks)
    bodies = {body.name: body.inertia for body in read_unassembled(path).bodies}
    assert set(bodies) == {"arm", "half"}
    assert bodies["half"].tolist() == [3, 0, 0, 0, 1, 1, 1, 0, 0, 0]


def test_the_ground(saved):
    """The world, or else the link without a parent, with a remark."""
    one = joint("j", "revolute", "base", "arm")
    free = saved(sdf(BASE, ARM, one))
    assert "'base'" in dict(read_robot(free).remarks)["base_taken_as_fixed"]
    still = link("base", inside=""), joint("w", "fixed", "world", "base", "")
    held = saved(sdf(ARM, one, *still), "held.sdf")
    assert not read_robot(held).remarks
    here, there = (joints(path)["j"].screw for path in (free, held))
    assert np.array_equal(here, there)
    hinged = saved(sdf(BASE, ARM, one, joint("w", "revolute", "world", "base")), "hinged.sdf")
    assert set(joints(hinged)) == {"j", "w"}


def test_locked_joints_are_told(saved):
    limit = "<limit><lower>0</lower><upper>0</upper></limit>"
    path = saved(sdf(BASE, ARM, joint("j", "revolute", "base", "arm", axis=limit)))
    assert "'j'" in dict(read_robot(path).remarks)["locked_joints"]


def test_numbers_keep_their_digits(saved):
    """Also those of poses that are relative to the model: they become chains of origins."""
    arm = link("arm", "0.10 0 0 0 0 1.5708")
    tip = link("tip", "0.30 0.20 0 0 0 0.7854")
    made = joint("j", "revolute", "base", "arm"), joint("k", "revolute", "arm", "tip")
    text = read_robot(saved(sdf(BASE, arm, tip, *made))).document.data.decode()
    origins = [item.attrib for item in ElementTree.fromstring(text).findall("joint/origin")]
    assert origins == [
        {"xyz": "0.10 0 0", "rpy": "0 0 1.5708"},
        {"xyz": "0.20 0.20 0", "rpy": "0 0 0.7854"},
        {"rpy": "0 0 -1.5708"},
    ]


RING = (
    BASE,
    *(link(n) for n in "abc"),
    joint("w", "fixed", "world", "base", ""),
    joint("ja", "revolute", "base", "a"),
    joint("jb", "revolute", "a", "b", inside="<pose>1 0 0 0 0 0</pose>"),
    joint("jc", "revolute", "base", "c", inside="<pose>0 1 0 0 0 0</pose>"),
)


@pytest.mark.parametrize("ends", [("b", "c"), ("c", "b")])
def test_a_joint_to_a_carried_link_is_a_loop(saved, ends):
    close = joint("close", "revolute", *ends, inside="<pose>1 1 0 0 0 0</pose>")
    draft = read_unassembled(saved(sdf(*RING, close)))
    (loop,) = draft.loops
    assert loop.name == "close" and np.array_equal(loop.gap, np.eye(4))
    found = next(item for item in draft.joints if item.name == "close")
    assert found.in_loop and np.abs(found.screw - screw([0, 0, 1], [1, 1, 0])).max() < 1e-15
    assert draft.joints[found.parent].name == {"b": "jb", "c": "jc"}[ends[0]]


def test_a_screw_or_mimic_that_closes_a_loop(saved):
    """It is a joint of the tree, and the loop is a weld."""
    close = joint(
        "close", "screw", "b", "c", inside="<screw_thread_pitch>1</screw_thread_pitch>"
    )
    draft = read_unassembled(saved(sdf(*RING, close)))
    found = next(item for item in draft.joints if item.name == "close")
    assert found.kind == "helical" and not found.in_loop and len(draft.loops) == 1
    mimic = '<mimic joint="ja"><multiplier>1</multiplier></mimic>'
    close = joint("close", "revolute", "b", "c", axis=mimic)
    assert len(read_unassembled(saved(sdf(*RING, close))).mimics) == 1


def test_joints_the_other_way(saved):
    """Parent and child are exchanged; the coordinate is that of the file."""
    made = joint("j", "revolute", "arm", "base", inside="<pose>0.5 0 0 0 0 0</pose>")
    world = joint("w", "fixed", "world", "base", "")
    (found,) = read_unassembled(saved(sdf(BASE, ARM, made, world))).joints
    assert np.abs(found.screw - screw([0, 0, -1], [0.5, 0, 0])).max() < 1e-15


REFUSED = {
    "nested model without a name": (sdf(BASE, "<model/>"), "without a name"),
    "include": (sdf(BASE, "<include><uri>model://arm</uri></include>"), "<include>"),
    "gripper": (sdf(BASE, '<gripper name="g"/>'), "gripper 'g'"),
    "gearbox": (sdf(BASE, ARM, joint("j", "gearbox", "base", "arm")), "gearbox"),
    "static": (sdf(BASE, "<static>true</static>"), "static"),
    "two models": ('<sdf version="1.9"><model name="a"/><model name="b"/></sdf>', "'a', 'b'"),
    "old": (sdf(BASE, version="1.3"), "version '1.3'"),
    "no version": ("<sdf><model/></sdf>", "no version"),
    "no model": ('<sdf version="1.9"/>', "no <model>"),
    "no link": (sdf(), "no <link>"),
    "cycle": (sdf(link("base", marks='relative_to="base"')), "relative to itself"),
    "frame": (sdf(link("base", marks='relative_to="x"')), "'x'"),
    "pose": (sdf(link("base", "1 2 3")), "6 finite numbers"),
    "comma": (sdf(link("base", "1,0 2 3 0 0 0")), "6 finite numbers"),
    "flag": (sdf(link("base", "1 2 3 0 0 0", marks='degrees="deg"')), "'deg'"),
    "form": (sdf(link("base", "1 2 3 0 0 0", marks='rotation_format="x"')), "'x'"),
    "quaternion": (
        sdf(link("base", "1 2 3 0 0 0 0", marks='rotation_format="quat_xyzw"')), "quaternion"),
    "attribute": (sdf(link("base", "1 2 3 0 0 0", marks='relative-to="x"')), "relative_to"),
    "no axis": (sdf(BASE, ARM, joint("j", "revolute", "base", "arm", "")), "no <axis>"),
    "zero axis": (sdf(BASE, ARM, joint("j", "revolute", "base", "arm", "0 0 0")), "zero"),
    "no pitch": (sdf(BASE, ARM, joint("j", "screw", "base", "arm")), "screw_thread_pitch"),
    "no parent": (sdf(BASE, '<joint name="j" type="fixed"><child>base</child></joint>'),
                  "no <parent>"),
    "unknown link": (sdf(BASE, joint("j", "revolute", "base", "arn")), "'arn'"),
    "apart": (sdf(BASE, ARM), "more than one root"),
    "child world": (sdf(BASE, joint("j", "revolute", "base", "world")), "world"),
    "misspelt": (sdf(BASE, "<Joint/>"), "write <joint>"),
    "products": (sdf(BASE, link("a", inside="<inertial><inertia><iyx>1</iyx></inertia>"
                                            "</inertial>")), "ixy"),
    "inside": (sdf(BASE, f"<group>{ARM}</group>"), "move it out"),
    "drake": (sdf(BASE, '<drake:joint name="d"/>', marks='xmlns:drake="d"'), "drake:joint"),
    "bushing": (sdf(BASE, ARM, joint("j", "revolute", "base", "arm"), '<x:y xmlns:x="x">'
                    "<a>base</a><b>arm</b></x:y>"), "x:y"),
    "second mimic": (sdf(BASE, ARM, joint("j", "universal", "base", "arm", inside="<axis2><xyz>"
                    '1 0 0</xyz><mimic joint="j"/></axis2>')), "second axis"),
    "detachable": (sdf(BASE, '<plugin name="gz::sim::systems::DetachableJoint"/>'), "plugin"),
    "mimic plugin": (sdf(BASE, '<plugin filename="libmimic_joint.so"/>'), "<mimic>"),
}  # fmt: skip


@pytest.mark.table(4)
@pytest.mark.parametrize("case", REFUSED)
def test_what_is_refused(saved, case):
    text, words = REFUSED[case]
    assert words in str(refusal(saved(text)))


def test_lines_of_messages_are_those_of_the_file(saved):
    text = sdf(BASE, "\n\n", ARM, "\n", joint("j", "revolute", "base", "arm", "0 0 0"))
    assert "joint 'j' (line 4)" in str(refusal(saved(text)))


def test_scenery_is_passed_over(saved):
    parts = BASE + ARM + joint("j", "revolute", "base", "arm")
    world = (
        '<sdf version="1.9"><world name="w"><include><uri>model://sun</uri></include>'
        '<model name="ground_plane"><static>1</static></model>'
        f'<model name="m">{parts}</model></world></sdf>'
    )
    assert set(joints(saved(world))) == {"j"}
