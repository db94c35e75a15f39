"""Argparse types, checks of files and error lines that several commands share."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn, TypeAlias

from balance.atomic_files import check_outputs, is_stream
from kinematics.errors import LinkageError

__all__ = [
    "MAX_ERROR_LENGTH", "Parser", "Verbs", "add_meshes_option", "check_files", "page_path",
    "picture_path", "read_streams", "describe_defect",
]  # fmt: skip

# Options of all commands that name output files.
OUTPUTS = {
    "out": "--out", "html": "--html", "plot": "--plot", "write_closed": "--write-closed",
    "table": "--table", "motion_table": "--csv",
}  # fmt: skip
# Options that name models.
MODELS = ("model", "against")
# Options that name other input files.
INPUTS = ("loops", "csv", "path", "masses", "study", "results")

# The commands of a parser, as `argparse` types them.
Verbs: TypeAlias = "argparse._SubParsersAction[Parser]"

MAX_ERROR_LENGTH = 20_000
"""Most characters of an error message."""


class Parser(argparse.ArgumentParser):
    """A parser that reports a wrong argument in one line, with control characters removed."""

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str], namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse arguments; refuse what is left over, with the usage of this very command.

        Refuse ``--option=--`` too, which Python 3.11 parses as a list.

        Args:
            args: words of the command line.
            namespace: object for the values; a new one by default.

        Returns:
            The values, and no words: all are taken.
        """
        for name in (word[:-3] for word in args if word.startswith("--")
                     and word.endswith("=--")):  # fmt: skip
            self.error(f"argument {name}: expected one argument")
        found, left = super().parse_known_args(args, namespace)
        if left:
            self.error(f"unrecognized arguments: {' '.join(left)}")
        return found, left

    def error(self, message: str) -> NoReturn:
        """End the command with code 2."""
        from kinematics.error_text import clean

        super().error(clean(message, MAX_ERROR_LENGTH))


def add_meshes_option(parser: argparse.ArgumentParser) -> None:
    """Add the option that leaves the shapes of the file out of a page."""
    parser.add_argument(
        "--no-meshes", action="store_true",
        help="leave the shapes of the file (<visual>) out of the page, which is smaller then",
    )  # fmt: skip


def read_streams(arguments: argparse.Namespace) -> None:
    """Read the models that come through streams; a stream can be read only once.

    Args:
        arguments: the options of a command; documents replace such models.

    Raises:
        FileError: one cannot be read, or is longer than a file may be.
        SystemExit: two models come through one stream.
    """
    named = {role: getattr(arguments, role, None) for role in ("model", "against")}
    models = {role: model for role, model in named.items() if model is not None}
    others = getattr(arguments, "others", [])
    if not models:
        return
    from kinematics.urdf.input_streams import read_stream, stream_identity

    every = [*models.values(), *others]
    streams = [stream for model in every if (stream := stream_identity(model))]
    if len(set(streams)) < len(streams):
        word = "--against: both" if not others else "two"
        arguments.refuse(f"{word} models come from the same stream: give two files")
    for role, model in models.items():
        setattr(arguments, role, read_stream(model) or model)
    if others:
        arguments.others = [read_stream(model) or model for model in others]


def check_files(arguments: argparse.Namespace) -> None:
    """Refuse to write where a command reads, or one file twice; see `check_outputs`.

    Raises:
        UsageError: an output is an input, or two outputs are one file.
    """
    given = {name: path for name, path in vars(arguments).items() if isinstance(path, str)}
    outputs = {OUTPUTS[name]: path for name, path in given.items() if name in OUTPUTS}
    if not outputs:
        return
    from kinematics.model_gallery import find
    from kinematics.urdf.loop_file import loop_file_of

    inputs = [given[name] for name in INPUTS if name in given]
    models = [given[name] for name in MODELS if name in given]
    for model in (*models, *getattr(arguments, "others", ())):
        # Reading the model raises the error later.
        with suppress(LinkageError, OSError, ValueError):
            path = str(find(model)) if model else ""
            inputs += [path, *filter(None, [loop_file_of(path)])] if path else []
    check_outputs(outputs, inputs, arguments.force)


def picture_path(text: str) -> str:
    """Check that a word names a picture.

    Raises:
        ArgumentTypeError: it ends neither in .png nor in .svg.
    """
    if not text.lower().endswith((".png", ".svg")):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .png nor in .svg")
    return text


def page_path(text: str) -> str:
    """Check that a word names a page, a pipe or a device.

    Raises:
        ArgumentTypeError: it ends neither in .html nor in .htm, and is no stream.
    """
    if not (text.lower().endswith((".html", ".htm")) or is_stream(text)):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .html nor in .htm")
    return text


def describe_defect(error: Exception, words: Sequence[str]) -> str:
    """Describe an unexpected error in one line: type, message, command, and remedy.

    Args:
        error: the exception.
        words: the arguments of the command, without the name of the program.
    """
    import shlex

    from kinematics.error_text import clean

    what = clean(" ".join(f"{type(error).__name__}: {error}".split()), 500).rstrip(": ")
    command = clean(shlex.join(["balance", *words]), 500)
    return (
        f"balance: unexpected {what}; this is a defect of balance, not of what was asked: "
        f"please report it with the file and the command {command} (BALANCE_DEBUG=1 shows "
        "where it happened)"
    )
