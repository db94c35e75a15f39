"""The report on a design space as one page of HTML, with the linkage to move and look at.

What is counted is in tables; what moves is drawn from poses computed here.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from math import inf

import numpy as np
from numpy.typing import NDArray

from balance.conditions.collect import conditions_by_order, relative_tolerance
from balance.inertial_parameters.multipole import NOUNS, UNITS, Primitive
from balance.interpretation.explain import ExplainedTransfer, Explanation
from balance.interpretation.freedoms import Freedom
from balance.report.data import report_data
from balance.report.html.render import bullets, facts_list, html_table, render_page
from balance.report.html.scene import scene
from balance.report.text.report import report_facts, report_table
from balance.spaces.design_space_result import DesignSpace
from balance.tolerances import COMPONENT_ZERO_RELATIVE
from kinematics.model.linkage import Notice

__all__ = ["report_page"]

# In the order in which they build on each other.
SCRIPTS = ("shapes", "linkage", "freedoms", "figure", "controls", "choice", "momentum",
           "spectrum", "start")  # fmt: skip


def report_page(space: DesignSpace, explanation: Explanation, change: float = inf) -> str:
    """The report on a design space as the text of one HTML file.

    It shows the linkage in 3D, moved by a slider for each degree of freedom of the motion;
    on it the masses, displacements and rods of any freedom; the singular values by order;
    and all that `report_data` holds, which is also in the element ``report`` as JSON.

    Args:
        space: the design space.
        explanation: result of `balance.explain`.
        change: result of `balance.distance_to_rank_drop`.

    Raises:
        PackageError: Plotly is missing.
    """
    drawing = scene(space) | {
        "titles": [transfer.title for transfer in explanation.transfers],
        "spectra": _spectra(space),
    }
    return render_page(
        "page.html",
        title=space.linkage.name,
        summary=_summary(space),
        report=report_data(space, explanation, change=change),
        data={"scene": drawing},
        scripts=SCRIPTS,
        warnings=_warnings(space.warnings),
        facts=facts_list(report_facts(space, change)),
        orders=_orders(space),
        transfers=_transfers(explanation.transfers),
        freedoms=_freedoms(explanation.freedoms),
    )


def _spectra(space: DesignSpace) -> list[dict[str, object]]:
    """The singular values of all conditions up to each order, relative to the largest."""
    chain, force, last = space.chain, space.balance == "force", space.orders[-1].order
    before = conditions_by_order(
        chain, space.exchanged.rows, force, relative_tolerance(chain), last - 1
    )
    decisions = [*(conditions.decide() for conditions in before), space.decision]
    return [
        {
            "order": order.order,
            "values": [float(f"{value:.4g}") for value in decision.singular_values],
            "kept": decision.kept,
            "dropped": decision.dropped,
        }
        for order, decision in zip(space.orders, decisions, strict=True)
    ]


def _summary(space: DesignSpace) -> str:
    """The page in one sentence."""
    algebra = "planar" if space.planar else "spatial"
    momentum = "momentum" if space.balance == "dynamic" else "linear momentum"
    when = f"with {', '.join(space.motion.relations)}" if space.motion else "in every motion"
    return (
        f"Mass distributions for which the total {momentum} vanishes {when}: "
        f"{space.nullity} dimensions of {space.rank + space.nullity} {algebra} parameters."
    )


def _orders(space: DesignSpace) -> str:
    """Rank and nullity by order."""
    head, *rows = report_table(space)
    return html_table([name.capitalize() for name in head], rows, range(len(head)))


def _warnings(notices: Sequence[Notice]) -> str:
    """The warnings, if there are any."""
    if not notices:
        return ""
    lines = [f"<li><code>{escape(n.code)}</code> {escape(n.message)}</li>" for n in notices]
    return f'<section class="warnings"><h2>Warnings</h2><ul>{"".join(lines)}</ul></section>'


def _transfers(transfers: Sequence[ExplainedTransfer]) -> str:
    """What may be moved across each joint, in words."""
    rows = [
        (escape(item.title), str(item.dimension), bullets(f.words for f in item.freedoms))
        for item in transfers
    ]
    if not rows:
        return "<p>None: no inertia can be moved across a joint.</p>"
    return html_table(["Joint", "Dim.", "What may be moved across it"], rows, [1])


def _freedoms(freedoms: Sequence[Freedom]) -> str:
    """The freedoms that only loop closure opens, with their primitives."""
    rows = [
        (str(number), escape(freedom.words), bullets(map(_primitive, freedom.primitives)))
        for number, freedom in enumerate(freedoms, 1)
    ]
    if not rows:
        return "<p>None: nothing is free beyond the transfers.</p>"
    return html_table(["No.", "In words", "Primitives"], rows, [0])


def _primitive(p: Primitive) -> str:
    """A primitive in words: value, unit, kind, body, and where."""
    where = "" if p.point is None else f" at {_vector(p.point)} m"
    along = "" if p.direction is None else f" along {_vector(p.direction)}"
    return f"{_signed(p.value)} {UNITS[p.kind]} {NOUNS[p.kind]} on {p.body}{where}{along}"


def _signed(value: float) -> str:
    """A number with its sign."""
    return f"{value:+.4g}".replace("-", "−")


def _vector(vector: NDArray[np.float64]) -> str:
    """Three numbers, without those that are round-off."""
    kept = np.where(
        np.abs(vector) > COMPONENT_ZERO_RELATIVE * np.abs(vector).max(), vector, 0.0
    )
    return "(" + ", ".join(f"{x:.4g}" for x in kept).replace("-", "−") + ")"
