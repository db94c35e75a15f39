"""Balanced four-bars stacked in the plane: each stands on the coupler of the one before.

A balanced kite or antiparallelogram is decoupled: the moment of inertia of all its links
together about their common centre of mass is constant, and so is that centre. What carries it
feels a rigid body, whatever the four-bar does on it. With masses m, centre c and moment I of
that body at the base, the coupler below keeps balance if it gives up so much of its own: its
balanced masses, scaled by

    s ≥ m / m_c        s ≥ I / I_c

less m and I, are those of a link that can be built, where the four-bar stands with its centre
on that of the coupler. So n four-bars make a mechanism of n freedoms without reactions; three
place a tool in the plane.

Source: S. Foucault, C. M. Gosselin, Synthesis, design, and prototyping of a planar
three-degree-of-freedom reactionless parallel mechanism, ASME J. Mech. Des. 126(6), 2004, which
has four-bars in series as legs; that decoupled modules can be stacked, J. J. de Jong, PhD
thesis, University of Twente, section 2.4.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.designs.density import STEEL
from balance.studies.synthesis.four_bar_masses import (
    balanced_masses,
    bare_space,
    four_bar_urdf,
    plane_origin,
)
from balance.studies.synthesis.four_bars import FOUR_BARS, FourBarDesign
from balance.studies.synthesis.positions import Position
from kinematics.errors import UsageError
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import element_text
from kinematics.wording import number_text

# Shortest base over its crank: masses exist above √2.
SHORTEST = 1.42
# What a coupler keeps of its mass or moment beside what it carries, over that at least.
SPARE = 0.5
# Thickness of plates, over the length of the base.
PLATE = 1.0 / 20.0
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


class _Body(NamedTuple):
    """Mass, kg; centre, m, as a complex number; moment of inertia about it, kg m²."""

    mass: float
    centre: complex
    moment: float


class _Module(NamedTuple):
    """A four-bar at the origin, with masses that balance it.

    Attributes:
        pivots: by name, metres.
        bodies: of its moving links, with what it carries.
        whole: all of them together.
    """

    pivots: dict[str, complex]
    bodies: dict[str, _Body]
    whole: _Body


def four_bar_stack_urdf(
    modules: Sequence[StackedFourBar] = THREE, name: str = "four_bar_stack"
) -> bytes:
    """Write four-bars that stand on each other as a URDF file, with masses that balance it.

    Inputs are ``crank_joint_1``, ``crank_joint_2``, …; the tool, at the middle of the last
    coupler, is the link ``tool``. Each four-bar is balanced and decoupled with all that it
    carries, and so is the stack.

    Args:
        modules: the four-bars, the lowest first; three by default.
        name: of the robot.

    Returns:
        The file.

    Raises:
        UsageError: there is no four-bar, or one has no masses or is flat.

    Source:
        S. Foucault, C. M. Gosselin, ASME J. Mech. Des. 126(6), 2004.

    Example:
        >>> from pathlib import Path
        >>> import kinematics, balance.studies
        >>> _ = Path("stack.urdf").write_bytes(balance.studies.four_bar_stack_urdf())
        >>> kinematics.load("stack.urdf").inputs
        ('crank_joint_1', 'crank_joint_2', 'crank_joint_3')
    """
    _check(modules)
    angles = np.cumsum([module.base_angle for module in modules]).tolist()
    balanced = [_balanced(module, angle) for module, angle in zip(modules, angles, strict=True)]
    for k in range(len(balanced) - 1, 0, -1):
        balanced[k - 1] = _scaled(balanced[k - 1], balanced[k].whole)
    parts, at, parent = [make_elements.link("base")], 0j, ("base", 0j)
    for k, module in enumerate(balanced, 1):
        above = balanced[k].whole if k < len(balanced) else _Body(0.0, 0j, 0.0)
        parts += _elements(module, above, k, at, parent)
        parent = f"coupler_{k}", at + module.pivots["crank_tip"]
        if k < len(balanced):
            # It stands with its centre on that of the coupler below.
            at += module.bodies["coupler"].centre - above.centre
    last = balanced[-1].pivots
    middle = plane_origin(0.5 * (last["rocker_tip"] - last["crank_tip"]))
    parts += [
        make_elements.link("tool"),
        make_elements.joint("tool_fixed", "fixed", parent[0], "tool", middle),
    ]
    return element_text(make_elements.robot(name, parts)).encode()


def _check(modules: Sequence[StackedFourBar]) -> None:
    """Refuse a stack of nothing, and four-bars that are flat or have no masses."""
    if not modules:
        raise UsageError("a stack has one four-bar or more")
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


def _balanced(module: StackedFourBar, angle: float) -> _Module:
    """Find the least masses that balance a four-bar, plates of steel where those do."""
    here = Position(0.0, 0.0, 0.0)
    direction = module.crank * cmath.exp(1j * angle)
    four_bar = FourBarDesign(
        module.kind, (here,), module.ratio, (module.crank_angle,), direction, 0j, here
    )
    space, plate = bare_space(module.kind, four_bar_urdf(four_bar)), four_bar.numbers["base"]
    best = balanced_masses(space, STEEL, PLATE * plate)[1]
    if best.verdict != "feasible":
        best = balanced_masses(space, None)[1]
    if best.verdict != "feasible":
        raise UsageError(f"no masses balance the {module.kind}: {best.words}")
    bodies = {
        each.name: _Body(each.mass, complex(*each.com[:2]), float(each.link_inertia[2, 2]))
        for each in best.bodies
        if each.com is not None and each.link_inertia is not None
    }
    return _Module(four_bar.pivots(), bodies, _together(bodies.values()))


def _times(body: _Body, factor: float) -> _Body:
    return _Body(factor * body.mass, body.centre, factor * body.moment)


def _together(bodies: Iterable[_Body]) -> _Body:
    """Add bodies up."""
    parts = list(bodies)
    mass = sum(body.mass for body in parts)
    centre = sum(body.mass * body.centre for body in parts) / mass
    moment = sum(body.moment + body.mass * abs(body.centre - centre) ** 2 for body in parts)
    return _Body(mass, centre, moment)


def _scaled(module: _Module, load: _Body) -> _Module:
    """Scale the masses of a four-bar so that its coupler can give up those of a load."""
    coupler = module.bodies["coupler"]
    least = max(load.mass / coupler.mass, load.moment / coupler.moment)
    factor = max(1.0, (1.0 + SPARE) * least)
    bodies = {name: _times(body, factor) for name, body in module.bodies.items()}
    return _Module(module.pivots, bodies, _together(bodies.values()))


def _elements(
    module: _Module, load: _Body, number: int, at: complex, parent: tuple[str, complex]
) -> list[Element]:
    """Make the links and joints of a four-bar.

    Args:
        load: what stands on its coupler, whose mass and moment that gives up.
        at: its place, m, inertial frame.
        parent: link that it stands on, and the place of its frame.
    """
    bodies = dict(module.bodies)
    mass, centre, moment = bodies["coupler"]
    bodies["coupler"] = _Body(mass - load.mass, centre, moment - load.moment)
    pins = module.pivots
    base, crank, rocker = (pins[name] for name in ("crank_base", "crank_tip", "rocker_base"))
    end = pins["rocker_tip"]
    frames = {"crank": base, "coupler": crank, "rocker": rocker}
    parts = []
    for name, frame in frames.items():
        body = bodies[name]
        # A plate in the plane of motion.
        tensor = body.moment * np.diag([0.5, 0.5, 1.0])
        inertial = make_elements.inertial(body.mass, tensor, plane_origin(body.centre - frame))
        parts.append(make_elements.link(f"{name}_{number}", inertial))
    link, below = parent
    names = {name: f"{name}_{number}" for name in frames}
    return [
        *parts,
        make_elements.hinge(
            f"crank_joint_{number}",
            link,
            names["crank"],
            plane_origin(at + base - below),
            independent=True,
        ),
        make_elements.hinge(
            f"coupler_joint_{number}",
            names["crank"],
            names["coupler"],
            plane_origin(crank - base),
        ),
        make_elements.hinge(
            f"rocker_joint_{number}", link, names["rocker"], plane_origin(at + rocker - below)
        ),
        make_elements.loop(
            f"tip_joint_{number}",
            "revolute",
            [
                (names["coupler"], plane_origin(end - crank)),
                (names["rocker"], plane_origin(end - rocker)),
            ],
            ("0 0 1", ""),
        ),
    ]
