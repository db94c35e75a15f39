"""Finding linkages by name or path, loaded models, and the options of every command."""

import json
import sys

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from kinematics import gallery
from kinematics.errors import FileError, LinkageError
from kinematics.files.urdf import read as urdf
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.loading import model_gallery as models
from tests.support.urdf_text import (
    EYE,
    UNIT_INERTIA,
    about,
    along,
    joint,
    link,
    placed,
    random_pose,
)


def arm(*kinds, first="base", extra=""):
    """A chain of joints of the given types, along x, with axes of z; its text."""
    links = [first, *(f"l{k}" for k in range(1, len(kinds) + 1))]
    parts = [link(links[0])]
    for k, kind in enumerate(kinds):
        parts.append(link(links[k + 1], **UNIT_INERTIA))
        step = along([1.0, 0.2 * k, 0.0])
        parts.append(joint(f"j{k + 1}", kind, links[k], links[k + 1], step, [0, 0, 1]))
    return f'<robot name="arm">{"".join(parts)}{extra}</robot>'


# --- names --------------------------------------------------------------------------------


@pytest.fixture
def shelf(tmp_path, monkeypatch):
    """A folder of robots as example-robot-data installs them, on the path of Python."""
    root = tmp_path / "site" / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
    texts = {
        "xy_description/urdf/xy5_robot.urdf": arm("revolute", "revolute"),
        "xy_description/urdf/xy5.urdf": "<robot/>",
        "xy_description/urdf/xy5_gripper.urdf": arm("revolute"),
        "dog_b_description/robots/dog.urdf": arm("revolute"),
        "dog_c_description/urdf/dog.urdf": arm("prismatic"),
        "man_data/robots/man.v2.urdf": arm("revolute"),
        "bar_description/urdf/five_bar.urdf": "<robot/>",
        **{f"many_description/urdf/unit{k}.urdf": "<robot/>" for k in range(100)},
    }
    for name, text in texts.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    monkeypatch.setattr(sys, "path", [*sys.path, str(tmp_path / "site")])
    return root


def test_robots_of_example_robot_data(shelf):
    assert models.robots()["xy5"] == shelf / "xy_description" / "urdf" / "xy5_robot.urdf"
    for name in ("xy5", "xy5_robot"):
        assert kinematics.load(name).mobility == 2
    assert models.find("xy5_gripper").stem == "xy5_gripper"
    assert models.find("man.v2").stem == "man.v2"


def test_robots_of_one_name_go_by_their_folders(shelf):
    assert "dog" not in models.robots()
    kinds = [kinematics.load(name).joints[0].kind for name in ("dog_b", "dog_c")]
    assert kinds == ["revolute", "prismatic"]
    with pytest.raises(FileError, match=r"no model of this name; .*'dog_b', 'dog_c'$"):
        kinematics.load("dog")


def test_gallery_names_and_files_come_first(shelf, tmp_path, monkeypatch):
    assert kinematics.load("five_bar").source == str(gallery()["five_bar"])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "five_bar").mkdir()
    assert kinematics.load("five_bar").source == str(gallery()["five_bar"])
    (tmp_path / "xy5").write_text(arm("prismatic"))
    assert kinematics.load("xy5").joints[0].kind == "prismatic"


def test_unknown_names_list_a_few_that_are_close(shelf):
    with pytest.raises(FileError) as caught:
        models.find("unit")
    assert caught.value.remedy.count("'unit") <= 8 and len(str(caught.value)) < 400
    with pytest.raises(FileError, match="'four_bar_kite'"):
        models.find("fourbarkite")
    for name in ("zzz", "x" * 10_000, "a\nb"):
        with pytest.raises(
            FileError, match="no such file, and no model of this name"
        ) as caught:
            models.find(name)
        assert len(str(caught.value).splitlines()) == 1


def test_without_the_robots_the_remedy_names_them(monkeypatch):
    monkeypatch.setattr(models, "_shares", lambda: iter(()))
    assert models.robots() == {}
    with pytest.raises(FileError, match="install example-robot-data"):
        models.find("ur5")


@pytest.mark.parametrize("name", ["no.urdf", "no.URDF", "no/where", "", "."])
def test_paths_stay_paths(name):
    with pytest.raises(FileError, match=r"no such file; check the path|not a file"):
        kinematics.load(name)


# --- loaded models ------------------------------------------------------------------------


def loaded(path):
    from yourdfpy import URDF

    return URDF.load(str(path), build_scene_graph=False, load_meshes=False)


def test_a_loaded_model_equals_its_file(robot):
    """Exactly, also where roll and yaw are ill-conditioned."""
    rng = np.random.default_rng(4)
    text = "".join(
        link(f"l{k}", mass=1.0 + k, inertia=np.eye(3), origin=random_pose(rng))
        for k in range(5)
    )
    for k in range(4):
        more = '<mimic joint="j0" multiplier="-2" offset="0.5"/>' if k == 3 else ""
        text += joint(f"j{k}", "revolute", f"l{k}", f"l{k + 1}", EYE, rng.normal(size=3), more)
    text = text.replace(placed(EYE), '<origin xyz="1 0 0" rpy="0.3 1.5707963267948966 0.1"/>')
    path = robot(f'<robot name="r">{text}</robot>')
    one, other = kinematics.load(loaded(path)), kinematics.load(path)
    assert one.source == "r" and len(one.mimics) == 1
    for ours, theirs in zip(one.joints, other.joints, strict=True):
        assert np.array_equal(ours.screw, theirs.screw)
    for ours, theirs in zip(one.bodies, other.bodies, strict=True):
        assert np.array_equal(ours.inertia, theirs.inertia)
    for ours, theirs in zip(one.mimics, other.mimics, strict=True):
        assert vars(ours) == vars(theirs)


def test_a_loaded_model_takes_loops_and_options(robot, tmp_path):
    text = arm("floating", "revolute", "revolute", first="world")
    model = loaded(robot(text))
    yaml = tmp_path / "robot.yaml"
    yaml.write_text("closed_loop: [[l3, world]]\ntype: [3d]\n")
    assert urdf.read_loaded_model(model, None, ReadOptions(fix_base=True)).loops == ()
    draft = urdf.read_loaded_model(model, yaml, ReadOptions(fix_base=True, massless=("l2",)))
    assert [w.name for w in draft.loops] == ["l3/world"]
    assert [b.name for b in draft.bodies] == ["l3"]
    with pytest.raises(FileError, match="arm: joint 'j1': a floating joint.*--fix-base"):
        kinematics.load(model)


def test_a_loaded_model_passes_the_guard(robot):
    path = robot(arm("revolute", "planar", "universal"))
    assert len(urdf.read_loaded_model(loaded(path)).joints) == 6

    def refused(change, match):
        model = loaded(path)
        change(model.robot)
        with pytest.raises(FileError, match=match) as caught:
            urdf.read_loaded_model(model)
        assert len(str(caught.value).splitlines()) == 1

    nan = np.full((4, 4), np.nan)
    refused(lambda r: setattr(r.joints[0], "origin", nan), "origin of 'j1': no rigid disp")
    refused(lambda r: setattr(r.joints[0], "origin", 2 * np.eye(4)), "origin of 'j1'")
    refused(lambda r: setattr(r.joints[0], "axis", np.zeros(3)), "joint 'j1': <axis> .*zero")
    refused(lambda r: setattr(r.joints[0], "child", "l9"), "child link 'l9' does not exist")
    refused(lambda r: setattr(r.joints[0], "type", None), "joint 'j1': no type")
    refused(lambda r: setattr(r.links[1].inertial, "mass", np.inf), "link 'l1': <mass value=")
    refused(lambda r: setattr(r.links[1].inertial, "inertia", None), "no <inertia ixx")


def test_what_is_no_model():
    for wrong in (None, 5, ["x.urdf"]):
        with pytest.raises(TypeError, match="yourdfpy.URDF"):
            kinematics.load(wrong)


# --- options ------------------------------------------------------------------------------


def test_fix_base(robot):
    """Of floating joints, only that of the base is fixed; the others are six joints."""
    path = robot(arm("fixed", "floating", "revolute", "prismatic"))
    with pytest.raises(FileError, match="joint 'j2'.*--fix-base") as caught:
        kinematics.load(path)
    assert "fix_base=True" in caught.value.remedy
    linkage = kinematics.load(path, fix_base=True)
    assert linkage.mobility == 2 and [b.name for b in linkage.bodies] == ["l3", "l4"]
    fixed = kinematics.load(robot(arm("fixed", "fixed", "revolute", "prismatic")))
    for ours, theirs in zip(linkage.joints, fixed.joints, strict=True):
        assert np.array_equal(ours.screw, theirs.screw)
    assert kinematics.load(path, fix_base=True).mobility == 2
    (told,) = [notice for notice in linkage.notices if notice.code == "base_fixed"]
    assert "'l2' to the ground: 'j2'" in told.message
    for text in (arm("revolute", "floating"), arm("floating", "revolute", "floating")):
        assert kinematics.load(robot(text), fix_base=True).mobility == 7


def shelf_of_links():
    """A moving link without mass, one of zeros, one with a tool, and one on the ground."""
    zeros = dict(mass=0.0, inertia=np.zeros((3, 3)))
    parts = [link(n, **UNIT_INERTIA) for n in ("base", "stand", "arm", "tool", "hand")]
    parts += [link("bare"), link("zero", **zeros)]
    parts += [
        joint("f", "fixed", "base", "stand"),
        joint("a", "revolute", "stand", "arm"),
        joint("t", "fixed", "arm", "tool", along([1, 0, 0])),
        joint("b", "revolute", "tool", "bare", about([0, 1, 0], 1.0)),
        joint("c", "revolute", "bare", "zero", along([0, 1, 0])),
        joint("d", "revolute", "zero", "hand", along([0, 0, 1])),
    ]
    return f'<robot name="r">{"".join(parts)}</robot>'


@pytest.mark.parametrize(
    ("options", "bodies", "bare"),
    [
        ({}, ["arm", "hand"], "bare, zero"),
        ({"bodies": "all"}, ["arm", "bare", "zero", "hand"], ""),
        ({"massless": ["hand"]}, ["arm"], "bare, zero"),
        ({"massless": "arm"}, ["hand"], "bare, zero"),
        ({"massless": ["base", "stand", "bare"]}, ["arm", "hand"], "bare, zero"),
        ({"massless": ["bare", "arm"], "bodies": "all"}, ["zero", "hand"], ""),
    ],
)
def test_which_bodies_carry_parameters(robot, options, bodies, bare):
    linkage = kinematics.load(robot(shelf_of_links()), **options)
    assert [body.name for body in linkage.bodies] == bodies
    notices = [n.message for n in linkage.notices if n.code == "massless"]
    asked = set(options.get("massless", ())) - {"base", "stand", "bare"}
    if bare and not asked:
        assert notices == [f"no mass, so no parameters: {bare}"]
    for body in linkage.bodies:
        assert body.inertia.any() == (body.name in ("arm", "hand"))


@pytest.mark.parametrize(
    ("massless", "words"),
    [
        (["ghost"], ["massless link 'ghost'", "does not exist", "'arm', 'bare'"]),
        (["tool"], ["fixed to link 'arm'", "name 'arm'"]),
        (["arm", "hand"], ["no moving link has", "--bodies all"]),
    ],
)
def test_massless_links_are_links_of_moving_bodies(robot, massless, words):
    with pytest.raises(FileError) as caught:
        kinematics.load(robot(shelf_of_links()), massless=massless)
    assert all(word in str(caught.value) for word in words)


def test_unknown_choice_of_bodies(robot):
    with pytest.raises(LinkageError, match="choose from given, all"):
        kinematics.load(robot(shelf_of_links()), bodies="none")


def test_the_command_takes_the_options(robot, capsys):
    path = str(robot(arm("floating", "revolute", "revolute", "revolute", first="world")))
    words = ["report", path, "--json", "--fix-base", "--massless", "l2"]
    assert main(words) == 0
    report = json.loads(capsys.readouterr().out)
    assert (report["bodies"], report["joints"]) == (["l3", "l4"], 3)
    assert main(["report", path, "--json"]) == 3
    assert "--fix-base" in capsys.readouterr().err
    assert main(["report", path, "--fix-base", "--massless", "ghost"]) == 3
    assert "'ghost'" in capsys.readouterr().err
    assert (
        main(["report", path, "--bodies", "none"])
        == main(["report", path, "--massless", ","])
        == 2
    )
    capsys.readouterr()
    path = str(robot(shelf_of_links()))
    assert main(["report", path, "--json", "--bodies", "all"]) == 0
    assert json.loads(capsys.readouterr().out)["bodies"] == ["arm", "bare", "zero", "hand"]
