"""The default run computes sweeps and searches with kernels that are not compiled."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
MARK = "pytest.mark." + "lanes"


def files_with_the_mark() -> list[Path]:
    """All files of tests in which the mark stands."""
    paths = sorted((ROOT / "tests").rglob("test_*.py"))
    return [path for path in paths if MARK in path.read_text(encoding="utf-8")]


def test_sweeps_and_searches_uncompiled():
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-n",
            "0",
            "-m",
            "lanes",
            "--part",
            *map(str, files_with_the_mark()),
        ],
        cwd=ROOT,
        env=os.environ | {"BALANCE_COMPILE": "never"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout[-4000:]
    assert int(re.search(r"(\d+) passed", done.stdout)[1]) > 50
