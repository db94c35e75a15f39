"""Perturbed rounding: run the product as if another processor computed it.

``python -m pytest --rounding SEED`` runs tests so. `perturb_rounding` puts a finder before
those of Python. It loads the modules of `kinematics` and `balance` from their sources with each
matrix product and each function of `tests.support.perturbed_functions` replaced. Kernels stay
as they are, because Numba compiles them from their sources. They are compiled in one of the
ways of `VARIANTS`, with a cache of its own, and what one kernel in two returns or writes is
perturbed where Python calls it; the seed chooses which. In the way ``uncompiled``, each
``+ - * /`` of a kernel is rounded at random: Monte Carlo arithmetic proper, for small linkages.

The product knows nothing of this. Other libraries, such as Clarabel and Pinocchio, compute as
ever.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable, Iterator
from functools import cache, partial, update_wrapper
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
from tests.support.rounded_operations import OPERATIONS, operation

PACKAGES = ("kinematics", "balance")
# Names by which rewritten modules call what is perturbed.
FUNCTION, OPERATION = "__perturbed_function__", "__perturbed_operation__"
# Each seed perturbs the results of one in so many kernels, because it takes time.
KERNELS = 2


class Variant(NamedTuple):
    """A way to run kernels: compiled or not, permitted rewriting, and the processor."""

    fastmath: frozenset[str] = frozenset()
    processor: str | None = None
    features: str | None = None
    vectorise: bool = True
    compiled: bool = True


FAST = frozenset({"reassoc", "contract", "nsz"})
VARIANTS = {
    "as_built": Variant(FAST),
    "in_order": Variant(),
    "generic": Variant(FAST, "generic", ""),
    "fused_in_order": Variant(frozenset({"contract"}), vectorise=False),
    "uncompiled": Variant(compiled=False),
}
COMPILED = tuple(name for name, variant in VARIANTS.items() if variant.compiled)


def perturb_rounding(seed: int, variant: str = "") -> None:
    """Perturb what the packages compute, from their import on.

    Args:
        seed: of the random rounding; 0 or more.
        variant: how kernels run, one of `VARIANTS`; one of `COMPILED` by the seed if empty.

    Raises:
        RuntimeError: a package was imported before.
    """
    if imported := [name for name in PACKAGES if name in sys.modules]:
        raise RuntimeError(f"imported before their rounding can be perturbed: {imported}")
    rounding.seed = seed
    sys.meta_path.insert(0, _Finder(variant or COMPILED[seed % len(COMPILED)]))


class _Finder(MetaPathFinder):
    """Finds the modules of the packages, to load them rewritten."""

    def __init__(self, variant: str) -> None:
        """Keep the way to run kernels."""
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
        """Keep the way to run kernels."""
        super().__init__(name, path)
        self._variant = variant

    def get_code(self, fullname: str) -> Any:
        """Compile the rewritten source; neither read nor write byte code of the other."""
        path = self.get_filename(fullname)
        tree = ast.parse(self.get_data(path), path)
        tree = _Rewriter(tree, VARIANTS[self._variant].compiled).visit(tree)
        return compile(ast.fix_missing_locations(tree), path, "exec", dont_inherit=True)

    def exec_module(self, module: ModuleType) -> None:
        """Run the module, then change what it defines of kernels."""
        vars(module).update({FUNCTION: _function, OPERATION: operation})
        super().exec_module(module)
        if change := CHANGES.get(module.__name__):
            change(module, self._variant)


@cache
def _function(name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    """The perturbed function of a name."""
    return perturbed(name, plain)


class _Rewriter(ast.NodeTransformer):
    """Replaces ``a @ b`` and functions that are perturbed; operations in uncompiled kernels."""

    def __init__(self, tree: ast.Module, compiled: bool) -> None:
        """Learn whether a module has kernels, and whether they are compiled."""
        text = ast.unparse(tree)
        self._compiled = compiled
        self._has_kernels = "from kinematics.numerics.compiled.jit import kernel" in text
        self._in_kernel = False

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.AST:
        """Leave compiled kernels as they are."""
        names = (ast.unparse(decorator) for decorator in node.decorator_list)
        if not any(name.partition("(")[0] == "kernel" for name in names):
            return self.generic_visit(node)
        if not self._compiled:
            self._in_kernel = True
            node.body = [self.visit(statement) for statement in node.body]
            self._in_kernel = False
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        """Replace a matrix product, or an operation of a kernel, by a call."""
        self.generic_visit(node)
        if isinstance(node.op, ast.MatMult):
            name = "operator.matmul"
            function = _call(FUNCTION, name, "__import__('operator').matmul")
        elif self._in_kernel and type(node.op).__name__ in OPERATIONS:
            function = _call(OPERATION, type(node.op).__name__)
        else:
            return node
        return ast.copy_location(ast.Call(function, [node.left, node.right], []), node)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.AST:
        """Replace an operation that changes an item; names may be of arrays, and stay."""
        self.generic_visit(node)
        name = type(node.op).__name__
        if not self._in_kernel or name not in OPERATIONS:
            return node
        value = ast.parse(ast.unparse(node.target), mode="eval").body
        place = "in place " if isinstance(node.target, ast.Name) else ""
        call = ast.Call(_call(OPERATION, place + name), [value, node.value], [])
        return ast.copy_location(ast.Assign([node.target], call), node)

    def visit_Attribute(self, node: ast.Attribute) -> ast.AST:
        """Replace a function by its perturbed one."""
        self.generic_visit(node)
        name = _dotted(node)
        if name not in PERTURBED or not isinstance(node.ctx, ast.Load):
            return node
        return ast.copy_location(_call(FUNCTION, name, name), node)

    def visit_ImportFrom(self, node: ast.ImportFrom) -> Any:
        """Replace functions that are imported by their names, except for compiled kernels."""
        if self._has_kernels and self._compiled:
            return node
        return [node] + [
            ast.copy_location(
                ast.Assign(
                    [ast.Name(alias.asname or alias.name, ast.Store())],
                    _call(FUNCTION, f"{node.module}.{alias.name}", alias.asname or alias.name),
                ),
                node,
            )
            for alias in node.names
            if f"{node.module}.{alias.name}" in PERTURBED
        ]


def _dotted(node: ast.expr) -> str:
    """The dotted name that an expression is, or nothing."""
    if isinstance(node, ast.Attribute):
        head = _dotted(node.value)
        return f"{head}.{node.attr}" if head else ""
    return node.id if isinstance(node, ast.Name) else ""


def _call(maker: str, name: str, *plain: str) -> ast.expr:
    """The expression of what is called instead of a function or an operation."""
    return ast.parse(f"{maker}({', '.join([repr(name), *plain])})", mode="eval").body


def _separate_cache(module: ModuleType, variant: str) -> None:
    """Give a variant its own folder of compiled kernels, unless it is the usual one."""
    plain = module.cache_folder

    def cache_folder() -> Path | None:
        above = plain()
        if above is None:
            return None
        folder = above / f"rounding-{variant}"
        folder.mkdir(exist_ok=True)
        return folder

    if variant != "as_built":
        vars(module)["cache_folder"] = update_wrapper(cache_folder, plain)


def _choose_mode(module: ModuleType, variant: str) -> None:
    """Compile nothing, if a variant says so."""
    if not VARIANTS[variant].compiled:
        module._ProcessChoice.default = "never"


def _compile_otherwise(module: ModuleType, name: str) -> None:
    """Compile kernels as a variant says."""
    import numba
    from numba.extending import typeof_impl

    variant, config = VARIANTS[name], numba.config
    config.CPU_NAME, config.CPU_FEATURES = variant.processor, variant.features
    if not variant.vectorise:
        config.LOOP_VECTORIZE = config.SLP_VECTORIZE = 0

    @typeof_impl.register(_PerturbedKernel)
    def _(value: Any, context: Any) -> Any:
        """Let kernels call perturbed ones as the plain ones that they hold."""
        return typeof_impl(getattr(value._kernel, "compiled", value._kernel), context)

    class Numba:
        """The module ``numba`` with another function ``njit``."""

        __getattr__ = staticmethod(partial(getattr, numba))

        @staticmethod
        def njit(**options: Any) -> Any:
            return numba.njit(**options | {"fastmath": set(variant.fastmath)})

    vars(module)["numba"] = Numba()


def _perturb_kernels(module: ModuleType, variant: str) -> None:
    """Perturb what compiled kernels return."""
    if VARIANTS[variant].compiled:
        vars(module)["kernel"] = partial(_perturbed_kernel, module.kernel)


# What is changed of a module after its import.
CHANGES = {
    "kinematics.numerics.compiled.cache_contents": _separate_cache,
    "kinematics.numerics.compiled.background": _choose_mode,
    "kinematics.numerics.compiled.jit": _perturb_kernels,
    "kinematics.numerics.compiled.numba_compiler": _compile_otherwise,
}


def _perturbed_kernel(
    kernel: Callable[..., Any], function: Callable[..., Any] | None = None, **options: Any
) -> Any:
    """The decorator of kernels, for perturbed ones."""
    if function is None:
        return partial(_perturbed_kernel, kernel, **options)
    return _PerturbedKernel(kernel(function, **options))


class _PerturbedKernel:
    """A kernel whose results are perturbed where Python calls it, if the seed chooses it."""

    def __init__(self, kernel: Any) -> None:
        """Keep the kernel."""
        update_wrapper(self, getattr(kernel, "py_func", kernel))
        self._kernel = kernel
        self._chosen = rounding.chooses(self.__qualname__, KERNELS)

    def __getattr__(self, name: str) -> Any:
        """All else is that of the kernel."""
        return getattr(vars(self)["_kernel"], name)

    def __call__(self, *arguments: Any) -> Any:
        """Run the kernel; perturb what it returns, and what it changes in its arguments."""
        if not self._chosen:
            return self._kernel(*arguments)
        arrays = list(_arrays(arguments))
        before = np.concatenate([[0.0], *map(np.ravel, arrays)])
        result = self._kernel(*arguments)
        after = np.concatenate([[0.0], *map(np.ravel, arrays)])
        changed, inputs = after != before, np.sort(before)
        if changed.any():
            after[changed] = _perturb_computed(after[changed], inputs)
            ends = np.cumsum([1, *(array.size for array in arrays)])
            for array, first, last in zip(arrays, ends[:-1], ends[1:], strict=True):
                if changed[first:last].any():
                    array[...] = after[first:last].reshape(array.shape)
        if isinstance(result, np.ndarray) and any(np.shares_memory(result, a) for a in arrays):
            return result
        return _perturb_computed(result, inputs)


def _perturb_computed(result: Any, inputs: np.ndarray) -> Any:
    """Perturb the numbers of a result that are not copies of inputs, which are sorted."""
    if isinstance(result, tuple):
        items = [_perturb_computed(item, inputs) for item in result]
        return type(result)(*items) if hasattr(result, "_fields") else tuple(items)
    if isinstance(result, float):
        return float(_perturb_computed(np.array([result]), inputs)[0])
    if isinstance(result, np.ndarray) and result.dtype == np.float64:
        nearest = np.searchsorted(inputs, result)
        copied = inputs[np.minimum(nearest, inputs.size - 1)] == result
        return np.where(copied, result, perturb_last_bits(result))
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
