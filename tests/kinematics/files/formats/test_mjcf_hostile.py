"""Files beside MJCF files, hostile files, and MuJoCo itself: nothing is written elsewhere."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from kinematics.errors import FileError, PackageError
from kinematics.files.formats.robot_files import read_robot
from tests.fuzz import fuzz_formats
from tests.support.mjcf_text import GEOM, INERTIAL, four_bar, mjcf_text, of, world
from tests.support.waiting import HANGS

ROOT = Path(__file__).parents[4]

pytest.importorskip("mujoco")


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
    with pytest.raises(FileError, match="stream"):
        read_robot(of('<mujoco><include file="a.xml"/></mujoco>'))


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
        (
            world(f'<replicate count="1000000000"><body><joint/>{GEOM}</body></replicate>'),
            ["repeats"],
        ),
        (world(f'<replicate count="nan"><body><joint/>{GEOM}</body></replicate>'), ["nan"]),
        (world('<composite type="cable" count="100000 1 1"/>'), ["repeats"]),
        (world('<attach model="m" prefix="p"/>'), ["attach"]),
        ('<mujoco><option timestep="x"/><size memory="999999999T"/></mujoco>', []),
    ],
)
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


@pytest.mark.slow
def test_mujoco_writes_no_file_and_no_line(tmp_path):
    """A warning of MuJoCo's reader is a remark, in a process of its own."""
    text = four_bar('<compiler settotalmass="3"/>')
    (tmp_path / "model.xml").write_text(text)
    (tmp_path / "nan.xml").write_text(text.replace('pos="0 1 0"', 'pos="0 nan 0"'))
    for name, code in (("model.xml", 0), ("nan.xml", 3)):
        done = subprocess.run(
            [sys.executable, "-m", "balance", "report", str(tmp_path / name), "--json"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=HANGS,
            env={**os.environ, "PYTHONPATH": os.getcwd()},
        )
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


@pytest.mark.slow
def test_urdf_needs_no_mujoco():
    code = (
        "import sys; from kinematics import gallery, load; load(gallery()['five_bar']); "
        "assert 'mujoco' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=HANGS)


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


# --- mutants: MuJoCo is compiled code, which a bad file may end


@pytest.mark.slow
def test_mutants_are_read_or_refused_in_one_line(tmp_path):
    """In a process of its own: it neither ends early, nor hangs, nor prints, nor writes."""
    words = ["-m", fuzz_formats.__name__, "mjcf", "--seed", "300", "--cases", "200"]
    done = subprocess.run(
        [sys.executable, *words],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=HANGS,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stderr == "" and done.stdout.endswith("0 found\n")
    assert os.listdir(tmp_path) == []
