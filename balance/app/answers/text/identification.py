"""Text of identified masses and of exciting motions for ``balance identify``.

`Identification.to_dict` and `ExcitingMotion.to_dict` have the same content as data.
"""

from __future__ import annotations

import numpy as np

from balance.app.answers.answer import MISSING, AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.masses.identification.exciting_motion import ExcitingMotion
from balance.masses.identification.identification import Identification, Identified
from balance.masses.identification.measurements import WRENCH
from balance.support.tolerances import NOISE_LEAST
from kinematics.wording import count_noun, number_text, size_text, vector_text

# Standard errors below which a difference is written as 0.
OFF_ZERO = 0.05
LOAD_UNITS = (("force", "N"), ("moment", "N m"))
HEAD = ("combination", "unit", "file", "measured", "1 sigma", "file off by (sigma)")


def identification_facts(answer: Identification) -> list[tuple[str, str]]:
    """List the facts on an identification as pairs of label and value."""
    space, several = answer.space, len(answer.recordings) > 1
    pairs = linkage_facts(space.linkage, f"{space.balance} balance")
    pairs += [
        (f"recording {k}" if several else "measured", recording.words)
        for k, recording in enumerate(answer.recordings, 1)
    ]
    if answer.cutoff is not None:
        told = f"below {number_text(answer.cutoff)} Hz, two samples a period"
        pairs.append(("filtered", told))
    weight = f"gravity {vector_text(answer.gravity)} m/s²"
    if not answer.gravity.any():
        weight = "without gravity"
    pairs.append(("loads", f"{weight}, moments about {vector_text(answer.point)} m"))
    pairs.append(("verdict", answer.words))
    pairs.append(
        (
            "excited",
            f"{count_noun(answer.excited, 'combination')}, also those that only gravity loads "
            f"excite; condition number {number_text(answer.condition)} of those for balance",
        )
    )
    pairs += [_shaking_fact(answer, name, unit) for name, unit in LOAD_UNITS]
    if max(answer.load_errors) > 0.0:
        force, moment = (number_text(x, ".2g") for x in answer.load_errors)
        pairs.append(
            ("table", f"its decimals leave loads off by up to {force} N and {moment} N m (rms)")
        )
    for name, value in answer.sensors.items():
        error, told = answer.sensor_errors[name], "cannot be told from the masses"
        if value is not None and error is not None:
            told = f"{number_text(value)} ± {number_text(error, '.2g')}"
        pairs.append((name, told))
    return pairs


def _shaking_fact(answer: Identification, name: str, unit: str) -> tuple[str, str]:
    """Describe the shaking force or moment by the file and as identified."""
    before, after = (getattr(x, name) for x in (answer.before, answer.after))
    parts = [getattr(x, f"{name}_share") for x in (answer.before, answer.after)]
    # What it would be if no body cancelled the load of another.
    scale = after / parts[1] if parts[1] > 0.0 else 1.0
    given, identified = (size_text(x, ".4g", scale, NOISE_LEAST) for x in (before, after))
    error = size_text(getattr(answer.after, f"{name}_error"), ".2g", scale, NOISE_LEAST)
    shares = [number_text(100.0 * part, ".3g", 100.0, NOISE_LEAST) for part in parts]
    text = (
        f"{given} {unit} by the file, {identified} ± {error} {unit} identified (rms); "
        f"{shares[0]} and {shares[1]} % of the sum over the bodies"
    )
    return f"shaking {name}", text


def _combination_row(item: Identified) -> tuple[str, ...]:
    """Build the row of a combination."""
    words, unit = item.combination.words, item.combination.unit
    scale = max(abs(item.file), abs(item.likeliest))
    file = number_text(item.file, scale=scale)
    if item.value is None or item.error is None:
        return (words, unit, file, "not excited", MISSING, MISSING)
    floor = max(item.error, NOISE_LEAST * scale)
    value = number_text(item.value, scale=1e-3 * floor, floor=1.0)
    off = item.off or 0.0
    return (
        words,
        unit,
        file,
        value,
        number_text(item.error, ".2g"),
        number_text(off, ".1f", OFF_ZERO, 1.0),
    )


def _channel_rows(answer: Identification) -> list[tuple[str, ...]]:
    """Build the table of the loads, its head first."""
    rows: list[tuple[str, ...]] = [("load", "unit", "rms", "left by the file", "left", "noise")]
    several = len(answer.recordings) > 1
    scale = max(channel.size for each in answer.recordings for channel in each.channels) or 1.0
    for k, recording in enumerate(answer.recordings, 1):
        for channel in recording.channels:
            sizes = (
                size_text(size, ".4g", scale, NOISE_LEAST)
                for size in (channel.size, channel.file, channel.residual, channel.noise)
            )
            name = f"{channel.name}, recording {k}" if several else channel.name
            rows.append((name, load_unit(answer, channel.name), *sizes))
    return rows


def load_unit(answer: Identification, name: str) -> str:
    """Return the unit of a measured load: ``N`` or ``N m``."""
    return "N" if name in WRENCH[:3] or name in answer.space.linkage.sliding else "N m"


def _mass_rows(answer: Identification) -> list[tuple[str, ...]]:
    """Build the table of the masses, its head first."""
    rows: list[tuple[str, ...]] = [
        ("link", "mass in file (kg)", "likeliest", "1 sigma", "centre of mass (m)")
    ]
    for mass in answer.masses:
        rows.append(
            (
                mass.link,
                number_text(mass.file),
                number_text(mass.mass),
                number_text(mass.error, ".2g"),
                vector_text(mass.com),
            )
        )
    return rows


def identification_body(answer: Identification) -> AnswerBody:
    """Build what is printed on an identification."""
    body: list[AnswerPart] = [answer.sentence, "", Facts(identification_facts(answer))]
    body += ["", AnswerTable([HEAD, *map(_combination_row, answer.combinations)], "<<>")]
    body += ["", AnswerTable(_channel_rows(answer), "<<>")]
    body += ["", AnswerTable(_mass_rows(answer), "<>>><")]
    share = number_text(100.0 * answer.prior)
    body += [
        "",
        f"Likeliest masses lie between the loads and the file, whose masses count as {share} % "
        "uncertain; combinations do not depend on that.",
    ]
    return body


def plan_sentence(plan: ExcitingMotion) -> str:
    """Say in one sentence what the motion is good for."""
    words = plan.words
    return f"{words[0].upper()}{words[1:]}."


def plan_body(plan: ExcitingMotion) -> AnswerBody:
    """Build what is printed on an exciting motion."""
    space, names = plan.space, plan.space.linkage.inputs
    facts = linkage_facts(space.linkage, f"{space.balance} balance")
    length = number_text(space.length)
    facts += [
        (
            "motion",
            f"{number_text(plan.duration)} s, {plan.harmonics} harmonics, from rest to "
            "rest at the reference pose",
        ),
        ("verdict", plan.words),
        ("excites", f"{count_noun(space.rank, 'combination')} on which balance depends"),
        (
            "error",
            f"{number_text(plan.excitation.error)} in kg and lengths of {length} m for a "
            "sensor of 1 N at one sample a second, geometric mean",
        ),
    ]
    _, *motions = plan.samples(401)
    upper = plan.limits.upper
    rows: list[tuple[str, ...]] = [
        ("input", "peak displacement", "peak speed", "limit", "peak acceleration", "limit")
    ]
    for k, name in enumerate(names):
        u, ud, udd = (number_text(float(np.abs(x[:, k]).max())) for x in motions)
        speed, change = (
            number_text(float(limit)) if np.isfinite(limit) else MISSING
            for limit in (upper[1, k], upper[2, k])
        )
        rows.append((name, u, ud, speed, udd, change))
    return [Facts(facts), "", AnswerTable(rows, "<>")]
