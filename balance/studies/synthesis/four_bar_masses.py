"""Masses of a balanced linkage with a coupler, and URDF file of a four-bar."""

from __future__ import annotations

from collections.abc import Mapping
from math import inf

from balance.masses.designs.best_design import Design, design
from balance.masses.designs.density import STEEL
from balance.masses.designs.write_urdf import replace_inertials
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace
from balance.studies.synthesis.four_bars import FourBarDesign
from balance.studies.synthesis.general_four_bars import GeneralFourBar
from kinematics.loading.model_gallery import load
from kinematics.model.document import make_elements
from kinematics.model.document.element import Document, Element
from kinematics.model.document.write_numbers import element_text, number_words

# Least masses, kg: of the coupler, which carries the tool, and of a slider.
LEAST = {"coupler": 1.0, "slider": 0.1}
# Decimals of lengths in the file.
DECIMALS = 15
LINKS = ("base", "crank", "coupler", "rocker", "tool")
"""Links of the file."""


def bare_space(name: str, urdf: bytes) -> DesignSpace:
    """Compute the design space of a file without masses, in floating point.

    Exact arithmetic would see the rounding of its digits, in which special lengths are no
    longer special.
    """
    return design_space(load(Document(name, urdf), bodies="all"))


def balanced_masses(
    space: DesignSpace,
    density: float | None = STEEL,
    thickness: float | None = None,
    least: Mapping[str, float] = LEAST,
) -> tuple[bytes | None, Design]:
    """Find the least masses that balance a linkage, and its file.

    Args:
        density: density of its links at most, kg/m³; None for points.
        thickness: of the plates that its links are, metres; see `balance.design`.
        least: least masses of links by name, kg; by default a coupler has at least 1 kg, and a
            slider 0.1 kg.

    Returns:
        The bytes of the file, None if no masses balance it, and the design.
    """
    names = {body.name for body in space.linkage.bodies}
    bounds = {name: (value, inf) for name, value in least.items() if name in names}
    best = design(space, "mass", bounds=bounds, density=density, thickness=thickness)
    if best.verdict != "feasible":
        return None, best
    elements = {body.name: body.urdf for body in best.bodies if body.urdf}
    return replace_inertials(best.space.linkage, elements), best


def four_bar_urdf(
    four_bar: FourBarDesign | GeneralFourBar,
    inertials: Mapping[str, Element] | None = None,
    name: str = "",
) -> bytes:
    """Write a four-bar as a URDF file at the first position.

    The frames of crank and coupler are at their joints, all parallel to the inertial frame.

    Args:
        inertials: of its links by name; the others have no mass.
        name: of the robot; its kind by default.
    """
    at = four_bar.pivots()
    tool, carrier = four_bar.first, four_bar.tool_link
    crank, tip = at["crank_base"], at["crank_tip"]
    yaw = number_words([0.0, 0.0, tool.angle])
    foot = tip if carrier == "coupler" else at["rocker_base"]
    turned = Element("origin", {**plane_origin(tool.point - foot).attributes, "rpy": yaw})
    parts = [
        *(make_elements.link(link, (inertials or {}).get(link)) for link in LINKS),
        make_elements.hinge(
            "crank_joint", "base", "crank", plane_origin(crank), independent=True
        ),
        make_elements.hinge("coupler_joint", "crank", "coupler", plane_origin(tip - crank)),
        make_elements.hinge("rocker_joint", "base", "rocker", plane_origin(at["rocker_base"])),
        make_elements.joint("tool_fixed", "fixed", carrier, "tool", turned),
        make_elements.loop(
            "tip_joint",
            "revolute",
            [
                ("coupler", plane_origin(at["rocker_tip"] - tip)),
                ("rocker", plane_origin(at["rocker_tip"] - at["rocker_base"])),
            ],
            ("0 0 1", ""),
        ),
    ]
    return element_text(make_elements.robot(name or four_bar.kind, parts)).encode()


def plane_origin(at: complex) -> Element:
    """Make the ``<origin>`` of a point of the plane."""
    x, y = round(at.real, DECIMALS), round(at.imag, DECIMALS)
    return Element("origin", {"xyz": number_words([x, y, 0.0])})
