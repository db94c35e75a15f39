"""Choose the ground of a robot whose joints leave several links without one that carries them.

A link that no joint carries is a root. A root is loose if nothing moves on it: at most fixed
joints hang further links on it. The ground is the root that the user names; what is loose is
left out then, and the other roots float.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from kinematics.error_text import clean, closest_names, quoted
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element, unused_name

LEFT_OUT = "left_out"
"""The code of the remark on loose links that are left out."""

WORLD_IMPLIED = "world_implied"
"""The code of the remark on a link ``world`` that the file names and does not have."""

WORLD = "world"
Remarks = tuple[tuple[str, str], ...]


def choose_ground(robot: Element, source: str, ground: str | None) -> tuple[Element, Remarks]:
    """Choose the ground of a robot, before it is checked.

    Drake and others imply a link ``world``: it is added if a joint has it as its parent.

    Args:
        robot: the ``<robot>`` element, not yet checked.
        source: name of its file in messages.
        ground: name of a link; None for the only one that no joint carries.

    Returns:
        The element, the same if nothing changes, and code and message of each remark.

    Raises:
        Refusal: the link does not exist, or a joint carries it.
    """
    file, remarks = clean(source, 1000), []
    names = {link.name for link in robot.every("link")}
    if WORLD not in names and WORLD in {
        _end(joint, "parent") for joint in robot.every("joint")
    }:
        robot = replace(robot, children=(Element("link", {"name": WORLD}), *robot.children))
        remarks.append((WORLD_IMPLIED, f"{file}: no link 'world': the ground is taken for it"))
        names.add(WORLD)
    if ground is None:
        return robot, tuple(remarks)
    carrier = {_end(joint, "child"): joint for joint in robot.every("joint")}
    if ground not in names:
        remedy = f"choose from {closest_names(ground, [x for x in names if x not in carrier])}"
        raise Refusal(f"ground '{clean(ground)}'", "there is no such link", remedy)
    if ground in carrier:
        roots = quoted(name for name in names if name not in carrier)
        problem = f"{carrier[ground].label} carries it"
        remedy = f"choose a link that no joint carries: {roots}"
        raise Refusal(f"ground '{clean(ground)}'", problem, remedy)
    robot, loose, floating = _set_ground(robot, ground)
    if loose:
        remarks.append((LEFT_OUT, f"{file}: loose links are left out: {quoted(loose)}"))
    if floating:
        text = f"{file}: links that no joint carries float: {quoted(floating)}"
        remarks.append((LEFT_OUT, text))
    return robot, tuple(remarks)


def loose_links(
    links: Sequence[Element],
    joints: Sequence[Element],
    loops: Sequence[Element],
) -> tuple[list[str], list[str]]:
    """Tell roots on which something moves from loose ones.

    Args:
        links: the links of a robot.

    Returns:
        Names of the roots on which a joint or a loop moves, and of the loose ones.
    """
    carried = {_end(joint, "child") for joint in joints}
    roots = [link.name for link in links if link.name not in carried]
    joined = {_end(joint, "parent") for joint in joints if joint.attributes["type"] != "fixed"}
    joined |= {_end(loop, side) for loop in loops for side in ("predecessor", "successor")}
    hanging = _rigidly_hanging(joints)
    moved = [root for root in roots if joined & set(_rigid_body(root, hanging))]
    return moved, [root for root in roots if root not in moved]


def _set_ground(robot: Element, ground: str) -> tuple[Element, list[str], list[str]]:
    """Leave out what is loose, and let other roots float.

    Returns:
        The robot, and names of the links that are left out and of the roots that float.
    """
    joints = robot.every("joint")
    carried = {_end(joint, "child") for joint in joints}
    hanging = _rigidly_hanging(joints)
    roots = [link.name for link in robot.every("link") if link.name not in carried]
    loose: list[str] = []
    floating: list[str] = []
    for root in roots:
        if root == ground:
            continue
        body = _rigid_body(root, hanging)
        inside = {joint.name for joint in joints if _end(joint, "child") in body}
        if set(body) & set(_named_elsewhere(robot, set(body), inside)):
            floating.append(root)
        else:
            loose += body
    if not loose and not floating:
        return robot, loose, floating
    gone = set(loose)
    kept = [
        item
        for item in robot.children
        if not (item.tag == "link" and item.name in gone)
        and not (item.tag == "joint" and _end(item, "child") in gone)
    ]
    taken = {item.name for item in robot.children}
    for root in floating:
        name = unused_name(f"{root}_floats", taken)
        sides = (Element("parent", {"link": ground}), Element("child", {"link": root}))
        kept.append(Element("joint", {"name": name, "type": "floating"}, sides))
    return replace(robot, children=tuple(kept)), loose, floating


def _named_elsewhere(robot: Element, body: set[str], joints: set[str]) -> Iterator[str]:
    """Yield the names that elements outside of a rigid body use."""
    for item in robot.children:
        inside = item.name in (body if item.tag == "link" else joints)
        if item.tag in ("link", "joint") and inside:
            continue
        for part in item.walk():
            yield part.text
            yield from part.attributes.values()


def _rigidly_hanging(joints: Sequence[Element]) -> Mapping[str, list[str]]:
    """Links that fixed joints hang on each link."""
    hanging: dict[str, list[str]] = {}
    for joint in joints:
        if joint.attributes.get("type") == "fixed":
            hanging.setdefault(_end(joint, "parent"), []).append(_end(joint, "child"))
    return hanging


def _rigid_body(root: str, hanging: Mapping[str, list[str]]) -> list[str]:
    """List the links that fixed joints hang on a root, itself first."""
    body: dict[str, None] = {}
    ready = [root]
    while ready:
        link = ready.pop()
        if link not in body:
            body[link] = None
            ready += hanging.get(link, ())
    return list(body)


def _end(item: Element, role: str) -> str:
    """Find the link on one side of a joint or loop, which may be malformed."""
    side = item.first(role)
    return side.attributes.get("link", "") if side else ""
