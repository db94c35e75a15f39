"""HTML page of verifications: the mechanism moves beside the curves of the chosen motion."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from balance.app.answers.html.render import facts_list, render_page
from balance.app.answers.html.time_panels import linkage_names
from balance.app.answers.html.verification import motion_heading
from balance.app.answers.html.verification_motions import motion_choice, motions_data
from balance.app.answers.text.verification import verification_facts
from balance.motion.verification.result import Verification
from kinematics.wording import count_noun


def verification_page(verifications: Sequence[Verification], meshes: bool = True) -> str:
    """Render verifications as one HTML file.

    The page moves each linkage through the motion that is chosen, beside its curves, a polar
    plot of the shaking force, and the numbers of that motion. The element ``report`` contains
    `Verification.to_dict` of each.

    Args:
        verifications: one or more verifications.
        meshes: whether to draw the shapes of the files that have any.
    """
    names = linkage_names([verification.linkage for verification in verifications])
    shown = motion_choice(verifications)
    return render_page(
        "verify.html",
        title=" and ".join(names) if len(names) < 3 else f"{len(names)} linkages",
        summary=_summary(verifications),
        report=[verification.to_dict() for verification in verifications],
        data={"models": motions_data(verifications, meshes)},
        scripts=["verify"],
        options=_options(verifications[0], shown),
        kind="one" if len(verifications) == 1 else "several",
        models="\n".join(
            _model(k, verification, name)
            for k, (verification, name) in enumerate(zip(verifications, names, strict=True))
        ),
        facts="\n".join(
            f"<section><h3>{escape(name)}</h3>"
            f"{facts_list(verification_facts(verification))}</section>"
            for name, verification in zip(names, verifications, strict=True)
        ),
    )


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


def _model(k: int, verification: Verification, name: str) -> str:
    """Render the places for the figures and the numbers of one linkage."""
    label = escape(name)
    return (
        f'<section class="model">\n<h2>{label}</h2>\n'
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
    """Summarise the verdicts in one sentence."""
    first = verifications[0]
    verdicts = "; ".join(
        f"{name}: {verification.verdict}"
        for name, verification in zip(
            linkage_names([verification.linkage for verification in verifications]),
            verifications,
            strict=True,
        )
    )
    if first.crank is not None:
        motions = f"one revolution of {first.crank.joint} at {first.crank.rpm:.6g} rpm"
    else:
        motions = count_noun(len(first.runs), "motion")
    return f"Shaking force and moment over {motions} ({first.duration:.4g} s). {verdicts}."
