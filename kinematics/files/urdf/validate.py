"""Check a URDF file before any numeric library is loaded.

The checks on the bare XML tree reject whatever would otherwise be misread silently. Only the
standard library is imported, so that an invalid file is rejected at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from kinematics.error_text import clean, closest_names, quoted
from kinematics.files.urdf.choose_ground import loose_links
from kinematics.files.urdf.validate_fields import (
    MAX_ANGLE,
    MAX_NUMBER,
    check_link,
    check_needed,
    check_numbers,
    check_only,
    check_origin,
    check_type,
    rotates,
)
from kinematics.files.urdf.validate_misplaced import check_misplaced
from kinematics.files.urdf.xml_tree import Refusal, name_file
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import DEGREES_OF_FREEDOM, coordinate_names

# Largest number of degrees of freedom of all joints: cost grows with its third power.
MAX_FREEDOMS = 1000
_LOOP_PARTS = ("predecessor", "successor", "axis", "axis2")


def validate_robot(robot: Element, file: str) -> Element:
    """Check the tree of a robot.

    Args:
        robot: the ``<robot>`` element.
        file: name of its file in messages.

    Returns:
        The same element.

    Raises:
        FileError: it is not a linkage.
    """
    with name_file(file):
        validate_tree(robot)
    return robot


def validate_tree(robot: Element) -> None:
    """Run every check on a tree; only direct children of ``<robot>`` count.

    Raises:
        Refusal: it is not a linkage.
    """
    if robot.tag != "robot":
        remedy = "give a URDF, SDF or MJCF file"
        raise Refusal(robot.label, "the root element is not <robot>", remedy)
    _check_xacro(robot)
    check_misplaced(robot)
    links, joints, loops = (robot.every(tag) for tag in ("link", "joint", "loop"))
    if not links:
        raise Refusal(robot.label, "no <link>", "give a URDF file with links and joints")
    _check_names([robot], links, joints + loops)
    for link in links:
        check_link(link)
    for item in joints + loops:
        check_type(item)
    _check_count(joints + loops)
    by_name = {link.name: link for link in links}
    carrier = _carriers(by_name, joints)
    _check_tree(by_name, carrier)
    _check_roots(by_name, joints, loops)
    _check_mimics(joints)
    for loop in loops:
        _check_loop(loop, by_name, carrier)


def _check_xacro(robot: Element) -> None:
    """Reject elements and expressions of xacro."""
    remedy = "run xacro first (xacro robot.xacro > robot.urdf)"
    for item, of_xacro in walk_xacro(robot):
        if of_xacro:
            raise Refusal(item.label, "a xacro element, not URDF", remedy)
        for attribute, value in item.attributes.items():
            if "${" in value:
                problem = f'{attribute}="{clean(value)}" is a xacro expression'
                raise Refusal(item.label, problem, remedy)


def walk_xacro(root: Element) -> Iterator[tuple[Element, bool]]:
    """Yield all elements of a tree, and whether each is one of xacro."""
    prefixes = {"xacro"}
    for item in root.walk():
        for attribute, value in item.attributes.items():
            if attribute.startswith("xmlns:") and "xacro" in value:
                prefixes.add(attribute.removeprefix("xmlns:"))
        prefix, colon, _ = item.tag.partition(":")
        yield item, bool(colon) and prefix in prefixes


def _check_names(*groups: Sequence[Element]) -> None:
    """Check that names are present, and unique within a group, as are their coordinates."""
    for group in groups:
        taken: dict[str, Element] = {}
        for item in group:
            if not item.name.strip():
                raise Refusal(item.label, "no name", f'add name="…" to <{item.tag}>')
            if odd := [c for c in item.name if not c.isprintable()]:
                problem = f"its name has the unprintable character U+{ord(odd[0]):04X}"
                raise Refusal(item.label, problem, f"rename this {item.tag}")
            several = DEGREES_OF_FREEDOM.get(item.attributes.get("type", ""), 0) > 1
            derived = coordinate_names(item.name, item.attributes["type"]) if several else []
            for name in [item.name, *derived]:
                if name in taken:
                    problem = f"the name '{clean(name)}' is taken by {taken[name].label}"
                    raise Refusal(item.label, problem, f"rename this {item.tag}")
                taken[name] = item


def _check_count(items: Sequence[Element]) -> None:
    """Check that joints and loops have at most `MAX_FREEDOMS` degrees of freedom."""
    count = 0
    for item in items:
        count += DEGREES_OF_FREEDOM[item.attributes["type"]]
        if count > MAX_FREEDOMS:
            problem = f"joints and loops of more than {MAX_FREEDOMS} degrees of freedom"
            raise Refusal(item.label, problem, "analyse a part of it, or fix joints")


def _check_link_name(
    owner: Element, role: str, name: str, links: Mapping[str, Element]
) -> None:
    """Check that a link exists."""
    if name not in links:
        remedy = f"correct the name; the links are {closest_names(name, links)}"
        raise Refusal(owner.label, f"{role} link '{clean(name)}' does not exist", remedy)


def _carriers(links: Mapping[str, Element], joints: Sequence[Element]) -> dict[str, Element]:
    """Find the joint that carries each link, by the link's name; a link has at most one."""
    carrier: dict[str, Element] = {}
    for joint in joints:
        parent, child = (check_needed(joint, role, "link") for role in ("parent", "child"))
        _check_link_name(joint, "parent", parent, links)
        _check_link_name(joint, "child", child, links)
        if parent == child:
            problem = f"joins link '{clean(child)}' to itself"
            raise Refusal(joint.label, problem, "correct its <parent> or its <child>")
        if child in carrier:
            problem = f"link '{clean(child)}' is already the child of {carrier[child].label}"
            raise Refusal(joint.label, problem, "close the loop with a <loop> element instead")
        carrier[child] = joint
    return carrier


def _parent(joint: Element) -> str:
    return check_needed(joint, "parent", "link")


def _check_tree(links: Mapping[str, Element], carrier: Mapping[str, Element]) -> None:
    """Check that the joints form no cycles."""
    checked: set[str] = set()
    for start in links:
        path: dict[str, None] = {}
        name = start
        while name in carrier and name not in checked:
            if name in path:
                ring = list(path)[list(path).index(name) :]
                problem = f"the links {quoted(reversed(ring))} form a cycle of joints"
                remedy = "replace one of these joints with a <loop> element"
                raise Refusal(carrier[name].label, problem, remedy)
            path[name] = None
            name = _parent(carrier[name])
        checked.update(path)


def _check_roots(
    links: Mapping[str, Element], joints: Sequence[Element], loops: Sequence[Element]
) -> None:
    """Check that a single link is the ground."""
    moved, loose = loose_links(list(links.values()), joints, loops)
    if len(moved) == 1 and loose:
        problem = "a loose link: no joint connects it to the others"
        if len(loose) > 1:
            problem = f"loose links: no joint connects {quoted(loose)} to the others"
        remedy = (
            f"fix it to '{clean(moved[0])}' with a fixed joint, or leave it out with "
            f"--ground {clean(moved[0])}"
        )
        raise Refusal(links[loose[0]].label, problem, remedy)
    roots = [*moved, *loose]
    if len(roots) > 1:
        problem = f"more than one root: no joint carries the links {quoted(roots)}"
        remedy = "fix all but one of them to the ground with a fixed joint, or choose the "
        remedy += f"ground, as with --ground {clean(roots[0])}"
        raise Refusal(links[roots[1]].label, problem, remedy)


def _check_mimics(joints: Sequence[Element]) -> None:
    """Check that mimic joints and their sources have one degree of freedom, without circles.

    A ``<mimic>`` of a fixed joint is ignored: exporters that freeze a joint leave it in place.
    """
    named = {joint.name: joint for joint in joints}
    source: dict[str, str] = {}
    for joint in joints:
        mimic = check_only(joint, "mimic")
        if mimic is None or joint.attributes["type"] == "fixed":
            continue
        target = source[joint.name] = check_needed(joint, "mimic", "joint")
        check_numbers(joint, mimic, "multiplier", 1)
        check_numbers(joint, mimic, "offset", 1)
        if target not in named:
            remedy = f"correct the name; the joints are {closest_names(target, named)}"
            raise Refusal(joint.label, f"mimics unknown joint '{clean(target)}'", remedy)
        for end in (joint, named[target]):
            if DEGREES_OF_FREEDOM[end.attributes["type"]] != 1:
                problem = f"<mimic> needs joints of one degree of freedom; {end.label} is "
                problem += end.attributes["type"]
                raise Refusal(joint.label, problem, "remove the <mimic>, or fix this joint too")
    at: dict[str, float] = {}
    for start in source:
        path: dict[str, None] = {}
        name = start
        while name in source and name not in at:
            if name in path:
                problem = "mimics itself" if source[name] == name else "mimics in a circle"
                raise Refusal(named[name].label, problem, "let one of the joints be free")
            path[name] = None
            name = source[name]
        for follower in reversed(path):
            at[follower] = _mimic_position(named[follower], at.get(source[follower], 0.0))


def _mimic_position(joint: Element, position: float) -> float:
    """Position, in the pose of the file, of a mimic joint whose source is at ``position``."""
    mimic = joint.first("mimic") or joint
    (ratio,), (offset,) = mimic.vector("multiplier", "1"), mimic.vector("offset", "0")
    place = ratio * position + offset
    unit, most = ("rad", MAX_ANGLE) if rotates(joint) else ("m", MAX_NUMBER)
    if not abs(place) <= most:
        problem = f"its <mimic> places it at {place:.3g} {unit}, which is out of range"
        remedy = "correct the offsets and multipliers of the mimic joints"
        raise Refusal(joint.label, problem, remedy)
    return place


def _check_loop(
    loop: Element, links: Mapping[str, Element], carrier: Mapping[str, Element]
) -> None:
    """Check that a loop joins two links that can move relative to each other."""
    extra = [child.tag for child in loop.children if child.tag not in _LOOP_PARTS]
    sides = loop.every("predecessor") + loop.every("successor")
    extra += [item.tag for side in sides for item in side.children if item.tag != "origin"]
    if extra:
        problem = f"unknown child {', '.join(f'<{clean(tag)}>' for tag in extra[:8])}"
        remedy = f"a loop may hold {', '.join(_LOOP_PARTS)}, and its sides an origin"
        raise Refusal(loop.label, problem, remedy)
    ends = []
    for role in ("predecessor", "successor"):
        name = check_needed(loop, role, "link")
        _check_link_name(loop, role, name, links)
        check_origin(loop, loop.first(role) or loop)
        while name in carrier and carrier[name].attributes["type"] == "fixed":
            name = _parent(carrier[name])
        ends.append(name)
    if ends[0] == ends[1]:
        problem = "its predecessor and its successor are one rigid body"
        raise Refusal(loop.label, problem, "let it join links that can move apart")
