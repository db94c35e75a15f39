"""The command ``balance report``: its options, its answer, and the files that it writes."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from balance.atomic_files import write_all_atomic
from balance.cli.arguments import Verbs, page_path, whole_number
from balance.cli.exit_codes import DONE, UNDECIDED
from balance.cli.model_options import add_model_options, certified_space
from balance.cli.outcome import Outcome
from balance.cli.spinner import spinner
from kinematics.errors import ExactError

if TYPE_CHECKING:
    from balance.certification.certified_space import CertifiedSpace
    from balance.exact.modular_ranks import Exact
    from balance.interpretation.explain import Explanation
    from balance.spaces.design_space import DesignSpace
    from kinematics.model.linkage import Linkage, Notice

__all__ = ["add_report"]

# Most joints in a notice.
MAX_NAMES = 6


def add_report(verbs: Verbs) -> None:
    """Add the command ``report`` to the parser."""
    parser = verbs.add_parser(
        "report",
        help="rank and dimension of the balanced design space, by order",
        description="Which mass distributions leave a linkage balanced: rank and dimension "
        "of the design space, order by order.",
    )
    add_model_options(parser)
    parser.set_defaults(run=_run)
    parser.add_argument(
        "--max-order", type=whole_number(0, 50, "an order"), metavar="K",
        help="compute exactly the orders 0 to K, instead of as many as needed",
    )  # fmt: skip
    parser.add_argument(
        "--explain", action="store_true",
        help="say what may be moved across each joint, and what the loops add",
    )  # fmt: skip
    parser.add_argument(
        "--html", type=page_path, metavar="FILE.html",
        help="write a page with the moving linkage and all of this; it needs no network",
    )  # fmt: skip
    parser.add_argument(
        "--write-closed", metavar="FILE",
        help="write the URDF file at the pose at which its loops close",
    )  # fmt: skip
    parser.add_argument(
        "--exact", action="store_true",
        help="also compute the ranks by exact arithmetic, from the decimals of the file",
    )  # fmt: skip
    parser.add_argument(
        "--require", choices=("proved", "verified"),
        help="exit with 4 if the answer is less certain than that",
    )  # fmt: skip


def _run(arguments: argparse.Namespace) -> Outcome:
    """Compute the design space and the results of the options, and write the files."""
    with spinner("finding the mass distributions that balance"):
        space = certified_space(arguments)
        exact = None
        if arguments.exact:
            space, exact = _add_exact_ranks(space)
        explanation, change = _describe(space, arguments)
        file_notices = _write_files(arguments, space, explanation, change)
    from balance.report.data import Report, report_data
    from balance.report.text.report import report_for_terminal, report_text

    missing = _missing_certainty(space, arguments)
    notices = (*space.warnings, *(exact.notices if exact else ()), *file_notices, *missing)
    complete = space.settled or arguments.max_order is not None
    answered = exact is not None or not arguments.exact
    sure = complete and answered and not space.doubts and not missing
    report = Report(space, explanation if arguments.explain else None, exact, change)
    return Outcome(
        DONE if sure else UNDECIDED, lambda: report_data(report), lambda: report_text(report),
        lambda: report_for_terminal(report), notices,
    )  # fmt: skip


def _add_exact_ranks(space: CertifiedSpace) -> tuple[CertifiedSpace, Exact | None]:
    """Compute the exact ranks; a refusal becomes a notice of the space."""
    from dataclasses import replace

    from balance.certification.exact_ranks import exact_ranks
    from kinematics.model.linkage import Notice

    try:
        return space, exact_ranks(space)
    except ExactError as error:
        notice = Notice("exact_refused", str(error))
        return replace(space, notices=(*space.notices, notice)), None


def _describe(
    space: DesignSpace, arguments: argparse.Namespace
) -> tuple[Explanation | None, float]:
    """Compute the explanation, if it is needed, and the distance to a rank drop."""
    from balance.interpretation.explain import explain
    from balance.spaces.distance_to_rank_drop import distance_to_rank_drop

    wanted = arguments.explain or arguments.html is not None
    return explain(space) if wanted else None, distance_to_rank_drop(space)


def _missing_certainty(
    space: CertifiedSpace, arguments: argparse.Namespace
) -> tuple[Notice, ...]:
    """Return a notice if the answer is less certain than ``--require``."""
    from balance.spaces.certainty import LEVELS
    from kinematics.model.linkage import Notice

    certainty = space.certainty
    if LEVELS.index(certainty.level) >= LEVELS.index(arguments.require or LEVELS[0]):
        return ()
    text = f"the answer is {certainty.level}, not {arguments.require}: {certainty.reason}"
    return (Notice("required", text),)


def _write_files(
    arguments: argparse.Namespace,
    space: DesignSpace,
    explanation: Explanation | None,
    change: float,
) -> tuple[Notice, ...]:
    """Write the files that ``--html`` and ``--write-closed`` name: all of them, or none.

    Args:
        arguments: the options of the command.
        space: the design space.
        explanation: result of `balance.explain`; None without ``--explain`` and ``--html``.
        change: result of `balance.distance_to_rank_drop`.

    Returns:
        Notices about the files for the user.

    Raises:
        FileError: a file cannot be written, or the linkage was not read from a file.
    """
    from kinematics.model.linkage import Notice

    page, closed = arguments.html, arguments.write_closed
    contents, notices = [], []
    if closed is not None:
        from kinematics.urdf.write_closed_pose import write_at_reference_pose

        posed = write_at_reference_pose(space.linkage)
        contents.append((closed, posed.data))
        text = _describe_pose(space.linkage, dict(posed.moved))
        if posed.beside:
            text += "; its loops are in another file: give that with --loops"
        notices.append(Notice("closed_pose", f"{closed}: written {text}"))
    if page is not None and explanation is not None:
        from balance.report.html.report import report_page

        contents.append((page, report_page(space, explanation, change).encode()))
    write_all_atomic(contents)
    return tuple(notices)


def _describe_pose(linkage: Linkage, positions: dict[str, float]) -> str:
    """Describe the pose of the written file by the displacements of the joints."""
    from kinematics.model.full_turns import position_text, wrap_turns

    if not positions:
        return "as it was, for its loops close at its own pose"
    moved = [joint for joint in linkage.joints if joint.name in positions]
    within, _ = wrap_turns(moved, [positions[joint.name] for joint in moved])
    pairs = sorted(zip(moved, within.tolist(), strict=True), key=lambda pair: -abs(pair[1]))
    named = [f"{joint.name} by {position_text(joint, q, 6)}" for joint, q in pairs]
    more = f" and {len(named) - MAX_NAMES} more" if len(named) > MAX_NAMES else ""
    where = "the pose asked for" if linkage.at else "the pose at which its loops close"
    return (
        f"at {where}: only origins of joints differ, moved are "
        f"{', '.join(named[:MAX_NAMES])}{more}; limits of joints count from there"
    )
