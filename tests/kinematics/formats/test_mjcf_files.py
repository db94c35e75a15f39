"""What is read of MJCF files and what is refused: one line, and nothing written elsewhere."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mjcf_text import mjcf_text

import kinematics
from balance.cli.main import main
from kinematics.errors import FileError, PackageError
from kinematics.formats.robot_files import read_robot
from kinematics.urdf_elements.element import Document

pytest.importorskip("mujoco")

GEOM = '<geom size=".1"/>'
INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
# A parallelogram.
FOUR_BAR = """<mujoco model="four_bar">{head}<worldbody>
<body name="crank"><joint name="j1" axis="0 0 1"/>
  <geom type="capsule" fromto="0 0 0 0 1 0" size=".05"/>
 <body name="coupler" pos="0 1 0"><joint name="j2" axis="0 0 1"/>
  <geom type="capsule" fromto="0 0 0 2 0 0" size=".05"/><site name="s" pos="2 0 0"/>
 </body></body>
<body name="rocker" pos="2 0 0"><joint name="j3" axis="0 0 1"/>
  <geom type="capsule" fromto="0 0 0 0 1 0" size=".05"/><site name="t" pos="0 1 0"/></body>
</worldbody>{tail}</mujoco>"""
CONNECT = (
    '<equality><connect name="k" body1="coupler" body2="rocker" anchor="2 0 0"/></equality>'
)


def four_bar(head="", tail=CONNECT):
    return FOUR_BAR.format(head=head, tail=tail)


def of(text):
    return Document("model", text.encode())


def world(inside, more=""):
    return f"<mujoco>{more}<worldbody>{inside}</worldbody></mujoco>"


def tree_of(text, **options):
    return read_robot(of(text), **options).tree


def remarks_of(text):
    return [message for _, message in read_robot(of(text)).remarks]


def refused(text, *fragments, **options):
    with pytest.raises(FileError) as caught:
        read_robot(of(text), **options)
    message = str(caught.value)
    assert message.isprintable() and len(message) < 1000
    for fragment in fragments:
        assert fragment in message, message


@pytest.mark.parametrize(
    ("tail", "kind"),
    [
        (CONNECT, "spherical"),
        ('<equality><connect site1="s" site2="t"/></equality>', "spherical"),
        ('<equality><connect body1="coupler" body2="rocker" anchor="2 0 0"/><connect '
         'body1="coupler" body2="rocker" anchor="2 0 1"/></equality>', "revolute"),
        ('<equality><weld body1="rocker" body2="coupler" torquescale="0" anchor="2 0 0"/>'
         "</equality>", "spherical"),
    ],
)  # fmt: skip
def test_every_way_to_close_a_four_bar(tail, kind):
    linkage = kinematics.load(of(four_bar(tail=tail)), inputs=["j1"])
    (loop,) = tree_of(four_bar(tail=tail)).every("loop")
    assert loop.attributes["type"] == kind
    assert linkage.mobility == 1 and len(linkage.loops) == 1


def test_a_weld_fixes_and_says_where():
    weld = '<weld body1="coupler" body2="rocker" relpose="2 0 0 .7071 0 0 .7071"/>'
    tail = f"<equality>{weld}</equality>"
    (loop,) = tree_of(four_bar(tail=tail)).every("loop")
    assert loop.attributes["type"] == "fixed"
    origin = loop.first("predecessor").first("origin")
    assert origin.attributes == {"xyz": "2 0 0", "rpy": "0 0 1.5707963267948966"}


def test_joints_are_coupled():
    tail = '<equality><joint joint1="j3" joint2="j1" polycoef="0.25 -2 0 0 0"/></equality>'
    tree = tree_of(four_bar(tail=tail))
    (mimic,) = (joint.first("mimic") for joint in tree.every("joint") if joint.first("mimic"))
    assert mimic.attributes == {"joint": "j1", "multiplier": "-2", "offset": "0.25"}


def test_a_joint_follows_one_other_only():
    tail = (
        '<equality><joint joint1="j1" joint2="j2" polycoef="0 2 0 0 0"/>'
        '<joint joint1="j1" joint2="j3" polycoef="1 4 0 0 0"/></equality>'
    )
    linkage = kinematics.load(of(four_bar(tail=tail)))
    assert linkage.mobility == 1 and len(linkage.mimics) == 2
    ratios = {
        (linkage.joints[m.joint].name, linkage.joints[m.source].name): m.ratio
        for m in linkage.mimics
    }
    speed = {"j1": 4.0, "j2": 2.0, "j3": 1.0}
    for (joint, source), ratio in ratios.items():
        assert speed[joint] == ratio * speed[source]


def test_a_held_joint_is_fixed():
    tail = '<equality><joint joint1="j3"/></equality>'
    joints = {joint.name: joint for joint in tree_of(four_bar(tail=tail)).every("joint")}
    assert joints["j3"].attributes["type"] == "fixed"


@pytest.mark.parametrize(
    ("tail", "fragments"),
    [
        ('<equality><joint name="e" joint1="j3" joint2="j1" polycoef="0 1 0.5"/></equality>',
         ["joint 'e'", "not linear"]),
        ('<equality><joint joint1="j3" polycoef="0.5 0 0 0 0"/></equality>', ["'j3'", "0.5"]),
        ('<equality><joint joint1="j3" joint2="j1"/><joint joint1="j1" joint2="j3"/>'
         "</equality>",
         ["couple already"]),
        ('<tendon><fixed name="f"><joint joint="j1" coef="1"/></fixed></tendon><equality>'
         '<tendon name="e" tendon1="f"/></equality>', ["tendon 'e'", "not read"]),
        ('<equality><flex flex="f"/></equality>', ["<flex>", "not read"]),
        ('<equality><connect body1="coupler" body2="nothing" anchor="0 0 0"/></equality>',
         ["unknown element", "connect", "(line 9)"]),
        ('<equality><conect body1="coupler" body2="rocker"/></equality>', ["conect"]),
        ('<equality><connect body1="coupler" body2="coupler" anchor="0 0 0"/></equality>', []),
        ('<equality><weld body1="coupler" body2="rocker" relpose="nan 0 0 1 0 0 0"/>'
         "</equality>",
         ["not finite"]),
    ],
)  # fmt: skip
def test_what_cannot_be_a_loop_is_refused(tail, fragments):
    refused(four_bar(tail=tail), *fragments)


@pytest.mark.parametrize(
    ("head", "tail", "fragment"),
    [
        ("", CONNECT.replace("name=", 'active="false" name='), "connect 'k': not active"),
        ('<option><flag equality="disable"/></option>', CONNECT, "connect 'k': not active"),
        ("", '<tendon><fixed name="f"><joint joint="j1" coef="1"/></fixed></tendon>', "'f'"),
        ("", '<deformable><flex name="c"/></deformable>', "deformable"),
    ],
)
def test_what_is_left_out_is_said(head, tail, fragment):
    (remark,) = remarks_of(four_bar(head, tail))
    assert fragment in remark and "\n" not in remark


def test_contacts_actuators_and_sensors_need_no_word():
    tail = (
        '<actuator><motor joint="j1"/></actuator><sensor><jointpos joint="j1"/></sensor>'
        '<contact><exclude body1="crank" body2="rocker"/></contact><keyframe><key/></keyframe>'
    )
    assert remarks_of(four_bar('<asset><texture file="no.png"/></asset>', tail)) == []


def test_free_bodies_float_until_the_base_is_fixed():
    text = world(f'<body name="b"><freejoint/>{GEOM}<body><joint/>{GEOM}</body></body>')
    refused(text, "floating joint", "--fix-base")
    linkage = kinematics.load(of(text), fix_base=True)
    assert linkage.mobility == 1 and [body.name for body in linkage.bodies] == ["body2"]


def test_unnamed_and_doubled_names_are_unique():
    inside = (
        f'<body name="body2"><joint name="joint1"/>{GEOM}<body><joint/>{GEOM}</body></body>'
    )
    tree = tree_of(world(inside + f'<body name="joint1_link"><joint/><joint/>{GEOM}</body>'))
    for tag in ("link", "joint"):
        names = [item.name for item in tree.every(tag)]
        assert len(set(names)) == len(names)
    assert {"body2", "body2_", "joint1", "joint1_", "joint1_link"} <= {
        item.name for tag in ("link", "joint") for item in tree.every(tag)
    }


def test_mocap_bodies_are_fixed_and_said_to_be():
    text = world(
        f'<body name="hand" mocap="true" pos="1 0 0"/><body name="b"><joint/>{GEOM}</body>'
    ).replace("</mujoco>", '<equality><weld body1="hand" body2="b"/></equality></mujoco>')
    (remark,) = remarks_of(text)
    assert "'hand' is a mocap body" in remark


def test_static_bodies_belong_to_the_ground_or_their_parent():
    text = world(
        f'<body name="t">{GEOM}<body name="b"><joint/>{GEOM}'
        f'<body name="c">{GEOM}</body></body></body>'
    )
    linkage = kinematics.load(of(text))
    (body,) = linkage.bodies
    assert body.name == "b"
    density = 1000.0 * 4 / 3 * np.pi * 1e-3
    assert abs(body.inertia[0] - 2 * density) <= 1e-12 * density


def test_joint_positions_count_from_the_reference():
    """``ref`` is where the joint stands in the pose of the file: nothing moves."""
    inside = (
        '<body name="b" pos="1 0 0"><joint name="j" ref="{}" axis="0 0 1"/>' + GEOM + "</body>"
    )
    poses = [kinematics.load(of(world(inside.format(ref)))).places["b"].pose for ref in (0, 30)]
    assert np.array_equal(*poses)


# --- other files


def test_includes_are_relative_to_the_file_and_to_each_other(tmp_path):
    (tmp_path / "parts").mkdir()
    whole = four_bar()
    start, end = whole.index("<body"), whole.index("</worldbody>")
    (tmp_path / "main.xml").write_text(
        whole[:start] + '<include file="parts/bodies.xml"/>' + whole[end:]
    )
    inner = '<mujocoinclude><include file="more.xml"/></mujocoinclude>'
    (tmp_path / "parts" / "bodies.xml").write_text(inner)
    (tmp_path / "parts" / "more.xml").write_text(f"<mujoco>{whole[start:end]}</mujoco>")
    found, expected = kinematics.load(tmp_path / "main.xml"), kinematics.load(of(whole))
    assert found.mobility == 1
    for one, other in zip(found.joints, expected.joints, strict=True):
        assert one.name == other.name and np.array_equal(one.screw, other.screw)


@pytest.mark.parametrize(
    ("inside", "fragments"),
    [
        ('<include file="nothing.xml"/>', ["line 1", "nothing.xml"]),
        ('<include file="model.xml"/>', ["second time"]),
        ('<include file="bad.xml"/>', ["bad.xml", "not well-formed"]),
        ('<include file="entities.xml"/>', ["DOCTYPE"]),
        ('<include file="/dev/zero"/>', ["not a file"]),
        ('<include file="."/>', ["not a file"]),
        ("<include/>", ["without a file"]),
        ('<asset><model name="m" file="bad.xml"/></asset>', ["model 'm'", "to_xml"]),
        ('<include file="big.xml"/>', ["larger than"]),
    ],
)
def test_included_files_are_guarded(inside, fragments, tmp_path, capsys):
    (tmp_path / "bad.xml").write_text("<mujoco><")
    (tmp_path / "entities.xml").write_text('<!DOCTYPE a [<!ENTITY b "c">]><mujoco/>')
    with open(tmp_path / "big.xml", "wb") as stream:
        stream.truncate(17 * 2**20)
    path = tmp_path / "model.xml"
    path.write_text(f"<mujoco>{inside}</mujoco>")
    assert main(["report", str(path), "--json"]) == 3
    streams = capsys.readouterr()
    (line,) = streams.err.splitlines()
    assert streams.out == "" and line.isprintable()
    for fragment in fragments:
        assert fragment in line


def test_a_stream_has_no_folder():
    refused('<mujoco><include file="a.xml"/></mujoco>', "stream")


MESH = '<asset><mesh name="m" file="m.stl"/><texture file="t.png" name="t"/></asset>'


def test_meshes_are_needed_only_for_inertia(tmp_path):
    inside = '<geom type="mesh" mesh="m"/><body><joint/>{}<geom type="mesh" mesh="m"/></body>'
    path = tmp_path / "model.xml"
    path.write_text(world(inside.format(INERTIAL), MESH))
    assert kinematics.load(path).mobility == 1
    for text in (
        world(inside.format(""), MESH),
        world(inside.format(INERTIAL), '<compiler inertiafromgeom="true"/>' + MESH),
    ):
        path.write_text(text)
        with pytest.raises(FileError, match=r"mesh 'm' \(line 1\).*m\.stl"):
            kinematics.load(path)


def test_a_mesh_gives_inertia(tmp_path):
    """A tetrahedron of unit edges along the axes: mass ρ/6, centre at a quarter."""
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "t.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    head = '<compiler meshdir="meshes"/><asset><mesh file="t.obj"/></asset>'
    path = tmp_path / "model.xml"
    path.write_text(world('<body><joint/><geom type="mesh" mesh="t"/></body>', head))
    (body,) = kinematics.load(path).bodies
    assert np.abs(body.inertia[:4] - 1000 / 6 * np.array([1, 0.25, 0.25, 0.25])).max() <= 1e-6


# --- hostile files


@pytest.mark.parametrize(
    ("text", "fragments"),
    [
        ("<mujoco/>", []),
        ("<mujoco><worldbody/></mujoco>", ["no joint moves"]),
        (world("<body><joint/></body>"), ["mjMINVAL", "body"]),
        (world(f'<body pos="nan 0 0"><joint/>{GEOM}</body>'), ["pos", "not finite"]),
        (world(f'<body><joint axis="0 0 0"/>{GEOM}</body>'), ["axis too small"]),
        (world(f'<body><joint type="hing"/>{GEOM}</body>'), ["hing", "line 1"]),
        (world(f'<body name="a"><joint/>{GEOM}</body><body name="a"/>'), ["repeated name 'a'"]),
        (world(f'<replicate count="1000000000"><body><joint/>{GEOM}</body></replicate>'),
         ["repeats"]),
        (world(f'<replicate count="nan"><body><joint/>{GEOM}</body></replicate>'), ["nan"]),
        (world('<composite type="cable" count="100000 1 1"/>'), ["repeats"]),
        (world('<attach model="m" prefix="p"/>'), ["attach"]),
        ('<mujoco><option timestep="x"/><size memory="999999999T"/></mujoco>', []),
    ],
)  # fmt: skip
def test_bad_files_get_one_line(text, fragments, capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "model.xml"
    path.write_text(text)
    assert main(["report", str(path), "--json"]) == 3
    out, err = capfd.readouterr()
    (line,) = err.splitlines()
    assert out == "" and line.isprintable()
    for fragment in fragments:
        assert fragment in line
    assert os.listdir(tmp_path) == ["model.xml"]


def test_mujoco_writes_no_file_and_no_line(tmp_path):
    """A warning of MuJoCo's reader is a remark, in a process of its own."""
    text = four_bar('<compiler settotalmass="3"/>')
    (tmp_path / "model.xml").write_text(text)
    (tmp_path / "nan.xml").write_text(text.replace('pos="0 1 0"', 'pos="0 nan 0"'))
    for name, code in (("model.xml", 0), ("nan.xml", 3)):
        done = subprocess.run(
            [sys.executable, "-m", "balance", "report", str(tmp_path / name), "--json"],
            cwd=tmp_path, capture_output=True, text=True, timeout=300,
            env={**os.environ, "PYTHONPATH": os.getcwd()},
        )  # fmt: skip
        assert done.returncode == code, done.stderr
        assert "WARNING" not in done.stderr
        assert done.stdout == "" if code else json.loads(done.stdout)
    assert sorted(os.listdir(tmp_path)) == ["model.xml", "nan.xml"]


def test_mujoco_may_be_missing(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(PackageError, match="pip install mujoco"):
        read_robot(of(four_bar()))
    path = tmp_path / "model.xml"
    path.write_text(four_bar())
    assert main(["report", str(path), "--json"]) == 2
    streams = capsys.readouterr()
    assert streams.out == "" and len(streams.err.splitlines()) == 1


def test_urdf_needs_no_mujoco():
    code = (
        "import sys; from kinematics import gallery, load; load(gallery()['five_bar']); "
        "assert 'mujoco' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


# --- what is written is URDF


def test_designs_are_written_as_urdf(tmp_path, capsys):
    path, out = tmp_path / "model.xml", tmp_path / "out.urdf"
    urdf = Path(kinematics.gallery()["four_bar_antiparallelogram"]).read_text()
    path.write_text(mjcf_text(urdf, "classes"))
    assert main(["design", str(path), "--out", str(out), "--json"]) == 0
    capsys.readouterr()
    assert out.read_text().lstrip().startswith("<?xml") and "<robot" in out.read_text()
    again = kinematics.load(out)
    assert again.mobility == 1 and len(again.bodies) == 3
    assert main(["report", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)


def test_a_closed_pose_is_written_as_urdf(tmp_path, capsys):
    text = four_bar(tail='<equality><connect site1="s" site2="t"/></equality>')
    path, out = tmp_path / "model.xml", tmp_path / "closed.urdf"
    path.write_text(text.replace('site name="t" pos="0 1 0"', 'site name="t" pos="0 1.1 0"'))
    assert main(["report", str(path), "--write-closed", str(out), "--json"]) == 0
    capsys.readouterr()
    again = kinematics.load(out)
    assert again.mobility == 1 and len(again.loops) == 1
