"""The result of `design_space`: a space of mass distributions, and what it says."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from balance.archive import Balance, Order, SpaceRecord, digest
from balance.bodies import BodyInertia, body_inertias, in_link_frames
from balance.inertia import parameter_labels, to_chain, violations
from balance.rank import Conditions
from kinematics.linkage import Chain, Linkage, Notice, frozen
from kinematics.motion import Motion

__all__ = ["SCHEMA", "AsGiven", "DesignSpace"]

Array = NDArray[np.float64]

SCHEMA = "balance.report/1"
# Masses in files are rounded: a given distribution counts as balanced up to this part of
# the sum of its bodies' contributions.
BALANCED = 1e-9


class AsGiven(NamedTuple):
    """Whether the masses in the file lie in the design space.

    Attributes:
        balanced: residual below 1e-9.
        residual: size of the conditions' residual over the sum of the bodies' parts in it.
    """

    balanced: bool
    residual: float


@dataclass(frozen=True, eq=False)
class DesignSpace:
    """Mass distributions with vanishing momentum in every motion.

    Attributes:
        linkage: the linkage.
        motion: the motion asked of it, None if every input is free.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        planar: whether planar parameters are counted.
        bodies: names of the bodies, in the order of the parameters.
        inputs: names of the independent coordinates.
        idle: names of joints that do not move.
        orders: rank and nullity by order of derivative.
        settled: whether a fresh finite pose confirms that no higher order is needed.
        kmax: first order at which the rank has its final value.
        rank: number of independent conditions.
        nullity: dimension of the space.
        basis: null-space basis (parameters, nullity): per body the parameters named by
            ``labels``, about the inertial origin at the reference pose, SI units. Its
            columns are orthonormal when lengths are measured from the middle of the
            mechanism in units of its size.
        axes: rows are the axes in which planar parameters are expressed (3, 3).
        singular_values: of all conditions, relative to the largest.
        kept: the smallest singular value that counts.
        dropped: upper bound of the largest one that does not.
        notices: remarks.
    """

    linkage: Linkage
    motion: Motion | None
    balance: Balance
    planar: bool
    bodies: tuple[str, ...]
    inputs: tuple[str, ...]
    idle: tuple[str, ...]
    orders: tuple[Order, ...]
    settled: bool
    kmax: int
    rank: int
    nullity: int
    basis: Array
    axes: Array
    singular_values: Array
    kept: float
    dropped: float
    notices: tuple[Notice, ...]
    _conditions: Conditions = field(repr=False)
    _chain: Chain = field(repr=False)

    @cached_property
    def as_given(self) -> AsGiven:
        """Whether the masses in the file are balanced."""
        factor = self._conditions.factor
        given = np.array([body.inertia for body in self.linkage.bodies])
        z = to_chain(given, self._chain.frame, self.planar, self.balance == "force")
        by_body = np.einsum("rbp,bp->rb", factor.reshape(self.rank, *z.shape), z)
        total = float(np.sqrt(np.einsum("rb,rb->b", by_body, by_body)).sum())
        left = by_body.sum(axis=1)
        residual = float(np.sqrt(left @ left)) / total if total > 0.0 else 0.0
        return AsGiven(residual <= BALANCED, residual)

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters of one body."""
        return parameter_labels(self.planar, self.balance == "force")

    @property
    def frames(self) -> Array:
        """Poses of the link frames of the bodies (bodies, 4, 4)."""
        return frozen([body.frame for body in self.linkage.bodies])

    @property
    def length(self) -> float:
        """The mechanism's size, in units of which the columns are orthonormal; metres."""
        return self._chain.frame.length

    @property
    def warnings(self) -> tuple[Notice, ...]:
        """The notices, and then the masses in the file that no body can have."""
        unreal = [
            Notice("non_physical", f"link '{body.name}': {problem}")
            for body in self.linkage.bodies
            for problem in violations(body.inertia)
        ]
        return (*self.notices, *unreal)

    def bodies_of(self, y: ArrayLike) -> tuple[BodyInertia, ...]:
        """The mass distribution ``basis @ y``, body by body, as a designer edits it.

        Args:
            y: coordinates in the basis (nullity,); they need not give physical bodies.

        Returns:
            Mass, centre of mass and inertia about it, in the inertial frame at the
            reference pose, in the link frame of the file, and as the file's element.
        """
        return body_inertias(
            self.bodies, self.basis, y, self.frames, self.axes, self.labels, self.length
        )

    def basis_in_link_frames(self) -> Array:
        """The basis (parameters, nullity), each body about the origin of its link frame.

        Parameters are those of ``labels``, in the axes of the link frame of the file, SI
        units; they keep their values when the linkage moves. Planar ones are in the axes
        ``kinematics.chain.plane_axes(n)``, n being the normal in that frame: x and y if it
        is the z axis.
        """
        return in_link_frames(self.basis, self.frames, self.axes, self.labels)

    def record(self) -> SpaceRecord:
        """What is known of the space, as data that can be saved and compared."""
        return SpaceRecord(
            source=self.linkage.source, sha256=digest(self.linkage.source), version=_version(),
            balance=self.balance, planar=self.planar, bodies=self.bodies, inputs=self.inputs,
            idle=self.idle, motion=self.motion, orders=self.orders, settled=self.settled,
            basis=self.basis, axes=self.axes, frames=self.frames, length=self.length,
            singular_values=self.singular_values, kept=self.kept, dropped=self.dropped,
            notices=self.notices,
        )  # fmt: skip

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the space to one ``.npz`` file, which `load_space` reads.

        The file appears whole or not at all. Its entry ``header`` is a JSON text with the
        version, the SHA-256 of the linkage's file and all options.

        Raises:
            FileError: it cannot be written.
        """
        self.record().save(path)

    def to_dict(self) -> dict[str, object]:
        """The report as plain data, ready for JSON.

        ``balance/report.schema.json`` describes it. A key whose value is ``None`` is not
        decided by this version.
        """
        linkage = self.linkage
        return {
            "schema": SCHEMA,
            "model": linkage.name,
            "algebra": "planar" if self.planar else "spatial",
            "balance": self.balance,
            "bodies": list(self.bodies),
            "parameters": self.rank + self.nullity,
            "joints": len(linkage.joints),
            "loops": len(linkage.loops),
            "mobility": linkage.mobility,
            "inputs": list(self.inputs),
            "idle": list(self.idle),
            "motion": list(self.motion.relations) if self.motion else [],
            "orders": [order._asdict() for order in self.orders],
            "kmax": self.kmax,
            "rank": self.rank,
            "nullity": self.nullity,
            "serial": None,
            "parallel": None,
            "certainty": None,
            "margin": {"kept": self.kept, "dropped": self.dropped},
            "as_given": self.as_given._asdict(),
            "warnings": [notice._asdict() for notice in self.warnings],
        }


def _version() -> str:
    """Version of the installed package."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("screwbalance")
    except PackageNotFoundError:
        return "unknown"
