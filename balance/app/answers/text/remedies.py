"""Text of remedies for ``balance remedies``.

`RemedyComparison.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.design import REDUCE
from balance.app.answers.text.linkage import linkage_facts
from balance.masses.remedies.applied import AppliedRemedy
from balance.masses.remedies.compare import COPIES, ON_LINKS, TORQUE_ALONE, RemedyComparison
from balance.support.change_text import LOAD_FORM
from kinematics.model.motion import while_text
from kinematics.numerics.tolerances import POSE_DETERMINED
from kinematics.wording import count_noun, number_text, size_text

FORM = ".4g"
NONE = "-"
# What is said below a command that adds point masses, as the table has them.
IN_STEEL = (
    "with --density steel: the same of steel, which takes more mass than the point masses "
    "printed here, or leaves more to shake"
)
NO_TRADE_OFF = (
    "trade-off: none, for it is of remedies that balance the linkage by the least matter, and "
    "none of these does"
)
# Gaps below it are those of the solver.
GAP_DETERMINED = 1e-6
ONLY_COPIES = "of these remedies only copies of the whole linkage balance it"
# Verdicts of what does not help, as lines begin, and where one reads why of the last two.
UNHELPFUL = {
    "undecided": "undecided",
    "infeasible": "no masses do",
    "refused": "not for this machine",
}
WHY = "why: --only NAME, or --html FILE.html for all of them"
HEAD = (
    "remedy",
    "verdict",
    "added (kg)",
    "added (× mass)",
    "of it gears (kg)",
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
    "×: times that of the linkage in the file; +: more than there; added: with gears; "
    "gears: solid steel, at the peaks of random motions of 1 s, and not in the written file; "
    "bearing load: the largest force of a joint where one input at a time has these peaks in "
    "the pose of the file (along a motion: balance verify); width: of a box about joints and "
    "masses; shaking left: where all is balanced, its part of the bodies' own inertia; else "
    "the rms over the motions, times that of the file (balance verify has peaks)"
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
        ("mass", f"{number_text(request.given_mass, FORM)} kg in moving links"),
        ("other masses", _other_masses_text(comparison)),
        ("added matter", matter),
        (
            "rotors",
            f"radius {number_text(request.rotor_radius, FORM)} m, "
            f"gear {request.gear:g} (bounds: larger ones take no more mass)",
        ),
    ]
    unbuilt = only_unbuilt(comparison)
    if unbuilt or comparison.only_copies:
        words = [ONLY_COPIES] * comparison.only_copies
        words += ["--balance force: the forces alone"] * (request.balance == "dynamic")
        if words:
            pairs.append(("other ways", "; ".join(words)))
        in_steel = ", in steel" * (request.density is None)
        pairs.append((f"reduce{in_steel}", comparison.reduce or REDUCE))
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
        return f"no masses of the links alone balance it: {anew.reason}"
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
    """Say what one would build and what it costs, or that nothing balances the linkage."""
    text, when = _first_choice_text(comparison), while_text(comparison.request.motion)
    return f"While{when.removeprefix(' while')}: {text[0].lower()}{text[1:]}" if when else text


def _first_choice_text(comparison: RemedyComparison) -> str:
    """Write the sentence without the motion of the request."""
    if only_unbuilt(comparison):
        return f"{_in_practice(comparison)}{_why_unbuilt(comparison)}."
    if comparison.only_copies and not _tried_less(comparison):
        return _copies_alone(comparison)
    if comparison.balanced:
        return f"Build {comparison.by_preference[0].short}: {comparison.why_first}."
    if comparison.verdict == "undecided":
        none = "whether one of these remedies balances the linkage is undecided"
    else:
        none = "none of these remedies balances the linkage"
    practice = _in_practice(comparison)
    if comparison.verdict == "partial":
        first = comparison.by_preference[0]
        cost = f"{first.added_text} added; rms shaking left: {_shaking_text(first)}"
        heavy = f"{first.short[0].upper()}{first.short[1:]} ({cost})"
        return f"{practice.removesuffix('; ') or heavy}."
    return f"{practice or none[0].upper()}{none if practice else none[1:]}."


def _tried_less(comparison: RemedyComparison) -> bool:
    """Whether remedies that take the force, or a part of the shaking, were tried too."""
    return any(each.remedy in ON_LINKS for each in comparison.results)


def _copies_alone(comparison: RemedyComparison) -> str:
    """Say that copies balance the linkage, at which cost, and where that is worth it."""
    copies = comparison.balanced[0]
    less = ON_LINKS if comparison.request.balance == "dynamic" else ON_LINKS[1:]
    text = f"{copies.short[0].upper()}{copies.short[1:]} balance the linkage, and nothing else "
    return (
        f"{text}that was tried: {_cost_text(comparison, copies)}. Worth it only where nothing "
        f"may shake: others add less and leave some (--only {','.join([*COPIES, *less])} "
        "compares them)."
    )


def first_choice(comparison: RemedyComparison) -> AppliedRemedy | None:
    """Find the result that one would build first; None if none helps so that one would."""
    if comparison.balanced and not only_unbuilt(comparison):
        return comparison.by_preference[0]
    less = _less_shaking(comparison)
    return less[0] if less else None


def _in_practice(comparison: RemedyComparison) -> str:
    """Say which partial balance one builds, then a semicolon; empty if there is none."""
    given, ways = comparison.request.given_mass, []
    less = _less_shaking(comparison)
    for k, way in enumerate(less):
        ratio = number_text(way.added_mass_with_gears / given, FORM)
        points = way.remedy in ON_LINKS and comparison.request.density is None
        added = f"{way.added_text}{' of point masses' * points} added"
        cost = f"{added}, {ratio} times the mass of the linkage"
        later = k > 0 and comparison.outweighs(way) and not comparison.outweighs(less[k - 1])
        ways.append(
            f"{', heavier than the linkage,' * later} {way.short} ({cost}; "
            f"{'rms ' * (k == 0)}shaking left: {_shaking_text(way)})"
        )
    return f"Build{', or'.join(ways)}; " if ways else ""


def _why_unbuilt(comparison: RemedyComparison) -> str:
    """Say why one builds nothing of what balances."""
    light = [each for each in comparison.balanced if not comparison.too_heavy(each)]
    each = (light or comparison.balanced)[0]
    what = "all shaking" if comparison.request.balance == "dynamic" else "the force"
    text = f"balancing {what} is not worth it: the lightest way ({each.short}) adds "
    text += _cost_text(comparison, each)
    return text if _less_shaking(comparison) else text[0].upper() + text[1:]


def _cost_text(comparison: RemedyComparison, applied: AppliedRemedy) -> str:
    """Say what a remedy adds, and of copies how many parts and how much room."""
    ratio = applied.added_mass_with_gears / comparison.request.given_mass
    text = f"{applied.added_text}, {number_text(ratio, FORM)} times the mass of the linkage"
    if applied.remedy in COPIES:
        text += (
            f", {count_noun(len(applied.new_links), 'link')} and "
            f"{count_noun(len(applied.new_joints), 'joint')}"
        )
        if applied.built is not None and applied.built.width_ratio is not None:
            text += f", at {number_text(applied.built.width_ratio, FORM)} times the width"
    return text


def _shaking_text(applied: AppliedRemedy) -> str:
    """Say what shaking is left: a part of the inertia, or of what is in the file."""
    if applied.residual is None:
        return NONE
    size = size_text(applied.residual, LOAD_FORM, floor=POSE_DETERMINED)
    if applied.verdict != "partial":
        return size
    if applied.remedy in TORQUE_ALONE:
        return f"torque × {size}"
    if applied.remedy == "partial":
        return ", ".join(_ratios(applied.details)) or f"× {size}"
    if "moment_after" in applied.details:
        return f"force 0, moment × {size}"
    return f"× {size}"


def _ratios(details: Mapping[str, Any]) -> list[str]:
    """Write how many times that of the file force and moment are, where the file has any."""
    ratios = (
        (part, details[f"{part}_after"] / details[f"{part}_before"])
        for part in ("force", "moment")
        if details.get(f"{part}_before")
    )
    return [
        f"{part} × {size_text(ratio, LOAD_FORM, floor=POSE_DETERMINED)}"
        for part, ratio in ratios
    ]


def remedy_rows(
    comparison: RemedyComparison, *, helping: bool = False
) -> list[tuple[str, ...]]:
    """Build the table of remedies in the order of preference, its head first.

    Those that do not apply to this linkage are left out; see `reason_lines`.

    Args:
        helping: whether those that do not help are left out too.
    """
    given_mass = comparison.request.given_mass
    shown = [each for each in applicable(comparison) if each.helps or not helping]
    return [HEAD, *(_row(applied, given_mass) for applied in shown)]


def applicable(comparison: RemedyComparison) -> list[AppliedRemedy]:
    """List the results of remedies that apply to this linkage, in the order of preference."""
    return [each for each in comparison.by_preference if each.verdict != "refused"]


def reason_lines(comparison: RemedyComparison, verdict: str = "refused") -> list[str]:
    """Say which remedies do not apply, or have another verdict: a line for each reason."""
    names: dict[str, list[str]] = {}
    for each in comparison.by_preference:
        if each.verdict == verdict:
            kinds = names.setdefault(each.reason, [])
            kinds += [each.short] * (each.short not in kinds)
    return [
        f"{UNHELPFUL[verdict]}: {', '.join(kinds)}, because {reason}"
        for reason, kinds in names.items()
    ]


def _row(applied: AppliedRemedy, given_mass: float) -> tuple[str, ...]:
    """Build the row of one result."""
    if not applied.helps:
        return (applied.short, applied.verdict, *[NONE] * (len(HEAD) - 2))
    built, whole = applied.built, applied.added_mass_with_gears
    numbers = (
        NONE if value is None else number_text(value, FORM, given_mass)
        for value in (
            None if applied.added_mass is None else whole,
            None if applied.added_mass is None else whole / given_mass,
            None if built is None else built.gear_mass,
            applied.inertia_ratio,
            None if built is None else built.bearing_ratio,
            None if built is None else built.width_ratio,
        )
    )
    counts = len(applied.new_links), len(applied.new_joints), -applied.lost_freedoms
    shaking = _shaking_text(applied)
    return (applied.short, applied.verdict, *numbers, *map(str, counts), shaking)


def remedies_body(comparison: RemedyComparison) -> AnswerBody:
    """Build what is printed on a comparison: the answer, the next command, facts, and costs.

    Where all remedies were tried, those that do not help are named without their reasons.
    """
    some = bool(comparison.request.only)
    rows = remedy_rows(comparison, helping=not some)
    reasons = [
        f"{each.short} ({each.remedy}): {each.words}; {each.reason}"
        for each in applicable(comparison)
        if some or each.helps
    ]
    table: list[AnswerPart] = [AnswerTable(rows), UNITS, ""] if len(rows) > 1 else []
    return [
        remedies_sentence(comparison),
        *following_lines(comparison),
        "",
        Facts(remedies_facts(comparison)),
        "",
        *table,
        *reasons,
        *(reason_lines(comparison) if some else _unhelpful_lines(comparison)),
        *_trade_offs(comparison),
    ]


def following_lines(comparison: RemedyComparison) -> list[str]:
    """Write the command that comes next, and what kind of matter it adds; none without one."""
    if not comparison.following:
        return []
    first = first_choice(comparison)
    on_links = first is not None and first.remedy in ON_LINKS
    points = on_links and comparison.request.density is None
    return [f"Next: {comparison.following}", *[f"      {IN_STEEL}"] * points]


def _unhelpful_lines(comparison: RemedyComparison) -> list[str]:
    """Name the remedies that do not help, by verdict, and where their reasons are.

    What is undecided, which the user may decide, has its reason here.
    """
    lines = []
    for verdict in ("infeasible", "refused"):
        same = [each.short for each in comparison.by_preference if each.verdict == verdict]
        if same:
            lines.append(f"{UNHELPFUL[verdict]}: {', '.join(dict.fromkeys(same))}")
    return [*reason_lines(comparison, "undecided"), *lines, *[WHY] * bool(lines)]


def _trade_offs(comparison: RemedyComparison) -> AnswerBody:
    """Build the table of mass against inertia if it is asked for, or say why it is empty."""
    given = comparison.request.given_mass
    rows = [
        (
            applied.short,
            number_text(point.added_mass, FORM, given),
            number_text(point.inertia, FORM),
            f"{point.gear:g}",
            size_text(point.gap, ".1e", floor=GAP_DETERMINED),
        )
        for applied in comparison.by_preference
        for point in applied.trade_off
    ]
    if not rows:
        return ["", NO_TRADE_OFF] if comparison.request.trade_off else []
    head = "trade-off", "added without gears (kg)", "input inertia (kg m2)", "gear", "gap"
    return ["", AnswerTable([head, *rows])]
