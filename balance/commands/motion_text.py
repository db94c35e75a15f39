"""What the poses of a Taylor motion say, as text; nothing here prints.

The same as data is `Predictions.to_dict`, the contract of ``balance motion --json``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from balance.motions.prediction import Prediction, Predictions, assigned

__all__ = ["facts", "measure", "rows", "text"]

Array = NDArray[np.float64]

# Poses shown, and names in a line.
ROWS, NAMES = 6, 12


def measure(found: Predictions) -> str:
    """In what distances and errors are measured."""
    return f"radians and lengths of {found.length:.3g} m"


def facts(found: Predictions) -> list[tuple[str, str]]:
    """The report without its table, as pairs of a label and a value."""
    motion, count = found.motion, len(found.linkage.loops)
    loops = f"{count} loop{'' if count == 1 else 's'}"
    pairs = [("linkage", f"{found.linkage.name}, {len(motion.joints)} joints, {loops}")]
    if found.linkage.at:
        pairs.append(("pose", found.linkage.pose))
    if found.tool is not None:
        pairs.append(("tool", found.tool))
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


def _single(found: Predictions, pose: Prediction) -> list[tuple[str, str]]:
    """Facts of the pose at the end of a line."""
    outcome = "reached, the corrected pose closes the loops"
    return [
        ("target", assigned(found.motion, pose.u)),
        ("distance", f"{pose.distance:.3g}"),
        ("error", _errors(pose.error, pose.difference)),
        ("verdict", f"not reached: {pose.reason}" if pose.reason else outcome),
    ]


def _several(found: Predictions) -> list[tuple[str, str]]:
    """Facts of the poses of a path."""
    count = len(found.poses)
    missed = [(k, pose) for k, pose in enumerate(found.poses, 1) if pose.reason]
    true = [pose.difference for pose in found.poses if pose.difference is not None]
    outcome = f"reached, {count} poses close the loops"
    if missed:
        first, pose = missed[0]
        outcome = f"not reached: {len(missed)} of {count} poses; pose {first}: {pose.reason}"
    errors = _errors(max(pose.error for pose in found.poses), max(true, default=None))
    return [
        ("distance", f"up to {max(pose.distance for pose in found.poses):.3g}"),
        ("error", f"up to {errors}"),
        ("verdict", outcome),
    ]


def rows(found: Predictions, most: int = ROWS) -> list[tuple[str, ...]]:
    """The joints of the one pose, or the first poses of a path, as a table; its head first."""
    if found.line:
        return _joints(found, found.poses[0])
    head = ("pose", *found.motion.motion.inputs, "distance", "estimated", "difference")
    lines = [_row(k, pose) for k, pose in enumerate(found.poses[:most], 1)]
    return [head, *lines] if lines else []


def _row(number: int, pose: Prediction) -> tuple[str, ...]:
    """One pose of a path."""
    true = "not reached" if pose.difference is None else f"{pose.difference:.1e}"
    u = (f"{x:.6g}" for x in pose.u)
    return str(number), *u, f"{pose.distance:.3g}", f"{pose.error:.1e}", true


def _joints(found: Predictions, pose: Prediction) -> list[tuple[str, ...]]:
    """Where the joints are in one pose."""
    predicted = _positions(pose.predicted)
    corrected = difference = [""] * len(predicted)
    if pose.corrected is not None:
        corrected = _positions(pose.corrected)
        difference = [f"{q:.1e}" if q else "0" for q in pose.predicted - pose.corrected]
    head = ("joint", "unit", "predicted", "corrected", "difference")
    columns = (found.motion.joints, found.units, predicted, corrected, difference)
    return [head, *zip(*columns, strict=True)]


def _positions(q: Array) -> list[str]:
    """Positions with nine decimals; nothing is less than zero."""
    return [f"{x + 0.0:.9f}" for x in np.round(q, 9)]


def text(found: Predictions) -> str:
    """The report as plain text."""
    lines = [f"{label:<12} {value}" for label, value in facts(found)]
    if table := rows(found):
        widths = [max(map(len, column)) for column in zip(*table, strict=True)]
        cells = ("  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])])
                 for row in table)  # fmt: skip
        lines += ["", *(line.rstrip() for line in cells)]
    if len(found.poses) > ROWS:
        lines.append(f"… and {len(found.poses) - ROWS} more; --json has them all")
    return "\n".join(lines)


def _errors(estimate: float, difference: float | None) -> str:
    """Both errors of a prediction."""
    true = "" if difference is None else f", {difference:.1e} to the corrected pose"
    return f"{estimate:.1e} estimated{true}"


def _listed(names: tuple[str, ...]) -> str:
    """The first names."""
    return ", ".join(names[:NAMES]) + (f" … ({len(names)})" if len(names) > NAMES else "")
