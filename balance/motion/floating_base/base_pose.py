"""The pose of a base as numbers that are integrated: in a plane or in space.

The coordinates x are an angle and a displacement in the axes of the plane (3,), or a quaternion
and a displacement (7,). With the twist ``S β = [ω; v]`` of the base in its own coordinates

    Ṙ = R ω̂        ṗ = R v.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.motion.floating_base.base import BaseInChain
from balance.motion.floating_base.dynamics import cross_products

Array = NDArray[np.float64]


class Placement(NamedTuple):
    """The base at a time; displacements in units of the chain.

    Attributes:
        R: rotation from its axes to inertial axes (3, 3).
        p: displacement of the origin of the chain (3,), in inertial axes.
        rotation: rotation vector (3,), radians; the angle counts full turns in a plane.
    """

    R: Array
    p: Array
    rotation: Array

    def wrench_to_inertial(self, wrench: Array) -> Array:
        """Convert ``[moment; force]`` (6,) of the base to inertial axes and origin."""
        force = self.R @ wrench[3:]
        return np.concatenate([self.R @ wrench[:3] + cross_products(self.p, force), force])

    def moved(self, point: Array) -> Array:
        """Compute the displacement (3,) of a point of the base, inertial axes."""
        return self.R @ point + self.p - point

    def spring_wrench(self, base: BaseInChain) -> Array:
        """Compute the wrench of the springs on the base (6,), in its coordinates."""
        if not (base.stiffness or base.turning_stiffness):
            return np.zeros(6)
        force = -base.stiffness * self.R.T @ self.moved(base.com)
        # The rotation vector has the same components in both axes.
        moment = cross_products(base.com, force) - base.turning_stiffness * self.rotation
        return np.concatenate([moment, force])

    def spring_energy(self, base: BaseInChain) -> float:
        """Compute the energy in the springs."""
        moved, turned = self.moved(base.com), self.rotation
        return 0.5 * float(
            base.stiffness * moved @ moved + base.turning_stiffness * turned @ turned
        )


def pose_size(base: BaseInChain) -> int:
    """Count the coordinates of a pose: 3 in a plane, 7 in space."""
    return 3 if base.planar else 7


def start_pose(base: BaseInChain) -> Array:
    """Return the coordinates of the pose at the start (3 or 7,)."""
    x = np.zeros(pose_size(base))
    if not base.planar:
        x[0] = 1.0
    return x


def place_base(base: BaseInChain, x: Array) -> Placement:
    """Compute the pose at coordinates.

    Args:
        x: coordinates (3 or 7,).
    """
    if base.planar:
        n, plane = base.freedoms[:3, 0], base.freedoms[3:, 1:]
        c, sine = np.cos(x[0]), np.sin(x[0])
        R = np.outer(n, n) + plane @ np.array([[c, -sine], [sine, c]]) @ plane.T
        return Placement(R, plane @ x[1:], x[0] * n)
    a, *v = (x[:4] / np.sqrt(x[:4] @ x[:4])).tolist()
    i, j, k = v
    R = np.array([
        [1.0 - 2.0 * (j * j + k * k), 2.0 * (i * j - a * k), 2.0 * (i * k + a * j)],
        [2.0 * (i * j + a * k), 1.0 - 2.0 * (i * i + k * k), 2.0 * (j * k - a * i)],
        [2.0 * (i * k - a * j), 2.0 * (j * k + a * i), 1.0 - 2.0 * (i * i + j * j)],
    ])  # fmt: skip
    return Placement(R, x[4:], _rotation_vector(a, np.array(v)))


def _rotation_vector(a: float, v: Array) -> Array:
    """Compute the rotation vector, of at most half a turn, of a unit quaternion [a; v]."""
    if a < 0.0:
        a, v = -a, -v
    sine = float(np.sqrt(v @ v))
    # sin x / x is 1 to round-off below this size.
    return 2.0 * v if sine < 1e-9 else (2.0 * np.arctan2(sine, a) / sine) * v


def pose_rate(base: BaseInChain, x: Array, R: Array, beta: Array) -> Array:
    """Compute the rates of the coordinates of a pose.

    Args:
        x: coordinates (3 or 7,).
        R: rotation there (3, 3).
        beta: rates of the freedoms of the base (3 or 6,).
    """
    b = base.freedoms @ beta
    moved = R @ b[3:]
    if base.planar:
        return np.concatenate([beta[:1], moved @ base.freedoms[3:, 1:]])
    a, v, omega = x[0], x[1:4], b[:3]
    turned = 0.5 * (a * omega + cross_products(v, omega))
    return np.concatenate([[-0.5 * (v @ omega)], turned, moved])
