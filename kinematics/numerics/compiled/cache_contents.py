"""The disk cache of compiled kernels: its folders, and the kernels in them.

A folder holds the kernels compiled from one state of the sources, for one version of Numba and
one processor. Its name is the hash of these, so that nothing in it is ever stale.
"""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path

logger = logging.getLogger(__name__)

# The file in a folder that lists the kernels in it.
READY = "kernels.ready"
# The entry of that file for all kernels.
ALL = "all"
# How many folders of other sources, versions of Numba or processors are kept.
KEPT = 3


def kernel_name(function: Callable[..., object]) -> str:
    """Compose the name of a kernel, the same in every process and without blanks.

    Raises:
        TypeError: the kernel is made for a value that is not an integer. Numba finds a kernel
            in its cache by these values, pickled: a kernel, say, is pickled with a name that
            differs between processes, and each process would compile anew.
    """
    values = [cell.cell_contents for cell in function.__closure__ or ()]
    made_for = ",".join(str(value) for value in values)
    name = f"{function.__module__}.{function.__qualname__}({made_for})"
    if not all(isinstance(value, int) for value in values):
        raise TypeError(f"kernel {name}: no process finds it in the cache; close over integers")
    return name


def package_of(function: Callable[..., object]) -> Path:
    """Find the folder of the top-level package that contains a function."""
    parents = Path(function.__code__.co_filename).parents
    return parents[max(0, function.__module__.count(".") - 1)]


def _hash_sources(package: Path) -> str:
    """Hash all files with kernels in a package and in `kinematics`.

    Numba checks only the file that contains a kernel, but compiles it together with the kernels
    and constants of other files. Contents are hashed, because a package manager may give all
    files one date.
    """
    from hashlib import sha256

    digest = sha256()
    files = {*package.rglob("*.py"), *Path(__file__).parents[2].rglob("*.py")}
    for file in sorted(file for file in files if file.is_file()):
        text = file.read_bytes()
        if b"kinematics.numerics.compiled.jit" in text:
            digest.update(b"%d %s" % (len(text), file.name.encode()))
            digest.update(text)
    return digest.hexdigest()


@cache
def cache_folder() -> Path | None:
    """Find the folder that contains those of the kernels; None if none can be written to.

    NUMBA_CACHE_DIR names it; without that, it is beside this package, or else in the user's
    cache.
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    user = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or "~/.cache"
    beside = Path(__file__).parents[2] / "__pycache__"
    user_cache = Path(user).expanduser() / "screwbalance"
    for folder in [Path(named)] if named else [beside, user_cache]:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return None


@cache
def _hash(package: Path) -> str:
    """Hash all that compiled kernels depend on: sources, versions, the processor."""
    from hashlib import sha256
    from importlib.metadata import version

    from llvmlite import binding

    parts = (
        _hash_sources(package),
        version("numba"),
        sys.version,
        os.environ.get("NUMBA_CPU_NAME", binding.get_host_cpu_name()),
        os.environ.get("NUMBA_CPU_FEATURES", binding.get_host_cpu_features().flatten()),
    )
    return sha256("\n".join(parts).encode()).hexdigest()[:16]


@cache
def kernel_folder(package: Path) -> Path | None:
    """Find or make the folder of the kernels of a package; None if there is no cache folder.

    If it is made, all but the newest folders of other sources are removed. A process that still
    uses a removed folder compiles again what it misses.
    """
    above = cache_folder()
    if above is None:
        return None
    folder = above / f"{package.name}-{_hash(package)}"
    try:
        folder.mkdir()
    except FileExistsError:
        return folder
    except OSError:
        return None
    _remove_old(folder)
    return folder


def _remove_old(new: Path) -> None:
    """Remove the folders of other states of a package, except the newest ``KEPT``."""
    import shutil

    pattern = f"{new.name.rpartition('-')[0]}-{'[0-9a-f]' * 16}"
    others = [folder for folder in new.parent.glob(pattern) if folder != new]
    with suppress(OSError):  # another process removes them too
        others.sort(key=lambda folder: folder.stat().st_mtime)
        for folder in others[:-KEPT]:
            shutil.rmtree(folder, ignore_errors=True)


def ready_kernels(package: Path) -> frozenset[str]:
    """Read the names of the kernels that are compiled, of a package and of those below it."""
    folder = kernel_folder(package)
    try:
        text = (folder / READY).read_text(encoding="utf-8") if folder is not None else ""
    except (OSError, ValueError):
        return frozenset()
    return frozenset(text.split())


def note_kernels(package: Path, kernels: Iterable[str]) -> None:
    """Write the list of compiled kernels, for other processes to read.

    Args:
        package: folder of the package.
        kernels: names as from `kernel_name`, or `ALL`.
    """
    folder = kernel_folder(package)
    if folder is None or ALL in ready_kernels(package):
        return
    new = folder / f"{READY}.{os.getpid()}"
    try:
        new.write_text("\n".join([*kernels, ""]), encoding="utf-8")
        new.replace(folder / READY)
    except (OSError, ValueError) as error:
        logger.debug("%s: %s", folder, error)
