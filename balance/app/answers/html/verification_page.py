"""HTML page of verifications: the mechanism moves beside the curves of the chosen motion."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

import numpy as np

from balance.app.answers.html.before_after import (
    choose_motions,
    comparison_charts,
    comparison_section,
)
from balance.app.answers.html.render import breakable, facts_list, render_page, with_capital
from balance.app.answers.html.robot_shapes import robot_shapes
from balance.app.answers.html.scene import scene
from balance.app.answers.html.time_panels import (
    PanelColumn,
    panels_figures,
)
from balance.app.answers.html.verification import (
    motion_heading,
    panels,
    pick_samples,
    run_curves,
)
from balance.app.answers.text.verification import (
    comparison_sentence,
    verification_facts,
)
from balance.motion.verification.comparison import VerificationComparison
from balance.motion.verification.run import Run
from balance.motion.verification.verification import Verification
from balance.support.linkage_names import linkage_names
from kinematics.model.motion import while_text
from kinematics.wording import count_noun, unit_text

# Most samples of a motion on a page, and most numbers of all its motions.
MAX_SAMPLES = 201
MAX_NUMBERS = 60_000


def verification_page(*verifications: Verification, meshes: bool = True) -> str:
    """Render verifications as one HTML file.

    The page moves each linkage through the motion that is chosen, beside its curves, a polar
    plot of the shaking force, and the numbers of that motion. The element ``report`` contains
    `Verification.to_dict` of each.

    Args:
        verifications: one or more verifications.
        meshes: whether to draw the shapes of the files that have any.
    """
    names = linkage_names([verification.linkage for verification in verifications])
    shown = _motion_choice(verifications)
    # What the first was made from is the second; see `comparison_sentence`.
    pair, labels = verifications[::-1], names[::-1]
    charts, section = {}, ""
    if len(verifications) == 2:
        charts = {"comparison": comparison_charts(pair, labels)}
        section = comparison_section(pair, labels)
    return render_page(
        "verify.html",
        title=" and ".join(names) if len(names) < 3 else f"{len(names)} linkages",
        summary=_summary(verifications),
        report=[verification.to_dict() for verification in verifications],
        data={"models": _motions_data(verifications, meshes), **charts},
        scripts=["verify", *charts],
        options=_options(verifications[0], shown),
        comparison=section,
        kind="one" if len(verifications) == 1 else "several",
        models="\n".join(
            _model(k, verification, name)
            for k, (verification, name) in enumerate(zip(verifications, names, strict=True))
        ),
        facts="\n".join(
            f"<section><h3>{breakable(name)}</h3>"
            f"{facts_list(verification_facts(verification))}</section>"
            for name, verification in zip(names, verifications, strict=True)
        ),
    )


def comparison_page(comparison: VerificationComparison) -> str:
    """Render two verifications along the same motions as one HTML file."""
    return verification_page(comparison.after, comparison.before)


def _options(first: Verification, shown: Sequence[int]) -> str:
    """Render the choice of motions; the one that decides the verdict is selected."""
    lines = []
    for k, number in enumerate(shown):
        decides = number == first.plotted
        text = motion_heading(first, number) + (", which decides the verdict" * decides)
        lines.append(
            f'<option value="{k}"{" selected" * decides}>'
            f"{escape(text if first.crank else with_capital(text))}</option>"
        )
    return "".join(lines)


def _model(k: int, verification: Verification, name: str) -> str:
    """Render the places for the figures and the numbers of one linkage."""
    label = escape(name)
    return (
        f'<section class="model">\n<h2>{breakable(name)}</h2>\n'
        f'<p class="note">{escape(verification.verdict)}</p>\n'
        f'<div class="canvas" id="plot{k}" role="group" aria-label="{label} in motion: arrow '
        f'keys turn it, plus and minus magnify"></div>\n'
        f'<div class="numbers" id="numbers{k}"></div>\n'
        f'<div class="traces square" id="polar{k}" role="img" aria-label="Polar plot of the '
        f'shaking force of {label}"></div>\n'
        f'<div class="traces" id="traces{k}" role="img" aria-label="Inputs, shaking force, '
        f'shaking moment and bearing forces of {label} over time"></div>\n</section>'
    )


def _summary(verifications: Sequence[Verification]) -> str:
    """Summarise the comparison, or the verdicts, in one sentence."""
    sentence, first = comparison_sentence(verifications), verifications[0]
    if sentence is not None:
        return sentence
    if first.crank is not None:
        motions = first.crank.words
    else:
        motions = count_noun(len(first.runs), "motion")
    when = f"over {motions} ({first.duration:.4g} s)"
    if len(verifications) == 1:
        force, moment = (
            first.load_text(part, size)
            for part, size in (("force", first.force), ("moment", first.moment))
        )
        return (
            f"{with_capital(first.verdict)}{while_text(first.motion)}: shaking force {force} "
            f"peak, moment {moment} peak, {when}."
        )
    verdicts = "; ".join(
        f"{name}: {verification.verdict}"
        for name, verification in zip(
            linkage_names([verification.linkage for verification in verifications]),
            verifications,
            strict=True,
        )
    )
    return f"Shaking force and moment {when}. {verdicts}."


def _motions_data(verifications: Sequence[Verification], meshes: bool) -> list[dict[str, Any]]:
    """Collect what the page of verifications draws: for each, its scene and its motions.

    Panels of one motion have one scale for all linkages. The motion that decides the verdict
    is there; of many motions, so are those that shake most.

    Args:
        verifications: one or more verifications.
        meshes: whether to collect the shapes of the files.
    """
    chosen = _motion_choice(verifications)
    figures = [_figures(verifications, k) for k in chosen]
    reaches = [_largest_force(verifications, k) for k in chosen]
    return [
        {
            "name": verification.model,
            "scene": scene(
                verification.linkage,
                shapes=robot_shapes(verification.linkage) if meshes else (),
            ),
            "least": verification.tolerance * verification.scale,
            "runs": [
                _run_data(verification, verification.runs[k], charts[i], reach)
                for k, charts, reach in zip(chosen, figures, reaches, strict=True)
            ],
        }
        for i, verification in enumerate(verifications)
    ]


def _motion_choice(verifications: Sequence[Verification]) -> list[int]:
    """List the indices of the motions on a page, in their order, with the plotted ones."""
    count = min(len(verification.runs) for verification in verifications)
    per_motion = sum(
        min(verification.runs[0].trajectory.time.size, MAX_SAMPLES)
        * (len(verification.linkage.joints) + 6 * len(panels(verification)))
        for verification in verifications
    )
    most = int(np.clip(MAX_NUMBERS // per_motion, 1, count))
    first = verifications[0]
    peaks = [
        max(run.peak("force"), run.peak("moment") / first.length) for run in first.runs[:count]
    ]
    return choose_motions(first, peaks, most)


def _figures(verifications: Sequence[Verification], number: int) -> list[dict[str, object]]:
    """Build the curves of one motion for each linkage."""
    columns = []
    for verification in verifications:
        picked = pick_samples(verification.runs[number], MAX_SAMPLES)
        kept = [
            panel._replace(lines=panel.lines[:, picked])
            for panel in panels(verification, number)
        ]
        time = verification.runs[number].trajectory.time[picked]
        columns.append(PanelColumn(motion_heading(verification, number), time, kept))
    return panels_figures(columns)


def _largest_force(verifications: Sequence[Verification], number: int) -> float:
    """Compute how far the polar plots of one motion reach, N, the same for all linkages."""
    least = max(check.tolerance * check.scale for check in verifications)
    peaks = (
        np.abs(check.runs[number].about[:, 3:]).max(initial=0.0) for check in verifications
    )
    return max(1.05 * float(max(peaks)), least) or 1.0


def _run_data(
    verification: Verification, run: Run, chart: dict[str, object], reach: float
) -> dict[str, Any]:
    """Collect poses, curves and numbers of one motion of one linkage."""
    picked = pick_samples(run, MAX_SAMPLES)
    motion, force = run.trajectory, -run.about[picked, 3:]
    q, time = motion.q[picked], motion.time[picked]
    curves = run_curves(verification.linkage, time, q, force, reach)
    return {"chart": chart, **curves, "rows": _numbers(verification, run)}


def _numbers(verification: Verification, run: Run) -> list[tuple[str, str]]:
    """List the peaks and the root mean squares of one motion."""
    rows = []
    for part in ("force", "moment"):
        rows.append((f"shaking {part}, peak", verification.load_text(part, run.peak(part))))
        rows.append((f"shaking {part}, rms", verification.load_text(part, run.rms(part))))
    bearing = float(run.bearing.max(initial=0.0))
    rows.append(("bearing force", unit_text(bearing, "N", ".3g")))
    rows.append(("duration", f"{run.trajectory.duration:.4g} s"))
    return rows
