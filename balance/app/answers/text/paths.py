"""Text of reactionless paths for ``balance paths``.

`ReactionlessPaths.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.motion.motion_tolerances import LOCAL_CURVE_STEP
from balance.motion.paths.path import ReactionlessPath
from balance.motion.paths.reactionless_paths import ReactionlessPaths, StartPose
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, vector_text

# Most inputs in a line, most lines of a table, and most directions at a meeting.
MAX_INPUTS = 6
MAX_ROWS = 30
MAX_DIRECTIONS = 4
KINDS = {
    "none": "no rates without reaction",
    "regular": "regular",
    "crossing": "several paths meet",
    "fold": "two paths touch, or one folds",
    "isolated": "rates without reaction, but no path",
}
HEAD = ("path", "through", "direction", "length", "momentum", "ends")


def paths_facts(solution: ReactionlessPaths) -> list[tuple[str, str]]:
    """List the facts on paths as pairs of label and value."""
    linkage = solution.linkage
    unit = linkage.spatial_chain.frame.length
    pairs = linkage_facts(linkage, f"inputs {', '.join(linkage.inputs)}")
    pairs.append(("at rest", solution.demand.words))
    if solution.motion is not None:
        pairs.append(("motion", ", ".join(solution.motion.relations)))
    width = len(solution.starts[0].values)
    pairs += [
        (
            "null space",
            f"{solution.dimension} of {width} rates in general, by {solution.poses} poses",
        ),
        ("lengths", f"radians and lengths of {number_text(unit, '.3g')} m, in all joints"),
    ]
    for number, start in enumerate(solution.starts[:MAX_ROWS], 1):
        pairs.append((f"pose {number}", _start_words(solution, start)))
    for start in solution.meetings:
        if not any(np.abs(start.q - pose.q).max() < 1e-6 for pose in solution.starts):
            pairs.append(("meeting", _meeting_words(solution, start)))
    if solution.tool is not None:
        tool = solution.tool
        reach = max(tool.lengths, default=0.0)
        words = f"{tool.link}, its point at {vector_text(tool.point)} m"
        pairs.append(("tool", f"{words}, is taken up to {number_text(reach, '.3g')} m"))
    if not solution.paths:
        pairs.append(("no path", solution.reason))
    return pairs


def _named(solution: ReactionlessPaths, values: Array, digits: int = 4) -> str:
    """Format values of the inputs: ``u1=0.3, u2=-0.1``."""
    pairs = zip(solution.linkage.inputs, values.tolist(), strict=True)
    texts = [f"{name}={number_text(value, f'.{digits}g', 1.0)}" for name, value in pairs]
    return ", ".join([*texts[:MAX_INPUTS], *["…"] * (len(texts) > MAX_INPUTS)])


def _start_words(solution: ReactionlessPaths, start: StartPose) -> str:
    """Describe a start: where it is, and what kind of pose."""
    words = f"{_named(solution, start.u)}: {KINDS[start.kind]}, null space {start.dimension}"
    if start.distance > LOCAL_CURVE_STEP:
        words += f" ({number_text(start.distance, '.2g')} from the pose asked for)"
    return words


def _meeting_words(solution: ReactionlessPaths, start: StartPose) -> str:
    """Describe a meeting of paths: where it is, and the directions."""
    ways = " | ".join(_named(solution, way, 3) for way in start.directions[:MAX_DIRECTIONS])
    more = len(start.directions) - MAX_DIRECTIONS
    ways += f" | and {more} more" if more > 0 else ""
    where = f"{_named(solution, start.u)}: {KINDS[start.kind]}"
    return f"{where} along {ways}" if ways else where


def path_rows(solution: ReactionlessPaths) -> list[tuple[str, ...]]:
    """Build the table of paths, its head first."""
    rows = [HEAD, *(_row(solution, k, path) for k, path in enumerate(solution.paths, 1))]
    if solution.tool is None:
        return rows
    ways = ["tool way (m)", *(number_text(way, ".3g") for way in solution.tool.lengths)]
    return [(*row[:5], way, *row[5:]) for row, way in zip(rows, ways, strict=True)]


def _row(solution: ReactionlessPaths, number: int, path: ReactionlessPath) -> tuple[str, ...]:
    """Build the row of one path."""
    ends = " | ".join(f"{event.text} at {number_text(event.s)}" for event in path.events)
    direction = path.direction / (np.linalg.norm(path.direction) or 1.0)
    return (
        str(number),
        f"pose {path.start + 1}",
        _named(solution, direction, 3),
        number_text(path.length),
        path.residual_text,
        ends,
    )


def paths_body(solution: ReactionlessPaths) -> AnswerBody:
    """Build what is printed on paths."""
    facts = Facts(paths_facts(solution))
    if not solution.paths:
        return [facts]
    return [facts, "", AnswerTable(path_rows(solution)[: MAX_ROWS + 1])]
