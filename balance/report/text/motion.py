"""What the poses of a Taylor motion say, as text; nothing here prints.

The same as data is `Predictions.to_dict`, the contract of ``balance motion --json``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.taylor_poses.prediction import Prediction, Predictions, assign_inputs
from kinematics.assembly.tool_frame import tool_coordinates
from kinematics.model.full_turns import wrap_turns

__all__ = ["motion_facts", "measure", "motion_tables", "motion_text"]

Array = NDArray[np.float64]

# Poses shown, and names in a line.
ROWS, NAMES = 6, 12
# Decimals of the joints at one pose, and at the poses of a path.
FINE, COARSE = 9, 6


def measure(found: Predictions) -> str:
    """In what distances and errors are measured."""
    return f"radians and lengths of {found.length:.3g} m"


def motion_facts(found: Predictions) -> list[tuple[str, str]]:
    """The report without its table, as pairs of a label and a value."""
    motion, count = found.motion, len(found.linkage.loops)
    loops = f"{count} loop{'' if count == 1 else 's'}"
    pairs = [("linkage", f"{found.linkage.name}, {len(motion.joints)} joints, {loops}")]
    if found.linkage.at:
        pairs.append(("pose", found.linkage.pose))
    if found.tool is not None:
        pairs += _tool(found, found.tool)
    if motion.motion.relations:
        pairs.append(("motion", ", ".join(motion.motion.relations)))
    radius = f"{motion.radius:.3g} ({measure(found)}), estimated"
    if np.isinf(motion.radius):
        radius = "infinite: the motion is linear"
    pairs += [
        ("independent", _listed(motion.motion.inputs)),
        ("dependent", _listed(found.dependent) or "none"),
        ("order", f"{motion.order}, {len(motion.exponents)} terms"),
        ("radius", radius),
    ]
    if found.line:
        return pairs + _single(found, found.poses[0])
    return pairs + _several(found) if found.poses else pairs


def _tool(found: Predictions, link: str) -> list[tuple[str, str]]:
    """Which point moves, and that other joint angles may take it to the same place."""
    name = link
    if found.point is not None:
        at = ", ".join(f"{x:.6g}" for x in found.point)
        name = f"{link}, its point ({at}) m in the frame of the link"
    inputs = found.motion.motion.inputs
    free = [each for each in inputs if each not in tool_coordinates(link)]
    posture = (
        "the one that leads from the reference pose straight to the target; others may take "
        "the tool there too"
    )
    if free:
        posture += f", for it does not determine {_listed(tuple(free))}"
    return [("tool", name), ("posture", posture)]


def _single(found: Predictions, pose: Prediction) -> list[tuple[str, str]]:
    """Facts of the pose at the end of a line."""
    pairs = [
        ("target", assign_inputs(found.motion, pose.u)),
        ("distance", f"{pose.distance:.3g}"),
    ]
    if pose.reason:
        return [*pairs, ("verdict", f"not reached: {pose.reason}")]
    outcome = "reached, the corrected pose closes the loops"
    return [*pairs, ("error", _errors(pose.error, pose.difference)), ("verdict", outcome)]


def _several(found: Predictions) -> list[tuple[str, str]]:
    """Facts of the poses of a path."""
    count = len(found.poses)
    missed = [(k, pose) for k, pose in enumerate(found.poses, 1) if pose.reason]
    outcome = f"reached, {count} poses close the loops"
    if missed:
        first, pose = missed[0]
        outcome = f"not reached: {len(missed)} of {count} poses; pose {first}: {pose.reason}"
    far = max(pose.distance for pose in found.poses)
    return [("distance", f"up to {far:.3g}"), ("error", _largest(found)), ("verdict", outcome)]


def _largest(found: Predictions) -> str:
    """The largest errors of a path."""
    reached = [pose for pose in found.poses if not pose.reason]
    estimates = [pose.error for pose in reached if pose.error is not None]
    true = [pose.difference for pose in reached if pose.difference is not None]
    errors = _errors(max(estimates, default=None), max(true, default=None))
    if estimates and len(estimates) < len(reached):
        errors = errors.replace("estimated", "estimated within the radius of convergence", 1)
    return f"up to {errors}" if estimates else errors


def motion_tables(found: Predictions, most: int = ROWS) -> list[list[tuple[str, ...]]]:
    """Build tables of the one pose, or of the first poses of a path, and their joints.

    Args:
        found: the predictions.
        most: most poses of a path.

    Returns:
        Tables as lists of rows, the head first.
    """
    if not found.poses:
        return []
    if found.line:
        return [_joints(found, found.poses[0])]
    head = ("pose", *found.motion.motion.inputs, "distance", "estimated", "difference")
    lines = [_row(k, pose) for k, pose in enumerate(found.poses[:most], 1)]
    return [[head, *lines], _joints_of_path(found, found.poses[:most])]


def _row(number: int, pose: Prediction) -> tuple[str, ...]:
    """One pose of a path."""
    estimate = "none" if pose.error is None else f"{pose.error:.1e}"
    true = "none" if pose.difference is None else f"{pose.difference:.1e}"
    if pose.reason:
        estimate, true = "none", "not reached"
    return str(number), *(f"{x:.6g}" for x in pose.u), f"{pose.distance:.3g}", estimate, true


def _joints(found: Predictions, pose: Prediction) -> list[tuple[str, ...]]:
    """Where the joints are in one pose, or as far as they were followed.

    What the series predicts beyond its radius of convergence is no answer, and left out.
    """
    joints = found.motion.joints
    corrected, predicted = pose.corrected, pose.predicted
    head, columns = [], []
    for name, q in (("corrected", corrected), ("furthest", pose.furthest)):
        if q is not None:
            head.append(name)
            columns.append(_positions(found, q))
    if corrected is not None and predicted is not None and pose.error is not None:
        head += ["predicted", "difference"]
        columns.append(_positions(found, predicted))
        columns.append([f"{q:.1e}" if q else "0" for q in predicted - corrected])
    return [("joint", "unit", *head), *zip(joints, found.units, *columns, strict=True)]


def _joints_of_path(found: Predictions, poses: tuple[Prediction, ...]) -> list[tuple[str, ...]]:
    """Where the joints are in poses of a path."""
    columns = [
        ["-"] * len(found.units) if pose.corrected is None
        else _positions(found, pose.corrected, COARSE)
        for pose in poses
    ]  # fmt: skip
    head = ("joint", "unit", *(f"pose {k}" for k in range(1, len(poses) + 1)))
    return [head, *zip(found.motion.joints, found.units, *columns, strict=True)]


def _positions(found: Predictions, q: Array, decimals: int = FINE) -> list[str]:
    """Positions within one turn, and how many full turns there are beside it."""
    within, turns = wrap_turns(found.linkage.joints, q)
    numbers = [f"{x + 0.0:.{decimals}f}" for x in np.round(within, decimals)]
    ends = [
        f" {'+' if n > 0 else '-'} {abs(n)} turn{'s' if abs(n) > 1 else ''}" if n else ""
        for n in turns.tolist()
    ]
    width = max(map(len, ends), default=0)
    return [number + end.ljust(width) for number, end in zip(numbers, ends, strict=True)]


def motion_text(found: Predictions) -> str:
    """The report as plain text."""
    lines = [f"{label:<12} {value}" for label, value in motion_facts(found)]
    for table in motion_tables(found):
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        cells = ("  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])])
                 for row in table)  # fmt: skip
        lines += ["", *(line.rstrip() for line in cells)]
    if len(found.poses) > ROWS:
        lines.append(f"… and {len(found.poses) - ROWS} more; --json has them all")
    return "\n".join(lines)


def _errors(estimate: float | None, difference: float | None) -> str:
    """Both errors of a prediction."""
    told = "no estimate beyond the radius of convergence"
    if estimate is not None:
        told = f"{estimate:.1e} estimated"
    return told if difference is None else f"{told}, {difference:.1e} to the corrected pose"


def _listed(names: tuple[str, ...]) -> str:
    """The first names."""
    return ", ".join(names[:NAMES]) + (f" … ({len(names)})" if len(names) > NAMES else "")
