"""Reading URDF: frames, screws, inertias and mimics against independent routes."""

import numpy as np
import pytest

from kinematics.errors import FileError
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.model.linkage import GROUND
from tests.support.counted_work import instructions
from tests.support.laws import point_masses, sums
from tests.support.urdf_text import (
    UNIT_INERTIA,
    about,
    along,
    inertial_of,
    joint,
    link,
    loop,
    pose_of,
    random_pose,
    screw,
)

NO_INERTIA = dict(mass=0.0, inertia=np.zeros((3, 3)))


# --- frames and screws --------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_screws_of_a_chain(read, seed):
    rng = np.random.default_rng(seed)
    kinds = ["revolute", "prismatic", "continuous", "prismatic"]
    origins, axes = [random_pose(rng) for _ in kinds], rng.normal(size=(4, 3)) * 3.0
    parts = [link("l0")]
    for i, kind in enumerate(kinds):
        parts.append(link(f"l{i + 1}", **UNIT_INERTIA))
        parts.append(joint(f"j{i}", kind, f"l{i}", f"l{i + 1}", origins[i], axes[i]))
    draft = read(*parts)
    pose = np.eye(4)
    for i, item in enumerate(draft.joints):
        pose = pose @ origins[i]
        n = pose[:3, :3] @ axes[i] / np.linalg.norm(axes[i])
        turning = kinds[i] != "prismatic"
        expected = screw(n, pose[:3, 3]) if turning else np.concatenate([np.zeros(3), n])
        np.testing.assert_allclose(item.screw, expected, atol=1e-12)
        np.testing.assert_allclose(item.point, pose[:3, 3], atol=1e-12)
        np.testing.assert_allclose(draft.bodies[i].frame, pose, atol=1e-12)
        assert item.kind == ("revolute" if turning else "prismatic")
        assert (item.name, item.parent, item.in_loop) == (f"j{i}", i - 1, False)
        assert not item.screw.flags.writeable and not draft.bodies[i].inertia.flags.writeable


def test_rpy_turns_about_fixed_axes(read):
    text = (
        link("a")
        + link("b", **UNIT_INERTIA)
        + '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
        '<origin xyz="1 2 3" rpy="0.3 -0.7 1.9"/></joint>'
    )
    draft = read(text)
    np.testing.assert_allclose(
        draft.bodies[0].frame, pose_of([1, 2, 3], [0.3, -0.7, 1.9]), atol=1e-15
    )
    np.testing.assert_allclose(draft.joints[0].screw[:3], draft.bodies[0].frame[:3, 0])


def test_helical_pitch_is_metres_per_revolution(read):
    pitch = '<screw_thread_pitch value="0.02"/>'
    parts = [link("a"), link("b", **UNIT_INERTIA), link("c", **UNIT_INERTIA)]
    at = along([1.0, 2.0, 0.0])
    draft = read(
        *parts,
        joint("h", "revolute", "a", "b", at, [0, 0, 2], pitch),
        joint("z", "continuous", "b", "c", at, [0, 0, 1], '<screw_thread_pitch value="0"/>'),
    )
    assert [j.kind for j in draft.joints] == ["helical", "revolute"]
    expected = screw([0, 0, 1], [1, 2, 0], 0.02 / (2 * np.pi))
    np.testing.assert_allclose(draft.joints[0].screw, expected, atol=1e-15)
    assert draft.joints[1].screw[2:].tolist() == [1.0, 4.0, -2.0, 0.0]


def test_planar_joint_has_three_freedoms(read):
    rng = np.random.default_rng(1)
    origin, axis = random_pose(rng), rng.normal(size=3)
    draft = read(
        link("a"), link("b", **UNIT_INERTIA), joint("p", "planar", "a", "b", origin, axis)
    )
    assert [j.name for j in draft.joints] == ["p.0", "p.1", "p.2"]
    assert [j.kind for j in draft.joints] == ["prismatic", "prismatic", "revolute"]
    assert [j.parent for j in draft.joints] == [-1, 0, 1]
    n = origin[:3, :3] @ axis / np.linalg.norm(axis)
    u, w, turn = (j.screw for j in draft.joints)
    np.testing.assert_allclose(turn, screw(n, origin[:3, 3]), atol=1e-12)
    triad = np.array([u[3:], w[3:], n])
    np.testing.assert_allclose(triad @ triad.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(triad) > 0 and not u[:3].any() and not w[:3].any()
    assert [b.link for b in draft.bodies] == [2]


@pytest.mark.parametrize(
    ("kind", "axis", "more", "lines"),
    [
        ("spherical", None, "", "xyz"),
        ("spherical", [0, 0, 1], "", "zxy"),
        ("universal", None, "", "xy"),
        ("universal", [0, 1, 0], "", "yz"),
        ("universal", [0, 0, 5], "", "zx"),
        ("universal", [0, 0, 1], '<axis2 xyz="0 3 0"/>', "zy"),
    ],
)
def test_concurrent_axes(read, kind, axis, more, lines):
    origin = random_pose(np.random.default_rng(2))
    draft = read(
        link("a"), link("b", **UNIT_INERTIA), joint("s", kind, "a", "b", origin, axis, more)
    )
    assert [j.name for j in draft.joints] == [f"s.{k}" for k in range(len(lines))]
    for item, letter in zip(draft.joints, lines, strict=True):
        n = origin[:3, "xyz".index(letter)]
        np.testing.assert_allclose(item.screw, screw(n, origin[:3, 3]), atol=1e-12)


def test_cylindrical_joint(read):
    origin = random_pose(np.random.default_rng(3))
    draft = read(
        link("a"), link("b", **UNIT_INERTIA), joint("c", "cylindrical", "a", "b", origin)
    )
    n = origin[:3, 0]
    np.testing.assert_allclose(draft.joints[0].screw, screw(n, origin[:3, 3]), atol=1e-12)
    np.testing.assert_allclose(draft.joints[1].screw, [0, 0, 0, *n], atol=1e-12)


# --- inertia ------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_inertia_of_a_cloud_of_point_masses(read, seed):
    rng = np.random.default_rng(seed)
    masses, points = point_masses(rng)
    first, second = random_pose(rng), random_pose(rng)
    draft = read(
        link("a"),
        link("b"),
        link("c", **inertial_of(rng, masses, points)),
        joint("j1", "revolute", "a", "b", first, rng.normal(size=3)),
        joint("j2", "revolute", "b", "c", second, rng.normal(size=3)),
    )
    pose = first @ second
    moved = points @ pose[:3, :3].T + pose[:3, 3]
    assert [(b.name, b.link) for b in draft.bodies] == [("c", 1)]
    np.testing.assert_allclose(draft.bodies[0].inertia, sums(masses, moved), rtol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_fixed_joints_merge_links(read, seed):
    rng = np.random.default_rng(seed)
    clouds = [point_masses(rng) for _ in range(3)]
    names, poses = ["arm", "tool", "tip"], [random_pose(rng) for _ in range(3)]
    draft = read(
        *(link(n, **inertial_of(rng, *c)) for n, c in zip(names, clouds, strict=True)),
        link("base", **UNIT_INERTIA),
        link("stand", **UNIT_INERTIA),
        link("flange"),
        joint("f3", "fixed", "flange", "tip", poses[2], [0, 0, 0]),
        joint("f2", "fixed", "flange", "tool", poses[1]),
        joint("f1", "fixed", "arm", "flange"),
        joint("f0", "fixed", "base", "stand", along([1, 0, 0])),
        joint("j", "revolute", "stand", "arm", poses[0]),
    )
    arm = along([1, 0, 0]) @ poses[0]
    frames = [arm, arm @ poses[1], arm @ poses[2]]
    moved = [c[1] @ F[:3, :3].T + F[:3, 3] for c, F in zip(clouds, frames, strict=True)]
    expected = sums(np.concatenate([c[0] for c in clouds]), np.concatenate(moved))
    assert [(b.name, b.link) for b in draft.bodies] == [("arm", 0)]
    assert [(j.name, j.parent) for j in draft.joints] == [("j", GROUND)]
    np.testing.assert_allclose(draft.bodies[0].inertia, expected, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(draft.bodies[0].frame, arm, atol=1e-12)


def test_a_group_is_named_after_its_topmost_link(read):
    draft = read(
        link("tool", **UNIT_INERTIA),
        link("base"),
        link("arm"),
        link("bare"),
        joint("f", "fixed", "arm", "tool", along([1, 0, 0])),
        joint("j", "revolute", "base", "arm", along([0, 1, 0])),
        joint("k", "revolute", "tool", "bare"),
    )
    assert [b.name for b in draft.bodies] == ["arm"]
    assert draft.bodies[0].frame[:3, 3].tolist() == [0.0, 1.0, 0.0]
    assert [n.code for n in draft.notices] == ["massless"]
    assert "bare" in draft.notices[0].message and "arm" not in draft.notices[0].message


def test_nothing_moves(read):
    with pytest.raises(FileError) as caught:
        read(
            link("a", **UNIT_INERTIA), link("b", **UNIT_INERTIA), joint("j", "fixed", "a", "b")
        )
    assert caught.value.file.endswith("robot.urdf")
    assert caught.value.problem == "no joint moves" and caught.value.remedy.startswith("give ")


@pytest.mark.parametrize("inertia", [{}, NO_INERTIA])
def test_without_any_mass_all_moving_links_carry_parameters(read, inertia):
    """One remark, in place of one on each link."""
    parts = [
        link("a", **UNIT_INERTIA),
        link("b", **inertia),
        link("c", **inertia),
        joint("j", "revolute", "a", "b"),
        joint("k", "revolute", "b", "c"),
    ]
    draft = read(*parts)
    assert [body.name for body in draft.bodies] == ["b", "c"]
    assert [notice.code for notice in draft.notices] == ["no_masses"]


# --- order, marks, mimics -----------------------------------------------------------------


def test_joints_keep_the_order_of_the_file_with_parents_first(read):
    parts = [link(name, **UNIT_INERTIA) for name in "abcdef"]
    tree = [("z", "d", "e"), ("y", "a", "b"), ("x", "c", "d"), ("w", "b", "c"), ("v", "a", "f")]
    draft = read(*parts, *(joint(n, "revolute", p, c) for n, p, c in tree))
    assert [j.name for j in draft.joints] == ["y", "w", "x", "z", "v"]
    assert [j.parent for j in draft.joints] == [-1, 0, 1, 2, -1]


def test_input_marks(read):
    yes = 'independent="true"'
    draft = read(
        *(link(name, **UNIT_INERTIA) for name in "abcd"),
        joint("p", "planar", "a", "b", marks=yes),
        joint("q", "revolute", "b", "c", marks='independent="false"'),
        joint("r", "prismatic", "a", "d", marks=yes),
        loop("k", "cylindrical", ("c", "d"), marks=yes),
    )
    assert draft.named_inputs == ("p.0", "p.1", "p.2", "r", "k.0", "k.1")
    assert set(draft.named_inputs) <= {j.name for j in draft.joints}


def test_mimics_and_their_offsets(read):
    """q1 = 0, q2 = 3 q1 + 0.4, q3 = -2 q2 + 0.1, q4 = 0.5 q3 (a slider)."""
    step = along([1.0, 0.0, 0.0])
    more = [
        "",
        '<mimic joint="j1" multiplier="3" offset="0.4"/>',
        '<mimic joint="j2" multiplier="-2" offset="0.1"/>',
        '<mimic joint="j3" multiplier="0.5"/>',
    ]
    kinds = ["revolute", "revolute", "revolute", "prismatic"]
    draft = read(
        *(link(f"l{i}", **UNIT_INERTIA) for i in range(5)),
        *(
            joint(f"j{i + 1}", kinds[i], f"l{i}", f"l{i + 1}", step, [0, 0, 1], more[i])
            for i in range(4)
        ),
    )
    assert [(m.joint, m.source, m.ratio) for m in draft.mimics] == [
        (1, 0, 3.0),
        (2, 1, -2.0),
        (3, 2, 0.5),
    ]
    pose = np.eye(4)
    for body, q in zip(draft.bodies, [0.0, 0.4, -0.7], strict=False):
        pose = pose @ step @ about([0, 0, 1], q)
        np.testing.assert_allclose(body.frame, pose, atol=1e-12)
    pose = pose @ step @ along([0, 0, -0.35])
    np.testing.assert_allclose(draft.bodies[3].frame, pose, atol=1e-12)


def test_offset_of_a_helical_mimic(read):
    draft = read(
        link("a"),
        link("b", **UNIT_INERTIA),
        link("c", **UNIT_INERTIA),
        joint("j", "revolute", "a", "b"),
        joint(
            "h",
            "revolute",
            "a",
            "c",
            along([1, 0, 0]),
            [0, 0, 1],
            '<screw_thread_pitch value="0.5"/><mimic joint="j" offset="1.5"/>',
        ),
    )
    lift = along([1, 0, 0.5 * 1.5 / (2 * np.pi)])
    expected = lift @ about([0, 0, 1], 1.5)
    np.testing.assert_allclose(draft.bodies[1].frame, expected, atol=1e-12)


def test_numbers_that_run_away(read):
    huge = 'multiplier="1e30" offset="1e30"'
    parts = [link("l0"), link("l1", **UNIT_INERTIA), joint("j1", "prismatic", "l0", "l1")]
    for i in range(2, 16):
        more = f'<mimic joint="j{i - 1}" {huge}/>'
        parts += [link(f"l{i}"), joint(f"j{i}", "prismatic", "l0", f"l{i}", more=more)]
    with pytest.raises(FileError, match="joint 'j3'.*out of range; .*mimic"):
        read(*parts)


# --- what yourdfpy would not survive, and speed -------------------------------------------


def test_ignored_elements_cannot_hurt(tmp_path):
    """Shapes, prefixes and a default namespace stop yourdfpy, but not the reader."""
    path = tmp_path / "robot.urdf"
    bad = '<visual><geometry/></visual><collision/><x:y xmlns:x="u" x:z="1"/>'
    path.write_text(
        '<robot name="r" xmlns="http://a.b/c">'
        + link("a")
        + link("b", **UNIT_INERTIA).replace("<inertial>", f"{bad}<inertial>")
        + joint("j", "revolute", "a", "b", more='<limit lower="x"/><w:z/>')
        + '<transmission name="t"><joint name="ghost"/></transmission>'
        + '<gazebo><link name="b"/></gazebo></robot>'
    )
    draft = read_unassembled(path)
    assert [j.name for j in draft.joints] == ["j"] and draft.name == "r"
    assert draft.source == str(path)


@pytest.mark.parametrize("name", ["a b", "&quot;&lt;&amp;", "関節", "𝛼", "a:b"])
def test_names_survive(read, name):
    draft = read(
        link("a"),
        link("b" + name, **UNIT_INERTIA),
        joint("j" + name, "planar", "a", "b" + name),
    )
    plain = build_tree(f'<robot name="{name}."/>'.encode()).name[:-1]
    assert draft.bodies[0].name == "b" + plain and draft.joints[1].name == f"j{plain}.1"


def a_chain(count):
    """Links and joints of a chain along x."""
    parts = [link("l0")]
    for i in range(count):
        parts.append(link(f"l{i + 1}", **UNIT_INERTIA))
        parts.append(joint(f"j{i}", "revolute", f"l{i}", f"l{i + 1}", along([1, 0, 0])))
    return parts


@pytest.mark.slow
def test_a_thousand_joints(read):
    draft = read(*a_chain(1000))
    assert len(draft.joints) == len(draft.bodies) == 1000
    assert draft.bodies[-1].frame[:3, 3].tolist() == [1000.0, 0.0, 0.0]


@pytest.mark.slow
def test_the_work_to_read_a_chain_grows_linearly(read):
    """Equal steps in the number of joints take equal numbers of instructions."""
    read(*a_chain(2))
    counts = [instructions(lambda n=n: read(*a_chain(n))) for n in (25, 50, 75)]
    first, second = np.diff(counts)
    assert 0 < second < 1.05 * first
