"""Methods of results that make files: pages and pictures.

What makes them is in `balance.app.answers.html`, above the results, whose classes name it as
``module:function``. `balance` registers the function that imports it by that name, and so a
result that is asked for its page imports what draws it, and no other.
"""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike, fspath
from typing import ClassVar

from balance.support.atomic_files import write_all_atomic
from kinematics.errors import UsageError
from kinematics.model.document.file_text import FileText

Maker = Callable[..., bytes]


class _Registered:
    """The function that makes files of results."""

    maker: Maker


def register_file_maker(maker: Maker) -> None:
    """Register the function that makes files.

    Args:
        maker: takes a result, ``"html"``, ``"png"`` or ``"svg"``, and options of the picture as
            keywords; its import must be cheap.
    """
    _Registered.maker = staticmethod(maker)


class FileBytes(bytes):
    """The bytes of a file; their ``repr`` is one line."""

    def __repr__(self) -> str:
        """One line, in place of pages of characters."""
        return f"<{len(self)} bytes of a file; .decode() gives its text>"


def write_file(path: str | PathLike[str] | None, data: bytes) -> FileBytes:
    """Write bytes to a file, as a whole or not at all, and return them; None writes none."""
    if path is not None:
        write_all_atomic([(fspath(path), data)])
    return FileBytes(data)


class Picture(bytes):
    """A picture, PNG or SVG, that notebooks show."""

    def __repr__(self) -> str:
        """One line, in place of pages of characters."""
        return f"<{'SVG' if self._repr_svg_() else 'PNG'} picture, {len(self)} bytes>"

    def _repr_png_(self) -> bytes | None:
        return None if self.startswith(b"<") else bytes(self)

    def _repr_svg_(self) -> str | None:
        return self.decode("utf-8") if self.startswith(b"<") else None


class WithPage:
    """A result that has a page; ``page_maker`` takes the result."""

    page_maker: ClassVar[str]

    def to_html(self, path: str | PathLike[str] | None = None) -> str:
        """Make the page that the command line writes with ``--html``.

        Args:
            path: file to write it to; None for none.

        Returns:
            The text of the page, which needs no network; an interpreter echoes one line.

        Raises:
            UsageError: there is no answer that a page could show.
            FileError: the file cannot be written.
        """
        return FileText(write_file(path, _Registered.maker(self, "html")).decode("utf-8"))


class WithPicture:
    """A result that has a picture; ``picture_maker`` takes the result, and the kind of file."""

    picture_maker: ClassVar[str]

    def plot(self, path: str | PathLike[str] | None = None) -> Picture:
        """Draw the result as charts.

        They show of a verification, a design and added matter the shaking force and moment
        along motions (of the last two before and after); of a front of added masses what is
        left to shake; of remedies what each costs; of springs the torques of the inputs; of an
        identification measured and predicted loads; of a quiet motion or a plan the rates of
        the inputs over time too; of paths the momentum along them; of a synthesis its
        mechanism.

        Args:
            path: file to write the picture to, which ends in ``.png`` or ``.svg``; None for
                none.

        Returns:
            The bytes of the picture, PNG without a path; notebooks show it, an interpreter
            echoes one line.

        Raises:
            UsageError: the path has another ending, or there is no answer to draw.
            PackageError: Matplotlib is missing.
            FileError: the file cannot be written.
        """
        return draw_file(self, path)


def draw_file(result: object, path: str | PathLike[str] | None, **options: object) -> Picture:
    """Draw a result; see `WithPicture.plot`.

    Args:
        options: of the picture.
    """
    kind = "png" if path is None else fspath(path)[-4:].lower().removeprefix(".")
    if kind not in ("png", "svg"):
        raise UsageError(f"{path}: a picture ends in .png or .svg")
    return Picture(write_file(path, _Registered.maker(result, kind, **options)))
