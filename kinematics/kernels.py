"""How kernels are compiled: once per machine, cached on disk, announced the first time."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import event

__all__ = ["kernel"]

F = TypeVar("F", bound=Callable[..., Any])
logger = logging.getLogger(__name__)


def kernel(function: F) -> F:
    """Compile ``function`` at its first call, or load it from the disk cache.

    Sums may be reordered and contracted, so that loops vectorise; infinities and NaNs keep
    their meaning.
    """
    compiled: F = numba.njit(
        cache=True, error_model="numpy", fastmath={"reassoc", "contract", "nsz"}
    )(function)
    _announcer.modules.add(function.__module__)
    return compiled


class _Announcer(event.Listener):
    """Says once per process that kernels are being compiled."""

    def __init__(self) -> None:
        self.modules: set[str] = set()
        self.told = False

    def on_start(self, event: Any) -> None:
        """Called when Numba starts to compile a function (not when it loads one)."""
        function = event.data["dispatcher"].py_func
        if not self.told and function.__module__ in self.modules:
            self.told = True
            logger.warning("compiling kernels (the first time only; they are cached on disk)")

    def on_end(self, event: Any) -> None:
        """Called when Numba has compiled a function."""


_announcer = _Announcer()
event.register("numba:compile", _announcer)
