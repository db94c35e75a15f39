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
from typing import TYPE_CHECKING, NamedTuple

from balance.app.cli.arguments import (
    MAX_ERROR_LENGTH,
    Parser,
    describe_defect,
    help_hint,
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
from kinematics.errors import LinkageError, PackageError, UsageError
from kinematics.numerics.compiled.background import compile_mode

if TYPE_CHECKING:
    from balance.app.answers.answer import Answer


class Command(NamedTuple):
    """A command in the list of `balance`.

    Attributes:
        summary: what it does.
        example: a command to copy.
    """

    summary: str
    example: str


# The commands in the order of the help. The module of each has its options, in a function
# `add_…`, and is imported only for that command.
COMMANDS = {
    "new": Command(
        "the file of a planar linkage from the points and links of a sketch",
        'balance new robot.urdf --points "A=0,0; B=0,0.3" --links "crank=A,B; base=A"',
    ),
    "report": Command(
        "which masses leave the base at rest: rank and dimension, by order",
        "balance report robot.urdf",
    ),
    "verify": Command(
        "shaking force and moment over motions, by an independent program",
        "balance verify robot.urdf --speed 300rpm",
    ),
    "identify": Command(
        "masses from measured motions and loads, as far as balance depends on them",
        "balance identify robot.urdf --motion motion.csv --wrench loads.csv",
    ),
    "design": Command(
        "masses of the links' own that can be built and do not shake, or why none do",
        "balance design robot.urdf --out balanced.urdf",
    ),
    "counterweights": Command(
        "the least matter that balances when it is added to links, or why none does",
        "balance counterweights robot.urdf --balance force --links crank,rocker",
    ),
    "reduce": Command(
        "the least shaking that so many kilograms buy, and what the motors pay",
        "balance reduce engine.urdf --links crank --region crank=80mm --budget 1.5",
    ),
    "remedies": Command(
        "what to build into a linkage that no masses balance, and what each costs",
        "balance remedies robot.urdf --html remedies.html",
    ),
    "springs": Command(
        "springs that balance gravity in every pose, or leave the least torque",
        "balance springs robot.urdf --between base,arm",
    ),
    "flex": Command(
        "links that bend: modes of a beam, supports, similar counter-arms, simulation",
        "balance flex simulate robot.urdf --flex coupler=EI:5,rhoA:1",
    ),
    "motion": Command(
        "all joints as polynomials in the inputs; poses, also of a tool",
        "balance motion robot.urdf --to u1=0.1,u2=0.2",
    ),
    "paths": Command(
        "paths along which a linkage leaves its base at rest",
        "balance paths robot.urdf --html paths.html",
    ),
    "quiet": Command(
        "the motion between two poses that shakes least, with the masses as they are",
        "balance quiet robot.urdf --to u1=0.5 --duration 0.8 --table quiet.csv",
    ),
    "sweep": Command(
        "one model in many geometries: what varies of it, and which one is the best",
        "balance sweep run robot.urdf --vary coupler.length=800mm:1200mm:10",
    ),
    "discover": Command(
        "a search for geometries that balance where others do not",
        "balance discover run --topology watt2 --starts 100",
    ),
    "synthesize": Command(
        "a balanced mechanism whose tool passes through positions",
        'balance synthesize --positions "0.3,0.1,11; 0.1,0.4,-40" --moving 0.2,-0.1',
    ),
    "formulas": Command(
        "conditions of balance as formulas in the dimensions of a planar linkage",
        "balance formulas robot.urdf --balance force",
    ),
    "models": Command("the linkages that come with the package", "balance models"),
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
    if not words:
        print(_jobs_text())
        return DONE
    try:
        compile_mode()  # refuses an unknown BALANCE_COMPILE before any work
        arguments = command_parser(words).parse_args(words)
        check_files(arguments)
        read_streams(arguments)
        with memory_notice():
            answer: Answer = arguments.run(arguments)
        write_outputs(arguments, answer)
        _print(answer, arguments.json, short=_program(words) != "balance report")
        return answer.code
    except SystemExit as stop:
        return int(stop.code or 0)
    except LinkageError as error:
        from kinematics.error_text import clean

        text = "; ".join([str(error), *getattr(error, "__notes__", ())])
        print(f"balance: {clean(text, MAX_ERROR_LENGTH)}", file=sys.stderr)
        if not isinstance(error, UsageError):
            return REFUSED
        if not isinstance(error, PackageError):
            print(help_hint(_program(words)), file=sys.stderr)
        return USAGE
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


def _jobs_text() -> str:
    """Write the list of commands, with an example of each."""
    lines = ["Dynamic balance of linkages. What is the job?", ""]
    for name, command in COMMANDS.items():
        lines += [f"{name:<16}{command.summary}", f"{'':<16}{command.example}"]
    return "\n".join([*lines, "", help_hint("balance COMMAND")])


def _program(words: Sequence[str]) -> str:
    """Return the program and its command among the words of a command line."""
    commands = [word for word in words if word in COMMANDS]
    return " ".join(["balance", *commands[:1]])


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
        "--completion",
        action=_Completion,
        choices=SHELLS,
        metavar="SHELL",
        help="print a script with which a shell completes words, and exit: bash, zsh or fish",
    )
    verbs = parser.add_subparsers(
        title="commands", metavar="command", prog=parser.prog, required=True
    )
    for name, command in COMMANDS.items():
        verb = verbs.add_parser(name, help=command.summary)
        if name in words:
            getattr(import_module(f"balance.app.cli.{name}"), f"add_{name}")(verb)
    return parser


def _print(answer: Answer, as_json: bool, short: bool) -> None:
    """Print the notices of a command on standard error, and its answer.

    Args:
        answer: the answer.
        as_json: whether it is printed as JSON.
        short: whether notices on the file are printed in short form.
    """
    notices = answer.notices
    if short and notices:
        from balance.app.cli.short_notices import shorten_notice

        notices = [shorten_notice(notice) for notice in notices]
    for notice in notices:
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
