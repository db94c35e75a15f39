"""Text of a design space for ``balance report``.

`balance.app.answers.data` has the same content as data for ``--json``.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from balance.app.answers.answer import AnswerBody, AnswerPart, AnswerSection, AnswerTable, Facts
from balance.app.answers.text.linkage import linkage_facts
from balance.support.tolerances import CHANGE_DETERMINED
from kinematics.numerics.tolerances import MARGIN_DETERMINED
from kinematics.wording import number_text, size_text

if TYPE_CHECKING:
    from balance.app.answers.data import Report
    from balance.masses.pure_inertias.pure_inertia import PureInertia
    from balance.space.decoupled.decoupling import Decoupling
    from balance.space.exact.modular_ranks import ExactRanks
    from balance.space.interpretation.explain import Explanation
    from balance.space.spaces.design_space import DesignSpace


def report_facts(space: DesignSpace, change: float = inf) -> list[tuple[str, str]]:
    """List the facts on a design space, without the table, as pairs of label and value.

    Args:
        change: result of `balance.space.distance_to_rank_drop`.
    """
    linkage = space.linkage
    algebra = "planar" if space.planar else "spatial"
    count = space.rank + space.nullity
    loops = f"{len(linkage.loops)} loop{'' if len(linkage.loops) == 1 else 's'}"
    bodies = [
        ("bodies", f"{', '.join(space.bodies)} ({count} parameters)"),
        ("joints", f"{len(linkage.joints)} with one degree of freedom each, {loops}"),
        ("mobility", f"{linkage.mobility}, inputs {', '.join(space.inputs)}"),
    ]
    relations = space.motion.relations if space.motion else ()
    lines = linkage_facts(linkage, f"{algebra}, {space.aim}", relations, bodies)
    if space.idle:
        lines.append(("idle joints", ", ".join(space.idle)))
    given = space.as_given
    if space.kept <= MARGIN_DETERMINED:
        # Floating point sees the linkage of lower rank itself, or not, as it rounds.
        change = 0.0
    # Near a linkage of lower rank round-off turns the space, and the residual with it.
    if given.residual is None or change <= MARGIN_DETERMINED:
        residual = ""
    else:
        residual = f" (residual {size_text(given.residual)})"
    return [
        *lines,
        ("conditions", f"{space.rank}, {_completeness(space)}"),
        ("design space", f"{space.nullity} of {count} dimensions: {space.parts_text}"),
        ("gap", gap_text(space.kept, space.dropped)),
        *([("near-special", distance_text(change))] if change < inf else []),
        *(("reading", reading.words) for reading in space.readings),
        ("certainty", space.assurance),
        *(("in doubt", doubt) for doubt in space.doubts),
        ("as given", f"{given.verdict}{residual}"),
    ]


def gap_text(kept: float, dropped: float) -> str:
    """Describe the gap between singular values that count and those that do not.

    Args:
        kept: the smallest that counts, relative to the largest.
        dropped: bound of the largest that does not.
    """
    kept_text = size_text(kept, floor=MARGIN_DETERMINED)
    return f"{kept_text} kept, {size_text(dropped)} dropped (singular values)"


def distance_text(change: float) -> str:
    """Describe the distance to the nearest linkage of lower rank, relative to the size."""
    size = size_text(change, floor=CHANGE_DETERMINED)
    by = size if size.startswith("below") else f"by {size}"
    return f"to first order, a change {by} of the size lowers the rank"


def _completeness(space: DesignSpace) -> str:
    """Describe whether the conditions are complete, and at which order."""
    if space.requirements:
        return "complete" if space.settled else "not complete"
    last = space.orders[-1].order
    if space.settled:
        if space.kmax is None:
            return f"complete with {space.poses} poses; order {last} was not enough"
        return f"complete at order {space.kmax}"
    poses = f" and at {space.poses} poses" if space.poses else ""
    return f"up to order {last}{poses}: not complete"


def report_table(space: DesignSpace, exact: ExactRanks | None = None) -> list[tuple[str, ...]]:
    """Build the table of rank and nullity by order, or of the requirements, its head first.

    Args:
        exact: result of `balance.checks.exact_ranks`, for a column of its own; None without it.
    """
    if space.requirements:
        listed = ((item.text, str(item.rank), str(item.adds)) for item in space.requirements)
        return [("requirement", "conditions", "beyond others"), *listed]
    if exact is None:
        rows = ((str(o.order), str(o.rank), str(o.nullity)) for o in space.orders)
        return [("order", "rank", "nullity"), *rows]
    counts = {o.order: (str(o.rank), str(o.nullity)) for o in space.orders}
    return [
        ("order", "rank", "nullity", "exact"),
        *((str(k), *counts.get(k, ("", "")), str(rank)) for k, rank in enumerate(exact.ranks)),
    ]


def report_body(report: Report) -> AnswerBody:
    """Build what is printed on a design space."""
    body: list[AnswerPart] = [
        report.space.can_balance.sentence,
        *([f"Next: {report.following}"] if report.following else []),
        *([f"      {report.alternative}"] if report.alternative else []),
        "",
        Facts(report_facts(report.space, report.change), least=13),
        "",
        _ranks(report),
    ]
    for section in _sections(report):
        body += ["", section]
    return body


def _ranks(report: Report) -> AnswerTable:
    """Build the table of ranks as it is printed."""
    table = report_table(report.space, report.exact)
    if report.space.requirements:
        return AnswerTable(table, "<>")
    return AnswerTable(table, ">", least=8, gap=0)


def comparison_facts(report: Report) -> list[tuple[str, str]]:
    """List the facts on a design space and its ranks, for a table of several."""
    ranks = ", ".join(str(order.rank) for order in report.space.orders)
    facts = report_facts(report.space, report.change)
    facts.insert(1, ("answer", report.space.can_balance.sentence))
    at = next(k for k, (label, _) in enumerate(facts) if label == "conditions")
    if ranks:
        facts.insert(at + 1, ("rank by order", ranks))
    if report.exact is not None:
        facts.insert(at + 2, ("exact ranks", ", ".join(map(str, report.exact.ranks))))
    if report.decoupling is not None:
        facts.append(("decoupled", report.decoupling.words))
    return facts


def _explanation_sections(explanation: Explanation) -> list[AnswerSection]:
    """List the sections of an explanation that say something."""
    moves = [(item.title, f"{item.dimension}: {item.words}") for item in explanation.transfers]
    freedoms = [(str(k), f.words) for k, f in enumerate(explanation.freedoms, 1)]
    sections = [
        AnswerSection("may be moved across each joint", moves),
        AnswerSection("freed by what couples the joints", freedoms),
    ]
    return [section for section in sections if section.pairs]


def decoupling_facts(decoupling: Decoupling) -> list[tuple[str, str]]:
    """List the facts on decoupling, as pairs of label and value.

    Args:
        decoupling: result of `balance.space.decoupling`.
    """
    residual = (
        "" if decoupling.residual is None else f" (residual {size_text(decoupling.residual)})"
    )
    ranks = " ".join(str(order.rank) for order in decoupling.orders)
    return [
        ("as given", f"{decoupling.words}{residual}"),
        ("design space", decoupling.parts),
        ("rank by order", ranks),
        ("certainty", decoupling.freed.assurance),
        *(("in doubt", doubt) for doubt in decoupling.freed.doubts),
    ]


def inertia_sections(pure_inertia: PureInertia) -> list[AnswerSection]:
    """List the sections on pure inertias that say something.

    Args:
        pure_inertia: result of `balance.masses.pure_inertia`.
    """
    stay = {item.body for item in pure_inertia.immovable}
    inertias = [
        (name, "mass stays" if name in stay else f"{number_text(value, '.6g')} kg m²")
        for name, value in zip(
            pure_inertia.space.bodies, pure_inertia.inertias.tolist(), strict=True
        )
    ]
    moved = [(", ".join(item.joints), item.gains_text) for item in pure_inertia.moved]
    unmoved = [
        (item.body, f"{number_text(item.mass, '.6g')} kg: {item.reason}")
        for item in pure_inertia.immovable
    ]
    related = [(str(k), text) for k, text in enumerate(pure_inertia.relation_words, 1)]
    asked = [(str(k), text) for k, text in enumerate(pure_inertia.condition_words, 1)]
    sections = [
        AnswerSection("pure inertias, of equal momentum", inertias),
        AnswerSection("point masses that bodies gain on the way there, by joint", moved),
        AnswerSection("masses that cannot be moved", unmoved),
        AnswerSection("relations of angular velocities", related),
        AnswerSection("conditions on pure inertias", asked),
    ]
    return [section for section in sections if section.pairs]


def _sections(report: Report) -> list[AnswerSection]:
    """List the sections of a report after its table."""
    sections = _explanation_sections(report.explanation) if report.explanation else []
    if report.decoupling:
        facts = decoupling_facts(report.decoupling)
        sections.append(AnswerSection("decoupled from a moving base", facts))
    return sections + (inertia_sections(report.pure_inertia) if report.pure_inertia else [])
