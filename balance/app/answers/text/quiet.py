"""Text of planned motions for ``balance quiet``.

`QuietMotion.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from math import isfinite

import numpy as np

from balance.app.answers.answer import MISSING, AnswerBody, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.motion.motion_tolerances import QUIET_INPUT_RESTS
from balance.motion.quiet.quiet_motion_result import MotionFigures, QuietMotion
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, number_text, vector_text

# Most inputs in a line.
MAX_INPUTS = 6
MEASURES = {"rms": "root mean square", "peak": "peak"}
PARTS = {"force": "shaking force", "moment": "shaking moment", "both": "shaking"}
HEAD = (
    "motion",
    "force rms (N)",
    "force peak (N)",
    "moment rms (N m)",
    "moment peak (N m)",
    "minimised",
    "limits",
)
INPUT_HEAD = (
    "input",
    "from",
    "to",
    "peak speed",
    "limit",
    "peak acceleration",
    "limit",
    "peak torque",
    "limit",
)


def quiet_facts(plan: QuietMotion) -> list[tuple[str, str]]:
    """List the facts on a plan as pairs of label and value."""
    linkage, objective = plan.linkage, plan.objective
    names = linkage.inputs
    shown = ", ".join([*names[:MAX_INPUTS], *["…"] * (len(names) > MAX_INPUTS)])
    pairs = linkage_facts(linkage, f"inputs {shown}")
    how = "from rest to rest"
    if plan.harmonics is not None:
        how = f"a cycle of {count_noun(plan.harmonics, 'harmonic')}"
    pairs.append(("duration", f"{number_text(plan.duration)} s, {how}"))
    what = f"{MEASURES[objective.measure]} of the {PARTS[objective.part]}"
    if objective.part != "force":
        what += f", moment about {vector_text(objective.point)} m"
    if objective.part == "both":
        what += f", {number_text(objective.length)} N m count as 1 N"
    pairs.append(("minimised", what))
    if plan.frequencies:
        frequencies = ", ".join(number_text(value) for value in plan.frequencies)
        pairs.append(("not excited", f"{frequencies} Hz"))
    pairs.append(("verdict", plan.words))
    if plan.law != "planned":
        pairs.append(("motion", f"the {plan.law} law: no plan that was found shakes less"))
    for law in plan.laws:
        if plan.feasible and law.figures is not None:
            pairs.append((law.name, _change_text(plan, law.figures)))
    return pairs


def _change_text(plan: QuietMotion, law: MotionFigures) -> str:
    """Say how much less, or more, a plan shakes than a law."""
    if plan.is_round_off(law.value):
        return "does not shake"
    percent = 100.0 * (1.0 - plan.after.value / law.value)
    word = "less" if percent >= 0.0 else "more"
    return f"the plan shakes {number_text(abs(percent), '.3g')} % {word}"


def _motion_rows(plan: QuietMotion) -> list[tuple[str, ...]]:
    """Build the table of what motions shake, its head first."""
    rows = [HEAD, _figures_row(plan, "planned", plan.after, plan.feasible)]
    for law in plan.laws:
        if law.figures is None:
            rows.append((law.name, *[MISSING] * 5, "loops do not close"))
        else:
            rows.append(_figures_row(plan, law.name, law.figures, law.within))
    return rows


def _figures_row(
    plan: QuietMotion, name: str, figures: MotionFigures, within: bool
) -> tuple[str, ...]:
    """Build the row of one motion."""
    values = (
        figures.force_rms,
        figures.force_peak,
        figures.moment_rms,
        figures.moment_peak,
        figures.value,
    )
    return (name, *map(plan.size_text, values), "kept" if within else "exceeded")


def _input_rows(plan: QuietMotion) -> list[tuple[str, ...]]:
    """Build the table of the inputs, its head first."""
    upper, after = plan.limits.upper, plan.after
    columns = (
        plan.start,
        plan.end,
        after.velocity,
        upper[1],
        after.acceleration,
        upper[2],
        after.torque,
        upper[4],
    )
    rows: list[tuple[str, ...]] = [INPUT_HEAD]
    peaks = after.velocity, after.acceleration, after.torque
    scales = [0.0] * len(columns)
    scales[2::2] = (float(np.max(column, initial=0.0)) for column in peaks)
    for name, *values in zip(plan.linkage.inputs, *columns, strict=True):
        texts = (
            number_text(x, scale=scale, floor=QUIET_INPUT_RESTS) if isfinite(x) else MISSING
            for x, scale in zip(map(float, values), scales, strict=True)
        )
        rows.append((name, *texts))
    return rows


def _passed_rows(plan: QuietMotion) -> list[tuple[str, ...]]:
    """Build the table of the poses that are passed, its head first."""
    rows: list[tuple[str, ...]] = [("passed at (s)", *plan.linkage.inputs, "tool")]
    for point in plan.passed:
        values = (number_text(x, ".4g") for x in _round_off_to_zero(point.u).tolist())
        rows.append((number_text(point.time, ".3g"), *values, point.tool or MISSING))
    return rows


def _round_off_to_zero(u: Array) -> Array:
    """Replace displacements that are round-off of a plan by zero."""
    return np.where(np.abs(u) < 1e-9, 0.0, u)


def quiet_body(plan: QuietMotion) -> AnswerBody:
    """Build what is printed on a plan."""
    body: list = [Facts(quiet_facts(plan)), "", AnswerTable(_motion_rows(plan), "<>")]
    body += ["", AnswerTable(_input_rows(plan), "<>")]
    if plan.passed:
        body += ["", AnswerTable(_passed_rows(plan), ">")]
    if plan.front:
        unit = plan.objective.unit
        rows = [(number_text(at), plan.size_text(value)) for at, value in plan.front]
        body += ["", AnswerTable([("duration (s)", f"least shaking ({unit})"), *rows], ">")]
    return body
