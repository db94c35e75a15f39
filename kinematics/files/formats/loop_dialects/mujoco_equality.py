"""Equalities of MuJoCo in ``<mujoco>``: ``connect``, ``weld`` and ``joint``.

An anchor is given in the frame of one body; the other body has it where it is at the pose of
the file, which is MuJoCo's reference pose ``qpos0``.
"""

from __future__ import annotations

from kinematics.error_text import clean
from kinematics.files.formats.loop_dialects.draft import (
    ZERO,
    Draft,
    check_spelling,
    read_numbers,
    write_instead,
)
from kinematics.files.formats.loop_dialects.joint_relations import fix_joint, follow_joint
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

_DIALECT = "MuJoCo"
_LINE = "0 1 0 0 0".split()
_KINDS = {"connect": "spherical", "weld": "fixed"}
_WORLD = "world"
_ATTRIBUTES = (
    "active",
    "anchor",
    "body1",
    "body2",
    "class",
    "joint1",
    "joint2",
    "name",
    "polycoef",
    "relpose",
    "site1",
    "site2",
    "solimp",
    "solref",
    "torquescale",
)


def translate_mujoco(draft: Draft, mujoco: Element) -> None:
    """Translate the equalities inside a ``<mujoco>``.

    Args:
        draft: the tree of the file, which gets the loops.

    Raises:
        Refusal: an equality does not say enough, or has no equal in URDF.
    """
    for group in mujoco.walk():
        if group.tag == "equality":
            for item in group.children:
                _translate(draft, item)


def _translate(draft: Draft, item: Element) -> None:
    """Translate an equality, unless it is switched off."""
    check_spelling(item, item, *_ATTRIBUTES)
    active = item.attributes.get("active", "true")
    if active not in ("true", "false"):
        problem = f'active="{clean(active)}" is neither true nor false'
        raise Refusal(item.label, problem, "correct it")
    if active == "false":
        draft.tell("loops_inactive", item, 'active="false": not read')
    elif item.tag == "joint":
        _translate_joint(draft, item)
    elif item.tag in _KINDS:
        if item.tag == "weld" and _has_no_torque(item):
            _translate_weld(draft, item, "spherical")
        elif item.tag == "weld":
            _translate_weld(draft, item, "fixed")
        else:
            _translate_connect(draft, item)
    elif item.tag.startswith("flex"):
        draft.tell("flex_ignored", item, "a flexible body is not part of the linkage: not read")
    else:
        problem = f"an equality '{clean(item.tag)}' is not read"
        raise Refusal(item.label, problem, "write joints and loops that say the same")


def _has_no_torque(item: Element) -> bool:
    text = item.attributes.get("torquescale", "1")
    return not float(read_numbers(item, item, text, 1)[0])


def _bodies(draft: Draft, item: Element) -> tuple[str, str]:
    """Find the links of ``body1`` and ``body2``, which is the world by default."""
    kind = _KINDS[item.tag]
    if "site1" in item.attributes or "site2" in item.attributes:
        problem = "it names sites, which a URDF file does not have"
        raise Refusal(item.label, problem, write_instead(kind))
    first = draft.link(item, item.attributes.get("body1", "").strip(), kind, grounded=True)
    second = item.attributes.get("body2", _WORLD).strip()
    return first, draft.root if second == _WORLD and second not in draft.links else (
        draft.link(item, second, kind)
    )


def _translate_connect(draft: Draft, item: Element) -> None:
    """Add the point that two bodies share."""
    first, second = _bodies(draft, item)
    if "anchor" not in item.attributes:
        raise Refusal(item.label, "no anchor", write_instead("spherical", first, second))
    words = read_numbers(item, item, item.attributes["anchor"], 3)
    anchor = draft.origin(item, " ".join(words))
    _share_point(draft, item, (first, second), anchor)


def _share_point(draft: Draft, item: Element, links: tuple[str, str], anchor: Element) -> None:
    """Add a spherical loop, with its point given on the first link."""
    first, second = links
    there: Element | None = None
    if draft.body(first) != draft.body(second):
        there = draft.poses.origin_on(second, draft.poses.frame(first, anchor), item.line)
        there = draft.origin(item, there.attributes["xyz"])
    draft.add_loop(item, _DIALECT, "spherical", [(first, anchor), (second, there)], {})


def _translate_weld(draft: Draft, item: Element, kind: str) -> None:
    """Add a weld; without torque it holds a point."""
    first, second = _bodies(draft, item)
    text = item.attributes.get("anchor", ZERO)
    anchor = draft.origin(item, " ".join(read_numbers(item, item, text, 3)))
    pose = _relative_pose(item)
    if pose is not None:
        draft.add_loop(item, _DIALECT, kind, [(first, pose), (second, anchor)], {})
    elif kind == "spherical":
        _share_point(draft, item, (second, first), anchor)
    else:
        there: Element | None = None
        if draft.body(first) != draft.body(second):
            there = draft.poses.origin_on(second, draft.poses.frame(first, None), item.line)
        draft.add_loop(item, _DIALECT, kind, [(first, None), (second, there)], {})


def _relative_pose(item: Element) -> Element | None:
    """Read ``relpose``; None if it is that of the pose of the file."""
    if "relpose" not in item.attributes:
        return None
    words = read_numbers(item, item, item.attributes["relpose"], 7)
    from kinematics.files.formats.loop_dialects.file_poses import FilePoses, quaternion_pose

    pose = quaternion_pose(words)
    return None if pose is None else FilePoses.origin_of(pose, item.line)


def _translate_joint(draft: Draft, item: Element) -> None:
    """Relate two joints by a line, or fix one."""
    names = [item.attributes.get(role, "").strip() for role in ("joint1", "joint2")]
    if not names[0]:
        raise Refusal(item.label, 'no joint1="…"', "name the joint")
    text = item.attributes.get("polycoef", " ".join(_LINE))
    given = read_numbers(item, item, text, max(1, min(5, len(text.split()))))
    words = [*given, *_LINE[len(given) :]]
    if not names[1]:
        fix_joint(draft, item, names[0], words[0])
        return
    if any(float(word) for word in words[2:]):
        problem = "a polynomial of joint positions that is not a line is not read"
        raise Refusal(item.label, problem, "write the linkage that couples them as <loop>s")
    if float(words[1]):
        follow_joint(draft, item, (names[0], names[1]), words[1], words[0])
    else:
        fix_joint(draft, item, names[0], words[0])
