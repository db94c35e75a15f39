"""An XML file as a small frozen tree, in one pass of the standard library's expat.

Refuses whatever a URDF file has no use for and an attacker has: entities, great depth,
great numbers of elements, great size.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from xml.parsers import expat

__all__ = ["Element", "Refusal", "build", "contents", "shown"]

MAX_BYTES = 64 * 2**20
MAX_DEPTH = 200
MAX_ELEMENTS = 200_000
MAX_VALUE = 100_000


class Refusal(Exception):
    """Element, problem and remedy of a `FileError` that still lacks its file."""


def shown(text: str, limit: int = 80) -> str:
    """``text`` on one line, printable and short."""
    line = "".join(c if c.isprintable() else " " for c in text)
    return line if len(line) <= limit else line[:limit] + "…"


@dataclass(frozen=True, slots=True)
class Element:
    """An XML element.

    Attributes:
        tag: name of the element, with its prefix if it has one.
        attributes: values by name.
        children: elements inside, in the order of the file.
        line: line of the file, from 1.
        text: character data directly inside, stripped.
    """

    tag: str
    attributes: Mapping[str, str] = field(default_factory=dict)
    children: tuple[Element, ...] = ()
    line: int = 0
    text: str = ""

    @property
    def name(self) -> str:
        """The ``name`` attribute, or an empty string."""
        return self.attributes.get("name", "")

    @property
    def label(self) -> str:
        """How messages call the element, such as ``joint 'j1' (line 12)``."""
        name = f"{self.tag} '{shown(self.name)}'" if self.name else f"<{shown(self.tag)}>"
        return f"{name} (line {self.line})"

    def every(self, tag: str) -> list[Element]:
        """The children with this tag."""
        return [child for child in self.children if child.tag == tag]

    def first(self, tag: str) -> Element | None:
        """The first child with this tag, or None."""
        return next((child for child in self.children if child.tag == tag), None)

    def vector(self, attribute: str, default: str) -> list[float]:
        """The numbers in an attribute that :func:`check` has accepted."""
        return [float(word) for word in self.attributes.get(attribute, default).split()]

    def walk(self) -> Iterator[Element]:
        """This element and all inside it, in the order of the file."""
        stack = [self]
        while stack:
            item = stack.pop()
            yield item
            stack.extend(reversed(item.children))


def contents(path: str) -> bytes:
    """The bytes of a file.

    Raises:
        Refusal: it is missing, not a regular file, unreadable, empty, or too large.
    """
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise Refusal("", "not a file", "give the path of a URDF file")
        with open(path, "rb") as stream:
            data = stream.read(MAX_BYTES + 1)
    except FileNotFoundError:
        raise Refusal("", "no such file", "check the path") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise Refusal("", f"cannot be read ({reason})", "check the path") from None
    if len(data) > MAX_BYTES:
        limit = MAX_BYTES // 2**20
        raise Refusal("", f"larger than {limit} MB", "keep meshes in files of their own")
    if not data.strip():
        raise Refusal("", "empty file", "export or save it again")
    return data


def build(data: bytes) -> Element:
    """The root element of an XML document.

    Raises:
        Refusal: the document is not well-formed, or exceeds a limit.
    """
    builder = _Builder()
    try:
        builder.parser.Parse(data, True)
    except expat.ExpatError as error:
        where = f"not well-formed XML at line {error.lineno}, column {error.offset + 1}"
        problem = f"{where} ({expat.ErrorString(error.code)})"
        raise Refusal("", problem, "export or save it again") from None
    except (ValueError, LookupError) as error:
        problem = f"not readable as XML ({shown(str(error))})"
        raise Refusal("", problem, "save it as UTF-8") from None
    return builder.closed[0]


class _Builder:
    """Expat handlers that build the tree, with the elements still open on a stack."""

    def __init__(self) -> None:
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.characters
        self.parser.StartDoctypeDeclHandler = self.doctype
        self.count = 0
        self.open: list[tuple[str, dict[str, str], int, list[Element], list[str]]] = []
        self.closed: list[Element] = []

    def doctype(self, *_: object) -> None:
        label = f"<!DOCTYPE> (line {self.parser.CurrentLineNumber})"
        raise Refusal(label, "entities are not accepted", "remove the DOCTYPE")

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        line = self.parser.CurrentLineNumber
        label = f"<{shown(tag)}> (line {line})"
        self.count += 1
        if self.count > MAX_ELEMENTS:
            remedy = "split the file, or remove what is not part of the linkage"
            raise Refusal(label, f"more than {MAX_ELEMENTS} elements", remedy)
        if len(self.open) >= MAX_DEPTH:
            raise Refusal(label, f"more than {MAX_DEPTH} levels deep", "nest less deeply")
        if max(map(len, attributes.values()), default=0) > MAX_VALUE:
            raise Refusal(label, f"a value of more than {MAX_VALUE} characters", "shorten it")
        self.open.append((tag, attributes, line, [], []))

    def characters(self, text: str) -> None:
        self.open[-1][4].append(text)

    def end(self, _: str) -> None:
        tag, attributes, line, children, text = self.open.pop()
        siblings = self.open[-1][3] if self.open else self.closed
        siblings.append(Element(tag, attributes, tuple(children), line, "".join(text).strip()))
