"""Potential energies of linkages by Pinocchio at closed poses."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from balance.motion.verification.verify_motions import PinocchioModel
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import PoseError

GRAVITY = np.array([0.6, -1.3, 0.4])
POSES, REACH = 50, 0.4


def poses_of(linkage):
    """Closed poses around the reference pose (poses, joints)."""
    rng, poses = np.random.default_rng(7), []
    while len(poses) < POSES:
        try:
            u = rng.uniform(-REACH, REACH, linkage.mobility)
            poses.append(joint_positions(linkage, u))
        except PoseError:
            continue
    return np.array(poses)


def energies(linkage, poses, masses, moments):
    """Potential energy of bodies with masses and first moments (bodies, 3), pose by pose."""
    z = np.zeros((len(linkage.bodies), 10))
    z[:, 0], z[:, 1:4] = masses, moments
    model = PinocchioModel(linkage, z).model
    model.gravity.linear = GRAVITY
    data = model.createData()
    return np.array([pin.computePotentialEnergy(model, data, q) for q in poses])
