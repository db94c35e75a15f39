"""Inertial parameters: conversions, frames, and whether a body with them can exist.

``z = [m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the origin, as in
`kinematics.inertial`; in a plane ``[m, mcx, mcy, Ezz]``; for force balance without E.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinematics.inertial import displaced, inertia_tensor, parameters, pseudo_inertia
from kinematics.linkage import Frame

__all__ = [
    "MassProperties",
    "displaced",
    "from_chain",
    "inertia_tensor",
    "mass_properties",
    "parameter_labels",
    "parameters",
    "pseudo_inertia",
    "selected",
    "violations",
]

Array = NDArray[np.float64]

LABELS = ("m", "mcx", "mcy", "mcz", "Exx", "Eyy", "Ezz", "Exy", "Exz", "Eyz")
PLANAR_LABELS = ("m", "mcx", "mcy", "Ezz")


class MassProperties(NamedTuple):
    """What an engineer calls the mass properties of a body.

    Attributes:
        mass: kg.
        com: centre of mass (3,), metres.
        inertia: tensor about the centre of mass (3, 3), kg m².
    """

    mass: float
    com: Array
    inertia: Array


def mass_properties(z: ArrayLike) -> MassProperties:
    """Mass, centre of mass and central inertia of parameters z (10,); the mass is not 0.

    ``I = E - m (c·c 1 - c cᵀ)``, the inverse of `parameters`.
    """
    z = np.asarray(z, dtype=np.float64)
    c = z[1:4] / z[0]
    inertia = inertia_tensor(z) - z[0] * (c @ c * np.eye(3) - np.outer(c, c))
    return MassProperties(float(z[0]), c, inertia)


def violations(z: ArrayLike, tolerance: float = 1e-9) -> list[str]:
    """The inequalities that a physical body satisfies and these parameters do not.

    A body can exist if and only if its pseudo-inertia is positive semidefinite, which is
    the same as ``m ≥ 0``, principal moments about the centre of mass that are not negative,
    and the three triangle inequalities between them (P. M. Wensing, S. Kim, J.-J. Slotine,
    IEEE Robotics and Automation Letters 3(1), 2018).

    Args:
        z: parameters (10,).
        tolerance: part of the largest moment by which rounding may violate them.

    Returns:
        One readable inequality each; empty for a physical body.
    """
    z = np.asarray(z, dtype=np.float64)
    if z[0] <= 0.0:
        if not z.any():
            return []
        return [f"mass {z[0]:.6g} kg is {'negative' if z[0] < 0.0 else 'zero'}"]
    moments = np.linalg.eigvalsh(mass_properties(z).inertia)
    slack = tolerance * max(float(np.abs(moments).max()), float(np.abs(z[4:7]).max()))
    found = [f"principal moment {value:.6g} is negative" for value in moments if value < -slack]
    if not found and moments[0] + moments[1] < moments[2] - slack:
        a, b, c = moments
        found.append(f"principal moments {a:.6g} + {b:.6g} < {c:.6g}")
    return found


def parameter_labels(planar: bool, force: bool) -> tuple[str, ...]:
    """Names of the parameters of one body that count, in order."""
    labels = PLANAR_LABELS if planar else LABELS
    return labels[: (3 if planar else 4)] if force else labels


def selected(z: ArrayLike, frame: Frame, planar: bool, force: bool) -> Array:
    """Parameters (..., 10) of bodies in the coordinates of a chain, those that count.

    Args:
        z: parameters about the inertial origin, SI units.
        frame: coordinates of the chain; masses keep their unit.
        planar: whether the chain is planar.
        force: whether only m and mc count.
    """
    A = np.eye(4)
    A[:3, :3] = frame.R / frame.length
    A[:3, 3] = -A[:3, :3] @ frame.origin
    moved = displaced(z, A)
    if planar:
        moved = moved[..., [0, 1, 2, 6]]
    return moved[..., : (3 if planar else 4)] if force else moved


def from_chain(frame: Frame, planar: bool, force: bool) -> Array:
    """Matrix that takes the parameters of a body from chain coordinates to SI units.

    They are about the inertial origin; in inertial axes, or in the axes ``frame.R`` of the
    plane. With ``x = L x' + o``: ``mc = L mc' + m o`` and E from the pseudo-inertia.
    """
    L, o = frame.length, frame.origin
    if planar:
        ox, oy = frame.R[:2] @ o
        G = np.array([
            [1.0, 0.0, 0.0, 0.0],
            [ox, L, 0.0, 0.0],
            [oy, 0.0, L, 0.0],
            [ox * ox + oy * oy, 2.0 * L * ox, 2.0 * L * oy, L * L],
        ])  # fmt: skip
        return G[:3, :3] if force else G
    ox, oy, oz = o
    G = np.diag([1.0, L, L, L] + [L * L] * 6)
    G[1:4, 0] = o
    G[4:, 0] = (oy * oy + oz * oz, ox * ox + oz * oz, ox * ox + oy * oy, -ox * oy, -ox * oz, -oy * oz)
    G[4:, 1] = L * np.array([0.0, 2.0 * ox, 2.0 * ox, -oy, -oz, 0.0])
    G[4:, 2] = L * np.array([2.0 * oy, 0.0, 2.0 * oy, -ox, 0.0, -oz])
    G[4:, 3] = L * np.array([2.0 * oz, 2.0 * oz, 0.0, 0.0, -ox, -oy])
    return G[:4, :4] if force else G
