"""Data of a design space, whether it was computed or comes from a file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.space.inertial_parameters.body_inertia import (
    BodyInertia,
    body_inertias,
    in_link_frames,
)
from balance.space.inertial_parameters.conversions import parameter_labels
from balance.support.options import Balance
from balance.support.tolerances import SPACES_EQUAL_SINE
from kinematics.model.linkage import Notice
from kinematics.model.motion import Motion
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun

COMPARED = "balance planar bodies inputs rank nullity serial_nullity kmax".split()


class Order(NamedTuple):
    """Rank and nullity after all conditions up to an order."""

    order: int
    rank: int
    nullity: int


class RequirementRank(NamedTuple):
    """What one of several requirements asks for.

    Attributes:
        text: the requirement.
        rank: number of independent conditions of it alone.
        adds: number of conditions that none of the others imposes.
    """

    text: str
    rank: int
    adds: int


def rank_table(ranks: Sequence[int], parameters: int) -> tuple[Order, ...]:
    """Tabulate rank and nullity by order of derivative.

    Args:
        ranks: rank up to order 0, 1, 2 …
        parameters: number of inertial parameters.
    """
    return tuple(Order(k, rank, parameters - rank) for k, rank in enumerate(ranks))


@dataclass(frozen=True, eq=False)
class SpaceData:
    """Data that a design space and the record of one have in common.

    Attributes:
        source: file of the linkage.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        planar: whether planar parameters are counted.
        bodies: names of the bodies, in the order of the parameters.
        inputs: names of the independent coordinates, whether or not the motion moves them.
        idle: names of joints that do not move in the motion.
        motion: restriction of the inputs, None if every input is free.
        orders: rank and nullity by order of derivative.
        poses: number of finite poses added, because the orders were not enough.
        settled: whether no condition is missing: the conditions have full column rank, or
            finite poses that were not used add none.
        serial_nullity: number of columns of the basis, the first ones, that span the serial
            part: the inertia transfers of its joints, with all loops opened.
        axes: rows are the axes in which planar parameters are expressed (3, 3).
        frames: poses of the link frames of the bodies (bodies, 4, 4).
        length: characteristic length of the mechanism, metres.
        notices: remarks.
    """

    source: str
    balance: Balance
    planar: bool
    bodies: tuple[str, ...]
    inputs: tuple[str, ...]
    idle: tuple[str, ...]
    motion: Motion | None
    orders: tuple[Order, ...]
    poses: int
    settled: bool
    serial_nullity: int
    axes: Array
    frames: Array
    length: float
    notices: tuple[Notice, ...]

    if TYPE_CHECKING:  # a field of a record; a design space computes it when it is asked for

        @property
        def basis(self) -> Array:
            """See `SpaceRecord`."""

    @property
    def rank(self) -> int:
        """Number of independent conditions."""
        return len(self.basis) - self.nullity

    @property
    def nullity(self) -> int:
        """Dimension of the space."""
        return self.basis.shape[1]

    @property
    def parts(self) -> str:
        """Rank, nullity and the two parts of the space, in words."""
        algebra = "planar" if self.planar else "spatial"
        return (
            f"rank {self.rank} of {count_noun(len(self.basis), algebra + ' parameter')}, "
            f"{self.balance} balance, nullity {self.nullity} = {self.serial_nullity} serial + "
            f"{self.nullity - self.serial_nullity} parallel"
        )

    @property
    def serial(self) -> Array:
        """The columns of the basis that the linkage has with its loops opened."""
        return self.basis[:, : self.serial_nullity]

    @property
    def parallel(self) -> Array:
        """The other columns: distributions that are balanced only with the loops closed."""
        return self.basis[:, self.serial_nullity :]

    @property
    def kmax(self) -> int | None:
        """First order at which the rank has its final value; None if no order reaches it."""
        return next((order.order for order in self.orders if order.rank == self.rank), None)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters of one body."""
        return parameter_labels(self.planar, self.balance == "force")

    def bodies_of(self, y: ArrayLike) -> tuple[BodyInertia, ...]:
        """Compute the mass distribution ``basis @ y``, body by body.

        Args:
            y: coordinates in the basis (nullity,); they need not give physical bodies.

        Returns:
            Mass, centre of mass and inertia about it, in the inertial frame at the
            reference pose, in the link frame of the file, and as the file's element; with
            the inequalities that a body violates; see `BodyInertia`.

        Raises:
            ValueError: y is no array of this many real, finite numbers, or they are too large
                or small.
        """
        return body_inertias(
            self.bodies,
            self.basis,
            y,
            self.frames,
            self.axes,
            self.labels,
            self.length,
            self.source,
        )

    def basis_in_link_frames(self) -> Array:
        """Express the basis (parameters, nullity) in the link frames, about their origins.

        Parameters are those of ``labels``, in the axes of the link frame of the file, SI
        units; they keep their values when the linkage moves. Planar ones are in the axes
        ``kinematics.model.chain.plane_axes(n)``, n being the normal in that frame: x and y if
        it is the z axis.
        """
        return in_link_frames(self.basis, self.frames, self.axes, self.labels)

    def differences(self, other: SpaceData) -> tuple[str, ...]:
        """List the differences from another design space, a line each; none if they agree.

        Spaces are compared as such, not their bases; files are not compared.
        """
        lines = [
            f"{name}: {mine} here, {its} there"
            for name in COMPARED
            if (mine := getattr(self, name)) != (its := getattr(other, name))
        ]
        if self.basis.shape == other.basis.shape:
            sine = _largest_angle_sine(self.basis, other.basis, self.labels)
            if not sine <= SPACES_EQUAL_SINE:
                lines.append(f"basis: the spaces are apart by an angle with sine {sine:.1e}")
        return tuple(lines)


def _largest_angle_sine(first: Array, other: Array, labels: Sequence[str]) -> float:
    """Compute the sine of the largest angle between spaces, in any unit of length."""
    kinds = np.array([label.rstrip("xyz") for label in labels] * (len(first) // len(labels)))
    scale = np.ones((len(first), 1))
    for kind in set(kinds):
        size = max(np.abs(basis[kinds == kind]).max(initial=0.0) for basis in (first, other))
        scale[kinds == kind] = size or 1.0
    P, Q = np.linalg.qr(first / scale)[0], np.linalg.qr(other / scale)[0]
    outside = Q - P @ (P.T @ Q)
    return float(np.linalg.norm(outside, 2)) if outside.size else 0.0
