"""Read the joints of an SDF model: their links, types, axes, pitches and mimics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from kinematics.error_text import clean, closest_names
from kinematics.files.formats.sdf.fields import is_true, needed_text, number_texts
from kinematics.files.formats.sdf.frames import MODEL, WORLD, FrameTree
from kinematics.files.formats.sdf.steps import negated, to_decimal
from kinematics.files.urdf.validate_fields import check_only
from kinematics.files.urdf.xml_tree import Refusal
from kinematics.model.document.element import Element

_TYPES = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "ball": "spherical",
    "universal": "universal",
    "revolute2": "universal",
    "screw": "continuous",
}
_NO_AXIS = ("fixed", "spherical")
# Version since which axes are in the frame of the joint, not of the model.
_AXES_IN_JOINT = 5


@dataclass(frozen=True)
class Axis:
    """An axis: the element, the frame that it is in, and its numbers as they are written."""

    element: Element
    frame: str
    words: tuple[str, ...]

    def text(self, sign: int) -> str:
        """Write the axis, or its opposite for a sign of -1."""
        return " ".join(self.words if sign > 0 else map(negated, self.words))


@dataclass(frozen=True)
class ModelJoint:
    """A joint of a model.

    Attributes:
        element: the element.
        kind: type of the joint in URDF.
        parent: its parent link, or the ground.
        child: its child link.
        axes: none, one or two.
        extra: pitch and mimic, as elements of URDF.
        locked: whether its limits leave it no motion.
    """

    element: Element
    kind: str
    parent: str
    child: str
    axes: tuple[Axis, ...] = ()
    extra: tuple[Element, ...] = ()
    locked: bool = False

    @property
    def name(self) -> str:
        """Name in the file."""
        return self.element.name


class LinkNames:
    """Names that joints may use for links: those of links, and of frames and joints on them."""

    def __init__(self, model: Element) -> None:
        """Collect the links, and what is attached to them."""
        self.links: Mapping[str, Element] = {item.name: item for item in model.every("link")}
        first = next(iter(self.links), "")
        self.canonical = model.attributes.get("canonical_link", "") or first
        self.attached = {
            item.name: item.attributes.get("attached_to", "") or MODEL
            for item in model.every("frame")
        }
        for joint in model.every("joint"):
            child = joint.first("child")
            self.attached.setdefault(joint.name, child.text if child is not None else "")
        self.attached[MODEL] = self.canonical

    def link_of(self, joint: Element, role: str) -> str:
        """Return the link on one side of a joint, or the ground.

        Args:
            role: ``"parent"`` or ``"child"``.

        Raises:
            Refusal: there is no such link, or frames are attached in a circle.
        """
        given = name = needed_text(joint, role)
        for _ in range(len(self.attached) + 1):
            if name in self.links or (name == WORLD and role == "parent"):
                return name
            if name not in self.attached:
                break
            name = self.attached[name]
        problem = f"{role} link '{clean(given)}' does not exist"
        if name == WORLD:
            problem = "its child is the world"
        remedy = f"correct the name; the links are {closest_names(given, self.links)}"
        raise Refusal(joint.label, problem, remedy)


def read_joint(joint: Element, names: LinkNames, frames: FrameTree, version: int) -> ModelJoint:
    """Read a joint.

    Args:
        names: the links of the model.
        frames: the frames of the model.
        version: minor number of the version of SDF.

    Raises:
        Refusal: its type is not one that is read, or a part is missing or malformed.
    """
    kind = joint.attributes.get("type", "")
    if kind not in _TYPES:
        problem = f"unknown type '{clean(kind)}'" if kind else "no type"
        remedy = f"choose from {', '.join(_TYPES)}"
        if kind == "gearbox":
            problem = "a gearbox joint is not supported"
            remedy = "remove it, and write <mimic> into the <axis> of one of the geared joints"
        raise Refusal(joint.label, problem, remedy)
    parent, child = (names.link_of(joint, role) for role in ("parent", "child"))
    if parent == child:
        remedy = "correct its <parent> or its <child>"
        raise Refusal(joint.label, f"joins link '{clean(child)}' to itself", remedy)
    kind_here = _TYPES[kind]
    tags = () if kind_here in _NO_AXIS else ("axis", "axis2")[: 1 + (kind_here == "universal")]
    axes = tuple(_read_axis(joint, tag, frames, version) for tag in tags)
    if len(axes) < 2 and tags and joint.first("axis2") is not None:
        raise Refusal(joint.label, f"<axis2> on a {kind} joint", "remove <axis2>")
    extra = (*_pitch(joint, kind), *_mimic(joint, kind_here))
    locked = bool(axes) and _is_locked(axes[0].element)
    return ModelJoint(joint, kind_here, parent, child, axes, extra, locked)


def _read_axis(joint: Element, tag: str, frames: FrameTree, version: int) -> Axis:
    """Read an axis, and the frame that it is in."""
    axis = check_only(joint, tag)
    xyz = check_only(joint, "xyz", axis) if axis is not None else None
    if axis is None or xyz is None:
        example = f"<{tag}><xyz>0 0 1</xyz></{tag}>"
        raise Refusal(joint.label, f"no {example[: len(tag) + 7]}", f"write {example}")
    frame = frames.check_name(joint, xyz.attributes.get("expressed_in") or joint.name, xyz)
    flag = check_only(joint, "use_parent_model_frame", axis)
    if version < _AXES_IN_JOINT or is_true(joint, flag):
        frame = MODEL
    return Axis(axis, frame, tuple(number_texts(joint, xyz, 3)))


def _pitch(joint: Element, kind: str) -> tuple[Element, ...]:
    """Metres per turn of a right-handed screw; the old element has its negative in rad/m."""
    new, old = (check_only(joint, tag) for tag in ("screw_thread_pitch", "thread_pitch"))
    item = new or old
    if kind != "screw":
        return ()
    if item is None:
        remedy = "write its metres per turn as <screw_thread_pitch>0.01</screw_thread_pitch>"
        raise Refusal(joint.label, "no <screw_thread_pitch>", remedy)
    (word,) = number_texts(joint, item, 1)
    if not float(word):
        problem = f"<{item.tag}> (line {item.line}) is zero"
        raise Refusal(joint.label, problem, "write its pitch, or type revolute")
    value = word if item is new else repr(-2 * math.pi / float(word))
    return (Element("screw_thread_pitch", {"value": value}, (), item.line),)


def _mimic(joint: Element, kind: str) -> tuple[Element, ...]:
    """Position of the follower: multiplier × (position of the leader - reference) + offset."""
    axes = [axis for tag in ("axis2", "axis") for axis in joint.every(tag)]
    mimics = [(axis, item) for axis in axes if (item := check_only(joint, "mimic", axis))]
    if not mimics or kind == "fixed":
        return ()
    axis, mimic = mimics[0]
    if axis.tag == "axis2" or mimic.attributes.get("axis", "axis") != "axis":
        problem = f"<mimic> (line {mimic.line}) of a second axis is not supported"
        raise Refusal(joint.label, problem, "use joints with one axis")
    values = {"multiplier": "1", "offset": "0", "reference": "0"}
    for tag in values:
        item = check_only(joint, tag, mimic)
        if item is not None:
            (values[tag],) = number_texts(joint, item, 1)
    m, o, r = map(to_decimal, values.values())
    offset = str(o - m * r) if r else values["offset"]
    attributes = {"multiplier": values["multiplier"], "offset": offset}
    if "joint" in mimic.attributes:
        attributes["joint"] = mimic.attributes["joint"]
    return (Element("mimic", attributes, (), mimic.line),)


def _is_locked(axis: Element) -> bool:
    """Whether the limits of an axis are one position."""
    limit = axis.first("limit")
    ends = [limit.first(tag) for tag in ("lower", "upper")] if limit is not None else []
    texts = [end.text for end in ends if end is not None]
    try:
        return len(texts) == 2 and float(texts[0]) == float(texts[1])
    except ValueError:
        return False
