"""One BLAS thread, processes for the whole suite, and robots as files.

The matrices are small, and sums keep their order on every machine.
"""

from __future__ import annotations

import os

import pytest

# BLAS reads these when NumPy loads, and pytest loads this file before any test.
for name in ("OPENBLAS", "OMP", "MKL", "BLIS"):
    os.environ[f"{name}_NUM_THREADS"] = "1"
os.environ["VECLIB_MAXIMUM_THREADS"] = "1"


# Files of tests that need no kernels, and then small ones.
PLAIN = (
    "packaging reference hostile_files keyfile guard loops markup multipole inertia screws "
    "urdf rank series taylor momentum_taylor sparse"
).split()


def pytest_collection_modifyitems(items):
    """Plain files come second: the first file has the large kernels compiled meanwhile."""
    first = [item.path for item in items[:1]]
    place = {f"test_{name}": k for k, name in enumerate(PLAIN)}
    items.sort(key=lambda i: (i.path not in first, place.get(i.path.stem, len(PLAIN))))


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
    from small_package import make_packages

    return make_packages(tmp_path / "site")
