"""Design spaces of four-bars with given lengths."""

from __future__ import annotations

import numpy as np

import balance
from kinematics import ScrewJoint, from_screws


def four_bar(a, b, c, d, turn):
    """A four-bar of crank a, coupler b, rocker c and ground d, at an angle of the crank."""
    crank = a * np.exp(1j * turn)
    gap = d - crank
    side = (b * b - c * c + abs(gap) ** 2) / (2 * abs(gap))
    height = np.sqrt(b * b - side * side)
    return crank, crank + (side + 1j * height) * gap / abs(gap), d


def space_of(a, b, c, d, turn, mirrored=False):
    """The design space of a four-bar with these lengths."""
    crank, elbow, end = four_bar(a, b, c, d, turn)
    if mirrored:  # the other branch
        line = (end - crank) / abs(end - crank)
        elbow = crank + ((elbow - crank) / line).conjugate() * line
    p = [(z.real, z.imag, 0.0) for z in (crank, elbow, complex(end))]
    joints = [
        ScrewJoint("u1", "base", "crank"),
        ScrewJoint("q2", "crank", "coupler", point=p[0]),
        ScrewJoint("q4", "base", "rocker", point=p[2]),
    ]
    loop = ScrewJoint("q3", "coupler", "rocker", point=p[1])
    return balance.design_space(from_screws(joints, [loop]))
