"""The text of ``balance verify``: nothing here prints.

The same as data is `Verification.to_dict`, the contract of ``balance verify --json``.
"""

from __future__ import annotations

import numpy as np

from balance.verification.result import Verification
from kinematics.wording import first_names

__all__ = ["verification_facts", "verification_text"]


def verification_facts(found: Verification) -> list[tuple[str, str]]:
    """The report as pairs of a label and a value."""
    ratio = f"{found.force_ratio:.1e} (force), {found.moment_ratio:.1e} (moment)"
    joint = found.most_loaded()
    force, moment = (_shaking(found, part) for part in ("force", "moment"))
    return [
        ("linkage", f"{found.model}, {found.balance} balance"),
        ("file", found.linkage.source),
        *([("pose", found.linkage.pose)] if found.linkage.at else []),
        ("inputs", first_names(found.linkage.inputs)),
        *_motions(found),
        ("shaking force", f"{force}; {found.force_residual:.1e} of inertia"),
        ("shaking moment", f"{moment}; {found.moment_residual:.1e} of inertia"),
        ("inertia", f"{found.scale:.3g} N, the bodies' own at its peak"),
        ("bearing force", f"{found.bearing:.3g} N" + (f" in {joint}" if joint else "")),
        ("to bearing", ratio),
        ("agreement", f"{found.agreement:.1e}, Pinocchio and our series"),
        ("closure", f"{found.closure:.1e} radians, characteristic lengths"),
        *(("note", remark) for remark in found.remarks),
        ("verdict", f"{found.verdict} (tolerance {found.tolerance:.1e})"),
    ]


def _motions(found: Verification) -> list[tuple[str, str]]:
    """The motions: how many, how long and how far, and which one is plotted."""
    samples = sum(run.trajectory.time.size for run in found.runs)
    if found.crank is not None:
        crank = found.crank
        return [
            ("motion", f"one revolution of {crank.joint} at {crank.rpm:.6g} rpm "
                       f"({crank.speed:.6g} rad/s), {samples - 1} steps"),
            ("duration", f"{found.duration:.4g} s"),
        ]  # fmt: skip
    count, number = len(found.runs), found.plotted
    origin = "given" if found.seed is None else f"random, seed {found.seed}"
    units = {joint.name: "m" if joint.kind == "prismatic" else "rad"
             for joint in found.linkage.joints}  # fmt: skip
    ways = [f"{name} {far:.3g} {units[name]}" for name, far in found.amplitude.items()]
    force, moment = (found.runs[number].peak(part) for part in ("force", "moment"))
    return [
        ("motions", f"{count} {origin}; {samples} samples"),
        ("duration", f"{found.duration:.4g} s" + (" each" if count > 1 else "")),
        ("amplitude", first_names(ways)),
        ("plotted", f"motion {number + 1} of {count}: {force:.3g} N, {moment:.3g} N m"),
    ]


def _shaking(found: Verification, part: str) -> str:
    """The peak of the shaking force or moment, and where it is."""
    unit = "N" if part == "force" else "N m"
    number = found.worst(part)
    run = found.runs[number]
    peak = f"{run.peak(part):.3g} {unit}"
    if found.crank is None:
        return f"{peak} in motion {number + 1}"
    at = found.linkage.inputs.index(found.crank.joint)
    angle = np.degrees(run.trajectory.u[np.argmax(run.sizes(part)), at])
    return f"peak {peak} at {angle:.1f}°, rms {run.rms(part):.3g} {unit}"


def verification_text(first: Verification, second: Verification | None = None) -> str:
    """Write verifications as plain text.

    Args:
        first: a verification.
        second: the verification of a second linkage, for a second column; None without it.
    """
    if second is None:
        return "\n".join(f"{label:<15} {value}" for label, value in verification_facts(first))
    notes = [("note", f"{one.model}: {note}") for one in (first, second)
             for note in one.remarks]  # fmt: skip
    plain = [
        [pair for pair in verification_facts(one) if pair[0] != "note"]
        for one in (first, second)
    ]
    table = [(label, left, right) for (label, left), (_, right) in zip(*plain, strict=True)]
    width = max(len(left) for _, left, _ in table)
    lines = [f"{label:<15} {left:<{width}}  {right}" for label, left, right in table]
    return "\n".join([*lines, *(f"{label:<15} {note}" for label, note in notes)])
