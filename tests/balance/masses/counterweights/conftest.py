"""Linkages of one link, of which several tests of counterweights ask."""

import pytest


@pytest.fixture
def turned_arm(tmp_path):
    """A link that turns about z, with 1 kg at x = 0.05 m, in a frame that is turned."""
    path = tmp_path / "turned.urdf"
    path.write_text(
        '<robot name="arm"><link name="base"/><link name="l1"><inertial>'
        '<origin xyz="0.05 0 0"/><mass value="1"/>'
        '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
        '<joint name="j1" type="continuous"><origin xyz="1 0.3 0" rpy="0 0 0.7"/>'
        '<parent link="base"/><child link="l1"/><axis xyz="0 0 1"/></joint></robot>'
    )
    return path


@pytest.fixture
def arm(tmp_path):
    """A link that turns about z, with 1 kg at x = 0.05 m."""
    path = tmp_path / "arm.urdf"
    path.write_text(
        '<robot name="arm"><link name="base"/><link name="l1"><inertial>'
        '<origin xyz="0.05 0 0"/><mass value="1"/>'
        '<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>'
        '<joint name="j1" type="continuous"><parent link="base"/><child link="l1"/>'
        '<axis xyz="0 0 1"/></joint></robot>'
    )
    return str(path)
