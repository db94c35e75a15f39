"""The command ``balance quiet``: its options, and its answer."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Parser, refuse_given
from balance.app.cli.exit_codes import DONE, NEGATIVE
from balance.app.cli.model_options import add_model_options, load_model, parse_coordinates
from balance.app.cli.number_arguments import (
    add_about,
    add_tool,
    gravity,
    number_between,
    positive_number,
    whole_number,
)
from balance.app.cli.outputs import (
    TABLE_NOT_CSV,
    add_meshes_option,
    add_page_option,
    add_picture_option,
    add_table_option,
    result_files,
)
from balance.app.cli.progress import spinner
from balance.support.options import GRAVITY

if TYPE_CHECKING:
    from balance.motion.quiet.quiet_motion_result import QuietMotion
    from kinematics.model.linkage import Linkage

# Limits of inputs: their options, and what they bound.
LIMITS = {
    "velocity": "speed, rad/s (sliding: m/s)",
    "acceleration": "acceleration, rad/s² or m/s²",
    "jerk": "jerk, rad/s³ or m/s³; accelerations then vanish at both ends",
    "torque": "torque with gravity, N m (sliding: N)",
}

_LENGTH = number_between(1e-9, 1e9)


def add_quiet(parser: Parser) -> None:
    """Add the options of the command ``quiet``."""
    parser.description = (
        "Plans the motion between poses that shakes the base least, with the masses as they "
        "are: from rest to rest, or a cycle; or the timing of a given path. Exits with 0, or "
        "with 1 if no motion within the limits is found. Gravity counts for torques alone."
    )
    parser.add_examples(
        "balance quiet robot.urdf --to u1=0.5,u2=-0.3 --duration 0.8 --table quiet.csv",
        "balance quiet robot.urdf --to u1=0.5 --shaking both --measure peak --max-torque 20",
        "balance quiet robot.urdf --tool hand --tool-to x=0.2,z=-0.1 --via u1=0.4",
        "balance quiet robot.urdf --to u1=0.5 --cycle --natural-frequency 12",
        "balance quiet robot.urdf --to u1=0.5 --straight --max-velocity 2 --front 5",
    )
    add_model_options(parser, unused=("--motion", "--balance", "--spatial"))
    parser.set_defaults(run=_run)
    parser.elsewhere |= TABLE_NOT_CSV
    group = parser.group("motion")
    _add_motion_options(group)
    _add_tool_options(group)
    _add_objective_options(group)
    _add_limit_options(group)
    add_table_option(
        parser.group("output"),
        "write the motion: time and the inputs, their velocities and accelerations, as "
        "'balance verify --csv' reads it",
    )
    add_picture_option(parser, "write a picture of the shaking and of the inputs over time")
    add_page_option(parser, "on which the linkage moves as planned, beside the quintic law")
    add_meshes_option(parser)


def _add_motion_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of poses, path and duration."""
    start = group.add_mutually_exclusive_group()
    start.add_argument(
        "--from",
        dest="start",
        type=parse_coordinates,
        default={},
        metavar="U1=VALUE,…",
        help="pose to start from: displacements of inputs from the reference pose, radians and "
        "metres (default: the reference pose)",
    )
    start.add_argument(
        "--tool-from",
        type=parse_coordinates,
        metavar="X=VALUE,…",
        help="pose of the tool to start from",
    )
    end = group.add_mutually_exclusive_group()
    end.add_argument(
        "--to",
        dest="end",
        type=parse_coordinates,
        metavar="U1=VALUE,…",
        help="pose to reach; inputs that are not named stay",
    )
    end.add_argument(
        "--tool-to",
        type=parse_coordinates,
        metavar="X=VALUE,…",
        help="pose of the tool to reach: displacements x, y, z and turns rx, ry, rz from the "
        "reference pose; directions that are not named, and inputs that it leaves free, are "
        "chosen",
    )
    group.add_argument(
        "--duration",
        type=number_between(1e-6, 1e6, "time"),
        metavar="S",
        help="duration of the motion, seconds (default 1)",
    )
    way = group.add_mutually_exclusive_group()
    way.add_argument(
        "--straight",
        action="store_true",
        help="keep to the straight line of the inputs, and choose the timing alone",
    )
    way.add_argument(
        "--path",
        metavar="FILE.csv",
        help="keep to the path through the poses of a table, one in a row: a column for each "
        "input, by its name; and choose the timing alone",
    )
    group.add_argument(
        "--front",
        type=whole_number(2, 100),
        metavar="N",
        help="with --straight or --path: print the least shaking for N durations, too, from "
        "the shortest within the limits up to that of --duration",
    )


def _add_tool_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of poses on the way, of cycles, and of the tool whose poses are given."""
    group.add_argument(
        "--via",
        action="append",
        type=parse_coordinates,
        default=[],
        metavar="U1=VALUE,…",
        help="pose that is passed on the way, of inputs or of the tool (x=0.1,…), at a time "
        "that the plan chooses; repeatable, in order",
    )
    group.add_argument(
        "--cycle",
        action="store_true",
        help="return to the start and repeat, without rest, with the duration as period",
    )
    group.add_argument(
        "--harmonics",
        type=whole_number(1, 30),
        metavar="N",
        help="with --cycle: number of harmonics of the inputs (default 5)",
    )
    add_tool(group, "link whose poses are given")


def _add_objective_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of what is minimised."""
    group.add_argument(
        "--shaking",
        choices=("force", "moment", "both"),
        default="force",
        help="what to minimise: the shaking force, the moment about a point, or both (default "
        "force)",
    )
    group.add_argument(
        "--measure",
        choices=("rms", "peak"),
        default="rms",
        help="of it, the root mean square over time or the peak (default rms)",
    )
    group.add_argument(
        "--weight-moment",
        type=_LENGTH,
        metavar="METRES",
        help="with --shaking both: length by which moments are divided (default: the "
        "characteristic length of the linkage)",
    )
    add_about(group, "the middle of the mechanism")
    group.add_argument(
        "--natural-frequency",
        action="append",
        type=number_between(1e-6, 1e6),
        default=[],
        metavar="HZ",
        help="natural frequency of the base that the motion does not excite; repeatable",
    )


def _add_limit_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of limits of the inputs."""
    for kind, what in LIMITS.items():
        add_limit(group, kind, f"largest {what}; of all inputs or of one, repeatable")
    group.add_argument(
        "--ignore-limits",
        action="store_true",
        help="do not read the limits of positions, speeds and torques in the file",
    )
    group.add_argument(
        "--gravity",
        type=gravity,
        default=GRAVITY,
        metavar="X,Y,Z",
        help="acceleration of gravity for torques, m/s², inertial frame (default 0,0,-9.81)",
    )


def add_limit(group: argparse._ArgumentGroup, kind: str, purpose: str) -> None:
    """Add the option of a limit of the inputs.

    Args:
        kind: what is limited.
        purpose: the help of the option.
    """
    group.add_argument(
        f"--max-{kind}",
        action="append",
        type=_limit,
        default=[],
        metavar="[J=]VALUE",
        help=purpose,
    )


def _limit(text: str) -> tuple[str, float]:
    """Parse ``[J=]VALUE``: the name of an input or an empty string, and a positive number."""
    name, equals, number = text.rpartition("=")
    if bool(equals) != bool(name.strip()):
        raise argparse.ArgumentTypeError(f"'{text}' is not a limit: write 2.5 or u1=2.5")
    return name.strip(), positive_number(number)


def _run(arguments: argparse.Namespace) -> Answer:
    """Plan the motion of the options.

    Raises:
        LinkageError: the file, the linkage, a pose or a limit cannot be used.
        SystemExit: options exclude each other.
    """
    _refuse_exclusive_options(arguments)
    with spinner("planning the motion"):
        plan = _plan(arguments, load_model(arguments, arguments.angles))
    from balance.app.answers.text.quiet import quiet_body

    return Answer(
        DONE if plan.feasible else NEGATIVE,
        plan.to_dict,
        lambda: quiet_body(plan),
        plan.notices,
        files=lambda: _prepare_plan_files(arguments, plan),
    )


def _refuse_exclusive_options(arguments: argparse.Namespace) -> None:
    """End the command if its options exclude each other."""
    ends = arguments.start, arguments.end, arguments.tool_from, arguments.tool_to
    if arguments.path is not None and any(ends):
        arguments.refuse(
            "--path: leads from its first pose to its last, without --from and --to"
        )
    reached = arguments.end is not None or arguments.tool_to is not None
    if arguments.path is None and not reached and not (arguments.cycle and arguments.via):
        arguments.refuse("give the pose to reach by --to or --tool-to, or a path by --path")
    if arguments.tool is None:
        missing = "{}: name the tool by --tool"
        refuse_given(arguments, ("tool_from", "tool_to", "point"), missing)
    if arguments.harmonics is not None and not arguments.cycle:
        arguments.refuse("--harmonics: only with --cycle")
    if arguments.cycle and arguments.max_jerk:
        arguments.refuse("--max-jerk: not with --cycle, whose harmonics are few")
    timing = arguments.straight or arguments.path is not None
    if timing:
        only = "{}: not with --straight or --path, whose timing alone is chosen"
        given = ("max_jerk", "natural_frequency", "via", "cycle", "tool")
        refuse_given(arguments, given, only)
    elif arguments.front is not None:
        arguments.refuse("--front: only with --straight or --path")
    if arguments.weight_moment is not None and arguments.shaking != "both":
        arguments.refuse("--weight-moment: only with --shaking both")


def _plan(arguments: argparse.Namespace, linkage: Linkage) -> QuietMotion:
    """Plan the motion, or the timing of a path."""
    # Load the libraries only after the file is accepted.
    from balance.motion.quiet.quiet_motion import HARMONICS, quiet_motion
    from balance.motion.quiet.quiet_timing import quiet_timing

    duration = 1.0 if arguments.duration is None else arguments.duration
    options: dict[str, Any] = {
        "minimise": arguments.shaking,
        "measure": arguments.measure,
        "about": arguments.about,
        "weight_moment": arguments.weight_moment,
        "file_limits": not arguments.ignore_limits,
        "gravity": arguments.gravity,
    }
    for kind in LIMITS:
        options[kind] = limits_by_name(linkage, getattr(arguments, f"max_{kind}"))
    if not arguments.straight and arguments.path is None:
        _check_tool_units(linkage, (arguments.tool_from, arguments.tool_to, *arguments.via))
        tool = arguments.tool
        return quiet_motion(
            linkage,
            arguments.tool_from or arguments.start,
            arguments.tool_to or arguments.end,
            duration,
            via=arguments.via,
            tool=tool if arguments.point is None else (tool, arguments.point),
            cycle=arguments.cycle,
            harmonics=arguments.harmonics or HARMONICS,
            frequencies=arguments.natural_frequency,
            **options,
        )
    del options["jerk"]
    front = arguments.front or 0
    if arguments.path is not None:
        from balance.support.csv_columns import read_columns

        poses = read_columns(arguments.path, linkage.inputs, 2)
        return quiet_timing(linkage, poses, duration, front=front, **options)
    from balance.motion.quiet.problem import end_poses

    ends = end_poses(linkage, arguments.start, arguments.end)
    return quiet_timing(linkage, ends, duration, front=front, **options)


def _check_tool_units(linkage: Linkage, poses: Sequence[Mapping[str, float] | None]) -> None:
    """Refuse inputs in a pose of the tool, an angle of its shift, and a length of its turn.

    Args:
        poses: the first two are of the tool alone.

    Raises:
        PoseError: a name or a unit does not fit.
    """
    from balance.support.units import UnitNumber
    from kinematics.closure.assembly.tool_frame import DIRECTIONS
    from kinematics.errors import PoseError

    names = [name for pose in poses[:2] for name in pose or ()]
    for name in (name for name in names if name not in DIRECTIONS):
        known = (
            "is an input: write --from or --to" if name in linkage.inputs else "is none of them"
        )
        text = f"a pose of the tool is given by {', '.join(DIRECTIONS)}: '{name}' {known}"
        raise PoseError(f"{linkage.source}: {text}")
    for name, value in (pair for pose in poses for pair in (pose or {}).items()):
        if name not in DIRECTIONS or name in linkage.inputs:
            continue
        wanted = "length" if name in DIRECTIONS[:3] else "angle"
        if isinstance(value, UnitNumber) and value.quantity != wanted:
            article = {"length": "a length, such as 20mm", "angle": "an angle, such as 30deg"}
            raise PoseError(f"{linkage.source}: {name} of the tool is {article[wanted]}")


def limits_by_name(
    linkage: Linkage, given: Sequence[tuple[str, float]]
) -> dict[str, float] | None:
    """Collect limits by name; those without a name are of all inputs that have none."""
    values: dict[str, float] = {}
    for name, value in sorted(given, key=lambda pair: bool(pair[0])):
        values |= {name: value} if name else dict.fromkeys(linkage.inputs, value)
    return values or None


def _prepare_plan_files(arguments: argparse.Namespace, plan: QuietMotion) -> Files:
    """Prepare the makers of the files of a plan; a table needs a motion within the limits."""
    files = result_files(arguments, plan, meshes=not arguments.no_meshes)
    return {**files, "table": plan.table} if plan.feasible else files
