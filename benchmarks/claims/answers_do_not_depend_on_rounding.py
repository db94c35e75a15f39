"""Claim: what is printed does not depend on rounding.

Each command runs as it is and with the rounding of `tests.support.rounding` perturbed, for 20
seeds: the last bits of what linear algebra, elementary functions and kernels return change at
random, and kernels are compiled in four ways. For each quantity the table has the significant
digits that are printed, those of the number behind that hold in all runs, and how many printed
texts changed.
"""

from __future__ import annotations

import json
import re
from functools import cache
from math import floor, log10
from typing import NamedTuple

from tests.support.gallery_run import Printed, run_commands

# Doubles have as many significant digits.
DIGITS = 16


class _Quantity(NamedTuple):
    """A printed quantity: the commands that print it, where in text and where in JSON."""

    commands: tuple[str, ...]
    text: str
    keys: tuple[str | int, ...]


REPORTS = tuple(
    f"report {model}" for model in ("four_bar_kite", "five_bar", "bennett", "sarrus")
)
VERIFIED = tuple(f"verify {model} --trajectories 1" for model in ("four_bar_kite", "five_bar"))
DESIGN = ("design four_bar_antiparallelogram --minimise mass --bounds coupler=0.5:2",)
ADDED = ("counterweights four_bar_general --balance force --links crank,rocker",)
MOTION = ("motion four_bar_kite --to u1=0.05",)
MODES = ("flex modes --count 2",)
NUMBER = r"([-+.e\d]+)"

QUANTITIES = {
    "rank": _Quantity(REPORTS, rf"conditions +{NUMBER}", ("rank",)),
    "nullity": _Quantity(REPORTS, rf"design space +{NUMBER}", ("nullity",)),
    "gap, kept": _Quantity(REPORTS, r"gap +(.*?) kept", ("margin", "kept")),
    "gap, dropped": _Quantity(REPORTS, r"kept, (.*?) dropped", ("margin", "dropped")),
    "near-special": _Quantity(REPORTS, rf"a change by {NUMBER}", ("margin", "change")),
    "residual of the file": _Quantity(REPORTS, r"\(residual (.*?)\)", ("as_given", "residual")),
    "shaking force, N": _Quantity(
        VERIFIED, rf"shaking force +{NUMBER} N", ("shaking", "force")
    ),
    "shaking moment, N m": _Quantity(
        VERIFIED, rf"shaking moment +{NUMBER} N m", ("shaking", "moment")
    ),
    "agreement": _Quantity(VERIFIED, r"agreement +(.*?), Pin", ("agreement",)),
    "closure": _Quantity(VERIFIED, r"closure +(.*?) radians", ("closure",)),
    "least mass, kg": _Quantity(DESIGN, rf"mass: {NUMBER} kg", ("value",)),
    "mass of a link, kg": _Quantity(DESIGN, rf"\ncrank +{NUMBER}", ("bodies", 0, "mass")),
    "centre of mass, m": _Quantity(
        DESIGN, rf"\ncrank +\S+ +{NUMBER}", ("bodies", 0, "link_com", 0)
    ),
    "moment of inertia, kg m²": _Quantity(
        DESIGN, rf"\ncrank .*  {NUMBER}", ("bodies", 0, "moments", 0)
    ),
    "counterweights, kg": _Quantity(ADDED, rf"added +{NUMBER} kg", ("added_mass",)),
    "joint position, rad": _Quantity(
        MOTION, rf"\nq2 +rad +{NUMBER}", ("poses", 0, "corrected", 1)
    ),
    "frequency of a beam": _Quantity(MODES, rf"\n1 +{NUMBER}", ("modes", 0, "frequency")),
}


@cache
def _runs(count: int) -> list[dict[str, Printed]]:
    """What all commands print, in text and as JSON: plain, then for each seed."""
    texts = dict.fromkeys(
        words for quantity in QUANTITIES.values() for words in quantity.commands
    )
    commands = [*texts, *(f"{words} --json" for words in texts)]
    return [run_commands(commands, seed) for seed in [None, *range(count)]]


class AnswersDoNotDependOnRounding:
    """Digits of one quantity, printed and certain."""

    params = tuple((name,) for name in QUANTITIES)
    claims = (("track_changed", 0.0),)
    slow = True
    runs = 20

    def setup(self, name: str) -> None:
        """Run the commands, once for all quantities."""
        runs, quantity = _runs(self.runs), QUANTITIES[name]
        self._texts, self._numbers = [], []
        for words in quantity.commands:
            printed = [re.search(quantity.text, run[words].out) for run in runs]
            if printed[0] is None:
                continue
            self._texts.append([match and match[1] for match in printed])
            self._numbers.append([_number(run, words, quantity.keys) for run in runs])

    def track_changed(self, name: str) -> int:
        """Count the printed texts that changed."""
        return sum(text != texts[0] for texts in self._texts for text in texts[1:])

    def row(self, name: str) -> dict[str, object]:
        """Compare the digits that are printed with those that hold."""
        digits = [_digits(text) for texts in self._texts for text in texts if text]
        hold = min(_digits_that_hold(*numbers) for numbers in self._numbers)
        printed = "a bound" if max(digits) == 0 else max(digits)
        compared = sum(len(texts) - 1 for texts in self._texts)
        changed = f"{self.track_changed(name)} of {compared}"
        return {"printed": printed, "hold": hold, "changed": changed}


def _number(run: dict[str, Printed], words: str, keys: tuple[str | int, ...]) -> float:
    """The number behind a printed quantity."""
    value = json.loads(run[f"{words} --json"].out)
    for key in keys:
        value = value[key]
    return float(value)


def _digits(text: str) -> int:
    """Count the significant digits of a number that is printed; none if it is a bound."""
    mantissa = text.lower().partition("e")[0].lstrip("+-")
    return (
        len(mantissa.replace(".", "").lstrip("0")) if re.fullmatch(r"[.\d]+", mantissa) else 0
    )


def _digits_that_hold(plain: float, *others: float) -> int:
    """Count the significant digits that a number has in common with others."""
    error = max(abs(other - plain) for other in others)
    if error == 0.0:
        return DIGITS
    return max(0, min(DIGITS, floor(-log10(error / abs(plain))))) if plain else 0
