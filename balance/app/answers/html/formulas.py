"""HTML page of formulas: the linkage with its dimensions, the conditions, and their symbols."""

from __future__ import annotations

from html import escape

from balance.app.answers.html.dimension_drawing import dimension_drawing
from balance.app.answers.html.render import (
    facts_list,
    html_table,
    render_page,
    with_capital,
)
from balance.app.answers.text.formulas import (
    complex_text,
    dimension_rows,
    formulas_facts,
    legend,
)
from balance.space.formulas.file_values import FileValues, file_values
from balance.space.formulas.formula_data import Formulas
from balance.space.formulas.notations import MATHML
from kinematics.wording import count_noun

PLANE = "An arrow at one end points to a point of a link, seen from the origin of its frame."
SPACE = "It is seen obliquely from above: lengths of lines are not to scale."
# Unit of a parameter, and what it is.
PARAMETERS = {
    "m": ("kg", "mass"),
    "s": ("kg m", "first moment"),
    "sx": ("kg m", "first moment, x"),
    "sy": ("kg m", "first moment, y"),
    "sz": ("kg m", "first moment, z"),
    "J": ("kg m²", "second moment"),
    **{
        f"J{a}{b}": ("kg m²", f"inertia, {a}{b}")
        for a, b in ("xx", "yy", "zz", "xy", "xz", "yz")
    },
}


def formulas_page(formulas: Formulas) -> str:
    """Render formulas as one HTML file.

    Returns:
        The text of the file; the element ``report`` contains `Formulas.to_dict`.
    """
    values = file_values(formulas)
    return render_page(
        "formulas.html",
        title=formulas.name,
        summary=_summary(formulas),
        report=formulas.to_dict(),
        data={},
        scripts=("copy",),
        drawing=dimension_drawing(formulas),
        caption=PLANE if formulas.planar else SPACE,
        conditions=_conditions(formulas, values),
        facts=facts_list(formulas_facts(formulas)[1:]),
        bounds=_bounds(formulas),
        legend=escape(" ".join(legend(formulas))),
        dimensions=_dimensions(formulas),
        parameters=_inertial_parameters(formulas, values),
        latex=escape(formulas.latex()) if formulas.conditions else "",
        python=escape(formulas.python()),
    )


def _summary(formulas: Formulas) -> str:
    """Say what the page answers, in one sentence."""
    kind = "complex condition" if formulas.complex else "condition"
    known = count_noun(len(formulas.conditions), kind)
    what = f"{formulas.balance} balance in the dimensions of this linkage"
    if formulas.unknown:
        return f"{known} of {what}; {formulas.unknown} more are not known."
    if not formulas.confirmed:
        return f"{known} of {what}; a check of them failed: do not rely on them."
    return (
        f"{known} of {what}, which hold in {count_noun(formulas.geometries, 'other geometry')} "
        "and in that of the file."
    )


def _symbol(name: str) -> str:
    """Write a symbol in MathML."""
    return f"<math>{MATHML.symbol(name)}</math>"


def _conditions(formulas: Formulas, values: FileValues) -> str:
    """Render the conditions, each with what its left side is in the file."""
    rows = []
    for condition, math, total in zip(
        formulas.conditions, formulas.mathml(), values.sums, strict=True
    ):
        unit = PARAMETERS[condition.solved.kind][0]
        text = complex_text(total, formulas.complex)
        rows.append([math, escape(f"{text} {unit}")])
    if not rows:
        return "<p>None is known.</p>"
    return html_table(["condition", "left side in the file"], rows, [1])


def _bounds(formulas: Formulas) -> str:
    """Render the lengths for which masses can be built."""
    bounds = formulas.bounds
    if bounds is None or bounds.verdict == "unknown":
        return ""
    words = escape(bounds.text())
    if bounds.verdict == "some":
        words = f"where {words if bounds.undecided else bounds.mathml()}"
    return f"<p>Balanced masses can be built {words}.</p>"


def _dimensions(formulas: Formulas) -> str:
    """Render the table of dimensions."""
    head, *rows = dimension_rows(formulas)
    cells = []
    for names, link, joints, value, equals in rows:
        unit = "" if value.endswith(" deg") else " m"
        terms = [escape(link), escape(joints), escape(f"{value}{unit}"), escape(equals)]
        symbols = ", ".join(_symbol(name) for name in names.split(", "))
        cells.append([symbols, f"<code>{escape(names)}</code>", *terms])
    return html_table(["Symbol", "Name", *map(with_capital, head[1:])], cells, [4])


def _inertial_parameters(formulas: Formulas, values: FileValues) -> str:
    """Render the table of the parameters of the bodies."""
    cells = []
    for parameter, value in zip(formulas.parameters, values.parameters, strict=True):
        unit, meaning = PARAMETERS[parameter.kind]
        body = formulas.linkage.bodies[parameter.body].name
        text = complex_text(value, parameter.kind == "s")
        name = f"<code>{escape(parameter.name)}</code>"
        words = [escape(meaning), escape(body), escape(f"{text} {unit}")]
        cells.append([_symbol(parameter.name), name, *words])
    return html_table(["Symbol", "Name", "Meaning", "Body", "In the file"], cells, [4])
