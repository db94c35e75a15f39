"""The frames of an SDF model: links, joints and frames, each placed in another one."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import NamedTuple

from kinematics.error_text import clean, closest_names
from kinematics.files.formats.sdf.fields import pose_steps
from kinematics.files.formats.sdf.steps import Shift, Steps, Turn, inverse_steps, simplify
from kinematics.files.urdf.validate_fields import check_only
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

WORLD = "world"
MODEL = "__model__"

# Deepest chain of frames: it bounds the time that poses take.
MAX_DEPTH = 1000


class SdfFrame(NamedTuple):
    """A frame: the element that places it, the frame that it is placed in, and its pose there.

    Attributes:
        element: the element.
        base: key of the other frame; empty for the model.
        steps: the pose.
        depth: number of frames between it and the model.
    """

    element: Element
    base: str
    steps: Steps
    depth: int = 0


class FrameTree:
    """The frames of a model by name."""

    def __init__(self, model: Element, frames: Mapping[str, SdfFrame]) -> None:
        """Order the frames from the model outwards.

        Raises:
            Refusal: a frame is placed in itself, or too deep.
        """
        self.frames = {MODEL: SdfFrame(model, "", ())}
        for start in frames:
            path: dict[str, None] = {}
            name = start
            while name not in self.frames:
                if name in path:
                    problem = "its pose is relative to itself, by way of other frames"
                    remedy = "let one of the frames be relative to the model"
                    raise Refusal(frames[name].element.label, problem, remedy)
                path[name] = None
                name = frames[name].base
            for name in reversed(path):
                depth = self.frames[frames[name].base].depth + 1
                if depth > MAX_DEPTH:
                    problem = f"its pose is more than {MAX_DEPTH} frames deep"
                    remedy = "give poses relative to the model"
                    raise Refusal(frames[name].element.label, problem, remedy)
                self.frames[name] = frames[name]._replace(depth=depth)

    def between(self, start: str, end: str) -> Steps:
        """Compute the pose of a frame in another one, by way of the first that both are in.

        Args:
            start: the other frame.
            end: the frame.
        """
        back: list[Steps] = []
        forth: list[Steps] = []
        while start != end:
            start_frame, other = self.frames[start], self.frames[end]
            if start_frame.depth >= other.depth:
                back.append(inverse_steps(start_frame.steps))
                start = start_frame.base
            else:
                forth.append(other.steps)
                end = other.base
        return simplify([step for part in (*back, *reversed(forth)) for step in part])

    def turns(self, start: str, end: str) -> tuple[Turn, ...]:
        """Compute the rotation from a frame to another one, without its shifts.

        Args:
            start: the first frame.
            end: the other frame.
        """
        turns = (step for step in self.between(start, end) if not isinstance(step, Shift))
        return tuple(step for step in simplify(turns) if isinstance(step, Turn))

    def check_name(self, owner: Element, name: str, item: Element) -> str:
        """Return the key of a frame that an element names.

        Args:
            item: the element with the name.

        Raises:
            Refusal: there is no such frame.
        """
        return _known(owner, name, item, self.frames)


def read_frames(model: Element) -> FrameTree:
    """Read the frames of a model; a joint is in the frame of its child by default.

    Args:
        model: the ``<model>``.

    Raises:
        Refusal: a pose cannot be read, or refers to a frame that does not exist.
    """
    items: dict[str, Element] = {}
    for tag in ("joint", "frame", "link"):
        items |= {item.name: item for item in model.every(tag)}
    names = {MODEL, *items}
    frames = {}
    for name, item in items.items():
        pose = check_only(item, "pose")
        given = ""
        if pose is not None:
            given = pose.attributes.get("relative_to", "") or pose.attributes.get("frame", "")
        base = _known(item, given or _default(item), pose or item, names)
        frames[name] = SdfFrame(item, base, pose_steps(item, pose))
    return FrameTree(model, frames)


def _default(item: Element) -> str:
    """Name the frame that an element is placed in unless its pose says otherwise."""
    if item.tag == "joint":
        child = check_only(item, "child")
        return child.text if child is not None and child.text else MODEL
    return item.attributes.get("attached_to", "") or MODEL


def _known(owner: Element, name: str, item: Element, names: Collection[str]) -> str:
    """Return the key of a frame; the world is where the model is."""
    if name == WORLD and name not in names:
        return MODEL
    if name not in names:
        problem = f"<{item.tag}> (line {item.line}): no frame is called '{clean(name)}'"
        remedy = f"correct the name; there are {closest_names(name, sorted(names))}"
        raise Refusal(owner.label, problem, remedy)
    return name
