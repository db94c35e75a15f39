"""A spatial linkage on a free base by Pinocchio alone, from the text of its file.

As `tests.support.planar_in_pinocchio`, on a free joint: ball joints of loops close three
distances, hinges also the directions of their axes. All frames are parallel in the pose of the
file.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from tests.support.planar_in_pinocchio import PlanarFile


class SpatialFile(PlanarFile):
    """The model; the first six velocities are those of the base."""

    root = pin.JointModelFreeFlyer

    def _loop_gap(self, sides, axis):
        """Distance of the ends, and for a hinge ``a × b`` of both axes, with derivatives."""
        (at, J), (there, K) = (self._end(*side) for side in sides)
        if axis is None:
            return at - there, J - K
        (a, Wa), (b, Wb) = (self._direction(link, axis) for link, _ in sides)
        turned = pin.skew(b) @ pin.skew(a) @ Wa - pin.skew(a) @ pin.skew(b) @ Wb
        return np.concatenate([at - there, np.cross(a, b)]), np.vstack([J - K, turned])

    def _direction(self, link: str, axis: np.ndarray):
        """A unit vector of a link, and the derivatives of the turn of the link."""
        number = self.model.getFrameId(link)
        J = pin.getFrameJacobian(
            self.model, self.data, number, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        )
        return self.frame(link).rotation @ axis / np.linalg.norm(axis), J[3:]
