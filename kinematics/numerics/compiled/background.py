"""Choose when kernels are compiled: at once, in the background of a command, or never.

For a small linkage, uncompiled kernels answer a command sooner than Numba loads compiled ones,
and the first command on a machine must not wait for a compiler. Therefore a command begins
uncompiled. Once its kernels have run as long as loading compiled ones takes, it loads these. If
they do not exist yet, one process per user compiles them in the background, at low priority,
for the rest of this command and for later ones. Sessions of Python compile at once.
``BALANCE_COMPILE=now|background|never`` overrides both.
"""

from __future__ import annotations

import gc
import logging
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import NamedTuple

from kinematics.errors import UsageError
from kinematics.numerics.compiled.cache_contents import (
    ALL,
    cache_folder,
    note_kernels,
    ready_kernels,
)

logger = logging.getLogger(__name__)

VARIABLE = "BALANCE_COMPILE"
MODES = ("now", "background", "never")
# Seconds of uncompiled kernels after which it is worth loading compiled ones: Numba takes
# 0.3 s to import, and thirty kernels 0.4 s to load (`python -m benchmarks start_up`).
WORTH = 0.5
# Seconds between two checks whether another process has compiled the kernels.
PAUSE = 0.2
# Niceness of the process that compiles: a third of the weight of a command. The lowest priority
# would starve where other processes keep all cores busy.
COMPILER_NICENESS = 5
# New objects, while kernels are compiled, after which Python looks for garbage.
NEW_OBJECTS = 200_000
# The process beside a command takes the lock before it imports anything heavy.
CHILD = (
    "import {}; from kinematics.numerics.compiled.background import compile_in_background; "
    "raise SystemExit(compile_in_background())"
)
STARTED = (
    "kernels are compiled in the background for later runs; this one does not wait "
    f"({VARIABLE}={'|'.join(MODES)})"
)
NO_FOLDER = (
    "no folder to cache compiled kernels in: they are not compiled; set NUMBA_CACHE_DIR to a "
    f"folder that can be written to, or {VARIABLE}=now to compile them in every process"
)


class _WarmUp(NamedTuple):
    """A run of every kernel: the module that registers it at its import, and its stages."""

    module: str
    stages: Callable[[], Iterator[None]]

    @property
    def package(self) -> Path:
        """The folder of the package."""
        return Path(str(sys.modules[self.module.split(".")[0]].__file__)).parent


class _ProcessChoice:
    """The choices made for this process."""

    default = "now"
    verb = ""
    warm_up: _WarmUp | None = None


def begin_command() -> None:
    """Compile kernels in the background from now on, unless the environment chooses otherwise.

    Call it before any kernel is imported, in a process that runs one command. The processes
    that this one starts read the choice from the environment.
    """
    os.environ[VARIABLE] = os.environ.get(VARIABLE) or "background"


def compile_mode() -> str:
    """Find when this process compiles: ``"now"``, ``"background"`` or ``"never"``.

    Raises:
        UsageError: ``BALANCE_COMPILE`` has another value.
    """
    if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
        return "never"
    chosen = os.environ.get(VARIABLE) or _ProcessChoice.default
    if chosen not in MODES:
        raise UsageError(f"{VARIABLE}={chosen!r}: choose from {', '.join(MODES)}")
    return chosen


def waiting_verb() -> str:
    """Return the verb of the command that this process compiles for; empty if for none."""
    return _ProcessChoice.verb


def register_warm_up(module: str, stages: Callable[[], Iterator[None]]) -> None:
    """Register the function that runs all kernels of a package and of those below it.

    Args:
        module: name of the module that calls this function at its import, which must be cheap.
        stages: yields after each stage, when its kernels have been compiled.
    """
    _ProcessChoice.warm_up = _WarmUp(module, stages)


def compile() -> None:
    """Compile all kernels of the packages that are imported, and cache them on disk.

    It takes about a minute once per machine, user and version, and seconds after that.
    Without it, a session of Python compiles each kernel at its first call. Where kernels are
    never compiled (``BALANCE_COMPILE=never``), it does nothing.

    Raises:
        UsageError: ``BALANCE_COMPILE`` has a value that does not exist.

    Example:
        >>> import kinematics
        >>> kinematics.compile()
    """
    if compile_mode() == "never" or _ProcessChoice.warm_up is None:
        return
    from kinematics.numerics.compiled.numba_compiler import compiled_kernels

    kernel_clock.compile_all()
    folder, package = cache_folder(), _ProcessChoice.warm_up.package
    with collect_garbage_seldom():
        for _ in _ProcessChoice.warm_up.stages():
            if folder is not None and not folder.exists():
                return  # another process has removed the cache
            note_kernels(package, compiled_kernels())
    note_kernels(package, [*compiled_kernels(), ALL])


@contextmanager
def collect_garbage_seldom() -> Iterator[None]:
    """Look for garbage less often while kernels are compiled or loaded.

    Numba makes and keeps so many objects that looking for garbage among them takes an eighth
    of the time of a compilation, and a twentieth of that of a command.
    """
    usual = gc.get_threshold()
    gc.set_threshold(NEW_OBJECTS, *usual[1:])
    try:
        yield
    finally:
        gc.set_threshold(*usual)


class _KernelClock:
    """The time that kernels have run uncompiled in this process, and which ones still do."""

    def __init__(self) -> None:
        """Start at 0 seconds, with all kernels uncompiled."""
        self._compiled: frozenset[str] = frozenset()
        self._seconds = 0.0
        self._next = 0.0
        self._asked = False

    def runs_compiled(self, kernel: str) -> bool:
        """Return whether a kernel is called compiled."""
        return kernel in self._compiled or ALL in self._compiled

    def compile_all(self) -> None:
        """Call all kernels compiled from now on."""
        self._compiled = frozenset([ALL])

    def foresee(self, seconds: float) -> None:
        """Change to compiled kernels before a run that would take long uncompiled.

        A process that starts others to compute calls it before, because they start none that
        compiles: each takes up the kernels that the process of this one compiles.
        """
        if seconds >= WORTH:
            self.add(seconds)

    def add(self, seconds: float) -> None:
        """Add the seconds of an uncompiled run; change to compiled kernels when it is time."""
        self._seconds += seconds
        if self._seconds < WORTH or monotonic() < self._next or compile_mode() != "background":
            return
        assert _ProcessChoice.warm_up is not None  # who imports a package registers it
        self._compiled = ready_kernels(_ProcessChoice.warm_up.package)
        if ALL not in self._compiled and not self._asked:
            self._asked = True
            _start_background()
        self._next = monotonic() + PAUSE


kernel_clock = _KernelClock()


def _start_background() -> None:
    """Start the process that compiles, unless one runs already or there is no cache folder.

    A process that another one has started to compute does nothing.
    """
    import subprocess
    from multiprocessing import parent_process

    from filelock import FileLock, Timeout

    if parent_process() is not None:
        return
    folder = cache_folder()
    if folder is None or _ProcessChoice.warm_up is None:
        logger.warning(NO_FOLDER)
        return
    logger.warning(STARTED)
    try:
        with FileLock(folder / "kernels.lock", timeout=0):
            pass
    except (Timeout, OSError, NotImplementedError):  # or a file system without locks
        return
    above = [str(Path(__file__).parents[3]), os.environ.get("PYTHONPATH")]
    variables = {"PYTHONPATH": os.pathsep.join(filter(None, above)), VARIABLE: "now"}
    try:
        subprocess.Popen(
            [
                *(sys.executable, "-P", "-c", CHILD.format(_ProcessChoice.warm_up.module)),
                *sys.argv[1:2],
            ],
            cwd=folder,
            env=os.environ | variables | {"OPENBLAS_NUM_THREADS": "1"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            # Interrupts of the command must not reach it. In a session of its own, Linux
            # might give it as much of the processor as the command.
            process_group=0 if os.name == "posix" else None,
            creationflags=getattr(subprocess, "IDLE_PRIORITY_CLASS", 0),
        ).returncode = 0  # no process waits for it
    except OSError as error:
        logger.debug("no process to compile kernels: %s", error)


def compile_in_background() -> int:
    """Compile all kernels in a process of its own, unless another does; return the exit code.

    The kernels that the command needs come first: its verb is the argument of the process. The
    lock ends with the process, however it ends. A failure is written to ``kernels.log``,
    and the next command tries again.
    """
    from filelock import FileLock, Timeout

    lower = getattr(os, "nice", None)
    if lower is not None:
        lower(COMPILER_NICENESS)
    _ProcessChoice.verb = next(iter(sys.argv[1:2]), "")
    folder = cache_folder()
    if folder is None or _ProcessChoice.warm_up is None:
        return 1
    try:
        with FileLock(folder / "kernels.lock", timeout=0):
            if ALL not in ready_kernels(_ProcessChoice.warm_up.package):
                compile()
    except Timeout:
        return 0
    except Exception:
        import traceback

        (folder / "kernels.log").write_text(traceback.format_exc(), encoding="utf-8")
        return 1
    return 0
