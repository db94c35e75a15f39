"""Formulas as data and in writing: conditions, each solved for a parameter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from balance.space.formulas.notations import (
    LATEX,
    MATHML,
    PYTHON,
    TEXT,
    Notation,
    Signed,
    Writer,
)
from balance.space.formulas.parameters import Parameter
from balance.space.formulas.polynomials import Quotient
from balance.support.result_files import WithPage
from balance.support.tolerances import FORMULA_AGREES
from kinematics.errors import PackageError
from kinematics.wording import repr_lines

if TYPE_CHECKING:
    from balance.space.formulas.length_bounds import LengthBounds
    from balance.space.formulas.planar_parts import Dimension, PlanarParts
    from balance.space.formulas.relations import FreeDimensions
    from balance.space.formulas.spatial_dimensions import SpatialDimensions
    from balance.space.formulas.spatial_parts import SpatialParts
    from kinematics.model.linkage import Linkage
    from kinematics.model.motion import Motion
    from kinematics.numerics.array_types import Array


class FormulaTerm(NamedTuple):
    """A parameter with its coefficient.

    Attributes:
        parameter: the parameter.
        coefficient: in the variables of the formulas.
        turns: power of i that multiplies it, 0 to 3.
    """

    parameter: Parameter
    coefficient: Quotient
    turns: int = 0


class Condition(NamedTuple):
    """A condition: the sum of a solved parameter and of terms is zero."""

    solved: Parameter
    terms: tuple[FormulaTerm, ...]


@dataclass(frozen=True, eq=False)
class Formulas(WithPage):
    """Conditions of balance of a linkage in its dimensions.

    Attributes:
        source: file of the linkage.
        linkage: the linkage itself.
        motion: restriction of the inputs; None if all are free.
        balance: ``"force"`` or ``"dynamic"``.
        parts: rigid parts, joints and dimensions.
        relations: relations between dimensions that are used, in words.
        free: dimensions that are left free by them, and the variables of the formulas.
        parameters: in the order of columns.
        conditions: each solved for a parameter.
        unknown: number of conditions that the time did not suffice for.
        rank: number of real conditions on the linkage.
        residual: violation by masses of the design space of the file, relative; infinite if
            the formulas span fewer conditions.
        geometries: number of fresh geometries at which the formulas hold.
        bounds: lengths for which balanced masses can be built; None if not asked for.
    """

    page_maker = "formulas:formulas_page"

    source: str
    linkage: Linkage
    motion: Motion | None
    balance: str
    parts: PlanarParts | SpatialParts
    relations: tuple[str, ...]
    free: FreeDimensions | SpatialDimensions
    parameters: tuple[Parameter, ...]
    conditions: tuple[Condition, ...]
    unknown: int
    rank: int
    residual: float
    geometries: int
    bounds: LengthBounds | None = None

    def __repr__(self) -> str:
        """Up to six lines: the linkage and its conditions."""
        head = f"Formulas of {self.name}, {self.balance} balance"
        return repr_lines(head, *self.text().splitlines())

    def __str__(self) -> str:
        """Give the conditions as text, a line each."""
        return self.text()

    @property
    def name(self) -> str:
        """Name of the linkage."""
        return self.linkage.name

    @property
    def planar(self) -> bool:
        """Whether the linkage moves in a plane."""
        return self.linkage.chain.planar

    @property
    def complex(self) -> bool:
        """Whether the conditions are complex: those of forces in a plane."""
        return self.planar and self.balance == "force"

    @property
    def axes(self) -> Array:
        """Axes of the plane, and its normal, in rows (3, 3)."""
        return self.linkage.chain.frame.R

    @property
    def confirmed(self) -> bool:
        """Whether all conditions are known and both checks passed."""
        agrees = self.residual <= FORMULA_AGREES
        return not self.unknown and agrees and self.geometries > 0

    def text(self) -> str:
        """Write the conditions as plain text, a line each."""
        return "\n".join(f"{line} = 0" for line in self._sums(TEXT))

    def latex(self) -> str:
        """Write the conditions as an ``align*`` environment of amsmath."""
        lines = " \\\\\n".join(f"  {line} &= 0" for line in self._sums(LATEX))
        return f"\\begin{{align*}}\n{lines}\n\\end{{align*}}"

    def mathml(self) -> list[str]:
        """Write the conditions as MathML, which browsers show: a ``math`` element each."""
        end = "<mo>=</mo><mn>0</mn>"
        return [f'<math display="block">{line}{end}</math>' for line in self._sums(MATHML)]

    def python(self) -> str:
        """Write a Python function that returns the matrix of the conditions.

        Its arguments are the free dimensions, complex where they are points; its rows have
        product zero with the parameters, in the order of its docstring. It needs NumPy.
        """
        writer = Writer(PYTHON, self.free.variables)
        names = ", ".join(self.free.argument_names())
        rows = []
        for condition in self.conditions:
            entries = {condition.solved: "1"}
            for term in condition.terms:
                negative, text = writer.quotient(term.coefficient, term.turns)
                entries[term.parameter] = "-" * negative + (text or "1")
            rows.append(", ".join(entries.get(each, "0") for each in self.parameters))
        body = "\n".join(f"        [{row}]," for row in rows)
        columns = ", ".join(each.name for each in self.parameters)
        return (
            "from numpy import array, conj\n\n\n"
            f"def conditions({names}):\n"
            f'    """Rows that have product zero with ({columns})."""\n'
            f"    return array([\n{body}\n    ])\n"
        )

    def sympy(self) -> list[object]:
        """Build the left sides of the conditions as SymPy expressions.

        Dimensions and real parameters are real symbols, points and s complex ones.

        Raises:
            PackageError: SymPy is not installed.
        """
        require_sympy("an expression")
        import sympy

        symbols = {
            variable.name: sympy.Symbol(variable.name, real=variable.kind in REAL or None)
            for variable in self.free.variables
        }
        for each in self.parameters:
            symbols[each.name] = sympy.Symbol(each.name, real=each.kind != "s" or None)
        words = {"conj": sympy.conjugate, "i": sympy.I, **symbols}
        return [sympy.parse_expr(line, words) for line in self._sums(SYMPY)]

    def _sums(self, notation: Notation) -> list[str]:
        writer = Writer(notation, self.free.variables)
        return [_sum(condition, writer) for condition in self.conditions]

    def to_dict(self) -> dict[str, object]:
        """Convert to the output of ``balance formulas --json``."""
        texts, latex = self._sums(TEXT), self._sums(LATEX)
        return {
            "schema": "balance.formulas/1",
            "source": self.source,
            "name": self.name,
            "balance": self.balance,
            "motion": [] if self.motion is None else list(self.motion.relations),
            "joints": [
                {
                    "letter": joint.letter,
                    "name": joint.name,
                    "links": [self.parts.parts[part].name for part in joint.parts],
                }
                for joint in self.parts.joints
            ],
            "dimensions": [
                _dimension(each, self.parts.parts[each.part].name, self.free.equals(i))
                for i, each in enumerate(self.parts.dimensions)
            ],
            "relations": list(self.relations),
            "parameters": [each.name for each in self.parameters],
            "conditions": [
                {"solved": condition.solved.name, "text": f"{text} = 0", "latex": f"{tex} = 0"}
                for condition, text, tex in zip(self.conditions, texts, latex, strict=True)
            ],
            "unknown": self.unknown,
            "python": self.python(),
            "rank": self.rank,
            "confirmed": self.confirmed,
            "geometries": self.geometries,
            "agrees_with_space": bool(self.residual <= FORMULA_AGREES),
            "bounds": None if self.bounds is None else self.bounds.to_dict(),
        }


REAL = ("real", "imaginary")
SYMPY = PYTHON._replace(unit="i")


def require_sympy(purpose: str) -> None:
    """Check that SymPy can be imported.

    Raises:
        PackageError: it is not installed.
    """
    if find_spec("sympy") is None:
        command = "python -m pip install 'screwbalance[symbols]'"
        raise PackageError(purpose, "SymPy", command)


def _sum(condition: Condition, writer: Writer) -> str:
    """Write the left side of a condition."""
    terms = [Signed(False, writer.notation.symbol(condition.solved.name))]
    for term in condition.terms:
        terms.append(writer.term(term.coefficient, term.turns, term.parameter.name))
    return writer.notation.sum(terms)


def _dimension(dimension: Dimension, link: str, equals: str) -> Mapping[str, object]:
    """Describe a dimension as data."""
    value = dimension.value
    point = dimension.kind == "point"
    return {
        "name": dimension.name,
        "kind": dimension.kind,
        "link": link,
        "joints": dimension.joints,
        "value": [value.real, value.imag] if point else [value.real],
        "equals": equals or None,
    }
