"""The rules of the house: layers, lazy imports, printing, docstrings, sizes, the command.

Sources are parsed, not imported, so that a rule is checked on every path through them.
"""

from __future__ import annotations

import ast
import importlib
import json
import re
import subprocess
import sys
from collections.abc import Iterator
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from tests.support.kernel_sources import is_kernel
from tests.support.source_files import (
    FACES,
    MODULES,
    OURS,
    PACKAGES,
    PRODUCT,
    ROOT,
    Definition,
    Function,
    imports,
    label,
    public_names,
    tree,
)

TESTS = [path for path in OURS if path.is_relative_to(ROOT / "tests")]
FILE_LINES, FUNCTION_LINES = 500, 60

# Slow to load, or not installed everywhere: only the functions that use them import them.
LAZY = {
    "clarabel",
    "distributed",
    "example_robot_data",
    "ezdxf",
    "manifold3d",
    "matplotlib",
    "mujoco",
    "pinocchio",
    "pyarrow",
    "rich",
    "scipy",
    "trimesh",
    "yourdfpy",
}
NOT_FOR_REPORT = (
    "pinocchio",
    "trimesh",
    "matplotlib",
    "clarabel",
    "balance.motion.flexible",
    "balance.motion.paths",
    "balance.motion.quiet",
)


def functions(path: Path) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    """All functions and methods of a file, nested ones included."""
    return (node for node in ast.walk(tree(path)) if isinstance(node, Function))


def undocumented(node: ast.AST, where: str) -> Iterator[str]:
    """Public modules, classes, functions and methods below ``node`` without a docstring."""
    if ast.get_docstring(node) is None:
        yield where
    if isinstance(node, Function):
        return
    for child in node.body:
        if isinstance(child, Definition) and not child.name.startswith("_"):
            yield from undocumented(child, f"{where}: {child.name}")


def length(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function, without its docstring and the kernels in its body."""
    inner = sum(length(node) for node in function.body if is_kernel(node))
    text = ast.get_docstring(function, clean=False)
    documented = 0 if text is None else text.count("\n") + 1
    return function.end_lineno - function.lineno + 1 - inner - documented


def speaks(node: ast.AST) -> bool:
    """Whether a node prints, touches the standard streams, or ends the process."""
    if isinstance(node, ast.Call):
        return ast.unparse(node.func) in {"print", "exit", "quit", "sys.exit", "os._exit"}
    if isinstance(node, ast.ImportFrom):
        private = {"stdout", "stderr", "__stdout__", "__stderr__", "exit"}
        return node.module == "sys" and any(alias.name in private for alias in node.names)
    if isinstance(node, ast.Attribute):
        streams = {"sys.stdout", "sys.stderr", "sys.__stdout__", "sys.__stderr__"}
        return ast.unparse(node) in streams
    return isinstance(node, ast.Name) and node.id == "SystemExit"


@pytest.mark.slow
def test_kinematics_knows_nothing_of_balance():
    wrong = [
        f"{label(path)}:{found.line}"
        for path in PRODUCT
        if path.is_relative_to(ROOT / "kinematics")
        for found in imports(path)
        if found.module.split(".")[0] == "balance"
    ]
    assert not wrong


@pytest.mark.slow
def test_product_imports_neither_tests_nor_benchmarks():
    outside = {path.stem for path in OURS if path not in PRODUCT} | {"tests", "benchmarks"}
    wrong = [
        f"{label(path)}:{found.line}: {found.module}"
        for path in PRODUCT
        for found in imports(path)
        if found.module.split(".")[0] in outside
    ]
    assert not wrong


@pytest.mark.slow
def test_tests_do_not_import_one_another():
    """They share `tests/support`, also with the processes that they start."""
    wrong = [
        f"{label(path)}:{found.line}: {found.module}"
        for path in TESTS
        for found in imports(path)
        if found.module.rpartition(".")[2].startswith("test_")
    ]
    assert not wrong
    assert not lines_with(re.compile(r"\btests(?:\.\w+)*\.test_"), TESTS)


@pytest.mark.slow
def test_shared_code_of_tests_imports_no_folder_of_tests():
    """Tests of the packages stand on it, not the other way round."""
    wrong = [
        f"{label(path)}:{found.line}: {found.module}"
        for folder in ("support", "independent", "fuzz")
        for path in TESTS
        if path.is_relative_to(ROOT / "tests" / folder)
        for found in imports(path)
        if found.module.startswith(tuple(f"tests.{package}" for package in PACKAGES))
    ]
    assert not wrong


@pytest.mark.slow
def test_modules_have_no_cycle():
    graph = {
        name: {found.module for found in imports(path)} & MODULES.keys()
        for name, path in MODULES.items()
    }
    assert not [name for name, below in graph.items() if name in below]
    TopologicalSorter(graph).prepare()  # raises CycleError, which names the cycle


@pytest.mark.slow
def test_imports_can_be_read_from_the_source():
    """Only package roots, and the parser of the commands, import what is used by a string."""
    wrong = [
        f"{label(path)}:{node.lineno}"
        for path in PRODUCT
        if path.name != "__init__.py" and label(path) != "balance/app/cli/main.py"
        for node in ast.walk(tree(path))
        if (isinstance(node, ast.alias) and node.name == "import_module")
        or (isinstance(node, ast.Attribute) and node.attr == "import_module")
        or (isinstance(node, ast.Name) and node.id == "__import__")
    ]
    assert not wrong


@pytest.mark.slow
def test_heavy_libraries_load_late():
    wrong = [
        f"{label(path)}:{found.line}: {found.module}"
        for path in PRODUCT
        for found in imports(path)
        if found.on_load and found.module.split(".")[0] in LAZY
    ]
    assert not wrong


@pytest.mark.slow
def test_numba_is_behind_two_modules():
    users = {
        label(path)
        for path in PRODUCT
        for found in imports(path)
        if found.module.split(".")[0] == "numba"
    }
    files = ("numba_compiler", "simd_types")
    assert users == {f"kinematics/numerics/compiled/{name}.py" for name in files}


@pytest.mark.slow
def test_only_the_command_line_speaks():
    allowed = {
        "balance/app/cli/main.py": True,
        "balance/__main__.py": "SystemExit",
        # A worker whose parent has ended, amid its work.
        "balance/studies/runs/parent_process.py": "os._exit(1)",
    }
    wrong = [
        f"{label(path)}:{node.lineno}: {ast.unparse(node)}"
        for path in PRODUCT
        for node in ast.walk(tree(path))
        if speaks(node) and allowed.get(label(path)) not in (True, ast.unparse(node))
    ]
    assert not wrong


@pytest.mark.parametrize("face", FACES)
def test_public_names_exist_and_are_documented(face: str):
    module = importlib.import_module(face)
    assert sorted(module.__all__) == list(module.__all__)
    for name, value in public_names(face).items():
        assert value.__doc__, f"{face}.{name}"
    with pytest.raises(AttributeError, match="no_such_name"):
        _ = module.no_such_name


def test_a_public_name_has_one_face():
    """But for the first name that anyone needs."""
    names = [name for face in FACES for name in public_names(face)]
    assert len(names) > 100
    assert [name for name in set(names) if names.count(name) > 1] == ["load"]


@pytest.mark.table(1)
@pytest.mark.parametrize("face", FACES)
def test_a_newcomer_finds_the_public_names(face: str):
    """In the docstring with a line each, by completion and in the help, before first use."""
    code = f"import {face}, json; p = {face}; print(json.dumps([p.__doc__, dir(p)]))"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True
    )
    text, names = json.loads(done.stdout)
    public = list(importlib.import_module(face).__all__)
    told = re.findall(r"^- ``(\w+)``: \S.*\S$", text, re.MULTILINE)
    assert sorted(told) == public
    assert set(public) <= set(names)


@pytest.mark.slow
def test_all_that_is_public_has_a_docstring():
    wrong = [where for path in PRODUCT for where in undocumented(tree(path), label(path))]
    assert not wrong


def test_only_the_faces_of_packages_list_their_names():
    """Elsewhere an underscore says what is private."""
    faces = {MODULES[face] for face in FACES}
    listing = {path for path in OURS if lines_with(re.compile(r"^[\w, ]*\b__all__ ="), [path])}
    assert listing == faces


def test_a_constant_has_one_value():
    """A second one of its name would replace it, as where two modules become one."""
    wrong = []
    for path in PRODUCT:
        assigned = [
            target.id
            for node in tree(path).body
            if isinstance(node, ast.Assign | ast.AnnAssign)
            for target in ast.walk(node)
            if isinstance(target, ast.Name) and isinstance(target.ctx, ast.Store)
        ]
        twice = {name for name in assigned if assigned.count(name) > 1 and name.isupper()}
        wrong += [f"{label(path)}: {name}" for name in sorted(twice)]
    assert not wrong


def test_files_are_short():
    lengths = {label(path): len(path.read_text("utf-8").splitlines()) for path in OURS}
    assert not {name: lines for name, lines in lengths.items() if lines > FILE_LINES}


@pytest.mark.slow
def test_functions_fit_on_a_screen():
    wrong = [
        f"{label(path)}: {function.name}: {length(function)} lines"
        for path in OURS
        for function in functions(path)
        if length(function) > FUNCTION_LINES and not is_kernel(function)
    ]
    assert not wrong


@pytest.mark.slow
def test_report_loads_no_heavy_library():
    """In a process of its own, since other tests load what they like."""
    code = f"""
import json, sys
from balance.app.cli.main import main
status = main(["report", "four_bar_kite", "--json"])
loaded = [name for name in {NOT_FOR_REPORT!r} if name in sys.modules]
print(json.dumps([status, loaded]), file=sys.stderr)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stderr.splitlines()[-1]) == [0, []]
    assert json.loads(done.stdout)


def lines_with(pattern: re.Pattern[str], files: list[Path]) -> list[str]:
    """Every line of the files in which the pattern occurs, and where."""
    return [
        f"{label(path)}:{number}: {line.strip()}"
        for path in files
        for number, line in enumerate(path.read_text("utf-8").splitlines(), 1)
        if pattern.search(line)
    ]


@pytest.mark.slow
def test_no_path_of_a_machine():
    pattern = re.compile(r"(?<![\w.:/])/(?:work|home|root|tmp|Users|mnt|opt)/|\b[A-Z]:\\\\")
    files = [*OURS, ROOT / ".ci" / "run", ROOT / "pyproject.toml"]
    assert not lines_with(pattern, files)


def test_product_does_not_know_its_gallery():
    """No rule is written for one linkage."""
    # A kind of mechanism that can be synthesised bears the name of an example of it.
    models = sorted({path.stem for path in ROOT.glob("urdf_models/*.urdf")} - {"pantograph"})
    assert models
    pattern = re.compile(rf"\b(?:{'|'.join(map(re.escape, models))})\b")
    assert not lines_with(pattern, PRODUCT)


def test_continuous_integration_runs_the_command_of_the_readme():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    fenced = re.search(r"<!-- test command -->\s*?\n```\w*\n(.*?)\n```", readme, re.DOTALL)
    assert fenced, "README.md: no code fence after <!-- test command -->"
    lines = (ROOT / ".ci" / "run").read_text(encoding="utf-8").splitlines()
    assert fenced[1] in lines
