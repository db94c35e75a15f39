"""What a design space says, as text; nothing here prints.

The same as data is `DesignSpace.to_dict`, the contract of ``balance report --json``.
"""

from __future__ import annotations

import json
from importlib.resources import files

from balance.space import DesignSpace

__all__ = ["facts", "schema", "table", "text"]


def schema() -> dict[str, object]:
    """The JSON schema (draft 2020-12) of `DesignSpace.to_dict`."""
    text = files("balance").joinpath("report.schema.json").read_text(encoding="utf-8")
    return dict(json.loads(text))


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
    if space.motion:
        lines.append(("motion", ", ".join(space.motion.relations)))
    if space.idle:
        lines.append(("idle joints", ", ".join(space.idle)))
    given = space.as_given
    verdict = "balanced" if given.balanced else "not balanced"
    return [
        *lines,
        ("conditions", f"{space.rank}, {_state(space)}"),
        ("design space", f"{space.nullity} of {count} dimensions"),
        ("gap", f"{space.kept:.1e} kept, {space.dropped:.1e} dropped (singular values)"),
        ("as given", f"{verdict} (residual {given.residual:.1e})"),
    ]


def _state(space: DesignSpace) -> str:
    """Whether the conditions are all there are."""
    if space.settled:
        return f"complete at order {space.kmax}"
    return f"up to order {space.orders[-1].order}: not complete"


def table(space: DesignSpace) -> list[tuple[str, str, str]]:
    """Rows of the table by order, its head first."""
    head = ("order", "rank", "nullity")
    return [head, *((str(o.order), str(o.rank), str(o.nullity)) for o in space.orders)]


def text(space: DesignSpace) -> str:
    """The report as plain text."""
    lines = [f"{label:<13} {value}" for label, value in facts(space)]
    rows = ["".join(f"{cell:>8}" for cell in row) for row in table(space)]
    return "\n".join([*lines, "", *rows])
