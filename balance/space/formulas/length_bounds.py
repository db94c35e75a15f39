"""Bounds on lengths for which balanced masses can be built, as data and in writing."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple

from balance.space.formulas.notations import (
    LATEX,
    MATHML,
    PYTHON,
    TEXT,
    Notation,
    Variable,
    Writer,
)
from balance.space.formulas.polynomials import Polynomial
from kinematics.wording import number_text


class RatioEnd(NamedTuple):
    """An end of an interval of ratios: a root of a polynomial.

    Attributes:
        value: of the ratio.
        polynomial: in the two lengths; it vanishes there.
        only: whether this is its only root among the ratios that are possible.
    """

    value: float
    polynomial: Polynomial
    only: bool


class RatioInterval(NamedTuple):
    """An open interval of ratios for which masses can be built.

    Attributes:
        low, high: its ends; None for no end.
        ratio: a rational one in it.
        signs: of the polynomials of low and high there; 0 without an end.
    """

    low: RatioEnd | None
    high: RatioEnd | None
    ratio: Fraction
    signs: tuple[int, int]

    def contains(self, ratio: float) -> bool:
        """Tell whether a ratio is in it."""
        above = self.low is None or ratio > self.low.value
        return above and (self.high is None or ratio < self.high.value)


@dataclass(frozen=True)
class LengthBounds:
    """Lengths for which balanced masses can be built.

    Attributes:
        verdict: ``"all"``, ``"some"`` or ``"none"`` of the lengths; ``"unknown"``: not derived.
        lengths: the two that the ratio is of, with its numerator first; none without a ratio.
        intervals: of the ratio, where masses can be built.
        undecided: ratios at which it was not decided, single points between intervals.
        reason: why it is unknown, or none.
    """

    verdict: str
    lengths: tuple[str, ...] = ()
    intervals: tuple[RatioInterval, ...] = ()
    undecided: tuple[RatioEnd, ...] = ()
    reason: str = ""

    def __repr__(self) -> str:
        """One line."""
        return f"LengthBounds: {self.text()}"

    def contains(self, ratio: float) -> bool:
        """Tell whether masses can be built for a ratio of the two lengths."""
        return any(interval.contains(ratio) for interval in self.intervals)

    def inequalities(self, notation: Notation = TEXT) -> list[list[str]]:
        """Write the intervals, each as one or two inequalities."""
        writer = Writer(notation, [Variable(name, "real") for name in self.lengths])
        return [self._sides(each, writer) for each in self.intervals]

    def _sides(self, interval: RatioInterval, writer: Writer) -> list[str]:
        """Write the inequalities of one interval."""
        notation = writer.notation
        more = "<mo>&gt;</mo>" if notation is MATHML else " > "
        out = []
        for end, sign, step in zip(interval[:2], interval.signs, (1, -1), strict=True):
            if end is None:
                continue
            if end.only:
                sides = [_write(part, writer) for part in _two_sides(end.polynomial, sign)]
            else:
                ratio = notation.fraction.format(*map(notation.symbol, self.lengths))
                number = notation.number.format(number_text(end.value, ".6g"))
                sides = [ratio, number][::step]
            out.append(more.join(sides))
        return out

    def text(self) -> str:
        """Say in one line for which lengths masses can be built."""
        if self.verdict == "unknown":
            return f"not derived: {self.reason}"
        if self.verdict == "none":
            return f"for no lengths: {self.reason}" if self.reason else "for no lengths"
        if self.verdict == "all":
            return "for all lengths"
        words = " or ".join(", ".join(each) for each in self.inequalities())
        if self.undecided:
            values = ", ".join(number_text(each.value, ".6g") for each in self.undecided)
            words += f"; not decided at {'/'.join(self.lengths)} = {values}"
        return words

    def latex(self) -> str:
        """Write the inequalities as LaTeX; empty unless they hold for some lengths."""
        return r" \text{ or } ".join(r", \; ".join(each) for each in self.inequalities(LATEX))

    def mathml(self) -> str:
        """Write the inequalities as MathML, with words between; as `latex`."""
        rows = [
            ", ".join(f"<math>{side}</math>" for side in each)
            for each in self.inequalities(MATHML)
        ]
        return " or ".join(rows)

    def python(self) -> str:
        """Write a Python expression that holds where masses can be built; empty if unknown."""
        if self.verdict in ("all", "none"):
            return str(self.verdict == "all")
        rows = [" and ".join(each) for each in self.inequalities(PYTHON)]
        return " or ".join(rows)

    def to_dict(self) -> dict[str, object]:
        """Convert to ``bounds`` of ``balance formulas --json``."""
        return {
            "verdict": self.verdict,
            "text": self.text(),
            "latex": self.latex(),
            "python": self.python(),
            "reason": self.reason,
            "ratio": list(self.lengths),
            "intervals": [
                {
                    "text": ", ".join(sides),
                    "low": None if each.low is None else each.low.value,
                    "high": None if each.high is None else each.high.value,
                }
                for each, sides in zip(self.intervals, self.inequalities(), strict=True)
            ],
            "undecided": [each.value for each in self.undecided],
        }


def _two_sides(polynomial: Polynomial, sign: int) -> tuple[Polynomial, Polynomial]:
    """Split an inequality: the terms that are positive, and the others on the other side."""
    terms = {e: sign * c for e, c in polynomial.items()}
    return (
        {e: c for e, c in terms.items() if c > 0},
        {e: -c for e, c in terms.items() if c < 0},
    )


def _write(polynomial: Polynomial, writer: Writer) -> str:
    return writer.polynomial(polynomial) if polynomial else writer.notation.number.format(0)
