"""Reject misspelt and misplaced elements, attributes and texts of a URDF file.

URDF parsers skip unknown elements, for many tools keep their own in these files. A joint in
``<Joint>``, an axis in ``<limit>``, a number in ``xzy`` and a position between tags would be
lost silently. They are rejected here; elements of other tools are not.
"""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache

from kinematics.error_text import clean
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

_PARTS = {
    "robot": ("link", "joint", "loop"),
    "link": ("inertial",),
    "inertial": ("origin", "mass", "inertia"),
    "joint": ("parent", "child", "origin", "axis", "axis2", "mimic", "screw_thread_pitch"),
    "loop": ("predecessor", "successor", "axis", "axis2"),
    "predecessor": ("origin",),
    "successor": ("origin",),
}
_ATTRIBUTES = {
    "parent": ("link",),
    "child": ("link",),
    "predecessor": ("link",),
    "successor": ("link",),
    "origin": ("xyz", "rpy"),
    "axis": ("xyz",),
    "axis2": ("xyz",),
    "mass": ("value",),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
    "mimic": ("joint", "multiplier", "offset"),
    "screw_thread_pitch": ("value",),
}
_WORDS = frozenset(_PARTS) - {"robot"} | frozenset(_ATTRIBUTES)
# Attributes next to which other tools write theirs.
_OWN = {
    "joint": ("independent", "name", "type"),
    "loop": ("independent", "name", "type"),
    "robot": ("name", "version"),
}
# Elements of other tools, in which some of these words mean something else.
_FOREIGN = {
    "calibration",
    "collision",
    "contact",
    "dynamics",
    "gazebo",
    "joint_properties",
    "limit",
    "material",
    "ros2_control",
    "safety_controller",
    "sensor",
    "surface",
    "transmission",
    "visual",
}
# Elements of `kinematics.files.formats.loop_dialects`, which belong into <robot>.
_DIALECTS = ("coupling", "loop_joint")
# Elements that count as misplaced inside an element of another tool, by the host of the latter:
# other elements of links and robots may hold origins and axes of their own.
_ELSEWHERE = {"link": ("inertial", "mass", "inertia"), "robot": ("link", "joint", "loop")}
# Minimum difflib ratio for a word to count as a misspelling of a known one.
MIN_SPELLING_RATIO = 0.7
# Longest word that is compared with known ones.
MAX_WORD = 40


def check_misplaced(robot: Element) -> None:
    """Reject misspelt and misplaced elements, attributes and texts.

    Raises:
        Refusal: a word is misspelt, or an element, an attribute or a text is in a place where
            it is not read.
    """
    hosts = [robot]
    while hosts:
        host = hosts.pop()
        _check_attributes(host)
        _check_text(host)
        for item in host.children:
            if item.tag in _PARTS.get(host.tag, ()):
                hosts.append(item)
            else:
                _check_child(host, item)
    top = {id(item) for item in robot.children}
    for item in robot.walk():
        if item.tag == "loop" and item.first("predecessor") and id(item) not in top:
            raise Refusal(item.label, "a loop inside another element", "move it into <robot>")


def _check_attributes(item: Element) -> None:
    """Reject attributes that are not read."""
    attributes = _ATTRIBUTES.get(item.tag, ())
    for name in item.attributes:
        plain = name.rpartition(":")[2]
        if item.tag in _OWN:
            allowed = _OWN[item.tag]
            namespace = item.tag == "robot" and ":" in name
            if name in allowed or namespace or not (intended := intended_word(plain, allowed)):
                continue
        elif not attributes or name in attributes or name.startswith(("xmlns", "quat")):
            continue
        elif ":" in name and not intended_word(plain, attributes):
            continue
        else:
            intended = intended_word(plain, attributes) or " or ".join(attributes)
        problem = f"<{item.tag} {clean(name)}> is not read"
        raise Refusal(item.label, problem, f"write {intended}, or remove it")


def _check_text(item: Element) -> None:
    """Reject numbers and tags between tags, which belong into attributes and elements."""
    leaf = item.tag in _ATTRIBUTES and item.tag not in _PARTS
    if item.text and ("<" in item.text or (leaf and (item.attributes or item.tag == "origin"))):
        problem = f"the text '{clean(item.text, 40)}' in <{item.tag}> is not read"
        remedy = "write it as elements and attributes, or remove it"
        raise Refusal(item.label, problem, remedy)


def _check_child(host: Element, item: Element) -> None:
    """Reject an unread child, unless it is an element of another tool without our elements."""
    word = item.tag.rpartition(":")[2]
    dialect = word if word in _DIALECTS else ""
    if host.tag in ("joint", "robot") and len(word) > len("loop"):
        dialect = dialect or intended_word(word, _DIALECTS)
    if dialect and (host.tag, item.tag) == ("robot", dialect):
        return
    if dialect:
        problem = f"<{clean(item.tag)}> in <{host.tag}> is not read"
        raise Refusal(item.label, problem, f"write <{dialect}> in <robot>, or remove it")
    if host.tag in ("loop", "predecessor", "successor") or (host.tag, word) == (
        "link",
        "origin",
    ):
        return
    where = f"<{clean(item.tag)}> in <{host.tag}>"
    if host.tag not in _PARTS:
        remedy = f"remove it: <{host.tag}> holds attributes only"
        raise Refusal(item.label, f"{where} is not read", remedy)
    parts = _PARTS[host.tag]
    if (intended := intended_word(word, parts)) and item.tag not in _FOREIGN:
        raise Refusal(item.label, f"{where} is not read", f"write <{intended}>, or remove it")
    if word in _FOREIGN:
        return
    if intended := word if word in _WORDS else intended_word(word, tuple(sorted(_WORDS))):
        places = [f"<{tag}>" for tag, inside in _PARTS.items() if intended in inside]
        spelling = "" if word == intended else f"write <{intended}> and "
        remedy = f"{spelling}move it into its {' or '.join(places)}, or remove it"
        raise Refusal(item.label, f"{where} is not read", remedy)
    wanted = _ELSEWHERE.get(host.tag, _WORDS)
    for inner in item.walk():
        if inner.tag in wanted and (host.tag != "robot" or inner.children):
            problem = f"inside <{clean(item.tag)}> (line {item.line}), where it is not read"
            raise Refusal(inner.label, problem, f"move it out of <{clean(item.tag)}>")


@cache
def intended_word(word: str, spellings: tuple[str, ...]) -> str:
    """Find the known word that another one misspells; empty if there is none."""
    if len(word) > MAX_WORD:
        return ""
    matches = get_close_matches(word.lower(), spellings, 1, MIN_SPELLING_RATIO)
    return matches[0] if matches else ""
