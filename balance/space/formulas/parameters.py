"""Names of the inertial parameters in formulas, in the order of the columns."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.space.formulas.notations import plain_name


class Parameter(NamedTuple):
    """A parameter of a body.

    Attributes:
        name: in formulas, such as ``s_crank``.
        kind: ``"s"`` (complex first moment), ``"sx"``, ``"sy"``, ``"J"`` or ``"m"``; of
            spatial linkages ``"sx"``, ``"sy"``, ``"sz"``, ``"Jxx"`` … ``"Jyz"`` or ``"m"``.
        body: index of the body.
    """

    name: str
    kind: str
    body: int

    @property
    def is_mass(self) -> bool:
        """Whether it is a mass, which no designer wants to solve for."""
        return self.kind == "m"


PLANAR_KINDS = ("sx", "sy", "J", "m")
SPATIAL_MOMENTS = ("sx", "sy", "sz")
SPATIAL_SECOND_MOMENTS = ("Jxx", "Jyy", "Jzz", "Jxy", "Jxz", "Jyz")


def name_parameters(
    bodies: Sequence[str], force: bool, planar: bool = True
) -> tuple[Parameter, ...]:
    """Name the parameters of bodies: first moments first, masses last."""
    words: list[str] = []
    for body in bodies:
        word, number = plain_name(body), 2
        while word in words:
            word, number = f"{plain_name(body)}_{number}", number + 1
        words.append(word)
    kinds: tuple[str, ...] = ("s", "m") if force else PLANAR_KINDS
    if not planar:
        kinds = (*SPATIAL_MOMENTS, *(() if force else SPATIAL_SECOND_MOMENTS), "m")
    return tuple(
        Parameter(f"{kind}_{body}", kind, b) for kind in kinds for b, body in enumerate(words)
    )


def in_part_frame(kind: str, origin: complex, axis: complex) -> NDArray[np.complexfloating]:
    """Express a parameter in the frame of a part by ``m, mcx, mcy, Ezz`` about the origin."""
    if kind == "m":
        return np.array([1, 0, 0, 0], complex)
    if kind == "J":
        return np.array([abs(origin) ** 2, -2 * origin.real, -2 * origin.imag, 1], complex)
    s = np.array([-origin, 1, 1j, 0]) * axis.conjugate()
    return {"s": s, "sx": s.real + 0j, "sy": s.imag + 0j}[kind]
