"""URDF text for tests, and displacements by routes that the product does not use."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from kinematics.errors import FileError
from kinematics.files.formats.robot_files import read_robot
from tests.support.laws import sums

INERTIAL = (
    '<inertial><origin xyz="0.5 0 0" rpy="0 0 0"/><mass value="1"/>'
    '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
)
FOUR_BAR = f"""<?xml version="1.0"?>
<robot name="four_bar" xmlns:xacro="http://ros.org/wiki/xacro">
  <!-- a comment -->
  <link name="base"/>
  <link name="crank">{INERTIAL}</link>
  <link name="coupler">{INERTIAL}</link>
  <link name="rocker">{INERTIAL}</link>
  <joint name="j1" type="revolute" independent="true">
    <parent link="base"/><child link="crank"/>
    <origin xyz="0 0 0" rpy="0 0 1.5"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="j2" type="continuous">
    <parent link="crank"/><child link="coupler"/>
    <origin xyz="1 0 0"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="j3" type="revolute">
    <parent link="base"/><child link="rocker"/>
    <origin xyz="2 0 0"/><axis xyz="0 0 1"/><mimic joint="j1" multiplier="1" offset="0"/>
  </joint>
  <loop name="k" type="revolute">
    <predecessor link="coupler"><origin xyz="1 0 0"/></predecessor>
    <successor link="rocker"><origin xyz="1 0 0"/></successor>
    <axis xyz="0 0 1"/>
  </loop>
  <transmission name="t"><joint name="j1"/><joint name="nowhere"/></transmission>
  <gazebo reference="base"><link/><joint type="ball"/></gazebo>
</robot>
"""
EYE = np.eye(4)
UNIT_INERTIA = dict(mass=1.0, inertia=np.eye(3))
SINGLE = {"revolute": 1, "continuous": 1, "prismatic": 1, "universal": 2, "cylindrical": 2}
DEGREES = {"fixed": 0, **SINGLE, "planar": 3, "spherical": 3}


def words(numbers):
    return " ".join(repr(float(x)) for x in np.ravel(numbers))


def pose_of(xyz, rpy):
    """Pose (4, 4) of an origin, with scipy's rotation about fixed x, y, z axes."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    pose[:3, 3] = xyz
    return pose


def placed(pose):
    """``<origin>`` of a pose (4, 4)."""
    rpy = Rotation.from_matrix(pose[:3, :3]).as_euler("xyz")
    return f'<origin xyz="{words(pose[:3, 3])}" rpy="{words(rpy)}"/>'


def random_pose(rng):
    return pose_of(rng.normal(size=3), rng.uniform(-1.4, 1.4, 3))


def link(name, mass=None, inertia=None, origin=EYE):
    if mass is None:
        return f'<link name="{name}"/>'
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    entries = np.asarray(inertia)[np.triu_indices(3)]
    values = " ".join(f'{k}="{v!r}"' for k, v in zip(names, entries.tolist(), strict=True))
    return (
        f'<link name="{name}"><inertial>{placed(origin)}<mass value="{mass!r}"/>'
        f"<inertia {values}/></inertial></link>"
    )


def joint(name, kind, parent, child, origin=EYE, axis=None, more="", marks=""):
    line = f'<axis xyz="{words(axis)}"/>' if axis is not None else ""
    return (
        f'<joint name="{name}" type="{kind}" {marks}><parent link="{parent}"/>'
        f'<child link="{child}"/>{placed(origin)}{line}{more}</joint>'
    )


def loop(name, kind, ends, frames=(EYE, EYE), axis=None, more="", marks=""):
    sides = zip(("predecessor", "successor"), ends, frames, strict=True)
    line = f'<axis xyz="{words(axis)}"/>' if axis is not None else ""
    return (
        f'<loop name="{name}" type="{kind}" {marks}>'
        + "".join(f'<{s} link="{end}">{placed(F)}</{s}>' for s, end, F in sides)
        + f"{line}{more}</loop>"
    )


def saved(folder, *elements, name="robot"):
    """A file that holds a robot."""
    path = folder / f"{name}.urdf"
    path.write_text(f'<robot name="{name}">{"".join(elements)}</robot>', encoding="utf-8")
    return path


def screw(n, r, pitch=0.0):
    """Screw ``[n; r × n + λ n]`` of a turning joint."""
    n = np.asarray(n) / np.linalg.norm(n)
    return np.concatenate([n, np.cross(r, n) + pitch * n])


def about(n, angle, point=(0.0, 0.0, 0.0)):
    """Displacement (4, 4) by a rotation about the line through ``point`` along ``n``."""
    H = np.eye(4)
    H[:3, :3] = Rotation.from_rotvec(angle * np.asarray(n) / np.linalg.norm(n)).as_matrix()
    H[:3, 3] = point - H[:3, :3] @ point
    return H


def along(d):
    """Displacement (4, 4) by a translation."""
    H = np.eye(4)
    H[:3, 3] = d
    return H


def inertial_of(rng, masses, points):
    """``<inertial>`` of a cloud in the link frame, in a rotated frame of its own."""
    com = masses @ points / masses.sum()
    frame = pose_of(com, rng.uniform(-1.4, 1.4, 3))
    local = (points - com) @ frame[:3, :3]
    z = sums(masses, local)
    tensor = np.array([[z[4], z[7], z[8]], [z[7], z[5], z[9]], [z[8], z[9], z[6]]])
    return dict(mass=float(masses.sum()), inertia=tensor, origin=frame)


def refusal(path):
    """The error for a file: one line that starts with the file and holds its parts."""
    with pytest.raises(FileError) as caught:
        read_robot(path)
    error = caught.value
    text = str(error)
    assert text.splitlines() == [text] and text.isprintable()
    assert text.startswith(f"{error.file}: ") and text.endswith(f"; {error.remedy}")
    assert error.element in text and error.problem in text
    assert error.problem and error.remedy
    return error
