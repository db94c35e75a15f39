"""The kernels in the sources: who is one, with which options, and which others it calls."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from tests.support.source_files import PRODUCT, ROOT, tree


def is_kernel(node: ast.AST) -> bool:
    """Whether a node is a function that is compiled: decorated by ``@kernel``."""
    marks = getattr(node, "decorator_list", [])
    return any(re.match(r"kernel\b", ast.unparse(mark)) for mark in marks)


def kernels(node: ast.AST) -> Iterator[ast.FunctionDef]:
    """All kernels below a node."""
    return (inner for inner in ast.walk(node) if is_kernel(inner))


def counts_references(kernel: ast.FunctionDef) -> bool:
    """Whether a kernel is compiled with reference counting."""
    return "reference_counting=False" not in ast.unparse(kernel.decorator_list[0])


@cache
def names(path: Path) -> dict[str, ast.FunctionDef]:
    """The kernels that a module may call, by the names it has for them.

    A function that makes a kernel stands for it, as do the names given to what it returns.
    """
    found = {}
    for node in tree(path).body:
        if isinstance(node, ast.FunctionDef):
            inner = list(kernels(node))
            if inner:
                found[node.name] = inner[0]
        elif isinstance(node, ast.ImportFrom):
            file = ROOT / (str(node.module).replace(".", "/") + ".py")
            known = names(file) if file in PRODUCT else {}
            found |= {a.asname or a.name: known[a.name] for a in node.names if a.name in known}
        elif isinstance(node, ast.Assign):
            for target, value in pairs(node.targets[0], node.value):
                made = getattr(getattr(value, "func", None), "id", None)
                if isinstance(target, ast.Name) and made in found:
                    found[target.id] = found[made]
    return found


def pairs(target: ast.AST, value: ast.AST) -> list[tuple[ast.AST, ast.AST]]:
    """What an assignment binds to what."""
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        return list(zip(target.elts, value.elts, strict=True))
    return [(target, value)]


def callees(path: Path, kernel: ast.FunctionDef) -> Iterator[tuple[ast.Call, ast.FunctionDef]]:
    """Calls of a kernel in a file to other kernels."""
    known = names(path)
    for node in ast.walk(kernel):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            if node.func.id in known:
                yield node, known[node.func.id]


def reached(path: Path) -> set[ast.FunctionDef]:
    """The kernels of a file, and all that they call, directly or not."""
    home = {kernel: file for file in PRODUCT for kernel in kernels(tree(file))}
    found: set[ast.FunctionDef] = set()
    pending = list(kernels(tree(path)))
    while pending:
        kernel = pending.pop()
        if kernel not in found:
            found.add(kernel)
            pending += [callee for _, callee in callees(home[kernel], kernel)]
    return found
