"""The command ``balance report``: its options, and its answer."""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from balance.app.answers.answer import Answer, Files, side_by_side
from balance.app.cli.arguments import Parser
from balance.app.cli.exit_codes import DONE, UNDECIDED
from balance.app.cli.model_options import add_model_options, model_words
from balance.app.cli.model_readings import certified_space
from balance.app.cli.number_arguments import whole_number
from balance.app.cli.outputs import add_meshes_option, add_page_option
from balance.app.cli.progress import spinner
from balance.app.cli.requirement_options import (
    add_requirement_options,
    check_requirement_options,
)
from balance.app.cli.several_models import (
    add_other_models,
    compared,
    each_model,
    named_notices,
)
from kinematics.errors import ExactError, MeetingModesError

if TYPE_CHECKING:
    from balance.app.answers.data import Report
    from balance.masses.mode_answers import ModeAnswers
    from balance.space.certification.certified_space import CertifiedSpace
    from balance.space.exact.modular_ranks import ExactRanks
    from balance.space.spaces.design_space import DesignSpace
    from kinematics.model.document.element import Document
    from kinematics.model.linkage import Linkage, Notice


# Most joints in a notice.
MAX_NAMES = 6
# Options that need one design space: where modes of motion meet, they need --mode.
OF_ONE_MODE = (
    "explain",
    "decoupled",
    "pure_inertia",
    "html",
    "write_closed",
    "exact",
    "require",
)
# The notice on the pose of each mode, which the table gives.
MODE_NOTICE = "mode_of_motion"


def add_report(parser: Parser) -> None:
    """Add the options of the command ``report``."""
    parser.description = (
        "Which mass distributions leave a linkage balanced: rank and dimension "
        "of the design space, order by order."
    )
    add_model_options(parser, explain=True)
    add_requirement_options(parser)
    add_other_models(parser)
    parser.set_defaults(run=_run)
    parser.group("motion").add_argument(
        "--max-order",
        type=whole_number(0, 50, "an order"),
        metavar="K",
        help="the orders 0 to K, instead of as many as needed",
    )
    _add_question_options(parser.group("check"))
    add_page_option(parser, "with the moving linkage")
    add_meshes_option(parser)
    parser.group("output").add_argument(
        "--write-closed", metavar="FILE", help="write the file with its loops closed"
    )
    parser.add_examples(
        "balance report robot.urdf",
        'balance report robot.urdf --motion "u2=u3" --explain',
        "balance report robot.urdf --certainty verified --html page.html",
    )


def _add_question_options(group: argparse._ArgumentGroup) -> None:
    """Add the options for what else is computed."""
    group.add_argument(
        "--explain", action="store_true", help="what may be moved across each joint"
    )
    group.add_argument(
        "--decoupled", action="store_true", help="is the inertia on the base constant too?"
    )
    group.add_argument(
        "--pure-inertia",
        action="store_true",
        help="move the point masses of a planar linkage away",
    )
    group.add_argument(
        "--exact", action="store_true", help="also by exact arithmetic, from the decimals"
    )
    group.add_argument(
        "--certainty",
        choices=("proved", "verified"),
        metavar="LEVEL",
        help="exit with 4 if less certain: proved, verified",
    )


def _run(arguments: argparse.Namespace) -> Answer:
    """Compute the design space and the results of the options."""
    others = ("max_order", "explain", "decoupled", "pure_inertia", "html", "exact")
    check_requirement_options(arguments, others)
    if arguments.others:
        return _run_several(arguments)
    with spinner("finding the mass distributions that balance"):
        try:
            report, code, notices = _report(arguments)
        except MeetingModesError as error:
            return _answer_modes(error, arguments)
    from balance.app.answers.data import report_data
    from balance.app.answers.text.report import report_body

    closed: Files = {}
    if arguments.write_closed is not None:
        posed, notice = _closed_pose(report.space.linkage, arguments.write_closed)
        closed, notices = {"write_closed": lambda: posed}, (*notices, notice)

    def prepare_files() -> Files:
        from balance.app.answers.html.report import report_page

        return {"html": partial(report_page, report, not arguments.no_meshes), **closed}

    shown = report if arguments.explain else report._replace(explanation=None)
    return Answer(
        code,
        lambda: report_data(shown),
        lambda: report_body(shown),
        notices,
        files=prepare_files,
        styled=True,
    )


def _run_several(arguments: argparse.Namespace) -> Answer:
    """Compute the design spaces of several models."""
    if arguments.write_closed is not None:
        arguments.refuse("--write-closed: not with several models")
    with spinner("finding the mass distributions that balance"):
        answers = [_report(each) for each in each_model(arguments)]
    from balance.app.answers.data import report_data
    from balance.app.answers.text.report import comparison_facts

    reports = [answer.report for answer in answers]

    def prepare_files() -> Files:
        from balance.app.answers.html.compare import compare_page

        return {"html": partial(compare_page, reports, not arguments.no_meshes)}

    return Answer(
        max(answer.code for answer in answers),
        lambda: compared("report", list(map(report_data, reports))),
        lambda: side_by_side(list(map(comparison_facts, reports))),
        named_notices((answer.report.space.linkage, answer.notices) for answer in answers),
        files=prepare_files,
    )


def _answer_modes(error: MeetingModesError, arguments: argparse.Namespace) -> Answer:
    """Compute the design space on every mode that meets at the pose of the file.

    Raises:
        MeetingModesError: an option asks for more than the table of the modes.
    """
    if any(getattr(arguments, name) for name in OF_ONE_MODE):
        raise error
    from balance.app.answers.text.modes import modes_body
    from balance.masses.mode_answers import answer_modes
    from kinematics.files.urdf.rounded_angles import ROUNDED_ANGLES
    from kinematics.model.linkage import Notice

    options = {
        "motion": arguments.motion,
        "balance": arguments.balance,
        "max_order": arguments.max_order,
        "spatial": arguments.spatial,
    }
    answers = answer_modes(error.modes, options, error.doubt)
    missing = [
        notice._replace(message=f"mode {each.mode.number}: {notice.message}")
        for each in answers.modes
        if each.space is not None
        for notice in _missing_certainty(each.space, arguments)
    ]
    sure = answers.sure and not missing
    readings = [Notice(ROUNDED_ANGLES, note) for note in getattr(error, "__notes__", ())]
    return Answer(
        DONE if sure else UNDECIDED,
        answers.to_dict,
        lambda: modes_body(answers),
        (*readings, *_warnings_of_modes(answers), *missing),
    )


def _warnings_of_modes(answers: ModeAnswers) -> list[Notice]:
    """List the warnings on each mode, with its number where not all modes have it."""
    spaces = {each.mode.number: each.space for each in answers.modes if each.space is not None}
    common = [set(space.warnings) for space in spaces.values()]
    shared = set.intersection(*common) if common else set()
    listed = dict.fromkeys(
        notice
        if notice in shared
        else notice._replace(message=f"mode {number}: {notice.message}")
        for number, space in spaces.items()
        for notice in space.warnings
        if notice.code != MODE_NOTICE
    )
    return list(listed)


class _ModelReport(NamedTuple):
    """The report on one model, the exit code, and notices."""

    report: Report
    code: int
    notices: tuple[Notice, ...]


def _report(arguments: argparse.Namespace) -> _ModelReport:
    """Compute the design space of one model and the results of the options."""
    space = certified_space(arguments)
    exact = None
    if arguments.exact:
        space, exact = _add_exact_ranks(space)
    report = _describe(space, exact, arguments)
    report = report._replace(
        following=_following(arguments, space.can_balance.verb),
        alternative=_following(arguments, _second_verb(space, arguments)),
    )
    answers = [space, *([report.decoupling.freed] if report.decoupling else [])]
    missing = [notice for answer in answers for notice in _missing_certainty(answer, arguments)]
    complete = arguments.max_order is not None or all(answer.settled for answer in answers)
    answered = exact is not None or not arguments.exact
    doubtful = any(answer.doubts for answer in answers)
    sure = complete and answered and not doubtful and not missing
    notices = (*space.warnings, *(exact.notices if exact else ()), *missing)
    return _ModelReport(report, DONE if sure else UNDECIDED, notices)


def _following(arguments: argparse.Namespace, verb: str) -> str:
    """Build the command that comes next, for the same model and motions; empty without verb."""
    import shlex

    if not verb:
        return ""
    words = ["balance", verb, _model_word(arguments.model)]
    words += model_words(arguments, arguments.loops)
    words += ["--ground", arguments.ground] if arguments.ground else []
    words += ["--bodies", "all"] * (arguments.bodies == "all")
    words += ["--spatial"] * arguments.spatial
    # A design for one pose asks for no more than its conditions, others for all there are.
    words += ["--max-order", "0"] * (verb == "design" and arguments.max_order == 0)
    return shlex.join(words)


def _second_verb(space: DesignSpace, arguments: argparse.Namespace) -> str:
    """Name the command that says what to build in, where the design may find no masses."""
    is_open = space.can_balance.verb == "design" and space.as_given.balanced is False
    in_any_motion = not space.requirements and arguments.max_order is None
    return "remedies" if is_open and in_any_motion else ""


def _model_word(model: str | Document) -> str:
    """Write a model as on a command line, by the name that the gallery has for it."""
    from kinematics.files.urdf.input_streams import STANDARD_INPUT, STANDARD_INPUT_NAME
    from kinematics.loading.model_gallery import find, gallery

    if not isinstance(model, str):
        return STANDARD_INPUT if model.name == STANDARD_INPUT_NAME else model.name
    path = find(model)
    if path == Path(model):
        return model
    return next((name for name, other in gallery().items() if other == path), model)


def _add_exact_ranks(space: CertifiedSpace) -> tuple[CertifiedSpace, ExactRanks | None]:
    """Compute the exact ranks; a refusal becomes a notice of the space."""
    from dataclasses import replace

    from balance.space.certification.exact_ranks import exact_ranks
    from kinematics.model.linkage import Notice

    try:
        return space, exact_ranks(space)
    except ExactError as error:
        notice = Notice("exact_refused", str(error))
        return replace(space, notices=(*space.notices, notice)), None


def _describe(
    space: CertifiedSpace, exact: ExactRanks | None, arguments: argparse.Namespace
) -> Report:
    """Compute what the options ask for beside the space, and the distance to a rank drop."""
    from balance.app.answers.data import Report
    from balance.space.interpretation.explain import explain
    from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop

    wanted = arguments.explain or arguments.html is not None
    explanation = explain(space) if wanted else None
    if space.requirements:
        return Report(space)
    report = Report(space, explanation, exact, distance_to_rank_drop(space))
    if arguments.decoupled:
        from balance.space.decoupled.decoupling import decoupling

        report = report._replace(decoupling=decoupling(space))
    if arguments.pure_inertia:
        from balance.masses.pure_inertias.pure_inertia import pure_inertia

        report = report._replace(pure_inertia=pure_inertia(space))
    return report


def _missing_certainty(space: DesignSpace, arguments: argparse.Namespace) -> tuple[Notice, ...]:
    """Return a notice if the answer is less certain than ``--certainty``."""
    from balance.space.spaces.certainty import LEVELS
    from kinematics.model.linkage import Notice

    if LEVELS.index(space.level) >= LEVELS.index(arguments.certainty or LEVELS[0]):
        return ()
    reason = space.assurance.removeprefix(f"{space.level}: ")
    text = f"the answer is {space.level}, not {arguments.certainty}: {reason}"
    return (Notice("required", text),)


def _closed_pose(linkage: Linkage, path: str) -> tuple[bytes, Notice]:
    """Write a linkage at the pose at which its loops close, and say what differs.

    Raises:
        FileError: the linkage was not read from a file.
    """
    from kinematics.files.urdf.write_closed_pose import write_at_reference_pose
    from kinematics.model.linkage import Notice

    posed = write_at_reference_pose(linkage)
    text = _describe_pose(linkage, dict(posed.moved))
    if posed.beside:
        text += "; its loops are in another file: give that with --loops"
    return posed.data, Notice("closed_pose", f"{path}: written {text}")


def _describe_pose(linkage: Linkage, positions: dict[str, float]) -> str:
    """Describe the pose of the written file by the displacements of the joints."""
    from kinematics.model.full_turns import position_text, wrap_turns
    from kinematics.numerics.linalg.ties import rank_least_first

    if not positions:
        return "as it was, for its loops close at its own pose"
    moved = [joint for joint in linkage.joints if joint.name in positions]
    within, _ = wrap_turns(moved, [positions[joint.name] for joint in moved])
    ranks = rank_least_first([-abs(q) for q in within.tolist()])
    pairs = [(moved[k], float(within[k])) for k in ranks]
    named = [f"{joint.name} by {position_text(joint, q, 6)}" for joint, q in pairs]
    more = f" and {len(named) - MAX_NAMES} more" if len(named) > MAX_NAMES else ""
    where = "the pose asked for" if linkage.at else "the pose at which its loops close"
    return (
        f"at {where}: only origins of joints differ, moved are "
        f"{', '.join(named[:MAX_NAMES])}{more}; limits of joints count from there"
    )
