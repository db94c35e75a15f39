"""Energies of springs and of gravity, differentiated along the motions of a linkage.

A spring of stiffness k and free length L between points a of link A and b of link B stores

    U = ½ k (|p_A - p_B| - L)² = ½ k |p_A - p_B|² - k L |p_A - p_B| + ½ k L²,    p_A = H_A a:

linear in k and k L for given points. Springs that may be attached elsewhere have L = 0. Where b
may be chosen, ``b = c + Σ_j s_j e_j`` with |p_B| turning rigidly, and

    ∂U/∂u_w = k (p_A - p_C)·(v_A - v_C) - Σ_j k s_j [(v_A - v_C)·n_j + (p_A - p_C)·(ω_B × n_j)]

with n_j the turned e_j: linear in k and in k s_j. Where the other end is free too, at ``a = d +
Σ_i r_i f_i``, products ``k r_i s_j`` join them, with ``-∂(m_i·n_j)/∂u_w``, m_i the turned f_i.
Gravity stores ``-g · Σ (m d + R mc)``. With
springs of positive k only, and |s_j| ≤ 1, the unknowns (k, k s) form a convex cone. (S. K.
Agrawal, A. Fattah, Mechanism and Machine Theory 39, 2004; S. R. Deepak, G. K. Ananthasuresh,
Journal of Mechanisms and Robotics 4, 2012.)
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from balance.masses.springs.attached_springs import AttachedEnd, AttachedSpring
from balance.motion.verification.holding_torques import Weights, gravity_gradient
from kinematics.closure.newton import Pose, expand_at
from kinematics.model.arrays import Chain
from kinematics.model.linkage import GROUND
from kinematics.numerics.array_types import Array


def gradient_rows(
    chain: Chain, pose: Pose, springs: Sequence[AttachedSpring], weights: Weights
) -> Array:
    """Differentiate the energies at a closed pose along all columns of the motion.

    Returns:
        Shape (w, unknowns + 1): for each spring the columns of its unknowns, in units of
        the squared length of the chain, J per N m⁻¹ times length⁻²; last that of gravity, J.
    """
    T = expand_at(chain, pose).T[0, 0]
    columns: list[Array] = []
    for spring in springs:
        columns += _spring_columns(pose, T, spring)
    columns.append(gravity_gradient(pose, T, weights))
    return np.stack(columns, axis=1)


def point_at(pose: Pose, end: AttachedEnd, shares: Array) -> Array:
    """Compute where the end of a spring is in a pose (3,).

    Args:
        pose: the pose.
        end: the end.
        shares: coordinates s in its box (free,).
    """
    point = end.middle + shares @ end.axes
    if end.link == GROUND:
        return np.asarray(point)
    return np.asarray(pose.H[end.link, :3, :3] @ point + pose.H[end.link, :3, 3])


def _spring_columns(pose: Pose, T: Array, spring: AttachedSpring) -> list[Array]:
    """Differentiate the energy of a spring: columns (w,) of k, and of k s_j or k L."""
    points, rates, turns = zip(
        *(_middle_motion(pose, T, end) for end in spring.ends), strict=True
    )
    apart, away = points[0] - points[1], rates[0] - rates[1]
    (low, high), distance = spring.lengths, float(np.linalg.norm(apart))
    # Where the ends meet, the distance has no derivative, and the force no direction.
    stretch = away @ apart / (distance or np.inf)
    columns = [away @ apart - 0.5 * (low + high) * stretch]
    if spring.any_length:
        columns.append(-0.5 * (high - low) * stretch)
    axes = []
    for sign, end, turn in zip((1.0, -1.0), spring.ends, turns, strict=True):
        R = np.eye(3) if end.link == GROUND else pose.H[end.link, :3, :3]
        axes.append(end.axes @ R.T)
        for axis in axes[-1]:
            columns.append(sign * (away @ axis + np.cross(turn, axis) @ apart))
    for first in axes[0]:
        for second in axes[1]:
            turned = np.cross(turns[0], first) @ second + np.cross(turns[1], second) @ first
            columns.append(-turned)
    return columns


def _middle_motion(pose: Pose, T: Array, end: AttachedEnd) -> tuple[Array, Array, Array]:
    """Compute the middle of an end, its velocities and the angular ones for unit rates."""
    point = point_at(pose, end, np.zeros(len(end.axes)))
    still = np.zeros((T.shape[1], 3))
    if end.link == GROUND:
        return point, still, still
    turn, rate = T[end.link, :, :3], T[end.link, :, 3:]
    return point, rate + np.cross(turn, point), turn
