"""Text of results on flexible links for ``balance flex``."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerTable, Facts
from balance.motion.flexible.flex_data import beam_deflection, moment_about
from balance.motion.flexible.free_beam_modes import FreeMode
from balance.motion.flexible.from_linkage import FlexibleLinkage
from balance.motion.flexible.similarity import Arm, Similarity
from balance.motion.flexible.simulate import FlexibleMotion
from balance.motion.flexible.support_points import STATIC_POINT, SupportPoints
from balance.motion.flexible.supported_beam_modes import SupportedModes
from balance.motion.flexible.translators import TranslatorMotion
from kinematics.wording import number_text, size_text

# Most digits of a frequency.
MOST_DIGITS = 5


def free_modes_table(modes: Sequence[FreeMode]) -> AnswerTable:
    """Build the table of modes of a free beam: λ², and zeros over the length."""
    rows = [("mode", "λ² = ω √(ρA l⁴ / EI)", "zeros ± ξ from the middle")]
    for mode in modes:
        zeros = " ".join(f"{zero:.12g}" for zero in mode.zeros)
        rows.append((str(mode.number), f"{mode.frequency:.9f}", zeros))
    return AnswerTable(rows)


def supported_modes_table(modes: SupportedModes) -> AnswerTable:
    """Build the table of frequencies of a beam on supports, with the digits that hold."""
    rows = [("mode", "frequency (Hz)", "ω (rad/s)")]
    pairs = zip(modes.frequencies.tolist(), modes.errors.tolist(), strict=True)
    for number, (omega, error) in enumerate(pairs, 1):
        form = f".{_digits_that_hold(error)}g"
        # Powers of ten show how many digits hold, and zeros in their place would not.
        rows.append((str(number), f"{omega / (2.0 * np.pi):{form}}", f"{omega:{form}}"))
    return AnswerTable(rows)


def _digits_that_hold(error: float) -> int:
    """Count the significant digits of a number with a relative error, at most `MOST_DIGITS`."""
    digits = math.floor(-math.log10(error)) if error > 0.0 else MOST_DIGITS
    return min(max(digits, 1), MOST_DIGITS)


def supports_body(supports: SupportPoints) -> AnswerBody:
    """Build what is printed on supports, their weights and the whippletree of one half."""
    rows = [("point ξ", "weight")]
    pairs = zip(supports.points.tolist(), supports.weights.tolist(), strict=True)
    rows += [(f"{x:+.9f}", f"{w:.9f}") for x, w in pairs]
    modes = ", ".join(map(str, supports.modes)) or "none"
    facts = [
        ("balanced", f"symmetric modes {modes}, and all antisymmetric ones"),
        ("residual", size_text(supports.residual)),
        ("hinge", f"ξ = ±{supports.hinge:.9f}"),
        ("static", f"two points at ξ = ±{STATIC_POINT:.9f} for a uniform load"),
    ]
    facts += [
        (
            f"bar {k}",
            f"ends at {bar.ends[0]:.9f} and {bar.ends[1]:.9f}, pivot at "
            f"{bar.pivot:.9f}: arms {bar.arms[0]:.9f} and {bar.arms[1]:.9f}",
        )
        for k, bar in enumerate(supports.bars, 1)
    ]
    return [AnswerTable(rows), "", Facts(facts)]


def similarity_body(
    second: Arm,
    similarity: Similarity,
    motion: FlexibleMotion | None = None,
    translator: TranslatorMotion | None = None,
) -> AnswerBody:
    """Build what is printed on a counter-arm, its similarity, and the peaks of a simulation.

    Args:
        similarity: the comparison with the arm that it balances.
        motion: a simulation of both on one hub, if there is one.
        translator: that of translators on two of each, if there is one.
    """
    beam = second.beam
    facts = [
        (
            "counter-arm",
            f"length {number_text(beam.length, '.6g')} m, EI "
            f"{number_text(beam.bending, '.6g')} N m², "
            f"ρA {number_text(beam.line_mass, '.6g')} kg/m, tip "
            f"{number_text(second.tip_mass, '.6g')} kg",
        ),
        (
            "",
            f"tip radius {number_text(second.tip_radius, '.6g')} m, tip inertia "
            f"{number_text(second.tip_inertia, '.6g')} "
            f"kg m², hub radius {number_text(second.hub_radius, '.6g')} m",
        ),
        ("scale", number_text(similarity.scale, ".6g")),
        (
            "same material",
            f"thickness × {number_text(similarity.scale**2, '.6g')}, width × "
            f"{number_text(similarity.scale**-4, '.6g')}, "
            f"width of rigid parts × {number_text(similarity.scale**-3, '.6g')}",
        ),
        (
            "frequencies",
            " and ".join(f"{number_text(f, '.6g')} Hz" for f in similarity.frequencies),
        ),
        ("similar", "yes" if similarity.similar else "no"),
    ]
    if motion is not None:
        facts.append(("shaking force", f"{number_text(motion.peak_force)} N at most"))
        facts.append(("shaking moment", f"{number_text(motion.peak_moment)} N m at most"))
    if translator is not None:
        facts += _translator_facts(translator)
    rows = [("condition", "equal", "arm", "counter-arm", "difference")]
    for condition in similarity.conditions:
        state = "holds" if condition.holds else f"{condition.difference:+.3%}"
        rows.append(
            (
                condition.name,
                condition.words,
                number_text(condition.first, ".6g"),
                number_text(condition.second, ".6g"),
                state,
            )
        )
    return [Facts(facts), "", AnswerTable(rows)]


def _translator_facts(motion: TranslatorMotion) -> list[tuple[str, str]]:
    """List the facts on a translator and its counter-translator."""
    translator, other = motion.translator, motion.blocks[1]
    low, high = (round(1e3 * y, 2) + 0.0 for y in motion.displacement)
    hubs = "half of it on each hub" if translator.both else "on the lower hub"
    return [
        (
            "counter-block",
            f"{number_text(other.mass, '.6g')} kg, length "
            f"{number_text(other.length, '.6g')} m, breadth "
            f"{number_text(other.breadth, '.6g')} m",
        ),
        (
            "driven by",
            f"{translator.moment:g} N m, {hubs}, within {translator.rise:g} s; for "
            f"{motion.pair.times[-1]:g} s",
        ),
        ("displacement", f"{number_text(low, '.2f')} to {number_text(high, '.2f')} mm"),
        (
            "shaking force",
            f"{number_text(motion.pair.peak_force)} N at most, "
            f"{number_text(motion.reduction, '.0f')} times "
            "less than without counter-translator",
        ),
        (
            "shaking moment",
            f"{number_text(motion.pair.peak_moment)} N m at most, about the "
            "middle "
            "between the hubs",
        ),
        ("energy", f"drifts by {size_text(motion.pair.energy_drift)} of the largest"),
    ]


def flexible_motion_facts(
    linkage: FlexibleLinkage, motion: FlexibleMotion
) -> list[tuple[str, str]]:
    """List the facts on a simulation as pairs of label and value."""
    x, y = linkage.point
    moment = float(np.abs(moment_about(motion, linkage.point)).max())
    centre = "the centre of mass at the start, " if linkage.about is None else ""
    pairs = [
        ("linkage", linkage.linkage.name),
        ("duration", f"{motion.times[-1]:g} s"),
        ("shaking force", f"{number_text(motion.peak_force)} N at most"),
        (
            "shaking moment",
            f"{number_text(moment)} N m at most, about {centre}"
            f"({number_text(x)}, {number_text(y)}) m in the plane",
        ),
    ]
    for name, model in linkage.beams.items():
        peak = float(beam_deflection(motion, linkage, name).max())
        line = (
            "its tangent at the drive"
            if name in linkage.tangents
            else ("the line through its joints")
        )
        pairs.append(
            (
                name,
                f"beam of {number_text(model.part.length)} m and "
                f"{number_text(model.mesh.beam.mass)} "
                f"kg, {len(model.mesh.nodes) - 1} elements, {model.part.size} modes: "
                f"bends by {number_text(peak, '.3g')} m from {line}",
            )
        )
    pairs.append(("energy", f"drifts by {size_text(motion.energy_drift)} of the largest"))
    pairs.append(("integrator", f"{motion.method}, {motion.steps} steps"))
    return pairs
