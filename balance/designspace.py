"""The design space: every mass distribution that leaves a linkage balanced.

The total momentum vanishes in every motion if and only if, for every coordinate w, all
derivatives of ``h_w = X_w z`` vanish at the reference pose. Derivatives of one order are
gathered along generic rays until another ray adds no condition; orders are gathered until a
finite pose that was not used adds none. Momentum is analytic, so one generic pose at which
every candidate is balanced decides. (J. J. de Jong, PhD thesis, University of Twente,
chapter 5.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from math import comb

import numpy as np
from numpy.typing import NDArray

from balance.archive import Balance, Order
from balance.elimination import FLOOR
from balance.inertia import from_chain
from balance.momentum import RegressorSeries, rows_per_column
from balance.opening import Transfers, transfers
from balance.rank import Conditions, Decision
from balance.space import DesignSpace
from kinematics.assembly import moving_chain
from kinematics.closure import Series, expand
from kinematics.errors import MobilityError, MotionError
from kinematics.linkage import Chain, Linkage, Notice, frozen, names
from kinematics.motion import Motion
from kinematics.placement import Pose, expand_at, radius
from kinematics.walk import walk

__all__ = ["design_space"]

Array = NDArray[np.float64]

# Orders to which the motion is expanded, one after the other as they are needed.
EXPANSIONS = (3, 8, 20)
# Highest order that may be asked for.
HIGHEST = 50
# Steps to the pose that decides whether high orders are complete.
FAR = 4
# Most poses that are looked at together.
POSES = 256
NOTHING = np.empty((0, 0))
# A kept singular value within this factor of round-off deserves a warning.
MARGIN = 1e3


def design_space(
    linkage: Linkage,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance = "dynamic",
    max_order: int | None = None,
    *,
    spatial: bool = False,
) -> DesignSpace:
    """The space of balanced mass distributions of a linkage.

    Args:
        linkage: an assembled linkage.
        motion: restriction of the inputs, as a `Motion`, as a relation such as ``"j4=j7"``
            or as several of them; free by default.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        max_order: compute exactly the orders 0 … max_order, instead of as many as needed.
        spatial: count all ten parameters per body, even if the linkage is planar.

    Raises:
        MotionError: a relation is wrong, or the motion is that of other inputs.
        MobilityError: the linkage cannot follow the motion.
        ValueError: an option has no such value.
    """
    if balance not in ("dynamic", "force"):
        raise ValueError(f"balance must be 'dynamic' or 'force', not {balance!r}")
    if max_order is not None and not (isinstance(max_order, int) and 0 <= max_order <= HIGHEST):
        raise ValueError(f"max_order must be a whole number from 0 to {HIGHEST}")
    if motion is not None and not isinstance(motion, Motion):
        try:
            motion = Motion.parse(motion, linkage.inputs)
        except MotionError as error:
            raise MotionError(
                error.relation, error.problem, error.valid, linkage.source
            ) from None
    chain = moving_chain(linkage, motion, spatial)
    try:
        exchanged = transfers(chain, balance == "force")
        force, poses = balance == "force", 0
        conditions, orders, settled = _gather(chain, exchanged, force, max_order)
        if not settled and max_order is None:
            conditions, poses, settled = _with_poses(chain, force, conditions)
    except MobilityError as error:
        raise MobilityError(f"{linkage.source}: {error}") from None
    return _result(
        linkage, chain, motion, balance, exchanged, conditions, orders, poses, settled
    )


def _gather(
    chain: Chain, exchanged: Transfers, force: bool, max_order: int | None
) -> tuple[Conditions, tuple[Order, ...], bool]:
    """Conditions order by order, until they are all there are or ``max_order`` is reached."""
    none = Conditions.beside(exchanged.rows)
    last = EXPANSIONS[-1] if max_order is None else max_order
    rows = chain.width * rows_per_column(chain.planar, force)
    size = none.known.shape[1]
    rays = min(comb(chain.width + 1, 2), 1 - (-size // rows))
    while True:
        conditions, ranks, settled, enough = _along(
            rays, chain, force, none, last, max_order is None
        )
        if enough:
            orders = tuple(Order(k, rank, size - rank) for k, rank in enumerate(ranks))
            return conditions, orders, settled
        rays *= 2


def _along(
    rays: int, chain: Chain, force: bool, conditions: Conditions, last: int, stop: bool
) -> tuple[Conditions, list[int], bool, bool]:
    """Conditions along a number of rays: their ranks, settled or not, rays enough or not."""
    directions = _generic(rays, chain.width)
    ranks: list[int] = []
    settled, enough = False, True
    for goal in EXPANSIONS if stop else (last,):
        series = expand(chain, directions, max(goal, EXPANSIONS[0]))
        reach = radius(series.C[0] @ directions[0])
        regressor = RegressorSeries(chain, series, force)
        fresh = NOTHING
        # With several coordinates the last order costs most, and is needed least.
        for upto in (goal - 1, goal) if stop and chain.width > 1 else (goal,):
            first = len(ranks)
            rows = regressor.rows(upto)[first - upto - 1 :]
            while not settled and len(rows):
                conditions, found, settled, enough = conditions.with_orders(
                    rows, first, reach, fresh, stop
                )
                if not enough:
                    return conditions, ranks, False, False
                ranks += found.tolist()
                first, rows = first + found.size, rows[found.size :]
                stalled = ranks[-1:] == ranks[-2:-1]
                if not settled and not len(fresh) and (stalled or upto == goal):
                    steps = 1 if goal == EXPANSIONS[0] else FAR
                    fresh = _fresh_rows(chain, force, steps, series)
                    settled = conditions.imply(fresh)
        if settled and stop:
            break
    while settled and stop and len(ranks) > 1 and ranks[-1] == ranks[-2]:
        ranks.pop()
    return conditions, ranks, settled, enough


def _fresh_rows(chain: Chain, force: bool, steps: int, known: Series) -> Array:
    """Rows at a finite pose, in a direction of its own; (rows, columns).

    A step is within the radius of convergence, where a condition of high order that is
    still missing may be too small to see: then several are needed.

    Args:
        chain: the linkage as arrays.
        force: whether only linear momentum counts.
        steps: how many steps away from the reference pose.
        known: series there; used where a chain has only one direction to move in.
    """
    ray = _generic(101, chain.width)[-1]
    poses = list(islice(walk(chain, ray, known if chain.width == 1 else None), steps))
    if not poses:
        raise MobilityError(
            "no closed pose was found near the reference pose to check the conditions at; "
            "write the file at a pose further from a singularity"
        )
    return _rows_at(chain, force, poses[-1])


def _rows_at(chain: Chain, force: bool, pose: Pose) -> Array:
    """Rows at a finite pose; (rows, columns)."""
    rows = RegressorSeries(chain, expand_at(chain, pose), force, pose).rows(0)
    return rows.reshape(-1, rows.shape[-1])


def _with_poses(
    chain: Chain, force: bool, conditions: Conditions
) -> tuple[Conditions, int, bool]:
    """Conditions at ever more poses, until as many again add none.

    Returns:
        The conditions, how many poses were used, and whether that settles them.
    """
    poses = _wander(chain)
    used, batch, complete = 0, FAR, False
    while batch <= POSES:
        rows = [_rows_at(chain, force, pose) for pose in islice(poses, batch)]
        if not rows:
            break
        used += len(rows)
        before = conditions.rank
        conditions = conditions.and_also(np.concatenate(rows))
        # As many again make a complete answer a well-conditioned one.
        if complete or (conditions.rank == before and batch > FAR):
            return conditions, used, True
        complete = conditions.complete
        batch *= 2
    return conditions, used, complete


def _wander(chain: Chain) -> Iterator[Pose]:
    """Poses in many directions in turn, ever further away."""
    rays = _generic(103, chain.width)[101:]
    walks = [walk(chain, sign * ray) for ray in rays[: chain.width] for sign in (1.0, -1.0)]
    while walks:
        for path in list(walks):
            pose = next(path, None)
            if pose is None:
                walks.remove(path)
            else:
                yield pose


def _generic(count: int, width: int) -> Array:
    """Unit directions of a fixed sequence without special relations; (count, width)."""
    if width == 1:
        return np.ones((count, 1))
    directions = np.cos(np.arange(1.0, count * width + 1.0) ** 2).reshape(count, width)
    return directions / np.sqrt(np.sum(directions**2, axis=1, keepdims=True))


def _result(
    linkage: Linkage, chain: Chain, motion: Motion | None, balance: Balance,
    exchanged: Transfers, conditions: Conditions, orders: tuple[Order, ...],
    poses: int, settled: bool,
) -> DesignSpace:  # fmt: skip
    """Everything that the conditions tell, in SI units."""
    decision = conditions.decide()
    force, bodies = balance == "force", len(linkage.bodies)
    G = from_chain(chain.frame, chain.planar, force)
    nullity = decision.basis.shape[1]
    basis = G @ decision.basis.reshape(bodies, len(G), nullity)
    return DesignSpace(
        source=linkage.source, linkage=linkage, motion=motion, balance=balance,
        planar=chain.planar, bodies=names(linkage.bodies), inputs=linkage.inputs,
        idle=_idle(linkage, chain), orders=orders, poses=poses, settled=settled,
        basis=frozen(basis.reshape(bodies * len(G), nullity)),
        serial_nullity=decision.known,
        axes=chain.frame.R, frames=linkage.frames, length=chain.frame.length,
        singular_values=decision.singular_values, kept=decision.kept, dropped=decision.dropped,
        notices=(*linkage.notices, *_notices(chain, decision, settled)),
        _conditions=conditions, _chain=chain, _exchanged=exchanged,
    )  # fmt: skip


def _idle(linkage: Linkage, chain: Chain) -> tuple[str, ...]:
    """Names of the joints that the chain does without."""
    if chain.joints.size == len(linkage.joints):
        return ()
    moving = set(chain.joints.tolist())
    return tuple(joint.name for j, joint in enumerate(linkage.joints) if j not in moving)


def _notices(chain: Chain, decision: Decision, settled: bool) -> list[Notice]:
    """Remarks on the motion and on the decision."""
    found = []
    if chain.links.max(initial=-1) < 0:
        found.append(Notice("nothing_moves", "no body with mass moves: nothing to balance"))
    if not settled:
        text = "poses further on need more conditions than were found: the rank may be too low"
        found.append(Notice("not_settled", text))
    if decision.kept < MARGIN * FLOOR:
        text = f"the smallest singular value kept, {decision.kept:.1e}, is near round-off"
        found.append(Notice("thin_margin", text))
    return found
