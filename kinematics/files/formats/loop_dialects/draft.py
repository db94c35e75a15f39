"""The tree of a file while loops in the words of other tools are added to it.

A dialect names links, gives frames on them and types of joints. All of it is checked here like
the elements of the file itself, so that a dialect refuses in one line whatever is wrong.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from typing import TYPE_CHECKING

from kinematics.error_text import clean, closest_names
from kinematics.files.urdf.rounded_angles import replace_rounded_angles
from kinematics.files.urdf.validate_fields import (
    are_numbers,
    check_only,
    check_origin,
    check_type,
)
from kinematics.files.urdf.validate_misplaced import MAX_WORD, MIN_SPELLING_RATIO
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

if TYPE_CHECKING:
    from kinematics.files.formats.loop_dialects.file_poses import FilePoses


ZERO = "0 0 0"
"""The numbers of an origin that is not given."""

Side = tuple[str, Element | None]
"""One side of a loop: the name of a link, and the ``<origin>`` of the frame of the loop."""

_KINDS = {"ball": "spherical"}


def end_name(item: Element, role: str) -> str:
    """Find the name of a link in a child or an attribute of an element; empty without one.

    Args:
        role: tag of the child, or name of the attribute.

    Raises:
        Refusal: there are two such children.
    """
    inner = check_only(item, role)
    if inner is None:
        return item.attributes.get(role, "").strip()
    return (inner.attributes.get("link", "") or inner.name or inner.text).strip()


def check_spelling(owner: Element, item: Element, *spellings: str) -> None:
    """Reject children and attributes that misspell a known one and would be lost.

    Args:
        item: the element that holds them.
        spellings: tags and names of attributes; others are those of another program.

    Raises:
        Refusal: there is one.
    """
    for word in (*(child.tag for child in item.children), *item.attributes):
        plain = word.rpartition(":")[2].lower()
        if word in spellings or len(plain) > MAX_WORD:
            continue
        if matches := get_close_matches(plain, spellings, 1, MIN_SPELLING_RATIO):
            problem = f"'{clean(word)}' in <{clean(item.tag)}> (line {item.line}) is not read"
            raise Refusal(owner.label, problem, f"write {matches[0]}, or remove it")


def read_numbers(owner: Element, item: Element, text: str, count: int) -> list[str]:
    """Split a text to the words of finite decimal numbers.

    Args:
        item: element with the text.
        text: an attribute of it, or its text.
        count: how many numbers there must be.

    Raises:
        Refusal: there is another count, or other text.
    """
    if not are_numbers(text, count):
        where = f"'{clean(text)}' in <{clean(item.tag)}> (line {item.line})"
        what = f"{count} finite numbers" if count > 1 else "a finite number"
        raise Refusal(owner.label, f"{where} is not {what}", "correct it")
    return text.split()


def write_instead(kind: str, first: str = "", second: str = "") -> str:
    """Compose the remedy for a closure that cannot be read: the ``<loop>`` to write.

    Args:
        kind: type of the loop.
        first: name of the predecessor, if it is known.
        second: name of the successor, if it is known.
    """
    axis = "" if kind in ("fixed", "spherical") else '<axis xyz="…"/>'
    return (
        f'write <loop name="…" type="{clean(kind) or "…"}"><predecessor '
        f'link="{clean(first) or "…"}"><origin xyz="…"/></predecessor><successor '
        f'link="{clean(second) or "…"}"><origin xyz="…"/></successor>{axis}</loop> in its place'
    )


class Draft:
    """The tree of a file, and what was translated.

    Attributes:
        tree: the checked ``<robot>``.
        links: names of its links.
        joints: joints by name; dialects replace those that they change.
        carriers: name of the joint that carries a link, by the link's name.
        root: name of the link that no joint carries.
        loops: translated loops, and the dialect of each.
        remarks: code and message of each remark for the user.
    """

    def __init__(self, tree: Element, nominal: bool) -> None:
        """Index a tree; ``nominal`` is whether its rounded angles will be replaced."""
        self.tree, self._nominal = tree, nominal
        self.links = {link.name for link in tree.every("link")}
        self.joints = {joint.name: joint for joint in tree.every("joint")}
        self.carriers = {end_name(j, "child"): name for name, j in self.joints.items()}
        self.root = next(name for name in self.links if name not in self.carriers)
        self.loops: list[tuple[Element, str]] = []
        self.remarks: list[tuple[str, str]] = []
        self._poses: FilePoses | None = None

    @property
    def poses(self) -> FilePoses:
        """The poses of links at the pose of the file; numeric libraries load only here."""
        if self._poses is None:
            from kinematics.files.formats.loop_dialects.file_poses import FilePoses

            parts = self.tree.every("link") + self.tree.every("joint")
            bare = replace(self.tree, children=tuple(parts))
            self._poses = FilePoses(replace_rounded_angles(bare) if self._nominal else bare)
        return self._poses

    def nominal_origin(self, origin: Element | None) -> Element | None:
        """Return an ``<origin>`` with rounded angles replaced, if those of the file will be."""
        if origin is None or not self._nominal:
            return origin
        joint = Element("joint", {"type": "fixed"}, (origin,))
        wrapped = replace_rounded_angles(Element("robot", {}, (joint,)))
        return wrapped.children[0].children[0]

    def tell(self, code: str, item: Element, text: str) -> None:
        """Add a remark on an element.

        Args:
            text: what is said of it.
        """
        self.remarks.append((code, f"{item.label}: {text}"))

    def link(self, item: Element, name: str, kind: str = "", grounded: bool = False) -> str:
        """Check that an element names a link of the file.

        Args:
            name: as it is written there.
            kind: type of the loop, for the remedy.
            grounded: whether ``world`` means the root link, unless a link is called so.

        Returns:
            The name.

        Raises:
            Refusal: there is no such link.
        """
        if not name:
            problem = "it closes a loop and does not name two links"
            raise Refusal(item.label, problem, write_instead(kind))
        if name in self.links:
            return name
        if grounded and name == "world":
            return self.root
        remedy = f"correct the name; the links are {closest_names(name, sorted(self.links))}"
        raise Refusal(item.label, f"link '{clean(name)}' does not exist", remedy)

    def body(self, link: str) -> str:
        """Find the topmost link of the rigid body of a link."""
        while link in self.carriers:
            joint = self.joints[self.carriers[link]]
            if joint.attributes["type"] != "fixed":
                break
            link = end_name(joint, "parent")
        return link

    def place(self, link: str) -> tuple[str, list[Element | None]]:
        """Find the rigid body of a link, and the ``<origin>``s from it to the link."""
        origins: list[Element | None] = []
        body = self.body(link)
        while link != body:
            joint = self.joints[self.carriers[link]]
            origins.insert(0, joint.first("origin"))
            link = end_name(joint, "parent")
        return body, origins

    def moving_joints(self, link: str) -> Iterator[Element]:
        """List the joints that move between a link and the root, from the link upwards."""
        while link in self.carriers:
            joint = self.joints[self.carriers[link]]
            if joint.attributes["type"] != "fixed":
                yield joint
            link = end_name(joint, "parent")

    def origin(self, item: Element, xyz: str = ZERO, rpy: str = ZERO) -> Element:
        """Make and check the ``<origin>`` of the frame of a loop.

        Args:
            item: the element that gives it.
            xyz: three numbers, metres.
            rpy: three numbers, radians.

        Raises:
            Refusal: they are not three and three finite numbers.
        """
        attributes = {"xyz": xyz, "rpy": rpy}
        if rpy.split() == ZERO.split():
            del attributes["rpy"]
        origin = Element("origin", attributes, (), item.line)
        check_origin(item, Element(item.tag, {}, (origin,), item.line))
        return origin

    def add_loop(
        self,
        item: Element,
        dialect: str,
        kind: str,
        sides: Sequence[Side],
        axes: Mapping[str, str],
    ) -> None:
        """Add a loop; one that welds two links of one rigid body closes nothing.

        Args:
            item: the element that gives it.
            dialect: its dialect: loops of one dialect do not repeat each other.
            kind: type of the joint that closes it.
            axes: text of ``axis`` and ``axis2``, as in a ``<loop>``.

        Raises:
            Refusal: the type, an axis or an origin is wrong, or it joins a body to itself.
        """
        kind = _KINDS.get(kind, kind)
        ends = [
            Element(role, {"link": link}, (origin,) if origin else (), item.line)
            for role, (link, origin) in zip(("predecessor", "successor"), sides, strict=True)
        ]
        lines = [Element(tag, {"xyz": text}, (), item.line) for tag, text in axes.items()]
        name = item.name if item.name.strip() else self._free_name(item.tag)
        attributes = {"name": name, "type": kind}
        if "independent" in item.attributes:
            attributes["independent"] = item.attributes["independent"]
        loop = Element("loop", attributes, (*ends, *lines), item.line, "", item.span)
        check_type(replace(loop, tag=item.tag))
        for end in ends:
            check_origin(item, end)
        if self.body(sides[0][0]) == self.body(sides[1][0]):
            if kind != "fixed":
                problem = "it joins two links of one rigid body"
                raise Refusal(item.label, problem, "let it join links that can move apart")
            return
        self.loops.append((loop, dialect))

    def _free_name(self, tag: str) -> str:
        """Compose a name that no joint and no loop has."""
        taken = {*self.joints, *(loop.name for loop in self.tree.every("loop"))}
        taken |= {loop.name for loop, _ in self.loops}
        stem, count = tag.rpartition(":")[2], 1
        while f"{stem}_{count}" in taken:
            count += 1
        return f"{stem}_{count}"
