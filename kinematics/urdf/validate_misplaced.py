"""What a URDF parser would pass over in silence although it was meant.

Parsers skip what they do not know, for many tools keep elements of their own in these files.
So a joint in ``<Joint>``, an axis in ``<limit>``, a number in ``xzy`` and a position between
tags would be lost. They are refused here; what other tools write is not.
"""

from __future__ import annotations

from difflib import get_close_matches
from functools import cache

from kinematics.error_text import clean
from kinematics.urdf.xml_tree import Refusal
from kinematics.urdf_elements.element import Element

__all__ = ["check_misplaced"]

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
# Attributes of joints and loops, next to which other tools write theirs.
_OWN = ("independent", "name", "type")
# Elements of other tools, in which some of these words mean something else.
_FOREIGN = {
    "calibration", "collision", "contact", "dynamics", "gazebo", "joint_properties", "limit",
    "material", "ros2_control", "safety_controller", "sensor", "surface", "transmission",
    "visual",
}  # fmt: skip
_UNSUPPORTED = {"coupling": "use <mimic> on a joint", "loop_joint": "use a <loop> element"}
# Links and robots have more of other tools' elements, which say where something is.
_ELSEWHERE = {"link": ("inertial", "mass", "inertia"), "robot": ("link", "joint", "loop")}
# Words that fingers make of others have so much in common with them, in parts of 1.
ALIKE = 0.7
ZEROS = {"0", "0.0", "-0", "-0.0"}


def check_misplaced(robot: Element) -> None:
    """Nothing that was meant goes unread.

    Raises:
        Refusal: a word is misspelt, or an element, an attribute or a text is where it does
            not count.
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
    known = _ATTRIBUTES.get(item.tag, ())
    for name, value in item.attributes.items():
        plain = name.rpartition(":")[2]
        if item.tag in ("joint", "loop"):
            meant = "" if name in _OWN else _meant(plain, _OWN)
            if not meant:
                continue
        elif not known or name in known or name.startswith(("xmlns", "quat")):
            continue
        elif ":" in name and not _meant(plain, known):
            continue
        elif (item.tag, name) == ("axis", "rpy") and set(value.split()) <= ZEROS:
            continue  # Old exporters write it beside every axis.
        else:
            meant = _meant(plain, known) or " or ".join(known)
        problem = f"<{item.tag} {clean(name)}> is not read"
        raise Refusal(item.label, problem, f"write {meant}, or remove it")


def _check_text(item: Element) -> None:
    """No numbers or tags between tags, where there are attributes and elements instead."""
    leaf = item.tag in _ATTRIBUTES and item.tag not in _PARTS
    if item.text and ("<" in item.text or (leaf and (item.attributes or item.tag == "origin"))):
        problem = f"the text '{clean(item.text, 40)}' in <{item.tag}> is not read"
        remedy = "write it as elements and attributes, or remove it"
        raise Refusal(item.label, problem, remedy)


def _check_child(host: Element, item: Element) -> None:
    """A child that is no part of its host is of another tool, and holds no parts."""
    word = item.tag.rpartition(":")[2]
    unsupported = word if word in _UNSUPPORTED else ""
    if host.tag in ("joint", "robot") and len(word) > len("loop"):
        unsupported = unsupported or _meant(word, ("loop_joint",))
    if unsupported:
        problem = f"<{clean(item.tag)}> is not supported"
        raise Refusal(item.label, problem, _UNSUPPORTED[unsupported])
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
    if (meant := _meant(word, parts)) and item.tag not in _FOREIGN:
        raise Refusal(item.label, f"{where} is not read", f"write <{meant}>, or remove it")
    if word in _FOREIGN:
        return
    if meant := word if word in _WORDS else _meant(word, tuple(sorted(_WORDS))):
        places = [f"<{tag}>" for tag, inside in _PARTS.items() if meant in inside]
        spelt = "" if word == meant else f"write <{meant}> and "
        remedy = f"{spelt}move it into its {' or '.join(places)}, or remove it"
        raise Refusal(item.label, f"{where} is not read", remedy)
    sought = _ELSEWHERE.get(host.tag, _WORDS)
    for inner in item.walk():
        if inner.tag in sought and (host.tag != "robot" or inner.children):
            problem = f"inside <{clean(item.tag)}> (line {item.line}), where it is not read"
            raise Refusal(inner.label, problem, f"move it out of <{clean(item.tag)}>")


@cache
def _meant(word: str, known: tuple[str, ...]) -> str:
    """The known word of which another was made by a slip; empty if there is none."""
    if len(word) > 40:
        return ""
    found = get_close_matches(word.lower(), known, 1, ALIKE)
    return found[0] if found else ""
