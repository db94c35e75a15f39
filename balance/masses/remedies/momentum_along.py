"""Momentum of a linkage and its rate along a motion, in inertial axes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.motion.verification.shaking_wrench import (
    inertia_loads,
    mass_parameters,
    motion_in_chain,
    wrench_to_si,
)
from balance.motion.verification.trajectory import Trajectory
from kinematics.closure.joint_positions import input_chain
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array


class Momentum(NamedTuple):
    """Total momentum along a motion, ``[ξ; p]`` about the inertial origin, SI units.

    Attributes:
        total: (N, 6).
        rate: its time derivative (N, 6).
        size: sum over the bodies of the sizes of their own momenta, moments about the middle
            of the mechanism divided by the characteristic length (N,), newton seconds.
    """

    total: Array
    rate: Array
    size: Array


class MovedMasses(NamedTuple):
    """A motion of a linkage, and the momentum of its masses along it."""

    trajectory: Trajectory
    momentum: Momentum


def move_masses(linkage: Linkage, trajectory: Trajectory) -> MovedMasses:
    """Compute the momentum of the masses in the file along a motion, and keep both.

    Args:
        trajectory: a motion of the linkage.
    """
    return MovedMasses(trajectory, momentum_along(linkage, trajectory))


def momentum_along(linkage: Linkage, trajectory: Trajectory) -> Momentum:
    """Compute the total momentum of the masses in the file along a motion.

    Args:
        trajectory: a motion of it.
    """
    chain = input_chain(linkage)
    motion = motion_in_chain(linkage, chain, trajectory)
    loads = inertia_loads(chain, mass_parameters(linkage), *motion)
    total, rate = (
        wrench_to_si(x.sum(axis=1), chain.frame) for x in (loads.momentum, loads.rate)
    )
    size = chain.frame.length * np.linalg.norm(loads.momentum, axis=2).sum(axis=1)
    return Momentum(total, rate, size)
