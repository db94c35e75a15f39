"""Mechanisms of the literature on flexible balance, as files and as parts."""

import numpy as np

from balance.motion.flexible.beam import rectangular_beam
from balance.motion.flexible.similarity import Arm

SHARE = 0.1  # distance of the balance masses from the pivots, over the lengths of the links


def four_bar_text(mass, beside=(1.5, -0.5)):
    """The four-bar of Meijaard and van der Wijk 2022, Sec. 5, without dimensions, as URDF.

    Crank from (0, 0) to (0, 0.5), coupler to (1, 0.5), rocker on to the pivot ``beside``. The
    coupler has the mass 1 per length, so that ``mass`` is its length too.
    """
    pivot, a2 = np.array(beside), np.array([1.0, 0.5])
    crank, rocker = np.array([0.0, 0.5]), a2 - pivot

    def link(name, m, at, moment):
        return (
            f'<link name="{name}"><inertial><origin xyz="{at[0]!r} {at[1]!r} 0"/>'
            f'<mass value="{m!r}"/><inertia ixx="{moment!r}" iyy="{moment!r}" '
            f'izz="{moment!r}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    def joint(name, parent, child, at, more=""):
        return (
            f'<joint name="{name}" type="continuous"{more}><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="{at[0]!r} {at[1]!r} 0"/>'
            '<axis xyz="0 0 1"/>'
        )

    mimic = '<mimic joint="{}" multiplier="-1"/></joint>'
    return "\n".join(
        [
            '<robot name="four_bar_with_wheels"><link name="base"/>',
            link("crank", 5 * mass, [float(x) for x in -SHARE * crank], 1e-9),
            link("coupler", mass, [0.5, 0.0], mass**3 / 12.0),
            link("rocker", 5 * mass, [float(x) for x in -SHARE * rocker], 1e-9),
            link("wheel1", 1e-9, [0.0, 0.0], 0.1375 * mass),
            link("wheel3", 1e-9, [0.0, 0.0], 0.6875 * mass),
            joint("u1", "base", "crank", [0.0, 0.0], ' independent="true"') + "</joint>",
            joint("q2", "crank", "coupler", [0.0, 0.5]) + "</joint>",
            joint("q4", "base", "rocker", [float(x) for x in pivot]) + "</joint>",
            joint("w1", "base", "wheel1", [0.0, 0.0]) + mimic.format("u1"),
            joint("w3", "base", "wheel3", [float(x) for x in pivot]) + mimic.format("q4"),
            '<loop name="q3" type="revolute"><predecessor link="coupler">'
            '<origin xyz="1.0 0 0"/></predecessor><successor link="rocker">'
            f'<origin xyz="{float(rocker[0])!r} {float(rocker[1])!r} 0"/></successor>'
            '<axis xyz="0 0 1"/></loop></robot>',
        ]
    )


def steel_arms(classical):
    """The arms of Sec. 2.4: f = 1/2, steel, discs at the tips."""

    def arm(length, thickness, width, mass, radius, hub):
        beam = rectangular_beam(
            length, thickness, width, 2e11, 8000.0, 0.29, 0.84, classical=classical
        )
        return Arm(beam, mass, radius, 0.5 * mass * radius**2, hub)

    return (
        arm(0.1, 1e-3, 2e-3, 0.01, 0.015, 0.01),
        arm(0.05, 0.25e-3, 32e-3, 0.02, 0.0075, 0.005),
    )
