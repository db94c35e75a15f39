"""Rank by sampling: momentum regressors of Pinocchio at closed poses, and a QR."""

from __future__ import annotations

import numpy as np
import scipy.linalg

from balance.motion.verification.shaking_wrench import mass_parameters
from kinematics.model.linkage import Linkage

# Largest pivot that counts as zero in figaroh.
ZERO_PIVOT = 1e-8


class Sampling:
    """One linkage in Pinocchio, opened at its welds."""

    def __init__(self, linkage: Linkage, planar: bool) -> None:
        """Build the model; this is not timed."""
        try:
            import pinocchio as pin

            from balance.motion.verification.verify_motions import PinocchioModel
        except ImportError:
            raise NotImplementedError("Pinocchio is not installed") from None
        self.pin, self.linkage = pin, linkage
        self.model = PinocchioModel(linkage, mass_parameters(linkage, None)).model
        self.data = self.model.createData()
        self.bodies = [body.link + 1 for body in linkage.bodies]
        self.loops = [(loop.end + 1, loop.successor + 1) for loop in linkage.loops]
        pin.forwardKinematics(self.model, self.data, np.zeros(self.model.nv))
        place = self.data.oMi
        self.welds = [place[f].actInv(place[e]) for e, f in self.loops]
        inputs = linkage.positions_of(linkage.inputs)
        self.inputs = inputs
        self.others = np.setdiff1d(np.arange(self.model.nv), inputs)
        # Columns and rows that count; Pinocchio: m, mc, Ixx, Ixy, Iyy, Ixz, Iyz, Izz.
        normal = int(np.argmax(np.abs(linkage.chain.frame.R[2]))) if planar else 0
        across = [i for i in range(3) if i != normal]
        moment = {0: 4, 1: 6, 2: 9}[normal]
        kept = [0, 1 + across[0], 1 + across[1], moment]
        self.columns = kept if planar else list(range(10))
        self.rows = [*across, 3 + normal] if planar else list(range(6))

    def close_loops(self, u: np.ndarray) -> np.ndarray:
        """Solve for joint positions at the inputs u, by Newton's method."""
        pin, model, data = self.pin, self.model, self.data
        q = np.zeros(model.nv)
        q[self.inputs] = u
        for _ in range(20):
            pin.computeJointJacobians(model, data, q)
            apart = [
                data.oMi[f].actInv(data.oMi[e]) * weld.inverse()
                for (e, f), weld in zip(self.loops, self.welds, strict=True)
            ]
            error = np.concatenate(
                [
                    data.oMi[f].act(pin.log6(D)).vector
                    for (_, f), D in zip(self.loops, apart, strict=True)
                ]
            )
            if np.abs(error).max() < 1e-12:
                break
            J = self.jacobian()[:, self.others]
            q[self.others] -= np.linalg.lstsq(J, error, rcond=None)[0]
        return q

    def jacobian(self) -> np.ndarray:
        """Compute the Jacobian of the welds at the pose of the last computeJointJacobians."""
        pin, model, data = self.pin, self.model, self.data
        zero = np.zeros((6, model.nv))
        J = [
            pin.getJointJacobian(model, data, i, pin.WORLD) if i else zero
            for pair in self.loops
            for i in pair
        ]
        return np.concatenate([a - b for a, b in zip(J[::2], J[1::2], strict=True)])

    def rates(self, q: np.ndarray) -> np.ndarray:
        """Compute joint velocities for unit velocities of the inputs (n, inputs)."""
        self.pin.computeJointJacobians(self.model, self.data, q)
        J = self.jacobian()
        C = np.zeros((self.model.nv, self.inputs.size))
        C[self.inputs] = np.eye(self.inputs.size)
        C[self.others] = -np.linalg.lstsq(J[:, self.others], J[:, self.inputs], rcond=None)[0]
        return C

    def regressor(self, q: np.ndarray, C: np.ndarray) -> np.ndarray:
        """Compute the momentum rows of all inputs at one pose."""
        pin, model, data = self.pin, self.model, self.data
        blocks, still = [], pin.Motion.Zero()
        for column in C.T:
            pin.forwardKinematics(model, data, q, column)
            blocks.append(
                np.concatenate(
                    [
                        (
                            data.oMi[i].toDualActionMatrix()
                            @ pin.bodyRegressor(still, data.v[i])
                        )[np.ix_(self.rows, self.columns)]
                        for i in self.bodies
                    ],
                    axis=1,
                )
            )
        return np.concatenate(blocks)

    def rank(self, poses: list[tuple[np.ndarray, np.ndarray]]) -> int:
        """Count the pivots above `ZERO_PIVOT` of the stacked rows."""
        rows = np.concatenate([self.regressor(q, C) for q, C in poses])
        R = scipy.linalg.qr(rows, mode="r", pivoting=True)[0]
        return int(np.sum(np.abs(np.diag(R)) > ZERO_PIVOT))
