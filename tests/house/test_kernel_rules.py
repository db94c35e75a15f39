"""Rules of the sources of kernels: reference counting, private names of Numba."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import pytest

from tests.support.kernel_sources import (
    callees,
    counts_references,
    kernels,
    reached,
)
from tests.support.small_package import run
from tests.support.source_files import PRODUCT, ROOT, tree

NUMBA = ROOT / "kinematics" / "numerics" / "compiled" / "numba_compiler.py"
# Private names that Numba has for the cache, the compiler and the types of its objects.
KNOWN = {
    "_cache",
    "_cache_file",
    "_cache_path",
    "_compile_for_args",
    "_compiler",
    "_data_name",
    "_impl",
    "_insert",
    "_load_data",
    "_nrt",
    "_numba_type_",
    "_rebuild",
    "_reduce",
    "_save_data",
    "_source_stamp",
}
HEAD = "import numpy as np\nfrom kinematics.numerics.compiled.jit import kernel\n"
# Kernels that are refused, and what the message says of them.
REFUSED = {
    """
@kernel(reference_counting=False)
def broken(x):
    x[0] += 1.0
    return x
""": "kernel broken returns array(float64, 1d, C)",
    """
@kernel(reference_counting=False)
def broken(x):
    return 1.0, x
""": "kernel broken returns Tuple(float64, array(float64, 1d, C))",
    """
@kernel
def made(x):
    return np.zeros(x.size)
made(np.ones(3))

@kernel(reference_counting=False)
def broken(x):
    new = made(x)
    return new[0]
""": "kernel broken is given array(float64, 1d, C) by made",
    """
@kernel(reference_counting=False)
def broken(x):
    return np.zeros(x.size)[0]
""": "No implementation of function Function(<built-in function zeros>)",
}
ASK = f"""
import numpy as np
from importlib import import_module
for k in range({len(REFUSED)}):
    broken = import_module(f"kinematics.refused_{{k}}").broken
    for _ in range(2):
        try:
            print(broken(np.ones(3)))
        except TypeError as error:
            print("refused", repr(str(error)).replace(" ", "_"))
        except Exception as error:
            print(type(error).__name__, repr(str(error)).replace(" ", "_"))
"""


@cache
def all_kernels() -> list[tuple[Path, ast.FunctionDef]]:
    """All kernels, each with its file."""
    return [(path, kernel) for path in PRODUCT for kernel in kernels(tree(path))]


def allocates(kernel: ast.FunctionDef) -> bool:
    """Whether a kernel makes arrays itself."""
    makers = {"np.empty", "np.zeros", "np.ones", "np.full", "np.arange", "np.array", "np.eye"}
    makers |= {f"{name}_like" for name in makers}
    calls = (node for node in ast.walk(kernel) if isinstance(node, ast.Call))
    return any(
        ast.unparse(call.func) in makers or ast.unparse(call.func).endswith(".copy")
        for call in calls
    )


@pytest.mark.compile
def test_kernels_without_counts_are_refused_where_they_would_need_them(copy):
    """At every call: compiled, one would return what is freed, another never free it."""
    for k, source in enumerate(REFUSED):
        (copy / "kinematics" / f"refused_{k}.py").write_text(HEAD + source, encoding="utf-8")
    told, _ = run(copy, ASK)
    assert len(told) == 4 * len(REFUSED), told
    for k, message in enumerate(REFUSED.values()):
        out = told[4 * k : 4 * k + 4]
        assert out[0] == out[2] != "array(", out
        assert message.replace(" ", "_") in out[1] and out[1] == out[3]


@pytest.mark.compile
def test_references_are_not_counted_in_sweeps_and_single_answers_alone():
    """In kernels for many geometries or poses, or of a design space, if they make no arrays."""
    search = ROOT / "balance" / "space" / "many"
    swept = reached(search / "many_geometries_kernels.py")
    swept |= reached(ROOT / "balance" / "studies" / "sweeps" / "closing_kernels.py")
    swept |= reached(search / "placing_kernels.py") | reached(search / "lane_kernels.py")
    verification = ROOT / "balance" / "motion" / "verification"
    swept |= reached(verification / "inertia_wrench_kernels.py")
    swept |= reached(verification / "motion_kernels.py")
    swept |= reached(ROOT / "kinematics" / "closure" / "taylor" / "lane_expansion.py")
    swept |= reached(ROOT / "kinematics" / "closure" / "taylor" / "expansion_kernels.py")
    swept |= reached(ROOT / "balance" / "space" / "spaces" / "first_orders.py")
    wrong = [
        f"{path.name}: {kernel.name}"
        for path, kernel in all_kernels()
        if counts_references(kernel) == (kernel in swept and not allocates(kernel))
    ]
    assert len(swept) > 40 and not wrong


@pytest.mark.slow
def test_kernels_without_counts_bind_nothing_that_others_make():
    """Nobody would free it."""
    assert any(allocates(kernel) for _, kernel in all_kernels())
    wrong = []
    for path, kernel in all_kernels():
        if counts_references(kernel):
            continue
        alone = {node.value for node in ast.walk(kernel) if isinstance(node, ast.Expr)}
        wrong += [
            f"{path.name}:{call.lineno}: {callee.name}"
            for call, callee in callees(path, kernel)
            if counts_references(callee) and call not in alone
        ]
        wrong += [f"{path.name}: {kernel.name}"] * allocates(kernel)
    assert not wrong


@pytest.mark.slow
def test_every_kernel_is_seen():
    """The word stands nowhere but in decorators and their import."""
    used = 0
    for path in PRODUCT:
        nodes = list(ast.walk(tree(path)))
        imports = [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]
        aliases = [alias for node in imports for alias in node.names]
        assert not [
            alias for alias in aliases if alias.name == "kinematics.numerics.compiled.jit"
        ]
        of_kernels = [a for a in aliases if a.name == "kernel"]
        assert all(alias.asname is None for alias in of_kernels)
        names = [node.id for node in nodes if isinstance(node, ast.Name)]
        used += names.count("kernel") if of_kernels else 0
    assert used == len(all_kernels()) > 60


def private(path: Path) -> set[str]:
    """Names in a file that begin with one underscore, and are of other objects than self."""
    found: set[object] = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) != "self":
            found.add(node.attr)
        elif isinstance(node, ast.keyword):
            found.add(node.arg)
        elif isinstance(node, ast.Dict):
            found |= {key.value for key in node.keys if isinstance(key, ast.Constant)}
        elif isinstance(node, ast.ClassDef):
            found |= {ast.unparse(n.targets[0]) for n in node.body if isinstance(n, ast.Assign)}
    words = {name for name in found if isinstance(name, str)}
    return {name for name in words if name.startswith("_") and not name.endswith("__")}


@pytest.mark.slow
def test_private_names_of_numba_stand_in_one_file():
    from kinematics.numerics.compiled.numba_compiler import PRIVATE

    others = {path: private(path) & KNOWN for path in PRODUCT if path != NUMBA}
    assert not {path: names for path, names in others.items() if names}
    assert private(NUMBA) == set(PRIVATE)
    assert not private(ROOT / "kinematics" / "numerics" / "compiled" / "simd_types.py")
