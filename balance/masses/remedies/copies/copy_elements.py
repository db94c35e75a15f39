"""Copy all elements of a URDF file but its root, and place the copy by a fixed joint.

A turned copy is rigidly turned: its elements are those of the file, on a fixed joint to the
root. A mirrored copy is turned too, and inverted in the origin of its root frame: positions
``x → -x`` in every frame, so that rotations of frames, axes of turns (axial vectors) and
inertia tensors stay, and slides and pitches of screws (polar) change their sign. No number of
the file changes but by its sign. Meshes are not mirrored: mirrored links have no pictures.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from balance.masses.remedies.copies.symmetric_copies import Copy
from balance.masses.remedies.variant import append_elements, free_name
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document, Element

_PICTURES = ("visual", "collision")
_SIDES = ("parent", "child", "predecessor", "successor")


class Copied(NamedTuple):
    """A linkage with copies of it.

    Attributes:
        document: its URDF file.
        names: the copied links, joints and loops of each copy, by their names in the linkage.
        links: all new links.
        joints: all new joints and loops.
    """

    document: Document
    names: tuple[Mapping[str, str], ...]
    links: tuple[str, ...]
    joints: tuple[str, ...]


def copy_linkage(
    document: Document, robot: Element, copies: Sequence[Copy], driven: Iterable[str]
) -> Copied:
    """Append copies of a linkage to its file, driven in step with it.

    Args:
        robot: its checked elements, loops in other words translated.
        copies: where the copies are.
        driven: joints that turn or slide the linkage: those of the copies mimic them.

    Returns:
        The new file.
    """
    items = [item for item in robot.children if item.tag in ("link", "joint", "loop")]
    taken = {item.name for item in items}
    sides = (child for joint in robot.every("joint") for child in joint.every("child"))
    carried = {child.attributes["link"] for child in sides}
    (root,) = (link.name for link in robot.every("link") if link.name not in carried)
    elements: list[Element] = []
    renamings: list[dict[str, str]] = []
    for number, copy in enumerate(copies, 1):
        suffix = "_copy" if len(copies) == 1 else f"_copy{number}"
        names = {}
        for item in items:
            names[item.name] = free_name(f"{item.name}{suffix}", taken)
            taken.add(names[item.name])
        mount = free_name(f"{names[root]}_mount", taken)
        taken.add(mount)
        at = make_elements.origin(copy.pose)
        elements += [
            make_elements.link(names[root]),
            make_elements.joint(mount, "fixed", root, names[root], at),
        ]
        writer = _Writer(names, frozenset(driven), copy.mirrored)
        elements += [writer.element(item) for item in items if item.name != root]
        renamings.append(names)
    return Copied(
        append_elements(document, elements), tuple(renamings),
        tuple(item.name for item in elements if item.tag == "link"),
        tuple(item.name for item in elements if item.tag != "link"),
    )  # fmt: skip


class _Writer(NamedTuple):
    """The writer of one copy: names of its parts, driven joints, whether it is mirrored."""

    names: Mapping[str, str]
    driven: frozenset[str]
    mirrored: bool

    def element(self, item: Element) -> Element:
        """Copy a link, joint or loop."""
        attributes = {**item.attributes, "name": self.names[item.name]}
        attributes.pop("independent", None)
        slides = item.attributes.get("type") == "prismatic"
        children = [
            self.part(child, slides) for child in item.children
            if not (self.mirrored and child.tag in _PICTURES)
        ]  # fmt: skip
        if item.name in self.driven and item.tag == "joint":
            children = [child for child in children if child.tag != "mimic"]
            children.append(Element("mimic", {"joint": item.name, "multiplier": "1"}))
        return replace(item, attributes=attributes, children=tuple(children))

    def part(self, part: Element, slides: bool) -> Element:
        """Copy what is inside of a link, joint or loop, ``slides`` if it is prismatic."""
        attributes = dict(part.attributes)
        if part.tag in _SIDES:
            attributes["link"] = self.names[attributes["link"]]
        elif part.tag == "mimic":
            attributes["joint"] = self.names[attributes["joint"]]
        if self.mirrored:
            if part.tag == "origin" or (part.tag == "axis" and slides):
                attributes["xyz"] = _opposite(attributes.get("xyz", "0 0 0"))
            elif part.tag == "screw_thread_pitch":
                attributes["value"] = _opposite(attributes["value"])
        children = tuple(self.part(child, slides) for child in part.children)
        return replace(part, attributes=attributes, children=children)


def _opposite(text: str) -> str:
    """Change the signs of numbers in a text; all their decimals stay."""
    words = text.split()
    return " ".join(w[1:] if w[0] == "-" else f"-{w.removeprefix('+')}" for w in words)
