"""Frames, inertias, mimics and axes of files, beside what yourdfpy reads of the same files."""

import numpy as np
import pytest
from yourdfpy import URDF

from kinematics import gallery
from kinematics.errors import FileError
from kinematics.files.formats.robot_files import read_robot, read_unassembled
from kinematics.files.urdf import read as urdf
from kinematics.files.urdf.read_options import ReadOptions
from kinematics.files.urdf.robot_tree import describe_robot
from kinematics.loading import model_gallery as models
from tests.support.covering import number_of_cases

ROUND_OFF = 1e-15


def second(path):
    """A file as yourdfpy reads it, shapes and scene apart."""
    return URDF.load(
        str(path),
        build_scene_graph=False,
        build_collision_scene_graph=False,
        load_meshes=False,
        load_collision_meshes=False,
    )


def apart(ours, theirs):
    """How far arrays are apart, relative to the largest entry that is above 1."""
    theirs = np.eye(4) if theirs is None else np.asarray(theirs, dtype=float)
    return float(np.abs(ours - theirs).max() / max(1.0, np.abs(theirs).max()))


def agree(path):
    """Compare both readings of a file; returns how many links have inertia."""
    robot, other = describe_robot(read_robot(path).tree), second(path).robot
    assert robot.name == other.name
    assert list(robot.links) == [link.name for link in other.links]
    for ours, theirs in zip(robot.links.values(), other.links, strict=True):
        given = theirs.inertial
        assert (ours is None) == (given is None or given.mass is None)
        if ours is not None:
            assert ours.mass == given.mass and np.array_equal(ours.inertia, given.inertia)
            assert apart(ours.origin, given.origin) <= ROUND_OFF
    for ours, theirs in zip(robot.joints, other.joints, strict=True):
        names = (theirs.name, theirs.type, theirs.parent, theirs.child)
        assert (ours.name, ours.kind, ours.parent, ours.child) == names
        assert apart(ours.origin, theirs.origin) <= ROUND_OFF
        axis = ours.element.first("axis")
        axis = axis.vector("xyz", "") if axis is not None else [1.0, 0.0, 0.0]
        assert np.array_equal(axis, theirs.axis)
        if ours.kind != "fixed":
            mimic = theirs.mimic
            known = mimic and (mimic.joint, mimic.multiplier, mimic.offset)
            assert (ours.mimic and tuple(ours.mimic)) == known
    return sum(inertial is not None for inertial in robot.links.values())


@pytest.mark.parametrize("name", sorted(gallery()))
def test_the_gallery(name):
    assert agree(gallery()[name]) > 0


@pytest.mark.slow
def test_robots_of_example_robot_data():
    found, weighed = models.robots(), 0
    if not found:
        pytest.skip("needs example-robot-data")
    for path in found.values():
        try:
            read_robot(path)
        except FileError:
            continue
        weighed += agree(path)
    assert weighed > 100


def number(rng, size=1.0):
    """A number in one of the ways in which people and programs write them."""
    value = float(rng.choice([0.0, 1.0, -1.0, rng.normal(), rng.normal() * 10.0**5])) * size
    form = rng.choice(["{!r}", "{:.6g}", "{:.3e}", "{:+.4f}"])
    return form.format(value)


def three(rng):
    gap = rng.choice([" ", "  ", "\t", "\n "])
    return gap.join(number(rng) for _ in range(3))


def origin(rng):
    """An ``<origin>`` with both attributes, one, or none; or no such element."""
    if rng.random() < 0.2:
        return ""
    xyz = f'xyz="{three(rng)}"' if rng.random() < 0.8 else ""
    angle = rng.choice([1.0, np.pi / 2, np.pi / 12])
    rpy = " ".join(repr(float(angle * rng.choice([0, 1, -1, 2, rng.normal()]))) for _ in "rpy")
    return f"<origin {xyz} " + (f'rpy="{rpy}"' if rng.random() < 0.8 else "") + "/>"


def link(rng, name):
    if rng.random() < 0.3:
        return f'<link name="{name}"/>'
    products = [
        f'{entry}="{number(rng)}"' for entry in ("ixy", "ixz", "iyz") if rng.random() < 0.7
    ]
    moments = [f'{entry}="{number(rng)}"' for entry in ("ixx", "iyy", "izz")]
    inertia = f"<inertia {' '.join(rng.permutation(moments + products))}/>"
    parts = [origin(rng), f'<mass value="{number(rng)}"/>', inertia]
    return f'<link name="{name}"><inertial>{"".join(rng.permutation(parts))}</inertial></link>'


def joint(rng, k):
    kind = str(rng.choice(["revolute", "continuous", "prismatic", "fixed"]))
    parts = [origin(rng), f'<parent link="l{rng.integers(k)}"/>', f'<child link="l{k}"/>']
    if rng.random() < 0.8:
        parts.append(f'<axis xyz="{number(rng)} 1 {number(rng)}"/>')
    # The first joint is followed by some: it moves, and follows none.
    kind = "revolute" if k == 1 else kind
    if k > 1 and rng.random() < 0.4:
        ratio = f'multiplier="{number(rng, 1e-3)}"' if rng.random() < 0.7 else ""
        offset = f'offset="{number(rng, 1e-3)}"' if rng.random() < 0.7 else ""
        parts.append(f'<mimic joint="j1" {ratio} {offset}/>')
    inside = "".join(rng.permutation(parts))
    return f'<joint name="j{k}" type="{kind}">{inside}</joint>'


def random_file(folder, seed):
    """A tree of up to nine joints, its elements in any order."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 10))
    parts = [link(rng, f"l{k}") for k in range(count + 1)]
    parts += [joint(rng, k) for k in range(1, count + 1)]
    path = folder / f"{seed}.urdf"
    path.write_text(f'<robot name="r{seed}">{"".join(rng.permutation(parts))}</robot>')
    return path


@pytest.mark.slow
def test_random_files(tmp_path):
    """A hundred; three hundred with ``ALL_CASES=1``."""
    count = number_of_cases(100, 300)
    assert sum(agree(random_file(tmp_path, seed)) for seed in range(count)) > count


def test_both_sources_make_the_same_draft(tmp_path):
    """A model that yourdfpy has loaded gives the screws and inertias of its file.

    For 40 files; for 100 with ``ALL_CASES=1``.
    """
    options = ReadOptions(bodies="all", angles="as_written")
    for seed in range(300, 300 + number_of_cases(40, 100)):
        path = random_file(tmp_path, seed)
        one = read_unassembled(path, None, options)
        other = urdf.read_loaded_model(second(path), None, options)
        for ours, theirs in zip(one.joints, other.joints, strict=True):
            assert (ours.name, ours.kind, ours.parent) == (
                theirs.name,
                theirs.kind,
                theirs.parent,
            )
            assert apart(ours.screw, theirs.screw) <= 10 * ROUND_OFF
        for ours, theirs in zip(one.bodies, other.bodies, strict=True):
            assert ours.name == theirs.name
            assert apart(ours.inertia, theirs.inertia) <= 10 * ROUND_OFF
            assert apart(ours.frame, theirs.frame) <= 10 * ROUND_OFF
        assert [vars(m) for m in one.mimics] == [vars(m) for m in other.mimics]
