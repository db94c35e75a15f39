"""Names of the inertial parameters in formulas, in the order of the columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


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
    kinds = ("s", "m") if force else ("sx", "sy", "J", "m")
    return tuple(
        Parameter(f"{kind}_{body}", kind, b) for kind in kinds for b, body in enumerate(bodies)
    )
