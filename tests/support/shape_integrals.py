"""A flexible part given by its shape integrals, as other programs and test sets give it.

With shapes φ_i, displacements [u_i, v_i] at x along the undeformed axis,

    M_ij = ∫ φ_i·φ_j dm,    B_ij = ∫ (u_i v_j - v_i u_j) dm,    c1_i = ∫ u_i dm,
    c2_i = ∫ v_i dm,        c12_i = ∫ x u_i dm,                c21_i = ∫ x v_i dm

(B. Simeon, Math. Modelling of Systems 2, 1-18, 1996). Displacements are linear in the elastic
coordinates, so that there is no geometric stiffness.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from balance.motion.flexible.beam_part import PartInertia

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ShapeIntegralPart:
    """A flexible part given by integrals.

    Attributes:
        name: for tables.
        mass: in kg.
        first_moment: ∫ x dm, in kg m.
        moment: moment of inertia about the origin of the frame, in kg m².
        elastic_mass: M, in kg; shape (n, n).
        coupling: B, in kg; shape (n, n), antisymmetric.
        translation: rows c1 and c2, in kg; shape (2, n).
        rotation: rows c12 and c21, in kg m; shape (2, n).
        stiffness: in N/m; shape (n, n).
        damping: in N s/m; shape (n, n).
    """

    name: str
    mass: float
    first_moment: float
    moment: float
    elastic_mass: Array
    coupling: Array
    translation: Array
    rotation: Array
    stiffness: Array
    damping: Array

    @property
    def size(self) -> int:
        """Number of elastic coordinates."""
        return len(self.stiffness)

    def inertia(self, position: Array, velocity: Array) -> PartInertia:
        """Compute mass matrix and bias.

        Args:
            position: coordinates (3 + n,).
            velocity: their rates (3 + n,).
        """
        q, rate, spin = position[3:], velocity[3:], velocity[2]
        c, s = np.cos(position[2]), np.sin(position[2])
        turn = np.array([[c, -s], [s, c]])
        centre = np.array([self.first_moment, 0.0]) + self.translation @ q
        moved = self.translation @ rate
        n = self.size
        mass = np.empty((3 + n, 3 + n))
        mass[:2, :2] = self.mass * np.eye(2)
        mass[:2, 2] = turn @ (-centre[1], centre[0])
        mass[:2, 3:] = turn @ self.translation
        mass[2, 2] = self.moment + 2.0 * self.rotation[0] @ q + q @ self.elastic_mass @ q
        mass[2, 3:] = self.rotation[1] + q @ self.coupling
        mass[3:, 3:] = self.elastic_mass
        mass[2:, :2] = mass[:2, 2:].T
        mass[3:, 2] = mass[2, 3:]
        bias = np.empty(3 + n)
        swirl = 2.0 * spin * np.array([-moved[1], moved[0]])
        bias[:2] = turn @ (swirl - spin**2 * centre)
        bias[2] = 2.0 * spin * (self.rotation[0] @ rate + q @ self.elastic_mass @ rate)
        bias[2] += rate @ self.coupling @ rate
        bias[3:] = -(spin**2) * (self.rotation[0] + self.elastic_mass @ q)
        bias[3:] += self.stiffness @ q + self.damping @ rate
        bias[3:] -= 2.0 * spin * (self.coupling @ rate)
        return PartInertia(mass, bias)
