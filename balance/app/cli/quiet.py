"""The command ``balance quiet``: its options, and its answer."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Parser, refuse_given
from balance.app.cli.exit_codes import DONE, NEGATIVE
from balance.app.cli.model_options import add_model_options, load_model, parse_coordinates
from balance.app.cli.number_arguments import (
    add_about,
    number_between,
    point,
    positive_number,
    whole_number,
)
from balance.app.cli.outputs import add_picture_option, kind_of
from balance.app.cli.progress import spinner
from balance.support.options import GRAVITY

if TYPE_CHECKING:
    from balance.motion.quiet.answer import QuietMotion
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
        "Plans the motion from rest to rest between two poses that shakes the base least, with "
        "the masses as they are; or the timing of a given path. Exits with 0, or with 1 if no "
        "motion within the limits is found. Gravity counts for torques alone."
    )
    parser.add_examples(
        "balance quiet robot.urdf --to u1=0.5,u2=-0.3 --duration 0.8 --csv quiet.csv",
        "balance quiet robot.urdf --to u1=0.5 --shaking both --measure peak --max-torque 20",
        "balance quiet robot.urdf --to u1=0.5 --straight --max-velocity 2 --front 5",
    )
    add_model_options(parser, unused=("--motion", "--balance", "--spatial"))
    parser.set_defaults(run=_run)
    group = parser.group("motion")
    _add_motion_options(group)
    _add_objective_options(group)
    _add_limit_options(group)
    parser.group("output").add_argument(
        "--csv",
        dest="motion_table",
        metavar="FILE",
        help="write the motion: time and the inputs, their velocities and accelerations, as "
        "'balance verify --csv' reads it",
    )
    add_picture_option(parser, "write a picture of the shaking and of the inputs over time")


def _add_motion_options(group: argparse._ArgumentGroup) -> None:
    """Add the options of poses, path and duration."""
    group.add_argument(
        "--from",
        dest="start",
        type=parse_coordinates,
        default={},
        metavar="U1=VALUE,…",
        help="pose to start from: displacements of inputs from the reference pose, radians and "
        "metres (default: the reference pose)",
    )
    group.add_argument(
        "--to",
        dest="end",
        type=parse_coordinates,
        metavar="U1=VALUE,…",
        help="pose to reach; inputs that are not named stay",
    )
    group.add_argument(
        "--duration",
        type=number_between(1e-6, 1e6),
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
        type=point,
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
        DONE if plan.found else NEGATIVE,
        plan.to_dict,
        lambda: quiet_body(plan),
        plan.notices,
        files=lambda: _files(arguments, plan),
    )


def _refuse_exclusive_options(arguments: argparse.Namespace) -> None:
    """End the command if its options exclude each other."""
    if arguments.path is not None and (arguments.start or arguments.end):
        arguments.refuse(
            "--path: leads from its first pose to its last, without --from and --to"
        )
    if arguments.path is None and arguments.end is None:
        arguments.refuse("give the pose to reach by --to, or a path by --path")
    timing = arguments.straight or arguments.path is not None
    if timing:
        only = "{}: not with --straight or --path, whose timing alone is chosen"
        refuse_given(arguments, ("max_jerk", "natural_frequency"), only)
    elif arguments.front is not None:
        arguments.refuse("--front: only with --straight or --path")
    if arguments.weight_moment is not None and arguments.shaking != "both":
        arguments.refuse("--weight-moment: only with --shaking both")


def _plan(arguments: argparse.Namespace, linkage: Linkage) -> QuietMotion:
    """Plan the motion, or the timing of a path."""
    # Load the libraries only after the file is accepted.
    from balance.motion.quiet.quiet_motion import quiet_motion
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
        return quiet_motion(
            linkage,
            arguments.start,
            arguments.end,
            duration,
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


def limits_by_name(
    linkage: Linkage, given: Sequence[tuple[str, float]]
) -> dict[str, float] | None:
    """Collect limits by name; those without a name are of all inputs that have none."""
    values: dict[str, float] = {}
    for name, value in sorted(given, key=lambda pair: bool(pair[0])):
        values |= {name: value} if name else dict.fromkeys(linkage.inputs, value)
    return values or None


def _files(arguments: argparse.Namespace, plan: QuietMotion) -> Files:
    """Find what makes the files of a plan; a table needs a motion within the limits."""
    from balance.app.answers.html.quiet import quiet_picture

    files: Files = {"plot": partial(quiet_picture, plan, kind_of(arguments.plot))}
    return {**files, "motion_table": plan.table} if plan.found else files
