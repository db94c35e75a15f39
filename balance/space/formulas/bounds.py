"""Derivation of the ratios of lengths for which balanced masses can be built.

A body of a planar linkage can be built if ``m > 0`` and ``m J > sx² + sy²`` (see
`balance.masses.designs.pseudo_inertia_cone`; the frame does not matter). If no condition mixes
sx and sy, then sy = 0 is no loss. A mass, or a second moment, that is in no condition can be
as large as it takes, and leaves ``J > 0``, or ``m > 0``; first moments without a limit are
eliminated. So are masses that are in no condition on moments about another joint of the body.
What remains are strict inequalities in a few parameters, of which a positive one
is 1, and in one ratio of lengths; `balance.space.formulas.open_cells` decides them exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING

from sympy import (
    QQ,
    Expr,
    Integer,
    Matrix,
    Poly,
    Rational,
    Symbol,
    cancel,
    degree,
    fraction,
    linear_eq_to_matrix,
    prod,
    sign,
    together,
)
from sympy.polys.matrices import DomainMatrix

from balance.space.formulas.length_bounds import LengthBounds, RatioEnd, RatioInterval
from balance.space.formulas.open_cells import (
    IsolatedRoot,
    OpenCells,
    TooManyCellsError,
    points_between,
)
from balance.space.formulas.parameters import Parameter
from balance.space.formulas.planar_parts import PlanarParts
from balance.space.formulas.polynomials import Polynomial
from balance.space.formulas.relations import FreeDimensions

if TYPE_CHECKING:
    from balance.space.formulas.formula_data import Condition, Formulas
    from balance.space.formulas.notations import Variable

MAX_FREE = 2
"""Most parameters that are free beside the ratio of lengths, and beside the one that is 1."""
# Distances from a root of points whose masses may hold at the root as well.
NEAR_ROOT = (Rational(1, 100), Rational(1, 10**6))


# Kinds of parameters that are positive.
POSITIVE = ("m", "J")


class NoBoundsError(Exception):
    """Bounds are not derived; the message says why."""


def length_bounds(formulas: Formulas) -> LengthBounds:
    """Find the ratios of lengths for which masses that fulfil formulas can be built.

    Returns:
        Bounds that are proved for general lengths under the relations of the formulas, or the
        reason why there are none.
    """
    try:
        if not formulas.planar:
            raise NoBoundsError("they are of planar linkages")
        if not formulas.confirmed:
            raise NoBoundsError("conditions are missing, or failed a check")
        for condition, line in zip(
            formulas.conditions, formulas.text().splitlines(), strict=True
        ):
            if _of_positives(condition, formulas.free.variables):
                return LengthBounds("none", reason=f"all terms are positive in {line}")
        if not formulas.complex:
            return decide_ratios(RatioInequalities(formulas))
        if any(condition.solved.is_mass for condition in formulas.conditions):
            raise NoBoundsError("a condition is on masses alone")
        # All first moments are possible, for second moments can be as large as it takes.
        return LengthBounds("all")
    except NoBoundsError as error:
        return LengthBounds("unknown", reason=str(error))
    except TooManyCellsError:
        return LengthBounds("unknown", reason="its inequalities have too many projections")


def _of_positives(condition: Condition, variables: Sequence[Variable]) -> bool:
    """Tell whether all terms of a condition are positive for all lengths and bodies."""
    if condition.solved.kind not in POSITIVE:
        return False
    return all(
        term.parameter.kind in POSITIVE
        and term.turns == 0
        and term.coefficient.content > 0
        and all(n % 2 == 0 for _, n in term.coefficient.factors)
        and all(
            n == 0 or (each.kind == "real" and (n % 2 == 0 or is_positive(each.name)))
            for each, n in zip(variables, term.coefficient.monomial, strict=True)
        )
        for term in condition.terms
    )


def is_positive(length: str) -> bool:
    """Tell whether a dimension is positive by definition, no coordinate and no offset."""
    return length.startswith("l_")


def _reaches(formulas: Formulas) -> Iterator[tuple[int, dict[str, Fraction]]]:
    """Yield the joints on the x-axis of each body: their places, as combinations of lengths."""
    parts, free = formulas.parts, formulas.free
    assert isinstance(parts, PlanarParts) and isinstance(free, FreeDimensions)
    for body, part in enumerate(parts.body_parts):
        for index in parts.parts[part].points.values():
            if index is not None and parts.dimensions[index].kind == "length":
                terms = free.terms[index]
                yield body, {parts.dimensions[i].name: c for i, c in terms.items()}


class RatioInequalities:
    """Inequalities ``f > 0`` of the parameters that formulas leave free.

    Attributes:
        lengths: the two that the ratio is of; none without a ratio.
        ratio: its symbol.
        positive: whether the ratio is positive by the definition of the lengths.
        sides: the left sides f.
        free: the symbols of the parameters in them.
    """

    def __init__(self, formulas: Formulas) -> None:
        """Eliminate what has no limit.

        Raises:
            NoBoundsError: there are too many lengths or parameters.
        """
        symbols = {Symbol(each.name, real=True): each for each in formulas.parameters}
        matrix = linear_eq_to_matrix(formulas.sympy(), list(symbols))[0]
        matrix = self._in_ratio(matrix, formulas.free.argument_names())
        self.rows = [
            {each: x for each, x in zip(symbols.values(), row, strict=True) if x}
            for row in matrix.tolist()
        ]
        self._drop_moments_across()
        for body, reach in _reaches(formulas):
            self._move_frame(formulas.parameters, body, self._at_ratio(reach))
        self._drop_unlimited()
        self._write(formulas.parameters)

    def _in_ratio(self, matrix: Matrix, names: Sequence[str]) -> Matrix:
        """Set one length to 1; at most one other is the ratio."""
        by_name = {str(symbol): symbol for symbol in matrix.free_symbols}
        known = [name for name in names if name in by_name]
        if len(known) > 2:
            raise NoBoundsError(f"its conditions depend on {len(known) - 1} ratios of lengths")
        units = [name for name in reversed(known) if is_positive(name)]
        if known and not units:
            raise NoBoundsError("no length in its conditions is positive by definition")
        others = [name for name in known if name != units[0]]
        self.ratio = Symbol("ratio", real=True)
        self.lengths = (others[0], units[0]) if others else ()
        self.positive = len(units) > 1
        self.values = {n: self.ratio if n in others else Integer(1) for n in known}
        return matrix.subs({by_name[n]: x for n, x in self.values.items()})

    def _at_ratio(self, reach: Mapping[str, Fraction]) -> Expr | None:
        """Write a combination of lengths in the ratio; None if others are in it."""
        if not set(reach) <= set(self.values):
            return None
        terms = (
            Rational(c.numerator, c.denominator) * self.values[n] for n, c in reach.items()
        )
        return sum(terms, Integer(0))

    def _move_frame(
        self, parameters: Sequence[Parameter], body: int, reach: Expr | None
    ) -> None:
        """Take the moments of a body about another point, if its mass is in no condition then.

        Its cone is the same for ``sx = sx' + x m`` and ``J = J' + 2 x sx' + x² m``.
        """
        if reach is None:
            return
        m, sx, J = (
            next(e for e in parameters if e.body == body and e.kind == kind)
            for kind in ("m", "sx", "J")
        )
        masses = (
            row.get(m, 0) + reach * row.get(sx, 0) + reach**2 * row.get(J, 0)
            for row in self.rows
        )
        if any(cancel(mass) for mass in masses):
            return
        for row in self.rows:
            row.pop(m, None)
            if moment := cancel(row.pop(sx, Integer(0)) + 2 * reach * row.get(J, 0)):
                row[sx] = moment

    def _drop_moments_across(self) -> None:
        """Set sy to zero."""
        kinds = [{each.kind == "sy" for each in row} for row in self.rows]
        if {True, False} in kinds:
            raise NoBoundsError("its conditions mix moments along and across the links")
        self.rows = [row for row, kind in zip(self.rows, kinds, strict=True) if kind != {True}]

    def _drop_unlimited(self) -> None:
        """Eliminate first moments of bodies whose mass or second moment has no limit."""
        before = -1
        while before != len(self.rows):
            before, present = len(self.rows), self._present()
            bounded = {each.body for each in present if each.kind == "m"}
            bounded &= {each.body for each in present if each.kind == "J"}
            unlimited = [e for e in present if e.kind == "sx" and e.body not in bounded]
            solved = self._solved(unlimited + [e for e in present if e not in unlimited])
            self.rows = [row for pivot, row in solved.items() if pivot not in unlimited]

    def _present(self) -> list[Parameter]:
        """List the parameters that are in conditions."""
        return sorted({each for row in self.rows for each in row})

    def _solved(self, order: Sequence[Parameter]) -> dict[Parameter, dict[Parameter, Expr]]:
        """Solve the conditions for the first parameters that allow it: rows with a 1 there."""
        if not self.rows:
            return {}
        entries = [[row.get(each, Integer(0)) for each in order] for row in self.rows]
        field = QQ.frac_field(self.ratio)
        rows, pivots = DomainMatrix.from_Matrix(Matrix(entries)).convert_to(field).rref()
        return {
            order[pivot]: {each: x for each, x in zip(order, row, strict=True) if x}
            for pivot, row in zip(pivots, rows.to_Matrix().tolist(), strict=False)
        }

    def _write(self, parameters: Sequence[Parameter]) -> None:
        """Write the inequalities; a parameter that is positive is 1.

        Each is multiplied by the square of its denominator.
        """
        present = self._present()
        for kinds in (("J", "sx", "m"), ("sx", "J", "m")):
            solved = self._solved(sorted(present, key=lambda each: kinds.index(each.kind)))
            free = [each for each in present if each not in solved]
            unit = next((each for each in free if each.kind != "sx"), None)
            if unit is not None:
                break
        if len(free) - 1 > MAX_FREE:
            raise NoBoundsError(
                f"{len(free) - 1} parameters are free beside the unit of mass: more than "
                f"{MAX_FREE}"
            )
        self.free = [Symbol(each.name, real=True) for each in free if each is not unit]
        values: dict[Parameter, Expr] = {each: Symbol(each.name, real=True) for each in free}
        if unit is not None:
            values[unit] = Integer(1)
        for each, row in solved.items():
            values[each] = -sum(
                (x * values[e] for e, x in row.items() if e != each), Integer(0)
            )
        sides = [self.ratio] if self.positive else []
        by_place = {(each.kind, each.body): values[each] for each in present}
        for body in {each.body for each in present}:
            m, J, sx = (by_place.get((kind, body)) for kind in ("m", "J", "sx"))
            sides += [each for each in (m, J) if each is not None]
            if m is not None and J is not None and sx is not None:
                sides.append(m * J - sx**2)
        self.sides = [prod(fraction(together(side))) for side in sides]


def decide_ratios(problem: RatioInequalities) -> LengthBounds:
    """Decide at a ratio between each two roots, and at the roots between those that hold."""
    order = sorted(problem.free, key=lambda x: -max(degree(f, x) for f in problem.sides))
    if not problem.lengths:
        solution = OpenCells(problem.sides, order).solution([])
        return LengthBounds("none" if solution is None else "all")
    cells = OpenCells(problem.sides, [problem.ratio, *order])
    roots = cells.roots()
    points = points_between(roots)
    holds = [cells.solution([point]) is not None for point in points]
    intervals: list[RatioInterval] = []
    undecided: list[RatioEnd] = []
    low: IsolatedRoot | None = None
    after = [*holds[1:], False]
    for point, root, here, beyond in zip(points, [*roots, None], holds, after, strict=True):
        if here:
            if root is not None and beyond:
                if _holds_at(cells, root):
                    continue
                if root.low < root.high:
                    undecided.append(_end(problem, root, roots))
            intervals.append(_interval(problem, (low, root), roots, point))
        low = root
    every = len(intervals) == 1 and intervals[0].low is None and intervals[0].high is None
    verdict = "all" if every else "some" if intervals else "none"
    return LengthBounds(verdict, problem.lengths, tuple(intervals), tuple(undecided))


def _holds_at(cells: OpenCells, root: IsolatedRoot) -> bool:
    """Tell whether the inequalities have a solution at a root; False if none is seen."""
    ratio, *free = cells.variables
    if root.low == root.high:
        at = [f.subs(ratio, root.low) for f in cells.inequalities]
        return OpenCells(at, free).solution([]) is not None
    for width in NEAR_ROOT:
        near = root.finer(width)
        for point in (near.low, near.high):
            solution = cells.solution([point])
            if solution is None:
                continue
            values = dict(zip(free, solution[1:], strict=True))
            at = [Poly(f.subs(values), ratio) for f in cells.inequalities]
            if all(root.sign_of(f) > 0 for f in at):
                return True
    return False


def _interval(
    problem: RatioInequalities,
    ends: tuple[IsolatedRoot | None, IsolatedRoot | None],
    roots: Sequence[IsolatedRoot],
    point: Rational,
) -> RatioInterval:
    """Describe an interval between two roots; zero is no end of a positive ratio."""
    named: list[RatioEnd | None] = []
    signs: list[int] = []
    for root in ends:
        if root is None or (problem.positive and root.low == root.high == 0):
            named.append(None)
            signs.append(0)
        else:
            named.append(_end(problem, root, roots))
            signs.append(int(sign(root.polynomial.eval(point))))
    ratio = Fraction(int(point.p), int(point.q))
    return RatioInterval(named[0], named[1], ratio, (signs[0], signs[1]))


def _end(
    problem: RatioInequalities, root: IsolatedRoot, roots: Sequence[IsolatedRoot]
) -> RatioEnd:
    """Describe a root by a polynomial in both lengths."""
    same = [each for each in roots if each.polynomial == root.polynomial]
    possible = [each for each in same if not problem.positive or each.high > 0]
    top = root.polynomial.degree()
    terms: Polynomial = {}
    for (n,), c in root.polynomial.terms():
        terms[int(n), int(top - n)] = Fraction(int(c.p), int(c.q))
    return RatioEnd(float(root), terms, only=len(possible) == 1)
