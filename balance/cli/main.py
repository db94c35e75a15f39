"""The command line: the only place that prints, and the only one with exit codes.

0 done, 1 a negative verdict, 2 usage, 3 bad input or a refused mechanism, 4 undecided, 70 a
defect of this program, 130 interrupted.
"""

from __future__ import annotations

import argparse
import io
import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING

from balance.cli import design as designing
from balance.cli import motion as moving
from balance.cli import report as reporting
from balance.cli import verify as verifying
from balance.cli.arguments import (
    LONGEST,
    Parser,
    add_model_options,
    check_files,
    take_streams,
    unexpected,
)
from balance.cli.rounded_angles import with_both
from balance.cli.spinner import spinner
from kinematics.compiled.background import mode
from kinematics.errors import ExactError, LinkageError, UsageError

if TYPE_CHECKING:
    from balance.cli.verify import Verified
    from balance.exact.ranks import Exact
    from balance.interpretation.explain import Explanation
    from balance.spaces.design_space_result import DesignSpace
    from balance.taylor_poses.prediction import Predictions
    from kinematics.model.linkage import Linkage, Notice

__all__ = ["main"]

EXIT_CODES = (
    "Exit codes: 0 done, 1 a negative verdict, 2 usage, 3 bad input or a refused mechanism, "
    "4 undecided, 70 a defect of this program (one line says what; BALANCE_DEBUG=1 shows "
    "where), 130 interrupted."
)
FINDING = "finding the mass distributions that balance"
DONE, NEGATIVE, USAGE, REFUSED, UNDECIDED, DEFECT, INTERRUPTED = 0, 1, 2, 3, 4, 70, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: words of the command line, without the name of the program.

    Returns:
        The exit code.
    """
    # Matrices are small: a pool of threads would cost more than it gains.
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
    """Prints records on standard error, as it stands when they come."""

    def emit(self, record: logging.LogRecord) -> None:
        """Print one line."""
        print(self.format(record), file=sys.stderr)


def _run(argv: Sequence[str] | None, debug: bool) -> int:
    """Run one command; returns its exit code, and prints one line where it fails."""
    words = sys.argv[1:] if argv is None else argv
    try:
        mode()  # refuses an unknown BALANCE_COMPILE before any work
        arguments = _parser().parse_args(words)
        check_files(arguments)
        take_streams(arguments)
        return int(arguments.run(arguments))
    except SystemExit as stop:
        return int(stop.code or 0)
    except LinkageError as error:
        from kinematics.urdf.xml_tree import shown

        text = "; ".join([str(error), *getattr(error, "__notes__", ())])
        print(f"balance: {shown(text, LONGEST)}", file=sys.stderr)
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
        print(unexpected(error, words), file=sys.stderr)
        return DEFECT


class _Version(argparse.Action):
    """Prints the version, which is imported only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        """End the command with code 0."""
        from kinematics.version import __version__

        print(f"balance {__version__}")
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    parser = Parser(
        prog="balance", description="Dynamic balance of linkages.", epilog=EXIT_CODES
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="show the version and exit")
    verbs = parser.add_subparsers(metavar="command", required=True)

    report = verbs.add_parser(
        "report",
        help="rank and dimension of the balanced design space, by order",
        description="Which mass distributions leave a linkage balanced: rank and dimension "
        "of the design space, order by order.",
    )
    add_model_options(report)
    reporting.add_options(report)
    report.set_defaults(run=_report)

    verify = verbs.add_parser(
        "verify",
        help="shaking force and moment over finite motions, by an independent program",
        description="Whether a linkage with the masses of its file shakes its base: base "
        "reaction without gravity, by Pinocchio and by our own series. Exits with 0 if it is "
        "balanced, 1 if not, 4 if the two disagree. All six components are always computed: "
        "--spatial changes nothing here.",
    )
    add_model_options(verify)
    verifying.add_options(verify)
    verify.set_defaults(run=_verify)

    design = verbs.add_parser(
        "design",
        help="a mass distribution that can be built and does not shake, or why there is none",
        description="Masses, centres of mass and inertias that balance a linkage and that "
        "bodies can have, or a certificate that there are none. Exits with 0 if there is a "
        "design, 1 if there is none, 4 if that is undecided.",
    )
    add_model_options(design)
    designing.add_options(design)
    design.set_defaults(run=_design, max_order=None)

    motion = verbs.add_parser("motion", help=moving.HELP, description=moving.DESCRIPTION)
    add_model_options(motion)
    moving.add_options(motion)
    motion.set_defaults(run=_motion)

    models = verbs.add_parser("models", help="list the linkages that come with the package")
    models.add_argument("--json", action="store_true", help="print one JSON object")
    models.set_defaults(run=_models)
    return parser


def _load(arguments: argparse.Namespace, angles: str, other: str = "") -> Linkage:
    """The linkage that the shared options describe, with rounded angles read as told.

    ``other`` is the path or name of another model, to be read with the same options.
    """
    from kinematics.model_gallery import load

    return load(
        other or arguments.model, None if other else arguments.loops, arguments.inputs,
        fix_base=arguments.fix_base, bodies=arguments.bodies, massless=arguments.massless,
        angles=angles, at=arguments.at,
    )  # fmt: skip


def _space(arguments: argparse.Namespace, angles: str) -> DesignSpace:
    """The design space that the options describe, with rounded angles read as told."""
    linkage = _load(arguments, angles)
    # The file has been accepted; only now is it worth loading the kernels.
    from balance.certification.certify_space import certify
    from balance.spaces.compute import design_space

    space = design_space(
        linkage, arguments.motion, arguments.balance, arguments.max_order,
        spatial=arguments.spatial,
    )  # fmt: skip
    return certify(space)


def _report(arguments: argparse.Namespace) -> int:
    with spinner(FINDING):
        space = with_both(partial(_space, arguments), arguments.angles)
        space, exact = _exactly(space) if arguments.exact else (space, None)
        explanation = space.explain() if arguments.explain else None
        told = reporting.write_files(arguments, space, explanation)
    from balance.report.text.report import text

    _warn((*space.warnings, *(exact.notices if exact else ()), *told))
    if arguments.json:
        print(_json(space.to_dict(explanation, exact)))
    elif sys.stdout.isatty():
        _show(space, explanation, exact)
    else:
        print(text(space, explanation, exact))
    refused = arguments.exact and exact is None
    return DONE if _sure(space, arguments) and not refused else UNDECIDED


def _design(arguments: argparse.Namespace) -> int:
    with spinner(FINDING):
        space = with_both(partial(_space, arguments), arguments.angles)
        found = designing.designed(arguments, space)
    told = designing.write_files(arguments, found)
    _warn(space.warnings)
    if told:
        logging.warning(told)
    if arguments.json:
        print(_json(found.to_dict()))
    else:
        from balance.report.text.design import text

        print(text(found))
    return {"feasible": DONE, "infeasible": NEGATIVE}.get(found.verdict, UNDECIDED)


def _verify(arguments: argparse.Namespace) -> int:
    with verifying.progress() as progress:
        found = verifying.verified(arguments, partial(_load, arguments), progress)
    _tell(found, found.text, arguments)
    if not found.first.agreed:
        return UNDECIDED
    return DONE if found.first.balanced else NEGATIVE


def _motion(arguments: argparse.Namespace) -> int:
    with spinner("expanding the motion"):
        found = moving.foretold(arguments, partial(_load, arguments))
    from balance.report.text.motion import text

    _tell(found, partial(text, found), arguments)
    return DONE if found.reached else NEGATIVE


def _tell(
    found: Verified | Predictions, text: Callable[[], str], arguments: argparse.Namespace
) -> None:
    """What was found, as text or as JSON, and what there is to tell of it."""
    _warn(found.notices)
    print(_json(found.to_dict()) if arguments.json else text())


def _json(data: object) -> str:
    """Data as the one JSON object that a command prints."""
    from balance.json_text import json_text

    return json_text(data, 2)


def _warn(notices: Iterable[Notice]) -> None:
    """What there is to tell beside an answer."""
    for notice in notices:
        logging.warning("%s: %s", notice.code, notice.message)


def _exactly(space: DesignSpace) -> tuple[DesignSpace, Exact | None]:
    """The exact ranks; where there can be none, the space has one more notice, of why."""
    try:
        return space, space.exact()
    except ExactError as error:
        from dataclasses import replace

        from kinematics.model.linkage import Notice

        notice = Notice("exact_refused", str(error))
        return replace(space, notices=(*space.notices, notice)), None


def _sure(space: DesignSpace, arguments: argparse.Namespace) -> bool:
    """Whether the answer is sure, and as certain as the user wants it; says so if it is not."""
    from balance.spaces.certainty import LEVELS

    certainty = space.certainty
    complete = space.settled or arguments.max_order is not None
    enough = LEVELS.index(certainty.level) >= LEVELS.index(arguments.require or LEVELS[0])
    if not enough:
        from kinematics.model.linkage import Notice

        text = f"the answer is {certainty.level}, not {arguments.require}: {certainty.reason}"
        _warn([Notice("required", text)])
    return complete and not certainty.doubts and enough


def _show(space: DesignSpace, explanation: Explanation | None, exact: Exact | None) -> None:
    """The report on a terminal."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    from balance.report.text.report import facts, meaning, table

    summary = Table.grid(padding=(0, 2))
    for label, value in facts(space):
        summary.add_row(f"[bold]{label}", escape(value))
    head, *rows = table(space, exact)
    orders = Table(*head)
    for row in rows:
        orders.add_row(*row)
    console = Console()
    console.print(summary)
    console.print(orders)
    for title, pairs in meaning(explanation) if explanation else []:
        section = Table("", "", title=title, title_justify="left", show_header=False)
        for left, right in pairs:
            section.add_row(escape(left), escape(right))
        console.print(section)


def _models(arguments: argparse.Namespace) -> int:
    from kinematics.model_gallery import describe, gallery

    found = {name: describe(path) for name, path in gallery().items()}
    if arguments.json:
        print(_json({"schema": "balance.models/1", "models": found}))
    else:
        width = max(map(len, found), default=0)
        print("\n".join(f"{name:<{width}}  {line}" for name, line in found.items()))
    return DONE
