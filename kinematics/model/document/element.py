"""The data of a URDF file: its elements, and its bytes if it cannot be read again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from kinematics.error_text import clean


class Document(NamedTuple):
    """A URDF file that was read from a stream, or written for a linkage that has no file.

    Attributes:
        name: its name in messages.
        data: its bytes.
    """

    name: str
    data: bytes


@dataclass(frozen=True, slots=True)
class Element:
    """An XML element.

    Attributes:
        tag: name of the element, with its prefix if it has one.
        attributes: values by name.
        children: elements inside, in the order of the file.
        line: line of the file, from 1; 0 if it is from no file.
        text: character data directly inside, stripped.
        span: byte positions in the file of its beginning and of its end tag, or of its end if
            it has no end tag; (0, 0) if it is from no file.
    """

    tag: str
    attributes: Mapping[str, str] = field(default_factory=dict)
    children: tuple[Element, ...] = ()
    line: int = 0
    text: str = ""
    span: tuple[int, int] = field(default=(0, 0), compare=False)

    @property
    def name(self) -> str:
        """The ``name`` attribute, or an empty string."""
        return self.attributes.get("name", "")

    @property
    def label(self) -> str:
        """Name of the element in messages, such as ``joint 'j1' (line 12)``."""
        name = f"{self.tag} '{clean(self.name)}'" if self.name else f"<{clean(self.tag)}>"
        return f"{name} (line {self.line})" if self.line else name

    def every(self, tag: str) -> list[Element]:
        """List the children with this tag."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> Element | None:
        """Find the first child with this tag; None if there is none."""
        return next((child for child in self.children if child.tag == tag), None)

    def link_at(self, role: str) -> str:
        """Name of the link on one side of a joint or loop; its own without such a side."""
        return (self.first(role) or self).attributes.get("link", "")

    def without_lines(self) -> Element:
        """Copy an element of another file: lines in messages are those of the main file."""
        children = tuple(child.without_lines() for child in self.children)
        return replace(self, children=children, line=0)

    def vector(self, attribute: str, default: str) -> list[float]:
        """Convert an attribute that `kinematics.files.urdf.validate` has accepted to numbers.

        Args:
            default: text to convert if the element does not have it.
        """
        return [float(word) for word in self.attributes.get(attribute, default).split()]

    def walk(self) -> Iterator[Element]:
        """Yield this element and all inside it, in the order of the file."""
        stack = [self]
        while stack:
            item = stack.pop()
            yield item
            stack.extend(reversed(item.children))


def unused_name(name: str, taken: set[str]) -> str:
    """Choose a name that is not taken, and take it.

    Args:
        taken: names that are taken; the chosen one is added.
    """
    while name in taken:
        name += "_"
    taken.add(name)
    return name
