"""Run Python code in a new process, with the packages of this one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def python(*words: str, cwd: Path | str = ROOT, **variables: str) -> str:
    """Run a Python process.

    Args:
        words: arguments of the interpreter.
        cwd: working directory.
        variables: environment variables, in addition to those of this process.

    Returns:
        Its standard output.
    """
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, *words],
        cwd=cwd,
        capture_output=True,
        text=True,
        check=True,
        env=os.environ | {"PYTHONPATH": path} | variables,
    )
    return done.stdout
