"""Write the links and joints of an SDF model as elements of a URDF file with loops.

The frame of a URDF link is that of the joint that carries it. If the two frames of SDF differ,
that of the joint is kept, in the directions in which its axis is written. Poses that are no
single ``<origin>`` become chains of fixed joints, so that every number keeps its digits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from kinematics.files.formats.sdf.frames import MODEL, WORLD, FrameTree
from kinematics.files.formats.sdf.inertials import convert_inertial, has_inertial
from kinematics.files.formats.sdf.model_joints import ModelJoint
from kinematics.files.formats.sdf.spanning_tree import SpanningTree
from kinematics.files.formats.sdf.steps import (
    Steps,
    Turn,
    inverse_steps,
    matrix_of,
    origins,
    simplify,
)
from kinematics.model.document.element import Element


class _Place(NamedTuple):
    """The frame of a URDF link: a frame of the model, turned by ``turns``."""

    frame: str
    turns: tuple[Turn, ...] = ()


class ModelWriter:
    """The writer of one model: frames of its URDF links, and names that are taken."""

    def __init__(
        self,
        links: Mapping[str, Element],
        frames: FrameTree,
        joints: Sequence[ModelJoint],
        ground: str,
        tree: SpanningTree,
        floating: Sequence[str] = (),
    ) -> None:
        """Choose the frames of the links.

        Args:
            links: links of the model by name.
            ground: the root of the tree: a link, or the world.
            tree: which joints are joints of the URDF file.
            floating: links that a floating joint connects to the ground.
        """
        self.ground, self.floating = ground, floating
        self.links, self.frames, self.joints, self.tree = links, frames, joints, tree
        self.places = {name: _Place(name) for name in links}
        if ground not in links:
            self.places[ground] = _Place(MODEL)
        for k in (*tree.forward, *tree.backward):
            self.places[self._carried(k)] = self._joint_place(k)
        self.taken = {*links, WORLD, *(joint.name for joint in joints)}
        self.leaders = {item.attributes.get("joint") for j in joints for item in j.extra}
        self.extra: list[Element] = []

    def moved_links(self) -> list[str]:
        """List the links whose frame is not that of the file."""
        places = self.places.items()
        return [name for name, place in places if name in self.links and place != (name, ())]

    def parts(self, line: int) -> tuple[Element, ...]:
        """Make the elements of links, joints and loops.

        Args:
            line: line of the world in messages, if it is a link.
        """
        world = [name for name in self.places if name not in self.links]
        links = [Element("link", {"name": name}, (), line) for name in world]
        links += map(self._make_link, self.links.values())
        closing = set(self.tree.closing)
        every = range(len(self.joints))
        joints = [self._make_joint(k) for k in every if k not in closing]
        joints += [self._make_floating(name) for name in self.floating]
        loops = [self._make_loop(self.joints[k]) for k in self.tree.closing]
        return (*links, *joints, *self.extra, *loops)

    def _carried(self, k: int) -> str:
        """Name the link that a joint of the tree carries."""
        joint = self.joints[k]
        return joint.child if k in self.tree.forward else joint.parent

    def _joint_place(self, k: int) -> _Place:
        """Choose the frame of the link that a joint of the tree carries."""
        joint, link = self.joints[k], self._carried(k)
        if joint.kind == "fixed":
            return _Place(link)
        place = self._axis_place(joint)
        between = self.frames.between(link, place.frame)
        return place if simplify([*between, *place.turns]) else _Place(link)

    def _axis_place(self, joint: ModelJoint) -> _Place:
        """Find the frame of a joint, in the directions in which its axis is written."""
        if not joint.axes:
            return _Place(joint.name)
        return _Place(joint.name, self.frames.turns(joint.name, joint.axes[0].frame))

    def _between(self, place: _Place, frame: str, turns: Sequence[Turn] = ()) -> Steps:
        """Compute the pose of a frame of the model, turned, in the frame of a URDF link."""
        between = self.frames.between(place.frame, frame)
        return simplify([*inverse_steps(place.turns), *between, *turns])

    def _make_link(self, link: Element) -> Element:
        """Make a link, with its inertia in its URDF frame."""
        inside: tuple[Element, ...] = ()
        if has_inertial(link):
            frame = self._between(self.places[link.name], link.name)
            inside = (convert_inertial(link, frame),)
        return Element("link", {"name": link.name}, inside, link.line)

    def _make_joint(self, k: int) -> Element:
        """Make a joint of the tree; one that is turned round has the opposite axis."""
        joint, child = self.joints[k], self._carried(k)
        forward = k in self.tree.forward
        parent = joint.parent if forward else joint.child
        steps = self._between(self.places[parent], *self.places[child])
        parent, origin = self._hang(joint.name, joint.element.line, parent, steps)
        axes = _axis_elements(joint, self._axis_texts(joint, 1 if forward else -1))
        return _joint_element(joint, (parent, child), (*origin, *axes, *joint.extra))

    def _make_floating(self, link: str) -> Element:
        """Make the floating joint of a link that no joint connects to the ground."""
        steps = self._between(self.places[self.ground], *self.places[link])
        name = self._free_name(f"{link}_floats")
        line = self.links[link].line
        parent, origin = self._hang(name, line, self.ground, steps)
        sides = (Element("parent", {"link": parent}), Element("child", {"link": link}))
        attributes = {"name": name, "type": "floating"}
        return Element("joint", attributes, (*sides, *origin), line)

    def _hang(
        self, joint: str, line: int, link: str, steps: Steps
    ) -> tuple[str, list[Element]]:
        """Hang fixed links on a link until the rest of a pose is one origin at most.

        Args:
            joint: name of the joint that needs them.
            line: its line in messages.
            steps: the pose in its frame.

        Returns:
            The last of these links, and the origin.
        """
        chain = origins(steps, line)
        while len(chain) > 1:
            name = self._free_name(f"{joint}_frame")
            sides = (Element("parent", {"link": link}), Element("child", {"link": name}))
            attributes = {"name": name, "type": "fixed"}
            self.extra.append(Element("link", {"name": name}, (), line))
            self.extra.append(Element("joint", attributes, (chain.pop(0), *sides), line))
            link = name
        return link, chain

    def _free_name(self, name: str) -> str:
        """Find a name that no link or joint has."""
        candidate, k = name, 1
        while candidate in self.taken:
            k += 1
            candidate = f"{name}{k}"
        self.taken.add(candidate)
        return candidate

    def _axis_texts(self, joint: ModelJoint, sign: int) -> list[str]:
        """Write the axes; those of a joint that is turned round change places and signs.

        A second axis in another frame than the first is written in floating point.
        """
        texts = [axis.text(sign) for axis in joint.axes]
        if len(joint.axes) == 2:
            first, second = joint.axes
            turns = self.frames.turns(first.frame, second.frame)
            if turns:
                R, _ = matrix_of(turns)
                axis = [sign * float(word) for word in second.words]
                rows = (sum(map(float.__mul__, row, axis)) for row in R)
                texts[1] = " ".join(map(repr, rows))
        return texts if sign > 0 else texts[::-1]

    def _make_loop(self, joint: ModelJoint) -> Element:
        """Make a ``<loop>``; a screw or a mimic becomes a joint, with a weld after it."""
        place = self._axis_place(joint)
        start, end = (
            self._hang(
                joint.name, joint.element.line, link, self._between(self.places[link], *place)
            )
            for link in (joint.parent, joint.child)
        )
        axes = _axis_elements(joint, self._axis_texts(joint, 1))
        if not joint.extra and joint.name not in self.leaders:
            attributes = {"name": joint.name, "type": joint.kind}
            return _loop_element(joint, attributes, (start, end), axes)
        name = self._free_name(f"{joint.name}_link")
        parts = (*start[1], *axes, *joint.extra)
        self.extra.append(Element("link", {"name": name}, (), joint.element.line))
        self.extra.append(_joint_element(joint, (start[0], name), parts))
        attributes = {"name": self._free_name(f"{joint.name}_weld"), "type": "fixed"}
        return _loop_element(joint, attributes, ((name, []), end), [])


def _axis_elements(joint: ModelJoint, texts: Sequence[str]) -> list[Element]:
    items = zip(("axis", "axis2"), texts, joint.axes, strict=False)
    return [Element(tag, {"xyz": text}, (), axis.element.line) for tag, text, axis in items]


def _joint_element(
    joint: ModelJoint, links: tuple[str, str], parts: Sequence[Element]
) -> Element:
    """Make a joint with the name and type of one of the model."""
    line = joint.element.line
    pairs = zip(("parent", "child"), links, strict=True)
    sides = [Element(role, {"link": link}, (), line) for role, link in pairs]
    attributes = {"name": joint.name, "type": joint.kind}
    return Element("joint", attributes, (*sides, *parts), line)


def _loop_element(
    joint: ModelJoint,
    attributes: Mapping[str, str],
    ends: Sequence[tuple[str, Sequence[Element]]],
    axes: Sequence[Element],
) -> Element:
    """Make a loop between two links, with the frame of the loop in each of them."""
    line = joint.element.line
    pairs = zip(("predecessor", "successor"), ends, strict=True)
    sides = [Element(role, {"link": link}, tuple(at), line) for role, (link, at) in pairs]
    return Element("loop", attributes, (*sides, *axes), line)
