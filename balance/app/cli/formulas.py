"""The command ``balance formulas``: its options, and its answer."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import Parser
from balance.app.cli.exit_codes import DONE, UNDECIDED
from balance.app.cli.model_options import add_model_options, load_model
from balance.app.cli.number_arguments import positive_number
from balance.app.cli.outputs import add_page_option, result_files

if TYPE_CHECKING:
    from balance.space.formulas.formula_data import Formulas


def add_formulas(parser: Parser) -> None:
    """Add the options of the command ``formulas``."""
    parser.description = (
        "Derives the conditions of balance of a linkage as formulas in its dimensions, "
        "by exact arithmetic and interpolation, and checks them in other dimensions, other "
        "poses, and against the design space of the model. Exits with 0 if all are known and "
        "checked, 4 if not."
    )
    add_model_options(parser, unused=("--spatial",))
    parser.set_defaults(run=_run)
    group = parser.group("formulas")
    group.add_argument(
        "--where",
        action="append",
        default=[],
        metavar="RELATION",
        help="relation between distances of joints, by the letters that are printed: AB=CD, "
        "AB=2*CD; repeatable. Those of the model are used where they lower the rank",
    )
    group.add_argument(
        "--solve",
        type=_words,
        default=[],
        metavar="P1,P2",
        help="parameters to solve for, such as s_crank (default: those that leave the fewest "
        "terms)",
    )
    group.add_argument(
        "--notation",
        choices=("text", "latex", "python", "sympy"),
        default="text",
        help="text with a table of the dimensions (default), an align* environment of LaTeX, a "
        "Python function, or SymPy expressions",
    )
    group.add_argument(
        "--seconds",
        type=positive_number,
        metavar="S",
        help="return what is known after this time",
    )
    group.add_argument(
        "--buildable",
        action="store_true",
        help="the lengths, too, for which balanced masses can be built, proved; for conditions "
        "with one ratio of lengths",
    )
    add_page_option(parser, "with the drawing of the linkage, its dimensions and the formulas")


def _run(arguments: argparse.Namespace) -> Answer:
    """Derive the formulas of the options.

    Raises:
        LinkageError: the file, the linkage, a relation or a parameter cannot be used.
    """
    linkage = load_model(arguments, arguments.angles)
    from balance.app.answers.text.formulas import formulas_body
    from balance.space.formulas.derive import formulas
    from balance.space.formulas.formula_data import require_sympy

    if arguments.notation == "sympy":
        require_sympy("an expression")
    answer = formulas(
        linkage,
        arguments.balance,
        arguments.motion,
        where=arguments.where,
        solve=arguments.solve,
        seconds=arguments.seconds,
        buildable=arguments.buildable,
    )
    known = answer.bounds is None or answer.bounds.verdict != "unknown"
    return Answer(
        DONE if answer.confirmed and known else UNDECIDED,
        answer.to_dict,
        lambda: formulas_body(answer, arguments.notation),
        remark=_remark(answer),
        files=lambda: result_files(arguments, answer),
    )


def _remark(answer: Formulas) -> str:
    """Say why the formulas are not confirmed."""
    if answer.unknown:
        return f"{answer.unknown} conditions are missing: give more time (--seconds)"
    if not answer.confirmed:
        return "a check of the formulas failed: do not rely on them"
    if answer.bounds is not None and answer.bounds.verdict == "unknown":
        return f"bounds are {answer.bounds.text()}"
    return ""


def _words(text: str) -> list[str]:
    """Parse names of ``a,b``."""
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise argparse.ArgumentTypeError(f"'{text}' is not a list of parameters: write a,b")
    return names
