"""Changes to the bytes of an XML file that leave all others as they are.

Comments, blanks, line ends, the encoding and whatever other programs keep in the file stay.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from kinematics.reader.markup import Element

__all__ = ["Splice", "Text"]


class Splice(NamedTuple):
    """A text in place of the bytes from ``start`` to ``end``."""

    start: int
    end: int
    text: str


class Text:
    """The bytes of an XML file."""

    def __init__(self, data: bytes) -> None:
        """Keep the bytes, and find out how characters are coded."""
        # Other encodings that expat reads have ASCII's characters where ASCII has them.
        self.data, self.codec = data, "ascii"
        if data.startswith((b"\xff\xfe", b"<\0")):
            self.codec = "utf-16-le"
        elif data.startswith((b"\xfe\xff", b"\0<")):
            self.codec = "utf-16-be"

    def spliced(self, splices: Iterable[Splice]) -> bytes:
        """The bytes with other texts in some places, which do not overlap."""
        data = self.data
        for start, end, new in sorted(splices, reverse=True):
            coded = new.encode(self.codec, "xmlcharrefreplace")
            data = data[:start] + coded + data[end:]
        return data

    def is_tag(self, element: Element) -> bool:
        """Whether an element is one tag, without an end tag."""
        return not self.data.startswith(f"</{element.tag}".encode(self.codec), element.span[1])

    def end(self, element: Element) -> int:
        """Where an element ends."""
        last = element.span[1]
        if self.is_tag(element):
            return last
        return self.data.index(">".encode(self.codec), last) + self.size(">")

    def margin(self, at: int) -> str:
        """The line break and the blanks before a place; empty if more is on its line."""
        width, found = self.size(" "), ""
        while (char := self.data[at - width : at].decode(self.codec, "replace")) in (" ", "\t"):
            found, at = char + found, at - width
        if char not in ("\r", "\n"):
            return ""
        before = self.data[at - 2 * width : at].decode(self.codec, "replace")
        return (before if before == "\r\n" else char) + found

    def size(self, text: str) -> int:
        """Number of bytes of a text."""
        return len(text.encode(self.codec))
