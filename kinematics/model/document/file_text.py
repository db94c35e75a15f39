"""Text of a file that an interpreter does not echo."""

from __future__ import annotations


class FileText(str):
    """The text of a file; its ``repr`` is one line, and ``print`` shows it."""

    __slots__ = ()

    def __repr__(self) -> str:
        """One line, in place of pages of characters."""
        return f"<text of a file, {len(self)} characters; print shows it>"
