"""Text of counterweights for ``balance counterweights``.

`Counterweights.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.design import REDUCE, other_ways
from balance.app.answers.text.linkage import linkage_facts
from balance.app.answers.text.verification import about_text
from balance.masses.counterweights.counterweight import (
    DENSITIES,
    PART_DIGITS,
    Counterweight,
)
from balance.masses.counterweights.counterweights_result import Counterweights
from balance.masses.counterweights.shaped.across_plane import shape_place
from balance.masses.designs.density import STEEL
from balance.motion.verification.comparison import peak_change, round_off_of
from balance.motion.verification.trajectory import singularity_remark
from balance.space.spaces.design_space import DesignSpace
from balance.support.change_text import grows
from balance.support.mass_table import ENTRIES
from balance.support.tolerances import FILLING_GAP, MASS_GAP, MASSES_EQUAL
from balance.support.vector_digits import vector_digits
from kinematics.numerics.linalg.ties import first_largest, round_decimals
from kinematics.wording import number_text, size_text

UNITS = {"mass": "kg", "inertia": "kg m²", "rotor": "kg m²"}
CUBIC_CENTIMETRES = 1e6
DIGITS, PLACE_DIGITS = 5, 4
# The same where moments of inertia are least, see `Counterweights.roughly_known`, and those of
# the moments then.
ROUGH_DIGITS, MOMENT_DIGITS = 3, 2
# Those of shapes with webs, which settle to 1e-6 of their mass, and a gap that counts.
WEB_DIGITS, WEB_GAP = 4, 1e-5
# Added mass, over the given mass, above which partial balance is named.
MUCH_ADDED = 3.0
# Of which frame places are.
FRAMES = (
    "Places, directions and regions are in the link frames of the file, and moments of inertia "
    "along their axes."
)
# The option for plates, where no request for them is known to have an answer.
PLATES = (
    "--shape sector=20mm or disc=20mm asks for plates to cut, which may need larger regions"
)
# What nobody has checked of shapes, which lie in the plane of their links.
LAYERS = (
    "which layer parts are in, and whether they collide with other links or the frame, is not "
    "checked"
)
# Distance from a joint, over the length of the linkage, up to which a centre of mass is at it.
AT_JOINT = 1e-6
# Angle of a sector that a workshop cuts, radians.
CUT_ANGLE = np.radians(60.0)
# What a link gets to which no matter needs to be added.
NONE_NEEDED = "none needed"


def counterweights_facts(
    counterweights: Counterweights, reduce: str = REDUCE
) -> list[tuple[str, str]]:
    """List the facts on counterweights as pairs of label and value.

    Args:
        reduce: the command for the least shaking, which an infeasible answer names.
    """
    space = counterweights.space
    algebra = "planar" if space.planar else "spatial"
    relations = space.motion.relations if space.motion else ()
    pairs = linkage_facts(space.linkage, f"{algebra}, {space.aim}", relations)
    pairs.append(("verdict", counterweights.words))
    if space.balance == "force" and not space.requirements and counterweights.value is not None:
        pairs.append(("moment", _moment_text(counterweights)))
    if counterweights.along is not None:
        pairs.append(("about", about_text(counterweights.along.before)))
        if near := singularity_remark(counterweights.along.before.motions):
            pairs.append(("note", near))
    if counterweights.verdict == "infeasible":
        pairs += other_ways(space.balance, reduce)
    for name, share in counterweights.movable.items():
        pairs.append((f"may move {name}", f"{number_text(100.0 * share)} % of its mass"))
    pairs += _region_facts(counterweights)
    if counterweights.value is not None:
        webs = any(weight.web is not None for weight in counterweights.weights)
        floor = WEB_GAP if webs else MASSES_EQUAL
        floor = FILLING_GAP if counterweights.roughly_known else floor
        gap = size_text(counterweights.gap or 0.0, floor=floor)
        what = _objective_text(counterweights)
        what += "; gap to its proved bound" + " beside these webs" * webs
        pairs.append(("minimised", f"{what} {gap} of it"))
        share = (
            counterweights.added_mass / counterweights.given_mass
            if counterweights.given_mass
            else 0.0
        )
        added = (
            f"{number_text(counterweights.added_mass, counterweights.mass_form)} kg, "
            f"{number_text(share, '.3g')} "
            "times the given mass"
        )
        if share > MUCH_ADDED:
            added += " (balance reduce --pareto 10 weighs mass against shaking)"
        pairs += moved_facts(counterweights.moved)
        pairs += [("added", added), *_shape_facts(counterweights)]
        if space.linkage.planar:
            digits, _ = _digits_of(counterweights)
            pairs += place_facts(space, counterweights.weights, min(PLACE_DIGITS, digits))
        if counterweights.shape is not None:
            pairs += shape_facts(counterweights.weights)
        pairs += density_facts(counterweights.weights)
        pairs.append(("residual", size_text(counterweights.residual or 0.0)))
    if counterweights.check:
        pairs.append(("certificate", str(counterweights.check)))
    # The verdict has the change that it names.
    changes = [change.words for change in counterweights.worth_naming]
    words = counterweights.words
    return pairs + [("would help", change) for change in changes if change not in words]


def _region_facts(counterweights: Counterweights) -> list[tuple[str, str]]:
    """List the regions of links, in one line if they are alike."""
    default = " (default: half the link's length about its joint)"
    texts = {
        name: region.words + default * (name in counterweights.chosen)
        for name, region in counterweights.regions.items()
    }
    if len(texts) > 1 and len({*texts.values()}) == 1:
        return [("regions", f"{next(iter(texts.values()))} on each of {', '.join(texts)}")]
    return [(f"region {name}", text) for name, text in texts.items()]


def _moment_text(counterweights: Counterweights) -> str:
    """Say what becomes of the moment if the forces alone are balanced."""
    along = counterweights.along
    if along is None:
        return "not balanced: --html FILE, or a motion (--speed 300rpm), says how it changes"
    change = peak_change(along.pair, "moment")
    if not grows(along.before.moment, along.after.moment, round_off_of(along.pair, "moment")):
        return change
    ways = ["--balance dynamic balances it too, or says why not"]
    if counterweights.minimise == "mass" and counterweights.shape is None:
        ways.append("--minimise inertia leaves less of it")
    ways.append("balance reduce --budget KG weighs it against the force")
    return f"{change}: it grows; {'; '.join(ways)}"


def _objective_text(counterweights: Counterweights) -> str:
    """Say what was minimised, with the price of mass, and its value."""
    name, unit = counterweights.minimise, UNITS[counterweights.minimise]
    value, whole = (
        number_text(x or 0.0, counterweights.mass_form)
        for x in (counterweights.value, counterweights.priced)
    )
    moving = f" + {number_text(counterweights.price_of_moving)}"
    moving += f"{'' if counterweights.minimise == 'mass' else ' m²'} × moved mass"
    moving = moving if counterweights.movable else ""
    if not (counterweights.price or moving):
        return f"{name}: {value} {unit}"
    price = f" + {number_text(counterweights.price)} m² × added mass"
    what = f"{name}{price if counterweights.price else ''}{moving}"
    return f"{what}: {whole} {unit}, of which {name} {value} {unit}"


def moved_facts(moved: Mapping[str, float]) -> list[tuple[str, str]]:
    """Say what is taken from links whose mass may be placed anew."""
    parts = [f"{number_text(mass, '.5g')} kg of '{name}'" for name, mass in moved.items()]
    text = f"{', '.join(parts)}, taken evenly from all of it, and placed again"
    return [("moved", text)] if moved else []


def _shape_facts(counterweights: Counterweights) -> list[tuple[str, str]]:
    """Say what the shape of counterweights costs beside the least matter of any shape."""
    if counterweights.shape is None or counterweights.least_mass is None:
        return []
    least = counterweights.least_mass
    more = number_text(max(0.0, counterweights.added_mass - least), ".3g")
    text = (
        f"{counterweights.shape}: {more} kg more than the {number_text(least)} kg of any shape"
    )
    return [("shape", text)]


def density_facts(weights: Sequence[Counterweight]) -> list[tuple[str, str]]:
    """Say how dense added matter is, or would have to be at least."""
    if not weights:
        return []
    limits = {weight.link: weight.density for weight in weights if weight.density}
    if limits:
        alike = len(set(limits.values())) == 1
        parts = [f"{number_text(value)} kg/m³ on {link}" for link, value in limits.items()]
        text = (
            f"{number_text(next(iter(limits.values())))} kg/m³" if alike else ", ".join(parts)
        )
        return [("density", f"at most {text}")]
    means = [weight.mean_density for weight in weights]
    densest = first_largest(means)
    times = number_text(means[densest] / STEEL, ".3g")
    text = (
        f"no limit: lumps are points; '{weights[densest].link}' would be {times} times as "
        "dense as steel if it filled its region (--density steel limits it, without --points)"
    )
    return [("density", text)]


def place_facts(
    space: DesignSpace, weights: Sequence[Counterweight], digits: int = PLACE_DIGITS
) -> list[tuple[str, str]]:
    """Say where counterweights of a planar linkage are, as one lays them out on their links.

    Args:
        digits: significant digits of distances.
    """
    places = [_place_text(space, weight, digits) for weight in weights]
    return [("place", f"centre of mass {'; '.join(places)}")] if places else []


def shape_facts(weights: Sequence[Counterweight]) -> list[tuple[str, str]]:
    """Say what holds shapes, what is not checked, and which sectors are too narrow to cut."""
    apart = [
        f"{number_text(1e3 * weight.arm)} mm on '{weight.link}'"
        for weight in weights
        if weight.arm and weight.floats
    ]
    webs = [
        f"{number_text(1e3 * weight.web_sizes[1])} mm wide on '{weight.link}'"
        for weight in weights
        if weight.web is not None
    ]
    pairs = []
    if webs:
        text = (
            f"{', '.join(webs)}: a bar as thick as the part joins it to the nearest joint, and "
            "is counted in mass and loads; --shape sector= needs none"
        )
        pairs.append(("web", text))
    if apart:
        text = (
            f"from the nearest joint to the part {', '.join(apart)}; an arm that holds it is "
            "not counted: add its mass to the link in the file and ask again, or take --shape "
            "sector=, which reaches the joint"
        )
        pairs.append(("arm", text))
    return [*pairs, ("layers", LAYERS), *_sliver_facts(weights)] if weights else []


def _place_text(space: DesignSpace, weight: Counterweight, digits: int) -> str:
    """Write where a counterweight is from the joint that carries its link.

    In line with another joint of the link it is towards it or opposite to it; else it has a
    direction in the frame of the link, and an angle to each of these joints.
    """
    place = shape_place(space, weight)
    if place.distance <= AT_JOINT * space.length:
        return f"at {place.joint} on '{weight.link}'"
    distance = number_text(1e3 * place.distance, f".{digits}g")
    at = f"{distance} mm from {place.joint} on '{weight.link}'"
    angles = {name: number_text(angle, ".1f") for name, angle in place.away.items()}
    in_line = {"0.0": "towards", "180.0": "opposite"}
    for name, angle in angles.items():
        if angle in in_line:
            return f"{at}, {in_line[angle]} {name}"
    # A direction of -180° is that of 180°: round-off decides which.
    direction = round(place.direction, 1)
    direction += 360.0 if direction <= -180.0 else 0.0
    from_joints = [f"{angle}° from {name}" for name, angle in angles.items()]
    return ", ".join([at, f"at {number_text(direction)}° of its frame", *from_joints])


def _sliver_facts(weights: Sequence[Counterweight]) -> list[tuple[str, str]]:
    """Say which sectors are too narrow to cut, and which shapes of the same mass are not.

    The centre of a sector of radius R and angle α is at ``2/3 R sin(α/2)/(α/2)`` from the
    joint. A disc of the same mass has the radius ``R √(α/2π)`` and lies further out, at the
    rim; a sector of `CUT_ANGLE` has the radius ``R √(α/60°)`` and is nearer to the joint. What
    they cost is the ratio of these distances: that of the unbalances of one mass.
    """
    pairs = []
    for weight in weights:
        region = weight.region
        angle = 2.0 * region.half_angle
        if not weight.too_narrow:
            continue
        radius, _, half = np.linalg.norm(region.place[:3, :3], axis=0).tolist()
        thickness = f"{number_text(2e3 * half)}mm"
        wide = number_text(1e3 * radius * (angle / CUT_ANGLE) ** 0.5, ".2g")
        turn = number_text(np.degrees(angle), ".2g")
        narrow = np.sinc(0.5 * angle / np.pi)
        far = 1.5 * (1.0 - (0.5 * angle / np.pi) ** 0.5) / narrow
        near = (angle / CUT_ANGLE) ** 0.5 * np.sinc(0.5 * CUT_ANGLE / np.pi) / narrow
        text = (
            f"a sector of {turn}° on '{weight.link}' is too narrow to cut: take --shape "
            f"disc={thickness} (the same mass at the rim has {number_text(far, '.2g')} times "
            f"the unbalance), or, with {np.degrees(CUT_ANGLE):.0f}°, --shape "
            f"sector={thickness},{wide}mm (the same mass has {number_text(near, '.2g')} times "
            "the unbalance)"
        )
        pairs.append(("sliver", text))
    return pairs


def part_lines(
    weights: Sequence[Counterweight], how: str = "", gap: float = MASS_GAP
) -> list[str]:
    """Say which part of its region each filled counterweight is.

    Args:
        weights: counterweights; those that fill no part are left out.
        how: a word before the part.
        gap: part of the sum of all masses to which each is known.
    """
    filled = [weight for weight in weights if weight.form is not None]
    known = gap * sum(weight.mass for weight in weights)
    lines = []
    for weight in filled:
        digits = 1 + int(np.floor(np.log10(max(weight.mass / known, 1.0))))
        part = weight.part_text(min(PART_DIGITS, digits))
        lines.append(f"{weight.link} fills {how}{part}")
    return lines


class TableUnits(NamedTuple):
    """Units of a table of counterweights: names, and how many of each in the unit of SI."""

    mass: str
    length: str
    per_si: float


SI = TableUnits("kg", "m", 1.0)
WORKSHOP = TableUnits("g", "mm", 1e3)


def counterweight_rows(
    weights: Sequence[Counterweight],
    links: Iterable[str] = (),
    units: TableUnits = SI,
    digits: int = DIGITS,
    nothing: str = NONE_NEEDED,
    gap: float = MASS_GAP,
) -> list[tuple[str, ...]]:
    """Build the table of lumps, its head first; a link with many lumps has one row.

    Args:
        links: links that may get matter: those that get none are named too.
        digits: significant digits of masses, volumes and positions.
        nothing: what these get, in words.
        gap: part of the sum of all masses to which each is known.
    """
    metals = tuple(f"{name} (cm³)" for name in DENSITIES)
    head = ("link", f"mass ({units.mass})", f"position, link frame ({units.length})", *metals)
    rows: list[tuple[str, ...]] = [head]
    total = sum(weight.mass for weight in weights)
    decimals = -int(np.floor(np.log10(gap * total))) if total > 0.0 else 0
    # Lumps of a small region have the round-off of the largest one.
    size = units.per_si * max((weight.region.size for weight in weights), default=0.0)
    for weight in weights:
        parts = [(lump.mass, lump.position) for lump in weight.lumps]
        for known, centre in parts or [(weight.mass, weight.com)]:
            mass = float(round_decimals(known, decimals))
            # Rounded once: a half that the first of two roundings made would go either way.
            place = digits - 1 - int(np.floor(np.log10(mass))) if mass > 0.0 else 0
            written = float(round_decimals(known, min(decimals, place)))
            known_digits = max(1, min(DIGITS, digits, digits + decimals - place))
            position = vector_digits(units.per_si * centre, digits, size)
            volumes = (
                number_text(CUBIC_CENTIMETRES * written / density, f".{known_digits}g")
                for density in DENSITIES.values()
            )
            text = number_text(units.per_si * written, f".{digits}g")
            rows.append((weight.link, text, position, *volumes))
    filled = {weight.link for weight in weights}
    rows += [(link, nothing, "", *("" for _ in metals)) for link in links if link not in filled]
    return rows


def _digits_of(counterweights: Counterweights) -> tuple[int, int]:
    """Return the digits to which masses and places, and moments of inertia, are written."""
    if counterweights.roughly_known:
        return ROUGH_DIGITS, MOMENT_DIGITS
    webs = any(weight.web is not None for weight in counterweights.weights)
    return (WEB_DIGITS, WEB_DIGITS) if webs else (DIGITS, DIGITS)


def counterweights_body(
    counterweights: Counterweights,
    reduce: str = REDUCE,
    following: str = "",
    plates: str = "",
) -> AnswerBody:
    """Build what is printed on counterweights; see `counterweights_facts`.

    Args:
        following: the command that comes next where nothing balances; empty without one.
        plates: the command for plates that can be cut; empty without one.
    """
    facts = Facts(counterweights_facts(counterweights, reduce), least=1)
    digits, moment_digits = _digits_of(counterweights)
    lead = [f"Next: {following}"] if following else []
    lead += [f"Next, as plates to cut: {plates}"] if plates else []
    option = counterweights.may_have_shape and not plates
    body: list[AnswerPart] = [counterweights.sentence, *lead, "", facts]
    if counterweights.z is not None:
        rows = counterweight_rows(counterweights.weights, counterweights.regions, digits=digits)
        body += ["", AnswerTable(rows)]
    body += [*part_lines(counterweights.weights), *[PLATES] * option]
    for weight in counterweights.weights:
        # The sizes of shapes say what their moments are.
        if not (weight.lumps or counterweights.shape):
            moments = vector_digits(weight.inertia[ENTRIES], moment_digits)
            verb = "needs" if weight.form is None else "has"
            body.append(
                f"{weight.link} {verb} about its centre Ixx, Iyy, Izz, Ixy, Ixz, Iyz = "
                f"{moments} kg m²"
            )
    if not all(weight.lumps for weight in counterweights.weights):
        body.append(FRAMES)
    return body
