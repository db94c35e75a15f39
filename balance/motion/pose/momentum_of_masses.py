"""The momentum matrix: total momentum of given masses per unit rate of the inputs.

    h(q, u̇) = M_B(q) u̇,    column w of M_B = Σ_b X_{b,w}(q) z_b

with the regressor X of `balance.space.momentum.regressor`. All six components count, also of
planar linkages, whose bodies need not lie in one plane. (J. J. de Jong, PhD thesis, University
of Twente, Eq. 3.15; D. N. Nenchev, 2013, calls it the coupling of the momentum of a robot.)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.pose.momentum_kernels import (
    fill_body_momenta,
    fill_momenta,
    pose_workspace,
)
from balance.motion.verification.shaking_wrench import mass_parameters, wrench_to_si
from balance.space.inertial_parameters.conversions import to_chain
from kinematics.closure.joint_positions import input_chain, joint_positions
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array


class MassedChain(NamedTuple):
    """A linkage with given masses, prepared for its momentum at many poses.

    Attributes:
        linkage: the linkage.
        chain: all its joints, spatial; the columns are the inputs.
        z: parameters of the bodies (bodies, 10) in the frame and units of the chain.
    """

    linkage: Linkage
    chain: Chain
    z: Array

    @classmethod
    def of(cls, linkage: Linkage, z: ArrayLike | None = None) -> MassedChain:
        """Prepare a linkage.

        Args:
            z: masses as in `momentum_matrix`; those of the file by default.
        """
        chain = input_chain(linkage)
        parameters = to_chain(mass_parameters(linkage, z), chain.frame, False, False)
        return cls(linkage, chain, np.ascontiguousarray(parameters))

    def __repr__(self) -> str:
        """One line: the linkage."""
        return f"MassedChain of {self.linkage.name}"

    def momenta(self, q: Array) -> tuple[Array, Array]:
        """Compute the momentum matrices at closed poses, all at once.

        Args:
            q: positions of all joints (poses, n), in units of the chain.

        Returns:
            ``[ξ; p]`` for unit rates (poses, 6, mobility), in the frame and units of the chain;
            and, entry by entry, the sum of the sizes of the momenta of the bodies.
        """
        M, magnitudes = np.empty((2, len(q), 6, self.chain.width))
        self._fill(fill_momenta, q, M, magnitudes)
        return M, magnitudes

    def body_momenta(self, q: Array) -> Array:
        """Compute the momenta of single bodies at closed poses, all at once.

        Args:
            q: positions of all joints (poses, n), in units of the chain.

        Returns:
            ``[ξ; p]`` for unit rates (poses, 6, mobility, bodies), in the frame and units of
            the chain.
        """
        h = np.empty((len(q), 6, self.chain.width, len(self.z)))
        self._fill(fill_body_momenta, q, h)
        return h

    def _fill(self, fill: Callable[..., None], q: Array, *out: Array) -> None:
        """Run a kernel on poses, with a workspace that the chain keeps.

        Positions are writable, as those that kernels find: all call one compiled version.
        """
        chain = self.chain
        workspace = chain.borrow(("momenta",), lambda: pose_workspace(chain))
        positions = np.array(q, dtype=np.float64, order="C")
        fill(chain.walked, chain.links, self.z, positions, workspace, *out)
        chain.give_back(("momenta",), workspace)

    def to_si(self, M: Array) -> Array:
        """Convert matrices (..., 6, mobility) of the chain to SI units, inertial origin."""
        chain = self.chain
        inputs = self.linkage.positions_of(self.linkage.inputs)
        per_rate = wrench_to_si(np.swapaxes(M, -1, -2), chain.frame)
        return np.asarray(np.swapaxes(per_rate / chain.units[inputs][:, None], -1, -2))


def momentum_matrix(
    linkage: LinkageLike, q: ArrayLike | Mapping[str, float], z: ArrayLike | None = None
) -> Array:
    """Compute the total momentum of a linkage per unit rate of each input, ``h = M_B u̇``.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: displacements from the reference pose, of the inputs or of all joints; see
            `kinematics.closure.joint_positions.joint_positions`; radians and metres.
        z: inertial parameters of the bodies, by default those of the file; see
            `balance.motion.verification.shaking_wrench.mass_parameters`.

    Returns:
        Shape (6, mobility): ``[ξ; p]`` about the inertial origin in inertial axes, kg m² and
        kg m for inputs that turn, kg m and kg for those that slide.

    Raises:
        PoseError: the pose does not close the loops, or cannot be reached.
        LinkageError: the number of parameters is wrong.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eq. 3.15.

    Example:
        >>> import balance
        >>> balance.pose.momentum_matrix("robot.urdf", {"u1": 0.1}).shape
        (6, 1)
    """
    linkage = as_linkage(linkage)
    model = MassedChain.of(linkage, z)
    positions = joint_positions(linkage, q) / model.chain.units
    return np.asarray(model.to_si(model.momenta(positions[None])[0])[0])
