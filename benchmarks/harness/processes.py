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
    done = _run(*words, cwd=cwd, **variables)
    done.check_returncode()
    return done.stdout


def balance_command(*words: str, cwd: Path | str, **variables: str) -> None:
    """Run a command of balance whose verdict may be positive or negative; see `python`."""
    done = _run("-m", "balance", *words, cwd=cwd, **variables)
    if done.returncode not in (0, 1):
        done.check_returncode()


def _run(*words: str, cwd: Path | str, **variables: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    return subprocess.run(
        [sys.executable, *words],
        cwd=cwd,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": path} | variables,
    )
