"""The default run computes sweeps and searches with kernels that are not compiled."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
# Folders with tests of the mark `lanes`.
FOLDERS = (
    "tests/balance/app/cli",
    "tests/balance/studies/discovery",
    "tests/balance/motion/pose",
    "tests/balance/space/many",
    "tests/balance/studies/runs",
    "tests/balance/studies/sweeps",
    "tests/fuzz/test_fuzz_results.py",
    "tests/kinematics/closure/taylor",
)


def test_sweeps_and_searches_uncompiled():
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "0", "-m", "lanes", *FOLDERS],
        cwd=ROOT, env=os.environ | {"BALANCE_COMPILE": "never"}, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-4000:]
    assert int(re.search(r"(\d+) passed", done.stdout)[1]) > 50


def test_no_folder_with_the_mark_is_left_out():
    files = {path for path in (ROOT / "tests").rglob("test_*.py")
             if "pytest.mark.lanes" in path.read_text(encoding="utf-8")}  # fmt: skip
    covered = [ROOT / folder for folder in FOLDERS]
    files.discard(Path(__file__))
    assert files and all({path, *path.parents} & set(covered) for path in files)
