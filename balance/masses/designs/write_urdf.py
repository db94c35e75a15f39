"""Write a linkage's URDF file with new ``<inertial>`` elements and no other change.

The text is edited where its elements begin and end. Comments, blanks, line ends, the encoding
and elements of other programs stay the same bytes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from kinematics.files.urdf.edit_xml import Splice, Text, read_source
from kinematics.files.urdf.floating_joints import topmost_links
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_lines
from kinematics.model.linkage import UnassembledLinkage


def replace_inertials(linkage: UnassembledLinkage, inertials: Mapping[str, str]) -> bytes:
    """Return the linkage's URDF file with new inertial parameters of its bodies.

    Links that fixed joints join, or that a loop without a joint welds together, are one body,
    named after its topmost link. That link gets the whole ``<inertial>``, and the others lose
    theirs. Links of other bodies, such as the ground, do not change.

    Args:
        linkage: a linkage that was read from a file.
        inertials: element ``<inertial>`` of each body by its name, in the frame of that
            link, in lines indented by two blanks, as `balance.bodies.BodyInertia.urdf` is.

    Returns:
        The bytes of the new file.

    Raises:
        FileError: the linkage was not read from a file, or the file can no longer be
            read, or its links are not those of the linkage.
    """
    data, tree = read_source(linkage, "link", "in which masses could be replaced")
    assert linkage.tree is not None
    links = {link.name: link for link in tree.every("link")}
    top, welded = topmost_links(linkage.tree), _welded_bodies(linkage)
    text = _Inertials(data)
    splices = [
        text.replacement(link, inertials.get(name))
        for name, link in links.items()
        if welded.get(linkage.places[name].link, top[name]) in inertials
    ]
    return text.replace([splice for splice in splices if splice is not None])


def append_to_file(data: bytes, root: Element, elements: Iterable[Element]) -> bytes:
    """Append elements before the end tag of a URDF file; every other byte stays.

    Args:
        root: the element of the file.
        elements: links, joints and loops, in order.
    """
    text, at = Text(data), root.span[1]
    end = text.margin(at)
    margin = text.margin(root.children[-1].span[0]) or end
    place = at - text.size(end)
    lines = (line for element in elements for line in element_lines(element, ""))
    return text.replace([Splice(place, place, "".join(f"{margin}{line}" for line in lines))])


def _welded_bodies(linkage: UnassembledLinkage) -> dict[int, str]:
    """Find the body of each link that loops without a joint weld to the link of a body."""
    groups: dict[int, set[int]] = {}
    for loop in linkage.loops:
        if not linkage.joints[loop.end].in_loop:
            group = groups.get(loop.end, {loop.end}) | groups.get(
                loop.successor, {loop.successor}
            )
            groups |= dict.fromkeys(group, group)
    names = {body.link: body.name for body in linkage.bodies}
    return {
        link: names[other]
        for link, group in groups.items()
        for other in group
        if link not in names and other in names
    }


class _Inertials(Text):
    """The bytes of an XML file, with the edits that set inertial elements."""

    def replacement(self, link: Element, inertial: str | None) -> Splice | None:
        """Build the edit that sets a link's ``<inertial>``; None as text removes it."""
        old = link.first("inertial")
        if old is not None:
            start, end = old.span[0], self.end(old)
            margin = self.margin(start)
            if inertial is None:
                return Splice(start - self.size(margin), end, "")
            return Splice(start, end, _indent(inertial, margin))
        return self.insertion(link, inertial) if inertial is not None else None

    def insertion(self, link: Element, inertial: str) -> Splice:
        """Build the edit that inserts an ``<inertial>`` as the first child of a link."""
        start, end = link.span
        if link.children:
            at = link.children[0].span[0]
            margin = self.margin(at)
            return Splice(at, at, _indent(inertial, margin) + margin)
        if self.is_tag(link):
            margin = self.margin(start)
            inner = _child_margin(margin)
            inside = f">{inner}{_indent(inertial, inner)}{margin}</{link.tag}>"
            return Splice(end - self.size("/>"), end, inside)
        margin = self.margin(end)
        inside = _indent(inertial, _child_margin(margin))
        return Splice(end, end, f"{_child_margin(margin).removeprefix(margin)}{inside}{margin}")


def _indent(inertial: str, margin: str) -> str:
    """Indent the lines of an element by a margin; without one, join them."""
    lines = inertial.split("\n")
    if not margin:
        return "".join(line.strip() for line in lines)
    return margin.join(line.replace("  ", _step(margin)) for line in lines)


def _child_margin(margin: str) -> str:
    """Return the margin of the children of an element."""
    return margin and margin + _step(margin)


def _step(margin: str) -> str:
    """Return the indentation of one level."""
    return "\t" if "\t" in margin else "  "
