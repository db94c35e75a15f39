"""Without a compiler (NUMBA_DISABLE_JIT=1) answers are the same, whole numbers to the last."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import kinematics
from balance import certify, design_space
from kinematics.closure.series import fill_loop_matrix
from tests.support.urdf_text import INERTIAL
from tests.support.waiting import HANGS

ROOT = Path(__file__).resolve().parents[3]
MODELS = (
    "four_bar_general", "four_bar_antiparallelogram", "four_bar_parallelogram", "five_bar",
    "slider_crank", "rusr", "four_bar_spherical", "hprs", "pantograph", "bennett",
    "six_bar_watt", "two_rrr", "three_rsr", "sarrus",
)  # fmt: skip
# Tests that are run in this mode: two whole files, and two in which numbers overflow.
TESTS = (
    "kinematics/closure/test_series.py", "kinematics/urdf/test_loops.py",
    "balance/search/test_many.py::test_screws_of_another_kind_are_refused",
    "balance/momentum/test_momentum.py::test_poses_may_be_given_in_three_ways",
)  # fmt: skip
# A parallelogram that is open at the pose of the file: exact arithmetic does not apply, and
# there is a parallel part.
OPEN = f"""<robot name="open"><link name="base"/><link name="crank">{INERTIAL}</link>
<link name="coupler">{INERTIAL}</link><link name="rocker">{INERTIAL}</link>
<joint name="u" type="continuous" independent="true"><parent link="base"/>
  <child link="crank"/><axis xyz="0 0 1"/></joint>
<joint name="a" type="continuous"><origin xyz="0 1 0"/><parent link="crank"/>
  <child link="coupler"/><axis xyz="0 0 1"/></joint>
<joint name="b" type="continuous"><origin xyz="2 0 0"/><parent link="base"/>
  <child link="rocker"/><axis xyz="0 0 1"/></joint>
<loop name="c" type="revolute"><axis xyz="0 0 1"/>
  <predecessor link="coupler"><origin xyz="2 0 0"/></predecessor>
  <successor link="rocker"><origin xyz="0.6 0.8 0"/></successor></loop></robot>"""


def answers():
    """The whole numbers of reports, and their levels of certainty, by model."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "open.urdf")
        path.write_text(OPEN, encoding="utf-8")
        for model in (*MODELS, path):
            space = design_space(kinematics.load(model))
            certainty = certify(space).certainty
            found[Path(model).stem] = [
                [order.rank for order in space.orders], space.rank, space.nullity,
                space.serial_nullity, space.kmax, space.poses, certainty.level, certainty.poses,
            ]  # fmt: skip
            if model != path:
                # Positions that Newton's method finds differ by the last digit, so that exact
                # arithmetic bounds the ranks of another linkage.
                found[Path(model).stem] += [certainty.rank, certainty.nullity]
    return found


def without_compiler(*command):
    """What a process without a compiler prints."""
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)}
    told = subprocess.run(
        [sys.executable, *command], env=environment, cwd=ROOT, capture_output=True, text=True,
        timeout=HANGS,
    )  # fmt: skip
    assert told.returncode == 0, told.stdout[-2000:] + told.stderr[-2000:]
    return told.stdout


def test_answers_are_those_of_compiled_kernels():
    compiled = hasattr(fill_loop_matrix, "signatures")
    script = (
        "import json, tests.kinematics.compiled.test_without_jit as t\n"
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
        "from kinematics.linalg.pivoted_qr import rows_follow, smallest_pivot, updated_factor\n"
        "one, both = np.eye(2), np.arange(2)\n"
        "print(type(smallest_pivot(one, both)).__name__)\n"
        "found = updated_factor(one[:0], one, both, 1e-9, 1.0)\n"
        "print(*(type(x).__name__ for x in found[2:]))\n"
        "print(type(rows_follow(one, both, one, both, 1e-9, 1.0)).__name__)"
    )
    assert without_compiler("-c", script).split() == ["float", "float", "float", "bool"]


def test_tests_of_kernels_pass_without_a_compiler():
    tests = [f"tests/{name}" for name in TESTS]
    # Seventy digits take most of the time, and nothing from the compiler: of one linkage.
    fewer = ("-k", "not digits or four_bar_general")
    without_compiler("-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider", *fewer, *tests)
