"""Options, argument types and error lines that several commands share."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import NoReturn

from balance.atomic_files import check_outputs, is_stream
from kinematics.errors import LinkageError

__all__ = [
    "LONGEST", "Parser", "add_model_options", "check_files", "page_path", "picture_path",
    "take_streams", "unexpected", "whole_number",
]  # fmt: skip

# Options that name files to write and to read, of any command.
WRITTEN = {
    "out": "--out", "html": "--html", "plot": "--plot", "write_closed": "--write-closed",
    "table": "--table",
}  # fmt: skip
MODELS, READ = ("model", "against"), ("loops", "csv", "path")

LONGEST = 20_000
"""Most characters of an error message."""


class Parser(argparse.ArgumentParser):
    """A parser that reports a wrong argument in one line, whatever characters it has."""

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str], namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse arguments; refuse ``--option=--``, which Python 3.11 reads as a list."""
        for name in (word[:-3] for word in args if word.startswith("--")
                     and word.endswith("=--")):  # fmt: skip
            self.error(f"argument {name}: expected one argument")
        return super().parse_known_args(args, namespace)

    def error(self, message: str) -> NoReturn:
        """End the command with code 2."""
        from kinematics.urdf.xml_tree import shown

        super().error(shown(message, LONGEST))


def add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that every command on a model shares."""
    parser.add_argument(
        "model",
        help="path of a URDF file, - for standard input, a name from 'balance models', or a "
        "robot of example-robot-data if that is installed",
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
        "--at", type=_coordinates, metavar="J1=VALUE,…",
        help="another reference pose than that of the file: coordinates of inputs counted from "
        "the pose of the file, in radians and metres (u1=0.3,u2=-0.1); the others follow, and "
        "displacements count from there",
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
    # Words that exclude each other are usage.
    parser.set_defaults(refuse=parser.error)


def take_streams(arguments: argparse.Namespace) -> None:
    """Read the models that come through streams, each of which can be read only once.

    Args:
        arguments: the options of a command; documents take the place of such models.

    Raises:
        FileError: one cannot be read, or is longer than a file may be.
        SystemExit: two models come through one stream.
    """
    named = {role: getattr(arguments, role, None) for role in ("model", "against")}
    models = {role: model for role, model in named.items() if model is not None}
    if not models:
        return
    from kinematics.urdf.input_streams import stream_of, streamed

    streams = [stream for model in models.values() if (stream := stream_of(model))]
    if len(set(streams)) < len(streams):
        arguments.refuse("--against: both models come from the same stream: give two files")
    for role, model in models.items():
        setattr(arguments, role, streamed(model) or model)


def check_files(arguments: argparse.Namespace) -> None:
    """Refuse to write where a command reads, or one file twice; see `check_outputs`.

    Raises:
        UsageError: the options ask for that.
    """
    given = {name: path for name, path in vars(arguments).items() if isinstance(path, str)}
    outputs = {WRITTEN[name]: path for name, path in given.items() if name in WRITTEN}
    if not outputs:
        return
    from kinematics.model_gallery import find
    from kinematics.urdf.loop_file import beside

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


def _coordinates(text: str) -> dict[str, float]:
    """Values by name, of ``u1=0.3,u2=-0.1``."""
    words = [word.rpartition("=") for word in text.split(",")]
    names = [name.strip() for name, *_ in words]
    try:
        values = [float(value) for *_, value in words]
    except ValueError:
        values = [math.nan]
    if not all(names) or len(set(names)) < len(names) or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"'{text}' is not u1=0.3,u2=-0.1 with each input once")
    return dict(zip(names, values, strict=True))


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
    if not (text.lower().endswith((".html", ".htm")) or is_stream(text)):
        raise argparse.ArgumentTypeError(f"'{text}' ends neither in .html nor in .htm")
    return text


def unexpected(error: Exception, words: Sequence[str]) -> str:
    """One line about an unexpected error: its type and message, the command, the remedy.

    Args:
        error: the exception.
        words: the arguments of the command, without the name of the program.
    """
    import shlex

    from kinematics.urdf.xml_tree import shown

    what = shown(" ".join(f"{type(error).__name__}: {error}".split()), 500).rstrip(": ")
    command = shown(shlex.join(["balance", *words]), 500)
    return (
        f"balance: unexpected {what}; this is a defect of balance, not of what was asked: "
        f"please report it with the file and the command {command} (BALANCE_DEBUG=1 shows "
        "where it happened)"
    )
