"""The linkage as arrays for kernels, and the frame in which they are written."""

from __future__ import annotations

import operator
from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.linalg.skyline_qr import envelope_table
from kinematics.wording import count_noun, number_text, vector_text

Made = TypeVar("Made")


def freeze(array: object, dtype: type = np.float64) -> NDArray:
    """Copy an array: read-only and contiguous.

    Args:
        array: anything that NumPy makes an array of.
        dtype: type of the numbers of the copy.
    """
    copy: NDArray = np.array(array, dtype=dtype, order="C")
    copy.flags.writeable = False
    return copy


def once(
    made: dict[tuple[object, ...], Any],
    make: Callable[..., Made],
    owner: object,
    *arguments: object,
) -> Made:
    """Return the result of a function of an object and of arguments, computed once.

    Args:
        made: results so far, by function and arguments.
        make: called with the object and the arguments.
        owner: the object.
        arguments: hashable.
    """
    key = (make, *arguments)
    try:
        value: Made = made[key]
    except KeyError:
        value = made[key] = make(owner, *arguments)
    return value


def read_only(array: NDArray) -> NDArray:
    """Make a read-only view of an array: Numba compiles a kernel again for a writable one."""
    view = array.view()
    view.setflags(write=False)  # half the time of the attribute
    return view


@dataclass(frozen=True, eq=False)
class Frame:
    """The coordinates of a chain: ``x_chain = R (x - origin) / length``.

    Attributes:
        R: rotation from inertial to chain axes (3, 3); its last row is the normal of a
            planar linkage.
        origin: middle of the mechanism (3,), metres.
        length: characteristic length, metres.
    """

    R: Array = field(default_factory=lambda: freeze(np.eye(3)))
    origin: Array = field(default_factory=lambda: freeze(np.zeros(3)))
    length: float = 1.0

    def __repr__(self) -> str:
        """Give one line: origin and length."""
        return (
            f"Frame: origin {vector_text(self.origin)} m, length {number_text(self.length)} m"
        )


class Structure:
    """Data that follow from the topology of a chain alone, and workspaces of kernels.

    Chains of one topology share it: a change of the geometry leaves it as it is.

    Attributes:
        of: the arrays that it follows from, and the number of components of a screw.
        made: results of functions of the topology, by function and arguments.
        workspaces: those that nobody uses, by purpose.
    """

    def __init__(self, of: tuple[Any, ...]) -> None:
        """Start without results and workspaces."""
        self.of = of
        self.made: dict[tuple[object, ...], Any] = {}
        self.workspaces: dict[tuple[object, ...], list[Any]] = {}


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
        structure: data that follow from all arrays but the screws; made if not given.
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
    moves: Flags
    links: IntArray
    structure: Structure = field(default=None, repr=False)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Keep the structure of a chain that differs in its screws alone."""
        of = (
            self.screws.shape[1],
            self.parent,
            self.ends,
            self.mimics,
            self.dependent,
            self.columns,
            self.moves,
            self.links,
        )
        if self.structure is None or any(map(operator.is_not, of, self.structure.of)):
            object.__setattr__(self, "structure", Structure(of))

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the arrays alone: each process has results and workspaces of its own."""
        arrays = (getattr(self, part.name) for part in fields(self)[1:-1])
        return _unpickled_chain, (self.frame, *arrays)

    def __repr__(self) -> str:
        """Give one line: the numbers of joints, loops and columns."""
        joints, loops = (
            count_noun(self.parent.size, "joint"),
            count_noun(len(self.ends), "loop"),
        )
        algebra = "planar" if self.planar else "spatial"
        return f"Chain: {algebra}, {joints}, {loops}, {count_noun(self.width, 'column')}"

    @property
    def planar(self) -> bool:
        """Whether the chain is reduced to its plane."""
        return self.screws.shape[1] == 3

    @property
    def width(self) -> int:
        """Number of columns: degrees of freedom of the motion."""
        return self.columns.shape[1]

    @property
    def envelope(self) -> IntArray:
        """Envelope table of the loop matrix; see `kinematics.numerics.linalg.skyline_qr`."""
        return self.once(_make_envelope)

    def with_columns(self, columns: Array) -> Chain:
        """Return the chain with other columns, for motions of the same joints.

        The table of the loop matrix and the workspaces of equal sizes do not depend on them.

        Args:
            columns: joint rates of the independent joints for each column (n, w). Column by
                column, they move no links but those in ``moves``, which stays.
        """
        chain = replace(self, columns=freeze(columns))
        chain.structure.made[_make_envelope,] = self.envelope
        if columns.shape == self.columns.shape:
            chain.structure.workspaces = self.structure.workspaces
        return chain

    @cached_property
    def walked(self) -> tuple[NDArray[Any], ...]:
        """The arrays that kernels of the motion read, in their order."""
        return (
            self.parent,
            self.screws,
            self.ends,
            self.mimics,
            self.columns,
            self.moves,
            self.envelope,
        )

    def once(self, make: Callable[..., Made], *arguments: object) -> Made:
        """Return the result of a function of the structure, computed once.

        Args:
            make: called with the chain and the arguments.
            arguments: hashable.
        """
        return once(self.structure.made, make, self, *arguments)

    def borrow(self, purpose: tuple[object, ...], make: Callable[[], Any]) -> Any:
        """Take a workspace of kernels that belongs to the caller alone until `give_back`.

        It contains the numbers of its last user. Nothing that a function returns may be part of
        it: a later call overwrites it.

        Args:
            purpose: equal for workspaces of one kind and size.
            make: makes one, if none was given back.

        Returns:
            The workspace.
        """
        try:
            return self.structure.workspaces[purpose].pop()
        except (KeyError, IndexError):
            return make()

    def give_back(self, purpose: tuple[object, ...], workspace: Any) -> None:
        """Keep a workspace for the next call of `borrow` with the same purpose.

        Args:
            purpose: as for `borrow`.
            workspace: the one that `borrow` returned.
        """
        self.structure.workspaces.setdefault(purpose, []).append(workspace)


def _unpickled_chain(frame: Frame, *arrays: NDArray[Any]) -> Chain:
    """Make a chain of pickled arrays, which are read-only again: kernels are for such ones."""
    parts: list[Any] = [read_only(array) for array in arrays]
    R, origin = read_only(frame.R), read_only(frame.origin)
    return Chain(Frame(R, origin, frame.length), *parts)


def _make_envelope(chain: Chain) -> IntArray:
    dim = chain.screws.shape[1]
    table = envelope_table(chain.parent, chain.ends, chain.mimics, chain.dependent, dim)
    return freeze(table, np.int64)
