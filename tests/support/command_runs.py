"""Commands run in this process, with their streams caught."""

from __future__ import annotations

import io
import logging
import warnings
from contextlib import redirect_stderr, redirect_stdout
from typing import NamedTuple

from balance.app.cli.main import main as run_command


class Outcome(NamedTuple):
    """What a command did."""

    code: int
    out: str
    err: str


def asked(words: list[str]) -> Outcome:
    """Run one command with its streams caught; warnings of libraries are shown, as to users."""
    out, err, root = io.StringIO(), io.StringIO(), logging.getLogger()
    kept, root.handlers = root.handlers, []
    try:
        with redirect_stdout(out), redirect_stderr(err), warnings.catch_warnings():
            warnings.resetwarnings()
            code = run_command(words)
    finally:
        root.handlers = kept
    return Outcome(code, out.getvalue(), err.getvalue())
