"""The command ``balance motion``: its options, and its answer."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from balance.app.answers.answer import Answer, Files
from balance.app.cli.arguments import Parser
from balance.app.cli.exit_codes import DONE, NEGATIVE
from balance.app.cli.model_options import add_model_options, check_units
from balance.app.cli.model_readings import solve_model
from balance.app.cli.number_arguments import add_tool, whole_number
from balance.app.cli.outputs import add_page_option, add_picture_option, kind_of
from balance.app.cli.progress import spinner
from balance.support.units import read_quantity
from kinematics.errors import CoordinateError, MotionError, PoseError, UsageError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from balance.motion.taylor_poses.prediction import Predictions
    from kinematics.closure.taylor.taylor_motion import TaylorMotion
    from kinematics.model.linkage import Linkage


# Default order of the expansion.
ORDER = 7
# Highest order of the option.
MAX_ORDER = 50


class Target(NamedTuple):
    """Displacements of inputs, as given on the command line.

    Attributes:
        names: names of the inputs; empty for the displacements of all inputs in order.
        values: displacements from the reference pose, SI units.
    """

    names: tuple[str, ...]
    values: tuple[float, ...]


def add_motion(parser: Parser) -> None:
    """Add the options of the command ``motion``."""
    parser.description = (
        "Taylor expansion of the closed motion, of any order: poses that it "
        "predicts, the same with the loops closed, and their difference. Exits with 0, or with "
        "1 if a pose cannot be reached. Masses do not matter."
    )
    add_model_options(parser, unused=("--balance", "--spatial"))
    group = parser.group("motion")
    add_tool(
        group,
        "inverse kinematics: the inputs are displacements of this link, named by --along",
    )
    group.add_argument(
        "--along",
        metavar="X,Y,…",
        help="directions of the tool: some of x, y, z, rx, ry, rz; others are held as far as "
        "that leaves these free",
    )
    group.add_argument(
        "--order",
        type=whole_number(1, MAX_ORDER, "an order"),
        default=ORDER,
        metavar="K",
        help=f"order of the expansion (default {ORDER})",
    )
    where = group.add_mutually_exclusive_group()
    where.add_argument(
        "--to",
        type=_target,
        metavar="VALUES",
        help="pose to predict: displacements of the inputs from the reference pose, SI units, "
        "by name (u1=0.3,u2=-0.1; inputs not named follow or stay), those of the tool also by "
        "their directions (x=0.02), or all in order (--to=-0.1,0.3)",
    )
    where.add_argument(
        "--path",
        metavar="FILE.csv",
        help="poses to predict, one in a row: a column for each input, by its name",
    )
    add_picture_option(parser, "write a picture of the error of every order against distance")
    add_page_option(parser, "with these curves")
    parser.set_defaults(run=_run, bodies="all")  # a file need not have masses


def _run(arguments: argparse.Namespace) -> Answer:
    """Predict the poses of the options."""
    with spinner("expanding the motion"):
        predictions = _predict(arguments)
    from balance.app.answers.text.motion import motion_body

    return Answer(
        DONE if predictions.reached else NEGATIVE,
        predictions.to_dict,
        lambda: motion_body(predictions),
        predictions.notices,
        files=lambda: _prepare_prediction_files(predictions, kind_of(arguments.plot)),
    )


def _predict(arguments: argparse.Namespace) -> Predictions:
    """Predict the poses of the options.

    Raises:
        LinkageError: a linkage, a motion, a pose, a file or a library cannot be used.
        SystemExit: options exclude each other.
    """
    if (arguments.tool is None) != (arguments.along is None):
        arguments.refuse("--tool and --along go together")
    if arguments.point is not None and arguments.tool is None:
        arguments.refuse("--point is a point of the tool: name that by --tool and --along")
    if arguments.tool is not None and arguments.inputs is not None:
        arguments.refuse("--inputs: with --tool the inputs are named by --along")
    return solve_model(arguments, partial(_compute_predictions, arguments))


def _compute_predictions(arguments: argparse.Namespace, linkage: Linkage) -> Predictions:
    """Compute the Taylor motion and the poses."""
    # Load the kernels only after the file is accepted.
    from balance.motion.taylor_poses.prediction import Predictions, predict
    from kinematics.closure.assembly.tool_frame import tool
    from kinematics.closure.taylor.taylor_motion import taylor_motion
    from kinematics.model.linkage import Notice

    if arguments.tool is not None:
        linkage = tool(linkage, arguments.tool, arguments.along, arguments.point, frame="link")
    motion = taylor_motion(linkage, arguments.order, arguments.motion)
    poses = tuple(predict(motion, y) for y in _target_coordinates(arguments, motion))
    notices = linkage.notices
    beyond = sum(pose.distance > motion.radius for pose in poses)
    if beyond:
        text = (
            f"{beyond} of {len(poses)} poses are beyond the estimated radius of convergence "
            f"({motion.radius:.3g}): there higher orders need not predict better, and there is "
            "no estimate of the error"
        )
        notices = (*notices, Notice("beyond_radius", text))
    line = arguments.to is not None
    return Predictions(motion, arguments.tool, line, poses, notices, arguments.point)


def _target_coordinates(
    arguments: argparse.Namespace, motion: TaylorMotion
) -> NDArray[np.float64]:
    """Compute the coordinates of the poses of the options (N, w).

    Raises:
        LinkageError: they are not poses of this motion.
    """
    import numpy as np

    from balance.motion.taylor_poses.prediction import input_values
    from balance.support.csv_columns import read_columns, refuse_row

    inputs, source = motion.motion.inputs, motion.linkage.source
    relations, short = ", ".join(motion.motion.relations), _short_names(arguments.tool, inputs)
    if arguments.path is not None:
        table = read_columns(arguments.path, inputs, short=short)
        points, fits = input_values(motion, table, range(len(inputs)))
        if not fits.all():
            where = f"sample {int(np.argmin(fits)) + 1}"
            raise refuse_row(arguments.path, where, f"is not on {relations}")
        return points
    if arguments.to is None:
        return np.empty((0, motion.scales.size))
    at = _target_inputs(arguments.to, inputs, short, source)
    named = [inputs[k] for k in at]
    check_units(motion.linkage, dict(zip(named, arguments.to.values, strict=True)))
    points, fits = input_values(motion, [arguments.to.values], at)
    if not fits.all():
        raise MotionError(relations, "does not hold at the pose --to", inputs, source)
    return points


def _short_names(tool: str | None, inputs: tuple[str, ...]) -> dict[str, str]:
    """Return the inputs that are tool coordinates, by direction."""
    from kinematics.closure.assembly.tool_frame import DIRECTIONS, tool_coordinates

    if tool is None:
        return {}
    pairs = zip(DIRECTIONS, tool_coordinates(tool), strict=True)
    return {direction: name for direction, name in pairs if name in inputs}


def _target_inputs(
    target: Target, inputs: tuple[str, ...], short: Mapping[str, str], source: str
) -> list[int]:
    """Return the indices of the inputs that a target displaces.

    Raises:
        LinkageError: it names other joints, or the number of displacements is wrong.
    """
    names: list[str] = []
    for word in target.names:
        name = word if word in inputs else short.get(word, word)
        problem = ""
        if name not in inputs:
            problem = "not an independent coordinate"
        elif name in names:
            problem = f"named twice, as {name} too"
        elif word in inputs and word in short and short[word] not in target.names:
            problem = f"a joint, and a direction of the tool: for the tool write {short[word]}"
        if problem:
            raise CoordinateError(source, [word], problem, inputs)
        names.append(name)
    if names:
        return [inputs.index(name) for name in names]
    if len(target.values) != len(inputs):
        raise PoseError(
            f"{source}: --to gives {len(target.values)} displacements, and there are "
            f"{len(inputs)} inputs ({', '.join(inputs)}); give one for each, or name them"
        )
    return list(range(len(inputs)))


def _prepare_prediction_files(predictions: Predictions, kind: str) -> Files:
    """Prepare the makers of the files of predictions."""
    from balance.app.answers.html.motion import motion_page, motion_picture
    from balance.motion.taylor_poses.error_curves import error_curves

    panels = error_curves(predictions)
    return {
        "plot": partial(motion_picture, predictions, panels, kind),
        "html": partial(motion_page, predictions, panels),
    }


def _target(text: str) -> Target:
    """Parse displacements of ``u1=0.3,u2=-0.1`` or ``0.3,-0.1``."""
    words = [word.rpartition("=") for word in text.split(",")]
    names = tuple(name.strip() for name, equals, _ in words if equals)
    try:
        values = tuple(read_quantity(value, "angle", "length") for *_, value in words)
    except UsageError:
        values = (math.nan,)
    once = len(set(names)) == len(names) and "" not in names
    if len(names) not in (0, len(words)) or not once or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(
            f"'{text}' is not u1=0.3,u2=-0.1 with each input once, nor 0.3,-0.1"
        )
    return Target(names, values)
