"""The command line: parser, output and exit code.

Each command computes an `Answer`. This module writes its files, prints it and returns the exit
code; no other module prints.
"""

from __future__ import annotations

import argparse
import io
import logging
import os
import sys
import warnings
from collections.abc import Collection, Sequence
from importlib import import_module
from typing import TYPE_CHECKING

from balance.app.cli.arguments import (
    MAX_ERROR_LENGTH,
    Parser,
    describe_defect,
    read_streams,
)
from balance.app.cli.completion import SHELLS
from balance.app.cli.exit_codes import (
    DEFECT,
    DONE,
    EXPLANATION,
    INTERRUPTED,
    REFUSED,
    USAGE,
)
from balance.app.cli.memory_notice import memory_notice
from balance.app.cli.outputs import check_files, write_outputs
from kinematics.errors import LinkageError, UsageError
from kinematics.numerics.compiled.background import compile_mode

if TYPE_CHECKING:
    from balance.app.answers.answer import Answer


# What each command does, in the order of the help. Its module has its options, in a function
# `add_…`, and is imported only for that command.
COMMANDS = {
    "report": "rank and dimension of the balanced design space, by order",
    "verify": "shaking force and moment over finite motions, by an independent program",
    "design": "a mass distribution that can be built and does not shake, or why there is none",
    "remedies": "what to build into a linkage that no masses balance, and what each remedy "
    "costs",
    "flex": "links that bend: modes, supports, similar counter-arms, simulation",
    "motion": "all joints as polynomials in the inputs, poses that they predict, and their "
    "error",
    "paths": "paths along which a linkage leaves its base at rest",
    "sweep": "a study of many geometries, kept in a file",
    "discover": "a search for geometries that balance where others do not",
    "synthesize": "a balanced mechanism whose tool passes through positions",
    "formulas": "conditions of balance as formulas in the dimensions of a planar linkage",
    "models": "list the linkages that come with the package",
}


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
            warnings.showwarning = _log_warning
        return _run(argv, debug)


def _log_warning(
    message: Warning | str, category: type[Warning], *_: object, **__: object
) -> None:
    """Log a warning of a library in one line, without the line of its source."""
    logging.warning("%s: %s", category.__name__, " ".join(str(message).split()))


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
        arguments = command_parser(words).parse_args(words)
        check_files(arguments)
        read_streams(arguments)
        with memory_notice():
            answer: Answer = arguments.run(arguments)
        write_outputs(arguments, answer)
        _print(answer, arguments.json)
        return answer.code
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
        from balance.app.cli.completion import completion_script

        print(completion_script(command_parser(COMMANDS), str(shell)))
        parser.exit()


def command_parser(words: Collection[str]) -> argparse.ArgumentParser:
    """Build the parser.

    Args:
        words: of the command line; only commands among them get their options.

    Returns:
        The parser, which knows the names and summaries of all commands.
    """
    parser = Parser(
        prog="balance", description="Dynamic balance of linkages.", epilog=EXPLANATION
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    parser.add_argument(
        "--completion", action=_Completion, choices=SHELLS,
        help="print a script with which a shell completes commands and options, and exit",
    )  # fmt: skip
    commands = parser.add_subparsers(metavar="command", required=True)
    for name, summary in COMMANDS.items():
        command = commands.add_parser(name, help=summary)
        if name in words:
            getattr(import_module(f"balance.app.cli.{name}"), f"add_{name}")(command)
    return parser


def _print(answer: Answer, as_json: bool) -> None:
    """Print the notices of a command on standard error, and its answer."""
    for notice in answer.notices:
        logging.warning("%s: %s", notice.code, notice.message)
    if answer.remark:
        logging.warning(answer.remark)
    if as_json:
        from balance.support.json_text import json_text

        print(json_text(answer.data(), 2))
        return
    from balance.app.answers.text.render import body_text, styled_text

    if answer.styled and sys.stdout.isatty():
        print(styled_text(answer.body()), end="")
    else:
        print(body_text(answer.body()))
