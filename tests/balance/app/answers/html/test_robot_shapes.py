"""Shapes of robot files on pages: where they are, how large, and what is left out."""

from __future__ import annotations

import base64

import numpy as np
import pytest

import balance.app.answers.html.robot_shapes as shapes_module
import kinematics
from balance import design_space
from balance.app.answers.data import Report
from balance.app.answers.html.report import report_page
from balance.app.answers.html.robot_shapes import robot_shapes, simplified
from tests.support.browser import complaints, needs_browser, settle, show

trimesh = pytest.importorskip("trimesh")

ROBOT = """<robot name="arm">
  <material name="blue"><color rgba="0 0 1 1"/></material>
  <link name="base"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
  <link name="arm">
    <visual><origin xyz="0.5 0 0" rpy="0 1.5707963267948966 0"/>
      <geometry><cylinder radius="0.05" length="1"/></geometry><material name="blue"/></visual>
    <visual><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></visual>
    <visual><geometry><mesh filename="{mesh}" scale="0.1 0.1 0.1"/></geometry></visual>
    <inertial><origin xyz="0.5 0 0"/><mass value="1"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="j" type="continuous"><parent link="base"/><child link="arm"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 0 1"/></joint>
</robot>"""


@pytest.fixture
def arm(tmp_path):
    """An arm with primitives and a mesh of a ball beside its file."""
    trimesh.creation.icosphere(subdivisions=5, radius=2.0).export(tmp_path / "ball.stl")
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT.replace("{mesh}", "ball.stl"), encoding="utf-8")
    return kinematics.load(path)


def unpacked(shape):
    """Points (n, 3) and faces (m, 3) of an entry of a page."""
    grid = np.frombuffer(base64.b64decode(shape["points"]), "<u2").reshape(-1, 3)
    low, high = np.array(shape["low"]), np.array(shape["high"])
    kind = "<u4" if shape["wide"] else "<u2"
    faces = np.frombuffer(base64.b64decode(shape["faces"]), kind).reshape(-1, 3)
    return low + grid / 65535.0 * (high - low), faces.astype(int)


def volume(points, faces):
    """Volume inside closed triangles, by the divergence theorem."""
    a, b, c = points[faces].transpose(1, 0, 2)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6.0


def test_primitives_and_meshes_are_where_the_file_has_them(arm):
    found = robot_shapes(arm)
    assert [shape["name"] for shape in found] == ["base", "arm", "arm", "arm"]
    boxes = [(shape["low"], shape["high"]) for shape in found]
    expected = [
        ([-0.1, -0.1, -0.05], [0.1, 0.1, 0.05]),
        ([0.0, -0.05, 0.25], [1.0, 0.05, 0.35]),
        ([0.9, -0.1, 0.2], [1.1, 0.1, 0.4]),
        ([-0.2, -0.2, 0.1], [0.2, 0.2, 0.5]),
    ]
    for (low, high), (least, most) in zip(boxes, expected, strict=True):
        np.testing.assert_allclose(low, least, atol=5e-3)
        np.testing.assert_allclose(high, most, atol=5e-3)
    assert [shape["color"] for shape in found[:2]] == ["#9aa4ae", "#0000ff"]
    exact = [0.004, np.pi * 0.05**2, 4 / 3 * np.pi * 0.1**3, 4 / 3 * np.pi * 0.2**3]
    for shape, known in zip(found, exact, strict=True):
        assert abs(volume(*unpacked(shape))) == pytest.approx(known, rel=0.05)


def test_meshes_are_simplified_to_the_limit(arm, monkeypatch):
    """The ball keeps its volume with a twentieth of its triangles."""
    monkeypatch.setattr(shapes_module, "MAX_FACES", 1500)
    found = robot_shapes(arm)
    assert sum(len(unpacked(shape)[1]) for shape in found) <= 1500
    ball = volume(*unpacked(found[-1]))
    assert abs(ball) == pytest.approx(4 / 3 * np.pi * 0.2**3, rel=0.1)
    shape = shapes_module.Shape(*trimesh_arrays(), "#000000")
    assert len(simplified(shape, 10**6).faces) == len(shape.faces)


def trimesh_arrays():
    ball = trimesh.creation.icosphere(subdivisions=3)
    return np.asarray(ball.vertices), np.asarray(ball.faces)


@pytest.mark.parametrize(
    "name", ["none.stl", "http://a.b/c.stl", "/etc/passwd", "arm.urdf", ""]
)
def test_what_is_no_mesh_is_left_out_and_named(tmp_path, caplog, name):
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT.replace("{mesh}", name), encoding="utf-8")
    assert len(robot_shapes(kinematics.load(path))) == 3
    assert f"shapes_left_out: {name} (no such mesh" in caplog.text


def test_files_that_cannot_be_read_are_named_once(tmp_path, caplog):
    (tmp_path / "bad.ply").write_bytes(b"ply\n\xff")
    path = tmp_path / "arm.urdf"
    text = ROBOT.replace("{mesh}", "bad.ply").replace('radius="0.05"', 'radius="wide"')
    visual = '<visual><geometry><mesh filename="bad.ply"/></geometry></visual>'
    text = text.replace('<link name="base">', f'<link name="base">{visual}{visual}')
    path.write_text(text, encoding="utf-8")
    assert [shape["name"] for shape in robot_shapes(kinematics.load(path))] == ["base"]
    assert caplog.text.count("bad.ply (trimesh cannot read it") == 1
    assert "link arm (a number of <visual> cannot be read)" in caplog.text


def test_entities_of_a_mesh_are_not_read(tmp_path, caplog):
    text = '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><COLLADA>&a;</COLLADA>'
    (tmp_path / "bad.dae").write_text(text, encoding="utf-8")
    path = tmp_path / "arm.urdf"
    path.write_text(ROBOT.replace("{mesh}", "bad.dae"), encoding="utf-8")
    assert len(robot_shapes(kinematics.load(path))) == 3
    assert "bad.dae (a mesh with a document type" in caplog.text


@needs_browser
def test_the_page_draws_them_and_moves_them(browser, tmp_path, arm):
    """The picture differs from the one without; `meshes=False` leaves them out."""
    space = design_space(arm)
    pictures, sizes = [], []
    look = "return stage.view.canvas.toDataURL()"
    for meshes in (True, False):
        text = report_page(Report(space), meshes)
        sizes.append(len(text))
        show(browser, tmp_path, text)
        settle(browser)
        assert bool(browser.execute_script("return stage.solids.length")) == meshes
        pictures.append(browser.execute_script(look))
        assert complaints(browser) == []
    assert len(set(pictures)) == 2
    assert sizes[1] < sizes[0] < sizes[1] + 5_000_000
