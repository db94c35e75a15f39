"""Options of ``balance paths`` for paths over moments of inertia, and their answers."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, NamedTuple

from balance.app.answers.answer import Answer
from balance.app.cli.arguments import refuse_given
from balance.app.cli.exit_codes import DONE, NEGATIVE
from balance.app.cli.model_options import parse_coordinates
from balance.app.cli.number_arguments import positive_number
from balance.app.cli.outputs import result_files

if TYPE_CHECKING:
    from balance.motion.paths.demand import Kept
    from kinematics.model.linkage import Linkage

# Options of paths for the masses of the file, which mean nothing here.
OTHERS = {
    "step": "--step",
    "motion": "--motion",
    "fan": "--fan",
    "end": "--to",
    "turn": "--turn",
    "about": "--about",
    "line": "--line",
    "tolerance": "--tolerance",
    "table": "--table",
}


class Factors(NamedTuple):
    """Factors of the moments of inertia of a link."""

    link: str
    values: tuple[float, ...]


def add_inertia_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of moments of inertia that may be others."""
    group.add_argument(
        "--factors",
        type=_factors,
        metavar="L=F1,F2",
        help="paths for the inertia of a link times each factor",
    )
    group.add_argument(
        "--through",
        action="append",
        type=parse_coordinates,
        metavar="POSE",
        help="pose to pass: inputs, or x=… of --tool; repeatable",
    )
    group.add_argument(
        "--change",
        metavar="L1,L2",
        help="links whose inertia --through chooses",
    )


def _factors(text: str) -> Factors:
    """Parse ``LINK=0.5,2``."""
    link, equals, numbers = text.rpartition("=")
    if not equals or not link.strip():
        raise argparse.ArgumentTypeError(f"'{text}' is not LINK=0.5,2")
    return Factors(link.strip(), tuple(map(positive_number, numbers.split(","))))


def refuse_inertia_options(arguments: argparse.Namespace) -> None:
    """End the command if options do not go with moments of inertia that may be others."""
    if (arguments.through is None) != (arguments.change is None):
        arguments.refuse("--through and --change go together: poses, and links that may change")
    if arguments.factors is None and arguments.through is None:
        return
    name = "--factors" if arguments.factors is not None else "--through"
    if arguments.factors is not None and arguments.through is not None:
        arguments.refuse("--factors: not with --through, which chooses them")
    for key, option in OTHERS.items():
        if getattr(arguments, key):
            arguments.refuse(f"{option}: not with {name}")
    if arguments.base == "free":
        arguments.refuse(f"--base free: not with {name}")
    if len(arguments.starts or ()) > 1:
        arguments.refuse(f"--from: one pose, with {name}")
    if arguments.through is not None:
        refuse_given(arguments, ("length",), "{}: not with --through, whose path has two ends")
        if arguments.kept == "force" or arguments.balance == "force":
            arguments.refuse("--through: forces do not depend on moments of inertia")


def answer_with_inertias(arguments: argparse.Namespace, linkage: Linkage) -> Answer:
    """Answer ``--factors`` or ``--through``."""
    force = arguments.balance == "force"
    kept: Kept = "force" if force else arguments.kept or "all"
    start = (arguments.starts or [{}])[0]
    tool = arguments.tool
    from balance.app.answers.text.path_inertia import chart_body, moments_body
    from balance.motion.paths import inertia_ratios

    if arguments.factors is not None:
        options = {} if arguments.length is None else {"length": arguments.length}
        chart = inertia_ratios.inertia_chart(
            linkage,
            arguments.factors.link,
            arguments.factors.values,
            start,
            kept=kept,
            tool=tool,
            point=arguments.point,
            **options,
        )
        return Answer(
            DONE if any(solution.paths for solution in chart.solutions) else NEGATIVE,
            chart.to_dict,
            lambda: chart_body(chart),
            linkage.notices,
            files=lambda: result_files(arguments, chart),
        )
    moments = inertia_ratios.moments_through_poses(
        linkage,
        arguments.change.split(","),
        [start, *arguments.through],
        kept=kept,
        tool=tool if arguments.point is None else (tool, arguments.point),
    )
    return Answer(
        NEGATIVE if moments.reason else DONE,
        moments.to_dict,
        lambda: moments_body(moments),
        linkage.notices,
        files=lambda: result_files(arguments, moments),
    )
