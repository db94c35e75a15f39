"""The architecture: rooms in layers, names that are used once, arguments that are documented.

Sources are parsed, not imported, so that a rule is checked on every path through them.
"""

from __future__ import annotations

import ast
import importlib
from collections import defaultdict
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from tests.support.source_files import MODULES, PACKAGES, PRODUCT, ROOT, imports, label, tree

# Rooms of a package, lowest first: a module imports from its own room and from those before it.
# Rooms on one line do not import each other.
LAYERS = """
kinematics.tolerances
kinematics.version kinematics.errors kinematics.error_text kinematics.wording
kinematics.compiled
kinematics.linalg kinematics.spatial
kinematics.urdf_elements
kinematics.model
kinematics.urdf kinematics.closure
kinematics.formats kinematics.mobility
kinematics.assembly
kinematics.meant
kinematics.model_gallery kinematics.taylor kinematics.building
kinematics.warmup

balance.tolerances balance.motion_tolerances balance.public_names
balance.options balance.atomic_files balance.json_text balance.csv_text
balance.result_files
balance.flexible
balance.inertial_parameters
balance.momentum
balance.conditions balance.transfers balance.exact
balance.spaces
balance.search balance.interpretation
balance.certification
balance.decoupled
balance.designs balance.verification balance.taylor_poses
balance.added_masses balance.dynamic_equivalence balance.floating_base balance.modes
balance.instantaneous
balance.partial_balance
balance.sweeps balance.discovery
balance.reactionless_paths
balance.remedies balance.synthesis
balance.report
balance.report.text
balance.report.html
balance.cli
balance.warmup balance.__main__
"""
LEVEL = {room: k for k, line in enumerate(LAYERS.splitlines()) for room in line.split()}


def room_of(module: str) -> str:
    """The longest name of a room that a module is, or is in."""
    parts = module.split(".")
    names = (".".join(parts[:count]) for count in range(len(parts), 0, -1))
    return next((name for name in names if name in LEVEL), "")


def public_names(path: Path) -> list[str]:
    """The names in ``__all__`` of a file."""
    for node in tree(path).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return [ast.literal_eval(item) for item in node.value.elts]
    return []


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


def public_functions(path: Path) -> Iterator[ast.FunctionDef]:
    """The functions in ``__all__`` of a file, and the public methods of the classes in it."""
    names = set(public_names(path))
    for node in tree(path).body:
        if isinstance(node, ast.FunctionDef) and node.name in names:
            yield node
        elif isinstance(node, ast.ClassDef) and node.name in names:
            yield from (
                item for item in node.body
                if isinstance(item, ast.FunctionDef) and not item.name.startswith("_")
            )  # fmt: skip


def test_every_module_is_in_a_room():
    assert not [name for name in MODULES if not room_of(name) and name not in PACKAGES]


def test_imports_point_down():
    """Also those for type checkers only, so that no two rooms know each other."""
    wrong = []
    for name, path in MODULES.items():
        here = room_of(name)
        for found in imports(path) if here else ():
            there = room_of(found.module)
            if there and there != here and LEVEL[there] >= LEVEL[here]:
                wrong.append(f"{label(path)}:{found.line}: {here} imports {found.module}")
    assert not wrong


@pytest.mark.slow
def test_rooms_have_no_circle():
    arrows = defaultdict(set)
    for name, path in MODULES.items():
        rooms = {room_of(found.module) for found in imports(path)} - {"", room_of(name)}
        arrows[room_of(name)] |= rooms
    TopologicalSorter(arrows).prepare()  # raises CycleError, which names the circle


@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_hides_a_public_function(package: str):
    """The import of a module sets an attribute of its package: functions go by other names."""
    found = {path.stem for path in (ROOT / package).iterdir() if path.name != "__pycache__"}
    assert not found & set(importlib.import_module(package).__all__)


def test_a_public_name_stands_for_one_thing():
    places = defaultdict(list)
    for path in PRODUCT:
        if path.name != "__init__.py":
            for name in set(public_names(path)) & defined_names(path):
                places[name].append(label(path))
    assert not {name: files for name, files in places.items() if len(files) > 1}


def test_public_functions_document_their_arguments():
    """Those that take two or more."""
    wrong = []
    for path in PRODUCT:
        for function in public_functions(path):
            arguments = function.args
            taken = [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]
            count = sum(argument.arg not in ("self", "cls") for argument in taken)
            if count > 1 and "Args:" not in (ast.get_docstring(function) or ""):
                wrong.append(f"{label(path)}:{function.lineno}: {function.name}")
    assert not wrong
