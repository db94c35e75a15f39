"""Dyads between two links of a planar linkage: their numbers, their joints, and their file.

A dyad (Assur group of class two) is two links hinged to each other. Its first link is hinged to
link A. Its second link is hinged to link B (RRR), or slides along a line that is fixed in B
(RRP). It adds two links and three joints, and neither takes nor gives a degree of freedom. Its
numbers, in the plane of the linkage, are

    RRR   a hinge on A, the hinge between, a hinge on B     (x, y) each
    RRP   a hinge on A, the hinge between                   (x, y) each
          the angle of the line of sliding                  radians

at the reference pose, in the frame and units of the chain. Any such numbers close the loop.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from balance.masses.remedies.variant import append_elements, free_name, names_taken
from kinematics.model.arrays import Frame
from kinematics.model.document.element import Document, Element
from kinematics.model.document.make_elements import joint, link, loop, origin
from kinematics.model.document.write_numbers import number_words
from kinematics.numerics.array_types import Array

# Digits of positions in the file, of which the characteristic length has as many: decimals that
# follow from decimals of the linkage are then written exactly. With one digit less, in half of
# all directions what is left of relations between angles is near where ranks are in doubt.
DIGITS = 15


@dataclass(frozen=True, eq=False)
class DyadSide:
    """A link to which a dyad is attached.

    Attributes:
        name: of the link in the file.
        link: the rigid body that it is part of; -1 is the ground.
        pose: of its frame in the inertial frame (4, 4).
    """

    name: str
    link: int
    pose: Array


@dataclass(frozen=True, eq=False)
class Dyad:
    """Where a dyad is attached, and what kind it is.

    Attributes:
        sides: links A and B.
        slides: whether its second link slides along B (RRP), or is hinged to it (RRR).
    """

    sides: tuple[DyadSide, DyadSide]
    slides: bool

    @property
    def kind(self) -> str:
        """``"RRP"`` or ``"RRR"``."""
        return "RRP" if self.slides else "RRR"

    @property
    def size(self) -> int:
        """How many numbers describe its geometry."""
        return 5 if self.slides else 6

    def __repr__(self) -> str:
        """One line: the kind and the two links."""
        first, second = self.sides
        return f"Dyad {self.kind}: {first.name} to {second.name}"


def dyad_screws(dyad: Dyad, numbers: Array) -> Array:
    """Compute the screws of the three joints of a dyad.

    A hinge at (x, y) has ``[1; y, -x]``, a slide at angle φ ``[0; cos φ, sin φ]``.

    Args:
        numbers: its numbers; see the head of this file.

    Returns:
        ``[ω; v_x; v_y]`` of each (3, 3), chain units.
    """
    points = numbers[:4].reshape(2, 2) if dyad.slides else numbers.reshape(3, 2)
    hinges = np.column_stack([np.ones(len(points)), points[:, 1], -points[:, 0]])
    if not dyad.slides:
        return hinges
    return np.vstack([hinges, [0.0, np.cos(numbers[4]), np.sin(numbers[4])]])


def segments_of(dyad: Dyad, numbers: Array) -> Array:
    """Compute the lengths of the links of a dyad between their hinges.

    Returns:
        The lengths in characteristic lengths: two, or one if its second link slides.
    """
    points = numbers[: 4 if dyad.slides else 6].reshape(-1, 2)
    return np.asarray(np.sqrt(np.sum(np.diff(points, axis=0) ** 2, axis=1)))


def convert_numbers(dyad: Dyad, numbers: Array, given: Frame, wanted: Frame) -> Array:
    """Convert the numbers of a dyad from one frame of the same plane to another.

    Args:
        numbers: its numbers in the frame ``given``.
        given: a frame.
    """
    hinges = numbers[: 4 if dyad.slides else 6].reshape(-1, 2)
    points = np.array([_in_space(given, point) for point in hinges])
    out = (points - wanted.origin) @ wanted.R[:2].T / wanted.length
    if not dyad.slides:
        return np.asarray(out.ravel())
    along = wanted.R[:2] @ _direction(given, numbers[4])
    return np.append(out, np.arctan2(along[1], along[0]))


def dyad_document(
    base: Document, dyad: Dyad, numbers: Array, frame: Frame, stem: str = "dyad"
) -> tuple[Document, tuple[str, str], tuple[str, str, str]]:
    """Write a linkage with a dyad; its links carry no mass yet.

    Args:
        base: file of the linkage, at its reference pose.
        frame: of the chain of the linkage.
        stem: begin of the names of its links and joints.

    Returns:
        The file, the names of the two links, and those of the three joints.
    """
    taken = names_taken(base)
    links = free_name(f"{stem}_1", taken), free_name(f"{stem}_2", taken)
    joints = (
        free_name(f"{stem}_joint_1", taken),
        free_name(f"{stem}_joint_2", taken),
        free_name(f"{stem}_loop", taken),
    )
    return append_elements(base, _elements(dyad, numbers, frame, links, joints)), links, joints


def _elements(
    dyad: Dyad,
    numbers: Array,
    frame: Frame,
    links: tuple[str, str],
    joints: tuple[str, str, str],
) -> list[Element]:
    """Make the links, joints and loop; frames of new links are parallel to the inertial one."""
    first, second = dyad.sides
    count = 2 if dyad.slides else 3
    at = [_in_space(frame, point) for point in numbers[: 2 * count].reshape(count, 2)]
    digits = DIGITS - math.ceil(math.log10(frame.length))

    def place(pose: Array) -> Element:
        """Make an origin, with as many decimals as positions have digits."""
        return origin(np.block([[pose[:3, :3], pose[:3, 3:].round(digits)], [pose[3:]]]))

    axis = normal = number_words(frame.R[2])
    if dyad.slides:
        axis = number_words(_direction(frame, numbers[4]))
    inverse = np.linalg.inv(first.pose)
    return [
        link(links[0]), link(links[1]),
        joint(joints[0], "continuous", first.name, links[0],
              place(inverse @ _shift(at[0])), (normal, "")),
        joint(joints[1], "continuous", links[0], links[1], place(_shift(at[1] - at[0])),
              (normal, "")),
        loop(joints[2], "prismatic" if dyad.slides else "revolute",
             [(links[1], place(_shift(at[-1] - at[1]))),
              (second.name, place(np.linalg.inv(second.pose) @ _shift(at[-1])))], (axis, "")),
    ]  # fmt: skip


def _in_space(frame: Frame, point: Array) -> Array:
    """Convert a point of the plane from chain units (2,) to metres (3,)."""
    return np.asarray(frame.origin + frame.length * frame.R[:2].T @ point)


def _direction(frame: Frame, angle: float) -> Array:
    """Return the direction (3,) at an angle in the plane."""
    return np.asarray(frame.R[:2].T @ [np.cos(angle), np.sin(angle)])


def _shift(to: Array) -> Array:
    """Make the pose (4, 4) that is shifted without turning."""
    pose = np.eye(4)
    pose[:3, 3] = to
    return pose
