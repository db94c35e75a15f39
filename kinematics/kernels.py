"""How kernels are compiled: once per machine, cached on disk, announced the first time.

A kernel may use functions and constants of files that hold kernels, and of no others.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from contextlib import suppress
from functools import cache, partial, wraps
from hashlib import sha256
from pathlib import Path
from threading import local
from typing import Any

import numba
import numpy as np
from numba.core import event
from numba.core.types.misc import unliteral

try:
    from numba.core.caching import FunctionCache, IndexDataCacheFile
except ImportError:
    FunctionCache = IndexDataCacheFile = object

__all__ = ["kernel"]

logger = logging.getLogger(__name__)


def kernel(
    function: Callable[..., Any] | None = None, *, inline: bool = False, borrows: bool = False
) -> Any:
    """Compile ``function`` at its first call, or load it from the disk cache.

    A kernel to be put in line costs no call, which for arrays takes as long as dozens of
    products. A kernel that borrows makes no arrays and returns none (those that it calls may
    make some), and so need not count who uses those it is given, which takes as long. Sums
    may be reordered and contracted, so that loops vectorise; infinities and NaNs keep their
    meaning. Other threads run meanwhile. Where no folder can be written to, nothing is
    cached.
    """
    if function is None:
        return partial(kernel, inline=inline, borrows=borrows)
    options = {"error_model": "numpy", "fastmath": {"reassoc", "contract", "nsz"}}
    compiled = numba.njit(nogil=True, forceinline=inline, _nrt=not borrows, **options)(function)
    if compiled is function:  # NUMBA_DISABLE_JIT is set
        return _interpreted(function)
    _for_any_number(compiled)
    try:
        _keep(compiled, function)
    except RuntimeError:
        _events.cannot_cache()
    _events.modules.add(function.__module__)
    return compiled


class _Within(local):
    """Whether a kernel is running in this thread, without a compiler."""

    kernel = False


_within = _Within()


def _interpreted(function: Callable[..., Any]) -> Callable[..., Any]:
    """A kernel that runs without a compiler, with the arguments and results of a compiled one.

    It returns Python numbers instead of NumPy scalars, and division by zero gives an infinity
    or a NaN without a warning.
    """

    @wraps(function)
    def run(*args: Any) -> Any:
        if _within.kernel:
            return function(*args)
        _within.kernel = True
        try:
            with np.errstate(all="ignore"):
                numbers = (np.float64(x) if type(x) is float else x for x in args)
                return _unboxed(function(*numbers))
        finally:
            _within.kernel = False

    return run


def _unboxed(found: Any) -> Any:
    """The same with numbers of Python in the place of scalars of NumPy, in tuples too."""
    if isinstance(found, np.generic):
        return found.item()
    if isinstance(found, tuple):
        items = map(_unboxed, found)
        return type(found)(*items) if hasattr(found, "_fields") else tuple(items)
    return found


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


@cache
def _fingerprint(package: Path) -> str:
    """Hash of all files with kernels in a package and in that of this file.

    Contents are hashed: files that a package manager installs may all bear one date.
    """
    digest = sha256()
    here = Path(__file__)
    files = {*package.rglob("*.py"), *here.parent.rglob("*.py")}
    for file in sorted(file for file in files if file.is_file()):
        text = file.read_bytes()
        if file == here or b"kinematics.kernels" in text:
            digest.update(b"%d %s" % (len(text), file.name.encode()))
            digest.update(text)
    return digest.hexdigest()


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
        stamp = _fingerprint(parents[max(0, function.__module__.count(".") - 1)])
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
    """Says once per process that kernels are being compiled, or cannot be cached."""

    def __init__(self) -> None:
        """Nothing said yet, and no kernel known."""
        self.modules: set[str] = set()
        self._told: set[str] = set()

    def on_start(self, event: Any) -> None:
        """Called when Numba starts to compile a function (not when it loads one)."""
        if event.data["dispatcher"].py_func.__module__ in self.modules and not self._told:
            self._tell("compiling kernels (the first time only; they are cached on disk)")

    def on_end(self, event: Any) -> None:
        """Called when Numba has compiled a function."""

    def cannot_cache(self) -> None:
        """Called when there is no folder for the disk cache, or no room in it."""
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
