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
    """The model; the first velocities are those of the base, which is at its place.

    Joints with ``<mimic>`` are no joints of loops.
    """

    root = pin.JointModelPlanar

    def __init__(self, urdf: bytes, inputs) -> None:
        """Read a file whose joints are hinges about z."""
        root = ElementTree.fromstring(urdf)
        self.loops = [
            [
                (side.get("link"), vector_of(side.find("origin")))
                for side in loop
                if side.get("link")
            ]
            for loop in root.findall("loop")
        ]
        self.axes = [vector_of(loop.find("axis")) for loop in root.findall("loop")]
        self.links = [link.get("name") for link in root.iter("link") if len(link)]
        for loop in root.findall("loop"):
            root.remove(loop)
        text = ElementTree.tostring(root, encoding="unicode")
        self.model = pin.buildModelFromXML(text, self.root())
        self.data = self.model.createData()
        self.free = [self._number(name) for name in inputs]
        self.followers = {
            self._number(joint.get("name")): (self._number(mimic.get("joint")), mimic)
            for joint in root.iter("joint")
            for mimic in joint.iter("mimic")
        }
        self.base = list(range(self.model.joints[1].nv))
        known = {*self.base, *self.free, *self.followers}
        self.others = [k for k in range(self.model.nv) if k not in known]
        self.q = pin.neutral(self.model)

    def _number(self, joint: str) -> int:
        return self.model.idx_vs[self.model.getJointId(joint)]

    def _follow(self, rates: np.ndarray) -> None:
        """Give joints with ``<mimic>``, which are rows, the rates that they follow."""
        for joint, (leader, mimic) in self.followers.items():
            rates[joint] = float(mimic.get("multiplier")) * rates[leader]

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
                self._follow(turned)
        self.q = pin.integrate(self.model, neutral, turned)
        closed = np.abs(self._gaps(self.q)[0]).max(initial=0.0) < 1e-11
        return float(np.abs(turned).max()) if closed else np.inf

    def mass_matrix(self) -> np.ndarray:
        """Mass matrix of the twist of the base and the rates of the inputs, at the pose."""
        M = pin.crba(self.model, self.data, self.q)
        M = np.triu(M) + np.triu(M, 1).T
        _, J = self._gaps(self.q)
        kept = [*self.base, *self.free]
        G = np.zeros((self.model.nv, len(kept)))
        G[kept, np.arange(len(kept))] = 1.0
        # Velocities of the base do not open the pins.
        closing = np.linalg.lstsq(J[:, self.others], J[:, self.free], rcond=None)[0]
        G[self.others, len(self.base) :] = -closing
        self._follow(G)
        return G.T @ M @ G

    def _gaps(self, q: np.ndarray):
        """Distances of the ends of the pins, and their derivatives by all velocities."""
        pin.forwardKinematics(self.model, self.data, q)
        pin.updateFramePlacements(self.model, self.data)
        pin.computeJointJacobians(self.model, self.data, q)
        gaps, rows = [], []
        for sides, axis in zip(self.loops, self.axes, strict=True):
            gap, row = self._loop_gap(sides, axis)
            gaps.append(gap)
            rows.append(row)
        empty = np.zeros((0, self.model.nv))
        return np.concatenate([[], *gaps]), np.vstack([empty, *rows])

    def _loop_gap(self, sides, axis):
        """Distance of the ends of a pin in the plane, and its derivatives."""
        (at, J), (there, K) = (self._end(*side) for side in sides)
        return (at - there)[:2], (J - K)[:2]

    def _end(self, link: str, point: np.ndarray):
        number = self.model.getFrameId(link)
        frame = self.data.oMf[number]
        arm = frame.rotation @ point
        J = pin.getFrameJacobian(
            self.model, self.data, number, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        return frame.translation + arm, J[:3] - pin.skew(arm) @ J[3:]


def vector_of(element) -> np.ndarray | None:
    """The numbers of ``xyz``; None without an element."""
    if element is None:
        return None
    return np.array([float(x) for x in element.get("xyz", "0 0 0").split()])
