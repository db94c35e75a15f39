"""The work of a function as the number of instructions that the interpreter executes."""

from __future__ import annotations

import sys
from collections.abc import Callable
from types import FrameType


def instructions(function: Callable[[], object]) -> int:
    """Count the instructions of Python code in a call, the same on every machine.

    What compiled code does is not counted.
    """
    count = 0

    def trace(frame: FrameType, event: str, _: object) -> Callable[..., object]:
        nonlocal count
        frame.f_trace_opcodes, frame.f_trace_lines = True, False
        count += event == "opcode"
        return trace

    before = sys.gettrace()
    sys.settrace(trace)
    try:
        function()
    finally:
        sys.settrace(before)
    return count
