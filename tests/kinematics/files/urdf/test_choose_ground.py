"""The ground: loose links are named and left out, and the user chooses among roots."""

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from kinematics.errors import FileError
from tests.support.dialect_text import answer
from tests.support.urdf_text import UNIT_INERTIA, along, joint, link, loop, saved

AXIS = [0, 0, 1]
ARM = (
    link("base"),
    link("arm", **UNIT_INERTIA),
    link("hand", **UNIT_INERTIA),
    joint("j1", "revolute", "base", "arm", axis=AXIS),
    joint("j2", "revolute", "arm", "hand", along([1, 0, 0]), AXIS),
)
# Links of SDF at the corners of a quadrangle.
CORNERS = {"base": "0 0", "a": "1 0.2", "b": "1.5 1.3", "c": "-0.2 1", "mark": "3 3"}
ROD = '<link name="{}"><pose>{} 0 0 0 0</pose><inertial><mass>1</mass></inertial></link>'
HINGE = (
    '<joint name="{0}{1}" type="revolute"><parent>{0}</parent><child>{1}</child>'
    "<axis><xyz>0 0 1</xyz></axis></joint>"
)


def codes(linkage):
    return {notice.code: notice.message for notice in linkage.notices}


def sdf(folder, links, joints, marks=""):
    text = "".join(ROD.format(name, CORNERS[name]) for name in links)
    text += "".join(HINGE.format(*pair) for pair in joints)
    path = folder / "robot.sdf"
    path.write_text(f'<sdf version="1.9"><model name="m" {marks}>{text}</model></sdf>')
    return path


def test_the_loose_link_is_named_and_left_out(tmp_path, caplog):
    path = saved(
        tmp_path,
        *ARM,
        link("stray", **UNIT_INERTIA),
        link("on_it"),
        joint("f", "fixed", "stray", "on_it"),
    )
    with pytest.raises(FileError, match="link 'stray'.*a loose link.*--ground base") as caught:
        kinematics.load(path)
    assert "'arm'" not in str(caught.value)
    linkage = kinematics.load(path, ground="base")
    assert linkage.mobility == 2 and "'stray', 'on_it'" in codes(linkage)["left_out"]
    assert main(["report", str(path), "--ground", "base"]) == 0
    assert "left_out" in caplog.text


@pytest.mark.parametrize(
    ("ground", "words"),
    [("hand", "joint 'j2'.*carries it.*'base'"), ("nobody", "no such link")],
)
def test_what_is_no_ground(tmp_path, ground, words):
    with pytest.raises(FileError, match=f"ground '{ground}': .*{words}"):
        kinematics.load(saved(tmp_path, *ARM), ground=ground)


def test_of_two_roots_the_user_chooses_and_the_other_floats(tmp_path):
    """A ball joins the second root to the hand."""
    ball = loop("k", "spherical", ("hand", "plate"), (along([1, 0, 0]), np.eye(4)))
    path = saved(tmp_path, *ARM, link("plate", **UNIT_INERTIA), ball)
    with pytest.raises(FileError, match="more than one root.*--ground base"):
        kinematics.load(path)
    linkage = kinematics.load(path, ground="base")
    assert linkage.mobility == 5 and "'plate'" in codes(linkage)["floating"]


def test_a_design_of_what_is_left_needs_no_ground(tmp_path, capsys):
    path = saved(tmp_path, *ARM, link("stray", **UNIT_INERTIA))
    out = tmp_path / "out.urdf"
    words = ["design", str(path), "--ground", "base", "--balance", "force", "--keep", "hand"]
    assert main([*words, "--out", str(out)]) == 0
    assert "stray" not in out.read_text(encoding="utf-8")
    assert kinematics.load(out).mobility == 2


def test_the_world_is_implied(tmp_path):
    """As Drake does: the same linkage as with the link."""
    fixed = joint("w", "fixed", "world", "base")
    told = kinematics.load(saved(tmp_path, *ARM, fixed))
    assert "'world'" in codes(told)["world_implied"]
    given = saved(tmp_path, link("world"), *ARM, fixed, name="given")
    assert answer(given) == answer(saved(tmp_path, *ARM, fixed))


def test_a_machine_beside_the_floor_floats(tmp_path):
    """The floor stands on the world, and nothing moves on it."""
    path = saved(tmp_path, link("floor"), joint("w", "fixed", "world", "floor"), *ARM)
    with pytest.raises(FileError, match="loose links: .*'world'|loose link.*--ground base"):
        kinematics.load(path)
    assert kinematics.load(path, ground="base").mobility == 2


@pytest.mark.parametrize("first", [True, False])
def test_a_loose_link_of_sdf_is_not_the_ground(tmp_path, first):
    links = ["base", "a", "b", "c"]
    links.insert(0 if first else 4, "mark")
    path = sdf(tmp_path, links, [("a", "b"), ("b", "c"), ("c", "base"), ("base", "a")])
    with pytest.raises(FileError, match="link 'mark'.*a loose link.*--ground") as caught:
        kinematics.load(path)
    assert "'b'" not in str(caught.value)


@pytest.mark.parametrize(
    ("marks", "ground", "joints"),
    [
        ("", "base", [("base", "a"), ("a", "b")]),
        ("", "base", [("a", "b"), ("b", "c"), ("c", "base"), ("base", "a")]),
        ("", "b", [("b", "a"), ("a", "base"), ("base", "c")]),  # a tree has its root
        ('canonical_link="c"', "c", [("a", "b"), ("b", "c"), ("c", "base"), ("base", "a")]),
    ],
)
def test_the_ground_of_sdf(tmp_path, marks, ground, joints):
    """The root of a tree, or the canonical link: by default the first that joints connect."""
    names = sorted({name for pair in joints for name in pair} - {"base"})
    linkage = kinematics.load(sdf(tmp_path, ("base", *names), joints, marks), bodies="all")
    assert f"'{ground}'" in codes(linkage)["base_taken_as_fixed"]
    assert linkage.places[ground].link == -1


def test_the_user_chooses_the_ground_of_sdf(tmp_path):
    """Of a closed chain any link: the ranks are those of the same chain written from there."""
    ring = [("a", "b"), ("b", "c"), ("c", "base"), ("base", "a")]
    path = sdf(tmp_path, ("base", "a", "b", "c"), ring)
    linkage = kinematics.load(path, ground="b")
    assert linkage.places["b"].link == -1 and "base_taken_as_fixed" not in codes(linkage)
    assert {body.name for body in linkage.bodies} == {"base", "a", "c"}
