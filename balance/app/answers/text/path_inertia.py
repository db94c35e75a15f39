"""Text of paths over ratios of inertia, and of moments of inertia for a path through poses."""

from __future__ import annotations

from balance.app.answers.answer import AnswerBody, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.motion.motion_tolerances import PATH_MOMENTUM
from balance.motion.paths.demand import Demand
from balance.motion.paths.inertia_ratios import InertiaChart, PathMoments
from kinematics.wording import number_text, size_text


def chart_facts(chart: InertiaChart) -> list[tuple[str, str]]:
    """List the facts on paths over ratios of inertia as pairs of label and value."""
    first = chart.solutions[0]
    linkage = first.linkage
    pairs = linkage_facts(linkage, f"inputs {', '.join(linkage.inputs)}")
    pairs.append(("at rest", first.demand.words))
    pairs.append(("moments", f"those of {chart.link} times a factor; mass and centre stay"))
    unit = number_text(linkage.spatial_chain.frame.length, ".3g")
    pairs.append(("lengths", f"radians and lengths of {unit} m, in all joints"))
    if first.tool is not None:
        pairs.append(("tool", first.tool.link))
    return pairs


def chart_rows(chart: InertiaChart) -> list[tuple[str, ...]]:
    """Build the table of the paths for each factor, its head first."""
    rows: list[tuple[str, ...]] = [("factor", "path", "length", "momentum", "ends")]
    for factor, solution in zip(chart.factors, chart.solutions, strict=True):
        if not solution.paths:
            rows.append((number_text(factor), "none", "", "", solution.reason))
        for k, path in enumerate(solution.paths, 1):
            ends = [f"{event.text} at {number_text(event.s)}" for event in path.events]
            numbers = number_text(factor), str(k), number_text(path.length)
            rows.append((*numbers, path.residual_text, " | ".join(ends)))
    return rows


def chart_body(chart: InertiaChart) -> AnswerBody:
    """Build what is printed on paths over ratios of inertia."""
    return [Facts(chart_facts(chart)), "", AnswerTable(chart_rows(chart))]


def moments_facts(answer: PathMoments) -> list[tuple[str, str]]:
    """List the facts on moments of inertia for a path through poses as pairs."""
    linkage = answer.linkage
    pairs = linkage_facts(linkage, f"inputs {', '.join(linkage.inputs)}")
    pairs.append(("at rest", Demand(answer.kept).words))
    for number, pose in enumerate(answer.poses, 1):
        values = zip(linkage.inputs, pose.tolist(), strict=True)
        text = ", ".join(f"{name}={number_text(value, '.4g', 1.0)}" for name, value in values)
        pairs.append((f"pose {number}", text))
    if answer.reason:
        pairs.append(("no path", answer.reason))
    else:
        size = size_text(answer.residual, floor=PATH_MOMENTUM)
        pairs.append(("momentum", f"{size} of the bodies' own"))
    return pairs


def moments_rows(answer: PathMoments) -> list[tuple[str, ...]]:
    """Build the table of links and factors, its head first."""
    pairs = answer.factors.items()
    return [("link", "moments of inertia times"), *((k, number_text(v)) for k, v in pairs)]


def moments_body(answer: PathMoments) -> AnswerBody:
    """Build what is printed on moments of inertia for a path through poses."""
    facts = Facts(moments_facts(answer))
    return [facts] if answer.reason else [facts, "", AnswerTable(moments_rows(answer))]
