"""HTML page of verifications: the mechanism moves beside the curves of the chosen motion."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from balance.report.html.render import facts_list, render_page
from balance.report.html.time_panels import linkage_names
from balance.report.html.verification import motion_heading
from balance.report.html.verification_motions import motion_choice, motions_data
from balance.report.text.verification import verification_facts
from balance.verification.result import Verification
from kinematics.wording import count_noun

__all__ = ["verification_page"]


def verification_page(found: Sequence[Verification], meshes: bool = True) -> str:
    """Render verifications as one HTML file.

    The page moves each linkage through the motion that is chosen, beside its curves, a polar
    plot of the shaking force, and the numbers of that motion. The element ``report`` contains
    `Verification.to_dict` of each.

    Args:
        found: one or more verifications.
        meshes: whether to draw the shapes of the files that have any.
    """
    names = linkage_names([one.linkage for one in found])
    shown = motion_choice(found)
    return render_page(
        "verify.html",
        title=" and ".join(names) if len(names) < 3 else f"{len(names)} linkages",
        summary=_summary(found),
        report=[one.to_dict() for one in found],
        data={"models": motions_data(found, meshes)},
        scripts=["verify"],
        options=_options(found[0], shown),
        kind="one" if len(found) == 1 else "several",
        models="\n".join(_model(k, one, name)
                         for k, (one, name) in enumerate(zip(found, names, strict=True))),
        facts="\n".join(
            f"<section><h3>{escape(name)}</h3>{facts_list(verification_facts(one))}</section>"
            for name, one in zip(names, found, strict=True)
        ),
    )  # fmt: skip


def _options(first: Verification, shown: Sequence[int]) -> str:
    """Render the choice of motions; the one that decides the verdict is selected."""
    lines = []
    for k, number in enumerate(shown):
        decides = number == first.plotted
        text = motion_heading(first, number) + (", which decides the verdict" * decides)
        lines.append(
            f'<option value="{k}"{" selected" * decides}>'
            f"{escape(text[0].upper() + text[1:])}</option>"
        )
    return "".join(lines)


def _model(k: int, found: Verification, name: str) -> str:
    """Render the places for the figures and the numbers of one linkage."""
    label = escape(name)
    return (
        f'<section class="model">\n<h2>{label}</h2>\n'
        f'<p class="note">{escape(found.verdict)}</p>\n'
        f'<div class="canvas" id="plot{k}" role="group" aria-label="{label} in motion: arrow '
        f'keys turn it, plus and minus magnify"></div>\n'
        f'<div class="numbers" id="numbers{k}"></div>\n'
        f'<div class="traces square" id="polar{k}" role="img" aria-label="Polar plot of the '
        f'shaking force of {label}"></div>\n'
        f'<div class="traces" id="traces{k}" role="img" aria-label="Inputs, shaking force, '
        f'shaking moment and bearing forces of {label} over time"></div>\n</section>'
    )


def _summary(found: Sequence[Verification]) -> str:
    """Summarise the verdicts in one sentence."""
    first = found[0]
    verdicts = "; ".join(
        f"{name}: {one.verdict}"
        for name, one in zip(linkage_names([one.linkage for one in found]), found, strict=True)
    )
    if first.crank is not None:
        motions = f"one revolution of {first.crank.joint} at {first.crank.rpm:.6g} rpm"
    else:
        motions = count_noun(len(first.runs), "motion")
    return f"Shaking force and moment over {motions} ({first.duration:.4g} s). {verdicts}."
