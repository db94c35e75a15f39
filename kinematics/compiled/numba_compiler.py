"""Numba compiles kernels once per machine, cached on disk, for `kinematics.compiled.jit`."""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
from numba.core import event
from numba.core.types import Dispatcher
from numba.core.types.misc import unliteral

import kinematics.compiled.simd_types  # noqa: F401  (Numba learns of lanes)
from kinematics.compiled.cache_contents import fingerprint, name_of

try:
    from numba.core.caching import FunctionCache, IndexDataCacheFile
except ImportError:
    FunctionCache = IndexDataCacheFile = object

if TYPE_CHECKING:
    from rich.progress import Progress

__all__ = ["compile_kernel", "compiled_kernels", "type_of"]

logger = logging.getLogger(__name__)

FIRST = "compiling kernels (the first time only; they are cached on disk)"


def compile_kernel(function: Callable[..., Any], inline: bool, borrows: bool) -> Any:
    """A function that Numba compiles at its first call, or loads from the disk cache.

    Sums may be reordered and contracted, so that loops vectorise; infinities and NaNs keep
    their meaning. Other threads run meanwhile. Where no folder can be written to, nothing is
    cached.

    Args:
        function: a function of numbers and arrays.
        inline: whether its callers contain its code.
        borrows: whether it makes no arrays and returns none.
    """
    options = {"error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz"}}
    compiled = numba.njit(nogil=True, forceinline=inline, _nrt=not borrows, **options)(function)
    _for_any_number(compiled)
    try:
        _keep(compiled, function)
    except RuntimeError:
        _events.cannot_cache()
    _events.kernels[function] = compiled
    return compiled


def compiled_kernels() -> list[str]:
    """Names of the kernels that this process has compiled or loaded."""
    return [name_of(k.py_func) for k in _events.kernels.values() if k.signatures]


def type_of(compiled: Any) -> Any:
    """Numba's type of a compiled kernel, for the kernels that call it."""
    return Dispatcher(compiled)


def _for_any_number(compiled: Any) -> None:
    """Compile a kernel once for all numbers of one type.

    Numba would specialise it for every literal number with which another kernel calls it.
    """
    typed = compiled.get_call_template
    compiled.get_call_template = lambda args, kws: typed(
        [unliteral(arg) for arg in args], {name: unliteral(arg) for name, arg in kws.items()}
    )


def _keep(compiled: Any, function: Callable[..., Any]) -> None:
    """Cache on disk; RuntimeError if there is no folder for it.

    The cache is a private part of Numba: where it looks different, Numba's own is used.
    """
    with suppress(AttributeError, TypeError):
        if hasattr(compiled, "_cache"):
            compiled._cache = _Cache(function)
            return
    compiled.enable_caching()


class _Files(IndexDataCacheFile):
    """One file per signature of a kernel, which says of what it is.

    Numba numbers them as they come, and has an index of the numbers: two processes that
    compile at once may give one number to two signatures, and call one as the other.
    """

    def save(self, key: Any, data: Any) -> None:
        """Store what was compiled for a signature and a processor."""
        self._save_data(self._name(key), (self._source_stamp, key, data))

    def load(self, key: Any) -> Any:
        """What was stored of these sources for a signature and a processor, or None."""
        try:
            stamp, stored, data = self._load_data(self._name(key))
        except FileNotFoundError:
            return None
        return data if (stamp, stored) == (self._source_stamp, key) else None

    def _name(self, key: Any) -> str:
        digest = sha256(f"{numba.__version__} {key}".encode()).digest()
        return self._data_name(int.from_bytes(digest[:8], "big"))


class _Cache(FunctionCache):
    """Numba's disk cache, stale as soon as any file with kernels has changed.

    A kernel is compiled together with the kernels that it calls, but Numba looks only at
    the file that the kernel itself is in.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        """Find the folder of the cache; RuntimeError if there is none."""
        super().__init__(function)
        parents = Path(function.__code__.co_filename).parents
        stamp = fingerprint(parents[max(0, function.__module__.count(".") - 1)])
        self._cache_file = _Files(self._cache_path, self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel, or None if it is not there or cannot be read."""
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # a file cut short by a crash or a full disk may raise anything
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store a compiled kernel if there is room."""
        try:
            super().save_overload(sig, data)
        except OSError:
            _events.cannot_cache()


class _Events(event.Listener):
    """Says that kernels are being compiled, with a bar on a terminal, or cannot be cached."""

    def __init__(self) -> None:
        """Nothing said yet, and no kernel known."""
        self.kernels: dict[Callable[..., Any], Any] = {}
        self._done: set[Callable[..., Any]] = set()
        self._told: set[str] = set()
        self._depth = 0
        self._bar: Progress | None = None

    def on_start(self, event: Any) -> None:
        """Called when Numba starts to compile a function (not when it loads one)."""
        if event.data["dispatcher"].py_func not in self.kernels:
            return
        if self._depth == 0:
            self._open()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """Called when Numba has compiled a function."""
        function = event.data["dispatcher"].py_func
        if function not in self.kernels:
            return
        self._done.add(function)
        self._depth -= 1
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], completed=len(self._done))
        if self._depth == 0 and self._bar is not None:
            self._bar.stop()

    def cannot_cache(self) -> None:
        """Called when there is no folder for the disk cache, or no room in it."""
        self._tell(
            "no folder to cache compiled kernels in: they are compiled anew in every process; "
            "set NUMBA_CACHE_DIR to a folder that can be written to"
        )

    def _open(self) -> None:
        """Show the bar on a terminal; elsewhere, say once what is going on."""
        if self._bar is None and not self._told:
            self._bar = _bar()
            if self._bar is None:
                self._tell(FIRST)
        if self._bar is None:
            return
        task = self._bar.task_ids[0]
        self._bar.update(task, completed=len(self._done), total=len(self.kernels))
        self._bar.start()

    def _tell(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            logger.warning(text)


def _bar() -> Progress | None:
    """A bar that counts kernels, on standard error, or None if that is no terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

    console = Console(stderr=True)
    if not (console.is_terminal or console.is_jupyter):
        return None
    columns = "{task.description}", BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    bar = Progress(*columns, console=console, transient=True)
    bar.add_task("compiling kernels")
    return bar


_events = _Events()
event.register("numba:compile", _events)
