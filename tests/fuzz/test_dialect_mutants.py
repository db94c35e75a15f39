"""Loops of other tools are translated, refused in one line or told of: never silently open.

``python tests/fuzz/test_dialect_mutants.py 100000`` runs as many cases as it is told.
"""

import sys
from collections import Counter
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
_PATHS = [str(ROOT / name) for name in ("", "tests/helpers", "tests/independent")]
sys.path[:0] = [path for path in _PATHS if path not in sys.path]

from dialect_mutants import dialect_mutant  # noqa: E402
from time_limit import time_limit  # noqa: E402

from kinematics.errors import FileError  # noqa: E402
from kinematics.formats.robot_files import read_robot, read_unassembled  # noqa: E402
from kinematics.urdf_elements.element import Document, Element  # noqa: E402

CASES, LIMIT = 1500, 20.0
TOLD = {
    "closing_frames", "loops_inactive", "loops_repeated", "springs_ignored", "unread_closure",
}  # fmt: skip


def outcome(seed: int) -> str:
    """How a case ends.

    Raises:
        AssertionError: the file is read as if nothing had been said, or refused badly.
    """
    case = dialect_mutant(seed)
    document = Document("case.urdf", case.urdf)
    try:
        robot = read_robot(document)
        linkage = read_unassembled(document)
    except FileError as error:
        text = str(error)
        assert text.splitlines() == [text] and text.isprintable() and len(text) < 5000
        assert text.startswith("case.urdf: ") and error.problem and error.remedy
        return "refused"
    assert len(linkage.loops) == len(robot.tree.every("loop"))
    if robot.dialects:
        return "translated"
    if any(code in TOLD for code, _ in robot.remarks):
        return "told"
    if any("fixed" in j.attributes["type"] or j.first("mimic") for j in changed(robot.tree)):
        return "translated"
    together = bodies(robot.tree)
    for links in case.named:
        assert len({together[link] for link in links}) < 2, f"seed {seed}: silent on {links}"
    return "harmless"


def changed(tree: Element) -> list[Element]:
    """Joints of a tree that have another line in them than their own."""
    return [
        joint for joint in tree.every("joint")
        if any(part.span == (0, 0) for part in joint.children)
    ]  # fmt: skip


def bodies(tree: Element) -> dict[str, str]:
    """The topmost link of the rigid body of each link, by the fixed joints alone."""
    found = {link.name: link.name for link in tree.every("link")}
    ends = [
        [side.attributes["link"] for side in (joint.first("parent"), joint.first("child"))]
        for joint in tree.every("joint") if joint.attributes["type"] == "fixed"
    ]  # fmt: skip
    for _ in ends:
        for parent, child in ends:
            found[child] = found[parent]
    return found


def run(seeds: range) -> tuple[Counter, list[str]]:
    """Outcomes of some seeds, and what was found wrong."""
    counts, wrong = Counter(), []
    for seed in seeds:
        try:
            with time_limit(LIMIT):
                counts[outcome(seed)] += 1
        except Exception as error:
            wrong.append(f"seed {seed}: {type(error).__name__}: {error}")
    return counts, wrong


def test_no_loop_of_another_tool_is_lost():
    counts, wrong = run(range(CASES))
    assert not wrong, "\n".join(wrong[:20])
    assert counts["translated"] > 0.1 * CASES and counts["refused"] > 0.2 * CASES
    assert counts["told"] > 0.02 * CASES


if __name__ == "__main__":
    totals, errors = run(range(int(sys.argv[2]) if len(sys.argv) > 2 else 0, int(sys.argv[1])))
    print("\n".join(errors[:50]), totals, f"{len(errors)} found", sep="\n")
