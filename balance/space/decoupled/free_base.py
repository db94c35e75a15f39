"""A linkage whose base moves freely and carries inertial parameters of its own."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from balance.space.spaces.design_space import DesignSpace
from kinematics.closure.assembly.assemble import assemble
from kinematics.model.arrays import freeze
from kinematics.model.document import make_elements
from kinematics.model.document.element import Element
from kinematics.model.document.write_numbers import number_words
from kinematics.model.linkage import (
    GROUND,
    Body,
    Joint,
    Linkage,
    LinkPose,
    UnassembledLinkage,
    names_of,
)
from kinematics.model.motion import Motion

Array = NDArray[np.float64]

# Name of the base and of its joints, with signs in front where the file uses it.
BASE = "free_base"


def with_free_base(space: DesignSpace) -> Linkage:
    """Put the linkage of a design space on a base that moves freely.

    The base has six degrees of freedom, or three in the plane of the motion. Its parameters
    are the negative of those of all bodies together, so that the masses of the file have no
    momentum when the base moves with the linkage locked at the reference pose.

    Args:
        space: a design space of the linkage.

    Returns:
        The linkage at the same pose; the joints of the base come before its own, and the base
        before its bodies.
    """
    linkage = space.linkage
    joints = tuple(_base_joints(space))
    count = len(joints)

    def shifted(link: int) -> int:
        return count - 1 if link == GROUND else link + count

    given = np.array([body.inertia for body in linkage.bodies]).reshape(-1, 10)
    base = Body(joints[0].whole, count - 1, freeze(-given.sum(axis=0)), freeze(np.eye(4)))
    entries = {f.name: getattr(linkage, f.name) for f in fields(UnassembledLinkage)}
    draft = UnassembledLinkage(**entries | {
        "joints": (*joints, *(replace(j, parent=shifted(j.parent)) for j in linkage.joints)),
        "bodies": (base, *(replace(b, link=shifted(b.link)) for b in linkage.bodies)),
        "loops": tuple(
            replace(x, end=shifted(x.end), successor=shifted(x.successor))
            for x in linkage.loops
        ),
        "mimics": tuple(
            replace(x, joint=x.joint + count, source=x.source + count)
            for x in linkage.mimics
        ),
        "named_inputs": (),
        "notices": (),
        "places": {
            name: LinkPose(shifted(place.link), place.pose)
            for name, place in linkage.places.items()
        },
        "tree": None if linkage.tree is None else _tree_with(linkage.tree, joints),
        "displaced": _displaced(linkage, count),
        "other_poses": (),
    })  # fmt: skip
    return assemble(draft, (*names_of(joints), *linkage.inputs), exactly=True)


def free_base_motion(space: DesignSpace, linkage: Linkage) -> Motion | None:
    """Extend the motion of a design space by free motion of the base.

    Args:
        space: the design space of the linkage on the ground.
        linkage: the result of `with_free_base`.
    """
    motion = space.motion
    if motion is None:
        return None
    if motion.relations:
        return Motion.parse(motion.relations, linkage.inputs)
    count = len(linkage.inputs) - len(motion.inputs)
    rows, columns = motion.basis.shape
    basis = np.zeros((count + rows, count + columns))
    basis[:count, :count] = np.eye(count)
    basis[count:, count:] = motion.basis
    return Motion((*linkage.inputs[:count], *motion.inputs), (), freeze(basis))


def _base_joints(space: DesignSpace) -> Iterator[Joint]:
    """Make the joints of the base: translations first, and rotations about the middle."""
    frame = space.chain.frame
    names = {*names_of(space.linkage.joints), *space.linkage.places}
    name = BASE
    while any(taken.startswith(name) for taken in names):
        name = f"_{name}"
    # In a plane, two translations along it and a rotation about its normal.
    axes = frame.R if space.planar else np.eye(3)
    steps = [("prismatic", n) for n in axes[: 2 if space.planar else 3]]
    steps += [("revolute", n) for n in axes[2 if space.planar else 0 :]]
    for k, (kind, n) in enumerate(steps):
        turning = kind == "revolute"
        screw = [n, np.cross(frame.origin, n)] if turning else [np.zeros(3), n]
        yield Joint(
            f"{name}.{k}", kind, k - 1, freeze(np.concatenate(screw)), freeze(frame.origin),
            numbered=True,
        )  # fmt: skip


def _displaced(linkage: Linkage, count: int) -> Array | None:
    """Return the positions of all joints; those of the base are zero."""
    if linkage.displaced is None:
        return None
    return freeze(np.concatenate([np.zeros(count), linkage.displaced]))


def _tree_with(tree: Element, joints: Sequence[Joint]) -> Element:
    """Put the base joints under the root link of a tree of elements, at its frame."""
    carried = {
        side.attributes["link"]
        for joint in tree.every("joint")
        for side in joint.every("child")
    }
    roots = [link.name for link in tree.every("link") if link.name not in carried]
    added = [make_elements.link(joint.name) for joint in joints]
    added.append(make_elements.link(joints[0].whole))
    ends = [item.name for item in added]
    at = np.zeros(3)
    for joint, parent, child in zip(joints, ends, ends[1:], strict=False):
        turning = joint.kind == "revolute"
        here = joint.point if turning else at
        axis = number_words(joint.screw[:3] if turning else joint.screw[3:])
        kind = "continuous" if turning else "prismatic"
        step = _origin(here - at)
        added.append(make_elements.joint(joint.name, kind, parent, child, step, (axis, "")))
        at = here
    fixed = make_elements.joint(joints[0].whole, "fixed", ends[-1], roots[0], _origin(-at))
    return replace(tree, children=(*added, fixed, *tree.children))


def _origin(shift: Array) -> Element:
    """Make the ``<origin>`` of a translation (3,), metres."""
    return Element("origin", {"xyz": number_words(shift)})
