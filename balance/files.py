"""Files that appear whole or not at all."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO
from uuid import uuid4

from kinematics.errors import FileError
from kinematics.reader.markup import shown

__all__ = ["replacing"]


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A file to write to, which takes its place at ``path`` once all is written.

    Raises:
        FileError: it cannot be written; what stood there before is left as it was.
    """
    target = Path(os.path.realpath(path))
    temporary = target.with_name(f".{uuid4().hex}.tmp")
    try:
        with open(temporary, "xb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, target)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        reason = error.strerror or type(error).__name__
        raise FileError(
            shown(os.fsdecode(path), 1000), "", f"cannot be written ({reason})",
            "give a path in a folder that can be written to",
        ) from None  # fmt: skip
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
