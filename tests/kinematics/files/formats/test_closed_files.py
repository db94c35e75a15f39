"""``--write-closed`` of a parallelogram in MJCF and in SDF: its pose in closed form."""

from __future__ import annotations

import numpy as np
import pytest

import kinematics
from balance.app.cli.main import main
from tests.support.mjcf_text import four_bar

ANGLE = 0.3
INERTIAL = (
    "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz>"
    "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"
)
LINKS = {"crank": "0 0 0", "coupler": "0 1 0", "rocker": "2 0 0"}
JOINTS = {
    "j1": ("world", "crank", "0 0 0"),
    "j2": ("crank", "coupler", "0 0 0"),
    "j3": ("world", "rocker", "0 0 0"),
    "j4": ("coupler", "rocker", "0 1 0"),
}


def sdf():
    links = "".join(
        f'<link name="{name}"><pose>{place} 0 0 0</pose>{INERTIAL}</link>'
        for name, place in LINKS.items()
    )
    joints = "".join(
        f'<joint name="{name}" type="revolute"><pose>{place} 0 0 0</pose><parent>{parent}'
        f"</parent><child>{child}</child><axis><xyz>0 0 1</xyz></axis></joint>"
        for name, (parent, child, place) in JOINTS.items()
    )
    return f'<sdf version="1.9"><model name="four_bar">{links}{joints}</model></sdf>'


@pytest.mark.parametrize(("name", "text"), [("a.xml", four_bar()), ("a.sdf", sdf())])
def test_the_written_file_has_the_pose_and_the_loop(name, text, tmp_path, capsys):
    path, out = tmp_path / name, tmp_path / "closed.urdf"
    path.write_text(text, encoding="utf-8")
    words = ["report", str(path), "--inputs", "j1", "--at", f"j1={ANGLE}"]
    assert main([*words, "--write-closed", str(out)]) in (0, 4)  # whatever its ranks are
    linkage = kinematics.load(out, inputs=["j1"])
    assert len(linkage.loops) == 1 and linkage.mobility == 1 and linkage.displaced is None
    frames = dict(zip(linkage.body_names, linkage.frames, strict=True))
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    turned = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    for body, R, place in (
        ("crank", turned, (0.0, 0.0, 0.0)),
        ("coupler", np.eye(3), (-s, c, 0.0)),
        ("rocker", turned, (2.0, 0.0, 0.0)),
    ):
        np.testing.assert_allclose(frames[body][:3, :3], R, atol=1e-12)
        np.testing.assert_allclose(frames[body][:3, 3], place, atol=1e-12)
