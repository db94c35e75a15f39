"""Options, argument types and error lines that several commands share."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

from balance.files import check_outputs, is_stream
from kinematics.errors import LinkageError
from kinematics.models import find
from kinematics.reader.markup import shown
from kinematics.reader.sidecar import beside

__all__ = [
    "add_model_options",
    "check_files",
    "page_path",
    "picture_path",
    "unexpected",
    "whole_number",
]

# Options that name files to write and to read, of any command.
WRITTEN = {"out": "--out", "html": "--html", "plot": "--plot", "write_closed": "--write-closed"}
MODELS, READ = ("model", "against"), ("loops", "csv", "path")


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that every command on a model shares."""
    parser.add_argument(
        "model",
        help="path of a URDF file, a name from 'balance models', or a robot of "
        "example-robot-data if that is installed",
    )
    parser.add_argument(
        "--loops", metavar="FILE",
        help="YAML file that describes the loops; by default the one next to the URDF file",
    )  # fmt: skip
    parser.add_argument(
        "--fix-base", action="store_true", help="fix a base that floats to the ground"
    )
    parser.add_argument(
        "--bodies", choices=("given", "all"), default="given",
        help="all: links without mass in the file carry parameters too",
    )  # fmt: skip
    parser.add_argument(
        "--massless", type=_names, default=[], metavar="L1,L2",
        help="links that carry no parameters, whatever the file says",
    )  # fmt: skip
    reading = parser.add_mutually_exclusive_group()
    reading.add_argument(
        "--nominal", dest="angles", action="store_const", const="nominal", default="nominal",
        help="read angles that look rounded, such as 1.5708, as the multiples of π/12 they "
        "round (the default)",
    )  # fmt: skip
    reading.add_argument(
        "--as-written", dest="angles", action="store_const", const="as_written",
        help="take all angles and axes by their digits, in loops that do not quite close too",
    )  # fmt: skip
    parser.add_argument(
        "--inputs", type=_names, metavar="J1,J2",
        help="joints to use as independent coordinates",
    )  # fmt: skip
    parser.add_argument(
        "--motion", action="append", metavar="RELATION",
        help="linear relation of input displacements: j4=j7, j4=-2*j7, j3=0; repeatable",
    )  # fmt: skip
    parser.add_argument(
        "--balance", choices=("dynamic", "force"), default="dynamic",
        help="force: linear momentum only",
    )  # fmt: skip
    parser.add_argument(
        "--spatial", action="store_true", help="ten parameters per body, even if it is planar"
    )
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--force", action="store_true",
        help="let a file that is written replace one that is read, such as the model",
    )  # fmt: skip


def check_files(arguments: argparse.Namespace) -> None:
    """Refuse to write where a command reads, or one file twice; see `check_outputs`.

    Raises:
        UsageError: the options ask for that.
    """
    given = {name: path for name, path in vars(arguments).items() if isinstance(path, str)}
    outputs = {WRITTEN[name]: path for name, path in given.items() if name in WRITTEN}
    if not outputs:
        return
    inputs = [given[name] for name in READ if name in given]
    for name in MODELS:
        # A model that cannot be read is told of by whoever reads it.
        with suppress(LinkageError, OSError, ValueError):
            path = str(find(given[name])) if name in given else ""
            inputs += [path, *filter(None, [beside(path)])] if path else []
    check_outputs(outputs, inputs, arguments.force)


def _names(text: str) -> list[str]:
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of names: write a,b")
    return names


def whole_number(lowest: int, highest: int, what: str = "a number") -> Callable[[str], int]:
    """What reads a whole number between two others, these included.

    It raises ArgumentTypeError for any other word.
    """

    def read(text: str) -> int:
        digits = text.isascii() and text.isdigit() and len(text) <= 18
        number = int(text) if digits else lowest - 1
        if not lowest <= number <= highest:
            raise argparse.ArgumentTypeError(
                f"'{text}' is not {what} from {lowest} to {highest}"
            )
        return number

    return read


def picture_path(text: str) -> str:
    """A word that names a picture.

    Raises:
        ArgumentTypeError: by its end it is none.
    """
    if not text.lower().endswith((".png", ".svg")):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .png nor in .svg")
    return text


def page_path(text: str) -> str:
    """A word that names a page.

    Raises:
        ArgumentTypeError: by its end it is none, nor is it a pipe or a device.
    """
    if not (text.lower().endswith((".html", ".htm")) or is_stream(Path(text))):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .html nor in .htm")
    return text


def unexpected(error: Exception, words: Sequence[str]) -> str:
    """One line about an unexpected error: its type and message, the command, the remedy.

    Args:
        error: the exception.
        words: the arguments of the command, without the name of the program.
    """
    what = shown(" ".join(f"{type(error).__name__}: {error}".split()), 500).rstrip(": ")
    command = shown(shlex.join(["balance", *words]), 500)
    return (
        f"balance: unexpected {what}; this is a defect of balance, not of what was asked: "
        f"please report it with the file and the command {command} (BALANCE_DEBUG=1 shows "
        "where it happened)"
    )
