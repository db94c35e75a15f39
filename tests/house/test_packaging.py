"""What is installed holds: the kernels' disk cache, the wheel, calls that every system has.

The cache is tried on a copy of what is behind `kinematics.numerics.compiled.jit`, in a package
with kernels of one line.
"""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.support.kernel_sources import kernels
from tests.support.small_package import ABOVE, BELOW, run
from tests.support.source_files import PRODUCT, ROOT, tree

ASK = "from kinematics.above import outer; print(outer(1.0))"
NO_FOLDER = "no folder to cache compiled kernels in"


@pytest.mark.compile
def test_a_change_in_another_file_is_seen(copy):
    """Even one that changes neither the size of the file nor its date."""
    code = "; ".join(
        f"from {module} import outer; print(outer(1.0))"
        for module in ("kinematics.above", "balance.above", "kinematics.plain")
    )
    first, told = run(copy, code)
    assert first == ["20.0", "20.0", "20.0"]
    assert len(told) == 1 and told[0].startswith("compiling kernels")
    (copy / "kinematics" / "other.py").write_text("colour = 'red'\n", encoding="utf-8")
    (copy / "kinematics" / ".#lock.py").symlink_to("nowhere")
    (copy / "beside.py").write_text(
        "import kinematics.numerics.compiled.jit\n", encoding="utf-8"
    )
    assert run(copy, code) == (first, []), "neither files without kernels nor those of others"

    for file in (copy / "kinematics" / "below.py", copy / "balance" / "deep" / "below.py"):
        dates = file.stat().st_atime_ns, file.stat().st_mtime_ns
        file.write_text(BELOW.replace("1.0", "2.0"), encoding="utf-8")
        os.utime(file, ns=dates)
    second, told = run(copy, code)
    assert second == ["30.0", "30.0", "20.0"], "the last, Numba's own cache, was stale"
    assert len(told) == 1


@pytest.mark.compile
def test_a_number_that_is_written_is_no_type_of_its_own(copy):
    text = ABOVE.replace("inner(x) * 10.0", "inner(1) + inner(2) + inner(x)")
    (copy / "kinematics" / "written.py").write_text(text, encoding="utf-8")
    code = """
from kinematics.numerics.compiled.numba_compiler import compile_inner_kernels
from kinematics.written import inner, outer
print(outer(3), len([*compile_inner_kernels()]), len(inner.signatures))
"""
    assert run(copy, code)[0] == ["9.0", "1", "1"]


@pytest.mark.compile
def test_nowhere_to_write_costs_one_warning(copy, tmp_path):
    """Files stand where the folders would have to be: nobody can write there."""
    (copy / "kinematics" / "__pycache__").write_text("", encoding="utf-8")
    (tmp_path / "home").write_text("", encoding="utf-8")
    home = str(tmp_path / "home")
    out, told = run(copy, ASK, HOME=home, USERPROFILE=home, LOCALAPPDATA=home)
    assert out == ["20.0"]
    assert len(told) == 1 and NO_FOLDER in told[0] and "NUMBA_CACHE_DIR" in told[0]
    folder = tmp_path / "cache"
    assert run(copy, ASK, HOME=home, NUMBA_CACHE_DIR=str(folder))[0] == ["20.0"]
    assert run(copy, ASK, HOME=home, NUMBA_CACHE_DIR=str(folder)) == (["20.0"], [])
    assert list(folder.glob("kinematics-*/*/*.nbc"))


@pytest.mark.compile
def test_a_damaged_cache_is_written_anew(copy):
    """Kernels, then their index, which alone makes no kernel compile again."""
    run(copy, ASK)
    for pattern, compiles in (("*.nbc", True), ("*.nbi", False)):
        files = list(copy.glob(f"**/{pattern}"))
        assert len(files) == 1
        for file in files:
            file.write_bytes(file.read_bytes()[:7])
        out, told = run(copy, ASK)
        assert out == ["20.0"] and (not compiles or len(told) == 1)
        assert all(file.stat().st_size > 7 for file in copy.glob(f"**/{pattern}"))
    assert run(copy, ASK) == (["20.0"], [])


@pytest.mark.compile
def test_a_full_disk_costs_one_warning(copy):
    full = """
import os
def replace(*_):
    raise OSError(28, "No space left on device")
os.replace = replace
"""
    out, told = run(copy, full + ASK)
    assert out == ["20.0"]
    assert [NO_FOLDER in line for line in told] == [False, True]


@pytest.mark.compile
def test_a_numba_with_another_inside_uses_its_own_cache(copy):
    code = f"""
from numba.core import dispatcher
class Other(dispatcher.FunctionCache):
    cache_path = property()  # there is none: AttributeError
dispatcher.FunctionCache = Other
{ASK}
"""
    assert run(copy, code)[0] == ["20.0"]
    assert run(copy, code) == (["20.0"], [])


# Arguments of different types, and what a kernel makes of them.
ASKED = {"2": "3.0", "2.5": "3.5", "2j": "(1+2j)", "np.float32(4.5)": "5.5"}
# A process that asks for one of them. All four have loaded an empty cache before one of them
# compiles, and have compiled before one of them saves.
RACE = """
import pathlib, time
import numpy as np
from kinematics.below import inner
from kinematics.numerics.compiled import numba_compiler

def meet(where):
    pathlib.Path(f"{where}-ASKED").touch()
    while len(list(pathlib.Path().glob(f"{where}-*"))) < 4:
        time.sleep(0.02)

def lock(*words, plain=numba_compiler.FileLock, **options):
    meet("compiled")
    return plain(*words, **options)

numba_compiler.FileLock = lock
meet("begun")
print(inner(ASKED))
"""


@pytest.mark.compile
def test_processes_may_compile_at_once(copy):
    """No signature is lost, none mistaken for another, and no part of a file read."""
    with ThreadPoolExecutor(4) as pool:
        codes = [RACE.replace("ASKED", asked) for asked in ASKED]
        answers = [out for out, _ in pool.map(partial(run, copy), codes)]
    assert answers == [[answer] for answer in ASKED.values()]
    asked = ", ".join(f"inner({x})" for x in ASKED)
    code = f"import numpy as np; from kinematics.below import inner; print({asked})"
    assert run(copy, code) == (list(ASKED.values()), []), "nothing is compiled again"


def folders(copy: Path) -> set[str]:
    """Names of the folders of compiled kernels."""
    return {file.parents[1].name for file in copy.glob("**/*.nbi")}


@pytest.mark.compile
def test_folders_of_old_sources_are_removed(copy):
    """All but the three newest, two of which stand for sources before the first."""
    found = []
    for k in range(3):
        number = f"{k + 1}.0"
        (copy / "kinematics" / "below.py").write_text(BELOW.replace("1.0", number), "utf-8")
        assert run(copy, ASK)[0] == [f"{10.0 * (2 + k)}"]
        found.append(folders(copy))
        if k == 0:
            (first,) = {file.parents[1] for file in copy.glob("**/*.nbi")}
            for age in (2, 1):
                older = first.with_name(f"kinematics-{age:016x}")
                shutil.copytree(first, older)
                os.utime(older, (1e9 - age, 1e9 - age))
    assert [len(names) for names in found] == [1, 4, 4]
    assert found[0] < found[2] and found[1] - found[2] == {f"kinematics-{2:016x}"}


def test_kernels_run_without_a_compiler(copy):
    assert run(copy, ASK, NUMBA_DISABLE_JIT="1") == (["20.0"], [])


def called(node: ast.AST) -> str:
    return ast.unparse(node.func) if isinstance(node, ast.Call) else ""


def borrowed(module: ast.Module) -> Iterator[tuple[str, str]]:
    """Names that the kernels of a module use from others, and the modules they are from."""
    origins = {
        alias.asname or alias.name: node.module
        for node in module.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    values = {
        target.id: node.value
        for node in module.body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Name)
    }
    pending: list[ast.AST] = list(kernels(module))
    while pending:
        node = pending.pop()
        body = node.body if isinstance(node, ast.FunctionDef) else [node]
        for name in (n.id for part in body for n in ast.walk(part) if isinstance(n, ast.Name)):
            if name in values:
                pending.append(values.pop(name))
            if name in origins:
                yield name, origins[name]


@pytest.mark.compile
def test_kernels_use_only_files_whose_change_is_seen():
    """`compiled.jit` looks at the files that mention it, and at no others."""
    homes = {path: ".".join(path.relative_to(ROOT).parts[:-1]) for path in PRODUCT}
    seen = {
        f"{homes[path]}.{path.stem}"
        for path in PRODUCT
        if "kinematics.numerics.compiled.jit" in path.read_text(encoding="utf-8")
    }
    uses = [(path, name, at) for path in PRODUCT for name, at in borrowed(tree(path))]
    assert any(at.startswith("kinematics.") for _, _, at in uses)
    wrong = [
        f"{path.name}: {name} of {at}"
        for path, name, at in uses
        if at not in seen or at.split(".")[0] not in ("kinematics", homes[path].split(".")[0])
    ]
    assert not wrong


POSIX = re.compile(
    r"os\.(fork\w*|wait\w*|get(e?[ug]id|pgid|ppgrp|loadavg)|set(sid|[ug]id|pgid)|l?chown|"
    r"mk(fifo|nod)|killpg|nice|uname|sysconf|statvfs|sched_\w+|openpty|pread|pwrite|"
    r"O_(NOFOLLOW|DIRECTORY|CLOEXEC))\b|"
    r"signal\.(SIG(KILL|HUP|ALRM|USR\d|PIPE|QUIT|STOP|CONT|CHLD)|alarm|setitimer|pause)\b|"
    r"\b(fcntl|grp|posix|pty|pwd|readline|resource|syslog|termios|tty)\.|"
    r"^'/(dev|proc|sys|tmp|etc|bin|usr)/"
)


def posix_only(module: ast.Module) -> Iterator[str]:
    """Names and paths that not every system has."""
    for node in ast.walk(module):
        found = []
        if isinstance(node, ast.Import):
            found = [f"{alias.name}." for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            found = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Attribute | ast.Constant):
            found = [ast.unparse(node)]
        yield from (f"{node.lineno}: {text}" for text in found if POSIX.search(text))


@pytest.mark.compile
def test_no_call_that_only_posix_has():
    example = "import fcntl; from os import fork; os.geteuid(), signal.SIGKILL, '/dev/null'"
    assert len(list(posix_only(ast.parse(example)))) == 5
    # The process that expands xacro limits its memory, where the system can.
    product = [p for p in PRODUCT if p.name != "xacro_worker.py"]
    assert not [f"{p.name}:{line}" for p in product for line in posix_only(tree(p))]


def guesses_encoding(node: ast.AST) -> bool:
    """Whether a call opens text without saying how it is encoded."""
    name = called(node)
    if name in ("os.open", "ResultsFile.open"):  # bytes, always
        return False
    if name != "open" and not name.endswith((".open", ".read_text", ".write_text")):
        return False
    modes = [a.value for a in node.args if isinstance(a, ast.Constant) and "b" in str(a.value)]
    return not modes and not any(word.arg == "encoding" for word in node.keywords)


@pytest.mark.slow
def test_text_is_read_in_one_encoding():
    """The default depends on the system."""
    assert guesses_encoding(ast.parse("open(p)").body[0].value)
    wrong = [
        f"{path.name}:{node.lineno}"
        for path in PRODUCT
        for node in ast.walk(tree(path))
        if guesses_encoding(node)
    ]
    assert not wrong


@pytest.mark.skipif(find_spec("hatchling") is None, reason="hatchling, the builder, is missing")
def test_the_wheel_holds_what_it_needs_and_no_more(tmp_path):
    code = "import sys; from hatchling.build import build_wheel; build_wheel(sys.argv[1])"
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    [path] = tmp_path.glob("*.whl")
    with zipfile.ZipFile(path) as wheel:
        names = set(wheel.namelist())
        [info] = {name.split("/")[0] for name in names if ".dist-info/" in name}
        metadata = wheel.read(f"{info}/METADATA").decode()
        commands = wheel.read(f"{info}/entry_points.txt").decode()
    wanted = {"balance/py.typed", "kinematics/py.typed"}
    wanted |= {path.relative_to(ROOT).as_posix() for path in PRODUCT}
    for data in ("balance/app/answers/html/static/*.*", "balance/app/schemas/*.json"):
        wanted |= {path.relative_to(ROOT).as_posix() for path in ROOT.glob(data)}
    wanted |= {f"urdf_models/{path.name}" for path in ROOT.glob("urdf_models/*.*")}
    assert wanted <= names
    folders = {"balance", "kinematics", "urdf_models", info}
    assert {name.split("/")[0] for name in names} == folders
    assert not [name for name in names if "/test" in name or "pycache" in name]
    assert "balance = balance.__main__:command" in commands
    assert re.search(r"Requires-Dist: pin\S* ?; ?sys_platform != 'win32'", metadata)
