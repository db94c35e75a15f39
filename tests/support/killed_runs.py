"""Runs that are killed at random moments and resumed, until one of them ends."""

from __future__ import annotations

import math
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from tests.support.waiting import HANGS, wait_until_true


def kill_and_resume(
    module: str,
    words: Sequence[str],
    covered: Callable[[], int],
    rows: int,
    kills: int,
    seed: int,
    environment: dict[str, str],
) -> list[int]:
    """Start a run, kill it by SIGKILL, and start it again; let the last run end.

    The moments are random, and such that all kills happen while rows are left: a run is killed
    when it has written a random part of an equal share of them, and a little later. It waits
    for that at the end of the share.

    Args:
        module: see `start_held`.
        words: see `start_held`; the run resumes.
        covered: counts the rows that its file covers; 0 if there is none.
        rows: all rows.
        kills: how many runs are killed; a share is to be longer than a chunk.
        seed: of the moments.
        environment: variables of the run.

    Returns:
        The rows in the file after each kill.
    """
    rng, after_kills = random.Random(seed), []
    for k in range(kills):
        goal, end = (math.ceil(rows * (k + x) / (kills + 1)) for x in (rng.random(), 1.0))
        process = start_held(end, module, words, environment)
        wait_until_true(lambda p=process, g=goal: covered() >= g or p.poll() is not None)
        time.sleep(rng.random() * 0.03)
        assert process.poll() is None, process.communicate()
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        after_kills.append(covered())
    last = start_held(rows + 1, module, words, environment)
    _, errors = last.communicate(timeout=HANGS)
    assert last.returncode == 0, errors
    return after_kills


def start_held(
    rows: int,
    module: str,
    words: Sequence[str],
    environment: dict[str, str],
) -> subprocess.Popen:
    """Start a run that waits once its file covers some rows, until its standard input ends.

    Args:
        rows: a number of rows.
        module: name of the module that runs it: `tests.support.held_runs` or another with the
            same first argument.
        words: its other arguments.
        environment: variables of the run.
    """
    return subprocess.Popen(
        [sys.executable, "-m", module, str(rows), *words],
        env=os.environ | environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        # A shell starts what runs in the background with interrupts ignored; Ctrl-C goes to
        # all processes of a session.
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def paths_of(root: Path) -> dict[str, str]:
    """The variables with which a command finds the product and the tests."""
    return {"PYTHONPATH": str(root)}
