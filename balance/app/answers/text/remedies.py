"""Text of remedies for ``balance remedies``.

`RemedyComparison.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.design import REDUCE
from balance.app.answers.text.linkage import linkage_facts
from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.compare import COPIES, TORQUE_ALONE, RemedyComparison
from kinematics.numerics.tolerances import POSE_DETERMINED
from kinematics.wording import count_noun, number_text, size_text

DIGITS = 4
NONE = "-"
# Gaps below it are those of the solver.
GAP_DETERMINED = 1e-6
ONLY_COPIES = "of these remedies only copies of the whole linkage balance it"
HEAD = (
    "remedy",
    "verdict",
    "added (kg)",
    "added (× mass)",
    "gears (kg)",
    "input inertia (×)",
    "bearing load (×)",
    "width (×)",
    "links (+)",
    "joints (+)",
    "freedoms (+)",
    "shaking left",
)
# What the units of the head are.
UNITS = (
    "×: times that of the linkage in the file; +: more than there; added: without gears; "
    "gears: solid steel, at the peaks of random motions of 1 s, and not in the written file; "
    "bearing load: the largest force of a joint at these peaks; width: of a box about joints "
    "and masses; shaking left: where all is balanced, its part of the bodies' own inertia; "
    "else the rms, times that of the file"
)


def remedies_facts(comparison: RemedyComparison, reduce: str = REDUCE) -> list[tuple[str, str]]:
    """List the facts on a comparison as pairs of label and value.

    Args:
        reduce: the command for the least shaking.
    """
    request = comparison.request
    pairs = linkage_facts(request.linkage, f"{request.balance} balance", request.motion)
    matter = "point masses, of any density (--density steel sets a limit)"
    if request.density is not None:
        matter = f"at most {number_text(request.density)} kg/m³"
    pairs += [
        ("mobility", str(request.freedoms)),
        ("mass", f"{number_text(request.given_mass, f'.{DIGITS}g')} kg in moving links"),
        ("other masses", _other_masses_text(comparison)),
        ("added matter", matter),
        (
            "rotors",
            f"radius {number_text(request.rotor_radius, f'.{DIGITS}g')} m, "
            f"gear {request.gear:g} (bounds: larger ones take no more mass)",
        ),
    ]
    unbuilt = only_unbuilt(comparison)
    if unbuilt:
        pairs.append(("build first", _unbuilt_text(comparison)))
    elif comparison.balanced:
        first = comparison.by_preference[0]
        pairs.append(("build first", f"{first.short}: {first.words}; {first.reason}"))
        pairs.append(("because", comparison.why_first))
    if unbuilt or comparison.only_copies:
        words = [ONLY_COPIES] * comparison.only_copies
        words += ["--balance force: the forces alone"] * (request.balance == "dynamic")
        if words:
            pairs.append(("other ways", "; ".join(words)))
        pairs.append(("reduce", reduce))
    return pairs


def _other_masses_text(comparison: RemedyComparison) -> str:
    """Say whether the links would balance if their masses were chosen anew."""
    anew = comparison.own_masses
    if anew.verdict == "feasible":
        return (
            "the links alone could balance it if all their masses were chosen anew (balance "
            "design); the remedies keep the masses of the file and add to them"
        )
    if anew.verdict == "infeasible":
        why = anew.words.removeprefix("infeasible: ")
        return f"no masses of the links alone balance it: {why}"
    return f"whether other masses of the links alone would balance it is {anew.words}"


def only_unbuilt(comparison: RemedyComparison) -> bool:
    """Whether remedies balance the linkage, and one would build none of them.

    All of them are too heavy, or copies of the whole linkage where others shake less.
    """
    less = bool(_less_shaking(comparison))
    return bool(comparison.balanced) and all(
        comparison.too_heavy(each) or (less and each.remedy in COPIES)
        for each in comparison.balanced
    )


def _less_shaking(comparison: RemedyComparison) -> list[AppliedRemedy]:
    """List the results of partial balance of the force, or of both, that one can build."""
    return [
        each
        for each in comparison.by_preference
        if each.verdict == "partial"
        and each.remedy not in TORQUE_ALONE
        and not comparison.too_heavy(each)
    ]


def remedies_sentence(comparison: RemedyComparison) -> str:
    """Say in one sentence what to build, or that nothing balances the linkage."""
    if only_unbuilt(comparison):
        return f"Build {_unbuilt_text(comparison)}."
    if comparison.balanced:
        first = comparison.by_preference[0]
        return f"Build first: {first.short}, {first.words}; {first.reason}."
    if comparison.verdict == "undecided":
        return "It is undecided whether one of these remedies balances the linkage."
    return "None of these remedies balances the linkage."


def _unbuilt_text(comparison: RemedyComparison) -> str:
    """Say why one builds nothing of what balances, and what one builds in practice."""
    given = comparison.request.given_mass
    light = [each for each in comparison.balanced if not comparison.too_heavy(each)]
    each = (light or comparison.balanced)[0]
    ratio = number_text(each.added_mass_with_gears / given, ".2g")
    text = (
        f"none of those that balance: the lightest ({each.short}) adds {each.added_text}, "
        f"{ratio} times the mass of the linkage"
    )
    if each.remedy in COPIES:
        text += (
            f", {count_noun(len(each.new_links), 'link')} and "
            f"{count_noun(len(each.new_joints), 'joint')}"
        )
        if each.built is not None and each.built.width_ratio is not None:
            text += f", at {number_text(each.built.width_ratio, '.2g')} times the width"
    ways = [
        f"{way.short} ({way.added_text} added; shaking left: {_shaking_text(way)})"
        for way in _less_shaking(comparison)
    ]
    return text + (f"; in practice one builds {' or '.join(ways)}" if ways else "")


def _shaking_text(applied: AppliedRemedy) -> str:
    """Say what shaking is left: a part of the inertia, or of what is in the file."""
    if applied.residual is None:
        return NONE
    size = size_text(applied.residual, floor=POSE_DETERMINED)
    if applied.verdict != "partial":
        return size
    if applied.remedy in TORQUE_ALONE:
        return f"torque × {size}"
    if "moment_after" in applied.details:
        return f"force 0, moment × {size}"
    return f"× {size}"


def remedy_rows(comparison: RemedyComparison) -> list[tuple[str, ...]]:
    """Build the table of remedies in the order of preference, its head first.

    Those that do not apply to this linkage are left out; see `refused_lines`.
    """
    given_mass = comparison.request.given_mass
    return [HEAD, *(_row(applied, given_mass) for applied in applicable(comparison))]


def applicable(comparison: RemedyComparison) -> list[AppliedRemedy]:
    """List the results of remedies that apply to this linkage, in the order of preference."""
    return [each for each in comparison.by_preference if each.verdict != "refused"]


def refused_lines(comparison: RemedyComparison) -> list[str]:
    """Say which remedies do not apply to this linkage: a line for each reason."""
    names: dict[str, list[str]] = {}
    for each in comparison.by_preference:
        if each.verdict == "refused":
            kinds = names.setdefault(each.reason, [])
            kinds += [each.short] * (each.short not in kinds)
    return [
        f"not for this machine: {', '.join(kinds)}, because {reason}"
        for reason, kinds in names.items()
    ]


def _row(applied: AppliedRemedy, given_mass: float) -> tuple[str, ...]:
    """Build the row of one result."""
    if not applied.helps:
        return (applied.short, applied.verdict, *[NONE] * (len(HEAD) - 2))
    built = applied.built
    numbers = (
        NONE if value is None else number_text(value, f".{DIGITS}g", given_mass)
        for value in (
            applied.added_mass,
            applied.mass_ratio,
            None if built is None else built.gear_mass,
            applied.inertia_ratio,
            None if built is None else built.bearing_ratio,
            None if built is None else built.width_ratio,
        )
    )
    counts = len(applied.new_links), len(applied.new_joints), -applied.lost_freedoms
    shaking = _shaking_text(applied)
    return (applied.short, applied.verdict, *numbers, *map(str, counts), shaking)


def remedies_body(comparison: RemedyComparison, reduce: str = REDUCE) -> AnswerBody:
    """Build what is printed on a comparison; see `remedies_facts`."""
    reasons = [
        f"{each.short} ({each.remedy}): {each.words}; {each.reason}"
        for each in applicable(comparison)
    ]
    table: list[AnswerPart] = []
    if reasons:
        table = [AnswerTable(remedy_rows(comparison)), UNITS, ""]
    return [
        Facts(remedies_facts(comparison, reduce)),
        "",
        *table,
        *reasons,
        *refused_lines(comparison),
        *_trade_offs(comparison),
    ]


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
