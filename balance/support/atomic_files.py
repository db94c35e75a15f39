"""Atomic file writes: a file is replaced as a whole or not at all."""

from __future__ import annotations

import os
import stat
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from typing import BinaryIO

from kinematics.errors import FileError, UsageError


@contextmanager
def open_atomic(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a file for an atomic write: it replaces ``path`` after everything is written.

    A path that is no regular file, such as a pipe or a device, is written to directly. A file
    that replaces another one keeps its mode.

    Raises:
        FileError: the file cannot be written; an existing one is unchanged.
    """
    target = os.path.realpath(path)
    if is_stream(target):
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


def write_all_atomic(contents: Iterable[tuple[str, bytes]]) -> None:
    """Write several files, all of them or none; see `open_atomic`.

    Args:
        contents: path and contents of each file.

    Raises:
        FileError: one of them cannot be written.
    """
    with ExitStack() as all_or_none:
        for path, content in contents:
            all_or_none.enter_context(open_atomic(path)).write(content)


def check_outputs(
    outputs: Mapping[str, str], inputs: Iterable[str | os.PathLike[str]], overwrite: bool
) -> None:
    """Refuse outputs that are one file, or that would replace an input.

    Files are compared, not paths: symbolic and hard links to one file are that file.

    Args:
        outputs: paths by the option that gives them.
        inputs: paths of the files that are read; those that do not exist are ignored.
        overwrite: whether inputs may be replaced.

    Raises:
        UsageError: two outputs are one file; or one is an input, without ``overwrite``.
    """
    from kinematics.error_text import clean

    places: dict[str, str] = {}
    for option, path in outputs.items():
        place = os.path.realpath(path)
        if place in places:
            text = f"{clean(path, 1000)}: both {places[place]} and {option} are to write it"
            raise UsageError(f"{text}; give each its own file")
        places[place] = option
    read = [] if overwrite else [path for path in inputs if os.path.isfile(path)]
    for option, path in outputs.items():
        if os.path.isfile(path) and any(os.path.samefile(path, source) for source in read):
            raise UsageError(
                f"{clean(path, 1000)}: {option} would replace a file that is read; give "
                "another path, or --overwrite"
            )


def _unwritable(path: str | os.PathLike[str], error: OSError) -> FileError:
    from kinematics.error_text import clean

    reason = error.strerror or type(error).__name__
    return FileError(
        clean(os.fsdecode(path), 1000),
        "",
        f"cannot be written ({reason})",
        "give a path in a folder that can be written to",
    )


def is_stream(target: str) -> bool:
    """Whether a path is a pipe or a device, or a standard stream of this process."""
    try:
        status = os.stat(target)
    except OSError:
        return False
    if not (stat.S_ISREG(status.st_mode) or stat.S_ISDIR(status.st_mode)):
        return True
    for number in (1, 2):
        with suppress(OSError):
            if os.path.samestat(status, os.fstat(number)):
                return True
    return False
