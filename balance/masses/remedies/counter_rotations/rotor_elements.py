"""Links and joints of counter-rotors, for the URDF file of a linkage.

A rotor is a link on a continuous joint that follows the joint it turns against. The frame of
its link has the axes of the frame of that joint, at the middle of the rotor.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.regions import Region, ball_region
from balance.masses.remedies.request import RemedyRequest
from balance.masses.remedies.variant import free_name, names_taken
from kinematics.files.urdf.xml_tree import build_tree
from kinematics.model.document.element import Element
from kinematics.model.document.make_elements import joint, link, origin
from kinematics.model.linkage import GROUND, Linkage
from kinematics.numerics.array_types import Array


class RotorParts(NamedTuple):
    """The elements of one rotor.

    Attributes:
        link: name of its link.
        joint: name of its joint.
        elements: both.
        region: where its matter may lie: a ball about a point of its axis, so that the
            balance conditions place it evenly about the axis, at the rim where it is lightest.
    """

    link: str
    joint: str
    elements: tuple[Element, ...]
    region: Region


class RotorWriter:
    """Makes the elements of rotors, with names that the file does not have yet."""

    def __init__(self, request: RemedyRequest) -> None:
        """Start with the names of the file of a request."""
        self.linkage, self.base = request.linkage, request.base
        self.radius = request.rotor_radius
        self._taken = names_taken(self.base)
        self.joints: Mapping[str, Element] = {
            item.name: item for item in build_tree(self.base.data).every("joint")
        }

    def on_base(self, name: str, ratio: float) -> RotorParts:
        """Make a rotor on the ground, in line with a joint at the reference pose.

        Args:
            name: of the joint that it turns against.
            ratio: its turns for one turn of the joint.
        """
        if self.side(name, "parent") == _root_link(self.linkage):
            return self.on_carrier(name, ratio)
        pose = self.linkage.places[self.side(name, "child")].pose.copy()
        pose[:3, 3] = self.linkage.joints[self.linkage.positions_of([name])[0]].point
        return self._parts(name, _root_link(self.linkage), origin(pose), ratio)

    def on_carrier(self, name: str, ratio: float) -> RotorParts:
        """Make a rotor on the link before a joint, on the axis of the joint.

        Args:
            ratio: its turns for one turn of the joint, seen from that link.
        """
        at = self.joints[name].first("origin") or origin(np.eye(4))
        return self._parts(name, self.side(name, "parent"), at, ratio)

    def on_child(self, name: str, place: Array, ratio: float) -> RotorParts:
        """Make a rotor on the link after a joint, with a parallel axis.

        Args:
            place: middle of the rotor (3,), metres, in the frame of that link.
            ratio: its turns for one turn of the joint, seen from that link.
        """
        pose = np.eye(4)
        pose[:3, 3] = place
        return self._parts(name, self.side(name, "child"), origin(pose), ratio)

    def side(self, name: str, side: str) -> str:
        """Return the name of a link of a joint.

        Args:
            side: ``"parent"`` or ``"child"``.
        """
        end = self.joints[name].first(side)
        assert end is not None, "a joint of a checked file has two links"
        return end.attributes["link"]

    def _parts(self, name: str, carrier: str, at: Element, ratio: float) -> RotorParts:
        """Make the link and the joint of a rotor that turns against a joint."""
        rotor = self.take_name(f"{name}_rotor")
        turning = self.take_name(f"{name}_rotor_joint")
        axis = self.axis(name)
        made = joint(
            turning, "continuous", carrier, rotor, at, (axis, ""), mimic=(name, ratio, 0.0)
        )
        region = ball_region(np.zeros(3), self.radius)
        return RotorParts(rotor, turning, (link(rotor), made), region)

    def axis(self, name: str) -> str:
        """Return the text of the axis of a joint, in the frame of that joint."""
        first = self.joints[name].first("axis")
        return first.attributes["xyz"] if first else "1 0 0"

    def take_name(self, wanted: str) -> str:
        """Return a free name, and take it."""
        name = free_name(wanted, self._taken)
        self._taken.add(name)
        return name


def _root_link(linkage: Linkage) -> str:
    """Return the name of the link of the file that carries all others."""
    return next(name for name, place in linkage.places.items() if place.link == GROUND)
