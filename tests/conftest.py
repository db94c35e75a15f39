"""One BLAS thread, and robots as files.

The matrices are small, and sums keep their order on every machine.
"""

from __future__ import annotations

import os

import pytest

# BLAS reads these when NumPy loads, and pytest loads this file before any test.
for name in ("OPENBLAS", "OMP", "MKL", "BLIS"):
    os.environ[f"{name}_NUM_THREADS"] = "1"
os.environ["VECLIB_MAXIMUM_THREADS"] = "1"


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
    from kinematics.reader import urdf

    return lambda *elements: urdf.read(robot(f'<robot name="r">{"".join(elements)}</robot>'))
