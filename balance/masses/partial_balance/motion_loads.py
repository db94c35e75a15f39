"""Loads along motions as affine functions of the matter that is added to links.

The pseudo-inertia of the matter on a link has ten coordinates in the orthonormal basis of
`balance.support.clarabel_adapter.triangles`, in the unit coordinates of the link's
region: kilograms. All links together have the coordinates s. Each load is linear in the
inertial parameters (`balance.space.momentum.regressor`), so it is ``columns @ [s; 1]``; the
last column is the load of the masses in the file. Moments are about the middle of the
mechanism, or a point that is given. Gravity is left out, since it does not shake.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.counterweights.added_matter import symmetric_basis
from balance.masses.counterweights.regions import Region
from balance.masses.designs.pseudo_inertia_cone import given_parameters
from balance.motion.verification.joint_reactions import JointReactions, joint_reactions
from balance.motion.verification.shaking_wrench import (
    Loads,
    load_regressors,
    mass_parameters,
)
from balance.motion.verification.trajectory import Trajectory
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.spaces.design_space import DesignSpace
from kinematics.closure.joint_positions import input_chain
from kinematics.closure.series import expand_from
from kinematics.model.arrays import Chain, freeze
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest

# Coordinates of the matter on one link.
COORDINATES = 10


@dataclass(frozen=True, eq=False)
class AddedParameters:
    """Inertial parameters of all bodies as an affine function of added matter.

    Attributes:
        chain: all joints of the linkage, columns the inputs.
        regions: region of each link that gets matter, by the position of its body.
        scaled: parameters of the file (bodies, 10), in the units of the chain.
        given: the same about the inertial origin, SI units.
        added: parameters of a body per unit of its coordinates (10, 10), by its position, in
            the units of the chain.
        si: the same about the inertial origin, SI units.
    """

    chain: Chain
    regions: Mapping[int, Region]
    scaled: Array
    given: Array
    added: Mapping[int, Array]
    si: Mapping[int, Array]

    @classmethod
    def of(cls, space: DesignSpace, regions: Mapping[int, Region]) -> AddedParameters:
        """Describe matter in regions of the link frames.

        Args:
            space: a design space of the linkage.
            regions: regions by the position of the body.
        """
        chain, given = input_chain(space.linkage), given_parameters(space)
        basis = symmetric_basis()
        si, added = {}, {}
        for b, region in regions.items():
            H = space.frames[b] @ region.place
            z = from_pseudo_inertia(H @ basis @ H.T)
            si[b], added[b] = z.T, to_chain(z, chain.frame, False, False).T
        chain_z = to_chain(given, chain.frame, False, False)
        return cls(chain, dict(regions), chain_z, given, added, si)

    @property
    def count(self) -> int:
        """Number of coordinates s."""
        return COORDINATES * len(self.regions)

    @property
    def masses(self) -> Array:
        """Mass as a function of the coordinates (count,), kilograms."""
        return np.tile(symmetric_basis()[:, 3, 3], len(self.regions))

    def parameters(self, s: Array) -> Array:
        """Compute the parameters of all bodies (bodies, 10), inertial origin, SI units."""
        z = self.given.copy()
        for (b, D), part in zip(self.si.items(), self.parts(s), strict=True):
            z[b] += D @ part
        return z

    def parts(self, s: Array) -> Array:
        """Split coordinates (count,) into those of each link (links, 10)."""
        return s.reshape(-1, COORDINATES)

    def input_inertia(self) -> Array:
        """Compute the inertia that each input feels at the reference pose.

        It is the diagonal of the generalised inertia matrix: ``tᵀ M t`` summed over the
        bodies, with their twists t for a unit rate of the input.

        Returns:
            Columns (inputs, count + 1), kg m², for sliding inputs kg.
        """
        chain = self.chain
        twists = expand_from(chain, chain.screws, np.zeros((1, chain.width)), 0).T[0, 0]
        rows = np.zeros((chain.links.size, chain.width, COORDINATES))
        for b, link in enumerate(chain.links):
            if link >= 0:
                rows[b] = inertia_weights(twists[link])
        inertias = np.zeros((chain.width, self.count + 1))
        for k, (b, D) in enumerate(self.added.items()):
            inertias[:, COORDINATES * k : COORDINATES * (k + 1)] = rows[b] @ D
        inertias[:, -1] = np.einsum("bwp,bp->w", rows, self.scaled)
        return inertias * (chain.frame.length / self.input_units)[:, None] ** 2

    @property
    def input_units(self) -> Array:
        """SI units per unit of each input of the chain (inputs,)."""
        moving = [first_largest(column) for column in np.abs(self.chain.columns).T]
        return np.asarray(self.chain.units[moving])


def inertia_weights(twists: Array) -> Array:
    """Compute the rows (..., 10) of ``tᵀ M t = ωᵀ E ω + 2 mc·(v × ω) + m v·v``.

    Args:
        twists: t = [ω; v] (..., 6), in the units of the inertial parameters.
    """
    w, v = twists[..., :3], twists[..., 3:]
    x, y, z = np.moveaxis(w, -1, 0)
    products = np.stack([x * y, x * z, y * z], axis=-1)
    size = np.sum(v * v, axis=-1, keepdims=True)
    return np.concatenate([size, 2.0 * np.cross(v, w), w * w, 2.0 * products], axis=-1)


@dataclass(frozen=True, eq=False)
class MotionLoads:
    """Loads along one motion as affine functions of the coordinates s of added matter.

    Attributes:
        trajectory: the motion.
        matter: the parameters as functions of s.
        given: inertia wrench of each body of the file (N, bodies, 6), in chain units,
            as the next.
        added: that of the matter on a body per unit of its coordinates (N, 6, 10), by its
            position: no other coordinate has a part in it.
        screws: joint screws (N, n, 6).
        about: point for moments, from the middle of the mechanism (3,), metres.
    """

    trajectory: Trajectory
    matter: AddedParameters
    given: Array
    added: Mapping[int, Array]
    screws: Array
    about: Array

    @property
    def wrench_columns(self) -> Array:
        """Moment, N m, and force, N, by each parameter, and as given (N, 6, count + 1)."""
        total = np.zeros((len(self.given), 6, self.matter.count + 1))
        for place, part in zip(self._places(), self.added.values(), strict=True):
            total[..., place] += part
        total[..., -1] = self.given.sum(axis=1)
        return self._moved(total)

    @property
    def single_wrenches(self) -> Array:
        """The same of each body of the file alone (N, 6, bodies)."""
        return self._moved(self.given.swapaxes(1, 2))

    @property
    def bodies(self) -> Array:
        """Inertia wrench of each body (N, bodies, 6, count + 1): large, and nowhere kept."""
        columns = np.zeros((*self.given.shape, self.matter.count + 1))
        for place, (b, part) in zip(self._places(), self.added.items(), strict=True):
            columns[:, b, :, place] = part
        columns[..., -1] = self.given
        return columns

    def _places(self) -> list[slice]:
        """List which coordinates are those of each link with added matter."""
        starts = range(0, self.matter.count, COORDINATES)
        return [slice(start, start + COORDINATES) for start in starts]

    def _moved(self, wrenches: Array) -> Array:
        """Convert wrenches of the chain (N, 6, columns) to SI units about the point."""
        L = self.matter.chain.frame.length
        moment, force = L**2 * wrenches[:, :3], L * wrenches[:, 3:]
        moment = moment - np.cross(self.about[None, :, None], force, axis=1)
        return np.concatenate([moment, force], axis=1)

    @property
    def weights(self) -> Array:
        """Weight of each sample in the mean over time (N,), by the trapezoidal rule."""
        step = np.diff(self.trajectory.time)
        sums = np.append(step, 0.0) + np.append(0.0, step)
        return np.asarray(0.5 * sums / step.sum())

    def reactions(self, points: Array | None = None) -> JointReactions:
        """Compute the joint reactions, in the units of the chain.

        Args:
            points: designs ``[s; 1]`` as columns (count + 1, designs); by default, the columns
                of the affine functions.
        """
        bodies = self.bodies
        rate = bodies if points is None else bodies @ points
        return joint_reactions(self.matter.chain, Loads(rate, rate, self.screws))

    def bearings(self, reactions: JointReactions, joint: int) -> Array:
        """Convert the reaction of a joint to its force (N, 3, columns), newtons.

        Args:
            reactions: from `reactions`.
            joint: position of the joint.
        """
        return np.asarray(self.matter.chain.frame.length * reactions.joints[:, joint, 3:])

    def torques(self, reactions: JointReactions) -> Array:
        """Convert reactions to drive torques of the inputs (N, inputs, columns), N m or N.

        Args:
            reactions: from `reactions`.
        """
        chain = self.matter.chain
        moving = [first_largest(column) for column in np.abs(chain.columns).T]
        scale = chain.frame.length**2 / self.matter.input_units
        return np.asarray(reactions.motors[:, moving] * scale[:, None])


def motion_loads(
    matter: AddedParameters, motions: Sequence[Trajectory], about: Array | None = None
) -> list[MotionLoads]:
    """Compute the loads along motions.

    Args:
        matter: the parameters as functions of added matter.
        motions: motions of the linkage.
        about: point for moments, from the middle of the mechanism, metres; that by default.
    """
    chain, loads_along = matter.chain, []
    offset = np.zeros(3) if about is None else about
    for trajectory in motions:
        ud, udd = trajectory.ud / matter.input_units, trajectory.udd / matter.input_units
        loads = load_regressors(chain, trajectory.q / chain.units, ud, udd)
        given = np.einsum("kbip,bp->kbi", loads.rate, matter.scaled)
        added = {b: loads.rate[:, b] @ D for b, D in matter.added.items()}
        loads_along.append(MotionLoads(trajectory, matter, given, added, loads.screws, offset))
    return loads_along


def input_inertia(linkage: Linkage, z: ArrayLike | None = None) -> dict[str, float]:
    """Compute the inertia that each input feels at the reference pose.

    It is the diagonal of the generalised inertia matrix: ``M_ww = Σ_b t_wᵀ M_b t_w`` with the
    twists ``t_w`` of the bodies for a unit rate of the input.

    Args:
        z: inertial parameters of the bodies, by default those of the file; see
            `balance.motion.verification.shaking_wrench.mass_parameters`.

    Returns:
        kg m², for sliding inputs kg, by the name of the input.
    """
    chain, given = input_chain(linkage), mass_parameters(linkage, z)
    scaled = to_chain(given, chain.frame, False, False)
    inertias = freeze(AddedParameters(chain, {}, scaled, given, {}, {}).input_inertia()[:, -1])
    return dict(zip(linkage.inputs, inertias.tolist(), strict=True))
