"""What tests of motions share: states and poses of linkages, derivatives by differences."""

from __future__ import annotations

import numpy as np

import kinematics
from balance.motion.verification.trajectory import Trajectory, drive, random_motions
from kinematics.model.linkage import Linkage
from tests.independent import reference
from tests.support.laws import point_masses, sums

# Central differences of order eight: offsets in steps, and their weights.
OFFSETS = np.arange(-4, 5)
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])


def bodies(linkage, seed=0):
    """Parameters of random bodies, also out of the plane of a planar linkage."""
    rng = np.random.default_rng(seed)
    length = linkage.spatial_chain.frame.length
    return np.array([sums(*point_masses(rng, 6, length)) for _ in linkage.bodies])


def states(linkage: Linkage, count: int, seed: int) -> Trajectory:
    """Random closed states of a linkage: samples of a random motion, at unequal times."""
    (way,) = random_motions(linkage, 1, 200, seed)
    chosen = np.sort(np.random.default_rng(seed).choice(199, count, replace=False))
    parts = (x[chosen] for x in (way.time, way.u, way.ud, way.udd, way.q, way.qd, way.qdd))
    return Trajectory(*parts, closure=way.closure, conditioning=way.conditioning)


def around(linkage: Linkage, way: Trajectory, k: int, step: float) -> Trajectory:
    """The parabola of the inputs that touches a motion at sample k, at nine times."""
    t = step * OFFSETS[:, None]
    u = way.u[k] + t * way.ud[k] + 0.5 * t * t * way.udd[k]
    ud = way.ud[k] + t * way.udd[k]
    return drive(linkage, t[:, 0], u, ud, np.broadcast_to(way.udd[k], u.shape))


def slope(values: np.ndarray, step: float) -> np.ndarray:
    """Derivative in the middle of nine equidistant samples (9, …), of order eight."""
    return np.tensordot(WEIGHTS, values, axes=1) / step


def followed(name, goal):
    """Joint positions by name, from Newton steps of `reference`."""
    mechanism = reference.load(kinematics.gallery()[name])
    at = {joint: k for k, joint in enumerate(kinematics.load(name).inputs)}
    goal = np.array([goal[at[mechanism.joints[i]]] for i in mechanism.inputs])
    q = reference.follow(mechanism, np.zeros(len(mechanism.joints)), goal)
    return mechanism, dict(zip(mechanism.joints, q, strict=True))
