"""Text of a design space for ``balance report``.

`balance.report.data` has the same content as data for ``--json``.
"""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

from balance.tolerances import CHANGE_DETERMINED
from kinematics.tolerances import MARGIN_DETERMINED
from kinematics.wording import number_text, size_text

if TYPE_CHECKING:
    from balance.decoupled.decoupling import Decoupling
    from balance.dynamic_equivalence.pure_inertia import PureInertia
    from balance.exact.modular_ranks import Exact
    from balance.interpretation.explain import Explanation
    from balance.report.data import Report
    from balance.spaces.design_space import DesignSpace

__all__ = [
    "comparison_facts",
    "decoupling_facts",
    "distance_text",
    "explanation_sections",
    "gap_text",
    "inertia_sections",
    "report_facts",
    "report_for_terminal",
    "report_table",
    "report_text",
]


def report_facts(space: DesignSpace, change: float = inf) -> list[tuple[str, str]]:
    """List the facts on a design space, without the table, as pairs of label and value.

    Args:
        space: the design space.
        change: result of `balance.distance_to_rank_drop`.
    """
    linkage = space.linkage
    algebra = "planar" if space.planar else "spatial"
    count = space.rank + space.nullity
    loops = f"{len(linkage.loops)} loop{'' if len(linkage.loops) == 1 else 's'}"
    lines = [
        ("linkage", f"{linkage.name}, {algebra}, {space.balance} balance"),
        ("bodies", f"{', '.join(space.bodies)} ({count} parameters)"),
        ("joints", f"{len(linkage.joints)} with one degree of freedom each, {loops}"),
        ("mobility", f"{linkage.mobility}, inputs {', '.join(space.inputs)}"),
    ]
    if linkage.at:
        lines.append(("pose", linkage.pose))
    if space.motion:
        lines.append(("motion", ", ".join(space.motion.relations)))
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
        ("design space", f"{space.nullity} of {count} dimensions: {_parts_text(space)}"),
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


def _parts_text(space: DesignSpace) -> str:
    """Describe the serial and the parallel part of the design space."""
    return f"{space.serial.shape[1]} serial + {space.parallel.shape[1]} parallel"


def _completeness(space: DesignSpace) -> str:
    """Describe whether the conditions are complete, and at which order."""
    last = space.orders[-1].order
    if space.settled:
        if space.kmax is None:
            return f"complete with {space.poses} poses; order {last} was not enough"
        return f"complete at order {space.kmax}"
    poses = f" and at {space.poses} poses" if space.poses else ""
    return f"up to order {last}{poses}: not complete"


def report_table(space: DesignSpace, exact: Exact | None = None) -> list[tuple[str, ...]]:
    """Build the table of rank and nullity by order, its head first.

    Args:
        space: the design space.
        exact: result of `balance.exact_ranks`, for a column of its own; None without it.
    """
    if exact is None:
        rows = ((str(o.order), str(o.rank), str(o.nullity)) for o in space.orders)
        return [("order", "rank", "nullity"), *rows]
    known = {o.order: (str(o.rank), str(o.nullity)) for o in space.orders}
    return [
        ("order", "rank", "nullity", "exact"),
        *((str(k), *known.get(k, ("", "")), str(rank)) for k, rank in enumerate(exact.ranks)),
    ]


def report_text(report: Report) -> str:
    """Write the report on a design space as plain text."""
    space = report.space
    lines = [f"{label:<13} {value}" for label, value in report_facts(space, report.change)]
    rows = ["".join(f"{cell:>8}" for cell in row) for row in report_table(space, report.exact)]
    found = ["\n".join([*lines, "", *rows])]
    for title, pairs in _sections(report):
        width = max(len(label) for label, _ in pairs)
        found.append("\n".join([f"{title}:", *(f"  {a:<{width}}  {b}" for a, b in pairs)]))
    return "\n\n".join(found)


def comparison_facts(report: Report) -> list[tuple[str, str]]:
    """List the facts on a design space and its ranks, for a table of several."""
    ranks = ", ".join(str(order.rank) for order in report.space.orders)
    facts = report_facts(report.space, report.change)
    at = next(k for k, (label, _) in enumerate(facts) if label == "conditions")
    facts.insert(at + 1, ("rank by order", ranks))
    if report.exact is not None:
        facts.insert(at + 2, ("exact ranks", ", ".join(map(str, report.exact.ranks))))
    if report.decoupling is not None:
        facts.append(("decoupled", report.decoupling.words))
    return facts


def explanation_sections(explanation: Explanation) -> list[tuple[str, list[tuple[str, str]]]]:
    """List the sections of an explanation: a title, and pairs of label and text."""
    moves = [(item.title, f"{item.dimension}: {item.words}") for item in explanation.transfers]
    freedoms = [(str(k), f.words) for k, f in enumerate(explanation.freedoms, 1)]
    sections = [
        ("may be moved across each joint", moves),
        ("freed by what couples the joints", freedoms),
    ]
    return [(title, pairs) for title, pairs in sections if pairs]


def decoupling_facts(found: Decoupling) -> list[tuple[str, str]]:
    """List the facts on decoupling, as pairs of label and value.

    Args:
        found: result of `balance.decoupling`.
    """
    residual = "" if found.residual is None else f" (residual {size_text(found.residual)})"
    ranks = " ".join(str(order.rank) for order in found.orders)
    return [
        ("as given", f"{found.words}{residual}"),
        ("design space", found.parts),
        ("rank by order", ranks),
        ("certainty", found.freed.assurance),
        *(("in doubt", doubt) for doubt in found.freed.doubts),
    ]


def inertia_sections(found: PureInertia) -> list[tuple[str, list[tuple[str, str]]]]:
    """List the sections on pure inertias: a title, and pairs of label and text.

    Args:
        found: result of `balance.pure_inertia`.
    """
    stay = {item.body for item in found.left}
    inertias = [
        (name, "mass stays" if name in stay else f"{number_text(value, '.6g')} kg m²")
        for name, value in zip(found.space.bodies, found.inertias.tolist(), strict=True)
    ]
    moved = [(", ".join(item.joints), item.gains_text) for item in found.moved]
    left = [
        (item.body, f"{number_text(item.mass, '.6g')} kg: {item.reason}") for item in found.left
    ]
    related = [(str(k), text) for k, text in enumerate(found.relation_words, 1)]
    asked = [(str(k), text) for k, text in enumerate(found.condition_words, 1)]
    sections = [
        ("pure inertias, of equal momentum", inertias),
        ("point masses that bodies gain on the way there, by joint", moved),
        ("masses that cannot be moved", left),
        ("relations of angular velocities", related),
        ("conditions on pure inertias", asked),
    ]
    return [(title, pairs) for title, pairs in sections if pairs]


def _sections(report: Report) -> list[tuple[str, list[tuple[str, str]]]]:
    """List the sections of a report after its table."""
    found = explanation_sections(report.explanation) if report.explanation else []
    if report.decoupling:
        found.append(("decoupled from a moving base", decoupling_facts(report.decoupling)))
    return found + (inertia_sections(report.pure_inertia) if report.pure_inertia else [])


def report_for_terminal(report: Report) -> str:
    """Write the report on a design space with the styles of a terminal."""
    space = report.space
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    summary = Table.grid(padding=(0, 2))
    for label, value in report_facts(space, report.change):
        summary.add_row(f"[bold]{label}", escape(value))
    head, *rows = report_table(space, report.exact)
    orders = Table(*head)
    for row in rows:
        orders.add_row(*row)
    console = Console()
    with console.capture() as capture:
        console.print(summary)
        console.print(orders)
        for title, pairs in _sections(report):
            section = Table("", "", title=title, title_justify="left", show_header=False)
            for left, right in pairs:
                section.add_row(escape(left), escape(right))
            console.print(section)
    return capture.get()
