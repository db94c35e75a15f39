"""The parser, checks of options and error lines that all commands share."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Collection, Iterable, Sequence
from typing import TYPE_CHECKING, Any, NoReturn, TypeAlias

from balance.app.cli.exit_codes import USAGE

if TYPE_CHECKING:
    from balance.app.answers.answer import Answer


# The commands of a parser, as `argparse` types them.
Verbs: TypeAlias = "argparse._SubParsersAction[Parser]"

MAX_ERROR_LENGTH = 20_000
"""Most characters of an error message."""
# Title of the group of which the help has the names alone: another command explains them.
NAMED_ALONE = "file and motion (see balance report --help)"
# Groups of options, in the order of the help; before them, words without a group.
GROUPS = (
    "model",
    "study",
    NAMED_ALONE,
    "motion",
    "base",
    "matter",
    "formulas",
    "check",
    "run",
    "output",
)
# Words of other programs for an option of ours.
OTHER_WORDS = {
    "--rpm": "--speed",
    "--output": "--out",
    "--save": "--out",
    "--material": "--density",
    "--objective": "--minimise",
}
# Where the texts of options begin in the help.
HELP_COLUMN = 28


class HelpText(argparse.RawDescriptionHelpFormatter):
    """Help with one usage line, and without the second spelling of an option."""

    def __init__(self, prog: str) -> None:
        """Format the help of a program."""
        super().__init__(prog, max_help_position=HELP_COLUMN)
        self._heading: str | None = None

    def start_section(self, heading: str | None) -> None:
        """Begin a group of options."""
        self._heading = heading
        super().start_section(heading)

    def add_arguments(self, actions: Iterable[argparse.Action]) -> None:
        """Add the options of a group, of one group without their texts."""
        if self._heading == NAMED_ALONE:
            self.add_text(" ".join(action.option_strings[0] for action in actions))
        else:
            # The text of another option tells some of them beside it.
            super().add_arguments(x for x in actions if not getattr(x, "told_beside", False))

    def _fill_text(self, text: str, width: int, indent: str) -> str:
        """Wrap a description; keep the lines of examples."""
        if "\n" in text:
            return text
        return argparse.HelpFormatter._fill_text(self, text, width, indent)

    def _format_usage(
        self,
        usage: str | None,
        actions: Iterable[argparse.Action],
        groups: object,
        prefix: str | None,
    ) -> str:
        """Write the words that a command needs, in one line; with a prefix, it is a name."""
        needed = [x for x in actions if x.required or getattr(x, "asked_for", False)]
        named = [action for action in needed if action.option_strings]
        words = [
            self._prog,
            *(
                self._format_args(action, action.dest)
                for action in needed
                if not action.option_strings
            ),
        ]
        words += [self._format_action_invocation(action) for action in named]
        line = " ".join(words)
        return f"usage: {line} [options]\n" if prefix is None else f"{line}\n"

    def _format_action_invocation(self, action: argparse.Action) -> str:
        """Write the options of an action, and its values after the last of them."""
        values = "" if action.nargs == 0 else f" {self._format_args(action, action.dest)}"
        if not action.option_strings:
            return super()._format_action_invocation(action)
        return ", ".join(action.option_strings) + values


class Parser(argparse.ArgumentParser):
    """A parser that reports a wrong argument in two lines, with control characters removed.

    Its commands refuse options by ``refuse``, and replace files that are read with
    ``overwrite``. What to write in place of an option of another command is in ``elsewhere``.
    """

    def __init__(self, **options: Any) -> None:
        """Build a parser from the arguments of ``argparse.ArgumentParser``."""
        super().__init__(**{"formatter_class": HelpText} | options, add_help=False)
        self.group("output").add_argument("-h", "--help", action="help", help=argparse.SUPPRESS)
        self.set_defaults(refuse=self.error, overwrite=False)
        self.elsewhere: dict[str, str] = {}

    def group(self, title: str) -> argparse._ArgumentGroup:
        """Return the group of options with a title, of `GROUPS`, new at the first call."""
        named = [group for group in self._action_groups if group.title == title]
        return named[0] if named else self.add_argument_group(title)

    def add_examples(self, *examples: str) -> None:
        """Set the end of the help: commands to copy."""
        self.epilog = "\n  ".join(("examples:", *examples))

    def format_help(self) -> str:
        """Write the help: groups in the order of `GROUPS`, without blank lines between them."""
        self._action_groups.sort(
            key=lambda group: GROUPS.index(group.title) if group.title in GROUPS else -1
        )
        return re.sub(r"\n{2,}(?=\S.*:\n)", "\n", super().format_help())

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str], namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        """Parse arguments; refuse what is left over, with the usage of this very command.

        Refuse ``--option=--`` too, which Python 3.11 parses as a list, and a second
        ``--speed``, which would be that of another crank.

        Args:
            args: words of the command line.
            namespace: object for the values; a new one by default.

        Returns:
            The values, of which ``words`` are the words of a command after its name, and no
            words: all are taken.
        """
        for name in (
            word[:-3] for word in args if word.startswith("--") and word.endswith("=--")
        ):
            self.error(f"argument {name}: expected one argument")
        if [word.partition("=")[0] for word in args].count("--speed") > 1:
            self.error(
                "argument --speed: given twice: give that of one crank, and the ratio of "
                "others by --motion u2=u1, or --motion u2=-2*u1"
            )
        options = {name for action in self._actions for name in action.option_strings}
        for word in args:
            if f"-{word.partition('=')[0]}" in options:
                self.error(f"unrecognized arguments: {word} (did you mean '-{word}'?)")
        values, extra = super().parse_known_args(args, namespace)
        if extra:
            hint = self._hint(extra[0], args, options)
            self.error(f"unrecognized arguments: {' '.join(extra)}{hint}")
        if not hasattr(values, "words"):
            values.words = list(args)
        return values, extra

    def _hint(self, word: str, args: Sequence[str], options: Collection[str]) -> str:
        """Say what may have been meant by a word that no option takes, in parentheses."""
        from kinematics.error_text import did_you_mean

        name = word.partition("=")[0]
        alone = [str(action.metavar) for action in self._actions if not action.option_strings]
        if name in self.elsewhere:
            return f" ({self.elsewhere[name]})"
        if name.startswith("--") and name[2:].upper() in alone:
            return f" (write {name[2:].upper()} alone, without {name})"
        if OTHER_WORDS.get(name) in options:
            return f" (did you mean '{OTHER_WORDS[name]}'?)"
        option = args[max(args.index(word) - 2, 0)] if word in args else ""
        if not word.startswith("-") and option.startswith("--"):
            return f" ({option} takes one word: commas part values, quotes keep blanks)"
        return did_you_mean(name, options)

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a word that is none of the choices, and ask for the one that is like it."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            from kinematics.error_text import did_you_mean

            meant = did_you_mean(str(value), map(str, action.choices or ()))
            raise argparse.ArgumentError(action, f"{error.message}{meant}") from None

    def error(self, message: str) -> NoReturn:
        """End the command with code 2."""
        from kinematics.error_text import clean

        text = clean(message, MAX_ERROR_LENGTH)
        self.exit(USAGE, f"{self.prog}: error: {text}\n{help_hint(self.prog)}\n")


def help_hint(command: str) -> str:
    """Say where the words of a command are explained.

    Args:
        command: the program and its command, ``balance design``.
    """
    return f"{command} --help lists what there is"


def add_json_option(parser: Parser, run: Callable[[argparse.Namespace], Answer]) -> None:
    """Add ``--json``, and set the function that runs the command.

    Args:
        parser: the parser of the command.
        run: computes the answer from the options.
    """
    parser.group("output").add_argument(
        "--json", action="store_true", help="print one JSON object"
    )
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
