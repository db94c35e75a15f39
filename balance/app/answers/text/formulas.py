"""Text of the formulas of ``balance formulas``.

`Formulas.to_dict` has the same content as data for ``--json``.
"""

from __future__ import annotations

from math import degrees

from balance.app.answers.answer import AnswerBody, AnswerTable, Facts
from balance.space.formulas.formula_data import Formulas
from balance.space.formulas.length_bounds import LengthBounds
from balance.space.formulas.planar_parts import Dimension, PlanarParts
from kinematics.wording import count_noun, number_text

# What bounds say.
BUILT = (
    "can be built: for these lengths alone bodies with m > 0 and m J > sx^2 + sy^2 fulfil the",
    "conditions; proved in exact numbers, for lengths without relations but those above",
)


def formulas_body(formulas: Formulas, notation: str) -> AnswerBody:
    """Build what is printed on formulas in a notation."""
    if notation == "latex":
        return [formulas.latex(), *_latex_of_bounds(formulas.bounds)]
    if notation == "python":
        return [formulas.python().rstrip("\n"), *_python_of_bounds(formulas.bounds)]
    if notation == "sympy":
        holds = "" if formulas.bounds is None else formulas.bounds.python()
        return [*map(str, formulas.sympy()), *[holds] * bool(holds)]
    return [
        Facts(formulas_facts(formulas)),
        "",
        AnswerTable(dimension_rows(formulas)),
        "",
        *formulas.text().splitlines(),
        "",
        *legend(formulas),
    ]


def _latex_of_bounds(bounds: LengthBounds | None) -> list[str]:
    """Write bounds as a comment, and as an equation if there are inequalities."""
    if bounds is None:
        return []
    equation = bounds.latex()
    return [f"% can be built: {bounds.text()}", *[f"\\[ {equation} \\]"] * bool(equation)]


def _python_of_bounds(bounds: LengthBounds | None) -> list[str]:
    """Write bounds as a function."""
    if bounds is None or bounds.verdict == "unknown":
        return []
    return [
        "",
        "",
        f"def can_be_built({', '.join(bounds.lengths)}):",
        '    """Whether bodies that fulfil the conditions can be built."""',
        f"    return {bounds.python()}",
    ]


def formulas_facts(formulas: Formulas) -> list[tuple[str, str]]:
    """List the linkage, the conditions, the relations that are used, and the checks."""
    return [
        ("linkage", f"{formulas.name}, {formulas.balance} balance"),
        *(("motion", each) for each in (formulas.motion.relations if formulas.motion else ())),
        ("conditions", _conditions(formulas)),
        *(("relation", words) for words in formulas.relations),
        ("checked", _checks(formulas)),
        *([] if formulas.bounds is None else [("can be built", formulas.bounds.text())]),
    ]


def _conditions(formulas: Formulas) -> str:
    kind = "complex" if formulas.complex else "real"
    missing = f", {formulas.unknown} more not known" if formulas.unknown else ""
    return f"{len(formulas.conditions)} {kind}{missing}, rank {formulas.rank}"


def _checks(formulas: Formulas) -> str:
    """Say which checks passed."""
    if formulas.unknown:
        return "no, for conditions are missing"
    if not formulas.confirmed:
        return "no: the checks failed"
    return (
        f"in {count_noun(formulas.geometries, 'other geometry')}, at finite poses; in the "
        "dimensions of the file, against its design space"
    )


def dimension_rows(formulas: Formulas) -> list[tuple[str, ...]]:
    """Build the table of dimensions, its head first."""
    rows: list[tuple[str, ...]] = [("dimension", "link", "joints", "in the file", "equals")]
    for i, (_, kind, part, joints, value) in enumerate(formulas.parts.dimensions):
        number = complex_text(value, kind == "point")
        if kind == "angle":
            number = f"{number_text(degrees(value.real), '.6g')} deg"
        link = formulas.parts.parts[part].name
        names = ", ".join(dimension_names(formulas.parts.dimensions[i]))
        rows.append((names, link, joints, number, _equals(formulas, i)))
    return rows


def dimension_names(dimension: Dimension) -> list[str]:
    """List the names of a dimension in formulas: an angle has those of cosine and sine."""
    if dimension.kind == "angle":
        return [f"c_{dimension.name}", f"s_{dimension.name}"]
    return [dimension.name]


def _equals(formulas: Formulas, i: int) -> str:
    """Write what a dimension follows from."""
    text = formulas.free.equals(i)
    if text and formulas.parts.dimensions[i].kind == "angle":
        return f"c_{text}, s_{text}"
    return text


def complex_text(value: complex, both: bool) -> str:
    """Write a number with six digits, and its imaginary part if it has one."""
    size = abs(value)
    text = number_text(value.real, ".6g", size)
    if not both:
        return text
    sign = "-" if value.imag < 0 else "+"
    return f"{text} {sign} {number_text(abs(value.imag), '.6g', size)} i"


def legend(formulas: Formulas) -> list[str]:
    """Explain the symbols, in lines."""
    if not formulas.planar:
        return _spatial_legend(formulas)
    force = formulas.balance == "force"
    point = "z = x + i y a point" if force else "(x, y) a point"
    moments = (
        "s = m (x + i y) first moment"
        if force
        else "sx, sy first moments, J second moment about the origin"
    )
    lines = [
        f"l, x, y, h lengths, {point}; m mass, {moments}; in the frame of the link:",
        "origin at its first joint, x-axis through its second one, or along its slide",
    ]
    if isinstance(formulas.parts, PlanarParts) and formulas.parts.unturned:
        names = ", ".join(formulas.parts.parts[k].name for k in sorted(formulas.parts.unturned))
        lines.append(f"does not turn, and has the directions of the ground: {names}")
    if formulas.bounds is not None and formulas.bounds.verdict != "unknown":
        lines += BUILT
    return lines


def _spatial_legend(formulas: Formulas) -> list[str]:
    """Explain the symbols of a linkage in space."""
    seconds = ", J inertia tensor about the origin" * (formulas.balance == "dynamic")
    return [
        "l common normal of two axes, h offset along an axis, c and s cosine and sine of the",
        f"angle of two axes; m mass; sx, sy, sz first moments{seconds}; in the frame",
        "of the link: z-axis along its first joint, x-axis along the common normal to its",
        "second one, origin at its foot",
    ]
