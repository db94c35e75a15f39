"""Page of a planned motion: the linkage moves as planned, beside the law that it replaces."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any, NamedTuple

import numpy as np

from balance.app.answers.answer import AnswerTable
from balance.app.answers.html.plot_style import short
from balance.app.answers.html.render import facts_list, render_page, rows_table, with_capital
from balance.app.answers.html.robot_shapes import robot_shapes
from balance.app.answers.html.scene import scene
from balance.app.answers.html.time_panels import (
    COLOURS,
    MAX_LINES,
    Panel,
    PanelColumn,
    drives_title,
    inputs_title,
    panels_figures,
)
from balance.app.answers.html.verification import run_curves
from balance.app.answers.text.quiet import MEASURES, quiet_body, quiet_facts
from balance.motion.motion_tolerances import SHAKING_RELATIVE
from balance.motion.quiet.quiet_motion_result import MotionFigures, QuietMotion
from balance.motion.quiet.sampled_loads import SampledLinkage
from balance.motion.verification.input_paths import InputPath
from balance.motion.verification.shaking_wrench import move_wrenches
from balance.motion.verification.trajectory import Trajectory, drive
from kinematics.errors import PoseError
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import rank_least_first
from kinematics.wording import number_text

# Samples of a motion on the page.
SAMPLES = 201
# Place and caption of the curve of time and shaking.
FRONT_FIGURE = (
    '<figure>\n<div class="traces low" id="front_curve" role="img" aria-label="Least shaking '
    'over the duration"></div>\n<figcaption><b>Figure 2.</b> The price of time: no timing of '
    "this path within the limits shakes less than the line. Marks: the plan and the laws of "
    "the given duration; a cross exceeds a limit.</figcaption>\n</figure>"
)


class _Shown(NamedTuple):
    """A motion that the page shows.

    Attributes:
        name: of the motion.
        motion: of all joints.
        wrench: of the linkage on its base, about the point of the moments (N, 6).
        torque: of the inputs (N, inputs).
        figures: what it shakes.
    """

    name: str
    motion: Trajectory
    wrench: Array
    torque: Array
    figures: MotionFigures


def quiet_page(plan: QuietMotion, meshes: bool = True) -> str:
    """Render a plan as one HTML file.

    The linkage moves as planned and by the quintic law, with Play and a slider of time; below
    each are the shaking force and moment, the torques, and the inputs with their speeds and
    accelerations over time; with the front of a path, the least shaking over the duration. The
    element ``report`` contains `QuietMotion.to_dict`.

    Args:
        meshes: whether to draw the shapes of the file, if it has any.
    """
    motions = _motions(plan)
    tables = [part.rows for part in quiet_body(plan) if isinstance(part, AnswerTable)]
    return render_page(
        "quiet.html",
        title=plan.linkage.name,
        summary=_summary(plan),
        report=plan.to_dict(),
        data={
            "models": _models(plan, motions, meshes),
            **({"front": _front_chart(plan)} if plan.front else {}),
        },
        scripts=["verify", *["front"] * bool(plan.front)],
        motion="a cycle" if plan.harmonics is not None else "from rest to rest",
        kind="one" if len(motions) == 1 else "several",
        models="\n".join(_place(k, shown.name) for k, shown in enumerate(motions)),
        caption=_caption(plan, motions),
        shaking=rows_table(tables[0], range(1, 6)),
        inputs=rows_table(tables[1], range(1, len(tables[1][0]))),
        more="\n".join([*map(_table, tables[2:]), *[FRONT_FIGURE] * bool(plan.front)]),
        facts=facts_list(quiet_facts(plan)),
    )


def _table(rows: Sequence[Sequence[str]]) -> str:
    """Render a further table: poses that are passed, or the price of time."""
    title = "Poses that are passed" if rows[0][-1] == "tool" else "Time and shaking"
    table = rows_table(rows, range(len(rows[0])))
    return f'<h2>{title}</h2>\n<div class="scroll wide">\n{table}\n</div>'


def _motions(plan: QuietMotion) -> list[_Shown]:
    """Compute the motions that are shown: that of the answer, and the quintic law."""
    name = "planned" if plan.law == "planned" else f"{plan.law} law"
    pairs = [(name, plan.path, plan.after)]
    law = plan.laws[0]
    if law.figures is not None and plan.law != law.name:
        pairs.append((f"{law.name} law", law.path, law.figures))
    model = SampledLinkage.of(plan.linkage, np.array(plan.gravity))
    return [
        shown
        for name, path, figures in pairs
        if (shown := _shown(plan, model, name, path, figures)) is not None
    ]


def _shown(
    plan: QuietMotion, model: SampledLinkage, name: str, path: InputPath, figures: MotionFigures
) -> _Shown | None:
    """Compute one motion; None if its loops cannot be closed."""
    time = np.linspace(0.0, plan.duration, SAMPLES)
    try:
        motion = drive(plan.linkage, time, *path.at(time))
    except PoseError:
        return None
    poses = model.close(motion.q)
    if poses is None:
        return None
    loads = model.loads(poses, motion.ud[..., None], motion.udd[..., None])[..., 0]
    wrench = move_wrenches(loads[:, :6], plan.objective.point)
    return _Shown(name, motion, wrench, loads[:, 6:], figures)


def _front_chart(plan: QuietMotion) -> dict[str, object]:
    """Build traces and layout of the least shaking over the duration, and of the laws."""
    durations, values = (short(np.array(column)) for column in zip(*plan.front, strict=True))
    traces: list[dict[str, object]] = [
        {
            "type": "scatter",
            "mode": "lines+markers",
            "name": "least",
            "x": durations,
            "y": values,
            "line": {"color": COLOURS[0], "width": 2},
            "marker": {"color": COLOURS[0], "size": 5},
        }
    ]
    shown = [("planned" if plan.law == "planned" else plan.law, plan.after, plan.feasible)]
    shown += [
        (law.name, law.figures, law.within)
        for law in plan.laws
        if law.figures is not None and law.name != plan.law
    ]
    for (name, figures, within), colour in zip(shown, COLOURS[1:], strict=False):
        traces.append(
            {
                "type": "scatter",
                "mode": "markers",
                "name": name,
                "x": [plan.duration],
                "y": short(np.array([figures.value])),
                "marker": {
                    "color": colour,
                    "size": 9,
                    "symbol": "circle" if within else "x",
                },
            }
        )
    least = SHAKING_RELATIVE * plan.inertia_force
    highest = max(value for _, value in plan.front)
    highest = max(highest, least, *(figures.value for _, figures, _ in shown))
    unit, measure = plan.objective.unit, MEASURES[plan.objective.measure]
    layout = {
        "showlegend": True,
        "xaxis": {"title": {"text": "duration (s)"}},
        "yaxis": {"title": {"text": f"{measure} ({unit})"}, "range": [0.0, 1.05 * highest]},
    }
    return {"data": traces, "layout": layout}


def _summary(plan: QuietMotion) -> str:
    """Summarise the page in a sentence: the verdict, and the change."""
    changes = [
        f"{name}: {text}"
        for name, text in quiet_facts(plan)
        if name in ("quintic", "trapezoidal") and plan.feasible
    ]
    sentence = "; ".join([plan.words, *changes])
    return f"{with_capital(sentence)}."


def _caption(plan: QuietMotion, motions: Sequence[_Shown]) -> str:
    """Describe the figure."""
    beside = f", and by the {escape(motions[1].name)}" if len(motions) > 1 else ""
    return (
        f"The mechanism as {escape(motions[0].name)}{beside}, with the path of its centre of "
        "mass and an arrow for the shaking force; the polar plot is the tip of that arrow. "
        "Curves: size of the shaking force and moment, torques and forces of the inputs with "
        "gravity, and the time law: inputs, speeds and accelerations. Curves in one row have "
        "one scale."
    )


def _place(k: int, name: str) -> str:
    """Render the places for the figures and the numbers of one motion."""
    label = escape(name)
    return (
        f'<section class="model">\n<h2>{label[0].upper()}{label[1:]}</h2>\n'
        f'<div class="canvas" id="plot{k}" role="group" aria-label="{label}: arrow keys turn '
        f'it, plus and minus magnify"></div>\n'
        f'<div class="numbers" id="numbers{k}"></div>\n'
        f'<div class="traces square" id="polar{k}" role="img" aria-label="Polar plot of the '
        f'shaking force, {label}"></div>\n'
        f'<div class="traces" id="traces{k}" role="img" aria-label="Shaking force and moment, '
        f'torques, inputs, speeds and accelerations over time, {label}"></div>\n</section>'
    )


def _models(plan: QuietMotion, motions: Sequence[_Shown], meshes: bool) -> list[dict[str, Any]]:
    """Collect what the script draws: for each motion its scene and its curves."""
    shapes = robot_shapes(plan.linkage) if meshes else ()
    least = SHAKING_RELATIVE * plan.inertia_force
    charts = panels_figures(
        [PanelColumn("", shown.motion.time, _panels(plan, shown, least)) for shown in motions]
    )
    reach = max(float(np.abs(shown.wrench[:, 3:]).max()) for shown in motions)
    drawn = scene(plan.linkage, shapes=shapes)
    return [
        {
            "name": shown.name,
            "scene": drawn,
            "least": least,
            "runs": [_run(plan, shown, chart, max(1.05 * reach, least) or 1.0)],
        }
        for shown, chart in zip(motions, charts, strict=True)
    ]


def _panels(plan: QuietMotion, shown: _Shown, least: float) -> list[Panel]:
    """Build the panels of a motion."""
    names, motion = plan.linkage.inputs, shown.motion
    ranked = rank_least_first((-np.ptp(motion.u, axis=0)).tolist())
    chosen = sorted(ranked[:MAX_LINES])
    labels = tuple(names[k] for k in chosen)
    sizes = [np.linalg.norm(shown.wrench[:, part], axis=1) for part in (slice(3, 6), slice(3))]
    acceleration = inputs_title(plan.linkage, "acceleration", "/s²")
    return [
        Panel("shaking force (N)", ("",), sizes[0][None], least),
        Panel("shaking moment (N m)", ("",), sizes[1][None], least),
        Panel(drives_title(plan.linkage), labels, shown.torque[:, chosen].T),
        Panel(inputs_title(plan.linkage), labels, motion.u[:, chosen].T),
        Panel(inputs_title(plan.linkage, "speed", "/s"), labels, motion.ud[:, chosen].T),
        Panel(acceleration, labels, motion.udd[:, chosen].T),
    ]


def _run(
    plan: QuietMotion, shown: _Shown, chart: dict[str, object], reach: float
) -> dict[str, Any]:
    """Collect poses, curves and numbers of one motion."""
    motion, force = shown.motion, -shown.wrench[:, 3:]
    curves = run_curves(plan.linkage, motion.time, motion.q, force, reach)
    return {"chart": chart, **curves, "rows": _numbers(plan, shown.figures)}


def _numbers(plan: QuietMotion, figures: MotionFigures) -> list[tuple[str, str]]:
    """List the peaks and the root mean squares of one motion."""
    rows = [
        ("shaking force", f"{plan.size_text(figures.force_peak)} N"),
        ("shaking force, rms", f"{plan.size_text(figures.force_rms)} N"),
        ("shaking moment", f"{plan.size_text(figures.moment_peak)} N m"),
        ("shaking moment, rms", f"{plan.size_text(figures.moment_rms)} N m"),
    ]
    kinds = {joint.name: joint.kind for joint in plan.linkage.joints}
    for name, value in zip(plan.linkage.inputs[:MAX_LINES], figures.torque, strict=False):
        what, unit = ("force", "N") if kinds.get(name) == "prismatic" else ("torque", "N m")
        rows.append((f"{what} {name}", f"{number_text(float(value), '.3g')} {unit}"))
    return [*rows, ("duration", f"{number_text(plan.duration)} s")]
