"""The source files of the repository, their syntax trees, and the modules that they import."""

from __future__ import annotations

import ast
import importlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("kinematics", "balance")
# Modules whose names are for users.
FACES = (
    *PACKAGES,
    *(f"balance.{name}" for name in ("space", "motion", "masses", "studies")),
    *(f"balance.{name}" for name in ("bodies", "momentum", "pose", "flexible", "checks")),
)
PRODUCT = [path for package in PACKAGES for path in sorted(ROOT.glob(f"{package}/**/*.py"))]
OURS = PRODUCT + [p for d in ("tests", "benchmarks") for p in sorted(ROOT.glob(f"{d}/**/*.py"))]
Function = (ast.FunctionDef, ast.AsyncFunctionDef)
Definition = (*Function, ast.ClassDef)


class Import(NamedTuple):
    """One imported module: its dotted name, where, and whether loading the file loads it."""

    module: str
    line: int
    on_load: bool


@cache
def tree(path: Path) -> ast.Module:
    """The syntax tree of a file."""
    return ast.parse(path.read_text(encoding="utf-8"), str(path))


def label(path: Path) -> str:
    """Path relative to the repository."""
    return path.relative_to(ROOT).as_posix()


def module_name(path: Path) -> str:
    """Dotted name of a source file; a package root goes by the package's name."""
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


def public_names(face: str) -> dict[str, Any]:
    """What a face shows users, by name; the modules that it lists too are left out."""
    module = importlib.import_module(face)
    values = {name: getattr(module, name) for name in module.__all__}
    return {name: value for name, value in values.items() if not isinstance(value, ModuleType)}


MODULES = {module_name(path): path for path in PRODUCT}
NAMES = {module_name(path) for path in OURS}


def imports(path: Path) -> Iterator[Import]:
    """All imports of a file, those within functions and for type checkers included."""
    pending: list[tuple[ast.AST, bool]] = [(tree(path), True)]
    while pending:
        node, on_load = pending.pop()
        if isinstance(node, ast.Import):
            yield from (Import(alias.name, node.lineno, on_load) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{label(path)}:{node.lineno}: relative import"
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                yield Import(whole if whole in NAMES else node.module, node.lineno, on_load)
        elif isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            pending += [(child, False) for child in node.body]
            pending += [(child, on_load) for child in node.orelse]
        else:
            inside = on_load and not isinstance(node, (*Function, ast.Lambda))
            pending += [(child, inside) for child in ast.iter_child_nodes(node)]
