"""A platform with three freedoms in the plane on three legs of two balanced four-bars each.

The lower four-bar of a leg stands on the base, the upper one on its coupler, and the upper
coupler carries the platform on a hinge at its middle. Each leg has two freedoms, so that three
hinges leave three. A platform of mass m, centre c and moment of inertia J moves as three point
masses at its hinges r_i if

    Σ m_i = m,    Σ m_i r_i = m c,    Σ m_i |r_i - c|² = J,

and each point mass is part of an upper coupler: legs that are balanced with them make a
mechanism without reactions, whatever the platform does. Three hinges that are not in line fix
m_i by the first two, and J by the third.

Sources: S. Foucault, C. M. Gosselin, Synthesis, design, and prototyping of a planar
three-degree-of-freedom reactionless parallel mechanism, ASME J. Mech. Des. 126(6), 2004; the
four-bars: R. Ricard, C. M. Gosselin, On the development of reactionless parallel manipulators,
ASME DETC 2000. Sizes are ours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.designs.density import STEEL
from balance.studies.synthesis.four_bar_masses import balanced_masses, bare_space, plane_origin
from balance.studies.synthesis.four_bar_stack import (
    StackedFourBar,
    check_stack,
    four_bar_elements,
    place_stack,
    plate_thicknesses,
)
from kinematics.errors import UsageError
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_text
from kinematics.wording import count_noun, number_text, repr_lines

LEGS, MODULES = 3, 2
# Area of the triangle of the hinges over the square of its longest side, at least.
IN_LINE = 0.02


def _make_leg(direction: float, turn: float) -> tuple[StackedFourBar, StackedFourBar]:
    """Make a leg whose lower base has a direction, and the upper one an angle from it."""
    return (
        StackedFourBar(crank=0.2, base_angle=direction),
        StackedFourBar(crank=0.12, base_angle=turn),
    )


class FourBarPlatform(NamedTuple):
    """Sizes of a platform on three legs; SI units, radians.

    Attributes:
        hinges: where the platform is hinged to the legs, at the pose of the file; complex, m.
        legs: of each leg the lower and the upper four-bar; the angle of the base of the lower
            is from the x-axis.
        platform_mass: least mass of the platform, kg.
    """

    hinges: tuple[complex, ...] = (0.0j, 0.3 + 0.0j, 0.1 + 0.25j)
    legs: tuple[tuple[StackedFourBar, ...], ...] = (
        _make_leg(0.3, 1.5),
        _make_leg(2.4, 1.3),
        _make_leg(-1.6, 1.7),
    )
    platform_mass: float = 1.0

    def __repr__(self) -> str:
        """Two lines: the platform and its legs."""
        mass = number_text(self.platform_mass)
        return repr_lines(
            f"FourBarPlatform: {mass} kg or more on {count_noun(len(self.hinges), 'hinge')}",
            f"{count_noun(len(self.legs), 'leg')} of {MODULES} four-bars",
        )


DEFAULT = FourBarPlatform()
"""A platform of 1 kg on legs of antiparallelograms."""


def four_bar_platform_urdf(
    platform: FourBarPlatform = DEFAULT,
    name: str = "four_bar_platform",
    *,
    density: float | None = STEEL,
    thickness: float | None = None,
) -> bytes:
    """Write a platform on three legs of four-bars as a URDF file, with masses that balance it.

    Inputs are the lower cranks ``crank_joint_1_1``, ``crank_joint_2_1`` and
    ``crank_joint_3_1``. The masses are the least with which the mechanism has no reactions; the
    moment of inertia of the platform is that of point masses at its hinges.

    Args:
        platform: its sizes.
        name: of the robot.
        density: that no link exceeds, kg/m³; None for points.
        thickness: of the plates that the links are, metres; by default a twentieth of the
            longest base, or an eighth if those are too thin.

    Returns:
        The file.

    Raises:
        UsageError: there are not three legs of two four-bars, the hinges are in line, or no
            such masses balance the mechanism.

    Source:
        S. Foucault, C. M. Gosselin, ASME J. Mech. Des. 126(6), 2004.

    Example:
        >>> from pathlib import Path
        >>> import kinematics, balance.studies
        >>> urdf = balance.studies.four_bar_platform_urdf()
        >>> _ = Path("platform.urdf").write_bytes(urdf)
        >>> kinematics.load("platform.urdf").mobility
        3
    """
    _check(platform)
    space = bare_space(name, _bare_urdf(platform, name))
    longest = max(module.crank * module.ratio for leg in platform.legs for module in leg)
    for plate in plate_thicknesses(longest, density, thickness):
        least = {"platform": platform.platform_mass}
        file, _ = balanced_masses(space, density, plate, least)
        if file is not None:
            return file
    matter = "masses" if density is None else f"matter of at most {density:g} kg/m³"
    raise UsageError(
        f"no {matter} balances the platform: take longer bases, or allow denser or thicker "
        "matter"
    )


def _bare_urdf(platform: FourBarPlatform, name: str) -> bytes:
    """Write the mechanism without masses; all frames are parallel to the inertial frame."""
    parts: list[Element] = [make_elements.link("base")]
    tips = [_add_leg(parts, platform, number) for number in range(1, LEGS + 1)]
    (first, at), *others = tips
    start = platform.hinges[0]
    parts += [
        make_elements.link("platform"),
        make_elements.hinge("hinge_1", first, "platform", plane_origin(start - at)),
    ]
    for number, (link, frame) in enumerate(others, 2):
        hinge = platform.hinges[number - 1]
        sides = [(link, plane_origin(hinge - frame)), ("platform", plane_origin(hinge - start))]
        parts.append(make_elements.loop(f"hinge_{number}", "revolute", sides, ("0 0 1", "")))
    return element_text(make_elements.robot(name, parts)).encode()


def _add_leg(
    parts: list[Element], platform: FourBarPlatform, number: int
) -> tuple[str, complex]:
    """Add the elements of a leg; the link of its upper coupler, and where its frame is."""
    modules = platform.legs[number - 1]
    angles = np.array([module.crank_angle for module in modules])
    reach = complex(place_stack(modules, angles).middle)
    pins = place_stack(modules, angles, platform.hinges[number - 1] - reach).pins.tolist()
    parent = "base", 0j
    for k, corners in enumerate(pins, 1):
        label = f"{number}_{k}"
        parts += four_bar_elements(corners, label, parent, independent=k == 1)
        parent = f"coupler_{label}", corners[2]
    return parent


def _check(platform: FourBarPlatform) -> None:
    """Refuse what is no platform on three legs."""
    if len(platform.hinges) != LEGS or len(platform.legs) != LEGS:
        raise UsageError("platform of four-bars: give three hinges and three legs")
    for number, leg in enumerate(platform.legs, 1):
        if len(leg) != MODULES:
            raise UsageError(
                f"leg {number} of the platform: give a lower and an upper four-bar"
            )
        try:
            check_stack(leg)
        except UsageError as error:
            raise UsageError(f"leg {number} of the platform: {error}") from error
    first, second, third = platform.hinges
    sides = np.array([second - first, third - first, third - second])
    area = 0.5 * abs((sides[0].conjugate() * sides[1]).imag)
    if not area > IN_LINE * np.abs(sides).max() ** 2:
        raise UsageError("platform of four-bars: the hinges are in line, or not finite")
    mass = platform.platform_mass
    if not 0.0 < mass < float("inf"):
        raise UsageError(f"platform of four-bars: platform_mass = {mass:g} must be positive")
