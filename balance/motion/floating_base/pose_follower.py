"""Closed poses of a linkage whose inputs move by small steps, on one branch."""

from __future__ import annotations

import numpy as np

from kinematics.closure.joint_positions import joint_positions
from kinematics.closure.newton import Pose, follow_ray, forward_kinematics
from kinematics.closure.series import expand_from
from kinematics.errors import PoseError
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

# Order of the series that predicts the next pose.
PREDICTION_ORDER = 3
# Most steps from one pose to the next.
MAX_STEPS = 50


class PoseFollower:
    """The pose of a linkage as a function of its inputs, from the last pose asked for."""

    def __init__(self, linkage: Linkage, chain: Chain, u: Array) -> None:
        """Start at displacements of the inputs from the reference pose.

        Args:
            chain: its arrays, from `kinematics.closure.joint_positions.input_chain`.
            u: the displacements (mobility,), in units of the chain.

        Raises:
            PoseError: the linkage cannot reach this pose.
        """
        self._chain, self._source = chain, linkage.source
        inputs = linkage.positions_of(linkage.inputs)
        start = joint_positions(linkage, u * chain.units[inputs]) / chain.units
        self._start = self._u, self._pose = u, forward_kinematics(chain, start)

    def restart(self) -> None:
        """Return to the first pose."""
        self._u, self._pose = self._start

    def at(self, u: Array) -> Pose:
        """Compute the pose at inputs (mobility,) near those of the last call, chain units.

        Raises:
            PoseError: the loops cannot be closed on the way there.
        """
        if self._chain.dependent.size == 0:
            return forward_kinematics(self._chain, self._chain.columns @ u)
        advance = u - self._u
        remaining = float(np.sqrt(advance @ advance))
        if remaining > 0.0:
            self._advance(advance / remaining, remaining)
            self._u = u
        return self._pose

    def _advance(self, direction: Array, remaining: float) -> None:
        """Follow a straight line of the inputs."""
        for _ in range(MAX_STEPS):
            if remaining == 0.0:
                return
            series = expand_from(
                self._chain, self._pose.screws, direction[None], PREDICTION_ORDER
            )
            pose, step = follow_ray(self._chain, self._pose.q, series, direction, remaining)
            if step == 0.0:
                break
            self._pose, remaining = pose, remaining - step
        raise PoseError(f"{self._source}: the loops cannot be closed")
