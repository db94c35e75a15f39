"""Convert the bodies and joints of a compiled MJCF file to links and joints of a URDF file.

The pose at which all joints are at their reference positions (``qpos0``, the ``ref`` of each
joint) is that of the URDF file at zero. Several joints of a body become a chain of joints
with massless links between them.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from typing import Any

import numpy as np

from kinematics.files.formats.mjcf.compile_file import Compiled
from kinematics.files.formats.mjcf.write_words import (
    direction_words,
    is_identity,
    rotation_matrix,
    round_to,
    write_origin,
)
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element, unused_name
from kinematics.model.document.joint_types import coordinate_names
from kinematics.model.document.write_numbers import number_words

_TYPES = ("floating", "spherical", "prismatic", "revolute")
# Error of the principal moments that MuJoCo computes, relative to the largest: below it the
# tensor is the one of the file.
DECOMPOSITION_ERROR = 1e-6
_NO_TURN = (1.0, 0.0, 0.0, 0.0)


class BodyTree:
    """The links and joints of a compiled file.

    Attributes:
        model: the ``mujoco.MjModel``.
        size: largest coordinate of the linkage, metres.
        carriers: name of the link that has the frame of each body.
        joints: name of each joint.
        turns: rotation matrix (3, 3) of each body at the reference pose.
        held: joints that do not move.
        relations: ``<mimic>`` of joints, by name: source, multiplier and offset.
    """

    def __init__(self, compiled: Compiled) -> None:
        """Name bodies and joints; those without a name go by ``body3`` and ``joint5``."""
        self.model = model = compiled.model
        self.axes, self.tensors = compiled.axes, compiled.tensors
        reach = np.abs(np.concatenate([model.body_pos.ravel(), model.jnt_pos.ravel()])).max()
        self.size = float(reach) or 1.0
        self.links: set[str] = {
            name for b in range(model.nbody) if (name := model.body(b).name)
        }
        self.moving: set[str] = set()
        for j in range(model.njnt):
            kind = _TYPES[model.jnt_type[j]]
            if name := model.jnt(j).name:
                several = kind in ("spherical", "floating")
                self.moving |= {name, *(coordinate_names(name, kind) if several else ())}
        self.bodies = [
            model.body(b).name or unused_name(f"body{b}", self.links)
            for b in range(model.nbody)
        ]
        self.joints = [
            model.jnt(j).name or unused_name(f"joint{j}", self.moving)
            for j in range(model.njnt)
        ]
        self.carriers = list(self.bodies)
        self.turns = [np.eye(3)]
        for b in range(1, model.nbody):
            before = self.turns[model.body_parentid[b]]
            self.turns.append(before @ rotation_matrix(model.body_quat[b]))
        self.held: set[str] = set()
        self.relations: dict[str, tuple[str, float, float]] = {}

    def parts(self) -> Iterator[Element]:
        """Make all links and joints, parents first."""
        for body in range(self.model.nbody):
            if body:
                yield from self._carry(body)
            else:
                yield make_elements.link(self.bodies[0])

    def _carry(self, body: int) -> Iterator[Element]:
        """Make the joints that carry a body, and its links."""
        model, name = self.model, self.bodies[body]
        start = self.carriers[model.body_parentid[body]]
        at = write_origin(model.body_pos[body], model.body_quat[body], self.size)
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        if not count:
            yield from self._fix(f"{name}_fixed", start, name, at, self._inertial(body))
            return
        for joint in range(first, first + count):
            end = body if joint == first + count - 1 else 0
            start = yield from self._move(joint, start, at, end)
            at = write_origin((0.0, 0.0, 0.0), _NO_TURN, self.size)
        self.carriers[body] = start

    def _move(
        self, joint: int, start: str, at: Element, end: int
    ) -> Generator[Element, None, str]:
        """Make a moving joint and its link; a joint beside the frame has fixed ones around it.

        Args:
            start: name of the link before it.
            at: ``<origin>`` of the frame of the body there.
            end: the body that it carries, if no other joint of the body follows; else 0.

        Returns:
            Name of the link with the frame of the body after the joint.
        """
        model, name = self.model, self.joints[joint]
        point = model.jnt_pos[joint]
        beside = _TYPES[model.jnt_type[joint]] != "floating" and bool(np.abs(point).max())
        if beside and not is_identity(at):
            before = unused_name(f"{name}_base", self.links)
            yield from self._fix(f"{name}_fixed", start, before, at)
            start = before
        there = self.bodies[end] if end else unused_name(f"{name}_link", self.links)
        mass = self._inertial(end) if end else None
        place = write_origin(point, _NO_TURN, self.size) if beside else at
        yield self._joint(joint, start, there, place)
        yield make_elements.link(there, None if beside else mass)
        if not beside:
            return there
        back = unused_name(f"{there}_origin", self.links)
        yield from self._fix(
            f"{back}_fixed", there, back, write_origin(-point, _NO_TURN, self.size), mass
        )
        return back

    def _fix(
        self, joint: str, start: str, there: str, at: Element, mass: Element | None = None
    ) -> Iterator[Element]:
        """Make a link and the fixed joint that carries it."""
        yield make_elements.joint(unused_name(joint, self.moving), "fixed", start, there, at)
        yield make_elements.link(there, mass)

    def _joint(self, joint: int, start: str, there: str, at: Element) -> Element:
        """Make a moving joint, or a fixed one if it is held."""
        kind, name = _TYPES[self.model.jnt_type[joint]], self.joints[joint]
        axis = ""
        if kind in ("revolute", "prismatic"):
            axis = direction_words(self.model.jnt_axis[joint], self.axes[joint])
            kind = "continuous" if kind == "revolute" else kind
        if name in self.held:
            return make_elements.joint(name, "fixed", start, there, at)
        relation = self.relations.get(name)
        return make_elements.joint(name, kind, start, there, at, (axis, ""), mimic=relation)

    def _inertial(self, body: int) -> Element | None:
        """Make the ``<inertial>`` of a body, along the axes of the body."""
        model: Any = self.model
        mass = float(model.body_mass[body])
        if mass == 0.0:
            return None
        moments = model.body_inertia[body]
        R, largest = rotation_matrix(model.body_iquat[body]), float(np.abs(moments).max())
        tensor = round_to((R * moments) @ R.T, largest)
        given = np.array(self.tensors.get(self.bodies[body], [np.nan] * 6))[
            [[0, 3, 4], [3, 1, 5], [4, 5, 2]]
        ]
        if np.abs(given - tensor).max() <= DECOMPOSITION_ERROR * largest:
            tensor = given
        centre = number_words(round_to(model.body_ipos[body], self.size))
        return make_elements.inertial(mass, tensor, Element("origin", {"xyz": centre}))
