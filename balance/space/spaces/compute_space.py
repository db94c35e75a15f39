"""The design space: every mass distribution that leaves a linkage balanced.

The total momentum vanishes in every motion if and only if, for every coordinate w, all
derivatives of ``h_w = X_w z`` vanish at the reference pose. The serial part is known
beforehand (`balance.space.transfers`); a rank decision gives the rest. (J. J. de Jong, PhD
thesis, University of Twente, chapter 5.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from balance.space.conditions.collect import (
    CollectedConditions,
    collect_conditions,
    relative_tolerance,
)
from balance.space.conditions.rank import Decision
from balance.space.momentum.regressor import parameters_per_body
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.first_orders import FirstOrders, first_orders
from balance.space.spaces.space_data import rank_table
from balance.space.transfers.serial_part import Transfers, serial_transfers
from balance.support.later_fields import with_later_fields
from balance.support.options import Balance
from kinematics.closure.assembly.assemble import moving_chain
from kinematics.errors import MobilityError, UsageError
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.arrays import Chain
from kinematics.model.linkage import Linkage, Notice
from kinematics.model.motion import Motion, motion_of
from kinematics.numerics.compiled.background import kernel_clock
from kinematics.numerics.tolerances import MARGIN_DETERMINED
from kinematics.wording import size_text

# Seconds of uncompiled kernels by the cube of the number of parameters: 0.1 s for an arm of six
# links, 7 s for a humanoid of 25, in one call.
ELIMINATION = 5e-7
# Highest order that may be requested.
MAX_ORDER = 50


def design_space(
    linkage: LinkageLike,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance = "dynamic",
    max_order: int | None = None,
    *,
    spatial: bool = False,
) -> DesignSpace:
    """Compute the space of balanced mass distributions of a linkage, in floating point.

    The total momentum ``h = Σ_w u̇_w X_w(u) z`` vanishes in every motion if and only if all
    derivatives of every ``X_w z`` vanish at the reference pose: the space is their common null
    space. `balance.certify` compares its integers with those of exact arithmetic. Derivation:
    docs/theory/momentum.md; how the rank is decided: docs/theory/rank.md.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        motion: restriction of the inputs, as a `Motion`, as a relation such as ``"j4=j7"``
            or as several of them; free by default.
        balance: ``"dynamic"``, or ``"force"`` for linear momentum alone.
        max_order: compute exactly the orders 0 … max_order, instead of as many as needed.
        spatial: count all ten parameters per body, even if the linkage is planar.

    Returns:
        Rank by order and a basis (parameters, nullity), in SI units; see `DesignSpace`.

    Raises:
        MotionError: a relation is wrong, or the motion is that of other inputs.
        MobilityError: the linkage cannot follow the motion.
        ValueError: an option has no such value.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, chapter 5.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf")
        >>> space.rank, space.nullity, space.kmax
        (8, 4, 3)
    """
    linkage = linkage if isinstance(linkage, Linkage) else as_linkage(linkage)
    if balance not in ("dynamic", "force"):
        raise ValueError(f"balance must be 'dynamic' or 'force', not {balance!r}")
    if max_order is not None and not (
        isinstance(max_order, int) and 0 <= max_order <= MAX_ORDER
    ):
        raise ValueError(f"max_order must be a whole number from 0 to {MAX_ORDER}")
    motion = motion_of(linkage, motion)
    chain, force = moving_chain(linkage, motion, spatial), balance == "force"
    parameters = chain.links.size * parameters_per_body(chain.planar, force)
    kernel_clock.foresee(ELIMINATION * parameters**3)
    first = first_orders(chain, force, max_order)
    fields: dict[str, Any] = {}
    later: dict[str, Callable[[], Any]] = {}
    if first is not None and first.suffice:
        poses, settled, serial, decision = 0, first.settled, first.serial, Decision(first)
        later = {"orders": first.order_table, "chain_transfers": first.transfers}
    else:
        gathered, transfers = _collect(linkage, chain, force, max_order, first)
        conditions, ranks, poses, settled = gathered
        serial, decision = len(conditions.known), conditions.decide()
        fields = {"orders": rank_table(ranks, parameters), "chain_transfers": transfers}
    return with_later_fields(
        DesignSpace,
        later,
        **fields,
        source=linkage.source,
        linkage=linkage,
        motion=motion,
        balance=balance,
        planar=chain.planar,
        bodies=linkage.body_names,
        inputs=linkage.inputs,
        idle=_idle(linkage, chain),
        poses=poses,
        settled=settled,
        serial_nullity=serial,
        axes=chain.frame.R,
        frames=linkage.frames,
        length=chain.frame.length,
        notices=(*linkage.notices, *_notices(chain, settled, decision)),
        highest_order=max_order,
        decision=decision,
        chain=chain,
    )


def as_space(
    model: DesignSpace | LinkageLike,
    motion: Motion | str | Sequence[str] | None = None,
    balance: Balance | None = None,
    max_order: int | None = None,
) -> DesignSpace:
    """Convert an argument to a design space: itself, or that of a linkage.

    Args:
        model: a design space, or an argument of `design_space`.
        motion: restriction of the inputs of a linkage; a space has its own.
        balance: ``"dynamic"``, as by default, or ``"force"``; of a space, what it is for.
        max_order: of a linkage, as for `design_space`.

    Raises:
        LinkageError: the linkage cannot be used.
        UsageError: a space is for another balance, or there is a motion beside it.
    """
    if not isinstance(model, DesignSpace):
        return design_space(model, motion, balance or "dynamic", max_order)
    if motion is not None:
        raise UsageError("a design space has its motion: leave out motion, or give a linkage")
    if balance not in (None, model.balance):
        raise UsageError(
            f"the design space is for {model.balance} balance: leave out balance, or give a "
            "linkage"
        )
    return model


def _collect(
    linkage: Linkage,
    chain: Chain,
    force: bool,
    max_order: int | None,
    first: FirstOrders | None,
) -> tuple[CollectedConditions, Transfers]:
    """Collect more conditions than those of the first orders, which are not enough."""
    tolerance = relative_tolerance(chain)
    transfers = first.transfers() if first else serial_transfers(chain, force, tolerance)
    begun = first.orders if first else None
    try:
        gathered = collect_conditions(chain, transfers.rows, force, tolerance, max_order, begun)
    except MobilityError as error:
        raise MobilityError(f"{linkage.source}: {error}") from None
    return gathered, transfers


def _idle(linkage: Linkage, chain: Chain) -> tuple[str, ...]:
    """List the names of the joints that the chain leaves out."""
    if chain.joints.size == len(linkage.joints):
        return ()
    moving = set(chain.joints.tolist())
    return tuple(joint.name for j, joint in enumerate(linkage.joints) if j not in moving)


def _notices(chain: Chain, settled: bool, decision: Decision) -> list[Notice]:
    """List remarks on the motion and on the decision."""
    notices = []
    if max(chain.links.tolist()) < 0:
        notices.append(Notice("nothing_moves", "no body with mass moves: nothing to balance"))
    if not settled:
        text = "poses further on need more conditions than were found: the rank may be too low"
        notices.append(Notice("not_settled", text))
    if decision.ill_conditioned:
        kept = size_text(decision.kept, floor=MARGIN_DETERMINED)
        text = f"the smallest singular value kept, {kept}, is near round-off"
        notices.append(Notice("thin_margin", text))
    return notices
