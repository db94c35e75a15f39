"""The architecture: groups in layers, names that are used once, arguments that are documented.

Sources are parsed, not imported, so that a rule is checked on every path through them.
"""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from tests.support.source_files import (
    FACES,
    MODULES,
    PACKAGES,
    PRODUCT,
    ROOT,
    imports,
    label,
    public_names,
    tree,
)

# Words that say nothing of the object that they would name.
VAGUE = {"found", "it", "left", "one", "own", "right", "thing"}

# Groups of a package, lowest first: a module imports from its own group and from those before
# it. What stands at the top of a package, or below a group, has a line of its own.
LAYERS = """
kinematics.numerics.tolerances
kinematics.version kinematics.error_text
kinematics.errors kinematics.wording
kinematics.numerics
kinematics.model
kinematics.files
kinematics.closure
kinematics.loading

balance.support
balance.space
balance.motion
balance.masses
balance.studies
balance.app
balance.bodies balance.momentum balance.pose balance.flexible balance.checks balance.__main__
"""
LEVEL = {room: k for k, line in enumerate(LAYERS.splitlines()) for room in line.split()}


def room_of(module: str) -> str:
    """The group that a module is in, or its own line in ``LAYERS``: the longest name there."""
    parts = module.split(".")
    names = (".".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((name for name in names if name in LEVEL), "")


def folder_of(module: str) -> str:
    """The folder of a group that a module is in, or the group; nothing at a package's top."""
    path = MODULES.get(module)
    parts = path.relative_to(ROOT).parts[:-1] if path else ()
    return ".".join(parts[:3]) if len(parts) > 1 else ""


def defined_names(path: Path) -> set[str]:
    """The names that a file binds itself at its top level, imports left out."""
    found = set()
    for node in tree(path).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            found |= {
                name.id for t in targets for name in ast.walk(t) if isinstance(name, ast.Name)
            }
    return found


def public_functions() -> Iterator[tuple[Path, ast.FunctionDef]]:
    """The functions that the packages show, and public methods of their classes, with files."""
    for face in FACES:
        for name, value in public_names(face).items():
            path = MODULES[value.__module__]
            for node in tree(path).body:
                if isinstance(node, ast.FunctionDef) and node.name == name:
                    yield path, node
                elif isinstance(node, ast.ClassDef) and node.name == name:
                    methods = (item for item in node.body if isinstance(item, ast.FunctionDef))
                    yield from ((path, m) for m in methods if not m.name.startswith("_"))


def vague_names(path: Path) -> Iterator[str]:
    """Parameters, attributes and functions of a file whose name could stand for anything."""
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.arg):
            name = node.arg
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            name = node.name
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            name = node.target.id
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            name = node.attr
        else:
            continue
        if name.strip("_").lower() in VAGUE:
            yield f"{label(path)}:{node.lineno}: {name}"


def test_every_module_is_in_a_group():
    assert not [name for name in MODULES if not room_of(name) and name not in PACKAGES]


@pytest.mark.slow
def test_imports_point_down():
    """Also those for type checkers only, so that no two groups know each other."""
    wrong = []
    for name, path in MODULES.items():
        here = room_of(name)
        for found in imports(path) if here else ():
            there = room_of(found.module)
            if there and there != here and LEVEL[there] >= LEVEL[here]:
                wrong.append(f"{label(path)}:{found.line}: {here} imports {found.module}")
    assert not wrong


@pytest.mark.slow
def test_folders_have_no_circle():
    """Nor have the groups, whose order `test_imports_point_down` checks."""
    arrows = defaultdict(set)
    for name, path in MODULES.items():
        here = folder_of(name)
        arrows[here] |= {folder_of(found.module) for found in imports(path)} - {"", here}
    arrows.pop("")
    TopologicalSorter(arrows).prepare()  # raises CycleError, which names the circle


@pytest.mark.parametrize("face", FACES)
def test_no_module_hides_a_public_function(face: str):
    """The import of a module sets an attribute of its package: functions go by other names."""
    folder = ROOT.joinpath(*face.split("."))
    modules = {path.stem for path in folder.iterdir()} if folder.is_dir() else set()
    assert not modules & public_names(face).keys()


@pytest.mark.slow
def test_a_shared_name_stands_for_one_thing():
    """Functions and classes that a module imports from another are defined in one place."""
    places = defaultdict(set)
    for path in PRODUCT:
        for node in ast.walk(tree(path)):
            home = MODULES.get(str(node.module)) if isinstance(node, ast.ImportFrom) else None
            for alias in node.names if home else ():
                if alias.name in defined_names(home) and not alias.name.isupper():
                    places[alias.name].add(label(home))
    assert len(places) > 500
    assert not {name: files for name, files in places.items() if len(files) > 1}


def test_public_functions_document_their_arguments():
    """Those that take two or more document each of them."""
    wrong, seen = [], 0
    for path, function in public_functions():
        arguments = function.args
        taken = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
        names = [argument.arg for argument in taken if argument.arg not in ("self", "cls")]
        text = (ast.get_docstring(function) or "").partition("Args:")[2]
        told = set(re.findall(r"^    \*{0,2}(\w+)(?: \([^)]*\))?:", text, re.MULTILINE))
        for line in re.findall(r"^    ([\w, *]+):", text, re.MULTILINE):
            told |= set(re.findall(r"\w+", line))
        seen += 1
        if len(names) > 1 and not set(names) <= told:
            missing = ", ".join(name for name in names if name not in told)
            wrong.append(f"{label(path)}:{function.lineno}: {function.name}: {missing}")
    assert seen > 50
    assert not wrong


def test_names_say_the_object():
    """No attribute, parameter or function is called by a pronoun, or by where it stands."""
    assert [line for path in PRODUCT for line in vague_names(path)] == []
