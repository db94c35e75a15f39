"""The ten inertial parameters of a body, its pseudo-inertia, and their displacement.

``z = [m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]``: E is the moment-of-inertia tensor
about the origin, entries as they stand in the matrix (``Exy = -∫ x y dm``). The
pseudo-inertia ``P = ∫ [x; 1][x; 1]ᵀ dm`` contains the same numbers and moves by ``H P Hᵀ``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kinematics.model.spatial.screws import skew
from kinematics.numerics.array_types import Array

# Index in z of each entry of E.
_ENTRIES = np.array([[4, 7, 8], [7, 5, 9], [8, 9, 6]])


def _linear_maps() -> tuple[Array, Array]:
    """Compute the matrices of `pseudo_inertia` (10, 16) and `from_pseudo_inertia` (16, 10)."""
    P, z = np.zeros((10, 4, 4)), np.zeros((4, 4, 10))
    P[0, 3, 3] = z[3, 3, 0] = 1.0
    for i in range(3):
        P[1 + i, i, 3] = P[1 + i, 3, i] = z[i, 3, 1 + i] = 1.0
        P[4 + i, range(3), range(3)] = 0.5
        P[4 + i, i, i] = -0.5
        z[range(3), range(3), 4 + i] = 1.0
        z[i, i, 4 + i] = 0.0
    for k, (i, j) in enumerate([(0, 1), (0, 2), (1, 2)], 7):
        P[k, i, j] = P[k, j, i] = z[i, j, k] = -1.0
    return P.reshape(10, 16), z.reshape(16, 10)


_MATRICES, _PARAMETERS = _linear_maps()


def parameters(mass: float, com: ArrayLike, inertia: ArrayLike) -> Array:
    """Compute inertial parameters from mass, centre of mass and inertia about that centre.

    ``E = I + m (c·c 1 - c cᵀ)``.

    Args:
        mass: kg.
        com: centre of mass (3,), metres.
        inertia: tensor about the centre of mass (3, 3), kg m², in the axes of ``com``.

    Returns:
        z about the origin of ``com`` (10,).

    Example:
        >>> import balance
        >>> balance.bodies.parameters(2, [0, 0, 1], [[1, 0, 0], [0, 1, 0], [0, 0, 1]]).tolist()
        [2.0, 0.0, 0.0, 2.0, 3.0, 3.0, 1.0, 0.0, 0.0, 0.0]
    """
    c = np.asarray(com, dtype=np.float64)
    E = np.asarray(inertia, dtype=np.float64) + mass * (c @ c * np.eye(3) - np.outer(c, c))
    return stack_parameters(mass, mass * c, E)


def stack_parameters(mass: float, first: ArrayLike, E: Array) -> Array:
    """Stack mass, first moment of mass (3,) and inertia tensor (3, 3), all about one point.

    Returns:
        z about that point (10,).
    """
    first = np.asarray(first, dtype=np.float64)
    return np.array([mass, *first, E[0, 0], E[1, 1], E[2, 2], E[0, 1], E[0, 2], E[1, 2]])


def inertia_tensor(z: ArrayLike) -> Array:
    """Extract the moment-of-inertia tensor E about the origin (..., 3, 3) from z (..., 10)."""
    z = np.asarray(z, dtype=np.float64)
    return z[..., _ENTRIES]


def spatial_inertias(z: ArrayLike) -> Array:
    """Compute the matrices ``[[E, [mc]×], [-[mc]×, m 1]]`` (..., 6, 6) of parameters (..., 10).

    A body with twist t has the momentum ``M t`` about the origin.
    """
    z = np.asarray(z, dtype=np.float64)
    M = np.zeros((*z.shape[:-1], 6, 6))
    M[..., :3, :3] = inertia_tensor(z)
    M[..., :3, 3:] = skew(z[..., 1:4])
    M[..., 3:, :3] = -M[..., :3, 3:]
    M[..., [3, 4, 5], [3, 4, 5]] = z[..., :1]
    return M


def pseudo_inertia(z: ArrayLike) -> Array:
    """Compute pseudo-inertias ``[[½ tr(E) 1 - E, mc], [mcᵀ, m]]``, linear in z.

    They are positive definite for bodies that can exist (P. M. Wensing, S. Kim and
    J.-J. Slotine, 2018).

    Args:
        z: inertial parameters (..., 10) about the origin, SI units.

    Returns:
        Symmetric matrices (..., 4, 4).

    Example:
        >>> import balance
        >>> balance.bodies.pseudo_inertia([2, 0, 0, 2, 3, 3, 1, 0, 0, 0]).diagonal().tolist()
        [0.5, 0.5, 2.5, 2.0]
    """
    z = np.asarray(z, dtype=np.float64)
    return np.asarray(z @ _MATRICES).reshape(*z.shape[:-1], 4, 4)


def from_pseudo_inertia(P: ArrayLike) -> Array:
    """Compute parameters (..., 10) of pseudo-inertias (..., 4, 4); inverts `pseudo_inertia`."""
    P = np.asarray(P, dtype=np.float64)
    return np.asarray(P.reshape(*P.shape[:-2], 16) @ _PARAMETERS)


def displace_parameters(z: ArrayLike, H: ArrayLike) -> Array:
    """Displace bodies: ``P → H P Hᵀ`` of their pseudo-inertias, about the same origin.

    Args:
        z: inertial parameters (..., 10).
        H: displacements (..., 4, 4), or other affine maps, such as a change of units.

    Returns:
        Parameters of the displaced bodies (..., 10).
    """
    H = np.asarray(H, dtype=np.float64)
    return from_pseudo_inertia(H @ pseudo_inertia(z) @ H.mT)
