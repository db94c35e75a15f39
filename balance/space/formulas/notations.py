"""Formulas in the notation of plain text, of LaTeX, of MathML and of Python.

A variable is real, a complex number or its conjugate, or i times a real number; powers of i
are gathered in front.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from fractions import Fraction
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


class Signed(NamedTuple):
    """An expression without its sign.

    Attributes:
        negative: whether it is subtracted.
        text: the rest; empty for 1.
    """

    negative: bool
    text: str


class Notation(NamedTuple):
    """How products, quotients and names are written.

    Attributes:
        times: between factors.
        conjugate: form of a conjugate.
        power: form of a power.
        fraction: form of a quotient.
        unit: the imaginary unit.
        name: form of a name of a letter and a subscript; empty: as it is.
        axis: form of an x or y before the rest of the subscript.
        number: form of a number.
        brackets: form of a sum in brackets.
        plus, minus: the signs.
    """

    times: str
    conjugate: str
    power: str
    fraction: str
    unit: str
    name: str = ""
    axis: str = ""
    number: str = "{}"
    brackets: str = "({})"
    plus: str = "+"
    minus: str = "-"

    @property
    def stacked(self) -> bool:
        """Whether fractions are stacked, and need no brackets."""
        return bool(self.name)

    def symbol(self, name: str) -> str:
        """Write the name of a dimension or a parameter."""
        if not self.name:
            return name
        kind, _, rest = name.partition("_")
        axis = self.axis.format(kind[1:]) if kind[1:] else ""
        subscript = rest.replace("_", r"\_") if self is LATEX else rest
        return self.name.format(kind[0], axis, subscript)

    def sum(self, terms: Iterable[Signed]) -> str:
        """Write a sum of terms."""
        text = ""
        for negative, term in terms:
            sign = self.minus if negative else self.plus
            text += f" {sign} {term}" if text else (sign if negative else "") + term
        return text


TEXT = Notation(" ", "conj({})", "{}^{}", "{}/{}", "i")
LATEX = Notation(
    r" \, ",
    r"\overline{{{}}}",
    "{}^{{{}}}",
    r"\frac{{{}}}{{{}}}",
    r"\mathrm{i}",
    name=r"{}_{{{}\mathrm{{{}}}}}",
    axis=r"{},\,",
)
PYTHON = Notation("*", "conj({})", "{}**{}", "{}/{}", "1j")
MATHML = Notation(
    # The sign between the tags is the product that is not seen.
    '<mo lspace="0" rspace="0.15em">\u2062</mo>',
    '<mover accent="true">{}<mo stretchy="true">\u203e</mo></mover>',
    "<msup>{}<mn>{}</mn></msup>",
    "<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>",
    '<mi mathvariant="normal">i</mi>',
    name="<msub><mi>{}</mi><mrow>{}<mtext>{}</mtext></mrow></msub>",
    axis='<mi>{}</mi><mo rspace="0.15em">,</mo>',
    number="<mn>{}</mn>",
    brackets="<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
    plus="<mo>+</mo>",
    minus="<mo>\u2212</mo>",
)


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
        terms = []
        for exponents in sorted(polynomial, reverse=True):
            coefficient, turns = polynomial[exponents], self._turns(exponents) % 4
            negative = (coefficient < 0) != (turns in (2, 3))
            factors = self._number(abs(coefficient)) + [self.notation.unit] * (turns % 2)
            term = self.notation.times.join(factors + self._factors(exponents))
            terms.append(Signed(negative, term or self.notation.number.format(1)))
        return self.notation.sum(terms)

    def _number(self, size: Fraction | int) -> list[str]:
        """Write a positive factor; none for 1."""
        return [self.notation.number.format(size)] * (size != 1)

    def quotient(self, quotient: Quotient, turns: int = 0) -> Signed:
        """Write a quotient times a power of i."""
        content, monomial = quotient.content, quotient.monomial
        turns = (turns + self._turns(monomial)) % 4
        negative = (content < 0) != (turns in (2, 3))
        over = self._factors(tuple(-n for n in monomial))
        size = abs(content)
        above = self._number(size.numerator) + [self.notation.unit] * (turns % 2)
        above += self._factors(monomial)
        below = self._number(size.denominator) + over
        for polynomial, n in quotient.factors:
            factor = self.notation.brackets.format(self.polynomial(polynomial))
            power = factor if abs(n) == 1 else self.notation.power.format(factor, abs(n))
            (above if n > 0 else below).append(power)
        return Signed(negative, self._fraction(above, below))

    def _fraction(self, above: Sequence[str], below: Sequence[str]) -> str:
        times = self.notation.times
        up = times.join(above)
        if not below:
            return up
        down = times.join(below)
        if self.notation.stacked:
            up, down = self._bare(above, up), self._bare(below, down)
        elif len(below) > 1:
            down = f"({down})"
        return self.notation.fraction.format(up or self.notation.number.format(1), down)

    def _bare(self, factors: Sequence[str], text: str) -> str:
        """Drop the brackets around the one factor of a side of a fraction."""
        start, end = self.notation.brackets.split("{}")
        bracketed = len(factors) == 1 and text.startswith(start) and text.endswith(end)
        return text[len(start) : -len(end)] if bracketed else text

    def term(self, quotient: Quotient, turns: int, parameter: str) -> Signed:
        """Write a coefficient and its parameter."""
        sign, text = self.quotient(quotient, turns)
        symbol = self.notation.symbol(parameter)
        if not text:
            return Signed(sign, symbol)
        if "/" in text and self.notation is TEXT:
            text = f"({text})"
        return Signed(sign, f"{text}{self.notation.times}{symbol}")
