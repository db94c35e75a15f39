"""Loads that sensors would measure, by other routes than the packages under test.

Of a linkage with loops, the momentum of point masses at finite poses (`reference`) is
differentiated in time by differences. Of an open chain, Pinocchio computes the base reaction
and the torques by the recursive Newton-Euler algorithm. Both are linear in the inertial
parameters ``[m, mc, E]`` of the bodies about the inertial origin.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pinocchio as pin

from tests.independent import reference
from tests.independent.reference_model import Mechanism

# Central differences of order six: offsets in steps, and their weights.
OFFSETS = np.array([-3, -2, -1, 1, 2, 3])
WEIGHTS = np.array([-1, 9, -45, 45, -9, 1]) / 60.0
# Step over the time between samples.
STEP = 0.02


def load_regressor(
    mechanism: Mechanism, path: Callable[[Any], Any], time: Any, gravity: Any
) -> Any:
    """Wrench of the base on the linkage per parameter, ``[force; moment]`` about the origin.

    Args:
        mechanism: the linkage, nb bodies.
        path: displacements and velocities of the inputs, in the order of the mechanism, at a
            time.
        time: samples (N,), evenly spaced.
        gravity: acceleration of gravity (3,).

    Returns:
        Shape (N, 6, 10 nb).
    """
    step = STEP * (time[1] - time[0])
    rows, q = [], np.zeros(len(mechanism.joints))
    for now in time:
        rate = 0.0
        for offset, weight in zip(OFFSETS, WEIGHTS, strict=True):
            u, ud = path(now + step * offset)
            q = reference.follow(mechanism, q, u)
            rates = reference.velocities(mechanism, q, ud[:, None])
            rate = rate + weight * reference.regressor(mechanism, q, rates) / step
        q = reference.follow(mechanism, q, path(now)[0])
        rows.append(rate - weights_of(mechanism, q, gravity))
    return np.roll(np.array(rows), 3, axis=1)


def weights_of(mechanism: Mechanism, q: Any, gravity: Any) -> Any:
    """Wrench of gravity per parameter, ``[moment; force]`` (6, 10 nb)."""
    carried = reference.carried_parameters(mechanism, q)
    found = np.zeros((6, len(carried), 10))
    found[3:] = np.multiply.outer(gravity, carried[:, 0])
    first = carried[:, 1:4].swapaxes(1, 2)
    found[:3] = np.moveaxis(np.cross(first, gravity), 2, 0)
    return found.reshape(6, -1)


class Arm:
    """An open chain in Pinocchio, from the joints that the package reads."""

    def __init__(self, linkage: Any, gravity: Any) -> None:
        """Build the chain; every joint turns, slides or screws."""
        assert not linkage.loops
        self.linkage, self.model = linkage, pin.Model()
        self.model.gravity.linear = np.array(gravity)
        points: list[Any] = []
        for joint in linkage.joints:
            n, v = joint.screw[:3], joint.screw[3:]
            points.append(np.cross(n, v) if n.any() else np.zeros(3))
            before = points[joint.parent] if joint.parent >= 0 else np.zeros(3)
            kind = pin.JointModelPrismaticUnaligned(v)
            if n.any():
                kind = pin.JointModelHelicalUnaligned(n, float(n @ v))
            place = pin.SE3(np.eye(3), points[-1] - before)
            self.model.addJoint(joint.parent + 1, kind, place, joint.name)
        self.points = points

    def loads(self, z: Any, q: Any, qd: Any, qdd: Any) -> tuple[Any, Any]:
        """Wrench of the base ``[force; moment]`` about the origin (N, 6), torques (N, n).

        Args:
            z: parameters of the bodies (nb, 10).
            q: positions of the joints (N, n).
            qd: their velocities.
            qdd: their accelerations.
        """
        for body, own in zip(self.linkage.bodies, z, strict=True):
            m, c, E = own[0], own[1:4] / own[0], own[4:]
            tensor = np.array([[E[0], E[3], E[4]], [E[3], E[1], E[5]], [E[4], E[5], E[2]]])
            central = tensor - m * (c @ c * np.eye(3) - np.outer(c, c))
            inertia = pin.Inertia.Zero()
            inertia.mass, inertia.lever = m, c - self.points[body.link]
            inertia.inertia = central
            self.model.inertias[body.link + 1] = inertia
        data = self.model.createData()
        wrenches, torques = [], []
        for sample in zip(q, qd, qdd, strict=True):
            torques.append(pin.rnea(self.model, data, *sample).copy())
            total = pin.Force.Zero()
            for joint in self.model.children[0]:
                total += data.liMi[joint].act(data.f[joint])
            wrenches.append(total.vector)
        return np.array(wrenches), np.array(torques)
