"""What a design space says, as text; nothing here prints.

The same as data is `DesignSpace.to_dict`, the contract of ``balance report --json``.
"""

from __future__ import annotations

import json
from importlib.resources import files
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from balance.exact.ranks import Exact
    from balance.interpretation.explain import Explanation
    from balance.spaces.design_space_result import DesignSpace

__all__ = ["facts", "meaning", "schema", "table", "text"]


def schema() -> dict[str, object]:
    """The JSON schema (draft 2020-12) of `DesignSpace.to_dict`."""
    path = files("balance").joinpath("schemas", "report.schema.json")
    return dict(json.loads(path.read_text(encoding="utf-8")))


def facts(space: DesignSpace) -> list[tuple[str, str]]:
    """The report without its table, as pairs of a label and a value."""
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
    verdict = "balanced" if given.balanced else "not balanced"
    return [
        *lines,
        ("conditions", f"{space.rank}, {_state(space)}"),
        ("design space", f"{space.nullity} of {count} dimensions: {_parts(space)}"),
        ("gap", f"{space.kept:.1e} kept, {space.dropped:.1e} dropped (singular values)"),
        *([("near-special", near)] if (near := _nearness(space)) else []),
        ("certainty", f"{space.certainty.level}: {space.certainty.reason}"),
        *(("in doubt", doubt) for doubt in space.certainty.doubts),
        ("as given", f"{verdict} (residual {given.residual:.1e})"),
    ]


def _nearness(space: DesignSpace) -> str:
    """How far the next linkage of lower rank is; empty if that is not known."""
    if space.nearest_drop is None:
        return ""
    return f"to first order, a change by {space.nearest_drop:.1e} of the size lowers the rank"


def _parts(space: DesignSpace) -> str:
    """How the design space is made up."""
    return f"{space.serial.shape[1]} serial + {space.parallel.shape[1]} parallel"


def _state(space: DesignSpace) -> str:
    """Whether the conditions are all there are."""
    last = space.orders[-1].order
    if space.settled:
        if space.kmax is None:
            return f"complete with {space.poses} poses; order {last} was not enough"
        return f"complete at order {space.kmax}"
    poses = f" and at {space.poses} poses" if space.poses else ""
    return f"up to order {last}{poses}: not complete"


def table(space: DesignSpace, exact: Exact | None = None) -> list[tuple[str, ...]]:
    """Rows of the table by order, its head first."""
    if exact is None:
        rows = ((str(o.order), str(o.rank), str(o.nullity)) for o in space.orders)
        return [("order", "rank", "nullity"), *rows]
    known = {o.order: (str(o.rank), str(o.nullity)) for o in space.orders}
    return [
        ("order", "rank", "nullity", "exact"),
        *((str(k), *known.get(k, ("", "")), str(rank)) for k, rank in enumerate(exact.ranks)),
    ]


def text(
    space: DesignSpace, explanation: Explanation | None = None, exact: Exact | None = None
) -> str:
    """The report as plain text, with what it means and exact ranks if these are given."""
    lines = [f"{label:<13} {value}" for label, value in facts(space)]
    rows = ["".join(f"{cell:>8}" for cell in row) for row in table(space, exact)]
    found = ["\n".join([*lines, "", *rows])]
    for title, pairs in meaning(explanation) if explanation else []:
        width = max(len(label) for label, _ in pairs)
        found.append("\n".join([f"{title}:", *(f"  {a:<{width}}  {b}" for a, b in pairs)]))
    return "\n\n".join(found)


def meaning(explanation: Explanation) -> list[tuple[str, list[tuple[str, str]]]]:
    """Sections of the explanation: a title, and pairs of what and how."""
    moved = [(item.title, f"{item.dimension}: {item.words}") for item in explanation.transfers]
    freed = [(str(k), f.words) for k, f in enumerate(explanation.freedoms, 1)]
    sections = [
        ("may be moved across each joint", moved),
        ("freed by what couples the joints", freed),
    ]
    return [(title, pairs) for title, pairs in sections if pairs]
