"""Processes for the whole suite, and robots as files."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import tempfile
from collections import defaultdict
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from time import sleep
from zlib import crc32

import pytest

from tests.support.rounding import perturb_rounding

ROOT = Path(__file__).parents[1]

# Files of tests that need no kernels. Each process begins with some, while these are compiled.
PLAIN = (
    "lanes packaging reference formats hostile_files keyfile house kernel_rules "
    "geometry guard loops markup urdf oddities xacro mjcf_files architecture translate "
    "repeated_loops multipole inertia screws sidecar mjcf_hostile"
).split()
# What compiles them: once, for all processes of the tests, which wait for each kernel while
# this process holds the lock.
COMPILE = """
import pathlib, sys, balance, kinematics
from filelock import FileLock
from kinematics.numerics.compiled.background import collect_garbage_seldom
from kinematics.numerics.compiled.cache_contents import ALL, cache_folder, ready_kernels
folder = cache_folder()
if folder is not None:
    with FileLock(folder / "kernels.lock"):
        print("locked", flush=True)
        if ALL not in ready_kernels(pathlib.Path(balance.__file__).parent):
            if sys.argv[1] == "all":
                kinematics.compile()
            else:
                from balance.app.warmup import warm_up_single
                from kinematics.loading.warmup import smallest_linkages
                with collect_garbage_seldom():
                    for _ in warm_up_single(smallest_linkages()):
                        pass
"""
PERTURB = """
from tests.support.rounding import perturb_rounding
perturb_rounding({})
"""
compiler = pytest.StashKey()
bytecode = pytest.StashKey()

# Why the default run leaves tests out; `--everything` runs them.
LEFT_OUT = {
    "bench": "run benchmarks",
    "browser": "drive a browser",
    "compile": "compile kernels, or test their cache",
    "docs": "run pages of the documentation, or build the site",
    "slow": "take seconds",
}
# Mark of tests that run the kernels of sweeps and searches. To compile these takes longer than
# to run such tests uncompiled, as `tests/house/test_lanes.py` does in a process of its own.
LANES = "lanes"
# What a test is told that needs a kernel of the packages that the default run does not compile.
PRODUCT = ("kinematics.", "balance.")
NOT_COMPILED = (
    "the default run would spend its time on compiling {}: mark the test `lanes`, or let "
    "`balance.app.warmup.warm_up_single` run what commands call with it"
)
# How many cases of a test that is marked as a table the default run takes.
CASES = 5


def pytest_addoption(parser):
    """Add the switches of the suite: all of it, and another rounding."""
    text = "also run the tests and the cases of tables that the default run leaves out"
    parser.addoption("--everything", action="store_true", help=text)
    text = "run the part of the default run, even of files that are named"
    parser.addoption("--part", action="store_true", help=text)
    text = "change results of floating-point functions and kernels in their last bits at random"
    parser.addoption("--rounding", type=int, metavar="SEED", help=text)


def pytest_configure(config):
    """Compile kernels, beside the first tests, if several processes will need them.

    The default run compiles those of single poses and geometries alone.
    """
    for mark, reason in LEFT_OUT.items():
        text = f"{mark}: tests that {reason}; left out without --everything"
        config.addinivalue_line("markers", text)
    config.addinivalue_line("markers", f"table(cases={CASES}): cases that run by default")
    text = "tests that run the kernels of sweeps; the default run takes them uncompiled"
    config.addinivalue_line("markers", f"{LANES}: {text}")
    seed = config.getoption("rounding")
    if seed is not None:
        perturb_rounding(seed)
    if hasattr(config, "workerinput"):
        wait_for_kernels(refused=takes_a_part(config))
    if config.getoption("numprocesses", None):
        config.stash[bytecode] = keep_bytecode()
        kernels = "all" if config.getoption("everything") else "single"
        config.stash[compiler] = start_compiler(kernels, seed)


def keep_bytecode():
    """Where Python is told to write no bytecode, write that of this run to a temporary folder.

    Otherwise every process that a test starts compiles the packages again.
    """
    if not sys.dont_write_bytecode:
        return None
    folder = tempfile.TemporaryDirectory(prefix="bytecode")
    os.environ["PYTHONPYCACHEPREFIX"] = folder.name
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    return folder


def start_compiler(kernels, seed):
    """Start the process that compiles kernels, and wait until it holds their lock."""
    code = COMPILE if seed is None else PERTURB.format(seed) + COMPILE
    process = subprocess.Popen(
        [sys.executable, "-c", code, kernels], cwd=ROOT, stdout=subprocess.PIPE, text=True
    )
    process.stdout.readline()
    return process


def pytest_unconfigure(config):
    if compiler in config.stash:
        config.stash[compiler].terminate()
        config.stash[compiler].communicate()
        if folder := config.stash[bytecode]:
            folder.cleanup()


def wait_for_kernels(refused):
    """Load each kernel that the process beside the tests compiles, instead of compiling it.

    A kernel that is not in the cache is looked for until it is, or until that process ends.

    Args:
        refused: whether a test fails that needs a kernel which that process does not compile.
    """
    from filelock import FileLock, Timeout

    from kinematics.numerics.compiled import numba_compiler
    from kinematics.numerics.compiled.cache_contents import cache_folder, kernel_name

    if (folder := cache_folder()) is None:
        return
    cache_on_disk, lock = numba_compiler._cache_on_disk, FileLock(folder / "kernels.lock")

    def compiler_runs():
        try:
            with lock.acquire(timeout=0):
                return False
        except Timeout:
            return True

    def cache_and_wait(compiled):
        cache_on_disk(compiled)
        store, name = compiled._cache, kernel_name(compiled.py_func)
        load, refuses = store.load_overload, refused and name.startswith(PRODUCT)

        def wait_and_load(signature, context):
            while (kernel := load(signature, context)) is None and compiler_runs():
                sleep(0.05)
            kernel = kernel or load(signature, context)
            if kernel is None and refuses and store.cache_path is not None:
                pytest.fail(NOT_COMPILED.format(name))
            return kernel

        store.load_overload = wait_and_load

    numba_compiler._cache_on_disk = cache_and_wait


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_collection(session):
    """Let each process rewrite the asserts of a part of the tests before it reads all of them.

    Otherwise each would rewrite those of all tests, because none is ahead of the others. What
    is read stays until the end: meanwhile nobody looks for garbage.
    """
    gc.disable()
    try:
        worker = getattr(session.config, "workerinput", None)
        if worker and session.config.args == session.config.getini("testpaths"):
            rewrite_a_part(int(worker["workerid"][2:]), worker["workercount"])
        return (yield)
    finally:
        gc.enable()


def rewrite_a_part(number, processes):
    """Import each file of tests that is this process's, so that its asserts are rewritten."""
    paths = sorted((ROOT / "tests").rglob("test_*.py"))
    for path in paths[number::processes]:
        with suppress(Exception):  # the collection reports it
            import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))


def pytest_collection_modifyitems(config, items):
    """Files that need no kernels come first, and the default run takes a part of the tests."""
    if takes_a_part(config):
        rest = select_left_out(items)
        config.hook.pytest_deselected(items=[item for item in items if item in rest])
        items[:] = [item for item in items if item not in rest]
    place = {f"test_{name}": k for k, name in enumerate(PLAIN)}
    items.sort(key=lambda item: place.get(item.path.stem, len(PLAIN)))
    if worker := getattr(config, "workerinput", None):
        share_plain_files(items, worker["workercount"])


def share_plain_files(items, processes):
    """Order tests so that each process begins with files that need no kernels.

    Each process begins with a part of the list, all of the same size. The test of lanes, the
    longest of these files, stands alone at the start of the last part.
    """
    count = sum(item.path.stem[len("test_") :] in PLAIN for item in items)
    plain, rest = items[:count], items[count:]
    if not plain or not rest or processes < 2:
        return
    first, *others = plain
    size = len(items) // processes
    starts = [others[k :: processes - 1] for k in range(processes - 1)] + [[first]]
    items.clear()
    for part in starts:
        room = max(size - len(part), 0)
        items += part + rest[:room]
        rest = rest[room:]
    items += rest


def select_left_out(items):
    """Find the tests that only `--everything` runs: marked ones, and most cases of tables.

    A table keeps its first case, and others by the hash of their names, so that no type of
    case is left out because it comes at regular intervals.
    """
    from kinematics.numerics.compiled.background import compile_mode

    marks = [*LEFT_OUT] if compile_mode() == "never" else [*LEFT_OUT, LANES]
    rest = {item for item in items if any(map(item.get_closest_marker, marks))}
    tables = defaultdict(list)
    for item in items:
        if mark := item.get_closest_marker("table"):
            cases = mark.args[0] if mark.args else CASES
            tables[item.path, item.cls, item.originalname, cases].append(item)
    for (*_, cases), (_, *others) in tables.items():
        others.sort(key=lambda item: crc32(item.name.encode()))
        rest.update(others[cases - 1 :])
    return rest


def pytest_terminal_summary(terminalreporter, config):
    """Say what the default run left out."""
    if takes_a_part(config):
        reasons = "; ".join(LEFT_OUT.values())
        terminalreporter.write_line(f"The default run leaves out tests that {reasons}.")
        terminalreporter.write_line("`python -m pytest --everything` runs them too.")


def takes_a_part(config):
    """Whether the run takes a part of the tests, as the default one does."""
    whole = config.getoption("everything") or names_files(config)
    return config.getoption("part") or not whole


def names_files(config):
    """Whether files are named: all of their tests run, in one process."""
    return all(".py" in argument for argument in config.args)


def pytest_collection_finish():
    """Refuse files of tests that run kernels at their import: every process would compile them.

    Let a fixture or a cached function do what they do.
    """
    compiler = sys.modules.get("kinematics.numerics.compiled.numba_compiler")
    if found := compiler and compiler.compiled_kernels():
        raise pytest.UsageError(f"these kernels run when tests are imported: {found}")


def pytest_xdist_auto_num_workers(config):
    """Up to four processes for a folder, one for files that are named."""
    return 0 if names_files(config) else min(os.cpu_count() or 1, 4)


@pytest.fixture
def compiled_kernels():
    """Wait until all kernels are compiled, for tests whose processes would compile them too."""
    from filelock import FileLock

    from kinematics.numerics.compiled.cache_contents import cache_folder

    if folder := cache_folder():
        with FileLock(folder / "kernels.lock"):
            pass


@pytest.fixture
def robot(tmp_path):
    """Write a text or bytes to a file and return its path."""

    def write(text):
        path = tmp_path / "robot.urdf"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


@pytest.fixture
def read(robot):
    """Write elements to a file and read it."""
    from kinematics.files.formats.robot_files import read_unassembled

    return lambda *elements: read_unassembled(
        robot(f'<robot name="r">{"".join(elements)}</robot>')
    )


@pytest.fixture
def copy(tmp_path):
    """A copy of what is behind `kinematics.numerics.compiled.jit`, with kernels of one line."""
    from tests.support.small_package import make_packages

    return make_packages(tmp_path / "site")
