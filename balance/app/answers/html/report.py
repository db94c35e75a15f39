"""HTML page of a design space: tables, and the moving linkage in 3D.

The page computes the poses of the linkage from its screws and loops.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from operator import itemgetter

import numpy as np
from numpy.typing import NDArray

from balance.app.answers.data import Report, report_data
from balance.app.answers.html.render import (
    bullets,
    facts_list,
    html_table,
    linkage_stage,
    render_page,
    rows_table,
)
from balance.app.answers.html.robot_shapes import robot_shapes
from balance.app.answers.html.scene import scene
from balance.app.answers.text.report import (
    decoupling_facts,
    gap_text,
    inertia_sections,
    report_facts,
    report_table,
)
from balance.space.conditions.collect import conditions_by_order, relative_tolerance
from balance.space.inertial_parameters.multipole import NOUNS, UNITS, Primitive
from balance.space.interpretation.explain import ExplainedTransfer, explain
from balance.space.interpretation.freedoms import Freedom
from balance.space.spaces.design_space import DesignSpace
from balance.support.linkage_names import linkage_title
from balance.support.tolerances import COMPONENT_ZERO_RELATIVE
from kinematics.model.linkage import Notice
from kinematics.model.spatial.inertia import pseudo_inertia
from kinematics.wording import number_text

SCRIPTS = ("drawing", "freedoms", "choice", "momentum", "spectrum", "start")


def space_page(space: DesignSpace) -> str:
    """Render a design space as one HTML file."""
    return report_page(Report(space))


def report_page(report: Report, meshes: bool = True) -> str:
    """Render a design space as one HTML file.

    The page shows the linkage in 3D, with a slider for each degree of freedom of the motion;
    the masses, displacements and rods of each freedom; and the singular values by order. The
    element ``report`` contains `report_data` as JSON.

    Args:
        report: the space and what was computed about it; `balance.explain` is, if it was not.
        meshes: whether to draw the shapes of the file, if it has any.

    Returns:
        The text of the file.
    """
    space = report.space
    explanation = report.explanation or explain(space)
    commands = [("next", report.following), ("or", report.alternative)]
    report = report._replace(explanation=explanation, exact=None)
    shapes = robot_shapes(space.linkage) if meshes else ()
    drawing = scene(space.linkage, space.motion, space.idle, shapes) | {
        "titles": [transfer.title for transfer in explanation.transfers],
        "spectra": _spectra(space),
    }
    if report.pure_inertia is not None:
        drawing["pure"] = pseudo_inertia(report.pure_inertia.spatial_parameters).tolist()
    return render_page(
        "page.html",
        stage=linkage_stage("The linkage"),
        title=linkage_title(space.linkage),
        summary=space.can_balance.sentence,
        report=report_data(report),
        data={"scene": drawing},
        scripts=SCRIPTS,
        warnings=_warning_section(space.warnings),
        facts=facts_list(
            [*filter(itemgetter(1), commands), *report_facts(space, report.change)]
        ),
        orders=rows_table(report_table(space), range(3)),
        transfers=_transfer_table(explanation.transfers),
        freedoms=_freedom_table(explanation.freedoms),
        decoupled=_decoupling_section(report),
        inertias=_inertia_section(report),
    )


def _spectra(space: DesignSpace) -> list[dict[str, object]]:
    """Compute the relative singular values of the conditions up to each order."""
    chain, force, last = space.chain, space.balance == "force", space.orders[-1].order
    earlier = conditions_by_order(
        chain, space.chain_transfers.rows, force, relative_tolerance(chain), last - 1
    )
    decisions = [*(conditions.decide() for conditions in earlier), space.decision]
    return [
        {
            "order": order.order,
            "values": [
                float(number_text(value)) for value in decision.singular_values.tolist()
            ],
            "kept": decision.kept,
            "dropped": decision.dropped,
            "gap": gap_text(decision.kept, decision.dropped),
        }
        for order, decision in zip(space.orders, decisions, strict=True)
    ]


def _decoupling_section(report: Report) -> str:
    """Render the facts on decoupling; empty without them."""
    if report.decoupling is None:
        return ""
    return (
        "<section>\n<h2>Decoupled from a moving base</h2>\n"
        '<p class="note">Whether the masses are balanced and the inertia of the linkage on its '
        "base is constant, so that a base that moves feels a rigid body.</p>\n"
        f"{facts_list(decoupling_facts(report.decoupling))}\n</section>"
    )


def _inertia_section(report: Report) -> str:
    """Render pure inertias and their conditions; empty without them."""
    if report.pure_inertia is None:
        return ""
    tables = (
        f"<h3>{escape(title[0].upper() + title[1:])}</h3>\n{facts_list(pairs)}"
        for title, pairs in inertia_sections(report.pure_inertia)
    )
    return (
        "<section>\n<h2>Pure inertias</h2>\n"
        '<p class="note">Point masses moved across revolute joints until the bodies have '
        "moments of inertia alone. Every momentum is then a couple, g ω, without a line: "
        f"choose the pure inertias under Lines of momentum.</p>\n{''.join(tables)}\n</section>"
    )


def _warning_section(notices: Sequence[Notice]) -> str:
    """Render the warnings; empty without any."""
    if not notices:
        return ""
    lines = [f"<li><code>{escape(n.code)}</code> {escape(n.message)}</li>" for n in notices]
    return f'<section class="warnings"><h2>Warnings</h2><ul>{"".join(lines)}</ul></section>'


def _transfer_table(transfers: Sequence[ExplainedTransfer]) -> str:
    """Render the table of inertia transfers across each joint."""
    rows = [
        (escape(item.title), str(item.dimension), bullets(f.words for f in item.freedoms))
        for item in transfers
    ]
    if not rows:
        return "<p>None: no inertia can be moved across a joint.</p>"
    return html_table(["Joint", "Dim.", "What may be moved across it"], rows, [1])


def _freedom_table(freedoms: Sequence[Freedom]) -> str:
    """Render the table of freedoms that loop closure adds, with their primitives."""
    rows = [
        (str(number), escape(freedom.words), bullets(map(_primitive_text, freedom.primitives)))
        for number, freedom in enumerate(freedoms, 1)
    ]
    if not rows:
        return "<p>None: nothing is free beyond the transfers.</p>"
    return html_table(["No.", "In words", "Primitives"], rows, [0])


def _primitive_text(p: Primitive) -> str:
    """Describe a primitive: value, unit, kind, body, position and direction."""
    where = "" if p.point is None else f" at {_vector(p.point)} m"
    along = "" if p.direction is None else f" along {_vector(p.direction)}"
    return f"{_signed(p.value)} {UNITS[p.kind]} {NOUNS[p.kind]} on {p.body}{where}{along}"


def _signed(value: float) -> str:
    """Format a number with its sign."""
    return number_text(value, "+.4g").replace("-", "−")


def _vector(vector: NDArray[np.float64]) -> str:
    """Format three numbers, with round-off as zero."""
    kept = np.where(
        np.abs(vector) > COMPONENT_ZERO_RELATIVE * np.abs(vector).max(), vector, 0.0
    )
    return "(" + ", ".join(map(number_text, kept.tolist())).replace("-", "−") + ")"
