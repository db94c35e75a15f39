"""Read a URDF file to an unassembled linkage.

The checks reject invalid files, and the YAML file beside it may add loops. Frames and inertias
come from the checked tree, or from a model that yourdfpy has loaded; types, axes, loops, screw
pitches and input marks come from the tree.

The inertial frame is the frame of the root link. The pose of the file, where every joint
coordinate is zero (that of a mimic joint: its offset), becomes the reference pose.
"""

from __future__ import annotations

import heapq
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from kinematics.error_text import clean, closest_names
from kinematics.errors import FileError
from kinematics.files.urdf.floating_joints import settle_floating_joints
from kinematics.files.urdf.loop_file import merge_loop_file
from kinematics.files.urdf.loop_joints import (
    attach_loop,
    freedoms_of_joint,
    has_one_axis,
    perpendicular_to,
    unit_vector,
)
from kinematics.files.urdf.read_options import Path, ReadOptions, RobotFile
from kinematics.files.urdf.robot_tree import Follows, Inertial, Robot, TreeJoint, describe_robot
from kinematics.files.urdf.validate import validate_robot
from kinematics.model.arrays import freeze
from kinematics.model.document.element import Element
from kinematics.model.document.joint_types import coordinate_names
from kinematics.model.linkage import (
    GROUND,
    Body,
    Joint,
    LinkPose,
    Loop,
    Mimic,
    Notice,
    UnassembledLinkage,
)
from kinematics.model.spatial.inertia import parameters
from kinematics.model.spatial.screws import exp, revolute
from kinematics.numerics.array_types import Array

if TYPE_CHECKING:
    from yourdfpy import URDF

# Code of the notice on links that carry no parameters.
MASSLESS = "massless"
# Names that are few enough to be listed in short forms of a notice, too.
FEW_NAMES = 3


def read_linkage(source: str, file: RobotFile, options: ReadOptions) -> UnassembledLinkage:
    """Build an unassembled linkage from a checked file.

    Args:
        source: name of the file in messages, and its path unless it has a document.
        options: changes to the file.

    Returns:
        The linkage of the file, with its loops not yet closed.

    Raises:
        FileError: the file is not a linkage that can move; the message gives the reason.
    """
    draft = _build_linkage(describe_robot(file.tree), file, source, options)
    return replace(draft, tree=file.tree, document=file.document)


def read_loaded_model(
    model: URDF, loops: Path | None = None, options: ReadOptions | None = None
) -> UnassembledLinkage:
    """Build an unassembled linkage from a model that yourdfpy has loaded.

    yourdfpy drops ``<loop>`` elements, screw pitches and input marks, and converts angles to
    rotation matrices, which are read as they are. In the reference pose all joints are at
    zero, whatever the configuration of the model.

    Args:
        loops: a YAML file with its loops; see `kinematics.files.urdf.loop_file`.
        options: changes to the model.

    Returns:
        The linkage of the model, with its loops not yet closed.

    Raises:
        FileError: the model is not a linkage; the message gives place and reason.
    """
    from kinematics.files.urdf.yourdfpy_adapter import set_poses, tree_of

    options = options or ReadOptions()
    source = model.robot.name or "URDF"
    tree = validate_robot(tree_of(model), source)
    side = merge_loop_file(tree, source, loops, search=False)
    side = settle_floating_joints(side, source, options.fix_base)
    return _build_linkage(set_poses(describe_robot(side.tree), model), side, source, options)


def _build_linkage(
    robot: Robot, side: RobotFile, source: str, options: ReadOptions
) -> UnassembledLinkage:
    """Build the unassembled linkage of a robot.

    Raises:
        FileError: no joint moves, no moving link carries parameters, or a massless link does
            not exist.
    """
    file, tree = clean(source, 1000), side.tree
    mimics = {joint.name: joint.mimic for joint in robot.joints if joint.mimic is not None}
    joints, places = _place_joints(robot, _mimic_positions(mimics))
    if not joints:
        remedy = "give a linkage with joints that are not fixed"
        raise FileError(file, "", "no joint moves", remedy)
    bodies = _bodies(robot, places, options, file)
    bare = not bodies and not options.massless
    if bare:
        bodies = _bodies(robot, places, options._replace(bodies="all"), file)
    if not bodies:
        remedy = "give the links that move a mass and an inertia, or use --bodies all"
        raise FileError(file, "", "no moving link has an <inertial>", remedy)
    loops = _attach_loops(tree, places, joints)
    return UnassembledLinkage(
        name=robot.name,
        source=source,
        joints=tuple(joints),
        bodies=tuple(bodies),
        loops=tuple(loops),
        mimics=tuple(_mimics(mimics, joints)),
        named_inputs=_inputs(tree) if side.inputs is None else side.inputs,
        notices=(
            *(Notice(*remark) for remark in side.remarks),
            *_notices(places, bodies, bare),
        ),
        places={
            name: LinkPose(place.link, freeze(place.pose)) for name, place in places.items()
        },
    )


def _sort_parents_first(joints: Sequence[TreeJoint], root: str) -> list[TreeJoint]:
    """Sort joints so that parents come first, otherwise in the order of the file."""
    hanging: dict[str, list[int]] = {}
    for i, joint in enumerate(joints):
        hanging.setdefault(joint.parent, []).append(i)
    ready = hanging.get(root, [])[:]
    order = []
    while ready:
        joint = joints[heapq.heappop(ready)]
        order.append(joint)
        for i in hanging.get(joint.child, ()):
            heapq.heappush(ready, i)
    return order


def _mimic_positions(mimics: Mapping[str, Follows]) -> dict[str, float]:
    """Compute positions of mimic joints at the pose of the file: ratio × source + offset."""
    positions: dict[str, float] = {}
    for start in mimics:
        path = [start]
        while path[-1] in mimics and path[-1] not in positions:
            path.append(mimics[path[-1]].joint)
        position = positions.get(path.pop(), 0.0)
        for name in reversed(path):
            position = mimics[name].multiplier * position + mimics[name].offset
            positions[name] = position
    return positions


def _place_joints(
    robot: Robot, offsets: Mapping[str, float]
) -> tuple[list[Joint], dict[str, LinkPose]]:
    """Compute the joints of the tree, and the pose of every link of the file, root first."""
    carried = {joint.child for joint in robot.joints}
    root = next(name for name in robot.links if name not in carried)
    places = {root: LinkPose(GROUND, np.eye(4))}
    joints: list[Joint] = []
    for joint in _sort_parents_first(robot.joints, root):
        link, pose = places[joint.parent]
        frame = pose @ joint.origin
        names = coordinate_names(joint.name, joint.kind)
        for name, (kind, screw) in zip(names, _freedoms(joint.element, frame), strict=True):
            point, several = freeze(frame[:3, 3]), len(names) > 1
            joints.append(Joint(name, kind, link, freeze(screw), point, numbered=several))
            link = len(joints) - 1
        if offsets.get(joint.name):
            frame = exp(joints[link].screw, offsets[joint.name]) @ frame
        places[joint.child] = LinkPose(link, frame)
    return joints, places


def _freedoms(joint: Element, frame: Array) -> list[tuple[str, Array]]:
    """Kinds and screws of a joint whose frame has the pose ``frame`` (4, 4)."""
    if joint.attributes["type"] == "fixed":
        return []
    first, second = joint.first("axis"), joint.first("axis2")
    axis = unit_vector(first.vector("xyz", "") if first else [1.0, 0.0, 0.0])
    kind, n, point = joint.attributes["type"], frame[:3, :3] @ axis, frame[:3, 3]
    thread = joint.first("screw_thread_pitch")
    pitch = thread.vector("value", "")[0] / (2 * np.pi) if thread else 0.0
    if pitch:
        return [("helical", revolute(n, point, pitch))]
    if has_one_axis(kind):
        return freedoms_of_joint(kind, n, None, point)
    across = perpendicular_to(axis, second.vector("xyz", "") if second else None)
    return freedoms_of_joint(kind, n, frame[:3, :3] @ across, point)


def inertial_parameters(inertial: Inertial, pose: Array) -> Array:
    """Compute the inertial parameters (10,) of a link about the inertial origin, SI units.

    The file has the tensor about the centre of mass, along the axes of the ``<inertial>``.

    Args:
        inertial: mass, tensor and centre of mass of the file.
        pose: of the frame of the link in the inertial frame (4, 4).
    """
    frame = pose @ inertial.origin
    R = frame[:3, :3]
    return parameters(inertial.mass, frame[:3, 3], R @ inertial.inertia @ R.T)


def _bodies(
    robot: Robot, places: Mapping[str, LinkPose], options: ReadOptions, file: str
) -> list[Body]:
    """Moving rigid bodies that carry parameters, each named after its topmost link.

    An ``<inertial>`` of zeros, as on the links between the axes of a spherical joint, counts
    as none.
    """
    top: dict[int, str] = {}
    for name, place in places.items():
        top.setdefault(place.link, name)
    sums = {link: np.zeros(10) for link in top if link != GROUND}
    for name, inertial in robot.links.items():
        place = places[name]
        if place.link != GROUND and inertial is not None:
            sums[place.link] += inertial_parameters(inertial, place.pose)
    for name in options.massless:
        sums.pop(_massless_link(name, places, top, file), None)
    return [
        Body(top[link], link, freeze(sums[link]), freeze(places[top[link]].pose))
        for link in sorted(sums)
        if options.bodies == "all" or sums[link].any()
    ]


def _massless_link(
    name: str, places: Mapping[str, LinkPose], top: Mapping[int, str], file: str
) -> int:
    """Find the link of a massless body; a link fixed to another does not stand for it."""
    label = f"massless link '{clean(name)}'"
    if name not in places:
        moving = [link for index, link in top.items() if index != GROUND]
        remedy = f"choose from {closest_names(name, moving)}"
        raise FileError(file, label, "does not exist", remedy)
    whole = top[places[name].link]
    if whole != name and places[name].link != GROUND:
        problem = f"fixed to link '{clean(whole)}', which the body is named after"
        raise FileError(file, label, problem, f"name '{clean(whole)}' to close all of it")
    return places[name].link


def _attach_loops(
    tree: Element, places: Mapping[str, LinkPose], joints: list[Joint]
) -> list[Loop]:
    """Append the joints of the loops to ``joints``, and return the welds."""
    extent = max(float(np.abs(place.pose[:3, 3]).max()) for place in places.values())
    welds = []
    for element in tree.every("loop"):
        chain, weld = attach_loop(element, places, joints, extent)
        joints.extend(chain)
        welds.append(weld)
    return welds


def _mimics(mimics: Mapping[str, Follows], joints: Sequence[Joint]) -> list[Mimic]:
    index = {joint.name: i for i, joint in enumerate(joints)}
    return [
        Mimic(index[name], index[mimic.joint], mimic.multiplier)
        for name, mimic in mimics.items()
    ]


def _inputs(tree: Element) -> tuple[str, ...]:
    """Coordinates of the joints and loops that are marked as independent."""
    marked = [
        coordinate_names(item.name, item.attributes["type"])
        for item in tree.every("joint") + tree.every("loop")
        if item.attributes.get("independent") == "true"
    ]
    return tuple(name for names in marked for name in names)


def _notices(
    places: Mapping[str, LinkPose], bodies: Sequence[Body], none_given: bool
) -> tuple[Notice, ...]:
    """Moving bodies that carry no parameters, or parameters without any mass in the file."""
    if none_given:
        text = "no moving link has an <inertial>: each carries parameters, as by --bodies all"
        return (Notice("no_masses", text),)
    links = {GROUND, *(body.link for body in bodies)}
    bare = []
    for name, place in places.items():
        if place.link not in links:
            links.add(place.link)
            bare.append(name)
    if not bare:
        return ()
    what, names = "no mass, so no parameters", ", ".join(bare)
    if len(bare) <= FEW_NAMES:
        return (Notice(MASSLESS, f"{what}: {names}"),)
    return (Notice(MASSLESS, f"{what}: {len(bare)} links: {names}", names),)
