"""Balanced four-bars stacked in the plane: each stands on the coupler of the one before.

A balanced kite or antiparallelogram is decoupled: the moment of inertia of all its links
together about their common centre of mass is constant, and so is that centre. What carries it
feels a rigid body, whatever the four-bar does on it. So n four-bars, each with its base on the
coupler of the one before, have masses that leave no reactions in n freedoms. Then they are
decoupled, too: with the twist t of the coupler below and the inertia M of four-bar k with all
that it carries,

    T = Σ_k ½ m_k(q_k) q̇_k²,

since the momentum of its links relative to its base vanishes and leaves no product ``t·q̇_k``.
The inertia that the drives feel is diagonal in all poses, and each term depends on its own
crank alone. Three four-bars place a tool in the plane.

Source: S. Foucault, C. M. Gosselin, Synthesis, design, and prototyping of a planar
three-degree-of-freedom reactionless parallel mechanism, ASME J. Mech. Des. 126(6), 2004, which
has four-bars in series as legs; that decoupled modules can be stacked, J. J. de Jong, PhD
thesis, University of Twente, section 2.4.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.masses.designs.density import STEEL
from balance.space.spaces.design_space import DesignSpace
from balance.studies.synthesis.four_bar_masses import (
    LEAST,
    balanced_masses,
    bare_space,
    plane_origin,
)
from balance.studies.synthesis.four_bars import FOUR_BARS, place_four_bar
from balance.studies.synthesis.positions import Position
from kinematics.errors import UsageError
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_text, number_words
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

Complex = NDArray[np.complex128]

# Shortest base over its crank: masses exist above √2.
SHORTEST = 1.42
# Thickness of plates, over the length of a base; the first that does is taken.
PLATES = (1.0 / 20.0, 1.0 / 8.0)
# Sine of the angle between crank and base, below which a four-bar is flat.
FLAT = 0.05


class StackedFourBar(NamedTuple):
    """A four-bar of a stack; SI units, radians.

    Attributes:
        kind: ``"kite"`` or ``"antiparallelogram"``.
        crank: length of the crank, m.
        ratio: length of the base over that of the crank, more than √2.
        crank_angle: of the crank from the base, no multiple of π.
        base_angle: of the base from that of the four-bar below, in the pose of the file.
    """

    kind: str = "antiparallelogram"
    crank: float = 0.2
    ratio: float = 3.0
    crank_angle: float = 1.2
    base_angle: float = 0.0

    def __repr__(self) -> str:
        """One line: the kind and both lengths."""
        lengths = f"{number_text(self.crank)} and {number_text(self.crank * self.ratio)} m"
        return f"StackedFourBar: {self.kind}, crank and base {lengths}"


THREE = (
    StackedFourBar(crank=0.3),
    StackedFourBar(crank=0.15, base_angle=1.5),
    StackedFourBar(crank=0.075, base_angle=-0.7),
)
"""Three four-bars, for all positions in a part of the plane."""
MOST_STACKED = 6
"""Most four-bars of a stack."""


class StackPoints(NamedTuple):
    """Where a stack is; complex, metres or radians, inertial frame.

    Attributes:
        pins: of each four-bar its crank and rocker on the base, and their tips (n, 4, …).
        middle: of the last coupler (…).
        turn: angle of the last coupler, continued over all poses of its crank (…).
    """

    pins: Complex
    middle: Complex
    turn: Array


def coupler_turn(kind: str, ratio: float, crank_angles: Array) -> Array:
    """Compute the angle of a coupler from its base, continued between change points.

    Args:
        kind: ``"kite"`` or ``"antiparallelogram"``.
        ratio: length of the base over that of the crank.
        crank_angles: radians, all above or all below 0; any shape.
    """
    A, B = place_four_bar(kind, ratio, crank_angles)
    if kind == "antiparallelogram":
        return np.angle(B - A)
    # That of a kite turns from -π to 0, or from π to 0.
    side = 1j * np.sign(crank_angles)
    return np.angle((B - A) * side) - np.angle(side)


def place_stack(
    modules: Sequence[StackedFourBar],
    crank_angles: Array,
    middle: complex = 0j,
    rests: Sequence[float] | None = None,
) -> StackPoints:
    """Compute the points of a stack for angles of its cranks.

    Args:
        modules: the four-bars, the lowest first.
        crank_angles: of each crank from its base, radians (…, n), on the side of the angle of
            the file.
        middle: of the lowest base, metres.
        rests: angle of each base from the coupler below, radians; of the modules by default.
    """
    rests = base_rests(modules) if rests is None else rests
    turn = np.zeros(crank_angles.shape[:-1])
    at, pins = np.full(turn.shape, middle, dtype=np.complex128), []
    for k, module in enumerate(modules):
        alpha = crank_angles[..., k]
        turn = turn + rests[k]
        scale = module.crank * np.exp(1j * turn)
        A, B = place_four_bar(module.kind, module.ratio, alpha)
        corner = at - 0.5 * module.ratio * scale
        tips = corner + scale * A, corner + scale * B
        pins.append([corner, corner + module.ratio * scale, *tips])
        at, turn = (
            0.5 * (tips[0] + tips[1]),
            turn + coupler_turn(module.kind, module.ratio, alpha),
        )
    return StackPoints(np.array(pins), at, turn)


def base_rests(modules: Sequence[StackedFourBar]) -> list[float]:
    """Compute the constant angle of each base from the coupler that it stands on, radians."""
    rests = [modules[0].base_angle]
    for below, module in pairwise(modules):
        turn = coupler_turn(below.kind, below.ratio, np.array(below.crank_angle))
        rests.append(module.base_angle - float(turn))
    return rests


def four_bar_stack_urdf(
    modules: Sequence[StackedFourBar] = THREE,
    name: str = "four_bar_stack",
    *,
    density: float | None = STEEL,
    thickness: float | None = None,
) -> bytes:
    """Write four-bars that stand on each other as a URDF file, with masses that balance it.

    Inputs are ``crank_joint_1``, ``crank_joint_2``, …; the tool, at the middle of the last
    coupler, is the link ``tool``. The middle of each base is that of the coupler below. The
    masses are the least with which the whole stack is balanced, and so decoupled; the last
    coupler, with the tool, has 1 kg or more.

    Args:
        modules: the four-bars, the lowest first; three by default.
        name: of the robot.
        density: that no link exceeds, kg/m³; None for points.
        thickness: of the plates that the links are, metres; by default a twentieth of the
            lowest base, or an eighth if those are too thin.

    Returns:
        The file.

    Raises:
        UsageError: there is no four-bar, one is flat, or no such masses balance the stack.

    Source:
        S. Foucault, C. M. Gosselin, ASME J. Mech. Des. 126(6), 2004.

    Example:
        >>> from pathlib import Path
        >>> import kinematics, balance.studies
        >>> _ = Path("stack.urdf").write_bytes(balance.studies.four_bar_stack_urdf())
        >>> kinematics.load("stack.urdf").inputs
        ('crank_joint_1', 'crank_joint_2', 'crank_joint_3')
    """
    check_stack(modules)
    angles = np.array([module.crank_angle for module in modules])
    place = place_stack(modules, angles)
    middle = complex(place.middle)
    tool = Position(middle.real, middle.imag, 0.0)
    base = modules[0].crank * modules[0].ratio
    space = stack_space(bare_stack(place, tool, name))
    for plate in plate_thicknesses(base, density, thickness):
        masses = stack_masses(space, density, plate)
        if masses is not None:
            return masses.urdf
    matter = "masses" if density is None else f"matter of at most {density:g} kg/m³"
    raise UsageError(
        f"no {matter} balances the stack: take longer bases, or allow denser or thicker matter"
    )


def plate_thicknesses(
    base: float, density: float | None, thickness: float | None
) -> tuple[float | None, ...]:
    """List the thicknesses of plates to try, the first that balances counts; metres.

    Args:
        base: length of a base, m.
        density: of the plates; None for points, which have no thickness.
        thickness: the only one to try, if given.
    """
    if thickness is not None or density is None:
        return (thickness,)
    return tuple(part * base for part in PLATES)


class StackMasses(NamedTuple):
    """Masses of a stack.

    Attributes:
        urdf: the file with them.
        masses: of its links by name, kg.
    """

    urdf: bytes
    masses: dict[str, float]


def stack_space(urdf: bytes) -> DesignSpace:
    """Compute the design space of a stack without masses."""
    return bare_space("four_bar_stack", urdf)


def stack_masses(
    space: DesignSpace, density: float | None, thickness: float | None
) -> StackMasses | None:
    """Find the least masses with which a stack is balanced; None if there are none.

    Args:
        space: see `stack_space`.
        density: density of its links at most, kg/m³; None for points.
        thickness: of the plates that its links are, metres.
    """
    last = max(body.name for body in space.linkage.bodies if body.name.startswith("coupler"))
    file, best = balanced_masses(space, density, thickness, {last: LEAST["coupler"]})
    if file is None:
        return None
    return StackMasses(file, {body.name: float(body.mass) for body in best.bodies})


def check_stack(modules: Sequence[StackedFourBar]) -> None:
    """Refuse a stack of nothing or too many, and four-bars that are flat or have no masses."""
    if not 0 < len(modules) <= MOST_STACKED:
        raise UsageError(f"a stack has one to {MOST_STACKED} four-bars")
    for k, module in enumerate(modules, 1):
        where = f"four-bar {k} of the stack"
        if module.kind not in FOUR_BARS:
            raise UsageError(f"{where}: kind '{module.kind}' is none of {', '.join(FOUR_BARS)}")
        if not all(map(math.isfinite, module[1:])) or module.crank <= 0.0:
            raise UsageError(f"{where}: give finite numbers, and a crank with a length")
        if module.ratio < SHORTEST:
            raise UsageError(
                f"{where}: no masses balance it with ratio = {module.ratio:g}: the base is "
                "longer than √2 times the crank"
            )
        if abs(math.sin(module.crank_angle)) < FLAT:
            raise UsageError(f"{where}: crank_angle makes it flat, where it may fold")


def bare_stack(place: StackPoints, tool: Position, name: str) -> bytes:
    """Write a stack at a pose as a URDF file without masses.

    All frames of links are parallel to the inertial frame at that pose; that of the tool is
    fixed to the last coupler.

    Args:
        place: its points at the pose.
        tool: where the tool is then.
        name: of the robot.
    """
    parts, parent = [make_elements.link("base")], ("base", 0j)
    for k, pins in enumerate(place.pins.tolist(), 1):
        parts += four_bar_elements(pins, str(k), parent)
        parent = f"coupler_{k}", pins[2]
    link, at = parent
    turned = Element(
        "origin",
        {
            **plane_origin(tool.point - at).attributes,
            "rpy": number_words([0.0, 0.0, tool.angle]),
        },
    )
    parts += [
        make_elements.link("tool"),
        make_elements.joint("tool_fixed", "fixed", link, "tool", turned),
    ]
    return element_text(make_elements.robot(name, parts)).encode()


def four_bar_elements(
    pins: Sequence[complex], label: str, parent: tuple[str, complex], independent: bool = True
) -> list[Element]:
    """Make the links and joints of a four-bar, without masses.

    Args:
        pins: its crank and rocker on the base, and their tips, m, inertial frame.
        label: what ends the names of its links and joints.
        parent: link that it stands on, and the place of its frame.
        independent: whether its crank is an input.
    """
    base, rocker, crank, end = pins
    crank_link, coupler_link, rocker_link = (
        f"{name}_{label}" for name in ("crank", "coupler", "rocker")
    )
    link, below = parent
    return [
        *map(make_elements.link, (crank_link, coupler_link, rocker_link)),
        make_elements.hinge(
            f"crank_joint_{label}",
            link,
            crank_link,
            plane_origin(base - below),
            independent=independent,
        ),
        make_elements.hinge(
            f"coupler_joint_{label}", crank_link, coupler_link, plane_origin(crank - base)
        ),
        make_elements.hinge(
            f"rocker_joint_{label}", link, rocker_link, plane_origin(rocker - below)
        ),
        make_elements.loop(
            f"tip_joint_{label}",
            "revolute",
            [
                (coupler_link, plane_origin(end - crank)),
                (rocker_link, plane_origin(end - rocker)),
            ],
            ("0 0 1", ""),
        ),
    ]
