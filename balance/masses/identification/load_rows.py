"""Measured loads as linear functions of the inertial parameters, along a motion.

The base exerts the wrench ``w = ḣ - g`` on a linkage: the rate of its momentum, less the wrench
of gravity on it. Both are linear in the parameters of the bodies. A drive exerts the torque

    τ_w = Σ_b T_bw · (ḣ_b - g_b)

with the twist ``T_bw`` of body b for a unit rate of input w, since ideal joints do no work, and
so in closed loops too. At a pose with the displacement ``[[R, d], [0, 1]]`` of a body,

    g_b = [R mc + m d] × g   (moment),   m g   (force).

(C. G. Atkeson, C. H. An, J. M. Hollerbach, International Journal of Robotics Research 5(3),
1986; for loops: W. Khalil, E. Dombre, Modeling, Identification and Control of Robots, 2002.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.motion.verification.shaking_wrench import motion_in_chain
from balance.motion.verification.trajectory import Trajectory
from balance.space.momentum.regressor import RegressorSeries
from kinematics.closure.joint_positions import input_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.screws import skew
from kinematics.numerics.array_types import Array


class LoadRows(NamedTuple):
    """Rows that give loads from parameters (bodies · 10,) in the units of the chain.

    Attributes:
        shaking: wrench ``[force; moment]`` without gravity (N, 6, parameters), N and N m.
        weight: the same of gravity on the linkage.
        drives: torques of the inputs with gravity (N, inputs, parameters), N m or N.
        bodies: number of bodies.
    """

    shaking: Array
    weight: Array
    drives: Array

    @property
    def bodies(self) -> int:
        """Number of bodies."""
        return self.shaking.shape[2] // 10

    @property
    def wrench(self) -> Array:
        """Wrench of the base on the linkage (N, 6, parameters)."""
        return self.shaking - self.weight


def load_rows(
    linkage: Linkage, trajectory: Trajectory, gravity: Array, about: Array
) -> LoadRows:
    """Compute the loads of a linkage as linear functions of its parameters.

    Args:
        trajectory: a motion of N samples.
        gravity: acceleration of gravity in the inertial frame (3,), m/s².
        about: point of the moments (3,), metres.
    """
    chain = input_chain(linkage)
    units = chain.units[linkage.positions_of(linkage.inputs)]
    length, bodies = chain.frame.length, chain.links.size
    shaking, weight = np.empty((2, trajectory.time.size, 6, bodies, 10))
    drives = np.empty((trajectory.time.size, units.size, bodies, 10))
    q, ud, udd = motion_in_chain(linkage, chain, trajectory)
    for k in range(trajectory.time.size):
        shaking[k], weight[k], twists = _one_sample(
            chain, q[k], ud[k], udd[k], gravity / length
        )
        drives[k] = np.einsum("bwi,ibp->wbp", twists, shaking[k] - weight[k])
    drives *= (length**2 / units)[:, None, None]
    flat = len(shaking), 6, 10 * bodies
    return LoadRows(
        _to_si(shaking.reshape(flat), chain, about),
        _to_si(weight.reshape(flat), chain, about),
        drives.reshape(len(drives), units.size, 10 * bodies),
    )


def _one_sample(
    chain: Chain, q: Array, ud: Array, udd: Array, gravity: Array
) -> tuple[Array, Array, Array]:
    """Compute rows at one sample, in units of the chain.

    Returns:
        Rate of momentum (6, bodies, 10), wrench of gravity likewise, and twists of the bodies
        for unit rates (bodies, inputs, 6).
    """
    pose = forward_kinematics(chain, q)
    series = expand_from(chain, pose.screws, ud[None], 1)
    steady, changing = (
        RegressorSeries(chain, series, pose=pose).rows(1)[:, 0].reshape(2, ud.size, -1)
    )
    bodies = chain.links.size
    rate = (udd @ steady + ud @ changing).reshape(6, bodies, 10)
    weight, twists = np.zeros((6, bodies, 10)), np.zeros((bodies, ud.size, 6))
    for b, link in enumerate(chain.links.tolist()):
        H = pose.H[link] if link >= 0 else np.eye(4)
        # Moments r × g = -g × r of the mass at d and of the first moments along R.
        weight[:3, b, :4] = -skew(gravity) @ np.column_stack([H[:3, 3], H[:3, :3]])
        weight[3:, b, 0] = gravity
        if link >= 0:
            twists[b] = series.T[0, 0, link]
    return rate, weight, twists


def _to_si(rows: Array, chain: Chain, about: Array) -> Array:
    """Convert wrenches ``[moment; force]`` of the chain (N, 6, …) to ``[force; moment]``."""
    frame = chain.frame
    force = frame.length * rows[:, 3:]
    moment = frame.length**2 * rows[:, :3]
    moment = moment + np.einsum("ij,njp->nip", skew(frame.origin - about), force)
    return np.concatenate([force, moment], axis=1)
