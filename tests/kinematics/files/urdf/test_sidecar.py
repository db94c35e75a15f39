"""Loops beside the URDF file: the same mechanism as with elements, and one clear line else."""

import itertools
import shutil
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from numpy.linalg import qr

import kinematics
from balance import design_space
from balance.app.cli.main import main
from kinematics import gallery
from kinematics.errors import FileError
from kinematics.files.formats.robot_files import read_unassembled
from kinematics.model.linkage import GROUND
from tests.support.sidecar_text import FRAMES, PAIR, bench, written
from tests.support.urdf_text import (
    about,
    along,
    joint,
    link,
    loop,
    pose_of,
    random_pose,
    screw,
)


@pytest.fixture
def write(tmp_path):
    """Write a robot and its YAML file to a folder of their own."""
    return partial(written, tmp_path)


BALL = PAIR + "joint_name: [s0]\njoint_type: SPHERICAL"


def same(one, other):
    """Two drafts hold the same joints, bodies and welds."""
    for ours, theirs in zip(one.joints, other.joints, strict=True):
        np.testing.assert_allclose(ours.screw, theirs.screw, atol=1e-14)
        assert (ours.kind, ours.parent) == (theirs.kind, theirs.parent)
        assert ours.in_loop == theirs.in_loop
    for ours, theirs in zip(one.bodies, other.bodies, strict=True):
        assert (ours.name, ours.link) == (theirs.name, theirs.link)
    for ours, theirs in zip(one.loops, other.loops, strict=True):
        assert (ours.end, ours.successor) == (theirs.end, theirs.successor)
        np.testing.assert_allclose(ours.gap, theirs.gap, atol=1e-14)


@pytest.mark.parametrize(("kind", "word"), [("spherical", "3d"), ("fixed", "6D")])
@pytest.mark.parametrize("frames", [("tip_a", "tip_b"), ("ja", "jb"), ("tip_b", "ja")])
def test_a_pair_is_a_loop_element(write, kind, word, frames):
    yaml = f"closed_loop: [{list(frames)}]\ntype: ['{word}']\nname_mot: [j3]\n"
    draft = read_unassembled(write(bench(), yaml))
    ends = ["tip_" + name[-1] for name in frames]
    expected = read_unassembled(write(bench(loop("k", kind, ends)), None))
    same(draft, expected)
    assert [w.name for w in draft.loops] == ["/".join(frames)]
    assert draft.named_inputs == ("j3",) and not draft.notices


def test_a_joint_names_the_frame_after_it(write):
    yaml = "closed_loop: [[j2, j3]]\ntype: ['3d']"
    draft = read_unassembled(write(bench(), yaml))
    assert (draft.loops[0].end, draft.loops[0].successor) == (5, 2)
    assert draft.joints[3].parent == 1
    gap = draft.loops[0].gap
    moved = np.array([np.cos(1.1), np.sin(1.1), 0.0])
    np.testing.assert_allclose(gap[:3, 3], [2.0, 0, 0] - moved, atol=1e-12)


@pytest.mark.parametrize("form", ["flow", "block", "json", "comments", "crlf", "bom", "utf-16"])
def test_forms_of_yaml(write, form):
    yaml = "closed_loop: [['tip_a', 'tip_b']]\ntype: ['3d']\nname_mot: ['j3']\n"
    texts = {
        "block": "closed_loop:\n- - tip_a\n  - tip_b\ntype:\n- 3d\nname_mot:\n- j3\n",
        "json": '{"closed_loop": [["tip_a", "tip_b"]], "type": ["3d"], "name_mot": ["j3"]}',
        "comments": "# a\n---\n" + yaml.replace("]]", "], # here\n]") + "joint_name:\n...\n",
        "crlf": yaml.replace("\n", "\r\n"),
        "bom": b"\xef\xbb\xbf" + yaml.encode(),
    }
    data = yaml.encode("utf-16") if form == "utf-16" else texts.get(form, yaml)
    path = write(bench(), data, "loops.txt")
    draft = read_unassembled(path, path.with_name("loops.txt"))
    assert [w.name for w in draft.loops] == ["tip_a/tip_b"] and draft.named_inputs == ("j3",)


@pytest.mark.parametrize("name", ["on", "1", "1e5", "null_", "~x", "é", "a b", "2.0"])
def test_names_stay_text(write, name):
    text = bench().replace('"tip_a"', f'"{name}"').replace('"j3"', f'"{name}."')
    draft = read_unassembled(
        write(text, f"closed_loop: [[{name}, tip_b]]\nname_mot: [{name}.]\n")
    )
    assert draft.loops[0].name == f"{name}/tip_b" and draft.named_inputs == (f"{name}.",)


def test_type_has_a_default_and_may_be_one_word(write):
    assert len(read_unassembled(write(bench(), PAIR)).joints) == 3
    assert len(read_unassembled(write(bench(), PAIR + "type: 3D")).joints) == 6


@pytest.mark.parametrize(
    ("kind", "axes"),
    [
        ("SPHERICAL", "xyz"),
        ("FIXED", ""),
        ("CARDAN", "xy"),
        ("spherical", "xyz"),
        *((f"UJOINT_{a}{b}", f"{a}{b}".lower()) for a, b in itertools.permutations("XYZ", 2)),
    ],
)
def test_joints_are_replaced(write, kind, axes):
    origin = random_pose(np.random.default_rng(3))
    old = joint("j2", "revolute", "crank", "coupler", along([1, 0, 0]), [0, 0, 1])
    new = joint("j2", "revolute", "crank", "coupler", origin, [0, 0, 1])
    text = bench().replace(old, new)
    draft = read_unassembled(write(text, f"joint_name: [j2]\njoint_type: ['{kind}']\n"))
    pose = about([0, 0, 1], 1.1) @ origin
    names = [f"j2.{k}" for k in range(len(axes))]
    assert [j.name for j in draft.joints] == ["j1", *names, "j3"]
    for item, letter in zip(draft.joints[1:], axes, strict=False):
        n = pose[:3, "xyz".index(letter)]
        np.testing.assert_allclose(item.screw, screw(n, pose[:3, 3]), atol=1e-12)
    bodies = ["crank", "coupler", "rocker"] if axes else ["crank", "rocker"]
    assert [b.name for b in draft.bodies] == bodies


def test_replaced_joints_and_loops_together(write):
    yaml = PAIR + "type: [6d]\njoint_name: [j2, s0]\njoint_type: [UJOINT_ZY, SPHERICAL]\n"
    draft = read_unassembled(write(bench(spins=[[1, 0, 0]]), yaml + "name_mot: [s0, j1]\n"))
    assert [j.name for j in draft.joints] == [
        "j1",
        "j2.0",
        "j2.1",
        "j3",
        "s0.0",
        "s0.1",
        "s0.2",
    ]
    assert draft.named_inputs == ("s0.0", "s0.1", "s0.2", "j1")
    assert (draft.loops[0].end, draft.loops[0].successor) == (6, 3)


def test_a_spherical_pair_and_three_joints_with_a_weld_are_one_mechanism(write):
    """All ways of writing it give the same design space."""
    spins = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
    coupler = about([0, 0, 1], 1.1) @ along([1, 0, 0]) @ along([0.4, -0.9, 0])
    ends = (along([0.4, -0.9, 0]), along([-2, 0, 0]) @ coupler)
    spaces = [
        design_space(kinematics.load(write(text, yaml)))
        for text, yaml in [
            (bench(ends=ends), PAIR + "type: ['3d']\nname_mot: [j1]"),
            (bench(ends=ends, spins=spins), PAIR + "type: ['6d']\nname_mot: [j1]"),
            (bench(ends=ends, spins=spins[:1]), BALL),
        ]
    ]
    first, *others = spaces
    assert (first.rank, first.nullity) == (8, 4)
    for other in others:
        assert (other.rank, other.bodies) == (first.rank, first.bodies)
        assert not [notice for notice in other.notices if notice.code == "assembled"]
        cosines = np.linalg.svd(qr(first.basis)[0].T @ qr(other.basis)[0], compute_uv=False)
        assert cosines.min() > 1 - 1e-12


# --- which file ---------------------------------------------------------------------------


def test_where_loops_are_found(write, tmp_path):
    path = write(bench(), PAIR + "type: [3d]", "robot.yml")
    assert len(read_unassembled(path).loops) == 1
    (tmp_path / "robot.yaml").write_text("controllers:\n  rate: !deg 3\n")
    assert len(read_unassembled(path).loops) == 1
    (tmp_path / "robot.yaml").write_text(PAIR + "type: [6d]")
    assert len(read_unassembled(path).joints) == 3
    elsewhere = tmp_path / "sub"
    elsewhere.mkdir()
    shutil.copy(path, elsewhere)
    assert read_unassembled(elsewhere / "robot.urdf").loops == ()
    assert len(read_unassembled(elsewhere / "robot.urdf", path.with_suffix(".yml")).joints) == 6


def test_elements_win_over_a_file_that_was_only_found(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # so that the path is short, and told as a whole
    ours = loop("k", "revolute", FRAMES, axis=[0, 0, 1])
    path = written(Path(), bench(ours), PAIR + "colour: red")
    draft = read_unassembled(path)
    assert [w.name for w in draft.loops] == ["k"]
    assert [notice.code for notice in draft.notices] == ["loops_ignored"]
    assert "robot.yaml" in draft.notices[0].message
    with pytest.raises(FileError) as caught:
        read_unassembled(path, path.with_suffix(".yaml"))
    assert caught.value.element.startswith("loop 'k'") and "robot.yaml" in caught.value.problem


def test_the_command_takes_loops(write, capsys):
    path = write(bench(), PAIR + "type: [3d]", "other.yaml")
    assert main(["report", str(path), "--loops", str(path.with_name("other.yaml"))]) == 0
    assert "4 of 12 dimensions" in capsys.readouterr().out
    assert main(["report", str(path), "--loops", str(path.with_name("none.yaml"))]) == 3
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1 and "none.yaml: no such file" in error


def test_inputs_of_the_file_replace_marks_and_yield_to_the_user(write):
    old = 'name="j3" type="revolute"'
    text = bench().replace(old, f'{old} independent="true"')
    assert read_unassembled(write(text)).named_inputs == ("j3",)
    path = write(text, PAIR + "type: [3d]\nname_mot: [j1]")
    assert kinematics.load(path).inputs == ("j1",)
    assert kinematics.load(path, inputs=["j2"]).inputs == ("j2",)
    assert read_unassembled(write(text, PAIR + "name_mot: []")).named_inputs == ("j3",)


def test_older_keys(write):
    """Words that names contain, and indices that mean nothing here."""
    yaml = PAIR + "rotule_name: s\nname_mot: j\nLidmot: [0, 1]\nLidvmot: [0]\n"
    draft = read_unassembled(write(bench(spins=[[1, 0, 0]]), yaml))
    assert [j.name for j in draft.joints] == ["j1", "j2", "j3", "s0.0", "s0.1", "s0.2"]
    assert draft.named_inputs == ("j1", "j2", "j3")
    (notice,) = draft.notices
    assert notice.code == "keys_ignored" and "Lidmot, Lidvmot" in notice.message


def test_gallery_models_have_their_loops_inside():
    assert all(not path.with_suffix(".yaml").exists() for path in gallery().values())


def test_loops_to_the_ground(write):
    """A frame on the ground may come first or second."""
    ends = (along([1.0, 0, 0]), pose_of([0.5, 0.5, 0], [0, 0, 0]))
    for pair in ("[tip_a, base]", "[base, tip_a]"):
        draft = read_unassembled(write(bench(ends=ends), f"closed_loop: [{pair}]\ntype: [6d]"))
        assert (draft.loops[0].end, draft.loops[0].successor) == (1, GROUND)


def test_names_that_the_file_makes_are_taken(write):
    text = bench(joint("tip_a/tip_b", "fixed", "base", "x") + link("x"))
    with pytest.raises(FileError, match="closed_loop: loop 'tip_a/tip_b'.*is taken by joint"):
        read_unassembled(write(text, PAIR))
    text = bench().replace('name="j2"', 'name="j1.1"')
    yaml = "joint_name: [j1]\njoint_type: [SPHERICAL]"
    with pytest.raises(FileError, match="joint_type: joint 'j1.1'.*is taken by joint 'j1'"):
        read_unassembled(write(text, yaml))


def test_a_link_and_a_joint_of_one_name(write):
    """One frame if the joint carries the link, else two that cannot be told apart."""
    assert read_unassembled(write(bench().replace('"ja"', '"tip_a"'), PAIR)).loops
    with pytest.raises(FileError, match="closed_loop.*'tip_b' is a link, and") as caught:
        read_unassembled(write(bench().replace('"ja"', '"tip_b"'), PAIR))
    assert "rename" in caught.value.remedy


def test_mimics_and_pitches_of_replaced_joints(write):
    follower = joint("j2", "revolute", "crank", "coupler", along([1, 0, 0]), [0, 0, 1])
    marked = follower.replace("</joint>", '<mimic joint="j1"/></joint>')
    yaml = "joint_name: [j1]\njoint_type: [SPHERICAL]"
    with pytest.raises(FileError, match="joint_type: joint 'j2'.*one degree of freedom"):
        read_unassembled(write(bench().replace(follower, marked), yaml))
    screwed = follower.replace("</joint>", '<screw_thread_pitch value="0.1"/></joint>')
    text = bench().replace(follower, screwed)
    with pytest.raises(FileError, match="joint_type: joint 'j2'.*<screw_thread_pitch>"):
        read_unassembled(write(text, yaml.replace("j1", "j2")))
    frozen = read_unassembled(write(text, "joint_name: [j2]\njoint_type: [FIXED]"))
    assert [j.name for j in frozen.joints] == ["j1", "j3"]


@pytest.mark.parametrize("key", ["name_mot", "rotule_name"])
def test_a_part_of_a_name_that_is_in_none_is_remarked(write, key):
    draft = read_unassembled(write(bench(), f"{PAIR}{key}: motor\n"))
    expected = read_unassembled(write(bench(), PAIR))
    (notice,) = draft.notices
    assert notice.code == "keys_ignored" and "called like 'motor'" in notice.message
    assert draft.named_inputs == expected.named_inputs
    assert [j.kind for j in draft.joints] == [j.kind for j in expected.joints]
