"""When kernels are compiled: at once, beside a command, or never.

A command on a small linkage is answered sooner by kernels that Python runs as they are than
Numba loads, and the first command on a machine must not wait for a compiler. A command
begins uncompiled. Once its kernels have run as long as it takes to load compiled ones, it
goes on with these; where they are not there yet, one process per user compiles them beside
it, at low priority, for the rest of this command and for later ones. Sessions of Python
compile at once. ``BALANCE_COMPILE=now|background|never`` overrides both.
"""

from __future__ import annotations

import logging
import os
import subprocess
import sys
import traceback
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path
from time import monotonic
from typing import NamedTuple

from kinematics.errors import SettingError

__all__ = [
    "account",
    "begin_command",
    "cache_folder",
    "compile",
    "compile_beside",
    "fingerprint",
    "mode",
    "name_of",
    "ready",
    "register",
]

logger = logging.getLogger(__name__)

VARIABLE = "BALANCE_COMPILE"
MODES = ("now", "background", "never")
# Seconds of uncompiled kernels after which it is worth loading compiled ones: Numba takes
# 0.3 s to import, and thirty kernels 0.4 s to load (`python -m benchmarks start_up`).
WORTH = 0.5
# Seconds between two looks at whether another process has compiled the kernels.
PAUSE = 0.2
# The file that tells which kernels are there, the word for all, and how many versions of the
# sources, of Numba or of the processor it remembers.
READY, ALL, KEPT = "kernels.ready", "all", 7
BESIDE = (
    "kernels are compiled in the background for later runs; this one does not wait "
    f"({VARIABLE}={'|'.join(MODES)})"
)
NO_FOLDER = (
    "no folder to cache compiled kernels in: they are not compiled; set NUMBA_CACHE_DIR to a "
    "folder that can be written to"
)


class _WarmUp(NamedTuple):
    """What runs every kernel: a module, as `python -m` takes it, and its stages."""

    module: str
    stages: Callable[[], Iterator[None]]


class _Choice:
    """What was chosen for this process."""

    default = "now"
    warm_up: _WarmUp | None = None


def begin_command() -> None:
    """Say that this process is one command, before any kernel is imported.

    Raises:
        SettingError: the environment asks for something unknown.
    """
    _Choice.default = "background"
    mode()


def mode() -> str:
    """When this process compiles: ``"now"``, ``"background"`` or ``"never"``.

    Raises:
        SettingError: the environment asks for something else.
    """
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return "never"
    chosen = os.environ.get(VARIABLE) or _Choice.default
    if chosen not in MODES:
        raise SettingError(f"{VARIABLE}={chosen!r}: choose from {', '.join(MODES)}")
    return chosen


def register(module: str, stages: Callable[[], Iterator[None]]) -> None:
    """Name what runs all kernels of a package and of those below it, stage by stage.

    Args:
        module: what `python -m` runs to call `compile_beside`.
        stages: yields after each stage, when its kernels have been compiled.
    """
    _Choice.warm_up = _WarmUp(module, stages)


def compile() -> None:
    """Compile all kernels of the packages that are imported, and cache them on disk.

    It takes a while once per machine, user and version, and next to nothing after that.
    Without it, a session of Python compiles each kernel when it is first called. Where
    kernels are never compiled (``BALANCE_COMPILE=never``), nothing happens.
    """
    if mode() == "never" or _Choice.warm_up is None:
        return
    from kinematics.compiler import compiled_kernels

    account.compile_all()
    for _ in _Choice.warm_up.stages():
        _note(compiled_kernels())
    _note([*compiled_kernels(), ALL])


class _Account:
    """How long kernels have run uncompiled in this process, and which ones still do."""

    def __init__(self) -> None:
        """Nothing has run."""
        self._compiled: frozenset[str] = frozenset()
        self._seconds = 0.0
        self._next = 0.0
        self._asked = False

    def runs_compiled(self, kernel: str) -> bool:
        """Whether a kernel is to be called compiled."""
        return kernel in self._compiled or ALL in self._compiled

    def compile_all(self) -> None:
        """Call all kernels compiled from now on."""
        self._compiled = frozenset([ALL])

    def add(self, seconds: float) -> None:
        """Note that a kernel has run so long; change to compiled ones when it is time."""
        self._seconds += seconds
        if self._seconds < WORTH or monotonic() < self._next or mode() != "background":
            return
        self._compiled = ready()
        if ALL not in self._compiled and not self._asked:
            self._asked = True
            _start_beside()
        self._next = monotonic() + PAUSE


account = _Account()


def name_of(function: Callable[..., object]) -> str:
    """Name of a kernel, the same in every process; it has no blanks."""
    values = [cell.cell_contents for cell in function.__closure__ or ()]
    made_for = ",".join(str(value) for value in values if isinstance(value, int))
    return f"{function.__module__}.{function.__qualname__}({made_for})"


def fingerprint(package: Path) -> str:
    """Hash of all files with kernels in a package and in that of this file.

    Contents are hashed: files that a package manager installs may all bear one date.
    """
    return _fingerprint(package)


@cache
def _fingerprint(package: Path) -> str:
    digest = sha256()
    here = Path(__file__)
    files = {*package.rglob("*.py"), *here.parent.rglob("*.py")}
    for file in sorted(file for file in files if file.is_file()):
        text = file.read_bytes()
        if b"kinematics.kernels" in text:
            digest.update(b"%d %s" % (len(text), file.name.encode()))
            digest.update(text)
    return digest.hexdigest()


@cache
def cache_folder() -> Path | None:
    """The folder of what processes tell each other of the cache, or None if there is none.

    It is that of the cache itself: the one that NUMBA_CACHE_DIR names, else one beside this
    file, else one of the user.
    """
    named = os.environ.get("NUMBA_CACHE_DIR")
    user = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or "~/.cache"
    beside = Path(__file__).parent / "__pycache__"
    for folder in [Path(named)] if named else [beside, Path(user).expanduser() / "screwbalance"]:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(folder, os.W_OK):
            return folder
    return None


@cache
def _key() -> str:
    """What compiled kernels depend on: sources, versions, the processor."""
    from llvmlite import binding

    assert _Choice.warm_up is not None
    package = Path(str(sys.modules[_Choice.warm_up.module.split(".")[0]].__file__)).parent
    parts = (
        fingerprint(package), version("numba"), sys.version, binding.get_host_cpu_name(),
        binding.get_host_cpu_features().flatten(),
    )  # fmt: skip
    return sha256("\n".join(parts).encode()).hexdigest()


def ready() -> frozenset[str]:
    """Names of the kernels that have been compiled for this processor and these sources."""
    folder = cache_folder()
    if folder is None or not (folder / READY).exists():
        return frozenset()
    try:
        text = (folder / READY).read_text(encoding="utf-8")
    except (OSError, ValueError):
        return frozenset()
    key = _key()
    found = (line.split() for line in text.splitlines() if line.startswith(key))
    return frozenset(name for words in found for name in words[1:])


def _note(kernels: Iterable[str]) -> None:
    """Tell other processes which kernels have been compiled."""
    folder = cache_folder()
    if folder is None or ALL in ready():
        return
    file, key = folder / READY, _key()
    new = file.with_suffix(f".{os.getpid()}")
    try:
        old = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
        kept = [line for line in old if not line.startswith(key)][-KEPT:]
        new.write_text("\n".join([*kept, " ".join([key, *kernels]), ""]), encoding="utf-8")
        new.replace(file)
    except (OSError, ValueError) as error:
        logger.debug("%s: %s", file, error)


def _start_beside() -> None:
    """Start the process that compiles, unless there is one or no place for what it makes."""
    from filelock import FileLock, Timeout

    folder = cache_folder()
    if folder is None or _Choice.warm_up is None:
        logger.warning(NO_FOLDER)
        return
    logger.warning(BESIDE)
    try:
        with FileLock(folder / "kernels.lock", timeout=0):
            pass
    except (Timeout, OSError):
        return
    path = os.pathsep.join([str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")])
    own = {"PYTHONPATH": path, VARIABLE: "now", "OPENBLAS_NUM_THREADS": "1"}
    subprocess.Popen(
        [sys.executable, "-P", "-m", _Choice.warm_up.module], cwd=folder,
        env=os.environ | own, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL, start_new_session=True,
        creationflags=getattr(subprocess, "IDLE_PRIORITY_CLASS", 0),
    ).returncode = 0  # nobody waits for it  # fmt: skip


def compile_beside() -> int:
    """Compile all kernels in a process of its own, if no other does; returns its exit code.

    The lock goes with the process, however it ends. A failure is told in ``kernels.log``,
    and the next command tries again.
    """
    from filelock import FileLock, Timeout

    lower = getattr(os, "nice", None)
    if lower is not None:
        lower(19)
    folder = cache_folder()
    if folder is None:
        return 1
    try:
        with FileLock(folder / "kernels.lock", timeout=0):
            if ALL not in ready():
                compile()
    except Timeout:
        return 0
    except Exception:
        (folder / "kernels.log").write_text(traceback.format_exc(), encoding="utf-8")
        return 1
    return 0
