"""A pantograph on an RR chain, and its URDF file."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from decimal import Decimal
from functools import cached_property

import numpy as np

from balance.studies.synthesis.momentum_integral import link_turn
from balance.studies.synthesis.pantograph import (
    PantographMasses,
    ReducedInertias,
    first_centre,
    reduced_inertias,
    second_centre,
)
from balance.studies.synthesis.rr_chain import RRChain
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_text, number_words
from kinematics.numerics.linalg.ties import first_largest

SHOULDER, ELBOW = "shoulder", "elbow"
"""Names of the input joints: first link on the base, second link on the first."""
# Least sine of the angle between the links at the pose of the file, and how many are compared.
REGULAR, POSES = 0.2, 101
# Significant digits of lengths in the file, so that sums of two are exact doubles too.
DIGITS = 14
# Moments about axes in the plane, of the moment about its normal: of a body with some height.
IN_PLANE = 0.6


@dataclass(frozen=True)
class BalancedPantograph:
    """A pantograph whose masses balance forces, on an RR chain.

    Attributes:
        chain: the RR chain; its tool is on link 2.
        masses: of the links.
        link_angle: from the line between moving pivot and tool to the direction e2 of link 2,
            radians.
    """

    chain: RRChain
    masses: PantographMasses
    link_angle: float = 0.0

    @property
    def first_angle(self) -> float:
        """θ1 at the first position, of e1, radians."""
        return self.chain.first_angle

    @property
    def second_angle(self) -> float:
        """θ2 at the first position, of e2, radians."""
        reach = self.chain.reach
        along = cmath.phase(reach) if reach else self.chain.positions[0].angle
        return along + self.link_angle

    @property
    def opening(self) -> float:
        """Angle ``δ = θ1 - θ2`` between the links at the first position, in ±π, radians."""
        return math.remainder(self.first_angle - self.second_angle, 2.0 * math.pi)

    @property
    def deltas(self) -> tuple[float, ...]:
        """The same at each position, continued from the first."""
        chain = self.chain
        pairs = zip(chain.link_turns, chain.tool_turns, strict=True)
        return tuple(self.opening + link - tool for link, tool in pairs)

    @property
    def payload(self) -> complex:
        """Centre s5 of the payload from the moving pivot, metres, in units of e2."""
        if self.masses.s5 is not None:
            return complex(self.masses.s5)
        return self.chain.reach * cmath.exp(-1j * self.second_angle)

    @property
    def s1(self) -> float:
        """Centre of link 1 from the fixed pivot, metres along e1."""
        return float(first_centre(self.masses, self.chain.length))

    @property
    def s2(self) -> complex:
        """Centre of link 2 from the moving pivot, metres, in units of e2."""
        return complex(second_centre(self.masses, self.payload))

    @property
    def inertias(self) -> ReducedInertias:
        """J1, J2 and C, kg m²."""
        return reduced_inertias(self.masses, self.chain.length, self.payload)

    @cached_property
    def pose(self) -> tuple[float, float]:
        """Turns of both links from the first position to the pose of the file, radians.

        Zero, unless the parallelogram is nearly flat at the first position: then the pose is
        the one of the motion at which it is furthest from that.
        """
        if abs(math.sin(self.opening)) >= REGULAR:
            return 0.0, 0.0
        path = np.linspace(min(self.deltas), max(self.deltas), POSES)
        best = float(path[first_largest(np.abs(np.sin(path)))])
        inertias = self.inertias
        link = float(link_turn(best, inertias) - link_turn(self.opening, inertias))
        return link, link - (best - self.opening)

    def outline(self, index: int) -> tuple[complex, ...]:
        """Compute a line along the links: tool, link 2, links 3, 4 and 1, moving pivot."""
        chain, m = self.chain, self.masses
        e1 = cmath.exp(1j * (self.first_angle + chain.link_turns[index]))
        e2 = cmath.exp(1j * (self.second_angle + chain.tool_turns[index]))
        W, end = chain.fixed + chain.length * e1, chain.fixed - m.l3 * e1
        tool = chain.positions[index].point
        return tool, W, W - m.l2 * e2, end - m.l2 * e2, end, chain.fixed, W


def elbow_ratio(ratio: float) -> float:
    """Compute the turn of the elbow over that of the shoulder, ``1/k - 1``, at a ratio k.

    It is negative for every k < 0: a belt that is not crossed, from a pulley that is fixed to
    the base at the fixed pivot to one on link 2 at the moving pivot, with radii in the ratio
    ``1 - 1/k``, makes both links turn so.
    """
    return 1.0 / ratio - 1.0


def pantograph_urdf(pantograph: BalancedPantograph, ratio: float | None = None) -> bytes:
    """Write a pantograph as a URDF file, with its loop, at `BalancedPantograph.pose`.

    Inputs are the joint ``shoulder`` at the fixed pivot and ``elbow`` at the moving one, or,
    with a ratio, ``shoulder`` alone, which the elbow follows as a ``<mimic>``. The frame of the
    link ``tool`` is the position of the tool. Lengths are rounded to decimals with which
    opposite sides of the parallelogram are equal exactly.

    Args:
        ratio: k, turn of the first link over that of the tool; None if it varies.
    """
    chain, m = pantograph.chain, pantograph.masses
    first, second = pantograph.pose
    e1 = cmath.exp(1j * (pantograph.first_angle + first))
    e2 = cmath.exp(1j * (pantograph.second_angle + second))
    place = _Rounding(max(chain.length, m.l2, m.l3))
    fixed, along = place(chain.fixed), place(chain.length * e1)
    back, down = place(-m.l3 * e1), place(-m.l2 * e2)
    third = (back[0] - along[0], back[1] - along[1])
    tool = place(chain.reach * cmath.exp(1j * second))
    links = [
        make_elements.link("base"),
        *_links(pantograph, e1, e2),
        make_elements.link("tool"),
    ]
    yaw = number_words([0.0, 0.0, chain.positions[0].angle + second])
    turned = Element("origin", {**_origin(tool).attributes, "rpy": yaw})
    mimic = None if ratio is None else (SHOULDER, elbow_ratio(ratio), 0.0)
    hinge = make_elements.hinge
    joints = [
        hinge(SHOULDER, "base", "link1", _origin(fixed), independent=True),
        hinge(ELBOW, "link1", "link2", _origin(along), mimic=mimic, independent=mimic is None),
        hinge("joint3", "link2", "link3", _origin(down)),
        hinge("joint4", "link1", "link4", _origin(back)),
        make_elements.joint("tool_fixed", "fixed", "link2", "tool", turned),
        make_elements.loop(
            "joint34",
            "revolute",
            [("link3", _origin(third)), ("link4", _origin(down))],
            ("0 0 1", ""),
        ),
    ]
    return element_text(make_elements.robot("pantograph", [*links, *joints])).encode()


def _links(pantograph: BalancedPantograph, e1: complex, e2: complex) -> list[Element]:
    """Make the four moving links with their masses."""
    m = pantograph.masses
    s1, s2, s5 = pantograph.s1, pantograph.s2, pantograph.payload
    second, fourth = m.m2 + m.m5, m.m4 + m.m6
    centre2 = (m.m2 * s2 + m.m5 * s5) / second
    apart2 = m.m2 * m.m5 / second * abs(s5 - s2) ** 2
    centre4 = (m.m4 * m.s4 + m.m6 * m.l2) / fourth
    apart4 = m.m4 * m.m6 / fourth * (m.l2 - m.s4) ** 2
    first_pair = _shares(m.inertia_1, (m.m1, m.m3))
    second_pair = _shares(m.inertia_2, (second, fourth))
    return [
        _link("link1", m.m1, s1 * e1, first_pair[0]),
        _link("link2", second, centre2 * e2, second_pair[0] + apart2),
        _link("link3", m.m3, -m.s3 * e1, first_pair[1]),
        _link("link4", fourth, -centre4 * e2, second_pair[1] + apart4),
    ]


def _shares(inertia: float, masses: tuple[float, float]) -> tuple[float, float]:
    """Share a moment of inertia between two links in proportion to their masses."""
    part = inertia * masses[0] / sum(masses)
    return part, inertia - part


def _link(name: str, mass: float, centre: complex, inertia: float) -> Element:
    """Make a link with mass, whose frame is parallel to the inertial one."""
    moments = inertia * np.diag([IN_PLANE, IN_PLANE, 1.0])
    at = Element("origin", {"xyz": number_words([centre.real, centre.imag, 0.0])})
    return make_elements.link(name, make_elements.inertial(mass, moments, at))


def _origin(at: tuple[Decimal, Decimal]) -> Element:
    """Make the ``<origin>`` of a point."""
    return Element("origin", {"xyz": f"{_word(at[0])} {_word(at[1])} 0"})


def _word(number: Decimal) -> str:
    """Write a decimal without exponent."""
    return f"{number:f}" if number else "0"


class _Rounding:
    """Round points to decimals with a fixed number of places."""

    def __init__(self, size: float) -> None:
        """Choose the places by the largest length."""
        places = max(DIGITS - 1 - math.floor(math.log10(size)), 0)
        self.unit = Decimal(1).scaleb(-places)

    def __call__(self, point: complex) -> tuple[Decimal, Decimal]:
        """Round the coordinates of a point."""
        x, y = (Decimal(value).quantize(self.unit) for value in (point.real, point.imag))
        return x, y
