"""Balanced pantographs: an RR chain with a parallelogram that carries counter-masses.

With e1 and e2 the directions of the two links of the chain, from the fixed pivot G, masses and
centres are

    m1 at s1 e1           m2 at l1 e1 + s2 e2         m3 at (l1 - s3) e1 - l2 e2
    m4 at -l3 e1 - s4 e2  m5 at l1 e1 + s5 e2         m6 at -l3 e1 - l2 e2

m1 is on link 1; m2 and m5, the payload, on link 2, which carries the tool; link 3 is parallel
to link 1, and link 4, with m6 at its end, to link 2. The force balances if both coefficients of
the momentum vanish:

    s1 m1 + l1 (m2 + m5) = l3 (m4 + m6) + (s3 - l1) m3
    s2 m2 + s5 m5 = s4 m4 + l2 (m3 + m6)

Then the momentum is ``(J1 + C cos δ) θ̇1 + (J2 + C cos δ) θ̇2`` about any point, δ = θ1 - θ2:

    J1 = I1 + I3 + m1 s1² + (m2 + m5) l1² + m3 (l1 - s3)² + (m4 + m6) l3²
    J2 = I2 + I4 + I5 + m2 s2² + m5 s5² + m4 s4² + (m3 + m6) l2²
    C  = (l1 + l3) (s4 m4 + l2 m6) + l2 s3 m3

s2 and s5 may be complex, in units of e2: centres of mass beside the line of link 2.

Source: G. Becht, MSc thesis, TU Delft, 2020, chapter 3, Eqs. 3 to 8 and 19; m6 and the places
of the masses are recovered from Eqs. 3, 4 and 19, of which Eq. 19 prints ``l1 - s3``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinematics.errors import SynthesisError, UsageError
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, repr_lines

# Largest mass, length and moment of inertia, and inverse of the least mass and length; SI.
LARGEST = 1e12


@dataclass(frozen=True)
class PantographMasses:
    """Lengths and masses of a pantograph, without the length l1 of its first link; SI units.

    Attributes:
        l2: from the moving pivot to link 3, along -e2.
        l3: from the fixed pivot to link 4, along -e1.
        m1: mass of link 1.
        m2: mass of link 2, without the payload.
        m3: mass of link 3.
        m4: mass of link 4.
        m5: mass of the payload at s5 on link 2.
        m6: mass at the joint of links 3 and 4.
        s3: centre of link 3 from its joint with link 2, along -e1.
        s4: centre of link 4 from its joint with link 1, along -e2.
        s5: centre of the payload from the moving pivot; None: it is at the point of the tool.
        inertia_1: I1 + I3, of links 1 and 3 about their centres.
        inertia_2: I2 + I4 + I5, of links 2 and 4 and the payload about their centres.
    """

    l2: float
    l3: float
    m1: float
    m2: float
    m3: float
    m4: float
    m5: float
    m6: float
    s3: float
    s4: float
    s5: float | None
    inertia_1: float
    inertia_2: float

    def __repr__(self) -> str:
        """Two lines: the mass of all, and the lengths."""
        mass = self.m1 + self.m2 + self.m3 + self.m4 + self.m5 + self.m6
        return repr_lines(
            f"PantographMasses: {number_text(mass)} kg",
            f"l2 {number_text(self.l2)} m, l3 {number_text(self.l3)} m, inertias of "
            f"links {number_text(self.inertia_1)} "
            f"and {number_text(self.inertia_2)} kg m²",
        )

    def check(self) -> None:
        """Check the numbers.

        Raises:
            UsageError: one is not finite, a mass or length is not positive, another is
                negative that must not be, or sizes are above 1e12 or below 1e-12.
        """
        for field in fields(self):
            value = getattr(self, field.name)
            if value is not None and not math.isfinite(value):
                raise UsageError(f"masses: {field.name} = {value!r} is not a finite number")
            if value is not None and abs(value) > LARGEST:
                raise UsageError(f"masses: {field.name} = {value:g} is more than {LARGEST:g}")
        for name in ("l2", "l3", "m1", "m2", "m3", "m4"):
            if not getattr(self, name) > 0.0:
                raise UsageError(f"masses: {name} = {getattr(self, name):g} must be positive")
            if getattr(self, name) < 1.0 / LARGEST:
                value = getattr(self, name)
                raise UsageError(f"masses: {name} = {value:g} is less than {1.0 / LARGEST:g}")
        for name in ("m5", "m6", "inertia_1", "inertia_2"):
            if not getattr(self, name) >= 0.0:
                raise UsageError(f"masses: {name} = {getattr(self, name):g} is negative")


class ReducedInertias(NamedTuple):
    """What the masses of a pantograph amount to; numbers or arrays.

    Attributes:
        first: J1, kg m².
        second: J2, kg m².
        coupling: C, kg m².
    """

    first: Array
    second: Array
    coupling: Array


def first_centre(masses: PantographMasses, l1: ArrayLike) -> Array:
    """Compute s1 of force balance, metres, from the first equation of this module.

    Args:
        l1: length of the first link, metres.
    """
    l1 = np.asarray(l1, dtype=np.float64)
    m = masses
    return np.asarray((m.l3 * (m.m4 + m.m6) + (m.s3 - l1) * m.m3 - l1 * (m.m2 + m.m5)) / m.m1)


def second_centre(masses: PantographMasses, s5: ArrayLike) -> NDArray[np.complex128]:
    """Compute s2 of force balance, metres: ``(s4 m4 + l2 (m3 + m6) - s5 m5) / m2``.

    Args:
        s5: centre of the payload, complex in units of e2.
    """
    m = masses
    return np.asarray((m.s4 * m.m4 + m.l2 * (m.m3 + m.m6) - np.asarray(s5) * m.m5) / m.m2)


def reduced_inertias(
    masses: PantographMasses,
    l1: ArrayLike,
    s5: ArrayLike,
    s2: ArrayLike | None = None,
    inertia_1: ArrayLike | None = None,
) -> ReducedInertias:
    """Compute J1, J2 and C of a pantograph; see the head of this module.

    Args:
        l1: length of the first link, metres; any shape.
        s5: centre of the payload, complex in units of e2; the same shape.
        s2: centre of link 2; that of force balance by default. Given otherwise, C is
            ``m2 l1 s2 + m5 l1 s5 - m3 (l1 - s3) l2 + m4 l3 s4 + m6 l3 l2``.
        inertia_1: instead of that of ``masses``.
    """
    m, l1 = masses, np.asarray(l1, dtype=np.float64)
    s5 = np.asarray(s5)
    s2 = second_centre(m, s5) if s2 is None else np.asarray(s2)
    s1 = first_centre(m, l1)
    inertia = m.inertia_1 if inertia_1 is None else np.asarray(inertia_1)
    first = (
        inertia
        + m.m1 * s1**2
        + (m.m2 + m.m5) * l1**2
        + m.m3 * (l1 - m.s3) ** 2
        + (m.m4 + m.m6) * m.l3**2
    )
    second = (
        m.inertia_2
        + m.m2 * np.abs(s2) ** 2
        + m.m5 * np.abs(s5) ** 2
        + m.m4 * m.s4**2
        + (m.m3 + m.m6) * m.l2**2
    )
    coupling = (
        l1 * np.real(m.m2 * s2 + m.m5 * s5)
        - m.m3 * (l1 - m.s3) * m.l2
        + m.l3 * (m.m4 * m.s4 + m.m6 * m.l2)
    )
    return ReducedInertias(np.asarray(first), np.asarray(second), np.asarray(coupling))


def default_masses(l1: float, reach: float) -> PantographMasses:
    """Choose masses in proportion to a chain: links of 1 kg, a payload of 0.1 kg at the tool.

    Args:
        l1: length of the first link, metres.
        reach: from the moving pivot to the point of the tool, metres.
    """
    half = 0.5 * l1
    inertia = l1 * l1 / 6.0 + half * half / 6.0
    return PantographMasses(
        l2=half,
        l3=half,
        m1=1.0,
        m2=1.0,
        m3=1.0,
        m4=1.0,
        m5=0.1,
        m6=0.0,
        s3=0.0,
        s4=0.0,
        s5=None,
        inertia_1=inertia,
        inertia_2=inertia + 0.1 * reach * reach / 12.0,
    )


def decouple(masses: PantographMasses, l1: float) -> PantographMasses:
    """Move the centre of link 3 so that C vanishes.

    ``s3 = -(l1 + l3) (s4 m4 + l2 m6) / (l2 m3)``.

    Args:
        masses: of the pantograph; with s4 = 0 and m6 = 0 the source's special case s3 = 0.
        l1: length of the first link, metres.
    """
    m = masses
    s3 = -(l1 + m.l3) * (m.s4 * m.m4 + m.l2 * m.m6) / (m.l2 * m.m3)
    return replace(masses, s3=s3 + 0.0)


def match_ratio(
    masses: PantographMasses, l1: float, s5: complex, ratio: float
) -> PantographMasses:
    """Raise I1 + I3 or I2 + I4 + I5 until ``k = -J2/J1`` is the ratio of the turns.

    Args:
        masses: of the pantograph, with C = 0.
        l1: length of the first link, metres.
        s5: centre of the payload, in units of e2.

    Raises:
        SynthesisError: k is positive: links that turn the same way cannot balance.
    """
    if not ratio < 0.0:
        raise SynthesisError(
            f"k = {ratio:g} turns both links the same way, and no masses balance that",
            "give a negative ratio",
        )
    inertias = reduced_inertias(masses, l1, s5)
    J1, J2 = float(inertias.first), float(inertias.second)
    if J2 > -ratio * J1:
        return replace(masses, inertia_1=masses.inertia_1 + J2 / -ratio - J1)
    return replace(masses, inertia_2=masses.inertia_2 - ratio * J1 - J2)
