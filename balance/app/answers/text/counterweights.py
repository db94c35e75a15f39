"""Text of counterweights for ``balance counterweights``.

`Counterweights.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from collections.abc import Sequence

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerTable, Facts
from balance.app.answers.text.design import FORCE_ONLY, OTHER_WAYS, vector_digits
from balance.app.answers.text.linkage import linkage_facts
from balance.masses.counterweights.answer import Counterweights
from balance.masses.counterweights.counterweight import DENSITIES, Counterweight
from balance.support.tolerances import MASSES_EQUAL
from kinematics.wording import number_text, size_text

UNITS = {"mass": "kg", "inertia": "kg m²", "rotor": "kg m²"}
CUBIC_CENTIMETRES = 1e6
DIGITS = 5
# Rows and columns of Ixx, Iyy, Izz, Ixy, Ixz, Iyz.
ENTRIES = ((0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2))
# Added mass, over the given mass, above which partial balance is named, and above which a
# change of the request is no help.
MUCH_ADDED = 3.0
MOST_ADDED = 100.0


def counterweights_facts(counterweights: Counterweights) -> list[tuple[str, str]]:
    """List the facts on counterweights as pairs of label and value."""
    space = counterweights.space
    algebra = "planar" if space.planar else "spatial"
    relations = space.motion.relations if space.motion else ()
    pairs = linkage_facts(space.linkage, f"{algebra}, {space.aim}", relations)
    pairs.append(("verdict", counterweights.words))
    if space.balance == "force" and not space.requirements and counterweights.value is not None:
        pairs.append(("moment", FORCE_ONLY))
    more = space.balance == "dynamic" or bool(space.requirements)
    if more and counterweights.verdict == "infeasible":
        pairs.append(OTHER_WAYS)
    for name, region in counterweights.regions.items():
        default = " (default: half the link's length about its joint)"
        pairs.append(
            (f"region {name}", region.text + default * (name in counterweights.chosen))
        )
    if counterweights.value is not None:
        value = number_text(counterweights.value, f".{DIGITS}g")
        gap = size_text(counterweights.gap or 0.0, floor=MASSES_EQUAL)
        value = f"{counterweights.minimise}: {value} {UNITS[counterweights.minimise]}"
        pairs.append(("minimised", f"{value}; gap to its proved bound {gap} of it"))
        share = (
            counterweights.added_mass / counterweights.given_mass
            if counterweights.given_mass
            else 0.0
        )
        added = (
            f"{number_text(counterweights.added_mass, f'.{DIGITS}g')} kg, "
            f"{number_text(share, '.3g')} "
            "times the given mass"
        )
        if share > MUCH_ADDED:
            added += " (balance reduce --pareto 10 weighs mass against shaking)"
        pairs += [("added", added), ("residual", size_text(counterweights.residual or 0.0))]
    if counterweights.check:
        pairs.append(("certificate", str(counterweights.check)))
    most = MOST_ADDED * counterweights.given_mass
    pairs += [
        ("would help", relaxation.words)
        for relaxation in counterweights.relaxations
        if relaxation.mass <= most
    ]
    return pairs


def counterweight_rows(
    weights: Sequence[Counterweight], digits: int = DIGITS
) -> list[tuple[str, ...]]:
    """Build the table of lumps, its head first; a link with many lumps has one row.

    Args:
        digits: significant digits of masses and positions.
    """
    metals = tuple(f"{name} (cm³)" for name in DENSITIES)
    rows: list[tuple[str, ...]] = [("link", "mass (kg)", "position, link frame (m)", *metals)]
    for weight in weights:
        parts = [(lump.mass, lump.position) for lump in weight.lumps]
        for mass, position in parts or [(weight.mass, weight.com)]:
            place = vector_digits(position, digits, weight.region.size)
            volumes = (
                number_text(CUBIC_CENTIMETRES * mass / density)
                for density in DENSITIES.values()
            )
            rows.append((weight.link, number_text(mass, f".{digits}g"), place, *volumes))
    return rows


def counterweights_body(counterweights: Counterweights) -> AnswerBody:
    """Build what is printed on counterweights."""
    body: list[AnswerPart] = [Facts(counterweights_facts(counterweights), least=1)]
    if counterweights.weights:
        body += ["", AnswerTable(counterweight_rows(counterweights.weights))]
    for weight in counterweights.weights:
        if not weight.lumps:
            moments = vector_digits(weight.inertia[ENTRIES], DIGITS)
            body.append(f"{weight.link} needs about its centre Ixx, Iyy, Izz, Ixy, Ixz, Iyz = "
                        f"{moments} kg m²")  # fmt: skip
    return body
