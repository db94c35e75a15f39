"""Screws, twists and wrenches: the Lie algebra se(3) in coordinates.

Component order is angular first: a twist is ``t = [ω; v]``, with v the velocity of the
body point passing through the origin; a wrench or momentum is ``[moment; force]``. All
components are in the inertial frame. Functions broadcast over leading dimensions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import cross_products
from kinematics.numerics.tolerances import SCREW_PART_RELATIVE
from kinematics.wording import number_text, vector_text


def skew(a: ArrayLike) -> Array:
    """Compute the matrix of the cross product: ``skew(a) @ b = a × b``; shape (..., 3, 3)."""
    a = np.asarray(a, dtype=np.float64)
    matrix = np.zeros((*a.shape[:-1], 3, 3))
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = a[..., 0], a[..., 1], a[..., 2]
    return matrix - np.swapaxes(matrix, -1, -2)


def hat(t: ArrayLike) -> Array:
    """Compute the matrix form ``[[ω̂, v], [0, 0]]`` of a twist (..., 6); shape (..., 4, 4)."""
    t = np.asarray(t, dtype=np.float64)
    matrix = np.zeros((*t.shape[:-1], 4, 4))
    matrix[..., :3, :3] = skew(t[..., :3])
    matrix[..., :3, 3] = t[..., 3:]
    return matrix


def vee(matrix: ArrayLike) -> Array:
    """Compute the twist (..., 6) of a matrix (..., 4, 4), the inverse of `hat`.

    The symmetric part of the rotation block is ignored.
    """
    m = np.asarray(matrix, dtype=np.float64)
    turn = 0.5 * (m - np.swapaxes(m, -1, -2))
    entries = turn[..., 2, 1], turn[..., 0, 2], turn[..., 1, 0]
    return np.concatenate([np.stack(entries, axis=-1), m[..., :3, 3]], axis=-1)


def ad(t: ArrayLike) -> Array:
    """Compute the matrix of the Lie bracket of twists (..., 6); shape (..., 6, 6).

    ``ad(a) b = [ω_a × ω_b; v_a × ω_b + ω_a × v_b]``, the rate of change of a twist b that
    is carried by a body moving with twist a.
    """
    t = np.asarray(t, dtype=np.float64)
    matrix = np.zeros((*t.shape[:-1], 6, 6))
    matrix[..., :3, :3] = matrix[..., 3:, 3:] = skew(t[..., :3])
    matrix[..., 3:, :3] = skew(t[..., 3:])
    return matrix


def Ad(H: ArrayLike) -> Array:  # noqa: N802 - the name of the field
    """Compute the adjoint matrix of a displacement H (..., 4, 4); shape (..., 6, 6).

    ``Ad(H) t`` is the twist t, carried along by the displacement:
    ``hat(Ad(H) t) = H hat(t) H⁻¹``. Wrenches transform with ``Ad(H)⁻ᵀ``.
    """
    H = np.asarray(H, dtype=np.float64)
    R = H[..., :3, :3]
    matrix = np.zeros((*H.shape[:-2], 6, 6))
    matrix[..., :3, :3] = matrix[..., 3:, 3:] = R
    matrix[..., 3:, :3] = skew(H[..., :3, 3]) @ R
    return matrix


def bracket_twists(a: Array, t: Array) -> Array:
    """Compute ``ad(a) t`` of twists (..., 6) without the matrix; see `ad`.

    Args:
        a: twists of the bodies that carry the others along (..., 6).
        t: twists that are carried along (..., 6).
    """
    turned = cross_products(a[..., None, :3], t.reshape(*t.shape[:-1], 2, 3))
    rates = turned.reshape(*turned.shape[:-2], 6)
    rates[..., 3:] += cross_products(a[..., 3:], t[..., :3])
    return rates


def carry_twists(H: Array, t: Array) -> Array:
    """Compute ``Ad(H) t`` of displacements (..., 4, 4) and twists (..., 6); see `Ad`."""
    parts = t.reshape(*t.shape[:-1], 2, 3) @ H[..., :3, :3].mT
    carried = parts.reshape(*parts.shape[:-2], 6)
    carried[..., 3:] += cross_products(H[..., :3, 3], carried[..., :3])
    return carried


def turn_momenta(t: Array, h: Array) -> Array:
    """Compute ``-ad(t)ᵀ h``, the rates of momenta (..., 6) that twists (..., 6) carry along."""
    rates = cross_products(t[..., None, :3], h.reshape(*h.shape[:-1], 2, 3)).reshape(h.shape)
    rates[..., :3] += cross_products(t[..., 3:], h[..., 3:])
    return rates


def revolute(axis: ArrayLike, point: ArrayLike, pitch: float = 0.0) -> Array:
    """Compute the screw ``[n; r × n + λ n]`` of a revolute or helical joint; shape (6,).

    Args:
        axis: direction of any length; normalised here.
        point: a point r on the axis, in metres.
        pitch: λ, in metres per radian.
    """
    a = np.asarray(axis, dtype=np.float64)
    n = a / np.linalg.norm(a)
    return np.concatenate([n, np.cross(np.asarray(point, dtype=np.float64), n) + pitch * n])


def prismatic(axis: ArrayLike) -> Array:
    """Compute the screw ``[0; n]`` (6,) of a prismatic joint; its axis may have any length."""
    a = np.asarray(axis, dtype=np.float64)
    return np.concatenate([np.zeros(3), a / np.linalg.norm(a)])


def exp(screw: ArrayLike, q: ArrayLike) -> Array:
    """Compute the displacement ``exp(q ŝ)`` of a joint; shape (..., 4, 4).

    For a screw whose angular part is a unit vector or zero, ``ŝ⁴ = -ŝ²``, so that

        exp(q ŝ) = 1 + q ŝ + (1 - cos q) ŝ² + (q - sin q) ŝ³

    holds for revolute, prismatic (``ŝ² = 0``) and helical joints alike.

    Args:
        screw: unit screws (..., 6).
        q: positions (...), in radians, or in metres for prismatic joints.
    """
    s = hat(screw)
    q = np.asarray(q, dtype=np.float64)[..., None, None]
    s2 = s @ s
    half = np.sin(0.5 * q)
    return np.eye(4) + q * s + 2.0 * half * half * s2 + (q - np.sin(q)) * (s2 @ s)


@dataclass(frozen=True, eq=False)
class ScrewAxis:
    """The line of a twist or of a wrench.

    Attributes:
        direction: unit vector; zero for a vanishing screw.
        point: the point of the line nearest to the origin, in metres; zero at infinite
            pitch, where the screw is a free vector.
        pitch: metres per radian; exactly 0 for a pure rotation or force, ``inf`` for a
            pure translation or couple.
        magnitude: length of the part that defines the line.
    """

    direction: Array
    point: Array
    pitch: float
    magnitude: float

    def __repr__(self) -> str:
        """Give one line: point, direction, pitch and magnitude."""
        where = f"through {vector_text(self.point)} m along {vector_text(self.direction)}"
        return (
            f"ScrewAxis {where}, pitch {number_text(self.pitch)} m, magnitude "
            f"{number_text(self.magnitude)}"
        )


def _line_of_screw(line: Array, moment: Array, tolerance: float) -> ScrewAxis:
    """Compute the axis of the screw with the line vector ``line`` and the moment ``moment``."""
    size, other = float(np.linalg.norm(line)), float(np.linalg.norm(moment))
    if size <= tolerance * other or size == 0.0:
        direction = moment / other if other > 0.0 else np.zeros(3)
        return ScrewAxis(direction, np.zeros(3), np.inf if other > 0.0 else 0.0, other)
    n = line / size
    along = float(n @ moment)
    pitch = 0.0 if abs(along) <= tolerance * other else along / size
    return ScrewAxis(n, np.cross(n, moment) / size, pitch, size)


def twist_axis(t: ArrayLike, tolerance: float = SCREW_PART_RELATIVE) -> ScrewAxis:
    """Compute the instantaneous screw axis of a twist ``[ω; v]``.

    Direction ω/|ω|, point ``ω × v / |ω|²``, pitch ``ω·v / |ω|²``.

    Args:
        t: twist, shape (6,).
        tolerance: relative size below which ω, or the part of v along it, counts as zero.
    """
    t = np.asarray(t, dtype=np.float64)
    return _line_of_screw(t[:3], t[3:], tolerance)


def wrench_axis(w: ArrayLike, tolerance: float = SCREW_PART_RELATIVE) -> ScrewAxis:
    """Compute the central axis of a wrench or momentum ``[ξ; p]``.

    Direction p/|p|, point ``p × ξ / |p|²``, pitch ``p·ξ / |p|²``.

    Args:
        w: wrench or momentum, moment first, shape (6,).
        tolerance: relative size below which p, or the part of ξ along it, counts as zero.
    """
    w = np.asarray(w, dtype=np.float64)
    return _line_of_screw(w[3:], w[:3], tolerance)
