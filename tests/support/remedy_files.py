"""Tables of remedies, and the momentum of their files by Pinocchio and by finite poses."""

from __future__ import annotations

import csv
import io

import numpy as np
from scipy.linalg import expm

from balance.motion.verification.verify_motions import PinocchioModel


def table(data: bytes) -> dict[str, np.ndarray]:
    """Columns of a file of comma-separated values, by name."""
    names, *rows = csv.reader(io.StringIO(data.decode()))
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


def momentum_by_pinocchio(linkage, trajectory) -> np.ndarray:
    """``[ξ; p]`` (N, 6) of the masses in the file."""
    masses = np.array([body.inertia for body in linkage.bodies])
    return PinocchioModel(linkage, masses).momenta(trajectory)


def hat(a):
    """The matrix of ``a ×``."""
    return np.cross(a, np.eye(3)).T


def carried(H):
    """The matrix that carries twists ``[ω; v]`` along with a displacement."""
    R, d = H[:3, :3], H[:3, 3]
    return np.block([[R, np.zeros((3, 3))], [hat(d) @ R, R]])


def placed(linkage, q, qd):
    """Displacements (4, 4) and twists of all links."""
    H, V = [], []
    for joint, position, rate in zip(linkage.joints, q, qd, strict=True):
        above = joint.parent >= 0
        before, twist = (
            (H[joint.parent], V[joint.parent]) if above else (np.eye(4), np.zeros(6))
        )
        generator = np.zeros((4, 4))
        generator[:3, :3], generator[:3, 3] = hat(joint.screw[:3]), joint.screw[3:]
        V.append(twist + carried(before) @ joint.screw * rate)
        H.append(before @ expm(position * generator))
    return H, V


def momentum(linkage, q, qd):
    """Momenta ``[ξ; p]`` of all bodies about the origin (bodies, 6)."""
    H, V = placed(linkage, q, qd)
    rows = []
    for body in linkage.bodies:
        m, c = body.inertia[0], hat(body.inertia[1:4])
        xx, yy, zz, xy, xz, yz = body.inertia[4:]
        E = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        M = np.block([[E, c], [-c, m * np.eye(3)]])
        back = np.linalg.inv(carried(H[body.link]))
        rows.append(back.T @ M @ back @ V[body.link])
    return np.array(rows)
