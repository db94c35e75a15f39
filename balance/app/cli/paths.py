"""The command ``balance paths``: its options, and its answer."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Parser, refuse_given
from balance.app.cli.exit_codes import DONE, NEGATIVE
from balance.app.cli.floating_base import inertia
from balance.app.cli.model_options import add_model_options, load_model, parse_coordinates
from balance.app.cli.number_arguments import (
    add_about,
    add_tool,
    finite_quantity,
    number_between,
    point,
    positive_number,
    whole_number,
)
from balance.app.cli.outputs import (
    TABLE_NOT_CSV,
    add_page_option,
    add_picture_option,
    add_table_option,
    result_files,
)
from balance.app.cli.path_inertia import (
    add_inertia_options,
    answer_with_inertias,
    refuse_inertia_options,
)
from balance.app.cli.progress import progress_bar

if TYPE_CHECKING:
    from balance.motion.floating_base.base import FloatingBase
    from balance.motion.paths.demand import Kept
    from balance.motion.paths.reactionless_paths import ReactionlessPaths


# Most starts on a line between two poses.
MAX_LINE = 10_000
# Most paths of a fan.
MAX_FAN = 1000

_SIZE = number_between(1e-9, 1e9)


def add_paths(parser: Parser) -> None:
    """Add the options of the command ``paths``."""
    parser.description = (
        "Finds paths along which the base stays at rest: from a pose, to a pose, or to turn a "
        "base that floats. Exits with 0, or with 1 if there is none."
    )
    add_model_options(parser, unused=("--spatial",), motion_alone=True)
    parser.set_defaults(run=_run)
    parser.elsewhere |= TABLE_NOT_CSV
    _add_path_options(parser.group("motion"))
    _add_tool_options(parser.group("motion"))
    _add_target_options(parser.group("motion"))
    add_inertia_options(parser.group("matter"))
    _add_base_options(parser.group("base"))
    output = parser.group("output")
    output.add_argument(
        "--which",
        type=whole_number(1, MAX_LINE, "the number of a path"),
        default=1,
        metavar="K",
        help="number of the path that --table writes (default 1)",
    )
    add_table_option(output, "write a motion along it, for verify --csv")
    add_picture_option(parser, "write a picture of the paths, and of the momentum")
    add_page_option(parser, "on which the linkage runs along them")


def _add_path_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of starts and lengths."""
    group.add_argument(
        "--from",
        dest="starts",
        action="append",
        type=parse_coordinates,
        metavar="U1=VALUE,…",
        help="pose to start from (reference pose); repeatable",
    )
    group.add_argument(
        "--line",
        type=whole_number(1, MAX_LINE),
        default=0,
        metavar="N",
        help="start also from N poses between each two of --from",
    )
    group.add_argument(
        "--length",
        type=_SIZE,
        metavar="L",
        help="arc length to either side, in all joints (1)",
    )
    group.add_argument(
        "--step",
        type=_SIZE,
        metavar="S",
        help="arc length between samples (default 0.005)",
    )
    part = group.add_mutually_exclusive_group()
    part.add_argument(
        "--moment-only",
        dest="kept",
        action="store_const",
        const="moment",
        help="without moment about a point, whatever the force",
    )
    part.add_argument(
        "--force-only",
        dest="kept",
        action="store_const",
        const="force",
        help="without force, whatever the moment",
    )
    add_about(group, "the inertial origin")


def _add_tool_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of a tool, and of paths that span its reactionless workspace."""
    group.add_argument(
        "--fan",
        type=whole_number(1, MAX_FAN),
        metavar="N",
        help="N paths all around, if two rates or more are free",
    )
    add_tool(group, "link whose ways are shown, in its workspace")


def _add_target_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of a pose to reach, and of momentum that may be left."""
    group.add_argument(
        "--to",
        dest="end",
        type=parse_coordinates,
        metavar="U1=VALUE,…",
        help="pose to reach; inputs that are not named stay",
    )
    group.add_argument(
        "--tolerance",
        type=_share,
        default=0.0,
        metavar="5%",
        help="part of the bodies' own momenta that may be left",
    )


def _add_base_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of a base that floats."""
    group.add_argument(
        "--base",
        choices=("fixed", "free"),
        metavar="fixed|free",
        default="fixed",
        help="free: the base floats and has a mass of its own",
    )
    group.add_argument(
        "--base-mass",
        type=number_between(1e-9, 1e9, "mass"),
        metavar="KG",
        help="its mass",
    )
    group.add_argument(
        "--base-com",
        type=point,
        metavar="X,Y,Z",
        help="its centre of mass, m, inertial frame (0,0,0)",
    )
    group.add_argument(
        "--base-inertia",
        type=inertia,
        metavar="I|I,I,I",
        help="its inertia, kg m², for --turn",
    )
    group.add_argument(
        "--turn",
        type=_turn,
        metavar="ANGLE|X,Y,Z",
        help="turn it by an angle, or a rotation vector",
    )
    group.add_argument(
        "--attitude",
        action="store_true",
        help="it may move, but not turn",
    )


def _run(arguments: argparse.Namespace) -> Answer:
    """Find the paths of the options.

    Raises:
        LinkageError: the file, the linkage, a pose or a relation cannot be used.
        SystemExit: options exclude each other.
    """
    _refuse_exclusive_options(arguments)
    if arguments.factors is not None or arguments.through is not None:
        return answer_with_inertias(arguments, load_model(arguments, arguments.angles))
    with progress_bar("starts") as advance:
        solution = _find(arguments, advance)
    if arguments.tool is not None:
        solution = solution.with_tool(arguments.tool, arguments.point)
    if solution.paths and arguments.which > len(solution.paths):
        arguments.refuse(f"--which: there are {len(solution.paths)} paths")
    from balance.app.answers.text.paths import paths_body

    return Answer(
        DONE if solution.paths else NEGATIVE,
        solution.to_dict,
        lambda: paths_body(solution),
        solution.notices,
        files=lambda: _prepare_path_files(arguments, solution),
    )


def _refuse_exclusive_options(arguments: argparse.Namespace) -> None:
    """End the command if its options exclude each other."""
    free = arguments.base == "free"
    if not free:
        base_options = ("base_mass", "base_com", "base_inertia", "turn", "attitude")
        refuse_given(arguments, base_options, "{}: only with --base free")
    _refuse_for_a_pose(arguments)
    refuse_inertia_options(arguments)
    if arguments.point is not None and arguments.tool is None:
        arguments.refuse("--point: name the tool by --tool")
    if free and arguments.base_mass is None and arguments.attitude:
        arguments.refuse("--attitude: give the mass of the base by --base-mass")
    if arguments.about is not None and arguments.kept != "moment":
        arguments.refuse("--about: only with --moment-only")
    if arguments.kept == "moment" and arguments.balance == "force":
        arguments.refuse("--moment-only: not with --balance force")
    if free and (arguments.kept or arguments.balance == "force"):
        arguments.refuse(
            "--base free: keeps all of the base at rest, or with --attitude its orientation: "
            "not with --moment-only, --force-only or --balance force"
        )
    if arguments.line and len(arguments.starts or ()) < 2:
        arguments.refuse("--line: give two poses or more by --from")


def _refuse_for_a_pose(arguments: argparse.Namespace) -> None:
    """End the command if options exclude each other where a pose or a turn is to be reached."""
    if arguments.turn is not None:
        needed = "--turn: give the mass and the inertia of the base, and not --attitude"
        refuse_given(arguments, ("base_mass", "base_inertia"), needed, given=False)
        refuse_given(arguments, ("attitude",), needed)
    elif arguments.base_inertia is not None:
        arguments.refuse("--base-inertia: only with --turn")
    if arguments.end is None and arguments.turn is None:
        return
    to = "{}: not with --to or --turn, whose path has two ends"
    refuse_given(arguments, ("step", "motion", "fan"), to)
    if arguments.line or arguments.tolerance:
        arguments.refuse(to.format("--line, --tolerance"))
    if len(arguments.starts or ()) > 1:
        arguments.refuse("--from: one pose, with --to or --turn")


def _find(
    arguments: argparse.Namespace, advance: Callable[[int, int], None]
) -> ReactionlessPaths:
    """Find the paths of the options."""
    linkage = load_model(arguments, arguments.angles)
    # Load the kernels only after the file is accepted.
    from balance.motion.paths.path_search import LENGTH, find_paths

    kept: Kept = "attitude" if arguments.attitude else arguments.kept or "all"
    if arguments.balance == "force":
        kept = "force"
    if arguments.end is not None or arguments.turn is not None:
        from balance.motion.paths.path_to_pose import path_to_pose

        return path_to_pose(
            linkage,
            arguments.end or {},
            (arguments.starts or [None])[0],
            kept="turned" if arguments.turn is not None else kept,
            base=_base(arguments),
            turn=arguments.turn,
            about=arguments.about,
        )
    return find_paths(
        linkage,
        arguments.starts or (),
        kept=kept,
        base=_base(arguments),
        about=arguments.about,
        motion=arguments.motion,
        length=arguments.length or LENGTH,
        step=arguments.step,
        line=arguments.line,
        tolerance=arguments.tolerance,
        fan=arguments.fan or 0,
        progress=advance,
    )


def _base(arguments: argparse.Namespace) -> FloatingBase | None:
    """Make the base that floats."""
    from balance.motion.floating_base.base import FloatingBase

    if arguments.base == "fixed":
        return None
    com = arguments.base_com or (0.0, 0.0, 0.0)
    return FloatingBase(arguments.base_mass or 0.0, arguments.base_inertia, com)


def _share(text: str) -> float:
    """Parse a part of 1, of ``5%`` or ``0.05``."""
    percent = text.rstrip().endswith("%")
    value = positive_number(text.rstrip().removesuffix("%"))
    value = value / 100.0 if percent else value
    if not value < 1.0:
        raise argparse.ArgumentTypeError(f"'{text}' is not below 1: write 5% or 0.05")
    return value


def _turn(text: str) -> tuple[float, ...]:
    """Parse an angle, or a rotation vector of three."""
    values = tuple(float(finite_quantity("angle")(word)) for word in text.split(","))
    if len(values) not in (1, 3):
        raise argparse.ArgumentTypeError(f"'{text}' is not an angle, nor three numbers")
    return values


def _prepare_path_files(arguments: argparse.Namespace, solution: ReactionlessPaths) -> Files:
    """Prepare the makers of the files of paths; a table needs a path."""
    from balance.motion.paths.path import path_table, segments_table

    files = result_files(arguments, solution)
    if not solution.paths:
        return files
    if solution.target is not None:
        table = partial(segments_table, solution.linkage, solution.paths)
        return {**files, "table": table}
    path = solution.paths[arguments.which - 1]
    return {**files, "table": partial(path_table, solution.linkage, path)}
