"""Decoupling: mass distributions that are balanced and keep the inertia on the base constant.

The base feels a linkage like a rigid body if its momentum is ``M t`` with a constant M for
every twist t of the base and every motion of the joints. That is the balance of another
linkage, whose base moves freely and carries a body with the inertia ``-M``: all conditions are
linear in the parameters of the bodies and of that one, and have the same orders, ranks and
certainty. The body on the base is given by the others, so that both null spaces have the same
dimension. (J. J. de Jong, PhD thesis, University of Twente, section 2.4.)
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from balance.space.certification.certified_space import CertifiedSpace
from balance.space.certification.certify_space import certify
from balance.space.conditions.collect import conditions_by_order, relative_tolerance
from balance.space.decoupled.free_base import free_base_motion, with_free_base
from balance.space.inertial_parameters.conversions import from_chain
from balance.space.momentum.regressor import parameters_per_body
from balance.space.spaces.compute_space import design_space
from balance.space.spaces.design_space import DesignSpace, residual_of
from balance.space.spaces.space_data import Order
from balance.space.spaces.subspace import subspace
from balance.support.tolerances import AS_GIVEN_RESIDUAL
from kinematics.errors import UsageError
from kinematics.wording import repr_lines

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Decoupling:
    """Decoupled mass distributions of a linkage, and whether those of its file are.

    Attributes:
        space: the design space of balanced distributions that it was asked for.
        freed: the design space of the linkage on a base that moves freely and carries a body,
            the first of its bodies; of the same certainty as ``space``.
    """

    space: DesignSpace
    freed: DesignSpace = field(repr=False)

    def __repr__(self) -> str:
        """Three lines: the verdict, the space, its certainty."""
        return repr_lines(
            f"Decoupling of {self.space.linkage.name}", self.words, self.parts,
            self.freed.assurance,
        )  # fmt: skip

    @property
    def exact(self) -> bool | None:
        """Whether the masses of the file are decoupled at all orders; None without masses."""
        return self.freed.as_given.balanced

    @property
    def residual(self) -> float | None:
        """Residual of the conditions for the masses of the file; see `AsGiven`."""
        return self.freed.as_given.residual

    @cached_property
    def order(self) -> int | None:
        """Highest order of derivative up to which the masses of the file are decoupled.

        Order 0: no momentum at the reference pose; order k: nor in the derivatives of the
        momentum up to k, and those of the inertia on the base vanish up to k. If all orders
        are decoupled, the one at which the conditions are complete. None if order 0 is not,
        or without masses.
        """
        freed, last = self.freed, self.freed.orders[-1].order
        if self.exact is None or self.exact:
            return self.kmax if self.exact else None
        chain = freed.chain
        by_order = conditions_by_order(
            chain, freed.chain_transfers.rows, False, relative_tolerance(chain), last
        )
        held = -1
        for order, conditions in enumerate(by_order):
            residual = residual_of(freed, conditions.rows)
            if residual is None or residual > AS_GIVEN_RESIDUAL:
                break
            held = order
        return held if held >= 0 else None

    @property
    def orders(self) -> tuple[Order, ...]:
        """Rank and nullity of the conditions on the bodies of the linkage, by order."""
        return tuple(o._replace(rank=o.rank - self._size) for o in self.freed.orders)

    @property
    def rank(self) -> int:
        """Number of independent conditions on the bodies of the linkage."""
        return self.freed.rank - self._size

    @property
    def nullity(self) -> int:
        """Dimension of the space of decoupled distributions."""
        return self.freed.nullity

    @property
    def serial_nullity(self) -> int:
        """Dimension of its part that the opened linkage has too."""
        return self.freed.serial_nullity

    @property
    def kmax(self) -> int | None:
        """First order at which the rank has its final value; None if no order reaches it."""
        return self.freed.kmax

    @property
    def parts(self) -> str:
        """Dimension and parts of the space of decoupled distributions, in words."""
        serial = self.serial_nullity
        return (
            f"{self.nullity} of {self.rank + self.nullity} dimensions: {serial} serial + "
            f"{self.nullity - serial} parallel"
        )

    @property
    def words(self) -> str:
        """The verdict on the masses of the file in one line."""
        if self.exact is None:
            return "no masses"
        if self.exact:
            return "yes: balanced, and the inertia on the base is constant"
        if not self.space.as_given.balanced:
            return "no: not balanced"
        first = 0 if self.order is None else self.order + 1
        return f"no: balanced, but the inertia on the base changes at order {first}"

    @cached_property
    def basis(self) -> Array:
        """Basis of the decoupled distributions, in rows and units of ``space.basis``.

        Shape (parameters, nullity); the first ``serial_nullity`` columns span the serial part.
        """
        return self.decoupled_space.basis

    @cached_property
    def decoupled_space(self) -> DesignSpace:
        """The decoupled distributions as a design space, for `balance.masses.feasible`.

        Its transfers are those of the linkage on the ground.
        """
        space, given = self.space, self.freed.basis[self._size :]
        G, serial = from_chain(space.chain.frame, space.planar, False), self.serial_nullity
        blocks = given.reshape(-1, len(G), given.shape[1])
        columns = np.asarray(np.linalg.solve(G, blocks), np.float64).reshape(given.shape)
        decoupled = subspace(space, columns[:, :serial], columns[:, serial:], self.orders)
        return replace(decoupled, poses=self.freed.poses, settled=self.freed.settled)

    @property
    def _size(self) -> int:
        """Number of parameters of the body on the base."""
        return parameters_per_body(self.space.planar, False)

    def to_dict(self) -> dict[str, object]:
        """Convert to the entry ``decoupled`` of the report, ready for JSON."""
        return {
            "order": self.order,
            "exact": self.exact,
            "residual": self.residual,
            "words": self.words,
            "orders": [order._asdict() for order in self.orders],
            "kmax": self.kmax,
            "rank": self.rank,
            "nullity": self.nullity,
            "serial": self.serial_nullity,
            "parallel": self.nullity - self.serial_nullity,
            "certainty": self.freed.level,
            "basis": self.basis.tolist(),
        }


def decoupling(space: DesignSpace) -> Decoupling:
    """Find the mass distributions that are balanced and keep the inertia on the base constant.

    A linkage with such masses is decoupled: a base that moves feels it like a rigid body, and
    does not drive its joints. The conditions are ``h_w = 0`` and ``∂M = 0`` in every motion,
    with the inertia M of all bodies together about a point of the base (see
    `balance.space.locked_inertia`), six by six, or three by three in a plane.

    Args:
        space: a design space for dynamic balance. If it is certified, so is the result.

    Returns:
        Rank by order and a basis of the decoupled distributions; whether the masses of the
        file are decoupled, and up to which order.

    Raises:
        UsageError: the space is one for force balance.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, section 2.4.

    Example:
        >>> import balance
        >>> found = balance.space.decoupling(balance.design_space("robot.urdf"))
        >>> [order.rank for order in found.orders], found.words
        ([3, 7, 8], 'no: not balanced')
    """
    if space.balance != "dynamic":
        raise UsageError("decoupling is about dynamic balance: leave out the force balance")
    linkage = with_free_base(space)
    motion = free_base_motion(space, linkage)
    freed = design_space(
        linkage, motion, max_order=space.highest_order, spatial=not space.planar
    )
    certified = isinstance(space, CertifiedSpace)
    return Decoupling(space, certify(freed) if certified else freed)
