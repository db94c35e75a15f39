"""Two small packages around a copy of what is behind `kinematics.numerics.compiled.jit`."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tests.support.waiting import HANGS

ROOT = Path(__file__).resolve().parents[2]
MODULES = (
    "errors",
    "numerics/array_types",
    "numerics/compiled/jit",
    "numerics/compiled/background",
    "numerics/compiled/numba_compiler",
    "numerics/compiled/cache_contents",
    "numerics/compiled/simd",
    "numerics/compiled/simd_types",
)
BELOW = """
from kinematics.numerics.compiled.jit import kernel

@kernel
def inner(x):
    return x + 1.0
"""
ABOVE = """
from kinematics.below import inner
from kinematics.numerics.compiled.jit import kernel

@kernel
def outer(x):
    return inner(x) * 10.0
"""
PLAIN = ABOVE.replace(
    "numerics.compiled.jit import kernel", "below import *\nimport numba"
).replace("@kernel", "@numba.njit(cache=True)")


def make_packages(site: Path) -> Path:
    """Write the packages into a folder."""
    for package, files in {
        "kinematics": {"__init__": "", "below": BELOW, "above": ABOVE, "plain": PLAIN},
        "kinematics/loading": {"__init__": ""},
        "kinematics/numerics": {"__init__": ""},
        "kinematics/numerics/compiled": {"__init__": ""},
        "balance": {"__init__": "", "above": ABOVE.replace("kinematics.b", "balance.deep.b")},
        "balance/deep": {"__init__": "", "below": BELOW},
    }.items():
        folder = site / package
        folder.mkdir(parents=True)
        for name, text in files.items():
            (folder / f"{name}.py").write_text(text, encoding="utf-8")
    for name in MODULES:
        shutil.copy(ROOT / "kinematics" / f"{name}.py", site / "kinematics" / f"{name}.py")
    return site


def run(folder: Path, code: str, **environment: str) -> tuple[list[str], list[str]]:
    """Lines that a new process prints, and lines of its standard error."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        env=clean() | environment,
        timeout=HANGS,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split(), done.stderr.splitlines()


def clean() -> dict[str, str]:
    """The environment without what changes how kernels are compiled."""
    ours = ("BALANCE_", "NUMBA_", "PYTHON", "XDG_")
    kept = {k: v for k, v in os.environ.items() if not k.startswith(ours)}
    return kept | {"PYTHONDONTWRITEBYTECODE": "1"}
