"""Edit an XML file by replacing single byte ranges.

Comments, blanks, line ends, the encoding and the elements of other programs stay unchanged.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from kinematics.error_text import clean
from kinematics.errors import FileError
from kinematics.files.urdf.xml_tree import build_tree, name_file, read_bytes
from kinematics.model.document.element import Element
from kinematics.model.linkage import UnassembledLinkage


def read_source(linkage: UnassembledLinkage, tag: str, purpose: str) -> tuple[bytes, Element]:
    """Read the file of a linkage again, to edit it; a stream has its document.

    Args:
        linkage: a linkage, assembled or not, that was read from a file.
        tag: elements whose names must be the same as when the file was read.
        purpose: end of "a model in memory, not a file …" in the error.

    Returns:
        Its bytes, and its elements with their byte ranges.

    Raises:
        FileError: the linkage was not read from a file, or the file cannot be read any more,
            or has elements of that tag with other names.
    """
    file = clean(linkage.source, 1000)
    if linkage.tree is None:
        problem = f"a model in memory, not a file {purpose}"
        raise FileError(file, "", problem, "load the linkage from the path of its URDF file")
    with name_file(linkage.source):
        data = linkage.document.data if linkage.document else read_bytes(linkage.source)
        root = build_tree(data)
    here, expected = ({x.name for x in tree.every(tag)} for tree in (root, linkage.tree))
    if here != expected:
        raise FileError(file, "", f"has other {tag}s than when it was read", "start again")
    return data, root


class Splice(NamedTuple):
    """A text that replaces the bytes from ``start`` to ``end``."""

    start: int
    end: int
    text: str


class Text:
    """The bytes of an XML file, and the edits to them."""

    def __init__(self, data: bytes) -> None:
        """Keep the bytes, and find the encoding of their characters."""
        # Other encodings that expat reads have ASCII's characters where ASCII has them.
        self.data, self.codec = data, "ascii"
        if data.startswith((b"\xff\xfe", b"<\0")):
            self.codec = "utf-16-le"
        elif data.startswith((b"\xfe\xff", b"\0<")):
            self.codec = "utf-16-be"

    def replace(self, splices: Iterable[Splice]) -> bytes:
        """Replace byte ranges, which must not overlap, by the texts of splices."""
        data = self.data
        for start, end, new in sorted(splices, reverse=True):
            coded = new.encode(self.codec, "xmlcharrefreplace")
            data = data[:start] + coded + data[end:]
        return data

    def is_tag(self, element: Element) -> bool:
        """Whether an element is one tag, without an end tag."""
        return not self.data.startswith(f"</{element.tag}".encode(self.codec), element.span[1])

    def end(self, element: Element) -> int:
        """Find the index after the last byte of an element."""
        last = element.span[1]
        if self.is_tag(element):
            return last
        return self.data.index(">".encode(self.codec), last) + self.size(">")

    def margin(self, at: int) -> str:
        """Find the line break and blanks before an index; empty if its line has other text."""
        width, blanks = self.size(" "), ""
        while (char := self.data[at - width : at].decode(self.codec, "replace")) in (" ", "\t"):
            blanks, at = char + blanks, at - width
        if char not in ("\r", "\n"):
            return ""
        before = self.data[at - 2 * width : at].decode(self.codec, "replace")
        return (before if before == "\r\n" else char) + blanks

    def size(self, text: str) -> int:
        """Count the bytes of a text."""
        return len(text.encode(self.codec))
