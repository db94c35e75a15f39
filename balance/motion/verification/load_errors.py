"""How far loads can be off along a motion whose inputs are known up to bounds.

The load is ``ḣ = A(u) ü + b(u, u̇)``, with b quadratic in u̇. To first order it is off by

    |Δḣ| ≤ Σ_w |∂ḣ/∂u_w| Δu_w + |∂ḣ/∂u̇_w| Δu̇_w + |A_w| Δü_w

The last two derivatives are differences of exact loads, since those are linear and quadratic.
"""

from __future__ import annotations

import numpy as np

from balance.motion.motion_tolerances import DISPLACEMENT_STEP
from balance.motion.verification.shaking_wrench import (
    inertia_loads,
    motion_in_chain,
    move_wrenches,
    wrench_to_si,
)
from balance.motion.verification.trajectory import Trajectory
from kinematics.closure.newton import forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Moment and force in a wrench.
PARTS = (slice(0, 3), slice(3, 6))


def load_errors(
    linkage: Linkage,
    chain: Chain,
    z: Array,
    trajectory: Trajectory,
    about: Array | None = None,
) -> Array:
    """Bound the errors of the shaking moment and force along a motion from a rounded table.

    Args:
        chain: its joints, from `kinematics.closure.joint_positions.input_chain`.
        z: parameters (bodies, 10) about the inertial origin, SI units.
        trajectory: a motion with bounds on the errors of its inputs.
        about: point for moments, metres, in the inertial frame; the middle of the mechanism by
            default.

    Returns:
        Errors of the moment about that point, N m, and of the force, N (2, N).

    Raises:
        ValueError: the motion is not from a table.
    """
    if (errors := trajectory.errors) is None:
        raise ValueError("the inputs of this motion are exact")
    units = chain.units[linkage.positions_of(linkage.inputs)]
    q, ud, udd = motion_in_chain(linkage, chain, trajectory)
    no_rates, frame = np.zeros_like(ud), chain.frame
    point = frame.origin if about is None else about

    def loads(q: Array, ud: Array, udd: Array) -> Array:
        rate = inertia_loads(chain, z, q, ud, udd).rate.sum(axis=1)
        return move_wrenches(wrench_to_si(rate, frame), point)

    totals = np.zeros((2, len(q)))
    rates = joint_rates(chain, q)
    for w, unit in enumerate(units):
        direction = no_rates + np.eye(units.size)[w]
        step = DISPLACEMENT_STEP * rates[:, :, w]
        derivatives = (
            (loads(q + step, ud, udd) - loads(q - step, ud, udd)) / (2.0 * DISPLACEMENT_STEP),
            0.5 * (loads(q, ud + direction, no_rates) - loads(q, ud - direction, no_rates)),
            loads(q, no_rates, direction),
        )
        bounds = (errors.u, errors.ud, errors.udd)
        for derivative, bound in zip(derivatives, bounds, strict=True):
            sizes = [np.linalg.norm(derivative[:, part], axis=1) for part in PARTS]
            totals += np.array(sizes) * (bound[:, w] / unit)
    return totals


def joint_rates(chain: Chain, q: Array) -> Array:
    """Compute the joint rates for unit rates of each input (N, n, inputs)."""
    still = np.zeros((1, chain.width))
    return np.array(
        [
            expand_from(chain, forward_kinematics(chain, pose).screws, still, 0).C[0, 0]
            for pose in q
        ]
    )
