"""Read URDF files from a pipe or from standard input, which can be read only once."""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Hashable

from kinematics.files.urdf.xml_tree import MAX_BYTES, Refusal, check_bytes, name_file
from kinematics.model.document.element import Document

STANDARD_INPUT = "-"
"""The model that is read from standard input."""
STANDARD_INPUT_NAME = "<stdin>"
"""Its name in messages."""


def source_name(model: str | os.PathLike[str] | Document) -> str:
    """Name a file in messages: its path, or the name of its stream."""
    return model.name if isinstance(model, Document) else os.fsdecode(model)


def stream_identity(model: str | os.PathLike[str]) -> Hashable | None:
    """Device and inode of the stream that a model comes through; None if it is no stream."""
    try:
        if os.fspath(model) == STANDARD_INPUT:
            status = os.fstat(0)
        else:
            status = os.stat(model)
            if not (stat.S_ISFIFO(status.st_mode) or stat.S_ISSOCK(status.st_mode)):
                return None
    except (OSError, ValueError):
        return STANDARD_INPUT if os.fspath(model) == STANDARD_INPUT else None
    return status.st_dev, status.st_ino


def read_stream(model: str | os.PathLike[str]) -> Document | None:
    """Read a model to its end if it comes through a stream.

    Args:
        model: ``-`` for standard input, or a path.

    Returns:
        The document; None if the path is no stream.

    Raises:
        FileError: the stream cannot be read, is empty, or exceeds the size limit of a file.
    """
    if stream_identity(model) is None:
        return None
    standard = os.fspath(model) == STANDARD_INPUT
    name = STANDARD_INPUT_NAME if standard else os.fsdecode(model)
    with name_file(name):
        try:
            data = _read_input() if standard else _read_pipe(model)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise Refusal("", f"cannot be read ({reason})", "give the path of a file") from None
        return Document(name, check_bytes(data))


def _read_input() -> bytes:
    stream = getattr(sys.stdin, "buffer", None)
    if stream is None:
        raise ValueError("there is no standard input")
    return stream.read(MAX_BYTES + 1) or b""


def _read_pipe(path: str | os.PathLike[str]) -> bytes:
    with open(path, "rb") as stream:
        return stream.read(MAX_BYTES + 1)
