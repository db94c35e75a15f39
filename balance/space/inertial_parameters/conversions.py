"""Inertial parameters: conversions, frames, and whether a body with them can exist.

``z = [m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the origin, as in
`kinematics.model.spatial.inertia`; in a plane ``[m, mcx, mcy, Ezz]``; for force balance without
E.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.support.tolerances import PHYSICAL_INEQUALITY
from kinematics.model.arrays import Frame
from kinematics.model.spatial.inertia import (
    inertia_tensor,
)
from kinematics.model.spatial.inertia import parameters as parameters
from kinematics.model.spatial.inertia import pseudo_inertia as pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.wording import vector_text

LABELS = ("m", "mcx", "mcy", "mcz", "Exx", "Eyy", "Ezz", "Exy", "Exz", "Eyz")
PLANAR_LABELS = ("m", "mcx", "mcy", "Ezz")


class MassProperties(NamedTuple):
    """Mass properties of a body.

    Attributes:
        mass: kg.
        com: centre of mass (3,), metres.
        inertia: tensor about the centre of mass (3, 3), kg m².
    """

    mass: float
    com: Array
    inertia: Array

    def __repr__(self) -> str:
        """One line: mass, centre of mass, moments of inertia about the axes."""
        moments = vector_text(np.diagonal(self.inertia))
        return (
            f"MassProperties: {self.mass:.4g} kg at {vector_text(self.com)} m, {moments} kg m²"
        )


def mass_properties(z: ArrayLike) -> MassProperties:
    """Compute mass, centre of mass and central inertia of inertial parameters.

    ``I = E - m (c·c 1 - c cᵀ)`` with ``c = mc / m``, the inverse of `parameters`.

    Args:
        z: parameters ``[m, mc, E]`` (10,) about the origin, SI units; the mass is not 0.

    Returns:
        Mass, centre of mass and inertia tensor about it, in the axes of z.

    Source:
        The parallel axis theorem.

    Example:
        >>> import balance
        >>> balance.bodies.mass_properties([2, 0, 0, 2, 3, 3, 1, 0, 0, 0])
        MassProperties: 2 kg at (0, 0, 1) m, (1, 1, 1) kg m²
    """
    z = np.asarray(z, dtype=np.float64)
    c = z[1:4] / z[0]
    inertia = inertia_tensor(z) - z[0] * (c @ c * np.eye(3) - np.outer(c, c))
    return MassProperties(float(z[0]), c, inertia)


def violations(
    z: ArrayLike, tolerance: float = PHYSICAL_INEQUALITY, floor: float = 0.0
) -> list[str]:
    """List the inequalities of physical bodies that inertial parameters violate.

    A body can exist if and only if its pseudo-inertia is positive semidefinite, which is
    the same as ``m ≥ 0``, principal moments about the centre of mass that are not negative,
    and the three triangle inequalities between them.

    Args:
        z: parameters (10,) about the origin, SI units.
        tolerance: part of the largest moment by which rounding may violate them.
        floor: moment by which it may violate them in any case, kg m².

    Returns:
        One readable inequality each; empty for a physical body.

    Source:
        P. M. Wensing, S. Kim, J.-J. Slotine, IEEE Robotics and Automation Letters 3(1), 2018.

    Example:
        >>> import balance
        >>> balance.bodies.violations([1, 0, 0, 0, 1, 1, 3, 0, 0, 0])
        ['principal moments 1 + 1 < 3']
    """
    z = np.asarray(z, dtype=np.float64)
    if z[0] < 0.0:
        return [f"mass {z[0]:.6g} kg is negative"]
    if z[0] == 0.0 and z[1:4].any():
        return ["mass is zero, but its centre is not at the origin"]
    inertia = mass_properties(z).inertia if z[0] > 0.0 else inertia_tensor(z)
    moments = np.linalg.eigvalsh(inertia)
    largest = max(float(np.abs(moments).max()), float(np.abs(z[4:7]).max()))
    slack = max(tolerance * largest, floor)
    faults = [
        f"principal moment {value:.6g} is negative" for value in moments if value < -slack
    ]
    if not faults and moments[0] + moments[1] < moments[2] - slack:
        a, b, c = moments
        faults.append(f"principal moments {a:.6g} + {b:.6g} < {c:.6g}")
    return faults


def parameter_labels(planar: bool, force: bool) -> tuple[str, ...]:
    """List the names of the parameters of one body that count, in order.

    Args:
        planar: whether only motion in the plane counts.
        force: whether only m and mc count.
    """
    labels = PLANAR_LABELS if planar else LABELS
    return labels[: (3 if planar else 4)] if force else labels


def to_chain(z: Array, frame: Frame, planar: bool, force: bool) -> Array:
    """Convert parameters (bodies, 10) from SI units to the coordinates of a chain.

    Args:
        z: parameters about the inertial origin, SI units.
        frame: coordinates of the chain; masses keep their unit.
        planar: whether only motion in the plane counts.
        force: whether only m and mc count.

    Returns:
        The parameters that count (bodies, count).
    """
    if planar:
        n = frame.R[2]
        moment = np.einsum("bij,i,j->b", inertia_tensor(z), n, n)
        z = np.column_stack([z[:, 0], z[:, 1:4] @ frame.R[:2].T, moment])
    count = len(parameter_labels(planar, force))
    scale = 1.0 / frame.length
    G = _affine(scale, -scale * frame.origin, frame.R, planar)
    return z[:, :count] @ G[:count, :count].T


def from_chain(frame: Frame, planar: bool, force: bool) -> Array:
    """Compute the matrix that takes parameters of a body from chain coordinates to SI units.

    Args:
        frame: coordinates of the chain.
        planar: whether only motion in the plane counts.
        force: whether only m and mc count.

    Returns:
        Shape (count, count); parameters in SI units are about the inertial origin, in inertial
        axes or in the axes ``frame.R`` of the plane.
    """
    count = len(parameter_labels(planar, force))
    return _affine(frame.length, frame.origin, frame.R, planar)[:count, :count]


def basis_from_chain(basis: Array, frame: Frame, planar: bool, force: bool) -> Array:
    """Convert columns of parameters of all bodies from chain coordinates to SI units.

    Args:
        basis: the columns (parameters, count).
        frame: coordinates of the chain.
        planar: whether only motion in the plane counts.
        force: whether only m and mc count.
    """
    G = from_chain(frame, planar, force)
    size, count = basis.shape
    return (G @ basis.reshape(size // len(G), len(G), count)).reshape(size, count)


def _affine(L: float, o: Array, R: Array, planar: bool) -> Array:
    """Compute the matrix of parameters under ``x = L x' + o``, so that ``mc = L mc' + m o``.

    A spatial chain keeps the inertial axes; in a plane o is resolved in the axes R.
    """
    if planar:
        ox, oy, _ = (R @ o).tolist()
        return np.array(
            [
                [1.0, 0.0, 0.0, 0.0],
                [ox, L, 0.0, 0.0],
                [oy, 0.0, L, 0.0],
                [ox * ox + oy * oy, 2.0 * L * ox, 2.0 * L * oy, L * L],
            ]
        )
    x, y, z = o.tolist()
    a, b, c = L * x, L * y, L * z
    G = np.zeros((10, 10))
    np.fill_diagonal(G[4:, 4:], L * L)
    G[:, :4] = [
        [1.0, 0.0, 0.0, 0.0],
        [x, L, 0.0, 0.0],
        [y, 0.0, L, 0.0],
        [z, 0.0, 0.0, L],
        [y * y + z * z, 0.0, 2.0 * b, 2.0 * c],
        [x * x + z * z, 2.0 * a, 0.0, 2.0 * c],
        [x * x + y * y, 2.0 * a, 2.0 * b, 0.0],
        [-x * y, -b, -a, 0.0],
        [-x * z, -c, 0.0, -a],
        [-y * z, 0.0, -c, -b],
    ]
    return G
