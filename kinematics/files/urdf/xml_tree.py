"""Parse an XML file to a small frozen tree, in one pass of the standard library's expat.

Entities, great depth, great numbers of elements and great size are rejected: a URDF file does
not need them, and an attacker could use them.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from xml.parsers import expat

from kinematics.error_text import clean
from kinematics.errors import FileError
from kinematics.model.document.element import Element

# Largest file: URDF files of robots have at most a few megabytes, without meshes.
MAX_BYTES = 16 * 2**20
# Deepest nesting of elements.
MAX_DEPTH = 200
# Largest number of elements.
MAX_ELEMENTS = 100_000
# Longest value of an attribute, in characters.
MAX_VALUE = 100_000
# Longest tag or comment, in bytes: parsing stops within a longer one.
MAX_TOKEN = 2**20
# Bytes that are parsed at a time.
_CHUNK = 2**16
# Largest file whose tree is kept for the next who reads the same bytes.
_KEPT = 2**17

_POINTER = b"version https://git-lfs"
# Byte order mark, blanks and comments, and a declaration after them. What is before it is
# matched once: a comment that could end at any later ``-->`` takes for ever in a file without
# declaration.
_MISPLACED = re.compile(
    rb"(\xef\xbb\xbf)?((?>(?:[ \t\r\n]|<!--.*?-->)+))(<\?xml[ \t\r\n][^>]*\?>)", re.DOTALL
)
_WIDE = (b"\xff\xfe\0\0", b"\0\0\xfe\xff")
_REMEDIES = {
    expat.errors.XML_ERROR_UNKNOWN_ENCODING: "save it as UTF-8",
    expat.errors.XML_ERROR_INCORRECT_ENCODING: "save it as UTF-8",
    expat.errors.XML_ERROR_UNDEFINED_ENTITY: "write the character itself",
    expat.errors.XML_ERROR_MISPLACED_XML_PI: "remove what precedes <?xml, blank lines too",
}
# Signs that may precede a document, and those with which one begins, of 16 bits too.
_BEFORE_XML, _XML_STARTS = b"\xef\xbb\xbf \t\r\n", (b"<", b"\xff\xfe", b"\xfe\xff", b"\0")


class Refusal(Exception):
    """Element, problem and remedy of a `FileError` that still lacks its file."""


@contextmanager
def name_file(file: str) -> Iterator[None]:
    """Convert a `Refusal` inside the block to the `FileError` of a file."""
    try:
        yield
    except Refusal as refusal:
        raise FileError(clean(file, 1000), *refusal.args) from None


def read_bytes(path: str, limit: int = MAX_BYTES) -> bytes:
    """Read a file of at most ``limit`` bytes.

    Args:
        limit: largest number of bytes.

    Returns:
        The bytes.

    Raises:
        Refusal: it is missing, not a regular file, unreadable, empty, or too large.
    """
    try:
        data = _read_regular(path, limit + 1)
    except FileNotFoundError:
        raise Refusal("", "no such file", "check the path") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise Refusal("", f"cannot be read ({reason})", "check the path") from None
    return check_bytes(data, limit)


def check_bytes(data: bytes, limit: int = MAX_BYTES) -> bytes:
    """Check that bytes can be those of a text file.

    Args:
        limit: largest number of bytes.

    Returns:
        The same bytes.

    Raises:
        Refusal: there are more than ``limit`` or none, or they are UTF-32 or a pointer of
            Git LFS.
    """
    if len(data) > limit:
        size = f"{limit // 2**20} MB" if limit >= 2**20 else f"{limit // 2**10} kB"
        raise Refusal("", f"larger than {size}", "keep meshes in files of their own")
    if not data.strip():
        raise Refusal("", "empty file", "export or save it again")
    if data.startswith(_WIDE):
        raise Refusal("", "text in UTF-32", "save it as UTF-8")
    if data.startswith(_POINTER):
        remedy = "fetch the file itself with 'git lfs pull'"
        raise Refusal("", "a pointer of Git LFS in place of the file", remedy)
    return data


def _read_regular(path: str, size: int) -> bytes:
    """Read up to ``size`` bytes of a regular file that does not change meanwhile.

    The file is opened without waiting: a pipe may have replaced it since the first check.
    """
    if not stat.S_ISREG(os.stat(path).st_mode):
        raise Refusal("", "not a file", "give the path of a file")
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    with open(os.open(path, flags), "rb") as stream:
        before = os.fstat(stream.fileno())
        if not stat.S_ISREG(before.st_mode):
            raise Refusal("", "not a file", "give the path of a file")
        data = stream.read(size)
        after = os.fstat(stream.fileno())
    if (before.st_size, before.st_mtime_ns) != (after.st_size, after.st_mtime_ns):
        raise Refusal("", "changed while it was read", "read it again once it is written")
    return data


def build_tree(data: bytes) -> Element:
    """Parse an XML document to its root element.

    Raises:
        Refusal: the document is not well-formed, or exceeds a limit.
    """
    return _parse_again(data) if len(data) <= _KEPT else _parse(data)


def _parse(data: bytes) -> Element:
    """Parse a document; see `build_tree`."""
    builder = _Builder()
    try:
        builder.feed(_declaration_first(data))
    except expat.ExpatError as error:
        where = f"not well-formed XML at line {error.lineno}, column {error.offset + 1}"
        problem = f"{where} ({expat.ErrorString(error.code)})"
        remedy = _REMEDIES.get(expat.ErrorString(error.code), "export or save it again")
        if not data.lstrip(_BEFORE_XML).startswith(_XML_STARTS):
            remedy = "give a robot as URDF, SDF or MJCF: such files begin with <"
        raise Refusal("", problem, remedy) from None
    except (ValueError, LookupError) as error:
        problem = f"not readable as XML ({clean(str(error))})"
        raise Refusal("", problem, "save it as UTF-8") from None
    return builder.closed[0]


# The last few trees of small files: who changes a file step by step reads it again and again.
_parse_again = lru_cache(maxsize=4)(_parse)


def _declaration_first(data: bytes) -> bytes:
    """Exchange ``<?xml …?>`` and what stands before it: blanks and comments, without meaning.

    All that follows keeps its place in the file.
    """
    match = _MISPLACED.match(data[:_CHUNK])
    if match is None:
        return data
    mark, before, declaration = match.groups(b"")
    return mark + declaration + before + data[match.end() :]


class _Builder:
    """Expat handlers that build the tree, with a stack of the open elements."""

    def __init__(self) -> None:
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.characters
        self.parser.StartDoctypeDeclHandler = self.doctype
        self.count = 0
        self.open: list[tuple[str, dict[str, str], int, list[Element], list[str], int]] = []
        self.closed: list[Element] = []

    def feed(self, data: bytes) -> None:
        """Parse chunk by chunk, so that an endless token stops in its middle."""
        for start in range(0, len(data), _CHUNK):
            end = start + _CHUNK
            self.parser.Parse(data[start:end], end >= len(data))
            if end - max(self.parser.CurrentByteIndex, 0) > MAX_TOKEN + _CHUNK:
                label = f"line {self.parser.CurrentLineNumber}"
                problem = f"a tag or a comment of more than {MAX_TOKEN // 2**20} MB"
                raise Refusal(label, problem, "shorten it")

    def doctype(self, *_: object) -> None:
        label = f"<!DOCTYPE> (line {self.parser.CurrentLineNumber})"
        raise Refusal(label, "entities are not accepted", "remove the DOCTYPE")

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        label = f"<{clean(tag)}> (line {line})"
        self.count += 1
        if self.count > MAX_ELEMENTS:
            remedy = "split the file, or remove what is not part of the linkage"
            raise Refusal(label, f"more than {MAX_ELEMENTS} elements", remedy)
        if len(self.open) >= MAX_DEPTH:
            raise Refusal(label, f"more than {MAX_DEPTH} levels deep", "nest less deeply")
        if max(map(len, attributes.values()), default=0) > MAX_VALUE:
            raise Refusal(label, f"a value of more than {MAX_VALUE} characters", "shorten it")
        for name in (tag, *attributes):
            if ":" in name and not all(name.split(":", 1)):
                problem = f"the name '{clean(name)}' begins or ends with a colon"
                raise Refusal(label, problem, "remove the colon")
        self.open.append((tag, attributes, line, [], [], self.parser.CurrentByteIndex))

    def characters(self, text: str) -> None:
        self.open[-1][4].append(text)

    def end(self, _: str) -> None:
        tag, attributes, line, children, text, start = self.open.pop()
        siblings = self.open[-1][3] if self.open else self.closed
        span = start, self.parser.CurrentByteIndex
        inside = "".join(text).strip()
        siblings.append(Element(tag, attributes, tuple(children), line, inside, span))
