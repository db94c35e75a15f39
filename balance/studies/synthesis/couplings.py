"""What couples the two links of a balanced pantograph: a belt, or a slot for one of its pins.

With turns β of link 1 and φ of link 2 from the first position, a pin is at
``P = G + a e^(iβ) + b e^(iφ)``. Without momentum β and φ are functions of the angle δ between
the links, with ``φ' = β' - 1``. A pin that runs in a slot along P(δ) leaves the pantograph one
degree of freedom, the motion without momentum.

- Curvature of the slot: ``Im(P̄' P'') / |P'|³``.
- Pressure angle: that between the normal of the slot and the velocity of the pin while the
  input stands still, ``i b e^(iφ)`` if the shoulder is the input and the slot turns link 2, and
  ``i (a e^(iβ) + b e^(iφ))`` if the elbow is and the slot turns both links. The slot jams where
  it is a right angle: in the first case where link 1 reverses, in both where a and b are
  parallel.

Source: the slider of G. Becht, MSc thesis, TU Delft, 2020, chapter 3; the pressure angle is
that of cam mechanisms (R. L. Norton, Design of Machinery, chapter 8).
"""

from __future__ import annotations

import cmath
import math
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.studies.synthesis.balanced_pantograph import (
    ELBOW,
    SHOULDER,
    BalancedPantograph,
    elbow_ratio,
)
from balance.studies.synthesis.momentum_integral import link_turn, link_turn_rate
from balance.support.csv_text import csv_table
from balance.support.dxf import polylines_dxf
from kinematics.errors import PackageError
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least
from kinematics.wording import number_text

Complex = NDArray[np.complex128]

SAMPLES = 241
# Curvature, times the length of the slot, below which the slot is straight.
STRAIGHT = 1e-9
# Pressure angles beyond which cams are advised against (Norton), radians.
STEEP = math.radians(30.0)


class BeltCoupling(NamedTuple):
    """A belt that couples both links in a constant ratio.

    Attributes:
        radii: radius of the pulley on the base, about the fixed pivot, over that of the pulley
            on link 2, about the moving pivot.
    """

    radii: float

    @property
    def words(self) -> str:
        """The belt in words."""
        return (
            "a belt, not crossed, from a pulley fixed to the base at the fixed pivot to one "
            f"fixed to link 2 at the moving pivot, radii {number_text(self.radii, '.6g')} : 1; "
            "in the file the elbow mimics the shoulder"
        )

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {"kind": "belt", "radii": self.radii, "words": self.words}


class SlotCoupling(NamedTuple):
    """A slot in the base, along which a pin of the pantograph runs.

    Attributes:
        pin: where the pin is: ``"tool"``, ``"joint3"`` (links 2 and 3) or ``"joint34"`` (links
            3 and 4).
        driven: the input of the mechanism, ``"shoulder"`` or ``"elbow"``.
        points: middle of the slot (N,), metres, inertial frame, complex.
        curvature: 1/m (N,); positive where the slot turns to the left.
        pressure_angle: radians (N,), from 0 to π/2.
    """

    pin: str
    driven: str
    points: Complex
    curvature: Array
    pressure_angle: Array

    @property
    def length(self) -> float:
        """Length of the slot, metres."""
        return float(np.abs(np.diff(self.points)).sum())

    @property
    def least_radius(self) -> float | None:
        """Least radius of curvature, metres; None for a straight slot."""
        most = float(np.abs(self.curvature).max())
        return 1.0 / most if most * self.length > STRAIGHT else None

    @property
    def largest_pressure_angle(self) -> float:
        """Largest pressure angle, radians."""
        return float(self.pressure_angle.max())

    @property
    def words(self) -> str:
        """The slot in words."""
        radius = self.least_radius
        bend = "straight" if radius is None else f"least radius {number_text(radius)} m"
        angle = number_text(math.degrees(self.largest_pressure_angle), ".1f")
        steep = self.largest_pressure_angle > STEEP
        return (
            f"a slot in the base for a pin at {self.pin}, {number_text(self.length)} m long, "
            f"{bend}; with the {self.driven} as input, pressure angle up to {angle}°"
            + (": above the 30° that cams should keep" if steep else "")
        )

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            "kind": "slot",
            "pin": self.pin,
            "input": self.driven,
            "length": self.length,
            "least_radius": self.least_radius,
            "largest_pressure_angle": self.largest_pressure_angle,
            "words": self.words,
        }


Coupling = BeltCoupling | SlotCoupling


def belt_coupling(ratio: float) -> BeltCoupling:
    """Compute the belt that couples the links in the ratio k: radii in ``1 - 1/k``."""
    return BeltCoupling(-elbow_ratio(ratio))


def slot_coupling(pantograph: BalancedPantograph) -> SlotCoupling:
    """Compute the slot of the pin and the input whose largest pressure angle is least."""
    slots = [
        _slot(pantograph, pin, driven, a, b)
        for driven in (SHOULDER, ELBOW)
        for pin, a, b in _pins(pantograph)
        if b
    ]
    return slots[first_least([slot.largest_pressure_angle for slot in slots], 0.5 * np.pi)]


def _pins(pantograph: BalancedPantograph) -> list[tuple[str, complex, complex]]:
    """List the pins that move with both links: a and b at the first position, metres."""
    chain, m = pantograph.chain, pantograph.masses
    along = chain.moving - chain.fixed
    e1 = cmath.exp(1j * pantograph.first_angle)
    e2 = cmath.exp(1j * pantograph.second_angle)
    return [
        ("tool", along, chain.reach),
        ("joint3", along, -m.l2 * e2),
        ("joint34", -m.l3 * e1, -m.l2 * e2),
    ]


def _slot(
    pantograph: BalancedPantograph, pin: str, driven: str, a: complex, b: complex
) -> SlotCoupling:
    """Compute the slot of a pin at ``G + a e^(iβ) + b e^(iφ)``, with an input."""
    deltas, inertias = pantograph.deltas, pantograph.inertias
    opening = np.linspace(min(deltas), max(deltas), SAMPLES)
    beta = link_turn(opening, inertias) - link_turn(deltas[0], inertias)
    phi = beta - (opening - deltas[0])
    rate, bend = link_turn_rate(opening, inertias)
    first, second = a * np.exp(1j * beta), b * np.exp(1j * phi)
    points = pantograph.chain.fixed + first + second
    slope = 1j * (rate * first + (rate - 1.0) * second)
    curve = bend * 1j * (first + second) - rate**2 * first - (rate - 1.0) ** 2 * second
    speed = np.abs(slope)
    # A pin that stands still has no slot: a right angle refuses it.
    moves = speed > STRAIGHT * (abs(a) + abs(b))
    speed = np.where(moves, speed, 1.0)
    curvature = np.where(moves, np.imag(slope.conj() * curve) / speed**3, 0.0)
    # The normal is i slope / speed, and the velocity i turned.
    turned = second if driven == SHOULDER else first + second
    reach = np.abs(turned) + STRAIGHT * (abs(a) + abs(b))
    cosine = np.abs(np.real(slope.conj() * turned)) / (speed * reach)
    angle = np.where(moves, np.arccos(np.minimum(cosine, 1.0)), 0.5 * np.pi)
    return SlotCoupling(pin, driven, points, curvature, angle)


def slot_file(slot: SlotCoupling, kind: str) -> bytes:
    """Write the middle of a slot.

    Args:
        kind: ``"csv"`` (metres and degrees, with curvature), ``"svg"`` or ``"dxf"`` (mm, in
            true size).

    Raises:
        PackageError: ezdxf is missing for DXF.
    """
    if kind == "csv":
        names = ["x", "y", "curvature", "pressure angle"]
        x, y = slot.points.real, slot.points.imag
        return csv_table(names, [x, y, slot.curvature, np.degrees(slot.pressure_angle)])
    return _slot_dxf(slot) if kind == "dxf" else _slot_svg(slot)


def _slot_svg(slot: SlotCoupling) -> bytes:
    """Write a slot as a polyline in mm; y points up."""
    x, y = 1e3 * slot.points.real, -1e3 * slot.points.imag
    margin = 0.05 * max(np.ptp(x), np.ptp(y), 1.0)
    left, top = float(x.min() - margin), float(y.min() - margin)
    width, height = (float(np.ptp(side) + 2.0 * margin) for side in (x, y))
    points = " ".join(f"{u:.6g},{v:.6g}" for u, v in zip(x, y, strict=True))
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.6g}mm" '
        f'height="{height:.6g}mm" viewBox="{left:.6g} {top:.6g} {width:.6g} {height:.6g}">\n'
        f'<polyline points="{points}" fill="none" stroke="black" '
        f'stroke-width="{0.05 * margin:.3g}"/>\n</svg>\n'
    ).encode()


def _slot_dxf(slot: SlotCoupling) -> bytes:
    """Write a slot as an open polyline in mm."""
    if find_spec("ezdxf") is None:
        command = "python -m pip install 'screwbalance[parts]'"
        raise PackageError("--slot FILE.dxf", "ezdxf", command)
    points = 1e3 * np.column_stack([slot.points.real, slot.points.imag])
    return polylines_dxf([points], closed=False)
