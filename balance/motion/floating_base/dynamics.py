"""Momentum and inertia forces of a linkage whose base moves.

Twists, momenta and wrenches are in the coordinates of the base, about its origin. With the
twist b of the base, the link twists ``V = T u̇`` relative to it (`kinematics.closure.series`),
and the spatial inertia M of each body at its pose,

    t = b + V                                       twist of a body
    h = Σ M t = M_t b + A u̇                         total momentum
    F = M (ḃ + V̇ + ad(b) V) - ad(t)ᵀ M t             inertia wrench of a body

Momentum balance of the whole gives ``Σ F = w`` with the wrench w of the springs, virtual power
``Σ Tᵀ F = Q`` with the drive torques Q. Loops stay closed, because the pose follows from the
inputs. (R. Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 9.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.floating_base.base import BaseInChain
from balance.motion.verification.shaking_wrench import mass_parameters
from balance.space.inertial_parameters.conversions import to_chain
from kinematics.closure.newton import Pose
from kinematics.closure.series import expand_from
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.inertia import displace_parameters, spatial_inertias
from kinematics.model.spatial.screws import bracket_twists, turn_momenta
from kinematics.numerics.array_types import Array


class MovingBodies(NamedTuple):
    """The bodies of a linkage at a pose, with their motion relative to the base.

    Attributes:
        M: spatial inertias (bodies, 6, 6).
        T: twists for unit rates of the coordinates (bodies, 6, w).
        V: twists (bodies, 6).
        V_rate: their rates of change for steady coordinates (bodies, 6).
    """

    M: Array
    T: Array
    V: Array
    V_rate: Array

    def mass_matrix(self, base: BaseInChain) -> Array:
        """Compute the mass matrix of the twist of the base and the coordinates (6+w, 6+w)."""
        w = self.T.shape[2]
        MT = self.M @ self.T
        matrix = np.empty((6 + w, 6 + w))
        matrix[:6, :6] = base.M + self.M.sum(axis=0)
        matrix[:6, 6:] = MT.sum(axis=0)
        matrix[6:, :6] = matrix[:6, 6:].T
        matrix[6:, 6:] = self.input_inertia
        return matrix

    @property
    def input_inertia(self) -> Array:
        """The inertia that the coordinates feel while the base rests (w, w)."""
        return np.asarray(np.einsum("biu,biw->uw", self.T, self.M @ self.T))

    def bias(self, base: BaseInChain, b: Array) -> Array:
        """Compute the inertia forces for steady rates of base and coordinates (6+w,).

        Args:
            b: its twist (6,).
        """
        h = self.momenta(b)
        F = _apply(self.M, self.V_rate + bracket_twists(b, self.V)) + turn_momenta(
            self.V + b, h
        )
        whole = F.sum(axis=0) + turn_momenta(b, base.M @ b)
        return np.concatenate([whole, np.einsum("biw,bi->w", self.T, F)])

    def momenta(self, b: Array) -> Array:
        """Compute the momenta of the bodies (bodies, 6), if the base has the twist b."""
        return _apply(self.M, self.V + b)

    def kinetic_energy(self, base: BaseInChain, b: Array) -> float:
        """Compute the kinetic energy of bodies and base.

        Args:
            b: its twist (6,).
        """
        bodies = np.einsum("bi,bi->", self.V + b, self.momenta(b))
        return 0.5 * float(bodies + b @ base.M @ b)


class CarriedBodies:
    """The bodies of a linkage with given masses, at any pose and any rates."""

    def __init__(
        self, linkage: Linkage, chain: Chain, basis: Array, z: ArrayLike | None = None
    ) -> None:
        """Prepare a linkage.

        Args:
            chain: its arrays, from `kinematics.closure.joint_positions.input_chain`.
            basis: inputs for unit values of the coordinates (mobility, w), chain units.
            z: inertial parameters as in `balance.motion.shaking`; those of the file by default.
        """
        self._chain, self._basis = chain, basis
        self._z = to_chain(mass_parameters(linkage, z), chain.frame, False, False)
        self._moving = chain.links >= 0

    @property
    def mass(self) -> float:
        """Total mass, kg."""
        return float(self._z[:, 0].sum())

    def at(self, pose: Pose, rates: Array) -> MovingBodies:
        """Compute the bodies at a closed pose.

        Args:
            rates: rates of the coordinates (w,).
        """
        chain, links = self._chain, self._chain.links
        series = expand_from(chain, pose.screws, (self._basis @ rates)[None], 1)
        M = spatial_inertias(displace_parameters(self._z, pose.H[links]))
        T = np.einsum("bui,uw->biw", series.T[0, 0, links], self._basis)
        V = series.V[0][:, links]
        if not self._moving.all():
            fixed = ~self._moving
            M[fixed] = spatial_inertias(self._z[fixed])
            T[fixed], V[:, fixed] = 0.0, 0.0
        return MovingBodies(M, T, V[0], V[1])


def _apply(M: Array, t: Array) -> Array:
    """Multiply matrices (bodies, 6, 6) with twists (bodies, 6)."""
    return (M @ t[..., None])[..., 0]
