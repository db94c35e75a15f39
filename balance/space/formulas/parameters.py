"""Names of the inertial parameters in formulas, in the order of the columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from balance.space.formulas.notations import plain_name


class Parameter(NamedTuple):
    """A parameter of a body.

    Attributes:
        name: in formulas, such as ``s_crank``.
        kind: ``"s"`` (complex first moment), ``"sx"``, ``"sy"``, ``"J"`` or ``"m"``.
        body: index of the body.
    """

    name: str
    kind: str
    body: int

    @property
    def is_mass(self) -> bool:
        """Whether it is a mass, which no designer wants to solve for."""
        return self.kind == "m"


def name_parameters(bodies: Sequence[str], force: bool) -> tuple[Parameter, ...]:
    """Name the parameters of bodies: first moments first, masses last."""
    words: list[str] = []
    for body in bodies:
        word, number = plain_name(body), 2
        while word in words:
            word, number = f"{plain_name(body)}_{number}", number + 1
        words.append(word)
    kinds = ("s", "m") if force else ("sx", "sy", "J", "m")
    return tuple(
        Parameter(f"{kind}_{body}", kind, b) for kind in kinds for b, body in enumerate(words)
    )
