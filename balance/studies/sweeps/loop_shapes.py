"""Shapes of single loops in many geometries: lengths of links, Grashof's rule, transmission."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.support.tolerances import SCREW_ROUNDED
from kinematics.model.chain import path
from kinematics.model.linkage import Linkage, names_of

Array = NDArray[np.float64]


def loop_cycle(linkage: Linkage, number: int) -> list[int]:
    """List the joints round a loop, in order."""
    parent, loop = [joint.parent for joint in linkage.joints], linkage.loops[number]
    out, back = path(parent, loop.end), path(parent, loop.successor)
    shared = set(out) & set(back)
    return [j for j in reversed(out) if j not in shared] + [j for j in back if j not in shared]


class FourBar(NamedTuple):
    """The loop of a planar four-bar linkage, driven at one joint.

    Attributes:
        cycle: its joints, from the driven one on: the first link follows that joint.
        normal: of its plane (3,).
    """

    cycle: tuple[int, ...]
    normal: Array

    @classmethod
    def of(cls, linkage: Linkage) -> FourBar | None:
        """Find the four-bar of a linkage; None if it is none, or is not driven at a joint."""
        cycle = loop_cycle(linkage, 0) if len(linkage.loops) == 1 else []
        joints = [linkage.joints[j] for j in cycle]
        if len(cycle) != 4 or not all(joint.kind == "revolute" for joint in joints):
            return None
        n = joints[0].screw[:3]
        if any(np.abs(np.cross(n, j.screw[:3])).max() > SCREW_ROUNDED for j in joints):
            return None
        driven = [k for k, name in enumerate(names_of(joints)) if name in linkage.inputs]
        if len(driven) != 1:
            return None
        return cls((*cycle[driven[0] :], *cycle[: driven[0]]), n)

    def lengths(self, points: Array) -> Array:
        """Compute the lengths of the links (rows, 4), in the plane, from points of the joints.

        Args:
            points: of all joints (rows, n, 3), metres.
        """
        corners = points[:, list(self.cycle)]
        spans = np.roll(corners, -1, axis=1) - corners
        spans -= (spans @ self.normal)[..., None] * self.normal
        return np.sqrt(np.sum(spans**2, axis=-1))

    @staticmethod
    def is_grashof(lengths: Array) -> NDArray[np.bool_]:
        """Whether some link can turn fully: shortest and longest are at most the other two."""
        ends = lengths.min(axis=1) + lengths.max(axis=1)
        return np.asarray(2.0 * ends <= lengths.sum(axis=1))

    @staticmethod
    def turns_fully(lengths: Array) -> NDArray[np.bool_]:
        """Whether the driven joint turns fully: the shortest link is at it, by Grashof."""
        at_joint = np.minimum(lengths[:, 0], lengths[:, 3]) <= lengths.min(axis=1)
        return FourBar.is_grashof(lengths) & at_joint

    @staticmethod
    def least_transmission(lengths: Array) -> Array:
        """Compute the least transmission angle (rows,) over a full turn, degrees.

        Opposite to the driven joint, between links b and c: ``cos μ = (b² + c² - D²) / 2bc``
        with the diagonal D between ``|a - d|`` and ``a + d``. It is 0 where the driven joint
        cannot turn fully: the linkage then reaches a dead centre.
        """
        a, b, c, d = lengths.T
        with np.errstate(all="ignore"):
            cosines = [(b * b + c * c - D * D) / (2.0 * b * c) for D in (np.abs(a - d), a + d)]
            largest = np.clip(np.max(np.abs(cosines), axis=0), 0.0, 1.0)
        angle = np.degrees(np.arccos(largest))
        return np.where(FourBar.turns_fully(lengths), angle, 0.0)
