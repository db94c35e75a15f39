"""Text of a design for ``balance design``.

`Design.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.app.answers.text.report import distance_text
from balance.masses.designs.best_design import Design
from balance.masses.designs.density import AIR, STEEL
from balance.space.inertial_parameters.body_inertia import BodyInertia
from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop
from balance.support.vector_digits import plain_number, vector_digits
from kinematics.model.motion import while_text
from kinematics.wording import number_text, size_text

UNITS = {"mass": " kg", "inertia": " kg m²", "rotor": " kg m²", "change": ""}
# The command for partial balance, where the words of the request are not at hand.
REDUCE = "balance reduce MODEL --links LINKS --budget KG"
FORCE_ONLY = "not balanced: compare it by balance verify FILE --against MODEL"
# Distance to a rank drop, in characteristic lengths, below which a geometry may be a rounded
# special one.
NEAR_SPECIAL = 1e-2
# Digits of masses and objectives: the conic solver finds an optimum to about six, and those of
# other processors may differ in the last of them.
DIGITS = 4
# Digits of the largest coordinate of a centre of mass: a quotient, which a least mass leaves
# free to about 1e-5 of its size.
COM_DIGITS = 3
# Density of steel with what a solver leaves open, kg/m³.
DENSER_THAN_STEEL = 1.001 * STEEL
# Digits of moments of inertia: objectives determine them less well than masses.
MOMENT_DIGITS = 2


def other_ways(balance: str, reduce: str = REDUCE) -> list[tuple[str, str]]:
    """List what is left to try where nothing balances, as pairs of label and value.

    Args:
        balance: what was asked for, ``"dynamic"`` or ``"force"``.
        reduce: the command for the least shaking.
    """
    forces = "--balance force: the forces alone; " if balance == "dynamic" else ""
    return [
        ("other ways", f"{forces}balance remedies: what to build in"),
        ("reduce", reduce),
    ]


def design_facts(design: Design, reduce: str = REDUCE) -> list[tuple[str, str]]:
    """List the facts on a design, without the table of bodies, as pairs of label and value.

    Args:
        reduce: the command for the least shaking, which a design that is infeasible names.
    """
    space = design.space
    algebra = "planar" if space.planar else "spatial"
    relations = space.motion.relations if space.motion else ()
    pairs = linkage_facts(space.linkage, f"{algebra}, {space.aim}", relations)
    count = space.rank + space.nullity
    size = f"{space.nullity} of {count} dimensions, {space.level}"
    pairs.append(("design space", size))
    pairs += [("reading", reading.words) for reading in space.readings]
    when = f"{design.verdict}{while_text(space.motion)}"
    pairs.append(("verdict", design.words.replace(design.verdict, when, 1)))
    pairs += _what_else(design, reduce)
    if design.minimise:
        value = "" if design.value is None else f": {size_text(design.value, f'.{DIGITS}g')}"
        unit = _unit(design) if value else ""
        pairs.append(("minimised", f"{design.minimise}{value}{unit}"))
    if design.floor:
        pairs.append(("floor", _floor_text(design)))
    if design.keep:
        pairs.append(("kept", ", ".join(design.keep)))
    if design.bounds:
        limits = (f"{name} {_mass_range(*pair)} kg" for name, pair in design.bounds.items())
        pairs.append(("bounds", ", ".join(limits)))
    pairs.append(("limits", _region_text(design)))
    if text := _density_text(design):
        pairs.append(("density", text))
    pairs += unusual_matter(design)
    if design.residuals:
        unasked = {"accepted"} if design.density else {"accepted", "density"}
        named = [item for item in design.residuals._asdict().items() if item[0] not in unasked]
        pairs.append(("residuals", ", ".join(f"{name} {size_text(x)}" for name, x in named)))
    return pairs


def body_rows(bodies: Sequence[BodyInertia], length: float) -> list[tuple[str, ...]]:
    """Build the table of bodies, its head first.

    Args:
        length: characteristic length, m; shorter coordinates by ten decades are zero.
    """
    head = ("body", "mass (kg)", "centre of mass, link frame (m)", "principal moments (kg m²)")
    return [head, *(_row(body, length) for body in bodies)]


def design_body(design: Design, reduce: str = REDUCE, following: str = "") -> AnswerBody:
    """Build what is printed on a design; see `design_facts`.

    Args:
        following: the command that comes next; empty without one.
    """
    body: list[AnswerPart] = [f"Next: {following}", ""] if following else []
    body.append(Facts(design_facts(design, reduce), least=13))
    if design.bodies:
        body += ["", AnswerTable(body_rows(design.bodies, design.space.length))]
    if design.bodies and design.density:
        body += ["", AnswerTable(solid_rows(design))]
    return body


def _what_else(design: Design, reduce: str) -> list[tuple[str, str]]:
    """List what a verdict leaves open: other ways, a special geometry near, the moment."""
    space = design.space
    if space.requirements:
        return []
    if design.verdict != "infeasible":
        force_only = space.balance == "force" and design.z is not None
        return [("moment", FORCE_ONLY)] if force_only else []
    pairs = other_ways(space.balance, reduce)
    if space.balance == "force":
        return pairs
    change = distance_to_rank_drop(space)
    if change < NEAR_SPECIAL:
        pairs.append(("near-special", f"{distance_text(change)}: were coordinates rounded?"))
    return pairs


def _floor_text(design: Design) -> str:
    """Describe the least mass and extent of a link, and what sets the size of the design."""
    assert design.floor is not None
    mass, moment = design.floor
    text = (
        f"each link at least {number_text(mass, '.3g')} kg, with second moments of at least "
        f"{number_text(moment, '.3g')} kg m²"
    )
    if design.keep or any(low > 0.0 for low, _ in design.bounds.values()):
        return text
    return (
        f"{text}; nothing else sets the size of the masses: --keep a link, or give one a least "
        f"mass, such as --bounds {design.space.bodies[0]}=0.1:"
    )


def _region_text(design: Design) -> str:
    """Describe the balls that must contain the masses."""
    if design.within is None:
        return "none: masses may be anywhere"
    flat = ", seen in the plane" if design.space.planar else ""
    return (
        f"the mass of each link within {design.within:g} lengths of the link from the middle "
        f"of its joints{flat} (--anywhere lifts this)"
    )


def _density_text(design: Design) -> str:
    """Describe the limits of density, and the density of the body that needs most.

    A certificate that holds for any density has no such row.
    """
    text, decides = "", design.z is not None or "kg/m³" in design.words
    if design.density and decides:
        limits = [f"{limit:g}" for limit in sorted(set(design.density.values()))]
        text = f"at most {' to '.join(dict.fromkeys((limits[0], limits[-1])))} kg/m³"
        if design.thickness is not None:
            text += f", links {number_text(1e3 * design.thickness, '.3g')} mm thick"
        unlimited = [
            name for name in design.space.bodies if name not in {*design.density, *design.keep}
        ]
        if unlimited:
            text += f"; no limit for {', '.join(unlimited)}"
        else:
            text += " (--density none lifts this)"
    if design.densest is None:
        return text
    name, density = design.densest
    if design.density:
        return f"{text}; densest body: {name}, {plain_number(density, COM_DIGITS)} kg/m³"
    text = f"no limit; densest body: {name}, {plain_number(density, MOMENT_DIGITS)} kg/m³"
    if density > STEEL:
        text += f", {plain_number(density / STEEL, MOMENT_DIGITS)} times steel"
    return f"{text}, as an ellipsoid (--density limits it)"


def unusual_matter(design: Design) -> list[tuple[str, str]]:
    """List the bodies that are lighter than air or denser than steel, as facts.

    Bodies that are kept are left out.
    """
    pairs = []
    for name, solid in zip(design.space.bodies, design.solids, strict=False):
        if solid is None or name in design.keep or AIR <= solid.density <= DENSER_THAN_STEEL:
            continue
        if solid.density < AIR:
            what = (
                f"lighter than air, {plain_number(solid.density, MOMENT_DIGITS)} kg/m³, as a "
                "solid: build it as masses at the ends of a light frame"
            )
            if name in design.more_mass:
                least = number_text(design.more_mass[name][0], ".2g")
                what += f", or give it more mass, such as --bounds {name}={least}:"
        else:
            size = f"{plain_number(solid.density, MOMENT_DIGITS)} kg/m³"
            if not solid.density < np.inf:
                size = "a body without volume"
            what = f"denser than steel, {size}: --density steel asks for bodies of steel"
        pairs.append(("matter", f"{name} is {what}"))
    return pairs


def solid_rows(design: Design) -> list[tuple[str, ...]]:
    """Build the table of the solids that have the inertia of the bodies, its head first."""
    rows: list[tuple[str, ...]] = [
        ("body", "solid of its inertia", "size (mm)", "mass (g)", "density (kg/m³)")
    ]
    for name, solid in zip(design.space.bodies, design.solids, strict=True):
        if solid is None:
            rows.append((name, "none", "", "", ""))
            continue
        mass = plain_number(1e3 * solid.mass, DIGITS)
        rows.append((name, solid.name, solid.size_text, mass, solid.density_text))
    return rows


def _unit(design: Design) -> str:
    """Return the unit of the objective, after a blank."""
    assert design.minimise is not None
    space, unit = design.space, UNITS[design.minimise]
    slides = [
        joint.name
        for joint in space.linkage.joints
        if joint.kind == "prismatic" and joint.name in {*space.inputs} - {*space.idle}
    ]
    if design.minimise == "rotor" and slides:
        length = number_text(space.length, f".{DIGITS}g")
        return f"{unit}, {', '.join(slides)} in lengths of {length} m"
    return unit


def _mass_range(low: float, high: float) -> str:
    """Describe the limits of a mass, kg."""
    if np.isinf(high):
        return f"at least {low:g}"
    return f"{low:g} to {high:g}" if low else f"at most {high:g}"


def _row(body: BodyInertia, length: float) -> tuple[str, ...]:
    """Build the row of one body, with principal moments about its centre of mass."""
    com = "" if body.link_com is None else vector_digits(body.link_com, COM_DIGITS, length)
    inertia = body.link_inertia
    moments = (
        ""
        if inertia is None
        else vector_digits(
            np.asarray(np.linalg.eigvalsh(inertia)), MOMENT_DIGITS, body.mass * length**2
        )
    )
    return body.name, number_text(body.mass, f".{DIGITS}g"), com, moments
