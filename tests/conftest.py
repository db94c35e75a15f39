"""Processes for the whole suite, and robots as files."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# Files of tests that need no kernels. They come first, while all kernels are compiled.
PLAIN = (
    "packaging reference formats hostile_files keyfile house mjcf_hostile kernel_rules "
    "geometry guard loops markup urdf oddities xacro mjcf_files architecture translate "
    "repeated_loops multipole inertia screws sidecar"
).split()
# What compiles them: once, for all processes of the tests, which wait for this lock.
COMPILE = """
import pathlib, balance, kinematics
from filelock import FileLock
from kinematics.compiled.cache_contents import ALL, cache_folder, ready_kernels
folder = cache_folder()
if folder is not None:
    with FileLock(folder / "kernels.lock"):
        if ALL not in ready_kernels(pathlib.Path(balance.__file__).parent):
            kinematics.compile()
"""
compiler = pytest.StashKey()


def pytest_configure(config):
    """Compile all kernels, beside the first tests, if several processes will need them."""
    if config.getoption("numprocesses", None):
        config.stash[compiler] = subprocess.Popen([sys.executable, "-c", COMPILE], cwd=ROOT)


def pytest_unconfigure(config):
    if compiler in config.stash:
        config.stash[compiler].terminate()
        config.stash[compiler].wait()


@cache
def wait_for_kernels():
    """Wait until the process that compiles all kernels has ended."""
    from filelock import FileLock

    from kinematics.compiled.cache_contents import cache_folder

    folder = cache_folder()
    if folder is not None:
        with FileLock(folder / "kernels.lock"):
            pass


def pytest_runtest_setup(item):
    """In one of several processes, compile nothing that the process beside them compiles."""
    if hasattr(item.config, "workerinput") and item.path.stem[5:] not in PLAIN:
        wait_for_kernels()


def pytest_collection_modifyitems(items):
    """Files that need no kernels come first."""
    place = {f"test_{name}": k for k, name in enumerate(PLAIN)}
    items.sort(key=lambda item: place.get(item.path.stem, len(PLAIN)))


def pytest_collection_finish():
    """Refuse files of tests that run kernels at their import: every process would compile them.

    Let a fixture or a cached function do what they do.
    """
    compiler = sys.modules.get("kinematics.compiled.numba_compiler")
    if found := compiler and compiler.compiled_kernels():
        raise pytest.UsageError(f"these kernels run when tests are imported: {found}")


def pytest_xdist_auto_num_workers(config):
    """Up to four processes for a folder; tests of files that are named run in this one."""
    named = all(".py" in argument for argument in config.args)
    return 0 if named else min(os.cpu_count() or 1, 4)


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
    from kinematics.formats.robot_files import read_unassembled

    return lambda *elements: read_unassembled(
        robot(f'<robot name="r">{"".join(elements)}</robot>')
    )


@pytest.fixture
def copy(tmp_path):
    """A copy of what is behind `kinematics.compiled.jit`, with kernels of one line."""
    from tests.support.small_package import make_packages

    return make_packages(tmp_path / "site")
