"""Text of remedies for ``balance remedies``.

`RemedyComparison.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from balance.app.answers.answer import AnswerBody, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.compare import RemedyComparison
from kinematics.numerics.tolerances import POSE_DETERMINED
from kinematics.wording import number_text, size_text

DIGITS = 4
NONE = "-"
# Gaps below it are those of the solver.
GAP_DETERMINED = 1e-6
ONLY_COPIES = "of these remedies only copies of the whole linkage balance it; "
LESS_SHAKING = "balance reduce --budget KG: the least shaking"
HEAD = (
    "remedy",
    "verdict",
    "added (kg)",
    "of its mass",
    "input inertia",
    "links",
    "joints",
    "freedoms",
    "shaking",
)


def remedies_facts(comparison: RemedyComparison) -> list[tuple[str, str]]:
    """List the facts on a comparison as pairs of label and value."""
    request = comparison.request
    pairs = linkage_facts(request.linkage, f"{request.balance} balance", request.motion)
    matter = "point masses, of any density (--density steel sets a limit)"
    if request.density is not None:
        matter = f"at most {number_text(request.density)} kg/m³"
    pairs += [
        ("mobility", str(request.freedoms)),
        ("mass", f"{number_text(request.given_mass, f'.{DIGITS}g')} kg in moving links"),
        ("own masses", comparison.own_masses.words),
        ("added matter", matter),
        (
            "rotors",
            f"radius {number_text(request.rotor_radius, f'.{DIGITS}g')} m, "
            f"gear {request.gear:g} (bounds: larger ones take no more mass)",
        ),
    ]
    if comparison.balanced:
        first = comparison.by_preference[0]
        pairs.append(("build first", f"{first.short}: {first.words}; {first.reason}"))
    if comparison.only_copies:
        forces = "--balance force: the forces alone; " if request.balance == "dynamic" else ""
        pairs.append(("other ways", f"{ONLY_COPIES}{forces}{LESS_SHAKING}"))
    return pairs


def remedy_rows(comparison: RemedyComparison) -> list[tuple[str, ...]]:
    """Build the table of remedies in the order of preference, its head first."""
    return [
        HEAD,
        *(_row(applied, comparison.request.given_mass) for applied in comparison.by_preference),
    ]


def _row(applied: AppliedRemedy, given_mass: float) -> tuple[str, ...]:
    """Build the row of one result."""
    if not applied.helps:
        return (applied.short, applied.verdict, *[NONE] * (len(HEAD) - 2))
    numbers = (
        NONE if value is None else number_text(value, f".{DIGITS}g", given_mass)
        for value in (applied.added_mass, applied.mass_ratio, applied.inertia_ratio)
    )
    counts = len(applied.new_links), len(applied.new_joints), -applied.lost_freedoms
    shaking = (
        NONE if applied.residual is None else size_text(applied.residual, floor=POSE_DETERMINED)
    )
    return (applied.short, applied.verdict, *numbers, *map(str, counts), shaking)


def remedies_body(comparison: RemedyComparison) -> AnswerBody:
    """Build what is printed on a comparison."""
    reasons = [
        f"{each.short} ({each.remedy}): {_what_and_why(each)}"
        for each in comparison.by_preference
    ]
    return [
        Facts(remedies_facts(comparison)),
        "",
        AnswerTable(remedy_rows(comparison)),
        "",
        *reasons,
        *_trade_offs(comparison),
    ]


def _what_and_why(applied: AppliedRemedy) -> str:
    """Say what is built in and what comes of it, or why it is not for this linkage."""
    if applied.verdict == "refused":
        return f"not for this machine, because: {applied.reason}"
    return f"{applied.words}; {applied.reason}"


def _trade_offs(comparison: RemedyComparison) -> AnswerBody:
    """Build the tables of mass against inertia, if they were asked for."""
    given = comparison.request.given_mass
    rows = [
        (
            applied.short,
            number_text(point.added_mass, f".{DIGITS}g", given),
            number_text(point.inertia, f".{DIGITS}g"),
            f"{point.gear:g}",
            size_text(point.gap, ".1e", floor=GAP_DETERMINED),
        )
        for applied in comparison.by_preference
        for point in applied.trade_off
    ]
    if not rows:
        return []
    head = "trade-off", "added (kg)", "input inertia (kg m2)", "gear", "gap"
    return ["", AnswerTable([head, *rows])]
