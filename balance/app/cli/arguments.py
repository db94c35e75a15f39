"""The parser, checks of options and error lines that all commands share."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias

if TYPE_CHECKING:
    from balance.app.answers.answer import Answer


# The commands of a parser, as `argparse` types them.
Verbs: TypeAlias = "argparse._SubParsersAction[Parser]"

MAX_ERROR_LENGTH = 20_000
"""Most characters of an error message."""


class Parser(argparse.ArgumentParser):
    """A parser that reports a wrong argument in one line, with control characters removed.

    Its commands refuse options by ``refuse``, and replace files that are read with ``force``.
    """

    def __init__(self, **options: Any) -> None:
        """Build a parser from the arguments of ``argparse.ArgumentParser``."""
        super().__init__(**options)
        self.set_defaults(refuse=self.error, force=False)

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
        values, extra = super().parse_known_args(args, namespace)
        if extra:
            self.error(f"unrecognized arguments: {' '.join(extra)}")
        return values, extra

    def error(self, message: str) -> NoReturn:
        """End the command with code 2."""
        from kinematics.error_text import clean

        super().error(clean(message, MAX_ERROR_LENGTH))


def add_json_option(
    parser: argparse.ArgumentParser, run: Callable[[argparse.Namespace], Answer]
) -> None:
    """Add ``--json``, and set the function that runs the command.

    Args:
        parser: the parser of the command.
        run: computes the answer from the options.
    """
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.set_defaults(run=run)


def refuse_given(
    arguments: argparse.Namespace, names: Sequence[str], reason: str, given: bool = True
) -> None:
    """End the command with code 2 if one of some options is given, or is not.

    Args:
        names: names of options, as attributes.
        reason: the message, with ``{}`` for the option.
        given: False to refuse what is not given.
    """
    for name in names:
        value = getattr(arguments, name)
        if (value is not None and value is not False and value != []) == given:
            arguments.refuse(reason.format(f"--{name.replace('_', '-')}"))


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
    from kinematics.files.urdf.input_streams import read_stream, stream_identity

    every = [*models.values(), *others]
    streams = [stream for model in every if (stream := stream_identity(model))]
    if len(set(streams)) < len(streams):
        word = "--against: both" if not others else "two"
        arguments.refuse(f"{word} models come from the same stream: give two files")
    for role, model in models.items():
        setattr(arguments, role, read_stream(model) or model)
    if others:
        arguments.others = [read_stream(model) or model for model in others]


def describe_defect(error: Exception, words: Sequence[str]) -> str:
    """Describe an unexpected error in one line: type, message, command, and remedy.

    Args:
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
