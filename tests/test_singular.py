"""A pose with more freedom than its neighbours is refused, and a better one is named."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from laws import posed

import kinematics
from kinematics.errors import MobilityError

FLAT = """<robot name="flat">
  <link name="base"/>
  {links}
  <joint name="a" type="continuous"><parent link="base"/><child link="crank"/>
    <origin xyz="0 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="b" type="continuous"><parent link="crank"/><child link="coupler"/>
    <origin xyz="0.5 0 0"/><axis xyz="0 0 1"/></joint>
  <joint name="d" type="continuous"><parent link="base"/><child link="rocker"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 1"/></joint>
  <loop name="c" type="revolute">
    <predecessor link="coupler"><origin xyz="1 0 0"/></predecessor>
    <successor link="rocker"><origin xyz="0.5 0 0"/></successor>
    <axis xyz="0 0 1"/>
  </loop>
</robot>
"""
LINK = (
    '<link name="{}"><inertial><origin xyz="0.2 0.1 0"/><mass value="1"/><inertia ixx="0.1" '
    'ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>'
)


def flat(tmp_path, angles):
    """A parallelogram, all its joints on one line, then turned by angles."""
    links = "".join(LINK.format(name) for name in ("crank", "coupler", "rocker"))
    robot = ElementTree.fromstring(FLAT.format(links=links))
    posed(angles)(robot)
    path = tmp_path / "flat.urdf"
    ElementTree.ElementTree(robot).write(path)
    return path


def test_a_flat_parallelogram_is_singular_and_the_pose_named_is_not(tmp_path):
    with pytest.raises(MobilityError) as refusal:
        kinematics.load(flat(tmp_path, {}))
    text = str(refusal.value)
    assert "singular at the pose of the file: 2 degrees of freedom there, 1 at other" in text
    named = {name: float(value) for name, value in re.findall(r"(\w+)=(-?[\d.]+)", text)}
    assert set(named) <= {"a", "b", "d"} and max(map(abs, named.values())) > 0.1
    assert kinematics.load(flat(tmp_path, named)).mobility == 1
