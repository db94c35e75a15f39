"""Text of predictions of a Taylor motion for ``balance motion``.

`Predictions.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.motion.taylor_poses.prediction import Prediction, Predictions, assign_inputs
from kinematics.closure.assembly.tool_frame import tool_coordinates
from kinematics.model.full_turns import wrap_turns
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import POSE_DETERMINED
from kinematics.wording import number_text, size_text

# Most poses in a table.
MAX_POSES = 6
# Most names in a line.
MAX_NAMES = 12
# Decimals of joint positions at a single pose.
POSE_DECIMALS = 9
# Decimals of joint positions at the poses of a path.
PATH_DECIMALS = 6


def measure(predictions: Predictions) -> str:
    """Name the units of distances and errors."""
    return f"radians and lengths of {number_text(predictions.length, '.3g')} m"


def motion_facts(predictions: Predictions) -> list[tuple[str, str]]:
    """List the facts on predictions, without the tables, as pairs of label and value."""
    motion, count = predictions.motion, len(predictions.linkage.loops)
    loops = f"{count} loop{'' if count == 1 else 's'}"
    pairs = linkage_facts(predictions.linkage, f"{len(motion.joints)} joints, {loops}")
    if predictions.tool is not None:
        pairs += _tool_facts(predictions, predictions.tool)
    if motion.motion.relations:
        pairs.append(("motion", ", ".join(motion.motion.relations)))
    radius = f"{number_text(motion.radius, '.3g')} ({measure(predictions)}), estimated"
    if np.isinf(motion.radius):
        radius = "infinite: the motion is linear"
    pairs += [
        ("independent", _first_names(motion.motion.inputs)),
        ("dependent", _first_names(predictions.dependent) or "none"),
        ("order", f"{motion.order}, {len(motion.exponents)} terms"),
        ("radius", radius),
    ]
    if predictions.line:
        return pairs + _pose_facts(predictions, predictions.poses[0])
    return pairs + _path_facts(predictions) if predictions.poses else pairs


def _tool_facts(predictions: Predictions, link: str) -> list[tuple[str, str]]:
    """Name the moving point, and note that other postures may reach the same pose."""
    name = link
    if predictions.point is not None:
        at = ", ".join(number_text(x, ".6g") for x in predictions.point)
        name = f"{link}, its point ({at}) m in the frame of the link"
    inputs = predictions.motion.motion.inputs
    free = [each for each in inputs if each not in tool_coordinates(link)]
    posture = (
        "the one that leads from the reference pose straight to the target; others may take "
        "the tool there too"
    )
    if free:
        posture += f", for it does not determine {_first_names(tuple(free))}"
    return [("tool", name), ("posture", posture)]


def _pose_facts(predictions: Predictions, pose: Prediction) -> list[tuple[str, str]]:
    """List the facts on the pose at the end of a line."""
    pairs = [
        ("target", assign_inputs(predictions.motion, pose.u)),
        ("distance", number_text(pose.distance, ".3g")),
    ]
    if pose.reason:
        return [*pairs, ("verdict", f"not reached: {pose.reason}")]
    outcome = "reached, the corrected pose closes the loops"
    return [*pairs, ("error", _error_text(pose.error, pose.difference)), ("verdict", outcome)]


def _path_facts(predictions: Predictions) -> list[tuple[str, str]]:
    """List the facts on the poses of a path."""
    count = len(predictions.poses)
    unreached = [(k, pose) for k, pose in enumerate(predictions.poses, 1) if pose.reason]
    outcome = f"reached, {count} poses close the loops"
    if unreached:
        first, pose = unreached[0]
        outcome = f"not reached: {len(unreached)} of {count} poses; pose {first}: {pose.reason}"
    distance = max(pose.distance for pose in predictions.poses)
    return [
        ("distance", f"up to {number_text(distance, '.3g')}"),
        ("error", _largest_errors(predictions)),
        ("verdict", outcome),
    ]


def _largest_errors(predictions: Predictions) -> str:
    """Describe the largest errors of a path."""
    reached = [pose for pose in predictions.poses if not pose.reason]
    estimates = [pose.error for pose in reached if pose.error is not None]
    true = [pose.difference for pose in reached if pose.difference is not None]
    errors = _error_text(max(estimates, default=None), max(true, default=None))
    if estimates and len(estimates) < len(reached):
        errors = errors.replace("estimated", "estimated within the radius of convergence", 1)
    return f"up to {errors}" if estimates else errors


def motion_tables(
    predictions: Predictions, most: int = MAX_POSES
) -> list[list[tuple[str, ...]]]:
    """Build tables of the one pose, or of the first poses of a path, and their joints.

    Args:
        most: most poses of a path.

    Returns:
        Tables as lists of rows, the head first.
    """
    if not predictions.poses:
        return []
    if predictions.line:
        return [_joint_table(predictions, predictions.poses[0])]
    head = ("pose", *predictions.motion.motion.inputs, "distance", "estimated", "difference")
    lines = [_pose_row(k, pose) for k, pose in enumerate(predictions.poses[:most], 1)]
    return [[head, *lines], _path_joint_table(predictions, predictions.poses[:most])]


def _pose_row(number: int, pose: Prediction) -> tuple[str, ...]:
    """Build the row of one pose of a path."""
    estimate, true = (
        "none" if size is None else size_text(size, floor=POSE_DETERMINED)
        for size in (pose.error, pose.difference)
    )
    if pose.reason:
        estimate, true = "none", "not reached"
    return (
        str(number),
        *(number_text(x, ".6g") for x in pose.u),
        number_text(pose.distance, ".3g"),
        estimate,
        true,
    )


def _joint_table(predictions: Predictions, pose: Prediction) -> list[tuple[str, ...]]:
    """Build the table of joint positions at one pose, or at the furthest pose reached.

    Predictions beyond the radius of convergence are left out.
    """
    joints = predictions.motion.joints
    corrected, predicted = pose.corrected, pose.predicted
    head, columns = [], []
    for name, q in (("corrected", corrected), ("furthest", pose.furthest)):
        if q is not None:
            head.append(name)
            columns.append(_position_texts(predictions, q))
    if corrected is not None and predicted is not None and pose.error is not None:
        head += ["predicted", "difference"]
        columns.append(_position_texts(predictions, predicted))
        differences = (predicted - corrected).tolist()
        columns.append([size_text(q, floor=POSE_DETERMINED) for q in differences])
    return [("joint", "unit", *head), *zip(joints, predictions.units, *columns, strict=True)]


def _path_joint_table(
    predictions: Predictions, poses: tuple[Prediction, ...]
) -> list[tuple[str, ...]]:
    """Build the table of joint positions at poses of a path."""
    columns = [
        ["-"] * len(predictions.units)
        if pose.corrected is None
        else _position_texts(predictions, pose.corrected, PATH_DECIMALS)
        for pose in poses
    ]
    head = ("joint", "unit", *(f"pose {k}" for k in range(1, len(poses) + 1)))
    return [head, *zip(predictions.motion.joints, predictions.units, *columns, strict=True)]


def _position_texts(
    predictions: Predictions, q: Array, decimals: int = POSE_DECIMALS
) -> list[str]:
    """Format positions within one turn, with the number of full turns."""
    within, turns = wrap_turns(predictions.linkage.joints, q)
    numbers = [f"{x + 0.0:.{decimals}f}" for x in np.round(within, decimals)]
    ends = [
        f" {'+' if n > 0 else '-'} {abs(n)} turn{'s' if abs(n) > 1 else ''}" if n else ""
        for n in turns.tolist()
    ]
    width = max(map(len, ends), default=0)
    return [number + end.ljust(width) for number, end in zip(numbers, ends, strict=True)]


def motion_body(predictions: Predictions) -> AnswerBody:
    """Build what is printed on predictions."""
    body: list[AnswerPart] = [Facts(motion_facts(predictions), least=12)]
    for table in motion_tables(predictions):
        body += ["", AnswerTable(table, "<>")]
    if len(predictions.poses) > MAX_POSES:
        body.append(f"… and {len(predictions.poses) - MAX_POSES} more; --json has them all")
    return body


def _error_text(estimate: float | None, difference: float | None) -> str:
    """Describe the estimated and the true error of a prediction."""
    text = "no estimate beyond the radius of convergence"
    if estimate is not None:
        text = f"{size_text(estimate, floor=POSE_DETERMINED)} estimated"
    if difference is None:
        return text
    return f"{text}, {size_text(difference, floor=POSE_DETERMINED)} to the corrected pose"


def _first_names(names: tuple[str, ...]) -> str:
    """List the first names, and the number of all."""
    return ", ".join(names[:MAX_NAMES]) + (
        f" … ({len(names)})" if len(names) > MAX_NAMES else ""
    )
