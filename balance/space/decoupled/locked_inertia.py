"""Inertia of a linkage on its base: that of all bodies together, with the joints locked."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.spatial.inertia import displace_parameters, spatial_inertias
from kinematics.numerics.array_types import Array


def locked_inertia(
    linkage: LinkageLike, q: ArrayLike | Mapping[str, float], *, spatial: bool | None = None
) -> Array:
    """Compute the inertia of a linkage on its base, with the joints locked at a pose.

    ``M = Σ_b [[E_b, [mc_b]×], [-[mc_b]×, m_b 1]]``: the momentum ``[ξ; p] = M t`` of the moving
    bodies when they move with the base, at its twist ``t = [ω; v]``.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: displacements from the reference pose, of all joints or of the inputs alone; see
            `kinematics.closure.joint_positions.joint_positions`; radians and metres.
        spatial: six components; by default only if the linkage is not planar.

    Returns:
        Shape (6, 6) about the inertial origin in inertial axes; or (3, 3) for ``[ωz; vx; vy]``
        in the axes of the plane; SI units.

    Raises:
        PoseError: the pose does not close the loops, or cannot be reached.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eq. 2.57.

    Example:
        >>> import balance
        >>> balance.space.locked_inertia("robot.urdf", {"u1": 0.1}).shape
        (3, 3)
    """
    linkage = as_linkage(linkage)
    M = spatial_inertias(locked_parameters(linkage, q))
    if not linkage.planar if spatial is None else spatial:
        return M
    R = linkage.chain.frame.R
    turned = np.kron(np.eye(2), R) @ M @ np.kron(np.eye(2), R).T
    kept = np.ix_([2, 3, 4], [2, 3, 4])
    return np.asarray(turned[kept])


def locked_parameters(linkage: LinkageLike, q: ArrayLike | Mapping[str, float]) -> Array:
    """Compute the inertial parameters (10,) of all bodies together at a pose.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        q: displacements from the reference pose, as in `locked_inertia`.

    Returns:
        Parameters about the inertial origin, SI units.
    """
    linkage = as_linkage(linkage)
    chain = si_chain(linkage, True)
    pose = forward_kinematics(chain, joint_positions(linkage, q)[chain.joints])
    H = np.concatenate([pose.H, np.eye(4)[None]])[chain.links]
    z = np.array([body.inertia for body in linkage.bodies]).reshape(-1, 10)
    return np.asarray(displace_parameters(z, H).sum(axis=0))
