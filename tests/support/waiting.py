"""Waiting for events in other processes, however slow the machine is."""

from __future__ import annotations

import time
from collections.abc import Callable

# Seconds after which nothing will happen any more.
HANGS = 1500.0


def wait_until_true(condition: Callable[[], object]) -> None:
    """Wait until a condition holds."""
    end = time.monotonic() + HANGS
    while not condition():
        assert time.monotonic() < end, "it does not happen"
        time.sleep(0.02)
