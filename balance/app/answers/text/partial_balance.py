"""Text of partial balance for ``balance reduce``.

`ParetoFront.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

import shlex
from math import inf

import numpy as np

from balance.app.answers.answer import MISSING, AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.counterweights import (
    FRAMES,
    SI,
    counterweight_rows,
    density_facts,
    moved_facts,
    part_lines,
    place_facts,
    shape_facts,
)
from balance.app.answers.text.linkage import linkage_facts
from balance.app.answers.text.verification import reach_text
from balance.masses.counterweights.link_regions import radius_text
from balance.masses.partial_balance.partial_balance import (
    ParetoFront,
    PartialBalance,
    WiderRegions,
)
from balance.masses.partial_balance.shaking_problem import ShakingFigures
from balance.masses.partial_balance.wider_regions import (
    HARDLY_SHAKES,
    USED,
    WORTH_MORE_ROOM,
    default_regions,
    lacks_room,
    links_at_rim,
    may_have_webs,
    reaches_least,
)
from balance.motion.verification.crank_revolution import TURN, Crank
from balance.motion.verification.trajectory import singularity_remark
from balance.support.change_text import LOAD_FORM, MASS_FORM, grows, mass_added_text
from balance.support.tolerances import SHAKING_GAP_PROVED
from kinematics.model.linkage import GROUND
from kinematics.wording import number_text, size_text, unit_text, vector_text

DIGITS = 4
# Relative change of a rate, and of a turn, up to which a crank turns once at one speed.
STEADY = 1e-9
# Part of the added mass to which the masses of links are known: the least shaking is flat.
FLAT_GAP = 1e-4
# Options that a line names at most.
MOST_OPTIONS = 3


def front_facts(front: ParetoFront) -> list[tuple[str, str]]:
    """List the facts on designs as pairs of label and value."""
    best = front.designs[-1]
    space = best.space
    relations = space.motion.relations if space.motion else ()
    pairs = linkage_facts(space.linkage, f"{space.balance} balance", relations)
    pairs.append(("minimised", _minimised_text(front)))
    pairs.append(_motion_fact(front))
    if front.frame is not None:
        pairs.append(("frame", f"natural frequency {number_text(front.frame.frequency)} Hz"))
    pairs.append(("verdict", best.words))
    if best.shaking is not None:
        pairs += _shaking_facts(front, best, best.shaking)
        pairs += moved_facts(best.moved)
        pairs += [*_limit_facts(front, best), *_shape_facts(front, best)]
        if best.shape is not None:
            pairs += [*place_facts(space, best.weights), *shape_facts(best.weights)]
        several = len(front.designs) > 1
        room = _filled_facts(best) if several else _room_facts(best)
        if best.shape is not None:
            room = _shaped_room_facts(best, [] if several else room)
        if not several and best.mass >= USED * best.budget > 0.0 and best.share > HARDLY_SHAKES:
            room += [("budget", "used up: --pareto 5 shows what other masses leave")]
        pairs += [*density_facts(best.weights), *room, *_drives(best)]
    if near := singularity_remark(best.motions):
        pairs.append(("note", near))
    return pairs


def _minimised_text(front: ParetoFront) -> str:
    """Say what is least."""
    point = f"{vector_text(front.point)} m"
    if front.minimise in ("torque", "bearing"):
        return f"{front.objective} along the motions; moments are about {point}"
    counts = f"{number_text(front.weight_moment)} N m about {point} count as 1 N"
    if front.weight_moment == inf:
        counts = f"forces alone; moments are about {point}"
    if front.minimise == "peak":
        return f"peak of the shaking, {counts}"
    return f"root mean square of the {front.objective}, {counts}"


def _motion_fact(front: ParetoFront) -> tuple[str, str]:
    """Say along which motions: the turn of a crank, or how long and how far inputs move."""
    linkage, motions = front.designs[0].space.linkage, front.designs[0].motions
    if crank := _steady_crank(front.designs[0]):
        return "motion", crank.words
    duration = f"{number_text(max(motion.duration for motion in motions))} s"
    amplitude = f"amplitude {reach_text(linkage, motions)}"
    if len(motions) == 1:
        return "motion", f"of {duration}, {amplitude}"
    return "motions", f"{len(motions)} of {duration} each, {amplitude}"


def _steady_crank(design: PartialBalance) -> Crank | None:
    """Find the input that turns once at one speed; None if there is another motion."""
    linkage, motions = design.space.linkage, design.motions
    if len(motions) > 1:
        return None
    u, ud = motions[0].u, motions[0].ud
    for k, name in enumerate(linkage.inputs):
        rate, turn = float(ud[0, k]), abs(float(u[-1, k] - u[0, k])) / TURN
        steady = np.abs(ud[:, k] - rate).max() <= STEADY * abs(rate)
        if rate and steady and name not in linkage.sliding and abs(turn - 1.0) <= STEADY:
            return Crank(name, rate, periodic=True)
    return None


def _shaking_facts(
    front: ParetoFront, best: PartialBalance, shaking: ShakingFigures
) -> list[tuple[str, str]]:
    """List force and moment, before and after, and how far tables let them be off."""
    pairs = []
    main, other = ("peak_", "") if front.minimise == "peak" else ("", "peak_")
    for name, unit in (("force", "N"), ("moment", "N m")):
        texts = [_change_text(best, shaking, prefix, name, unit) for prefix in (main, other)]
        sizes = getattr(best.given, main + name), getattr(shaking, main + name)
        growth = _growth_text(front, name) if grows(*sizes, best.round_off_of(name)) else ""
        pairs.append((name, f"{'; '.join(texts)}{growth}"))
    if best.given.force_off > 0.0 or shaking.force_off > 0.0:
        pairs.append(("tables", _rounding_text(best)))
    return pairs


def _change_text(
    best: PartialBalance, shaking: ShakingFigures, prefix: str, name: str, unit: str
) -> str:
    """Write a load before and after, its root mean square or with ``peak_`` its peak."""
    sizes = getattr(best.given, prefix + name), getattr(shaking, prefix + name)
    scale = max(sizes[0], best.round_off_of(name) / SHAKING_GAP_PROVED)
    before, after = (
        unit_text(size, unit, LOAD_FORM, scale, SHAKING_GAP_PROVED, max(sizes))
        for size in sizes
    )
    return f"{before} before, {after} after ({'peak' if prefix else 'rms'})"


def _shape_facts(front: ParetoFront, best: PartialBalance) -> list[tuple[str, str]]:
    """Say what the shape of counterweights leaves beside matter of any shape."""
    if best.shape is None or best.least_objective is None:
        return []
    given = best.given.objective or 1.0
    least = size_text(best.least_objective / given, ".3g", floor=SHAKING_GAP_PROVED)
    left = size_text(best.share, ".3g", floor=SHAKING_GAP_PROVED)
    text = (
        f"{best.shape} leaves {left} of the {front.objective}, where any shape leaves {least}"
    )
    return [("shape", text)]


def _limit_facts(front: ParetoFront, best: PartialBalance) -> list[tuple[str, str]]:
    """Say what no matter on the links, wherever it is, can save."""
    given = best.given.objective or 1.0
    if best.least_anywhere is None or best.least_anywhere < HARDLY_SHAKES * given:
        return []
    share = number_text(best.least_anywhere / given, ".3g")
    links = ", ".join(best.regions)
    text = f"no matter on {links}, wherever it is, leaves less than {share} of the "
    return [("limit", f"{text}{front.objective}")]


def _room_facts(best: PartialBalance) -> list[tuple[str, str]]:
    """Say that the room of the regions, not the budget, limits what is left to shake."""
    used = f"{number_text(best.mass)} of {number_text(best.budget)} kg"
    shakes = best.weights and best.share >= HARDLY_SHAKES
    if shakes and best.mass < USED * best.budget and reaches_least(best):
        return [("room", f"{used} are enough")]
    if not lacks_room(best):
        return []
    return [("room", f"{used}: more kilograms do no better there; {_more_room(best)}")]


def _more_room(best: PartialBalance) -> str:
    """Write the options that give room, and what is left with them."""
    if not best.wider:
        tried = default_regions(best) and (lacks_room(best) or links_at_rim(best))
        little = f"twice the radius saves less than {WORTH_MORE_ROOM:.0%}"
        return little if tried else "--region L=SHAPE gives room"
    few = len(best.wider[-1].regions) <= MOST_OPTIONS
    parts = [_wider_text(wider) for wider in (best.wider if few else best.wider[-1:])]
    return f"{', '.join(parts)}{_any_shape_text(best)}"


def _wider_text(wider: WiderRegions) -> str:
    """Write the options of larger regions, and what is left with them."""
    radii = ((link, radius_text(region)) for link, region in wider.regions.items())
    options = " ".join(f"--region {shlex.quote(f'{link}={radius}')}" for link, radius in radii)
    return f"{options} leaves {size_text(wider.share, '.3g', floor=SHAKING_GAP_PROVED)}"


def _any_shape_text(best: PartialBalance) -> str:
    """Say of what shape the matter in larger regions is, if it is not the one asked for."""
    return ", of any shape" if may_have_webs(best) else ""


def room_sentence(best: PartialBalance) -> str:
    """Say in a sentence that regions by default leave no room for the budget; or nothing."""
    if not best.wider:
        return ""
    widest = best.wider[-1]
    left = f"{_wider_text(widest)} of the {best.front.objective}{_any_shape_text(best)}"
    return f"The default regions are too small: {left} ({mass_added_text(widest.mass)})."


def _shaped_room_facts(
    best: PartialBalance, used: list[tuple[str, str]]
) -> list[tuple[str, str]]:
    """Say in which regions shapes are, and which are at the rim of theirs.

    Args:
        used: what `_room_facts` says of the budget.
    """
    given = default_regions(best)
    places = [
        f"{region.words} of {link}{' (the default)' * (link in given)}"
        for link, region in best.regions.items()
    ]
    text = "; ".join([", ".join(places), *(words for _, words in used)])
    if bound := links_at_rim(best):
        text += (
            f"; {', '.join(bound)} at the rim of the region: a larger one {_gain_text(best)}"
        )
        text += "" if used or reaches_least(best) else f"; {_more_room(best)}"
    return [("room", text)]


def _gain_text(best: PartialBalance) -> str:
    """Say what a larger region is good for."""
    if best.least_anywhere is None:
        return "leaves less, or as much with less mass"
    return "takes less mass" if reaches_least(best) else "leaves less"


def _filled_facts(best: PartialBalance) -> list[tuple[str, str]]:
    """Say how much of each region the last design of a front fills."""
    parts = [
        f"{number_text(100.0 * share, '.3g')} % of {best.regions[link].words} of {link}"
        for link, share in _filled(best).items()
    ]
    text = f"the last design fills {', '.join(parts)}; --region L=SHAPE sets the room"
    return [("room", text)] if parts else []


def _filled(design: PartialBalance) -> dict[str, float]:
    """Compute the part of the region of each link that matter of limited density fills."""
    return {
        weight.link: weight.mass / (weight.density * design.regions[weight.link].volume)
        for weight in design.weights
        if weight.density is not None
    }


def _growth_text(front: ParetoFront, part: str) -> str:
    """Say what to do about a force or a moment that the added matter makes larger."""
    best, weight = front.designs[-1], front.weight_moment
    other = "moment" if part == "force" else "force"
    ways = []
    if front.frame is not None:
        ways.append("without --frame, force and moment count")
    elif front.minimise in ("torque", "bearing"):
        ways.append(f"--minimise rms counts force and moment, not the {front.objective}")
    elif best.space.balance == "force":
        shaped = "" if best.shape is None else "without --shape, "
        ways.append(f"{shaped}--balance dynamic lets moments count")
    else:
        change = "less" if part == "moment" else "more"
        ways.append(
            f"--weight-moment {change} than {number_text(weight)} m counts the {part} more "
            f"against the {other}"
        )
    if part == "moment" and front.frame is None:
        ways.append(_other_point_text(best))
    return f": it grows; {'; '.join(ways)}"


def _other_point_text(best: PartialBalance) -> str:
    """Say about which point to take the moment.

    A rigid body that turns about a fixed axis at one speed pulls at the axis alone: about it,
    weights on a planar crank have no moment.
    """
    linkage, crank = best.space.linkage, _steady_crank(best)
    links = {weight.link for weight in best.weights}
    if crank is not None and linkage.planar:
        for body in linkage.bodies:
            shaft = linkage.joints[body.link]
            if links == {body.name} and (shaft.parent, shaft.name) == (GROUND, crank.joint):
                about = ",".join(number_text(x, ".9g") for x in shaft.point.tolist())
                return f"about the axis of {shaft.name} it stays as it is: --about {about}"
    return "--about X,Y,Z takes it about another point"


def _rounding_text(best: PartialBalance) -> str:
    """Say how far the loads before and after can be off, since tables are rounded."""
    assert best.shaking is not None
    words = []
    for name, unit in (("force", "N"), ("moment", "N m")):
        before, after = (
            size_text(getattr(figures, f"{name}_off"), ".2g", getattr(best.given, name))
            for figures in (best.given, best.shaking)
        )
        words.append(f"{name} off by up to {before} {unit} before, {after} {unit} after")
    return f"by decimals and samples, {'; '.join(words)}"


def _remaining_load_text(after: float, before: float) -> str:
    """Write what is left of a load, as a bound if it is less than the solver's accuracy."""
    return size_text(after, LOAD_FORM, before, SHAKING_GAP_PROVED)


def _drives(best: PartialBalance) -> list[tuple[str, str]]:
    """List what the motors feel, before and after."""
    assert best.shaking is not None
    inertia, torque, after = best.given.inertia, best.given.torque, best.shaking.torque
    slides = best.space.linkage.sliding
    pairs = []
    for name in inertia:
        mass, what, load = (
            ("kg", "force", "N") if name in slides else ("kg m²", "torque", "N m")
        )
        sizes = torque[name], after[name]
        first, then = (unit_text(x, load, LOAD_FORM, beside=max(sizes)) for x in sizes)
        pairs.append(
            (
                f"input {name}",
                f"inertia {number_text(inertia[name])} {mass} before, "
                f"{number_text(best.shaking.inertia[name])} {mass} after; peak "
                f"{what} {first} before, {then} after",
            )
        )
    return pairs


def front_rows(front: ParetoFront) -> list[tuple[str, ...]]:
    """Build the table of designs, its head first.

    The room that is filled is that of the region with most matter; a dash stands for none.
    """
    unit = "N" if front.frame is None else "m"
    if front.minimise == "torque":
        unit = "N m"
    inputs = set(front.designs[0].given.torque)
    sliding = front.designs[0].space.linkage.sliding & inputs
    torque_unit = ", ".join(["N m"] * bool(inputs - sliding) + ["N"] * bool(sliding))
    head = (
        "added (kg)",
        f"{front.objective} ({unit})",
        "force (N rms)",
        "moment (N m rms)",
        f"peak torque ({torque_unit})",
        "room filled (%)",
        "verdict",
    )
    rows: list[tuple[str, ...]] = [head]
    for design in front.designs:
        if design.shaking is None:
            rows.append((number_text(design.budget, MASS_FORM), *[MISSING] * 5, design.verdict))
            continue
        given, torque = design.given, max(design.shaking.torque.values(), default=0.0)
        loads = (
            _remaining_load_text(getattr(design.shaking, name), getattr(given, name))
            for name in ("objective", "force", "moment")
        )
        mass, torque_text = number_text(design.mass, MASS_FORM), number_text(torque, LOAD_FORM)
        filled = max(_filled(design).values(), default=0.0)
        room = number_text(100.0 * filled, ".3g") if filled else MISSING
        rows.append((mass, *loads, torque_text, room, design.verdict))
    return rows


def part_word(design: PartialBalance) -> str:
    """Return the word before the part of a region that matter fills: shapes are exact."""
    return "about " if design.shape is None else ""


def front_body(front: ParetoFront) -> AnswerBody:
    """Build what is printed on designs, of which the last one is described in full."""
    best = front.designs[-1]
    lead = [best.sentence, *filter(None, [room_sentence(best)])]
    body: list[AnswerPart] = [*lead, "", Facts(front_facts(front))]
    if len(front.designs) > 1:
        body += ["", AnswerTable(front_rows(front))]
    if best.weights:
        rows = counterweight_rows(best.weights, best.regions, SI, DIGITS, "none", FLAT_GAP)
        lines = part_lines(best.weights, part_word(best), FLAT_GAP)
        body += ["", AnswerTable(rows), *lines, *([FRAMES] if lines else [])]
    return body
