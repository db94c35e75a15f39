"""What inputs hold against gravity at rest, in the poses of a motion.

Gravity stores ``-g·Σ (m d + R mc)`` with the displacement d, R of each body; its derivative by
an input is what that input has to hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from kinematics.closure.joint_positions import input_chain
from kinematics.closure.newton import Pose, expand_at, forward_kinematics
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Frame
from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.array_types import Array, IntArray
from kinematics.wording import number_text

if TYPE_CHECKING:
    from balance.motion.verification.verification import Verification

# Poses of each motion at which torques are computed.
POSES = 50


class Weights(NamedTuple):
    """Masses that gravity acts on, in the frame and units of a chain.

    Attributes:
        links: rigid body of each (bodies,).
        moments: mass, and mass times centre of mass at the reference pose (bodies, 4).
        gravity: g times the length of the chain (3,), in its axes.
    """

    links: IntArray
    moments: Array
    gravity: Array


class HoldingTorques(NamedTuple):
    """What inputs hold at rest in the poses of motions.

    Attributes:
        gravity: acceleration of gravity (3,), m/s².
        peaks: largest torque, N m, or force, N, of each input, by name.
        scale: weight of the linkage times its characteristic length, N m: what counts as small
            is small beside it.
    """

    gravity: tuple[float, float, float]
    peaks: dict[str, float]
    scale: float

    def __repr__(self) -> str:
        """Give one line: the peaks."""
        listed = ", ".join(f"{name} {number_text(peak)}" for name, peak in self.peaks.items())
        return f"HoldingTorques: up to {listed}"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {"gravity": list(self.gravity), "peaks": dict(self.peaks)}


def weights_of(linkage: Linkage, frame: Frame, gravity: Array) -> Weights:
    """Collect the weights of a linkage."""
    bodies = [body for body in linkage.bodies if body.link != GROUND]
    inertia = np.array([body.inertia[:4] for body in bodies]).reshape(-1, 4)
    m, mc = inertia[:, :1], inertia[:, 1:]
    moments = np.hstack([m, (mc - m * frame.origin) @ frame.R.T / frame.length])
    links = np.array([body.link for body in bodies], dtype=np.int64)
    return Weights(links, moments, frame.length * (frame.R @ gravity))


def gravity_gradient(pose: Pose, T: Array, weights: Weights) -> Array:
    """Differentiate the energy of gravity along the columns of a motion (w,), J.

    Args:
        pose: a closed pose.
        T: twists of all links for the columns there (links, w, 6).
        weights: the masses.
    """
    turned = np.einsum("bij,bj->bi", pose.H[weights.links, :3, :3], weights.moments[:, 1:])
    turned += weights.moments[:, :1] * pose.H[weights.links, :3, 3]
    twists = T[weights.links]
    rates = weights.moments[:, :1, None] * twists[:, :, 3:]
    rates = rates + np.cross(twists[:, :, :3], turned[:, None])
    return np.asarray(-(rates.sum(axis=0) @ weights.gravity))


def holding_torques(linkage: LinkageLike, q: ArrayLike, gravity: Sequence[float]) -> Array:
    """Compute what the inputs hold at rest against gravity.

    Args:
        linkage: the linkage, or what `kinematics.load` accepts, with its masses.
        q: closed positions of all joints (poses, joints), radians and metres.
        gravity: acceleration of gravity (3,), m/s², inertial frame.

    Returns:
        Torques, N m, and forces, N (poses, inputs): derivatives of the potential energy.

    Raises:
        UsageError: gravity has not three finite coordinates.

    Example:
        >>> import balance, kinematics
        >>> linkage = kinematics.load("robot.urdf")
        >>> q = [[0.0] * len(linkage.joints)]
        >>> balance.motion.holding_torques(linkage, q, (0, -9.81, 0)).shape
        (1, 1)
    """
    linkage = as_linkage(linkage)
    g = np.asarray(gravity, dtype=np.float64)
    if g.shape != (3,) or not np.isfinite(g).all():
        raise UsageError(f"gravity has three coordinates, not {gravity!r}")
    chain = input_chain(linkage)
    weights = weights_of(linkage, chain.frame, g)
    at = linkage.positions_of(linkage.inputs)
    torques = []
    for positions in np.asarray(q, dtype=np.float64):
        pose = forward_kinematics(chain, positions / chain.units)
        torques.append(gravity_gradient(pose, expand_at(chain, pose).T[0, 0], weights))
    return np.reshape(torques, (-1, len(at))) / chain.units[at]


def holding_along(verification: Verification, gravity: Sequence[float]) -> HoldingTorques:
    """Compute the largest torques that hold a linkage in the poses of a verification.

    Args:
        verification: the linkage and its motions.
        gravity: acceleration of gravity (3,), m/s², inertial frame.
    """
    linkage = verification.linkage
    peaks = np.zeros(len(linkage.inputs))
    for run in verification.runs:
        q = run.trajectory.q[:: max(1, len(run.trajectory.q) // POSES)]
        peaks = np.maximum(peaks, np.abs(holding_torques(linkage, q, gravity)).max(axis=0))
    mass = sum(float(body.inertia[0]) for body in linkage.bodies)
    x, y, z = map(float, gravity)
    return HoldingTorques(
        (x, y, z),
        dict(zip(linkage.inputs, peaks.tolist(), strict=True)),
        mass * float(np.linalg.norm(gravity)) * verification.length,
    )
