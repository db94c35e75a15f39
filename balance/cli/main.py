"""The command line: parser, output and exit code.

Each command computes an `Outcome`. This module prints it and returns the exit code; no other
module prints.
"""

from __future__ import annotations

import argparse
import io
import logging
import os
import sys
import warnings
from collections.abc import Sequence

from balance.cli.arguments import (
    MAX_ERROR_LENGTH,
    Parser,
    check_files,
    describe_defect,
    read_streams,
)
from balance.cli.completion import SHELLS
from balance.cli.design import add_design
from balance.cli.discover import add_discover
from balance.cli.exit_codes import (
    DEFECT,
    DONE,
    EXPLANATION,
    INTERRUPTED,
    REFUSED,
    USAGE,
)
from balance.cli.flex import add_flex
from balance.cli.models import add_models
from balance.cli.motion import add_motion
from balance.cli.outcome import Outcome
from balance.cli.paths import add_paths
from balance.cli.remedies import add_remedies
from balance.cli.report import add_report
from balance.cli.sweep import add_sweep
from balance.cli.synthesize import add_synthesize
from balance.cli.verify import add_verify
from kinematics.compiled.background import compile_mode
from kinematics.errors import LinkageError, UsageError

__all__ = ["main"]


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: words of the command line, without the name of the program.

    Returns:
        The exit code.
    """
    # Matrices are small: threads of the linear algebra would cost more time than they save.
    for variable in ("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OMP_NUM_THREADS"):
        os.environ.setdefault(variable, "1")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    logging.basicConfig(format="%(message)s", handlers=[_StandardError()])
    debug = bool(os.environ.get("BALANCE_DEBUG"))
    with warnings.catch_warnings():
        if not debug:
            # Warnings of libraries are for programmers; those for users are notices.
            warnings.showwarning = lambda *_, **__: None
        return _run(argv, debug)


class _StandardError(logging.Handler):
    """Handler that prints records on the current standard error."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one line."""
        print(self.format(record), file=sys.stderr)


def _run(argv: Sequence[str] | None, debug: bool) -> int:
    """Run one command and return its exit code; print one line if it fails."""
    words = sys.argv[1:] if argv is None else argv
    try:
        compile_mode()  # refuses an unknown BALANCE_COMPILE before any work
        arguments = _parser().parse_args(words)
        check_files(arguments)
        read_streams(arguments)
        outcome: Outcome = arguments.run(arguments)
        _print(outcome, arguments.json)
        return outcome.code
    except SystemExit as stop:
        return int(stop.code or 0)
    except LinkageError as error:
        from kinematics.error_text import clean

        text = "; ".join([str(error), *getattr(error, "__notes__", ())])
        print(f"balance: {clean(text, MAX_ERROR_LENGTH)}", file=sys.stderr)
        return USAGE if isinstance(error, UsageError) else REFUSED
    except BrokenPipeError:
        sys.stderr.close()
        return DONE
    except KeyboardInterrupt:
        return INTERRUPTED
    except Exception as error:
        if debug:
            import traceback

            traceback.print_exc(file=sys.stderr)
        print(describe_defect(error, words), file=sys.stderr)
        return DEFECT


class _Version(argparse.Action):
    """Action that prints the version, imported on demand."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """End the command with code 0."""
        from kinematics.version import __version__

        print(f"balance {__version__}")
        parser.exit()


class _Completion(argparse.Action):
    """Action that prints the script with which a shell completes words."""

    def __call__(
        self, parser: argparse.ArgumentParser, _: object, shell: object, *__: object
    ) -> None:
        """End the command with code 0."""
        from balance.cli.completion import completion_script

        print(completion_script(parser, str(shell)))
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    """Build the parser with all commands."""
    parser = Parser(
        prog="balance", description="Dynamic balance of linkages.", epilog=EXPLANATION
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    parser.add_argument(
        "--completion", action=_Completion, choices=SHELLS,
        help="print a script with which a shell completes commands and options, and exit",
    )  # fmt: skip
    verbs = parser.add_subparsers(metavar="command", required=True)
    for add_command in (
        add_report, add_verify, add_design, add_remedies, add_flex, add_motion,
        add_paths, add_sweep, add_discover, add_synthesize, add_models,
    ):  # fmt: skip
        add_command(verbs)
    return parser


def _print(outcome: Outcome, as_json: bool) -> None:
    """Print the notices of a command on standard error, and its answer."""
    for notice in outcome.notices:
        logging.warning("%s: %s", notice.code, notice.message)
    if outcome.remark:
        logging.warning(outcome.remark)
    if as_json:
        from balance.json_text import json_text

        print(json_text(outcome.data(), 2))
    elif outcome.styled is not None and sys.stdout.isatty():
        print(outcome.styled(), end="")
    else:
        print(outcome.text())
