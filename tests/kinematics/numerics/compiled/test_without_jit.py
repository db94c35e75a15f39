"""Without a compiler (NUMBA_DISABLE_JIT=1) answers are the same, whole numbers to the last."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from kinematics.closure.series import fill_loop_matrix
from tests.support.waiting import HANGS
from tests.support.whole_number_answers import MODELS, answers

ROOT = Path(__file__).resolve().parents[4]
# Tests that are run in this mode: two whole files, and two in which numbers overflow.
TESTS = (
    "kinematics/closure/test_series.py",
    "kinematics/files/urdf/test_loops.py",
    "balance/space/many/test_many.py::test_screws_of_another_kind_are_refused",
    "balance/space/momentum/test_momentum.py::test_poses_may_be_given_in_three_ways",
)


def without_compiler(*command):
    """What a process without a compiler prints."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    told = subprocess.run(
        [sys.executable, *command],
        env=environment,
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=HANGS,
    )
    assert told.returncode == 0, told.stdout[-2000:] + told.stderr[-2000:]
    return told.stdout


@pytest.mark.compile
def test_answers_are_those_of_compiled_kernels():
    compiled = hasattr(fill_loop_matrix, "signatures")
    script = (
        "import json, tests.support.whole_number_answers as t\n"
        "import sys; assert 'numba' not in sys.modules\n"
        "print(json.dumps(t.answers()))"
    )
    told = json.loads(without_compiler("-c", script))
    assert len(told) == len(MODELS) + 1
    assert told == answers() or not compiled


def test_numbers_are_those_of_python():
    """As a compiled kernel returns them: no index and no JSON takes a scalar of NumPy."""
    script = (
        "import numpy as np\n"
        "from kinematics.numerics.linalg.pivoted_qr import rows_follow, smallest_pivot, "
        "updated_factor\n"
        "one, both = np.eye(2), np.arange(2)\n"
        "print(type(smallest_pivot(one, both)).__name__)\n"
        "found = updated_factor(one[:0], one, both, 1e-9, 1.0)\n"
        "print(*(type(x).__name__ for x in found[2:]))\n"
        "print(type(rows_follow(one, both, one, both, 1e-9, 1.0)).__name__)"
    )
    assert without_compiler("-c", script).split() == ["float", "float", "float", "bool"]


@pytest.mark.compile
def test_tests_of_kernels_pass_without_a_compiler():
    tests = [f"tests/{name}" for name in TESTS]
    # Seventy digits take most of the time, and nothing from the compiler: of one linkage.
    fewer = ("-k", "not digits or four_bar_general")
    without_compiler("-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *fewer, *tests)
