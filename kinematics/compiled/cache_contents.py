"""What the disk cache of `kinematics.compiled.jit` holds, told by one process to the others."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path

__all__ = ["ALL", "cache_folder", "fingerprint", "name_of", "note", "ready"]

logger = logging.getLogger(__name__)

# The file that tells which kernels are there, the word for all, and how many versions of the
# sources, of Numba or of the processor it remembers.
READY, ALL, KEPT = "kernels.ready", "all", 7


def name_of(function: Callable[..., object]) -> str:
    """Name of a kernel, the same in every process; it has no blanks."""
    values = [cell.cell_contents for cell in function.__closure__ or ()]
    made_for = ",".join(str(value) for value in values if isinstance(value, int))
    return f"{function.__module__}.{function.__qualname__}({made_for})"


@cache
def fingerprint(package: Path) -> str:
    """Hash of all files with kernels in a package and in `kinematics`.

    Contents are hashed: files that a package manager installs may all bear one date.
    """
    from hashlib import sha256

    digest = sha256()
    files = {*package.rglob("*.py"), *Path(__file__).parents[2].rglob("*.py")}
    for file in sorted(file for file in files if file.is_file()):
        text = file.read_bytes()
        if b"kinematics.compiled.jit" in text:
            digest.update(b"%d %s" % (len(text), file.name.encode()))
            digest.update(text)
    return digest.hexdigest()


@cache
def cache_folder() -> Path | None:
    """The folder of what processes tell each other of the cache, or None if there is none.

    It is that of the cache itself: the one that NUMBA_CACHE_DIR names, else one in the folder
    of `kinematics`, else one of the user.
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    user = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or "~/.cache"
    beside = Path(__file__).parents[1] / "__pycache__"
    own = Path(user).expanduser() / "screwbalance"
    for folder in [Path(named)] if named else [beside, own]:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return None


@cache
def _key(package: Path) -> str:
    """What compiled kernels depend on: sources, versions, the processor."""
    from hashlib import sha256
    from importlib.metadata import version

    from llvmlite import binding

    parts = (
        fingerprint(package), version("numba"), sys.version, binding.get_host_cpu_name(),
        binding.get_host_cpu_features().flatten(),
    )  # fmt: skip
    return sha256("\n".join(parts).encode()).hexdigest()


def ready(package: Path) -> frozenset[str]:
    """Names of the kernels of a package, and below, that are compiled for this processor."""
    folder = cache_folder()
    if folder is None or not (folder / READY).exists():
        return frozenset()
    try:
        text = (folder / READY).read_text(encoding="utf-8")
    except (OSError, ValueError):
        return frozenset()
    key = _key(package)
    found = (line.split() for line in text.splitlines() if line.startswith(key))
    return frozenset(name for words in found for name in words[1:])


def note(package: Path, kernels: Iterable[str]) -> None:
    """Tell other processes which kernels have been compiled."""
    folder = cache_folder()
    if folder is None or ALL in ready(package):
        return
    file, key = folder / READY, _key(package)
    new = file.with_suffix(f".{os.getpid()}")
    try:
        old = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
        kept = [line for line in old if not line.startswith(key)][-KEPT:]
        new.write_text("\n".join([*kept, " ".join([key, *kernels]), ""]), encoding="utf-8")
        new.replace(file)
    except (OSError, ValueError) as error:
        logger.debug("%s: %s", file, error)
