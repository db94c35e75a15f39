"""Write the URDF file of a linkage at its present reference pose.

Nothing is taken from the file that the linkage may have been read from. `Linkage` has
`to_urdf` as a method and imports this module, so that it is typed here as ``Any``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from kinematics.model.document import make_elements
from kinematics.model.document.element import Element, unused_name
from kinematics.model.document.joint_types import coordinate_names
from kinematics.model.document.write_numbers import element_text, number_words
from kinematics.model.spatial.inertia import displace_parameters, inertia_tensor
from kinematics.numerics.array_types import Array
from kinematics.numerics.tolerances import JOINT_AXES_MEET

# Decimals that are kept of numbers of size 1: the next are round-off.
DIGITS = 15
_MOTIONS = {
    ("revolute",): "continuous",
    ("helical",): "continuous",
    ("prismatic",): "prismatic",
    ("revolute", "revolute"): "universal",
    ("revolute", "prismatic"): "cylindrical",
    ("prismatic", "prismatic", "revolute"): "planar",
    ("revolute", "revolute", "revolute"): "spherical",
    ("prismatic", "prismatic", "prismatic", "revolute", "revolute", "revolute"): "floating",
}


class _FileJoint(NamedTuple):
    """A chain of single freedoms that is one joint, or the joint of one loop, of the file.

    Attributes:
        name: of the joint or loop.
        kind: its type in the file.
        steps: its freedoms, from the parent to the child.
        axis: its axis (3,), inertial.
        axis2: second axis of a universal joint.
        centre: a point (3,) of all its rotation axes.
    """

    name: str
    kind: str
    steps: Sequence[Any]
    axis: Array
    axis2: Array | None
    centre: Array


def urdf_text(linkage: Any) -> str:
    """Write a linkage as the text of a URDF file with its loops; see `Linkage.to_urdf`."""
    return element_text(make_elements.robot(linkage.name, _LinkageWriter(linkage).parts()))


class _LinkageWriter:
    """The writer of one linkage: poses of its links, and names that are taken."""

    def __init__(self, linkage: Any) -> None:
        """Find the links of every rigid body, the one it is named after first."""
        self.linkage = linkage
        points = [place.pose[:3, 3] for place in linkage.places.values()]
        points += [joint.point for joint in linkage.joints]
        self.size = float(np.abs(points).max()) or 1.0
        self.links: dict[int, list[str]] = {}
        for name, place in linkage.places.items():
            self.links.setdefault(place.link, []).append(name)
        self.poses = {name: place.pose for name, place in linkage.places.items()}
        self.inputs = set(linkage.inputs)
        self.taken = {*self.poses, *(joint.name for joint in linkage.joints)}

    def parts(self) -> list[Element]:
        """Make the elements of all links, then of all joints, then of all loops."""
        tree = [joint for joint in self.linkage.joints if not joint.in_loop]
        joints = [
            part
            for chain in self._group_freedoms(tree)
            for part in self._make_tree_joint(chain)
        ]
        loops = []
        for loop in self.linkage.loops:
            added, closing = self._make_loop(loop)
            joints += added
            loops.append(closing)
        joints += list(self._make_fixed_joints())
        return [*self._make_links(), *joints, *loops]

    def _make_links(self) -> Iterator[Element]:
        masses = {body.link: body.inertia for body in self.linkage.bodies}
        for index, names in self.links.items():
            for name in names:
                z = masses.get(index) if name == names[0] else None
                yield make_elements.link(
                    name, None if z is None else self._make_inertial(z, name)
                )

    def _make_inertial(self, z: Array, name: str) -> Element:
        """Make the ``<inertial>`` of parameters (10,) about the inertial origin."""
        parameters = displace_parameters(z, np.linalg.inv(self.poses[name]))
        mass, E = float(parameters[0]), inertia_tensor(parameters)
        c = parameters[1:4] / mass if mass else np.zeros(3)
        at = Element("origin", {"xyz": number_words(_round_to_size(c, self.size))})
        about = E - mass * (c @ c * np.eye(3) - np.outer(c, c))
        return make_elements.inertial(
            mass, _round_to_size(about, float(np.abs(z[4:]).max())), at
        )

    def _make_fixed_joints(self) -> Iterator[Element]:
        """Make joints that fix further links of a body to the first."""
        for first, *others in self.links.values():
            for name in others:
                yield make_elements.joint(
                    unused_name(f"{name}_fixed", self.taken),
                    "fixed",
                    first,
                    name,
                    self._relative_origin(first, name),
                )

    def _group_freedoms(self, joints: Iterable[Any]) -> Iterator[list[Any]]:
        """Group freedoms that are one joint of the file, unless only some are inputs."""
        for _, group in groupby(joints, key=lambda joint: (joint.whole, joint.numbered)):
            yield list(group)

    def _find_file_joint(self, name: str, steps: Sequence[Any]) -> _FileJoint | None:
        """Find the joint of the file with these freedoms; None if there is none."""
        kind = _MOTIONS.get(tuple(step.kind for step in steps), "")
        given = [step.name for step in steps]
        chosen = self.inputs.intersection(given)
        if not kind or given != coordinate_names(name, kind) or 0 < len(chosen) < len(steps):
            return None
        directions = [step.direction for step in steps]
        axis = directions[2] if kind == "planar" else directions[0]
        axis2 = directions[1] if kind == "universal" else None
        turning = [step for step in steps if step.kind != "prismatic"]
        centre = (turning or steps)[-1].point
        joint = _FileJoint(name, kind, steps, axis, axis2, centre)
        return joint if self._fits_motions(joint) else None

    def _fits_motions(self, joint: _FileJoint) -> bool:
        """Return whether the joint of the file allows the motions of the freedoms.

        Its rotation axes meet in the centre. Slides are along the axis of a cylindrical joint,
        and at right angles to that of a planar one, as is the second axis of a universal one.
        """
        off = [0.0]
        for step in joint.steps:
            n, v = step.screw[:3], step.screw[3:]
            if step.kind == "revolute":
                off.append(float(np.abs(v + np.cross(n, joint.centre)).max()) / self.size)
            elif joint.kind == "cylindrical":
                off.append(float(np.abs(np.cross(joint.axis, v)).max()))
            elif joint.kind == "planar":
                off.append(abs(float(joint.axis @ v)))
        if joint.axis2 is not None:
            off.append(abs(float(joint.axis @ joint.axis2)))
        return max(off) <= JOINT_AXES_MEET

    def _make_tree_joint(self, steps: Sequence[Any]) -> list[Element]:
        """Make a joint of the tree, or one for every freedom of it, with links between."""
        parent, last = steps[0].parent, self.linkage.joints.index(steps[-1])
        start, child = self.links[parent][0], self.links[last][0]
        joint = self._find_file_joint(steps[0].whole, steps)
        if joint is None:
            return self._make_single_joints(steps, start, child)
        return [self._make_joint(joint, start, child)]

    def _make_single_joints(self, steps: Sequence[Any], start: str, end: str) -> list[Element]:
        """Make single joints from one link to another, with links of no mass between."""
        joints = []
        for step in steps:
            there = end
            if step is not steps[-1] or not end:
                there = unused_name(f"{step.name}_link", self.taken)
                pose = np.eye(4)
                pose[:3, 3] = step.point
                self.poses[there] = pose
                self.links[self.linkage.joints.index(step)] = [there]
            joint = self._find_file_joint(step.name, [step])
            assert joint is not None
            joints.append(self._make_joint(joint, start, there))
            start = there
        return joints

    def _make_joint(self, joint: _FileJoint, parent: str, child: str) -> Element:
        """Make a ``<joint>``; move the frame of its child onto the axis, if it is beside it."""
        step = joint.steps[0]
        self._centre_frame(joint, child)
        rows = self.poses[child][:3, :3].T
        axis2 = "" if joint.axis2 is None else self._direction_text(rows @ joint.axis2)
        pitch = float(step.screw[:3] @ step.screw[3:]) if step.kind == "helical" else 0.0
        return make_elements.joint(
            joint.name,
            joint.kind,
            parent,
            child,
            self._relative_origin(parent, child),
            (self._direction_text(rows @ joint.axis), axis2),
            pitch,
            self._find_mimic(step),
            independent=step.name in self.inputs,
        )

    def _centre_frame(self, joint: _FileJoint, child: str) -> None:
        """Move the frame of a link onto the rotation axes of the joint that carries it."""
        if joint.kind == "prismatic":
            return
        pose, point = self.poses[child], joint.centre
        if joint.kind not in ("universal", "spherical", "floating"):
            point = point + joint.axis * (joint.axis @ (pose[:3, 3] - point))
        if np.abs(pose[:3, 3] - point).max() > JOINT_AXES_MEET * self.size:
            pose = pose.copy()
            pose[:3, 3] = point
            self.poses[child] = pose

    def _find_mimic(self, step: Any) -> tuple[str, float, float] | None:
        joints = self.linkage.joints
        for mimic in self.linkage.mimics:
            if joints[mimic.joint] is step:
                return joints[mimic.source].name, mimic.ratio, 0.0
        return None

    def _make_loop(self, loop: Any) -> tuple[list[Element], Element]:
        """Make a ``<loop>``, and joints before it if no single joint type has its freedoms."""
        joints, start = self.linkage.joints, loop.end
        steps: list[Any] = []
        while start >= 0 and joints[start].in_loop:
            steps.insert(0, joints[start])
            start = joints[start].parent
        first, last = self.links[start][0], self.links[loop.successor][0]
        joint = self._find_file_joint(loop.name, steps)
        if joint is not None:
            return [], self._make_closing_joint(joint, first, last)
        added = self._make_single_joints(steps, first, "") if steps else []
        before = self.links[loop.end][0]
        sides = [(before, None), (last, self._relative_origin(last, before))]
        return added, make_elements.loop(loop.name, "fixed", sides)

    def _make_closing_joint(self, joint: _FileJoint, first: str, last: str) -> Element:
        """Make a ``<loop>`` by a joint; both frames are the predecessor's, at the centre."""
        frame = self.poses[first].copy()
        frame[:3, 3] = joint.centre
        rows = frame[:3, :3].T
        sides = [
            (name, self._origin_between(self.poses[name], frame)) for name in (first, last)
        ]
        axis2 = "" if joint.axis2 is None else self._direction_text(rows @ joint.axis2)
        kind = "revolute" if joint.kind == "continuous" else joint.kind
        return make_elements.loop(
            joint.name,
            kind,
            sides,
            (self._direction_text(rows @ joint.axis), axis2),
            independent=joint.steps[0].name in self.inputs,
        )

    def _relative_origin(self, parent: str, child: str) -> Element:
        """Make the ``<origin>`` of a link in the frame of another."""
        return self._origin_between(self.poses[parent], self.poses[child])

    def _origin_between(self, before: Array, after: Array) -> Element:
        """Make the ``<origin>`` of a pose in the frame of another, without round-off."""
        pose = np.eye(4)
        pose[:3, :3] = before[:3, :3].T @ after[:3, :3]
        d = before[:3, :3].T @ (after[:3, 3] - before[:3, 3])
        pose[:3, 3] = _round_to_size(d, self.size)
        return make_elements.origin(pose)

    @staticmethod
    def _direction_text(axis: Array) -> str:
        """Write a unit vector as text, without round-off."""
        return number_words(_round_to_size(axis, 1.0))


def _round_to_size(x: Array, size: float) -> Array:
    """Round numbers to the digits that are significant beside numbers of a size."""
    return np.round(x, DIGITS - round(float(np.log10(size)))) if size else x
