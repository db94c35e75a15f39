"""Processes of Python of their own, with the packages of this one."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

__all__ = ["ROOT", "python"]

ROOT = Path(__file__).parents[2]


def python(*words: str, cwd: Path | str = ROOT, **variables: str) -> str:
    """What a process prints.

    Args:
        words: arguments of the interpreter.
        cwd: where it runs.
        variables: of its environment, besides those of this process.
    """
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    done = subprocess.run(
        [sys.executable, *words], cwd=cwd, capture_output=True, text=True, check=True,
        env=os.environ | {"PYTHONPATH": path} | variables,
    )  # fmt: skip
    return done.stdout
