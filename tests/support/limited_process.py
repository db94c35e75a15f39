"""Processes with bounded memory and processor time: a runaway ends, a slow machine does not."""

from __future__ import annotations

import os
import resource
import subprocess
import sys

# Address space, bytes, and processor time, seconds. What runs here needs a tenth of either.
MEMORY = 2**30
SECONDS = 300


def run_limited(code: str, *words: str) -> subprocess.CompletedProcess[str]:
    """Run Python code with the words as ``sys.argv[1:]``; it has to end with exit code 0."""
    return subprocess.run(
        [sys.executable, "-c", code, *words],
        capture_output=True,
        text=True,
        check=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        preexec_fn=_set_limits,
    )


def _set_limits() -> None:
    """Limit the process that is about to start."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS))
