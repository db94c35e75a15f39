"""The file of a linkage with other masses: new ``<inertial>`` elements, all else as it was.

The text is spliced where its elements begin and end, so that comments, blanks, line ends, the
encoding and whatever other programs keep in the file stay the same bytes.
"""

from __future__ import annotations

from collections.abc import Mapping

from kinematics.model.linkage import UnassembledLinkage
from kinematics.urdf.edit_xml import Splice, Text, read_source
from kinematics.urdf.validate_fields import check_needed
from kinematics.urdf_elements.element import Element

__all__ = ["replace_inertials"]


def replace_inertials(linkage: UnassembledLinkage, inertials: Mapping[str, str]) -> bytes:
    """The bytes of the linkage's URDF file with new inertial parameters of its bodies.

    Links that fixed joints join are one body. Its topmost link, after which it is named,
    gets the whole of it, and the others lose their ``<inertial>``. Links of bodies that are
    not named, the ground among them, are left as they are.

    Args:
        linkage: the linkage, or a draft of it, as read from a file.
        inertials: element ``<inertial>`` of each body by its name, in the frame of that
            link, in lines indented by two blanks, as `balance.BodyInertia.urdf` is.

    Raises:
        FileError: the linkage was not read from a file, or the file cannot be read any
            more, or its links are not those of the linkage.
    """
    data, found = read_source(linkage, "link", "in which masses could be replaced")
    assert linkage.tree is not None
    links = {link.name: link for link in found.every("link")}
    top = _tops(linkage.tree)
    text = _Inertials(data)
    splices = [
        text.changed(link, inertials.get(name))
        for name, link in links.items()
        if top[name] in inertials
    ]
    return text.replace([splice for splice in splices if splice is not None])


def _tops(robot: Element) -> dict[str, str]:
    """The topmost of the links that fixed joints join to each link, by its name."""
    parent = {
        check_needed(joint, "child", "link"): check_needed(joint, "parent", "link")
        for joint in robot.every("joint")
        if joint.attributes["type"] == "fixed"
    }

    def topmost(name: str) -> str:
        while name in parent:
            name = parent[name]
        return name

    return {link.name: topmost(link.name) for link in robot.every("link")}


class _Inertials(Text):
    """The bytes of an XML file, in which to find room for inertial elements."""

    def changed(self, link: Element, inertial: str | None) -> Splice | None:
        """What gives a link its inertial in place of its old one; None takes that away."""
        old = link.first("inertial")
        if old is not None:
            start, end = old.span[0], self.end(old)
            margin = self.margin(start)
            if inertial is None:
                return Splice(start - self.size(margin), end, "")
            return Splice(start, end, _set(inertial, margin))
        return self.added(link, inertial) if inertial is not None else None

    def added(self, link: Element, inertial: str) -> Splice:
        """A first child for a link."""
        start, end = link.span
        if link.children:
            at = link.children[0].span[0]
            margin = self.margin(at)
            return Splice(at, at, _set(inertial, margin) + margin)
        if self.is_tag(link):
            margin = self.margin(start)
            inside = f">{_deeper(margin)}{_set(inertial, _deeper(margin))}{margin}</{link.tag}>"
            return Splice(end - self.size("/>"), end, inside)
        margin = self.margin(end)
        inside = _set(inertial, _deeper(margin))
        return Splice(end, end, f"{_deeper(margin).removeprefix(margin)}{inside}{margin}")


def _set(inertial: str, margin: str) -> str:
    """The lines of an element at a margin, or all in one line if there is none."""
    lines = inertial.split("\n")
    if not margin:
        return "".join(line.strip() for line in lines)
    return margin.join(line.replace("  ", _step(margin)) for line in lines)


def _deeper(margin: str) -> str:
    """The margin of what is inside an element."""
    return margin and margin + _step(margin)


def _step(margin: str) -> str:
    """By how much an element is indented more than the one around it."""
    return "\t" if "\t" in margin else "  "
