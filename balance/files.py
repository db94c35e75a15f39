"""Files that appear whole or not at all."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from typing import BinaryIO

from kinematics.errors import FileError

__all__ = ["check_different", "replacing", "replacing_all"]


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A file to write to, which takes its place at ``path`` once all is written.

    What is not a regular file, such as a pipe or a device, is written to as it is. A file
    that is replaced hands on its mode.

    Raises:
        FileError: it cannot be written; what stood there before is left as it was.
    """
    target = os.path.realpath(path)
    if _is_stream(target):
        try:
            with open(path, "wb") as file:
                yield file
        except OSError as error:
            raise _unwritable(path, error) from None
        return
    temporary = os.path.join(os.path.dirname(target), f".{os.urandom(16).hex()}.tmp")
    try:
        with open(temporary, "xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        with suppress(FileNotFoundError):
            os.chmod(temporary, stat.S_IMODE(os.stat(target).st_mode))
        os.replace(temporary, target)
    except OSError as error:
        with suppress(OSError):
            os.unlink(temporary)
        raise _unwritable(path, error) from None
    except BaseException:
        with suppress(FileNotFoundError):
            os.unlink(temporary)
        raise


def replacing_all(contents: Iterable[tuple[str, bytes]]) -> None:
    """Write several files, of which all appear or none; see `replacing`.

    Args:
        contents: path of each file, and what it is to hold.

    Raises:
        FileError: one cannot be written.
    """
    with ExitStack() as all_or_none:
        for path, content in contents:
            all_or_none.enter_context(replacing(path)).write(content)


def check_different(linkage: str | None, page: str | None) -> None:
    """Refuse one path for both the linkage and the page that a command writes.

    Raises:
        FileError: both are given, and are one file.
    """
    if linkage is None or page is None:
        return
    if os.path.realpath(linkage) == os.path.realpath(page):
        problem, remedy = "is to hold both the linkage and the page", "give each its own file"
        raise FileError(linkage, "", problem, remedy)


def _unwritable(path: str | os.PathLike[str], error: OSError) -> FileError:
    from kinematics.reader.markup import shown

    reason = error.strerror or type(error).__name__
    return FileError(
        shown(os.fsdecode(path), 1000), "", f"cannot be written ({reason})",
        "give a path in a folder that can be written to",
    )  # fmt: skip


def _is_stream(target: str) -> bool:
    """Whether a path is a pipe or a device, or what this process prints to."""
    try:
        found = os.stat(target)
    except OSError:
        return False
    if not (stat.S_ISREG(found.st_mode) or stat.S_ISDIR(found.st_mode)):
        return True
    for number in (1, 2):
        with suppress(OSError):
            if os.path.samestat(found, os.fstat(number)):
                return True
    return False
