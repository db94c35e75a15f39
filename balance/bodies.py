"""Parameters of one body: conversions, checks, multipoles.

- ``parameters``: from mass, centre of mass and inertia about that centre
- ``mass_properties``: mass, centre of mass and central inertia of parameters
- ``pseudo_inertia``: the matrix (4, 4) that is positive for physical bodies
- ``violations``: inequalities of physical bodies that parameters break
- ``BodyInertia``: inertial parameters of a body, and what follows from them
- ``Primitive``: one element of a mass distribution
- ``Multipole``: the parameters of a body as a mass, displacements and rods
- ``multipole_of``: decompose parameters into a mass and displacements at a point, and rods
"""

from __future__ import annotations

from balance.space.inertial_parameters.body_inertia import BodyInertia
from balance.space.inertial_parameters.conversions import (
    mass_properties,
    parameters,
    pseudo_inertia,
    violations,
)
from balance.space.inertial_parameters.multipole import Multipole, Primitive, multipole_of

__all__ = [
    "BodyInertia",
    "Multipole",
    "Primitive",
    "mass_properties",
    "multipole_of",
    "parameters",
    "pseudo_inertia",
    "violations",
]
