"""The design space: every mass distribution that leaves a linkage balanced.

The total momentum vanishes in every motion if and only if, for every coordinate w, all
derivatives of ``h_w = X_w z`` vanish at the reference pose. Derivatives of one order are
gathered along generic rays until another ray adds no condition; orders are gathered until a
finite pose that was not used adds none. Momentum is analytic, so one generic pose at which
every candidate is balanced decides. (J. J. de Jong, PhD thesis, University of Twente,
chapter 5.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.inertia import from_chain, parameter_labels, to_chain
from balance.momentum import RegressorSeries, parameters_per_body, rows_per_column
from balance.rank import FLOOR, Conditions, Decision
from kinematics.assembly import moving_chain
from kinematics.closure import expand, expand_at, follow, radius
from kinematics.errors import MobilityError
from kinematics.linkage import Chain, Linkage, Notice, frozen, names
from kinematics.motion import Motion

__all__ = ["AsGiven", "DesignSpace", "Order", "design_space"]

Array = NDArray[np.float64]
Balance = Literal["dynamic", "force"]

# Orders tried before giving up on a pose that refuses to agree.
LAST_ORDER = 20
# Masses in files are rounded: a given distribution counts as balanced up to this part of
# the sum of its bodies' contributions.
BALANCED = 1e-9
# A kept singular value within this factor of round-off deserves a warning.
MARGIN = 1e3


class Order(NamedTuple):
    """Rank and nullity after all conditions up to an order."""

    order: int
    rank: int
    nullity: int


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
        motion: the motion asked of it.
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
        as_given: whether the masses in the file are balanced.
        notices: remarks.
    """

    linkage: Linkage
    motion: Motion
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
    as_given: AsGiven
    notices: tuple[Notice, ...]

    @property
    def labels(self) -> tuple[str, ...]:
        """Names of the parameters of one body."""
        return parameter_labels(self.planar, self.balance == "force")


def design_space(
    linkage: Linkage,
    motion: Motion | Sequence[str] | None = None,
    balance: Balance = "dynamic",
    max_order: int | None = None,
    *,
    spatial: bool = False,
) -> DesignSpace:
    """The space of balanced mass distributions of a linkage.

    Args:
        linkage: an assembled linkage.
        motion: restriction of the inputs, as a `Motion` or as relations such as
            ``["j4=j7"]``; free by default.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        max_order: compute exactly the orders 0 … max_order, instead of as many as needed.
        spatial: count all ten parameters per body, even if the linkage is planar.

    Raises:
        MotionError: a relation is wrong.
        MobilityError: the linkage cannot follow the motion.
    """
    if balance not in ("dynamic", "force"):
        raise ValueError(f"balance must be 'dynamic' or 'force', not {balance!r}")
    if motion is not None and not isinstance(motion, Motion):
        motion = Motion.parse(motion, linkage.inputs)
    chain = moving_chain(linkage, motion, spatial)
    conditions, orders, settled = _gather(chain, balance == "force", max_order)
    motion = motion or Motion.free(linkage.inputs)
    return _result(linkage, chain, motion, balance, conditions, orders, settled)


def _gather(
    chain: Chain, force: bool, max_order: int | None
) -> tuple[Conditions, list[Order], bool]:
    """Conditions order by order, until a fresh pose agrees or ``max_order`` is reached."""
    size = chain.links.size * parameters_per_body(chain.planar, force)
    conditions = Conditions.none(size)
    rays = Rays(chain, force)
    orders: list[Order] = []
    fresh: Array | None = None
    settled = False
    for order in range(1 + (LAST_ORDER if max_order is None else max_order)):
        conditions = _with_order(conditions, rays, order)
        orders.append(Order(order, conditions.rank, size - conditions.rank))
        if order == 0 and max_order != 0:
            continue
        if fresh is None:
            fresh = rays.fresh_rows()
        settled = conditions.imply(fresh)
        if settled and max_order is None:
            break
    return conditions, orders, settled


def _with_order(conditions: Conditions, rays: Rays, order: int) -> Conditions:
    """Add the derivatives of one order, along as many rays as it takes.

    ``C(w + k - 1, k)`` generic rays span all derivatives of order k in w coordinates. Fewer
    will do once the rows of one more follow from those gathered.
    """
    every = comb(rays.chain.width + order - 1, order)
    size = conditions.factor.shape[1]
    used, wanted = 0, -(-(size - conditions.rank) // rays.rows_per_ray)
    while used < every:
        wanted = min(every, max(wanted, used + 1))
        rows = rays.rows(order, min(every, wanted + 1))
        conditions = conditions.and_also(rows[used:wanted])
        used, wanted = wanted, 2 * wanted
        if used < every and conditions.imply(rows[used]):
            break
    return conditions


class Rays:
    """Regressor rows along generic rays, more of them and to higher orders on demand."""

    def __init__(self, chain: Chain, force: bool) -> None:
        """Prepare the rays that two orders are likely to need, to order 4."""
        self.chain, self.force = chain, force
        self.rows_per_ray = chain.width * rows_per_column(chain.planar, force)
        size = chain.links.size * parameters_per_body(chain.planar, force)
        self._count = min(comb(chain.width + 1, 2), 1 - (-size // self.rows_per_ray))
        self._last = 4
        self._batches: list[_Batch] = []

    def rows(self, order: int, count: int) -> Array:
        """Rows of one order along at least ``count`` rays; (rays, rows per ray, columns)."""
        if order > self._last:
            self._last *= 2
            self._batches = []
        made = sum(batch.count for batch in self._batches)
        if made < max(count, self._count):
            self._count = max(count, self._count)
            self._batches.append(_Batch(self, made, self._count, self._last))
        blocks = [batch.rows(order) for batch in self._batches]
        return blocks[0] if len(blocks) == 1 else np.concatenate(blocks)

    def fresh_rows(self) -> Array:
        """Rows at a finite pose away from the reference pose."""
        batch = self._batches[0]
        start = np.zeros(self.chain.parent.size)
        pose, step = follow(self.chain, start, batch.series, batch.directions[-1])
        if step == 0.0:
            raise MobilityError(
                "no closed pose was found near the reference pose to check the conditions at; "
                "write the file at a pose further from a singularity"
            )
        return RegressorSeries(self.chain, expand_at(self.chain, pose), self.force, pose).rows(0)[0]


class _Batch:
    """Rays that were expanded together."""

    def __init__(self, rays: Rays, first: int, last: int, order: int) -> None:
        self.count = last - first
        self.directions = _generic(first, last, rays.chain.width)
        self.series = expand(rays.chain, self.directions, order)
        self._scale = radius(self.series.C[0] @ self.directions[0])
        self._regressor = RegressorSeries(rays.chain, self.series, rays.force)
        self._shape = (self.count, rays.rows_per_ray, -1)
        self._order, self._rows = -1, self.directions

    def rows(self, order: int) -> Array:
        """Rows of one order, scaled by that power of the radius of convergence."""
        while self._order < order:
            self._order += 1
            self._rows = self._regressor.rows(self._order)[0]
        return (self._rows * self._scale**order).reshape(self._shape)


def _generic(first: int, last: int, width: int) -> Array:
    """Directions ``first … last - 1`` of a fixed sequence without special relations."""
    if width == 1:
        return np.ones((last - first, 1))
    at = np.arange(first * width, last * width, dtype=np.float64).reshape(-1, width)
    directions = np.cos((at + 1.0) ** 2)
    return directions / np.sqrt(np.sum(directions**2, axis=1, keepdims=True))


def _result(
    linkage: Linkage, chain: Chain, motion: Motion, balance: Balance,
    conditions: Conditions, orders: list[Order], settled: bool,
) -> DesignSpace:  # fmt: skip
    """Everything that the conditions tell, in SI units."""
    decision = conditions.decide()
    force, bodies = balance == "force", len(linkage.bodies)
    G = from_chain(chain.frame, chain.planar, force)
    basis = G @ decision.basis.reshape(bodies, len(G), -1)
    nullity = orders[-1].nullity
    return DesignSpace(
        linkage=linkage, motion=motion, balance=balance, planar=chain.planar,
        bodies=names(linkage.bodies), inputs=linkage.inputs, idle=_idle(linkage, chain),
        orders=tuple(orders), settled=settled,
        kmax=next(o.order for o in orders if o.rank == conditions.rank),
        rank=conditions.rank, nullity=nullity, basis=frozen(basis.reshape(-1, nullity)),
        axes=chain.frame.R, singular_values=decision.singular_values,
        kept=decision.kept, dropped=decision.dropped,
        as_given=_as_given(linkage, chain, conditions, force),
        notices=(*linkage.notices, *_notices(decision, settled)),
    )  # fmt: skip


def _idle(linkage: Linkage, chain: Chain) -> tuple[str, ...]:
    """Names of the joints that the chain does without."""
    if chain.joints.size == len(linkage.joints):
        return ()
    moving = set(chain.joints.tolist())
    return tuple(joint.name for j, joint in enumerate(linkage.joints) if j not in moving)


def _as_given(linkage: Linkage, chain: Chain, conditions: Conditions, force: bool) -> AsGiven:
    """Residual of the masses in the file."""
    given = np.array([body.inertia for body in linkage.bodies])
    z = to_chain(given, chain.frame, chain.planar, force)
    by_body = np.einsum("rbp,bp->rb", conditions.factor.reshape(conditions.rank, *z.shape), z)
    total = float(np.sqrt(np.einsum("rb,rb->b", by_body, by_body)).sum())
    left = by_body.sum(axis=1)
    residual = float(np.sqrt(left @ left)) / total if total > 0.0 else 0.0
    return AsGiven(residual <= BALANCED, residual)


def _notices(decision: Decision, settled: bool) -> list[Notice]:
    """Remarks on the decision."""
    found = []
    if not settled:
        text = "a pose further on needs more orders than were computed: the rank may be too low"
        found.append(Notice("not_settled", text))
    if decision.kept < MARGIN * FLOOR:
        text = f"the smallest singular value kept, {decision.kept:.1e}, is near round-off"
        found.append(Notice("thin_margin", text))
    return found
