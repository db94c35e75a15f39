"""Compile kernels with Numba once per machine and cache them on disk.

`kinematics.numerics.compiled.jit` imports this file when it first needs compiled kernels.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numba
from filelock import FileLock
from numba.core import event, ir
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.errors import NumbaTypeError
from numba.core.typed_passes import NopythonTypeInference
from numba.extending import typeof_impl

import kinematics.numerics.compiled.simd_types  # noqa: F401  (Numba learns of lanes)
from kinematics.numerics.compiled.cache_contents import kernel_folder, kernel_name, package_of

if TYPE_CHECKING:
    from rich.progress import Progress


logger = logging.getLogger(__name__)

# All private names of Numba that this project uses; no other file uses any.
# _cache: the disk cache of one function, whose reading and writing are guarded.
# _name: the name of a compiler pass in messages of Numba.
# _nrt: the option that turns the reference counting of arrays off.
# Private methods that a class replaces are named by its docstring.
PRIVATE = ("_cache", "_name", "_nrt")

FIRST = "compiling kernels (the first time only; they are cached on disk)"
# Seconds to wait for another process that saves a kernel.
PATIENCE = 10.0


def compile_kernel(function: Callable[..., Any], inline: bool, reference_counting: bool) -> Any:
    """Make a function that Numba compiles at its first call, or loads from the disk cache.

    Sums may be reordered and contracted, so that loops vectorise; infinities and NaNs keep
    their meaning. Other threads run meanwhile. Where no folder can be written to, nothing is
    cached.

    The code of a kernel contains that of all kernels that it calls, which LLVM optimises
    together. For these, a kernel is translated apart, without machine code of its own: LLVM
    would optimise it once more for each kernel above it.

    Args:
        function: a function of numbers and arrays.
        inline: whether its callers contain its code.
        reference_counting: whether arrays are counted; see
            `kinematics.numerics.compiled.jit.kernel`.

    Returns:
        The dispatcher of Numba.
    """
    decorate = partial(
        numba.njit,
        nogil=True,
        forceinline=inline,
        error_model="numpy",
        fastmath={"reassoc", "contract", "nsz"},
        no_cfunc_wrapper=True,  # entries for C, which nobody calls, take time to compile
        _nrt=reference_counting,  # a kernel would else take it from the kernel that calls it
    )
    compiled = decorate(pipeline_class=_Compiler)(function)
    inner = decorate(pipeline_class=_InnerCompiler, no_cpython_wrapper=True)
    _let_kernels_call_inner(compiled, inner)
    _cache_on_disk(compiled)
    _events.kernels[function] = compiled
    return compiled


def compiled_kernels() -> list[str]:
    """List the names of the kernels that this process has compiled or loaded."""
    return [kernel_name(k.py_func) for k in _events.kernels.values() if k.signatures]


def compile_inner_kernels() -> Iterator[None]:
    """Make machine code of public kernels that have run inside others, for calls by Python.

    Yields after each.
    """
    for compiled in list(_events.kernels.values()):
        inner = _events.inner_kernels.get(compiled.py_func)
        if inner is None or compiled.py_func.__name__.startswith("_"):
            continue
        for signature in set(inner.signatures).difference(compiled.signatures):
            compiled.compile(signature)
            yield


@cache
def let_kernels_call(kind: type) -> None:
    """Let compiled kernels call objects of a class by their attribute ``compiled``."""

    @typeof_impl.register(kind)
    def _(value: Any, context: Any) -> Any:
        return typeof_impl(value.compiled, context)


def _let_kernels_call_inner(compiled: Any, decorate: Callable[..., Any]) -> None:
    """Let kernels call a kernel without machine code, once for all numbers of one type.

    Numba would specialise it for every literal number with which another kernel calls it.

    Args:
        compiled: the dispatcher of calls by Python.
        decorate: makes that of calls by kernels.
    """
    plain = numba.types.unliteral

    def inner() -> Any:
        function = compiled.py_func
        if function not in _events.inner_kernels:
            _events.inner_kernels[function] = decorate(function)
        return _events.inner_kernels[function]

    compiled.get_call_template = lambda args, kws: inner().get_call_template(
        [plain(arg) for arg in args], {name: plain(arg) for name, arg in kws.items()}
    )
    compiled.get_overload = lambda signature: inner().get_overload(signature)


@register_pass(mutates_CFG=False, analysis_only=True)
class _RefuseArrays(FunctionPass):
    """Compiler pass: refuse kernels without reference counting that would misuse arrays.

    Numba would free an argument that such a kernel returns while it is in use, and never free
    an array that a callee returns.
    """

    _name = "refuse_arrays_without_reference_counting"

    def __init__(self) -> None:
        """Make a pass without state."""

    def run_pass(self, state: Any) -> bool:
        """Check the types that Numba has found; change nothing."""
        models, name = state.targetctx.data_model_manager, state.func_id.func_qualname
        if models[state.return_type].contains_nrt_meminfo():
            raise NumbaTypeError(
                f"kernel {name} returns {state.return_type}: a kernel with "
                "reference_counting=False must not return arrays; let it fill one of its "
                "arguments, or count references"
            )
        for call, signature in state.calltypes.items():
            if not isinstance(call, ir.Expr) or call.op != "call":
                continue
            callee = state.typemap[call.func.name]
            if isinstance(callee, numba.types.Dispatcher) and (
                models[signature.return_type].contains_nrt_meminfo()
            ):
                raise NumbaTypeError(
                    f"kernel {name} is given {signature.return_type} by "
                    f"{callee.dispatcher.py_func.__qualname__}: with reference_counting=False "
                    "it would never be freed"
                )
        return False


class _Compiler(CompilerBase):
    """Numba's compiler with a check of kernels without reference counting."""

    def define_pipelines(self) -> list[Any]:
        """Add the check to the passes of Numba, after type inference."""
        passes = DefaultPassBuilder.define_nopython_pipeline(self.state)
        self.add_passes(passes)
        passes.finalize()
        return [passes]

    def add_passes(self, passes: Any) -> None:
        """Add what differs from Numba."""
        if not self.state.flags.nrt:
            passes.add_pass_after(_RefuseArrays, NopythonTypeInference)


@register_pass(mutates_CFG=False, analysis_only=True)
class _WithoutMachineCode(FunctionPass):
    """Compiler pass: give a kernel that others contain a library without machine code."""

    _name = "library_without_machine_code"

    def __init__(self) -> None:
        """Make a pass without state."""

    def run_pass(self, state: Any) -> bool:
        """Make the library; change nothing else."""
        state.library = _InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        return False


class _InnerCompiler(_Compiler):
    """The compiler of kernels for those that call them."""

    def add_passes(self, passes: Any) -> None:
        """Add the pass that makes the library."""
        super().add_passes(passes)
        passes.add_pass_after(_WithoutMachineCode, NopythonTypeInference)


class _InnerLibrary(JITCodeLibrary):
    """A kernel and all that it calls, for kernels that contain it: neither optimised nor run.

    It replaces ``_optimize_final_module`` and ``_finalize_final_module`` of Numba, and reads
    ``_finalized``.
    """

    def get_pointer_to_function(self, name: str) -> int:
        """Return the address of a function; 0 because there is no machine code."""
        self._ensure_finalized()
        return 0

    @property
    def codegen(self) -> Any:
        """This library where Numba looks for what holds the variables of machine code."""
        return self

    def set_env(self, name: str, env: object) -> None:
        """Ignore the Python objects of a function: machine code alone has a place for them."""

    def _optimize_final_module(self) -> None:
        """Leave it to the kernels above."""

    def _finalize_final_module(self) -> None:
        """Make no machine code."""
        self._finalized = True


def _cache_on_disk(compiled: Any) -> None:
    """Cache a kernel in the folder of its sources; warn if there is none."""
    folder, usual = kernel_folder(package_of(compiled.py_func)), numba.config.CACHE_DIR
    if folder is None:
        _events.cannot_cache()
        return
    numba.config.CACHE_DIR = str(folder)
    try:
        compiled.enable_caching()
    except RuntimeError:
        _events.cannot_cache()
    finally:
        numba.config.CACHE_DIR = usual
    # Another version of Numba may have no such attribute: its cache is used unguarded.
    with suppress(AttributeError):
        _guard_cache(compiled._cache)


def _guard_cache(store: Any) -> None:
    """Let one process at a time save kernels of a folder, and ignore damaged files.

    Numba numbers the signatures of a kernel in an index, in the order of their compilation: of
    two processes that save at once, one would lose its kernel, or call the other's. Files are
    replaced as a whole, so that reading needs no lock.
    """
    load, save, lock = store.load_overload, store.save_overload, Path(store.cache_path, "lock")

    def load_undamaged(signature: Any, context: Any) -> Any:
        # A file cut short by a crash or a full disk may raise anything. The second try is for
        # versions of Numba that need the rules.
        for prepare in (_without_refresh, nullcontext):
            with suppress(Exception), prepare(context):
                return load(signature, context)
        return None

    def save_alone(signature: Any, data: Any) -> None:
        try:
            with FileLock(lock, PATIENCE, poll_interval=0.01):
                try:
                    save(signature, data)
                except OSError:
                    raise
                except Exception:  # the index is damaged
                    store.flush()
                    save(signature, data)
        except (OSError, NotImplementedError):  # no space, no folder, or no locks
            _events.cannot_cache()

    store.load_overload, store.save_overload = load_undamaged, save_alone


@contextmanager
def _without_refresh(context: Any) -> Iterator[None]:
    """Load a kernel without the rules by which Numba compiles.

    Numba collects them by ``refresh`` of its context before it loads the first kernel, which
    takes as long as loading twenty; machine code needs none of them, but the memory of its
    arrays. A compilation collects them.

    Raises:
        Exception: this version of Numba cannot do so; the context is as before.
    """
    from numba.core.runtime import rtsys

    rtsys.initialize(context)
    context.refresh = lambda: None
    try:
        yield
    finally:
        vars(context).pop("refresh", None)


class _CompilationEvents(event.Listener):
    """Report that kernels are being compiled, with a bar on a terminal, or cannot be cached."""

    def __init__(self) -> None:
        """Start without kernels and without messages."""
        self.kernels: dict[Callable[..., Any], Any] = {}
        self.inner_kernels: dict[Callable[..., Any], Any] = {}
        self._compiled_functions: set[Callable[..., Any]] = set()
        self._logged: set[str] = set()
        self._depth = 0
        self._bar: Progress | None = None

    def on_start(self, event: Any) -> None:
        """Count the beginning of a compilation; Numba does not call it for kernels it loads."""
        if event.data["dispatcher"].py_func not in self.kernels:
            return
        if self._depth == 0:
            self._show_bar()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """Count the end of a compilation; Numba calls it."""
        function = event.data["dispatcher"].py_func
        if function not in self.kernels:
            return
        self._compiled_functions.add(function)
        self._depth -= 1
        if self._bar is not None:
            self._bar.update(self._bar.task_ids[0], completed=len(self._compiled_functions))
        if self._depth == 0 and self._bar is not None:
            self._bar.stop()

    def cannot_cache(self) -> None:
        """Warn that the disk cache has no folder, or no space."""
        self._log_once(
            "no folder to cache compiled kernels in: they are compiled anew in every process; "
            "set NUMBA_CACHE_DIR to a folder that can be written to"
        )

    def _show_bar(self) -> None:
        """Show the bar on a terminal; elsewhere, log once that kernels are compiled."""
        if self._bar is None and not self._logged:
            self._bar = _make_bar()
            if self._bar is None:
                self._log_once(FIRST)
        if self._bar is None:
            return
        task = self._bar.task_ids[0]
        self._bar.update(task, completed=len(self._compiled_functions), total=len(self.kernels))
        self._bar.start()

    def _log_once(self, text: str) -> None:
        if text not in self._logged:
            self._logged.add(text)
            logger.warning(text)


def _make_bar() -> Progress | None:
    """Make a bar that counts kernels, on standard error; None if that is no terminal."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeElapsedColumn

    console = Console(stderr=True)
    if not (console.is_terminal or console.is_jupyter):
        return None
    columns = "{task.description}", BarColumn(), MofNCompleteColumn(), TimeElapsedColumn()
    bar = Progress(*columns, console=console, transient=True)
    bar.add_task("compiling kernels")
    return bar


_events = _CompilationEvents()
event.register("numba:compile", _events)
