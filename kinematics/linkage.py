"""The linkage as data: bodies, joints, loops, and the arrays that the kernels walk.

Everything is written in the inertial frame at the reference pose, where all joint
positions are 0. Every joint has one degree of freedom; a joint of the file that has more
is a chain of such joints. Link ``i`` is the link that joint ``i`` carries, and link -1 is
the ground, so one integer names both a joint and the link after it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from kinematics.profile import profile

if TYPE_CHECKING:
    from kinematics.reader.markup import Element

__all__ = [
    "GROUND",
    "Body",
    "Chain",
    "Draft",
    "Frame",
    "Joint",
    "Linkage",
    "Loop",
    "Mimic",
    "Notice",
    "Place",
    "frozen",
    "names",
    "shown",
]

GROUND = -1
Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Made = TypeVar("Made")


def frozen(array: object, dtype: type = np.float64) -> NDArray:
    """A read-only, contiguous copy of ``array``."""
    copy: NDArray = np.array(array, dtype=dtype, order="C")
    copy.flags.writeable = False
    return copy


def shown(array: NDArray) -> NDArray:
    """The same numbers, read-only: kernels are compiled again for what may be written to."""
    view = array.view()
    view.flags.writeable = False
    return view


class Notice(NamedTuple):
    """A remark for the user: a stable code for scripts, and one readable line."""

    code: str
    message: str


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

    @property
    def whole(self) -> str:
        """Name in the file of the joint that it is, or is part of."""
        return self.name.rpartition(".")[0] if self.numbered else self.name


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body with inertial parameters.

    Attributes:
        name: name of its link in the file.
        link: the link it is; never ``GROUND``.
        inertia: ``[m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` about the inertial
            origin; shape (10,), SI units.
        frame: pose of the link frame of the file; shape (4, 4).
    """

    name: str
    link: int
    inertia: Array
    frame: Array


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
    gap: Array = field(default_factory=lambda: frozen(np.eye(4)))


@dataclass(frozen=True, eq=False)
class Mimic:
    """A joint that follows another: ``q[joint] = ratio * q[source]``.

    Both positions are displacements from the reference pose. ``ratio`` is in the units of
    ``joint`` over the units of ``source``.
    """

    joint: int
    source: int
    ratio: float


class Place(NamedTuple):
    """Where a link of the file is.

    Attributes:
        link: the rigid body that it is part of; -1 is the ground.
        pose: of its frame in the inertial frame; shape (4, 4).
    """

    link: int
    pose: Array


@dataclass(frozen=True, eq=False)
class Draft:
    """A linkage as its file describes it, before its loops are closed.

    Attributes:
        name: name of the robot in the file.
        source: path of the file.
        joints: parents first; the joints of the tree before those of the loops.
        bodies: moving bodies that carry inertial parameters.
        loops: the welds.
        mimics: joints that follow others.
        named_inputs: joints that the file marks as independent.
        notices: what the reader has to tell.
        places: where every link of the file is, by name.
        tree: the elements of the file it was read from, with their decimals, or None.
        displaced: positions of all joints (n,) at the reference pose, measured from the pose
            of the file, in radians and metres; None if it is that pose.
    """

    name: str
    source: str
    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]
    loops: tuple[Loop, ...]
    mimics: tuple[Mimic, ...] = ()
    named_inputs: tuple[str, ...] = ()
    notices: tuple[Notice, ...] = ()
    places: Mapping[str, Place] = field(default_factory=dict, repr=False)
    tree: Element | None = field(default=None, repr=False)
    displaced: Array | None = field(default=None, repr=False)


@dataclass(frozen=True, eq=False)
class Frame:
    """Where the chain's coordinates stand: ``x_chain = R (x - origin) / length``.

    Attributes:
        R: rotation from inertial to chain axes (3, 3); its last row is the normal of a
            planar linkage.
        origin: middle of the mechanism (3,), metres.
        length: characteristic length, metres.
    """

    R: Array = field(default_factory=lambda: frozen(np.eye(3)))
    origin: Array = field(default_factory=lambda: frozen(np.zeros(3)))
    length: float = 1.0


@dataclass(frozen=True, eq=False)
class Chain:
    """A linkage as arrays; n moving joints, L loops, w independent columns.

    Attributes:
        frame: the coordinates in use.
        joints: index in the linkage of each joint (n,).
        units: SI units per unit of each joint position: 1 (radians) or the length (n,).
        parent: link before each joint, -1 for the ground (n,).
        screws: unit screws at the reference pose (n, 6), or ``[ω; v_x; v_y]`` (n, 3).
        ends: the two links welded by each loop (L, 2).
        mimics: rows of linear relations between joint positions (g, n).
        dependent: joints whose positions follow from the loops (d,).
        columns: joint rates of the independent joints for each column (n, w).
        moves: whether a column can move a link (n, w).
        links: link of each body with inertial parameters, -1 if it cannot move.
    """

    frame: Frame
    joints: IntArray
    units: Array
    parent: IntArray
    screws: Array
    ends: IntArray
    mimics: Array
    dependent: IntArray
    columns: Array
    moves: NDArray[np.bool_]
    links: IntArray

    @property
    def planar(self) -> bool:
        """Whether the chain is reduced to its plane."""
        return self.screws.shape[1] == 3

    @property
    def width(self) -> int:
        """Number of columns: degrees of freedom of the motion."""
        return self.columns.shape[1]

    @cached_property
    def lines(self) -> IntArray:
        """The profile of the loop matrix of the dependent joints; see `kinematics.profile`."""
        dim = self.screws.shape[1]
        return frozen(
            profile(self.parent, self.ends, self.mimics, self.dependent, dim), np.int64
        )

    @cached_property
    def walked(self) -> tuple[NDArray[Any], ...]:
        """The arrays that kernels of the motion walk, in their order."""
        return (
            self.parent, self.screws, self.ends, self.mimics, self.columns, self.moves,
            self.lines,
        )  # fmt: skip

    @cached_property
    def _made(self) -> dict[Callable[[Chain], Any], Any]:
        """What functions made of the chain."""
        return {}

    def once(self, make: Callable[[Chain], Made]) -> Made:
        """What a function makes of the chain, made once."""
        try:
            found: Made = self._made[make]
        except KeyError:
            found = self._made[make] = make(self)
        return found

    @cached_property
    def _spare(self) -> dict[tuple[int, ...], list[Any]]:
        """Room that nobody uses, by what it is for."""
        return {}

    def borrow(self, purpose: tuple[int, ...], make: Callable[[], Any]) -> Any:
        """Room for kernels that belongs to the caller alone: made, or given back before."""
        try:
            return self._spare[purpose].pop()
        except (KeyError, IndexError):
            return make()

    def give_back(self, purpose: tuple[int, ...], room: Any) -> None:
        """Keep room for the next who borrows some for the same purpose."""
        self._spare.setdefault(purpose, []).append(room)


@dataclass(frozen=True, eq=False)
class Linkage(Draft):
    """A linkage at its reference pose, with loops closed and coordinates chosen.

    Attributes:
        mobility: degrees of freedom.
        inputs: names of the independent coordinates, as many as the mobility.
        idle: names of joints that do not move in any motion.
        frames: poses of the link frames of the bodies at the reference pose (bodies, 4, 4).
        chain: the linkage as arrays, planar if every link moves in parallel planes.
        spatial_chain: the same without the reduction to the plane.
    """

    mobility: int = 0
    inputs: tuple[str, ...] = ()
    idle: tuple[str, ...] = ()
    frames: Array = field(kw_only=True)
    chain: Chain = field(kw_only=True)
    spatial_chain: Chain = field(kw_only=True)

    @property
    def planar(self) -> bool:
        """Whether the linkage moves in parallel planes."""
        return self.chain.planar

    def positions_of(self, joints: Sequence[str]) -> IntArray:
        """Where joints of these names stand among all joints."""
        at = {joint.name: j for j, joint in enumerate(self.joints)}
        return np.array([at[name] for name in joints], dtype=np.int64)


def names(items: Sequence[Joint] | Sequence[Body] | Sequence[Loop]) -> tuple[str, ...]:
    """The names of joints, bodies or loops, in order."""
    return tuple(item.name for item in items)
