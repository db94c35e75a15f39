"""Tell the floating joint of a base from those of other bodies, and fix the base if wanted.

Links that fixed joints connect are one rigid body. Bodies that moving joints or loops connect,
other than through the ground, are one mechanism. A floating joint carries the base of a
mechanism if it alone carries it from the ground; any other floating joint, such as that of a
platform whose legs stand on the ground, is six joints.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from kinematics.error_text import clean, quoted
from kinematics.files.urdf.read_options import RobotFile
from kinematics.files.urdf.validate import validate_tree
from kinematics.files.urdf.validate_fields import check_needed
from kinematics.files.urdf.xml_tree import Refusal, name_file
from kinematics.model.document.element import Element

BASE_FIXED = "base_fixed"
"""The code of the remark on a base that was fixed to the ground."""

FLOATING = "floating"
"""The code of the remark on floating joints that are read as six joints each."""


class _Mechanism(NamedTuple):
    """What connects one mechanism to the ground.

    Attributes:
        joints: the moving joints of the tree that do.
        loops: bodies that a loop connects to the ground.
        bodies: its rigid bodies, by the names of their topmost links.
    """

    joints: list[Element]
    loops: list[str]
    bodies: set[str]


def settle_floating_joints(file: RobotFile, source: str, fix_base: bool) -> RobotFile:
    """Fix the floating base of a robot if wanted, and say which bodies float.

    Args:
        file: its checked elements, with all its loops.
        source: name of the file in messages.
        fix_base: change the floating joint of the base into a fixed one.

    Returns:
        The elements with a remark on each change.

    Raises:
        FileError: a base floats freely and is not to be fixed.
    """
    tree = file.tree
    floating = [j for j in tree.every("joint") if j.attributes["type"] == "floating"]
    if not floating:
        return file
    bases = {joint.name: free for joint, free in _find_bases(tree)}
    with name_file(source):
        for joint in floating if not fix_base else ():
            if bases.get(joint.name):
                remedy = "fix the base with --fix-base (fix_base=True), or use a fixed joint"
                problem = "a floating joint of the base is not supported"
                raise Refusal(joint.label, problem, remedy)
        fixed = [joint for joint in floating if fix_base and joint.name in bases]
        if fixed:
            tree = _fix(tree, {joint.name for joint in fixed})
            validate_tree(tree)
    others = [joint for joint in floating if not fix_base or joint.name not in bases]
    remarks = _remarks(source, fixed, others, fix_base)
    return file._replace(tree=tree, remarks=(*file.remarks, *remarks))


def _remarks(
    source: str, fixed: list[Element], others: list[Element], fix_base: bool
) -> Iterator[tuple[str, str]]:
    """Say which joints were fixed, and which bodies float."""
    file = clean(source, 1000)
    if fixed:
        bodies, names = (quoted(words) for words in _names(fixed))
        text = f"{file}: --fix-base fixes {bodies} to the ground: {names}"
        yield BASE_FIXED, text
    if others:
        bodies, names = (quoted(words) for words in _names(others))
        text = f"{file}: six freedoms of {bodies}: {names} (floating)"
        if fix_base:
            text += "; not a base, and not fixed"
        yield FLOATING, text


def _names(joints: list[Element]) -> tuple[list[str], list[str]]:
    """Names of the links that joints carry, and of the joints."""
    return [check_needed(j, "child", "link") for j in joints], [j.name for j in joints]


def _fix(tree: Element, names: set[str]) -> Element:
    """Change the joints with these names into fixed ones."""
    children = tuple(
        replace(item, attributes={**item.attributes, "type": "fixed"})
        if item.tag == "joint" and item.name in names
        else item
        for item in tree.children
    )
    return replace(tree, children=children)


def _find_bases(tree: Element) -> Iterator[tuple[Element, bool]]:
    """Yield the floating joints of bases, and whether no loop holds their mechanisms."""
    mechanisms = _find_mechanisms(tree)
    for mechanism in mechanisms:
        first, *more = mechanism.joints
        body = check_needed(first, "child", "link")
        alone = len(mechanism.bodies) == 1 and len(mechanisms) > 1
        carried = first.attributes["type"] == "floating" and not more and not alone
        if carried and body not in mechanism.loops:
            yield first, not mechanism.loops


def _find_mechanisms(tree: Element) -> list[_Mechanism]:
    """Find the mechanisms of a robot, in the order in which the ground carries them."""
    top = topmost_links(tree)
    moving = [j for j in tree.every("joint") if j.attributes["type"] != "fixed"]
    pairs = [_ends(joint, ("parent", "child"), top) for joint in moving]
    loops = [_ends(loop, ("predecessor", "successor"), top) for loop in tree.every("loop")]
    carried = {after for _, after in pairs}
    ground = {body for body in top.values() if body not in carried}
    groups = _connected([pair for pair in (*pairs, *loops) if not ground & {*pair}])
    mechanisms: dict[int, _Mechanism] = {}
    for joint, (before, after) in zip(moving, pairs, strict=True):
        if before in ground:
            bodies = groups.setdefault(after, {after})
            mechanism = mechanisms.setdefault(id(bodies), _Mechanism([], [], bodies))
            mechanism.joints.append(joint)
    for pair in loops:
        for body in pair if ground & {*pair} else ():
            if body in groups and id(groups[body]) in mechanisms:
                mechanisms[id(groups[body])].loops.append(body)
    return list(mechanisms.values())


def topmost_links(tree: Element) -> dict[str, str]:
    """Find, for each link, the topmost link that fixed joints connect to it."""
    before = {
        check_needed(joint, "child", "link"): check_needed(joint, "parent", "link")
        for joint in tree.every("joint")
        if joint.attributes["type"] == "fixed"
    }
    top: dict[str, str] = {}
    for link in tree.every("link"):
        path = [link.name]
        while path[-1] in before and path[-1] not in top:
            path.append(before[path[-1]])
        top.update(dict.fromkeys(path, top.get(path[-1], path[-1])))
    return top


def _ends(item: Element, roles: tuple[str, str], top: dict[str, str]) -> tuple[str, str]:
    """Find the two rigid bodies of a joint or a loop."""
    first, second = (top[check_needed(item, role, "link")] for role in roles)
    return first, second


def _connected(pairs: list[tuple[str, str]]) -> dict[str, set[str]]:
    """Find the set of the bodies that pairs connect to each body."""
    groups: dict[str, set[str]] = {}
    for pair in pairs:
        ends = [groups.setdefault(body, {body}) for body in pair]
        if ends[0] is not ends[1]:
            small, large = sorted(ends, key=len)
            large |= small
            groups.update(dict.fromkeys(small, large))
    return groups
