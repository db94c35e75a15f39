"""Text of a verification for ``balance verify``.

`Verification.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from balance.app.answers.answer import AnswerBody, Facts, joined_facts
from balance.app.answers.text.linkage import amplitude_text
from balance.motion.verification.comparison import VerificationComparison, round_off_of
from balance.motion.verification.holding_torques import HoldingTorques
from balance.motion.verification.trajectory import Trajectory, are_shortened, input_reach
from balance.motion.verification.verification import HARMONICS, Verification
from balance.support.change_text import grows
from balance.support.linkage_names import linkage_names
from kinematics.model.linkage import Linkage
from kinematics.model.motion import while_text
from kinematics.numerics.linalg.ties import first_largest
from kinematics.numerics.tolerances import SIZE_DETERMINED, TIE_RELATIVE
from kinematics.wording import first_names, number_text, size_text, unit_text, vector_text

# Part of weight times length above which a holding torque is no round-off.
HELD_DETERMINED = 1e-12


def verification_facts(check: Verification) -> list[tuple[str, str]]:
    """List the facts on a verification as pairs of label and value."""
    force_ratio, moment_ratio, force_residual, moment_residual, agreement = (
        size_text(size, floor=check.round_off)
        for size in (
            check.force_ratio,
            check.moment_ratio,
            check.force_residual,
            check.moment_residual,
            check.agreement,
        )
    )
    joint = check.most_loaded()
    force, moment = (_peak_text(check, part) for part in ("force", "moment"))
    return [
        ("linkage", f"{check.model}, {check.balance} balance"),
        ("file", check.linkage.source),
        *([("pose", check.linkage.pose)] if check.linkage.at else []),
        ("inputs", first_names(check.linkage.inputs)),
        *_motion_facts(check),
        ("shaking force", f"{force}; {force_residual} of inertia"),
        ("shaking moment", f"{moment}; {moment_residual} of inertia{_own_middle(check)}"),
        *_harmonic_facts(check),
        ("about", about_text(check)),
        *_table_facts(check),
        ("inertia force", f"{unit_text(check.scale, 'N', '.3g')}, the bodies' own at its peak"),
        (
            "bearing force",
            unit_text(check.bearing, "N", ".3g")
            + (f" in {joint}" if joint else "")
            + _preload_text(check),
        ),
        ("to bearing", f"{force_ratio} (force), {moment_ratio} (moment)"),
        ("agreement", f"{agreement}, Pinocchio and our series"),
        ("closure", f"{size_text(check.closure)} radians, characteristic lengths"),
        *(("note", remark) for remark in check.remarks),
        ("verdict", f"{_verdict(check)} (tolerance {check.tolerance:.1e})"),
    ]


def _preload_text(verification: Verification) -> str:
    """Say in which range preload lets the largest bearing force be."""
    if not verification.preload:
        return ""
    least = verification.least_bearing
    if least <= SIZE_DETERMINED * verification.scale:
        return "; with preload it can be any"
    if least >= verification.bearing * (1.0 - TIE_RELATIVE):
        return "; preload adds to it"
    return f"; from {unit_text(least, 'N', '.3g')} up with preload"


def about_text(verification: Verification) -> str:
    """Write the point of the moments, and name it if it is the middle of the mechanism."""
    name = ", the middle of the mechanism" if verification.about_middle else ""
    return f"{vector_text(verification.point)} m{name}"


def _own_middle(verification: Verification) -> str:
    """Say that the part of the inertia is for moments about another point than the load."""
    return "" if verification.about_middle else " about its middle"


def _harmonic_facts(verification: Verification) -> list[tuple[str, str]]:
    """List the largest force and moment of the first harmonics of the speed of a crank."""
    sizes = verification.harmonics(HARMONICS)
    if sizes is None:
        return []
    parts = [
        f"{part} {', '.join(verification.load_text(part, x) if x else '0' for x in loads)}"
        for part, loads in sizes.items()
    ]
    return [("harmonics", f"1 to {HARMONICS}: {'; '.join(parts)}")]


def _table_facts(verification: Verification) -> list[tuple[str, str]]:
    """Say how far the peaks can be off if the motions are from a rounded table."""
    if verification.decimals is None:
        return []
    force, moment = (verification.range_text(part) for part in ("force", "moment"))
    return [("table", f"decimals and samples allow a force of {force}, a moment of {moment}")]


def _verdict(verification: Verification) -> str:
    """Return the verdict; of forces alone, or which load is cancelled and which is not."""
    verdict = f"{verification.verdict}{while_text(verification.motion)}"
    if not verification.decided or (
        verification.balance == "dynamic" and verification.balanced
    ):
        return verdict
    if verification.balance == "force":
        return f"{verdict}; the moment does not count"
    alone = " (--balance force)" * (verification.force_residual <= verification.tolerance)
    outcome = f": {verification.outcome}{alone}".removesuffix(": ")
    return f"{verdict}{outcome}"


def _motion_facts(verification: Verification) -> list[tuple[str, str]]:
    """List the facts on the motions: number, duration, amplitude, and the plotted one."""
    samples = sum(run.trajectory.time.size for run in verification.runs)
    if verification.crank is not None:
        crank = verification.crank
        pose = "the pose above" if verification.linkage.at else "the pose of the file"
        return [
            (
                "motion",
                f"{crank.words} ({number_text(crank.speed, '.6g')} rad/s), "
                f"{samples - 1} steps; its angle counts from {pose}",
            ),
            ("duration", f"{verification.duration:.4g} s"),
        ]
    count, number = len(verification.runs), verification.plotted
    origin = "given" if verification.seed is None else f"random, seed {verification.seed}"
    loads = ", ".join(
        verification.load_text(part, verification.runs[number].peak(part))
        for part in ("force", "moment")
    )
    amplitude = amplitude_text(verification.linkage, verification.amplitude)
    if verification.seed is not None:
        amplitude = reach_text(verification.linkage, verification.motions)
    return [
        ("motions", f"{count} {origin}; {samples} samples"),
        ("duration", f"{verification.duration:.4g} s" + (" each" if count > 1 else "")),
        ("amplitude", amplitude),
        ("plotted", f"motion {number + 1} of {count}: peaks {loads}"),
    ]


def reach_text(linkage: Linkage, motions: Sequence[Trajectory]) -> str:
    """Write how far inputs move, and why random motions go no further."""
    shortened = ", so that loops close (--csv FILE goes further)"
    text = amplitude_text(linkage, input_reach(linkage, motions))
    return f"{text}{shortened if are_shortened(motions) else ''}"


def _peak_text(verification: Verification, part: str) -> str:
    """Describe peak and root mean square of the shaking force or moment."""
    number = verification.worst(part)
    run = verification.runs[number]
    peak = verification.load_text(part, run.peak(part))
    rms = f"rms {verification.load_text(part, verification.rms(part))}"
    if verification.crank is None:
        text = f"peak {peak} in motion {number + 1}"
        if peak.startswith("below"):
            return text
        return f"{text}, {rms}{' over all' if len(verification.runs) > 1 else ''}"
    if peak.startswith("below"):
        return f"peak {peak}, {rms}"
    at = verification.linkage.inputs.index(verification.crank.joint)
    sample = first_largest(run.sizes(part), verification.part_scale(part))
    angle = np.degrees(run.trajectory.u[sample, at])
    return f"peak {peak} at {number_text(angle, '.1f')}°, {rms}"


def comparison_sentence(results: Sequence[Verification]) -> str | None:
    """Compare the peaks of a linkage with those of a second one; None without a second."""
    if len(results) < 2:
        return None
    return VerificationComparison(*results).sentence


def growth_notes(results: Sequence[Verification]) -> list[tuple[str, str]]:
    """List what to do about a moment that is larger than that of the second linkage."""
    if len(results) != 2:
        return []
    after, before = results
    if not grows(before.moment, after.moment, round_off_of(results, "moment")):
        return []
    ways = (
        "balance counterweights --balance dynamic, or --minimise inertia, and balance reduce "
        "count it; --about X,Y,Z takes it about another point"
    )
    return [("note", f"the moment grows: {ways}")]


def joined_notes(results: Sequence[Verification]) -> list[tuple[str, str]]:
    """List the remarks on two linkages: which of them each is on."""
    names = [each.model for each in results]
    if len({*names}) == 1:
        names = linkage_names([each.linkage for each in results])
    notes: dict[str, list[str]] = {}
    for name, each in zip(names, results, strict=True):
        for remark in each.remarks:
            notes.setdefault(remark, []).append(name)
    return [
        ("note", f"{on[0] if len(on) == 1 else 'both'}: {remark}")
        for remark, on in notes.items()
    ]


def verification_body(results: Sequence[Verification]) -> AnswerBody:
    """Build what is printed on the verification of a linkage, or of two beside each other."""
    facts = [verification_facts(each) for each in results]
    if len(results) == 1:
        return [Facts(facts[0], least=15)]
    notes = joined_notes(results)
    rows = joined_facts([[pair for pair in pairs if pair[0] != "note"] for pairs in facts])
    rows = [
        (label, f"both: {cells[0]}")
        if label == "verdict" and len({*cells}) == 1
        else (label, *cells)
        for label, *cells in rows
    ]
    notes += growth_notes(results)
    sentence = comparison_sentence(results)
    assert sentence is not None
    return [sentence, "", Facts([*rows, *notes], least=15)]


def holding_body(held: Sequence[HoldingTorques]) -> AnswerBody:
    """Build what is printed on what inputs hold against gravity, for one linkage or two."""
    if not held:
        return []
    gravity = f"gravity {vector_text(held[0].gravity)} m/s²"
    rows = [
        (f"held by {name}", " before, ".join(_held_text(x, name) for x in reversed(held)))
        for name in held[0].peaks
        if all(name in x.peaks for x in held)
    ]
    return ["", Facts([("at rest", f"largest torques (N m) or forces (N), {gravity}"), *rows])]


def _held_text(held: HoldingTorques, name: str) -> str:
    """Write the largest torque of an input."""
    return size_text(held.peaks[name], ".4g", held.scale, HELD_DETERMINED)
