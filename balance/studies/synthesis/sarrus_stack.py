"""Balanced chains stacked into a mechanism of two degrees of freedom.

Two RR chains in vertical planes at an angle carry a platform that can only rise and sink, a
Sarrus linkage; a crank-slider on the platform moves by itself. Each is balanced alone:

- In each leg the links turn against each other, ``θ̇1 = -θ̇2``. A counter-mass behind the elbow
  keeps the centre of the upper link and of the leg's share of all that the platform carries at
  the elbow, and one behind the base joint that of the leg at the base; then C = 0, and J1 = J2
  by a moment of inertia on one of the links.
- The platform carries the masses of the crank-slider as a point mass at the crank's pivot.
- In the crank-slider crank and coupler have one length, so that they turn against each other
  too, and the slider goes along a line through the crank's pivot: the same chain, with the
  slider for the share of the platform.

Source: G. Becht, MSc thesis, TU Delft, 2020, chapter 4, Fig. 4.1, a drawing without figures:
lengths and masses are ours.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from kinematics.errors import UsageError
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_text, number_words
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, repr_lines

# Moments about the other axes, of that about the axis of the joints: of a body with some width.
ACROSS = 0.6
# Decimals of lengths and directions, so that sums of two are exact.
DECIMALS = 12


class StackedChains(NamedTuple):
    """Lengths and masses of both chains; SI units.

    Attributes:
        leg: length of both links of a leg, m.
        leg_angle: of the lower link of a leg from the vertical, radians.
        plane_angle: between the planes of the legs, radians; no multiple of π.
        spread: distance of the base joints from the axis of the platform, m.
        crank: length of crank and coupler, m.
        crank_angle: of the crank from the line of the slider, radians.
        link_mass: of each link of a leg, with its counter-mass, kg.
        platform_mass: kg.
        crank_mass: of crank and of coupler, with their counter-masses, kg.
        slider_mass: kg.
        inertia: least moment of inertia of a link about its centre, kg m².
    """

    leg: float = 0.3
    leg_angle: float = 0.7
    plane_angle: float = 0.5 * math.pi
    spread: float = 0.15
    crank: float = 0.1
    crank_angle: float = 0.6
    link_mass: float = 2.0
    platform_mass: float = 1.0
    crank_mass: float = 0.8
    slider_mass: float = 0.4
    inertia: float = 0.01

    def __repr__(self) -> str:
        """Three lines: the mass of all, the legs, the crank-slider."""
        legs, pair = 4.0 * self.link_mass, 2.0 * self.crank_mass
        mass = legs + self.platform_mass + pair + self.slider_mass
        return repr_lines(
            f"StackedChains: {number_text(mass)} kg",
            f"legs: two links of {number_text(self.leg)} m each",
            f"crank and coupler: {number_text(self.crank)} m",
        )


class _Dyad(NamedTuple):
    """Centres and moments of two links in series, balanced with a point mass at the tip."""

    centres: tuple[float, float]
    moments: tuple[float, float]


def stacked_urdf(chains: StackedChains | None = None, name: str = "stacked_chains") -> bytes:
    """Write the stacked mechanism as a URDF file.

    Inputs are ``lift``, of the first leg, and ``crank_joint``.

    Args:
        chains: lengths and masses; see `StackedChains`.
        name: name of the robot.

    Returns:
        The file, whose masses balance both freedoms.

    Raises:
        UsageError: a length or mass is not positive, or an angle makes the mechanism flat.

    Source:
        G. Becht, MSc thesis, TU Delft, 2020, chapter 4, Fig. 4.1.

    Example:
        >>> from pathlib import Path
        >>> import kinematics, balance.studies
        >>> _ = Path("stacked.urdf").write_bytes(balance.studies.stacked_urdf())
        >>> kinematics.load("stacked.urdf").inputs
        ('lift', 'crank_joint')
    """
    c = chains or StackedChains()
    _check(c)
    directions = [_direction(0.0), _direction(c.plane_angle)]
    carried = c.platform_mass + 2.0 * c.crank_mass + c.slider_mass
    leg = _balance_dyad(c.leg, c.link_mass, 0.5 * carried, c.inertia)
    # The frame of the platform is on the joint of the first leg; its middle is on the line to
    # that of the second.
    across = c.spread * (directions[1] - directions[0])
    links, joints = [make_elements.link("base")], []
    for number, radial in enumerate(directions, 1):
        more = _leg(c, leg, number, radial, across)
        links += more[0]
        joints += more[1]
    links.append(_link("platform", c.platform_mass, 0.5 * across, c.inertia, np.eye(3)[2]))
    dyad = _balance_dyad(c.crank, c.crank_mass, c.slider_mass, c.inertia)
    more = _crank_slider(c, dyad, 0.5 * across)
    parts = [*links, *more[0], *joints, *more[1]]
    return element_text(make_elements.robot(name, parts)).encode()


def _check(c: StackedChains) -> None:
    """Refuse chains that do not exist or that are flat."""
    for field, value in c._asdict().items():
        if not (math.isfinite(value) and value > 0.0):
            raise UsageError(f"stacked chains: {field} = {value:g} must be positive")
    for field in ("leg_angle", "plane_angle", "crank_angle"):
        sine = math.sin(getattr(c, field))
        if abs(sine) < 0.05 or (
            field != "plane_angle" and getattr(c, field) > 0.5 * math.pi - 0.05
        ):
            raise UsageError(f"stacked chains: {field} makes the mechanism flat")


def _balance_dyad(length: float, mass: float, tip: float, inertia: float) -> _Dyad:
    """Place counter-masses so that two links that turn against each other have no momentum.

    ``mass s2 + tip l = 0`` and ``mass s1 + (mass + tip) l = 0``; the moments about the base of
    the first link and about the elbow of the second are equal: ``J1 = J2``.
    """
    s2 = -tip * length / mass
    s1 = -(mass + tip) * length / mass
    first = mass * s1**2 + (mass + tip) * length**2
    second = mass * s2**2 + tip * length**2
    return _Dyad((s1, s2), (inertia, inertia + first - second))


def _direction(angle: float) -> Array:
    """Horizontal direction."""
    return np.round([math.cos(angle), math.sin(angle), 0.0], DECIMALS)


def _leg(
    c: StackedChains, dyad: _Dyad, number: int, radial: Array, across: Array
) -> tuple[list[Element], list[Element]]:
    """Make the links and joints of a leg; the second leg closes the loop at the platform."""
    up, axis = np.array([0.0, 0.0, 1.0]), np.array([-radial[1], radial[0], 0.0])
    rise, out = (round(c.leg * f(c.leg_angle), DECIMALS) for f in (math.cos, math.sin))
    along = rise * up + out * radial, rise * up - out * radial
    names = f"lower{number}", f"upper{number}"
    links = _dyad_links(c.leg, c.link_mass, names, dyad, along, axis)
    root = "lift" if number == 1 else "foot2"
    joints = [
        _joint(root, "base", names[0], c.spread * radial, axis, number == 1),
        _joint(f"knee{number}", *names, along[0], axis),
    ]
    if number == 1:
        joints.append(_joint("head1", names[1], "platform", along[1], axis))
    else:
        ends = [("platform", _origin(across)), (names[1], _origin(along[1]))]
        joints.append(make_elements.loop("head2", "revolute", ends, (number_words(axis), "")))
    return links, joints


def _crank_slider(
    c: StackedChains, dyad: _Dyad, pivot: Array
) -> tuple[list[Element], list[Element]]:
    """Make the links and joints of the crank-slider, in the vertical plane of x."""
    axis, line = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    x, z = (round(c.crank * f(c.crank_angle), DECIMALS) for f in (math.cos, math.sin))
    along = np.array([x, 0.0, z]), np.array([x, 0.0, -z])
    links = [
        *_dyad_links(c.crank, c.crank_mass, ("crank", "coupler"), dyad, along, axis),
        _link("slider", c.slider_mass, np.zeros(3), c.inertia, axis),
    ]
    joints = [
        _joint("crank_joint", "platform", "crank", pivot, axis, True),
        _joint("coupler_joint", "crank", "coupler", along[0], axis),
        make_elements.joint(
            "slide",
            "prismatic",
            "platform",
            "slider",
            _origin(pivot + 2.0 * x * line),
            (number_words(line), ""),
        ),
        make_elements.loop(
            "slider_joint",
            "revolute",
            [("coupler", _origin(along[1])), ("slider", _origin(np.zeros(3)))],
            (number_words(axis), ""),
        ),
    ]
    return links, joints


def _dyad_links(
    length: float,
    mass: float,
    names: tuple[str, str],
    dyad: _Dyad,
    along: tuple[Array, Array],
    axis: Array,
) -> list[Element]:
    """Make both links of a dyad."""
    return [
        _link(name, mass, centre / length * way, moment, axis)
        for name, centre, moment, way in zip(
            names, dyad.centres, dyad.moments, along, strict=True
        )
    ]


def _link(name: str, mass: float, centre: Array, moment: float, axis: Array) -> Element:
    """Make a link whose principal axis is that of its joints."""
    tensor = moment * (ACROSS * np.eye(3) + (1.0 - ACROSS) * np.outer(axis, axis))
    return make_elements.link(name, make_elements.inertial(mass, tensor, _origin(centre)))


def _joint(
    name: str, parent: str, child: str, at: Array, axis: Array, independent: bool = False
) -> Element:
    """Make a revolute joint."""
    words = number_words(axis)
    return make_elements.hinge(name, parent, child, _origin(at), words, independent=independent)


def _origin(at: Array) -> Element:
    """Make the ``<origin>`` of a point."""
    return Element("origin", {"xyz": number_words([round(float(x), 15) for x in at])})
