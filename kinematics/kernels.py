"""How kernels are compiled: once per machine, cached on disk, announced the first time."""

from __future__ import annotations

import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import event
from numba.core.caching import FunctionCache

__all__ = ["kernel"]

logger = logging.getLogger(__name__)


def kernel(function: Callable[..., Any]) -> Any:
    """Compile ``function`` at its first call, or load it from the disk cache.

    Sums may be reordered and contracted, so that loops vectorise; infinities and NaNs keep
    their meaning. Where no folder can be written to, nothing is cached.
    """
    fastmath = {"reassoc", "contract", "nsz"}
    compiled = numba.njit(error_model="numpy", fastmath=fastmath)(function)
    try:
        compiled._cache = _Cache(function)
    except RuntimeError:
        _events.cannot_cache()
    _events.modules.add(function.__module__)
    return compiled


class _Cache(FunctionCache):
    """Numba's disk cache, stale as soon as any file of the package has changed.

    A kernel is compiled together with the kernels that it calls, but Numba looks only at
    the file that the kernel itself is in.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        """Find the folder of the cache; RuntimeError if there is none."""
        super().__init__(function)
        files = sorted(Path(function.__code__.co_filename).parent.glob("*.py"))
        states = [file.stat() for file in files]
        self._source_stamp = tuple((state.st_mtime_ns, state.st_size) for state in states)
        self._cache_file._source_stamp = self._source_stamp


class _Events(event.Listener):
    """Says once per process that kernels are being compiled, or cannot be cached."""

    def __init__(self) -> None:
        """Nothing said yet, and no kernel known."""
        self.modules: set[str] = set()
        self._told: set[str] = set()

    def on_start(self, event: Any) -> None:
        """Called when Numba starts to compile a function (not when it loads one)."""
        if event.data["dispatcher"].py_func.__module__ in self.modules:
            self._tell("compiling kernels (the first time only; they are cached on disk)")

    def on_end(self, event: Any) -> None:
        """Called when Numba has compiled a function."""

    def cannot_cache(self) -> None:
        """Called when there is no folder for the disk cache."""
        self._tell(
            "no folder to cache compiled kernels in: they are compiled anew in every process; "
            "set NUMBA_CACHE_DIR to a folder that can be written to"
        )

    def _tell(self, text: str) -> None:
        if text not in self._told:
            self._told.add(text)
            logger.warning(text)


_events = _Events()
event.register("numba:compile", _events)
