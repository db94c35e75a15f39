"""A four-bar without its last hinge, and what a file that closes it must say."""

import numpy as np

import kinematics
from balance import certify, design_space
from kinematics.files.formats.robot_files import read_unassembled
from tests.support.urdf_text import INERTIAL, refusal

# Turned links, one by a rounded angle: a frame of b is not a frame of the base.
JOINTS = (
    ("j1", "base", "a", "0 0 0", "0 0 1.5708"),
    ("j2", "a", "b", "1 0 0", "0 3.141592653589793 0"),
    ("j3", "base", "c", "2 0 0", "0 0 0"),
)
OPEN = '<link name="base"/>' + "".join(
    f'<link name="{child}">{INERTIAL}</link>\n<joint name="{name}" type="revolute">'
    f'<parent link="{parent}"/><child link="{child}"/><origin xyz="{xyz}" rpy="{rpy}"/>'
    '<axis xyz="0 0 1"/></joint>\n'
    for name, parent, child, xyz, rpy in JOINTS
)
# The point at (2, 1.5, 0) of the base, in the frames of b and c.
ON_B, ON_C = "-0.5 -2 0", "0 1.5 0"
# A fourth link on b, of which the hinge is in the tree: c and d are one body.
MORE = (
    f'<link name="d">{INERTIAL}</link><joint name="j4" type="continuous">'
    '<parent link="b"/><child link="d"/>'
    f'<origin xyz="{ON_B}"/><axis xyz="0 0 1"/></joint>\n'
)


def hand_written(kind, axis='<axis xyz="0 0 1"/>', rpy=("0 0 0", "0 3.141592653589793 0")):
    """The loop of the hinge as an element of the format itself."""
    sides = zip(("predecessor", "successor"), "bc", (ON_B, ON_C), rpy, strict=True)
    ends = "".join(
        f'<{role} link="{name}"><origin xyz="{xyz}" rpy="{turn}"/></{role}>'
        for role, name, xyz, turn in sides
    )
    return f'<loop name="l" type="{kind}">{ends}{axis}</loop>'


WELD = (
    '<loop name="l" type="fixed"><predecessor link="d"/><successor link="c">'
    '<origin xyz="0 1.5 0" rpy="0 3.141592653589793 1.5707963267948966"/></successor></loop>'
)


def robot_text(*elements):
    """A file with elements in ``<robot>``."""
    return f'<robot name="r">\n{"".join(elements)}\n</robot>'


def compare_drafts(found, wanted):
    """Assert that two files are the same linkage, apart from the names of their loops."""
    assert [j.kind for j in found.joints] == [j.kind for j in wanted.joints]
    assert [j.parent for j in found.joints] == [j.parent for j in wanted.joints]
    assert [b.name for b in found.bodies] == [b.name for b in wanted.bodies]
    for name, part in (("joints", "screw"), ("bodies", "inertia"), ("loops", "gap")):
        for one, other in zip(getattr(found, name), getattr(wanted, name), strict=True):
            np.testing.assert_allclose(getattr(one, part), getattr(other, part), atol=1e-14)
    assert [(m.joint, m.source, m.ratio) for m in found.mimics] == [
        (m.joint, m.source, m.ratio) for m in wanted.mimics
    ]


def answer(path):
    """Ranks by order, nullity, bodies and certainty of a file."""
    space = certify(design_space(kinematics.load(path)))
    ranks = [order.rank for order in space.orders]
    return ranks, space.nullity, space.bodies, space.certainty.level


def codes(draft):
    """Codes of the remarks on a file, without those on its angles."""
    return [notice.code for notice in draft.notices if notice.code != "rounded_angles"]


def draft_of(folder, *elements):
    """The linkage of a file, its loops not yet closed."""
    path = folder / "robot.urdf"
    path.write_text(robot_text(*elements), encoding="utf-8")
    return read_unassembled(path)


def refused(folder, *elements):
    """The error of a file that is refused, which is one line."""
    path = folder / "robot.urdf"
    path.write_text(robot_text(*elements), encoding="utf-8")
    return refusal(path)
