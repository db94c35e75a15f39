"""Formulas in the notation of plain text, of LaTeX and of Python.

A variable is real, a complex number or its conjugate, or i times a real number; powers of i
are gathered in front.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

from balance.space.formulas.polynomials import Exponents, Polynomial, Quotient


class Variable(NamedTuple):
    """A variable of the formulas.

    Attributes:
        name: of the dimension.
        kind: ``"real"``, ``"complex"``, ``"conjugate"``, or ``"imaginary"`` for i times it.
    """

    name: str
    kind: str


class Notation(NamedTuple):
    """How products, quotients and names are written.

    Attributes:
        times: between factors.
        conjugate: form of a conjugate.
        power: form of a power.
        fraction: form of a quotient.
        unit: the imaginary unit.
        latex: whether names are set in LaTeX.
    """

    times: str
    conjugate: str
    power: str
    fraction: str
    unit: str
    latex: bool = False

    def symbol(self, name: str) -> str:
        """Write the name of a dimension or a parameter."""
        if not self.latex:
            return name
        kind, _, rest = name.partition("_")
        subscript = rest.replace("_", r"\_")
        letter, axis = (kind[0], kind[1:] + r",\,") if kind[1:] else (kind, "")
        return f"{letter}_{{{axis}\\mathrm{{{subscript}}}}}"


TEXT = Notation(" ", "conj({})", "{}^{}", "{}/{}", "i")
LATEX = Notation(
    r" \, ", r"\overline{{{}}}", "{}^{{{}}}", r"\frac{{{}}}{{{}}}", r"\mathrm{i}", latex=True
)
PYTHON = Notation("*", "conj({})", "{}**{}", "{}/{}", "1j")


class Signed(NamedTuple):
    """An expression without its sign.

    Attributes:
        negative: whether it is subtracted.
        text: the rest; empty for 1.
    """

    negative: bool
    text: str


def plain_name(name: str) -> str:
    """Replace characters that names in formulas and in Python do not have."""
    word = re.sub(r"\W", "_", name)
    return f"_{word}" if not word or word[0].isdigit() else word


class Writer:
    """Writes polynomials and quotients of variables in a notation."""

    def __init__(self, notation: Notation, variables: Sequence[Variable]) -> None:
        """Keep both."""
        self.notation, self.variables = notation, variables
        self._symbols = []
        for variable in variables:
            symbol = notation.symbol(variable.name)
            if variable.kind == "conjugate":
                symbol = notation.conjugate.format(symbol)
            self._symbols.append(symbol)

    def _turns(self, exponents: Exponents) -> int:
        """Count the factors i of a monomial."""
        pairs = zip(self.variables, exponents, strict=True)
        return sum(n for variable, n in pairs if variable.kind == "imaginary")

    def _factors(self, exponents: Exponents) -> list[str]:
        """Write the powers of the variables with positive exponents."""
        return [
            symbol if n == 1 else self.notation.power.format(symbol, n)
            for symbol, n in zip(self._symbols, exponents, strict=True)
            if n > 0
        ]

    def polynomial(self, polynomial: Polynomial) -> str:
        """Write a sum of terms, the leading one first."""
        text = ""
        for exponents in sorted(polynomial, reverse=True):
            coefficient, turns = polynomial[exponents], self._turns(exponents) % 4
            negative = (coefficient < 0) != (turns in (2, 3))
            size = abs(coefficient)
            factors = [str(size)] * (size != 1) + [self.notation.unit] * (turns % 2)
            term = self.notation.times.join(factors + self._factors(exponents)) or "1"
            joint = (" - " if negative else " + ") if text else "-" * negative
            text += joint + term
        return text

    def quotient(self, quotient: Quotient, turns: int = 0) -> Signed:
        """Write a quotient times a power of i."""
        content, monomial = quotient.content, quotient.monomial
        turns = (turns + self._turns(monomial)) % 4
        negative = (content < 0) != (turns in (2, 3))
        over = self._factors(tuple(-n for n in monomial))
        size = abs(content)
        above = [str(size.numerator)] * (size.numerator != 1) + [self.notation.unit] * (
            turns % 2
        )
        above += self._factors(monomial)
        below = [str(size.denominator)] * (size.denominator != 1) + over
        for polynomial, n in quotient.factors:
            factor = f"({self.polynomial(polynomial)})"
            power = factor if abs(n) == 1 else self.notation.power.format(factor, abs(n))
            (above if n > 0 else below).append(power)
        return Signed(negative, self._fraction(above, below))

    def _fraction(self, above: Sequence[str], below: Sequence[str]) -> str:
        times = self.notation.times
        up = times.join(above)
        if not below:
            return up
        down = times.join(below)
        if self.notation.latex:
            up, down = _bare(above, up), _bare(below, down)
        elif len(below) > 1:
            down = f"({down})"
        return self.notation.fraction.format(up or "1", down)

    def term(self, quotient: Quotient, turns: int, parameter: str) -> Signed:
        """Write a coefficient and its parameter."""
        sign, text = self.quotient(quotient, turns)
        symbol = self.notation.symbol(parameter)
        if not text:
            return Signed(sign, symbol)
        if "/" in text and self.notation is TEXT:
            text = f"({text})"
        return Signed(sign, f"{text}{self.notation.times}{symbol}")


def _bare(factors: Sequence[str], text: str) -> str:
    """Drop the brackets around the one factor of a side of a fraction."""
    bracketed = len(factors) == 1 and text.startswith("(") and text.endswith(")")
    return text[1:-1] if bracketed else text
