"""Replace the ``<include>`` elements of an MJCF file by what their files hold."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import replace

from kinematics.error_text import clean
from kinematics.files.urdf.xml_tree import (
    MAX_DEPTH,
    MAX_ELEMENTS,
    Refusal,
    build_tree,
    read_bytes,
)
from kinematics.model.document.element import Element

# Largest number of bytes of all included files.
MAX_INCLUDED = 64 * 2**20


def expand_includes(root: Element, path: str | None) -> Element:
    """Replace every ``<include>`` by the children of the root of its file.

    Args:
        root: the ``<mujoco>`` element.
        path: its file, whose folder holds the others; None for a stream.

    Returns:
        The element without includes. Elements of other files have line 0.

    Raises:
        Refusal: a file is missing, included twice or not well-formed, or the files exceed the
            limits of one file.
    """
    return _Expansion(path).expand(root)


def find_file(folder: str | None, names: list[str], item: Element) -> str:
    """Find the first of several paths that exists.

    Args:
        folder: of the main file; None for a stream.
        names: paths relative to it, or absolute.
        item: the element that names the file, for messages.

    Raises:
        Refusal: there is none, or the main file is a stream.
    """
    if folder is None:
        problem = f"names the file '{clean(names[0])}', and a stream has no folder"
        raise Refusal(item.label, problem, "give the path of the file")
    for name in names:
        if "\0" not in name and os.path.exists(path := os.path.join(folder, name)):
            return path
    problem = f"there is no file '{clean(names[0])}'"
    raise Refusal(item.label, problem, "put it beside the file, or correct its name")


class _Expansion:
    """The files that were included so far, and what they amount to."""

    def __init__(self, path: str | None) -> None:
        self.folder = None if path is None else os.path.dirname(path)
        self.seen = set() if path is None else {os.path.realpath(path)}
        self.bytes = self.elements = 0

    def expand(self, item: Element, nearby: str = "", depth: int = 1) -> Element:
        """Replace the includes inside an element whose file is in the folder ``nearby``."""
        self.elements += 1
        if self.elements > MAX_ELEMENTS or depth > MAX_DEPTH:
            problem = f"more than {MAX_ELEMENTS} elements or {MAX_DEPTH} levels of them"
            raise Refusal(item.label, problem, "split the file, or remove what is not needed")
        children: list[Element] = []
        for child in item.children:
            children += self._expand_child(child, nearby, depth)
        return replace(item, children=tuple(children))

    def _expand_child(self, child: Element, nearby: str, depth: int) -> Iterator[Element]:
        if child.tag.lower() != "include":
            yield self.expand(child, nearby, depth + 1)
            return
        name = child.attributes.get("file", "")
        if not name or child.children:
            raise Refusal(child.label, "an include without a file", 'write <include file="…"/>')
        path = find_file(self.folder, [name, os.path.join(nearby, name)], child)
        folder = os.path.relpath(os.path.dirname(path) or ".", self.folder or ".")
        for item in self._read(path, child).children:
            yield from self._expand_child(item, folder, depth)

    def _read(self, path: str, child: Element) -> Element:
        """Read an included file, without the lines of its elements."""
        where = os.path.realpath(path)
        if where in self.seen:
            remedy = "include each file once"
            raise Refusal(child.label, "includes a file for the second time", remedy)
        self.seen.add(where)
        try:
            data = read_bytes(path)
            self.bytes += len(data)
            if self.bytes > MAX_INCLUDED:
                problem = f"more than {MAX_INCLUDED // 2**20} MB of included files"
                raise Refusal("", problem, "include less")
            return build_tree(data).without_lines()
        except Refusal as refusal:
            element, problem, remedy = refusal.args
            text = ": ".join(part for part in (clean(path), element, problem) if part)
            raise Refusal(child.label, text, remedy) from None
