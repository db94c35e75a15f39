"""The motion of a base and its linkage at the steps of the integration, in SI units."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from balance.motion.floating_base.equations import BaseEquations, BaseState
from kinematics.model.arrays import Chain, freeze
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.vectors import cross_products


class Samples(NamedTuple):
    """What is known at each step; vectors in inertial axes.

    Attributes:
        u: displacements of the inputs from the reference pose (N, mobility).
        ud: their velocities.
        rotation: rotation vector of the base (N, 3), radians.
        displacement: of its centre of mass (N, 3), metres.
        turning: its angular velocity (N, 3), rad/s.
        velocity: of its centre of mass (N, 3), m/s.
        kinetic: kinetic energy of linkage and base (N,), joules.
        spring: energy in the springs (N,), joules.
        work: of the drives since the start (N,), joules.
        momentum: of linkage and base in the freedoms of the base (N, 3 or 6), about the middle
            of the mechanism at the start, in kg and units of the chain.
        impulse: of the springs in them since the start (N, 3 or 6), likewise.
        momentum_size: sum of the sizes of the momenta of base and bodies (N,), likewise.
        speed: largest size of the twist of a body relative to the base (N,), likewise.
        twist: twist of the base in its own coordinates (N, 6), likewise.
    """

    u: Array
    ud: Array
    rotation: Array
    displacement: Array
    turning: Array
    velocity: Array
    kinetic: Array
    spring: Array
    work: Array
    momentum: Array
    impulse: Array
    momentum_size: Array
    speed: Array
    twist: Array


def take_samples(
    equations: BaseEquations, chain: Chain, times: Array, states: Array
) -> Samples:
    """Compute the samples at states.

    Args:
        equations: the equations; their linkage is at its first pose.
        chain: the arrays of the linkage.
        times: times (N,).
        states: states (N, size).
    """
    rows = [
        _sample(equations, chain, equations.read(time, state))
        for time, state in zip(times.tolist(), states, strict=True)
    ]
    columns = [np.array(column) for column in zip(*rows, strict=True)]
    samples = Samples(*columns)
    if not equations.base.planar:
        samples = samples._replace(rotation=_unwrap(samples.rotation))
    return Samples(*(freeze(column) for column in samples))


def _sample(equations: BaseEquations, chain: Chain, now: BaseState) -> Iterator[object]:
    """Yield the entries of `Samples` at one time."""
    base, L, units = equations.base, chain.frame.length, equations.drive.units
    R, b = now.placement.R, now.b
    h = now.bodies.momenta(b)
    carried = base.M @ b
    whole = now.placement.wrench_to_inertial(h.sum(axis=0) + carried)
    yield now.u * units
    yield (equations.drive.basis @ now.rates) * units
    yield now.placement.rotation
    yield L * now.placement.moved(base.com)
    yield R @ b[:3]
    yield L * (R @ (b[3:] + cross_products(b[:3], base.com)))
    yield L**2 * now.bodies.kinetic_energy(base, b)
    yield L**2 * now.placement.spring_energy(base)
    yield L**2 * now.work
    yield base.freedoms.T @ whole
    yield now.impulse
    yield np.linalg.norm(h, axis=1).sum() + np.linalg.norm(carried)
    yield np.linalg.norm(now.bodies.V, axis=1).max(initial=0.0)
    yield b


def _unwrap(rotation: Array) -> Array:
    """Add full turns to rotation vectors (N, 3), so that they change continuously."""
    vectors = rotation.copy()
    for k in range(1, len(vectors)):
        angle = float(np.linalg.norm(vectors[k]))
        if angle == 0.0:
            continue
        axis = vectors[k] / angle
        turns = np.round((axis @ vectors[k - 1] - angle) / (2.0 * np.pi))
        vectors[k] += 2.0 * np.pi * turns * axis
    return vectors
