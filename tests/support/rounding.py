"""Perturbed rounding: run the product as if another processor computed it.

``python -m pytest --rounding SEED`` runs tests so. `install` puts a finder before those of
Python. It loads the modules of `kinematics` and `balance` from their sources with each matrix
product and each function of `tests.support.perturbed_functions` replaced; kernels are left as
they are, because Numba compiles them from their sources. It compiles them in one of a few ways,
which the seed chooses, into a cache of their own, and what they return or write is perturbed
where Python calls them. The product itself knows nothing of this, and other libraries, such as
Clarabel and Pinocchio, compute as ever.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Iterator
from functools import partial, update_wrapper
from importlib.abc import MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder, SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from tests.support.perturbed_functions import (
    PERTURBED,
    perturb_last_bits,
    perturbed,
    rounding,
)

__all__ = ["VARIANTS", "install"]

PACKAGES = ("kinematics", "balance")
# The name by which rewritten modules call what is perturbed.
WRAP = "__perturbed__"


class Variant(NamedTuple):
    """A way to compile kernels: permitted rewriting, and the processor."""

    fastmath: frozenset[str]
    processor: str | None = None
    features: str | None = None
    vectorise: bool = True


FAST = frozenset({"reassoc", "contract", "nsz"})
VARIANTS = {
    "as_built": Variant(FAST),
    "in_order": Variant(frozenset()),
    "generic": Variant(FAST, "generic", ""),
    "fused_in_order": Variant(frozenset({"contract"}), vectorise=False),
}


def install(variant: str = "as_built") -> None:
    """Perturb what the packages compute, from their import on, whenever `rounding` has a seed.

    Args:
        variant: how kernels are compiled, one of `VARIANTS`.

    Raises:
        RuntimeError: a package was imported before.
    """
    if imported := [name for name in PACKAGES if name in sys.modules]:
        raise RuntimeError(f"imported before their rounding can be perturbed: {imported}")
    sys.meta_path.insert(0, _Finder(variant))


class _Finder(MetaPathFinder):
    """Finds the modules of the packages, to load them rewritten."""

    def __init__(self, variant: str) -> None:
        """Keep the way to compile kernels."""
        self._variant = variant

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Find the source of a module of the packages, and none of others."""
        if name.partition(".")[0] not in PACKAGES:
            return None
        spec = PathFinder.find_spec(name, path, target)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = _Loader(name, spec.loader.path, self._variant)
        return spec


class _Loader(SourceFileLoader):
    """Loads a module from its source, rewritten."""

    def __init__(self, name: str, path: str, variant: str) -> None:
        """Keep the way to compile kernels."""
        super().__init__(name, path)
        self._variant = variant

    def get_code(self, fullname: str) -> Any:
        """Compile the rewritten source; neither read nor write byte code of the other."""
        path = self.get_filename(fullname)
        tree = _Rewriter().visit(ast.parse(self.get_data(path), path))
        return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)

    def exec_module(self, module: ModuleType) -> None:
        """Run the module, then change what it defines of kernels."""
        vars(module)[WRAP] = _wrap
        super().exec_module(module)
        if module.__name__ == "kinematics.compiled.cache_contents":
            _separate_cache(module, self._variant)
        elif module.__name__ == "kinematics.compiled.jit":
            vars(module)["kernel"] = partial(_perturbed_kernel, vars(module)["kernel"])
        elif module.__name__ == "kinematics.compiled.numba_compiler":
            _compile_otherwise(module, VARIANTS[self._variant])


def _wrap(name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    """The perturbed function of a name, made once."""
    if (name, plain) not in _wrapped:
        _wrapped[name, plain] = perturbed(name, plain)
    return _wrapped[name, plain]


_wrapped: dict[tuple[str, Callable[..., Any]], Callable[..., Any]] = {}


class _Rewriter(ast.NodeTransformer):
    """Replaces ``a @ b`` and functions that are perturbed, except in kernels."""

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Leave kernels as they are."""
        names = (ast.unparse(decorator) for decorator in node.decorator_list)
        if any(name.partition("(")[0] == "kernel" for name in names):
            return node
        return self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        """Replace a matrix product by a call."""
        self.generic_visit(node)
        if not isinstance(node.op, ast.MatMult):
            return node
        function = _call_wrap("operator.matmul", "__import__('operator').matmul")
        return ast.copy_location(ast.Call(function, [node.left, node.right], []), node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        """Replace a function by its perturbed one."""
        self.generic_visit(node)
        name = _dotted(node)
        if name not in PERTURBED or not isinstance(node.ctx, ast.Load):
            return node
        return ast.copy_location(_call_wrap(name, name), node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> Any:
        """Replace functions that are imported by their names."""
        names = [alias for alias in node.names if f"{node.module}.{alias.name}" in PERTURBED]
        bound = [(alias, alias.asname or alias.name) for alias in names]
        return [node] + [
            ast.copy_location(
                ast.Assign([ast.Name(name, ast.Store())],
                           _call_wrap(f"{node.module}.{alias.name}", name)), node)
            for alias, name in bound
            if not self._in_kernels
        ]  # fmt: skip

    _in_kernels = False

    def visit_Module(self, node: ast.Module) -> ast.AST:
        """Kernels of a module need the functions that it imports as they are."""
        self._in_kernels = "kinematics.compiled.jit import kernel" in ast.unparse(node)
        return self.generic_visit(node)


def _dotted(node: ast.expr) -> str:
    """The dotted name that an expression is, or nothing."""
    if isinstance(node, ast.Attribute):
        head = _dotted(node.value)
        return f"{head}.{node.attr}" if head else ""
    return node.id if isinstance(node, ast.Name) else ""


def _call_wrap(name: str, plain: str) -> ast.expr:
    """The expression of a perturbed function."""
    return ast.parse(f"{WRAP}({name!r}, {plain})", mode="eval").body


def _separate_cache(module: ModuleType, variant: str) -> None:
    """Let a variant have a folder of compiled kernels of its own, unless it is the usual one."""
    if variant == "as_built":
        return
    plain = module.cache_folder

    def cache_folder() -> Path | None:
        above = plain()
        if above is None:
            return None
        folder = above / f"rounding-{variant}"
        folder.mkdir(exist_ok=True)
        return folder

    vars(module)["cache_folder"] = update_wrapper(cache_folder, plain)


def _compile_otherwise(module: ModuleType, variant: Variant) -> None:
    """Compile kernels as a variant says."""
    import numba

    _let_numba_see_kernels()

    config = numba.config
    config.CPU_NAME, config.CPU_FEATURES = variant.processor, variant.features
    if not variant.vectorise:
        config.LOOP_VECTORIZE = config.SLP_VECTORIZE = 0

    class Numba:
        """The module ``numba`` with another function ``njit``."""

        __getattr__ = staticmethod(partial(getattr, numba))

        @staticmethod
        def njit(**options: Any) -> Any:
            return numba.njit(**options | {"fastmath": set(variant.fastmath)})

    vars(module)["numba"] = Numba()


class _PerturbedKernel:
    """A kernel, compiled or not, whose results are perturbed where Python calls it."""

    def __init__(self, kernel: Any) -> None:
        """Keep the kernel."""
        update_wrapper(self, getattr(kernel, "py_func", kernel))
        self._kernel = kernel

    def __getattr__(self, name: str) -> Any:
        """All else is that of the kernel."""
        return getattr(vars(self)["_kernel"], name)

    def __call__(self, *arguments: Any) -> Any:
        """Run the kernel; perturb what it returns, and what it changes in its arguments."""
        if rounding.seed is None:
            return self._kernel(*arguments)
        given = list(_arrays(arguments))
        inputs = np.concatenate([np.ravel(values) for values in given]) if given else np.empty(0)
        before = [array.copy() for array in given]
        result = self._kernel(*arguments)
        for array, old in zip(given, before, strict=True):
            changed = array != old
            if changed.any():
                array[changed] = _perturb_computed(array[changed], inputs)
        if isinstance(result, np.ndarray) and any(np.shares_memory(result, a) for a in given):
            return result
        return _perturb_computed(result, inputs)


def _perturb_computed(result: Any, inputs: np.ndarray) -> Any:
    """Perturb the numbers of a result that are not copies of inputs."""
    if isinstance(result, tuple):
        items = [_perturb_computed(item, inputs) for item in result]
        return type(result)(*items) if hasattr(result, "_fields") else tuple(items)
    if isinstance(result, float | np.ndarray) and np.asarray(result).dtype == np.float64:
        values = np.where(np.isin(result, inputs), result, perturb_last_bits(result))
        return values if isinstance(result, np.ndarray) else float(values)
    return result


def _arrays(values: Any) -> Iterator[np.ndarray]:
    """The doubles among arguments, as arrays, also in tuples."""
    for value in values:
        if isinstance(value, tuple):
            yield from _arrays(value)
        elif isinstance(value, float):
            yield np.array(value)
        elif isinstance(value, np.ndarray) and value.dtype == np.float64:
            yield value


def _perturbed_kernel(
    kernel: Callable[..., Any], function: Callable[..., Any] | None = None, **options: Any
) -> Any:
    """The decorator of kernels, for perturbed ones."""
    if function is None:
        return partial(_perturbed_kernel, kernel, **options)
    return _PerturbedKernel(kernel(function, **options))


def _let_numba_see_kernels() -> None:
    """Let kernels call perturbed ones as the plain ones that they hold."""
    from numba.extending import typeof_impl

    @typeof_impl.register(_PerturbedKernel)
    def _(value: Any, context: Any) -> Any:
        return typeof_impl(getattr(value._kernel, "compiled", value._kernel), context)
