"""The linkage as data: bodies, joints and loops.

Everything is written in the inertial frame at the reference pose, where all joint
positions are 0. Every joint has one degree of freedom; a joint of the file that has more
is a chain of such joints. Link ``i`` is the link that joint ``i`` carries, and link -1 is
the ground, so one integer names both a joint and the link after it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from kinematics.model.arrays import Chain, Made, freeze, once
from kinematics.numerics.array_types import Array, IntArray
from kinematics.wording import (
    count_noun,
    first_names,
    html_facts,
    number_text,
    repr_lines,
    vector_text,
)

if TYPE_CHECKING:
    from kinematics.model.document.element import Document, Element


GROUND = -1


class Notice(NamedTuple):
    """A remark for the user.

    Attributes:
        code: a stable name, for scripts.
        message: one readable line.
        names: what the message lists after a colon and short forms leave out; empty for none.
    """

    code: str
    message: str
    names: str = ""

    def to_dict(self) -> dict[str, str]:
        """Return code and message as plain data for JSON."""
        return {"code": self.code, "message": self.message}


@dataclass(frozen=True, eq=False)
class Joint:
    """One degree of freedom between two links.

    Attributes:
        name: name in the file; ``name.0``, ``name.1`` … for a joint of several degrees.
        kind: ``"revolute"``, ``"prismatic"`` or ``"helical"``.
        parent: link that carries the joint (``GROUND`` or an earlier joint's index).
        screw: ``[n; r × n + λ n]``, or ``[0; n]`` if prismatic; shape (6,), SI units.
        point: a point of the joint, for drawing and for scaling; shape (3,), metres.
        in_loop: whether the joint belongs to a loop closure rather than to the tree.
        numbered: whether it is part of a joint of several degrees.
    """

    name: str
    kind: str
    parent: int
    screw: Array
    point: Array
    in_loop: bool = False
    numbered: bool = False

    def __repr__(self) -> str:
        """Give one line: kind, point and axis."""
        where = f"{vector_text(self.point)} m, axis {vector_text(self.direction)}"
        return f"Joint {self.name}: {self.kind} at {where}"

    @property
    def direction(self) -> Array:
        """Unit vector (3,) along the axis, or of the sliding of a prismatic joint."""
        return self.screw[3:] if self.kind == "prismatic" else self.screw[:3]

    @property
    def whole(self) -> str:
        """Name in the file of the joint, or of the joint of several degrees around it."""
        return self.name.rpartition(".")[0] if self.numbered else self.name


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body with inertial parameters.

    Attributes:
        name: name of its link in the file.
        link: index of its link; never ``GROUND``.
        inertia: ``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the inertial
            origin; shape (10,), SI units.
        frame: pose of the link frame of the file; shape (4, 4).
    """

    name: str
    link: int
    inertia: Array
    frame: Array

    def __repr__(self) -> str:
        """Give one line: mass and link."""
        return f"Body {self.name}: {number_text(self.inertia[0])} kg, on link {self.link}"


@dataclass(frozen=True, eq=False)
class Loop:
    """A weld of link ``end`` to link ``successor``.

    The joint of the loop, if any, lies between the predecessor and ``end``.

    Attributes:
        name: name in the file.
        end: link at the far side of the loop's joint.
        successor: link that it is welded to; may be ``GROUND``.
        gap: displacement, in the inertial frame, that carries the frame of the weld on
            ``end`` onto the one on ``successor``; shape (4, 4), the identity once closed.
    """

    name: str
    end: int
    successor: int
    gap: Array = field(default_factory=lambda: freeze(np.eye(4)))

    def __repr__(self) -> str:
        """Give one line: the two links of the weld."""
        far = "the ground" if self.successor == GROUND else f"link {self.successor}"
        return f"Loop {self.name}: link {self.end} welded to {far}"


@dataclass(frozen=True, eq=False)
class Mimic:
    """A joint that follows another: ``q[joint] = ratio * q[source]``.

    Both positions are displacements from the reference pose.

    Attributes:
        joint: index of the joint that follows.
        source: index of the joint that it follows.
        ratio: in the units of ``joint`` over the units of ``source``.
    """

    joint: int
    source: int
    ratio: float


class LinkPose(NamedTuple):
    """The pose of a link of the file.

    Attributes:
        link: the rigid body that it is part of; -1 is the ground.
        pose: of its frame in the inertial frame; shape (4, 4).
    """

    link: int
    pose: Array

    def __repr__(self) -> str:
        """Give one line: the rigid body, and the origin of the frame."""
        return f"LinkPose: on link {self.link}, origin {vector_text(self.pose[:3, 3])} m"


class MeantGeometry(NamedTuple):
    """Rational screws of a linkage inside the intervals of the digits of its file.

    Screws are those of `Geometry.screws` in `kinematics.files.urdf.rational_screws`. In all of
    them the axes of planar and of spherical loops are exactly parallel, and exactly meet.

    Attributes:
        screws: of the linkage as it is meant, with the relations that hold inside all
            intervals (n, 6).
        plain: of the linkage as written, with the relations that its decimals have (n, 6).
        near: of the special linkage just outside of the intervals (n, 6); None without one.
        relations: of ``screws``, in words.
        near_relations: further ones of ``near``, in words.
        digits: significant digits of the file; 0 if its numbers are exact, and only a pose
            is rounded.
        distance: largest error of the relations, in parts of the size: of ``near``, if there
            is one, otherwise of ``screws``.
        nearness: the same in half widths of the intervals.
        in_decimals: whether the decimals of the file have all of ``relations`` themselves.
        apart: number of joints that ``relations`` do not name.
    """

    screws: tuple[tuple[Fraction, ...], ...]
    plain: tuple[tuple[Fraction, ...], ...]
    near: tuple[tuple[Fraction, ...], ...] | None
    relations: tuple[str, ...]
    near_relations: tuple[str, ...]
    digits: int
    distance: float
    nearness: float
    in_decimals: bool = False
    apart: int = 0

    def __repr__(self) -> str:
        """Give one line: digits and relations."""
        words = ", ".join(self.relations) or "no relation"
        return f"MeantGeometry of {self.digits} digits: {words}"


@dataclass(frozen=True, eq=False)
class UnassembledLinkage:
    """A linkage as its file describes it, before its loops are closed.

    Attributes:
        name: name of the robot in the file.
        source: path of the file.
        joints: parents first; the joints of the tree before those of the loops.
        bodies: moving bodies that carry inertial parameters.
        loops: the welds.
        mimics: joints that follow others.
        named_inputs: joints that the file marks as independent.
        notices: remarks of the reader.
        places: poses of all links of the file, by name.
        tree: the elements of the file it was read from, with their decimals, or None.
        document: that file, if it was read from a stream or the linkage was built without one,
            so that it cannot be read again.
        displaced: positions of all joints (n,) at the reference pose, measured from the pose
            of the file, in radians and metres; None if it is that pose.
        at: coordinates of the inputs at the reference pose, by name, counted likewise, if a
            caller asked for that pose; else None.
        other_poses: positions of all joints (n,), counted likewise, at other poses that close
            loops which the file leaves open, with at most twice the motion of the one taken.
        mended: largest change of axes and welds with which overconstrained loops were made to
            close, in radians and parts of the size; 0 without one.
        meant: the geometry inside the digits of the file, at the reference pose; None if the
            numbers of the file are exact, or taken as written.
        as_written: whether the numbers of the file are taken as written.
    """

    name: str
    source: str
    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    loops: tuple[Loop, ...]
    mimics: tuple[Mimic, ...] = ()
    named_inputs: tuple[str, ...] = ()
    notices: tuple[Notice, ...] = ()
    places: Mapping[str, LinkPose] = field(default_factory=dict, repr=False)
    tree: Element | None = field(default=None, repr=False)
    document: Document | None = field(default=None, repr=False)
    displaced: Array | None = field(default=None, repr=False)
    at: Mapping[str, float] | None = None
    other_poses: tuple[Array, ...] = field(default=(), repr=False)
    mended: float = field(default=0.0, repr=False)
    meant: MeantGeometry | None = field(default=None, repr=False)
    as_written: bool = False

    def __repr__(self) -> str:
        """Give two lines: the numbers of parts, and the file."""
        parts = (
            count_noun(len(self.bodies), "body"),
            count_noun(len(self.joints), "joint"),
            count_noun(len(self.loops), "loop"),
        )
        head = f"{type(self).__name__} {self.name}: {', '.join(parts)}"
        return repr_lines(head, f"from {self.source}")


@dataclass(frozen=True, eq=False)
class Linkage(UnassembledLinkage):
    """A linkage at its reference pose, with loops closed and coordinates chosen.

    Attributes:
        mobility: degrees of freedom.
        inputs: names of the independent coordinates, as many as the mobility.
        idle: names of joints that do not move in any motion.
        frames: poses of the link frames of the bodies at the reference pose (bodies, 4, 4).
        chain: the linkage as arrays, planar if every link moves in parallel planes.
        spatial_chain: the same without the reduction to the plane.

    Example:
        >>> from kinematics import ScrewJoint, from_screws
        >>> arm = from_screws([ScrewJoint("j1", "base", "arm", point=(0.5, 0, 0))])
        >>> arm.mobility, arm.inputs, arm.planar
        (1, ('j1',), True)
    """

    mobility: int = 0
    inputs: tuple[str, ...] = ()
    idle: tuple[str, ...] = ()
    frames: Array = field(kw_only=True)
    chain: Chain = field(kw_only=True)
    spatial_chain: Chain = field(kw_only=True)
    _made: dict[tuple[object, ...], Any] = field(default_factory=dict, init=False, repr=False)

    def __repr__(self) -> str:
        """Give four lines: parts, mobility, bodies, file."""
        head, source = super().__repr__().split("\n")
        algebra = "planar" if self.planar else "spatial"
        moves = f"{algebra}, mobility {self.mobility}, inputs {first_names(self.inputs)}"
        return repr_lines(head, moves, f"bodies {first_names(names_of(self.bodies))}", source)

    def _repr_html_(self) -> str:
        """Table of the same facts, for notebooks."""
        return html_facts(
            f"{type(self).__name__} {self.name}",
            ("algebra", "planar" if self.planar else "spatial"),
            ("bodies", f"{len(self.bodies)}: {first_names(names_of(self.bodies))}"),
            ("joints", f"{len(self.joints)}: {first_names(names_of(self.joints))}"),
            ("loops", str(len(self.loops))),
            ("mobility", str(self.mobility)),
            ("inputs", first_names(self.inputs)),
            ("source", self.source),
        )

    @cached_property
    def body_names(self) -> tuple[str, ...]:
        """Names of the bodies, in their order."""
        return names_of(self.bodies)

    @property
    def sliding(self) -> frozenset[str]:
        """Names of the joints that slide: their displacements are metres, others radians."""
        return frozenset(joint.name for joint in self.joints if joint.kind == "prismatic")

    @property
    def planar(self) -> bool:
        """Whether the linkage moves in parallel planes."""
        return self.chain.planar

    @property
    def pose(self) -> str:
        """Text of the reference pose, if a caller asked for it; otherwise empty."""
        named = (
            f"{name} = {number_text(value, '.6g')} {'m' if name in self.sliding else 'rad'}"
            for name, value in (self.at or {}).items()
        )
        return f"{', '.join(named)} from the pose of the file" if self.at else ""

    def to_urdf(self) -> str:
        """Write the linkage as a URDF file with its loops, at its reference pose.

        `kinematics.load` reads the same linkage from it: screws, loops, inertial parameters,
        relations of joints, and inputs, which are marked. The pose of the file is the reference
        pose, so that coordinates count from there. The whole mass of a body is on the link it
        is named after; links that are fixed to it follow, as frames. Joints that turn have no
        limits, those that slide have limits of 1e9 m. Positions and axes are written to 15
        digits of the largest. A joint of several degrees of freedom of which only some are
        inputs is written as several joints.

        Returns:
            The text. Other programs read the tree of it, and pass over ``<loop>`` and
            ``<screw_thread_pitch>``. Where ``bodies="all"`` gave parameters to links without
            mass, read it with ``bodies="all"`` again; where angles such as 1.5708 were taken
            as written, with ``angles="as_written"``.

        Example:
            >>> from kinematics import ScrewJoint, from_screws
            >>> arm = from_screws([ScrewJoint("j1", "base", "arm", point=(0.5, 0, 0))])
            >>> '<origin xyz="0.5 0 0"/>' in arm.to_urdf()
            True
        """
        from kinematics.model.document.file_text import FileText
        from kinematics.model.document.linkage_text import urdf_text

        return FileText(urdf_text(self))

    def once(self, make: Callable[..., Made], *arguments: object) -> Made:
        """Return the result of a function of the linkage, computed once.

        Args:
            make: called with the linkage and the arguments.
            arguments: hashable.
        """
        return once(self._made, make, self, *arguments)

    def positions_of(self, joints: Sequence[str]) -> IntArray:
        """Find the indices of joints, by name, among all joints."""
        at = {joint.name: j for j, joint in enumerate(self.joints)}
        return np.array([at[name] for name in joints], dtype=np.int64)


def names_of(items: Sequence[Joint] | Sequence[Body] | Sequence[Loop]) -> tuple[str, ...]:
    """List the names of joints, bodies or loops, in order."""
    return tuple(item.name for item in items)
