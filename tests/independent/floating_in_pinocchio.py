"""A linkage on a base that floats, in Pinocchio: all coordinates, loops by their accelerations.

A second route that shares no code with the product: mass matrix and bias by Pinocchio, the base
on a free-flyer (in a plane on two sliders and a hinge), loops as equal twists of the welded
links, and Gauss's principle: of all accelerations that keep the constraints, the nearest to the
free ones.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pinocchio as pin
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation


class FloatingModel:
    """The model; coordinates are those of Pinocchio."""

    def __init__(self, linkage: Any, base: Any, planar: bool) -> None:
        """Put the linkage on its base, which starts at the pose of the file."""
        self.linkage, self.base, self.planar = linkage, base, planar
        self.model = pin.Model()
        self.model.gravity.setZero()
        com = np.array(base.com)
        self.axes = linkage.chain.frame.R if planar else np.eye(3)
        root = self._add_root(com)
        moments = np.diag(base.moments)
        carried = pin.Inertia(base.mass, np.zeros(3), moments)
        self.model.appendBodyToJoint(root, carried, pin.SE3.Identity())
        count = len(linkage.joints)
        self.root, self.ids = root, [0] * count
        points = [_axis_point(joint) for joint in linkage.joints]
        # Pinocchio's mass matrix wants the joints of each branch in a row.
        pending = [k for k in range(count) if linkage.joints[k].parent < 0]
        while pending:
            k = pending.pop()
            joint = linkage.joints[k]
            before = points[joint.parent] if joint.parent >= 0 else com
            parent = self.ids[joint.parent] if joint.parent >= 0 else root
            place = pin.SE3(np.eye(3), points[k] - before)
            self.ids[k] = self.model.addJoint(parent, _kind(joint), place, joint.name)
            pending += [other for other in range(count) if linkage.joints[other].parent == k]
        for body in linkage.bodies:
            self._add_body(body, points[body.link])
        self.data = self.model.createData()
        self.count = self.model.nv
        # Where the joints of the linkage stand among the velocities.
        self.places = np.array([self.model.idx_vs[k] for k in self.ids])
        self.inputs = self.places[linkage.positions_of(linkage.inputs)]

    def _add_root(self, com: np.ndarray) -> int:
        """Add the joints of the base, at its centre of mass."""
        place = pin.SE3(np.eye(3), com)
        if not self.planar:
            return self.model.addJoint(0, pin.JointModelFreeFlyer(), place, "base")
        root = 0
        for k, make in enumerate(
            (pin.JointModelPrismaticUnaligned,) * 2 + (pin.JointModelRevoluteUnaligned,)
        ):
            root = self.model.addJoint(root, make(self.axes[k]), place, f"base{k}")
            place = pin.SE3.Identity()
        return root

    def _add_body(self, body: Any, point: np.ndarray) -> None:
        """Add a body; parameters are about the inertial origin."""
        m, mc, E = body.inertia[0], body.inertia[1:4], body.inertia[4:]
        tensor = np.array([[E[0], E[3], E[4]], [E[3], E[1], E[5]], [E[4], E[5], E[2]]])
        c = mc / m
        own = tensor - m * (c @ c * np.eye(3) - np.outer(c, c))
        found = pin.Inertia.Zero()
        found.mass, found.lever, found.inertia = m, c - point, own
        self.model.inertias[self.ids[body.link]] += found

    def _constraints(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows J and γ of the loops and the mimic joints, ``J a + γ = 0``."""
        model, data = self.model, self.data
        pin.computeJointJacobiansTimeVariation(model, data, q, v)
        rows, rest = [], []

        def both(link: int) -> tuple[np.ndarray, np.ndarray]:
            # A weld to the ground of the file is one to the base.
            joint = self.ids[link] if link >= 0 else self.root
            world = pin.ReferenceFrame.WORLD
            return (
                pin.getJointJacobian(model, data, joint, world),
                pin.getJointJacobianTimeVariation(model, data, joint, world) @ v,
            )

        for loop in self.linkage.loops:
            (J1, r1), (J2, r2) = both(loop.end), both(loop.successor)
            rows.append(J1 - J2)
            rest.append(r1 - r2)
        for mimic in self.linkage.mimics:
            row = np.zeros((1, self.count))
            row[0, self.places[mimic.joint]] = 1.0
            row[0, self.places[mimic.source]] = -mimic.ratio
            rows.append(row)
            rest.append(np.zeros(1))
        return np.vstack([np.zeros((0, self.count)), *rows]), np.concatenate([[], *rest])

    def _load(self, q: np.ndarray) -> np.ndarray:
        """Forces of the springs (nv,)."""
        tau = np.zeros(self.count)
        k, turning = self.base.stiffness, self.base.turning_stiffness
        if self.planar:
            tau[:3] = -k * q[0], -k * q[1], -turning * q[2]
        else:
            turned = Rotation.from_quat(q[3:7])
            tau[:3] = -k * turned.inv().apply(q[:3])
            tau[3:6] = -turning * turned.as_rotvec()
        return tau

    def rate(self, t: float, state: np.ndarray, path: Any, torques: np.ndarray) -> np.ndarray:
        """The rate of the state ``[q, v]``."""
        model, data = self.model, self.data
        q, v = state[: model.nq].copy(), state[model.nq :]
        if not self.planar:
            q[3:7] /= np.linalg.norm(q[3:7])
        J, gamma = self._constraints(q, v)
        M = pin.crba(model, data, q)
        M = np.triu(M) + np.triu(M, 1).T
        free = self._load(q) - pin.nonLinearEffects(model, data, q, v)
        if path is None:
            free[self.inputs] += torques
        else:
            J = np.vstack([J, np.eye(self.count)[self.inputs]])
            gamma = np.concatenate([gamma, -path.at(np.array([t]))[2][0]])
        _, size, rows = np.linalg.svd(J) if len(J) else (None, np.zeros(0), np.eye(self.count))
        N = rows[(size > 1e-9 * size.max(initial=0.0)).sum() :].T
        a = np.linalg.lstsq(J, -gamma, rcond=1e-9)[0] if len(J) else np.zeros(self.count)
        a = a + N @ np.linalg.solve(N.T @ M @ N, N.T @ (free - M @ a))
        if self.planar:
            return np.concatenate([v, a])
        w, turn = q[3:7], v[3:6]
        spin = np.concatenate([w[3] * turn + np.cross(w[:3], turn), [-w[:3] @ turn]])
        moved = Rotation.from_quat(w).apply(v[:3])
        return np.concatenate([moved, 0.5 * spin, v[6:], a])

    def run(
        self,
        times: np.ndarray,
        q: np.ndarray,
        qd: np.ndarray,
        twist: np.ndarray,
        path: Any,
        torques: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Rotations (N, 3, 3) and displacements (N, 3) of the base, and joints (N, n).

        ``twist``: angular velocity and velocity of the centre of mass at the start.
        """
        first = 3 if self.planar else 6
        start, rates = np.zeros(self.count), np.zeros(self.count)
        start[self.places], rates[self.places] = q, qd
        own = [np.zeros(3)] if self.planar else [np.zeros(6), np.ones(1)]
        if self.planar:
            rates[:3] = [*(self.axes[:2] @ twist[3:]), self.axes[2] @ twist[:3]]
        else:
            rates[:6] = [*twist[3:], *twist[:3]]
        found = solve_ivp(
            self.rate,
            (times[0], times[-1]),
            np.concatenate([*own, start[first:], rates]),
            method="DOP853",
            t_eval=times,
            rtol=1e-12,
            atol=1e-13,
            args=(path, torques),
        ).y.T
        joints = found[:, self.places + self.model.nq - self.count]
        if self.planar:
            turned = Rotation.from_rotvec(np.outer(found[:, 2], self.axes[2]))
            return turned.as_matrix(), found[:, :2] @ self.axes[:2], joints
        return Rotation.from_quat(found[:, 3:7]).as_matrix(), found[:, :3], joints


def _axis_point(joint: Any) -> np.ndarray:
    """The point of a joint axis nearest to the inertial origin."""
    n, v = joint.screw[:3], joint.screw[3:]
    return np.cross(n, v) if n.any() else np.zeros(3)


def _kind(joint: Any) -> Any:
    """The joint of Pinocchio, its axis in inertial axes."""
    n, v = joint.screw[:3], joint.screw[3:]
    if not n.any():
        return pin.JointModelPrismaticUnaligned(v)
    if abs(n @ v) > 1e-12:
        return pin.JointModelHelicalUnaligned(n, float(n @ v))
    return pin.JointModelRevoluteUnaligned(n)
