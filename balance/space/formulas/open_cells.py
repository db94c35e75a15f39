"""Whether strict polynomial inequalities have a solution, and where that may change.

Polynomials are projected along one variable after the other: leading coefficients,
discriminants and resultants of two, in irreducible factors. Between their roots the number and
the order of the roots above do not change. Strict inequalities hold on an open set, which
meets a cell of full dimension, so that one rational point of each of those cells decides
(A. Strzeboński, Solving systems of strict polynomial inequalities, Journal of Symbolic
Computation 29 (2000)). All numbers are exact. SymPy is imported where this module is used.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

from sympy import Expr, Poly, Rational, Symbol, ceiling, factor_list, floor, resultant

MAX_PROJECTED = 60
"""Most polynomials that are projected along one variable."""
# Width of the first isolating intervals of roots.
FIRST_WIDTH = Rational(1, 16)


class TooManyCellsError(Exception):
    """The projections are too many."""


class IsolatedRoot(NamedTuple):
    """A real root.

    Attributes:
        polynomial: irreducible, in one variable.
        low, high: rational numbers; it is the only root between them, or equal to both.
    """

    polynomial: Poly
    low: Rational
    high: Rational

    def __float__(self) -> float:
        """Return its value."""
        low, high = self.finer(Rational(1, 10**18))[1:]
        return float((low + high) / 2)

    def finer(self, width: Rational) -> IsolatedRoot:
        """Shorten its interval."""
        if self.low == self.high:
            return self
        low, high = self.polynomial.refine_root(self.low, self.high, eps=width)
        return self._replace(low=low, high=high)

    def sign_of(self, polynomial: Poly) -> int:
        """Compute the sign of another polynomial there."""
        if polynomial.is_zero or not polynomial.gcd(self.polynomial).is_ground:
            return 0
        here = self
        while here.low < here.high and polynomial.count_roots(here.low, here.high):
            here = here.finer((here.high - here.low) / 16)
        return 1 if polynomial.eval((here.low + here.high) / 2) > 0 else -1


class OpenCells:
    """Inequalities ``f > 0`` and their projections.

    Attributes:
        inequalities: the polynomials f.
        variables: the last one is projected along first.
        levels: for each variable the irreducible polynomials in it and in those before it.
    """

    def __init__(self, inequalities: Sequence[Expr], variables: Sequence[Symbol]) -> None:
        """Project them.

        Raises:
            TooManyCellsError: there are too many polynomials.
        """
        self.inequalities, self.variables = list(inequalities), list(variables)
        self.levels: list[list[Poly]] = [[] for _ in variables]
        for f in self.inequalities:
            self._learn(f)
        for k in range(len(self.variables) - 1, 0, -1):
            here, x = self.levels[k], self.variables[k]
            if len(here) > MAX_PROJECTED:
                raise TooManyCellsError
            for f in here:
                self._learn(f.as_poly(x).LC())
                if f.degree(x) > 1:
                    self._learn(f.as_poly(x).discriminant())
            for f, g in combinations(here, 2):
                self._learn(resultant(f.as_expr(), g.as_expr(), x))

    def _learn(self, expression: Expr) -> None:
        """Keep the irreducible factors of an expression, each at its last variable."""
        for factor, _ in factor_list(expression, *self.variables)[1]:
            polynomial = Poly(factor, *self.variables)
            last = max(k for k, x in enumerate(self.variables) if polynomial.degree(x) > 0)
            if polynomial not in self.levels[last]:
                self.levels[last].append(polynomial)

    def roots(self) -> list[IsolatedRoot]:
        """List the roots at which the first variable may gain or lose solutions."""
        polynomials = [f.as_poly(self.variables[0]) for f in self.levels[0]]
        return isolated_roots(polynomials)

    def solution(self, values: Sequence[Rational]) -> list[Rational] | None:
        """Find values of the other variables with which all inequalities hold.

        Args:
            values: of the first variables; no root of a projection to them.
        """
        k = len(values)
        at = dict(zip(self.variables, values, strict=False))
        rest = [f.subs(at) for f in self.inequalities]
        if any(f.is_number and not f > 0 for f in rest):
            return None
        if k == len(self.variables):
            return list(values)
        x = self.variables[k]
        lines = [Poly(f.as_expr().subs(at), x) for f in self.levels[k]]
        for point in points_between(isolated_roots([f for f in lines if f.degree() > 0])):
            if (solution := self.solution([*values, point])) is not None:
                return solution
        return None


def isolated_roots(polynomials: Sequence[Poly]) -> list[IsolatedRoot]:
    """Isolate the real roots of polynomials in one variable, in order."""
    factors: list[Poly] = []
    for polynomial in polynomials:
        for factor, _ in polynomial.factor_list()[1]:
            if factor not in factors:
                factors.append(factor)
    roots = [
        IsolatedRoot(factor, low, high)
        for factor in factors
        for low, high in factor.intervals(sqf=True)
    ]
    width = FIRST_WIDTH
    while True:
        roots.sort(key=lambda root: root.low + root.high)
        if all(a.high < b.low for a, b in zip(roots, roots[1:], strict=False)):
            return roots
        roots, width = [root.finer(width) for root in roots], width / 16


def points_between(roots: Sequence[IsolatedRoot]) -> list[Rational]:
    """Choose a rational point before, between and after roots, each."""
    if not roots:
        return [Rational(1)]
    inner = [(a.high + b.low) / 2 for a, b in zip(roots, roots[1:], strict=False)]
    return [Rational(floor(roots[0].low) - 1), *inner, Rational(ceiling(roots[-1].high) + 1)]
