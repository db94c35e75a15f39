"""Text of remedies for ``balance remedies``.

`RemedyComparison.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from balance.remedies.applied import AppliedRemedy
from balance.remedies.compare import RemedyComparison
from balance.report.answer import AnswerBody, AnswerTable, Facts
from balance.report.text.linkage import linkage_facts
from kinematics.tolerances import POSE_DETERMINED
from kinematics.wording import number_text, size_text

__all__ = ["remedies_body", "remedies_facts", "remedy_rows"]

DIGITS = 4
NONE = "-"
HEAD = ("remedy", "verdict", "added (kg)", "of its mass", "input inertia", "links", "joints",
        "freedoms", "shaking")  # fmt: skip


def remedies_facts(found: RemedyComparison) -> list[tuple[str, str]]:
    """List the facts on a comparison as pairs of label and value.

    Args:
        found: the comparison.
    """
    request = found.request
    pairs = linkage_facts(request.linkage, f"{request.balance} balance", request.motion)
    pairs += [
        ("mobility", str(request.freedoms)),
        ("mass", f"{number_text(request.given_mass, f'.{DIGITS}g')} kg in moving links"),
        ("own masses", found.own.words),
        (
            "rotors",
            f"radius {number_text(request.rotor_radius, f'.{DIGITS}g')} m, "
            f"gear {request.gear:g}",
        ),
    ]
    for one in found.balanced[:1]:
        pairs.append(("lightest", f"{one.words}: {one.reason}"))
    return pairs


def remedy_rows(found: RemedyComparison) -> list[tuple[str, ...]]:
    """Build the table of remedies, its head first.

    Args:
        found: the comparison.
    """
    return [HEAD, *(_row(one, found.request.given_mass) for one in found.results)]


def _row(one: AppliedRemedy, given_mass: float) -> tuple[str, ...]:
    """Build the row of one result."""
    if not one.helps:
        return (one.remedy, one.verdict, *[NONE] * (len(HEAD) - 2))
    numbers = (
        NONE if value is None else number_text(value, f".{DIGITS}g", given_mass)
        for value in (one.added_mass, one.mass_ratio, one.inertia_ratio)
    )  # fmt: skip
    counts = len(one.new_links), len(one.new_joints), -one.lost_freedoms
    shaking = NONE if one.residual is None else size_text(one.residual, floor=POSE_DETERMINED)
    return (one.remedy, one.verdict, *numbers, *map(str, counts), shaking)


def remedies_body(found: RemedyComparison) -> AnswerBody:
    """Build what is printed on a comparison."""
    reasons = [f"{each.remedy}: {each.words}; {each.reason}" for each in found.results]
    return [Facts(remedies_facts(found)), "", AnswerTable(remedy_rows(found)), "", *reasons]
