"""Runs that are killed at random moments and resumed, until one of them ends."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import time
from collections.abc import Callable, Sequence
from pathlib import Path

__all__ = ["kill_and_resume"]

# Seconds after which a run that is not killed hangs.
HANGS = 1500.0


def kill_and_resume(
    command: Sequence[str], covered: Callable[[], int], rows: int, kills: int, seed: int,
    environment: dict[str, str],
) -> list[int]:  # fmt: skip
    """Start a command, kill it by SIGKILL, and start it again; let the last run end.

    The moments are random, and such that all kills happen while rows are left: a run is killed
    when it has written a random part of an equal share of them, and a little later.

    Args:
        command: words of the command, which resumes.
        covered: counts the rows that its file covers; 0 if there is none.
        rows: all rows.
        kills: how many runs are killed.
        seed: of the moments.
        environment: variables of the command.

    Returns:
        The rows in the file after each kill.
    """
    rng, found = random.Random(seed), []
    for k in range(kills):
        goal = rows * (k + rng.random()) / (kills + 1)
        process = start(command, environment)
        begin = time.monotonic()
        while covered() < goal and process.poll() is None:
            time.sleep(0.003)
            assert time.monotonic() - begin < HANGS
        time.sleep(rng.random() * 0.03)
        assert process.poll() is None, process.communicate()
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        found.append(covered())
    last = start(command, environment)
    _, errors = last.communicate(timeout=HANGS)
    assert last.returncode == 0, errors
    return found


def start(command: Sequence[str], environment: dict[str, str]) -> subprocess.Popen:
    """Start a command."""
    return subprocess.Popen(
        list(command), env=os.environ | environment, stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def paths_of(root: Path) -> dict[str, str]:
    """The variables with which a command finds the product and the tests."""
    return {"PYTHONPATH": str(root)}
