"""Judge what was read of a mutant of another format, or of a dialect of URDF.

Each judge returns how a case ended: ``read``, ``translated``, ``told``, ``harmless`` or
``refused``. It raises an AssertionError if a joint of the file that may close a loop is neither
in what was read nor told of, or if a refusal is not one clean line.
"""

from __future__ import annotations

from collections.abc import Callable
from xml.etree import ElementTree

from kinematics.errors import FileError
from kinematics.files.formats.robot_files import read_robot, read_unassembled
from kinematics.files.urdf.read_options import ReadOptions, RobotFile
from kinematics.model.document.element import Document, Element
from kinematics.model.linkage import UnassembledLinkage
from tests.fuzz.dialect_mutants import dialect_mutant
from tests.fuzz.mjcf_mutants import mjcf_mutant
from tests.fuzz.sdf_mutants import sdf_mutant

TOLD = {
    "closing_frames",
    "loops_inactive",
    "loops_repeated",
    "springs_ignored",
    "unread_closure",
}

Read = tuple[RobotFile, UnassembledLinkage]


def judge_dialect(seed: int) -> str:
    """How a URDF file with elements of other tools ends."""
    case = dialect_mutant(seed)
    found = _read("case.urdf", case.urdf)
    if found is None:
        return "refused"
    robot, linkage = found
    assert len(linkage.loops) == len(robot.tree.every("loop"))
    if robot.dialects:
        return "translated"
    if any(code in TOLD for code, _ in robot.remarks):
        return "told"
    if any("fixed" in j.attributes["type"] or j.first("mimic") for j in _changed(robot.tree)):
        return "translated"
    together = _rigid_bodies(robot.tree)
    for links in case.named:
        assert len({together[link] for link in links}) < 2, f"silent on {links}"
    return "harmless"


def judge_sdf(seed: int) -> str:
    """How an SDF file ends: all joints of its model are joints or loops."""
    data = sdf_mutant(seed)
    found = _read("case.sdf", data)
    if found is None:
        return "refused"
    robot, _ = found
    known = {item.name for tag in ("joint", "loop") for item in robot.tree.every(tag)}
    for model in ElementTree.fromstring(data).iter("model"):
        if model.get("name") == robot.tree.name:
            names = {joint.get("name") for joint in model.findall("joint")}
            assert names <= known, f"silent on {names - known}"
    return "read"


def judge_mjcf(seed: int) -> str:
    """How an MJCF file ends: a constraint in force is a loop or a relation, or is told of."""
    data = mjcf_mutant(seed)
    found = _read("case.xml", data, ReadOptions(fix_base=seed % 2 == 0))
    if found is None:
        return "refused"
    robot, linkage = found
    constraints = [
        item
        for section in ElementTree.fromstring(data).findall("equality")
        for item in section
        if item.get("active") != "false" and (item.tag != "joint" or item.get("joint2"))
    ]
    told = any("equalit" in text or "constraint" in text for _, text in robot.remarks)
    assert not constraints or linkage.loops or linkage.mimics or told, "silent on equalities"
    return "read"


JUDGES: dict[str, Callable[[int], str]] = {
    "dialects": judge_dialect,
    "mjcf": judge_mjcf,
    "sdf": judge_sdf,
}


def _read(name: str, data: bytes, options: ReadOptions | None = None) -> Read | None:
    """Read a file; None if it is refused in one clean line.

    Raises:
        AssertionError: the line is not clean.
    """
    document, options = Document(name, data), options or ReadOptions()
    try:
        return read_robot(document), read_unassembled(document, None, options)
    except FileError as error:
        text = str(error)
        assert text.splitlines() == [text] and text.isprintable() and len(text) < 5000, text
        assert text.startswith(f"{name}: ") and error.problem and error.remedy, text
        return None


def _changed(tree: Element) -> list[Element]:
    """Joints of a tree that have another line in them than their own."""
    return [
        joint
        for joint in tree.every("joint")
        if any(part.span == (0, 0) for part in joint.children)
    ]


def _rigid_bodies(tree: Element) -> dict[str, str]:
    """The topmost link of the rigid body of each link, by the fixed joints alone."""
    found = {link.name: link.name for link in tree.every("link")}
    ends = [
        [side.attributes["link"] for side in (joint.first("parent"), joint.first("child"))]
        for joint in tree.every("joint")
        if joint.attributes["type"] == "fixed"
    ]
    for _ in ends:
        for parent, child in ends:
            found[child] = found[parent]
    return found
