"""A planar linkage on a free base by Pinocchio alone, from the text of its file.

The tree is read by Pinocchio's reader of URDF on a planar joint; the pins of ``<loop>`` are
closed by Newton's method on the distance of their two ends, with Pinocchio's Jacobians. The
mass matrix is that of CRBA, projected on the motions that keep the pins closed.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin


class PlanarFile:
    """The model; the first velocities are those of the base, which is at its place."""

    def __init__(self, urdf: bytes, inputs) -> None:
        """Read a file whose joints are hinges about z."""
        root = ElementTree.fromstring(urdf)
        self.loops = [
            [(side.get("link"), _point(side)) for side in loop if side.get("link")]
            for loop in root.findall("loop")
        ]
        self.links = [link.get("name") for link in root.iter("link") if len(link)]
        for loop in root.findall("loop"):
            root.remove(loop)
        text = ElementTree.tostring(root, encoding="unicode")
        self.model = pin.buildModelFromXML(text, pin.JointModelPlanar())
        self.data = self.model.createData()
        self.free = [self.model.idx_vs[self.model.getJointId(name)] for name in inputs]
        self.others = [k for k in range(3, self.model.nv) if k not in self.free]
        self.q = pin.neutral(self.model)

    def frame(self, link: str) -> pin.SE3:
        """The frame of a link at the pose."""
        return self.data.oMf[self.model.getFrameId(link)]

    def turn_to(self, values, steps: int = 60) -> float:
        """Turn the inputs from the pose of the file, with the pins kept.

        Returns:
            Largest turn of a joint, radians; infinity if the pins do not close.
        """
        neutral, turned = pin.neutral(self.model), np.zeros(self.model.nv)
        for part in np.linspace(0.0, 1.0, steps + 1):
            turned[self.free] = part * np.asarray(values)
            for _ in range(6):
                gaps, J = self._gaps(pin.integrate(self.model, neutral, turned))
                turned[self.others] -= np.linalg.lstsq(J[:, self.others], gaps, rcond=None)[0]
        self.q = pin.integrate(self.model, neutral, turned)
        closed = np.abs(self._gaps(self.q)[0]).max(initial=0.0) < 1e-11
        return float(np.abs(turned).max()) if closed else np.inf

    def mass_matrix(self) -> np.ndarray:
        """Mass matrix of the twist of the base and the rates of the inputs, at the pose."""
        M = pin.crba(self.model, self.data, self.q)
        M = np.triu(M) + np.triu(M, 1).T
        _, J = self._gaps(self.q)
        kept = [0, 1, 2, *self.free]
        G = np.zeros((self.model.nv, len(kept)))
        G[kept, np.arange(len(kept))] = 1.0
        # Velocities of the base do not open the pins.
        G[self.others, 3:] = -np.linalg.lstsq(J[:, self.others], J[:, self.free], rcond=None)[0]
        return G.T @ M @ G

    def _gaps(self, q: np.ndarray):
        """Distances of the ends of the pins, and their derivatives by all velocities."""
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        pin.computeJointJacobians(self.model, self.data, q)
        gaps, rows = [], []
        for sides in self.loops:
            (at, J), (there, K) = (self._end(*side) for side in sides)
            gaps.append((at - there)[:2])
            rows.append((J - K)[:2])
        empty = np.zeros((0, self.model.nv))
        return np.concatenate([[], *gaps]), np.vstack([empty, *rows])

    def _end(self, link: str, point: np.ndarray):
        number = self.model.getFrameId(link)
        frame = self.data.oMf[number]
        arm = frame.rotation @ point
        J = pin.getFrameJacobian(
            self.model, self.data, number, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        return frame.translation + arm, J[:3] - pin.skew(arm) @ J[3:]


def _point(side) -> np.ndarray:
    origin = side.find("origin")
    return np.array([float(x) for x in origin.get("xyz", "0 0 0").split()])
