"""Certification of design spaces: exact arithmetic, and poses that were not used."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from balance.space.certification.below_digits import joints_as_subject, reason_below_digits
from balance.space.certification.certified_space import CertifiedSpace, with_certainty
from balance.space.certification.compare_integers import (
    add_correction_notice,
    list_differences,
)
from balance.space.certification.correct_integers import (
    Evidence,
    correct_integers,
    exact_orders,
    with_idle_joints,
    with_more_poses,
)
from balance.space.certification.meant_notice import (
    add_meant_notice,
    add_mending_doubt,
)
from balance.space.certification.replaced_numbers import (
    add_roots_notice,
    is_general_as_written,
    notice_codes,
    replaced_text,
    rests_on_replaced,
    round_off_counts,
    with_changed_numbers,
)
from balance.space.conditions.fresh_momenta import momentum_left
from balance.space.exact.chain import ExactChain, exact_chain, loops_are_regular
from balance.space.exact.conditions import first_orders_of_motion, orders_closed
from balance.space.exact.idle_joints import joints_shown_at_rest
from balance.space.exact.modular_ranks import PLATEAU_WITHOUT_BOUND, ExactRanks, ranks_of
from balance.space.exact.modular_series import primes_of
from balance.space.exact.proof import Proof, independent_transfers
from balance.space.exact.serial import exact_transfers, has_branching_links
from balance.space.spaces.certainty import Certainty
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import Balance
from balance.support.tolerances import (
    MOMENTUM_RESIDUAL,
    MOMENTUM_RESIDUAL_ILL_CONDITIONED,
    PARALLEL_AXES_ROUNDED,
)
from kinematics.errors import (
    InexactClosureError,
    InexactPlaneError,
    LinkageError,
)
from kinematics.files.urdf.rational_screws import Geometry, of_lowest_rank
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.linkage import Notice
from kinematics.numerics.array_types import IntArray
from kinematics.wording import count_noun, size_text

# Lowest order up to which the loops of an overconstrained linkage must close exactly, and
# joints be at rest to count as idle: twice the 14th power of the input with which a gear of
# three yokes and a dead centre moves a joint.
CLOSURE_ORDERS = 30
# The same where joints are at rest at these orders, and not shown to be at rest at others.
CLOSURE_ORDERS_OF_IDLE_JOINTS = 126
# Orders up to which conditions may come, and loops open, for each order at which the last joint
# starts to move: a joint that moves with a power of the input drives others with its square.
ORDERS_PER_MOTION = 4
_BELIEVE_FLOATING_POINT = (
    "believe the latter: the digits of the file describe another linkage, which does not move "
    "so, and the answer is for the linkage that closes"
)
_BELIEVE_WITHOUT_LOOPS = (
    "believe the latter: replaced numbers may lose a special geometry, and add conditions"
)
_UNSETTLED = "poses further on need more conditions than were found"


def certify(
    space: DesignSpace | LinkageLike, *, balance: Balance | None = None
) -> CertifiedSpace:
    """Confirm or correct the integers of a design space, and state how sure they are.

    Exact arithmetic, from the decimals of the file, bounds the rank from below at every
    order. Inertia transfers in rational numbers bound the nullity from below. If both bounds
    add up to the number of parameters, they prove rank and nullity. Where floating point found
    other integers, the space is computed again with the exact ones, and the notice
    ``corrected`` names both. Poses are added if fresh poses leave momentum. Where exact
    arithmetic is impossible, fresh poses alone decide the certainty. See docs/theory/exact.md.

    Args:
        space: a design space from `design_space`, or an argument of it.
        balance: ``"dynamic"``, as by default, or ``"force"``; of a space, what it is for.

    Returns:
        The space; its ``certainty`` holds for all of its integers.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, section 5.5, for the transfers.

    Example:
        >>> import balance
        >>> space = balance.design_space("robot.urdf")
        >>> balance.certify(space).certainty.level
        'proved'
    """
    space = as_space(space, balance=balance)
    if isinstance(space, CertifiedSpace):
        return space
    return add_meant_notice(add_mending_doubt(_certify(space)))


def _certify(space: DesignSpace) -> CertifiedSpace:
    """Confirm or correct the integers of a design space; see `certify`."""
    try:
        evidence = _gather_evidence(space)
    except LinkageError as error:
        rounded = _certify_rounded(space, f"not by exact arithmetic: {error}", None)
        return _add_rounding_notice(rounded, error)
    lines = list_differences(space, evidence)
    if evidence.replaced and lines and not round_off_counts(space, evidence):
        numbers = count_noun(evidence.replaced, "number")
        changed = with_changed_numbers(space)
        if rests_on_replaced(space, changed) and not is_general_as_written(space, evidence):
            # A difference that these numbers do not explain either comes from round-off.
            mixed = changed is not None and bool(list_differences(changed, evidence))
            believed = _BELIEVE_WITHOUT_LOOPS
            if space.linkage.loops:
                believed = _BELIEVE_FLOATING_POINT
            reason = (
                f"exact arithmetic, with {numbers} of the file replaced, finds "
                f"{'; '.join(lines)}; {believed}"
            )
            return _certify_rounded(space, reason, evidence, mixed)
    moving = set(range(len(space.linkage.joints))) - set(evidence.idle)
    rested = space
    if moving != set(space.chain.joints.tolist()):
        rested = with_idle_joints(space, evidence.idle)
    corrected = correct_integers(rested, evidence)
    residual, poses = _measure_residual(corrected)
    if _needs_poses(corrected, evidence, residual):
        more = with_more_poses(corrected)
        if more is not corrected:
            evidence = _gather_evidence(more)
            corrected = correct_integers(more, evidence)
            residual, poses = _measure_residual(corrected)
    corrected = _settle(corrected, evidence, residual, poses)
    certainty = _certainty_of(corrected, evidence, residual, poses)
    if doubt := reason_below_digits(space, corrected, evidence):
        certainty = certainty.with_doubt(doubt)
    certified = add_correction_notice(space, with_certainty(corrected, certainty))
    certified = add_roots_notice(certified, evidence)
    certified.check_proved()
    return certified


def _gather_evidence(space: DesignSpace) -> Evidence:
    """Compute ranks, transfers and idle joints of a space by exact arithmetic.

    Of geometries of equal ranks, that with the fewest replaced numbers serves; but at a pose
    that Newton's method closed, the one whose replaced numbers are told.

    Raises:
        LinkageError: exact arithmetic cannot be done.
    """
    in_file = space.linkage.displaced is None

    def ranks(evidence: Evidence) -> tuple[int, ...]:
        replaced = evidence.replaced if in_file else 0
        return evidence.exact.rank, *evidence.exact.ranks, replaced

    return of_lowest_rank(
        space.linkage,
        lambda geometry: _gather_evidence_of(space, geometry),
        ranks,
        lambda evidence: not list_differences(space, evidence),
    )


def _gather_evidence_of(space: DesignSpace, geometry: Geometry) -> Evidence:
    """Compute the evidence of a geometry in rational numbers; see `_gather_evidence`."""
    linkage = space.linkage
    chain = exact_chain(
        linkage, geometry, space.motion, space.balance == "force", not space.planar
    )
    order, lowest = CLOSURE_ORDERS, first_orders_of_motion(chain, CLOSURE_ORDERS)
    if _joints_in_doubt(chain, lowest):
        order = CLOSURE_ORDERS_OF_IDLE_JOINTS
        lowest = first_orders_of_motion(chain, order)
    order = max(order, ORDERS_PER_MOTION * int(lowest.max()))
    idle = np.flatnonzero(lowest < 0).tolist()
    transfers = tuple(exact_transfers(chain, idle))
    size = len(chain.links) * len(chain.parameters)
    most = size - len(independent_transfers(chain, transfers, next(primes_of(chain))))
    exact = ranks_of(
        linkage.source,
        chain,
        geometry.notices,
        space.highest_order,
        space.rank,
        most,
        ORDERS_PER_MOTION * int(lowest.max()),
    )
    independent = independent_transfers(chain, transfers, exact.witness.prime)
    return Evidence(
        exact,
        transfers,
        independent,
        not has_branching_links(chain, idle),
        tuple(idle),
        _joints_in_doubt(chain, lowest),
        order,
        linkage.meant is not None and geometry.screws is linkage.meant.screws,
    )


def _joints_in_doubt(chain: ExactChain, lowest: IntArray) -> tuple[int, ...]:
    """List the joints at rest at all orders computed that no argument shows to be at rest.

    Args:
        chain: the linkage in rational numbers.
        lowest: order at which each joint first moves, -1 if at none (n,).
    """
    idle = np.flatnonzero(lowest < 0).tolist()
    return tuple(sorted(set(idle) - joints_shown_at_rest(chain, idle)))


def _settle(space: DesignSpace, evidence: Evidence, residual: float, poses: int) -> DesignSpace:
    """Settle a space some of whose conditions only exact arithmetic sees.

    They are below round-off: floating point does not choose the directions that they exclude,
    and the basis leaves no momentum at fresh poses in any case.
    """
    exact = evidence.exact
    if space.settled or not exact.settled or exact.rank != space.rank:
        return space
    if not poses or residual > MOMENTUM_RESIDUAL or not _adds_no_condition(space, exact):
        return space
    notices = tuple(x for x in space.notices if x.code != "not_settled")
    return replace(space, settled=True, notices=notices)


def _needs_poses(space: DesignSpace, evidence: Evidence, residual: float) -> bool:
    """Whether fresh poses leave momentum, so that more poses may add conditions."""
    complete = evidence.exact.rank + len(evidence.independent) == evidence.exact.parameters
    return residual > MOMENTUM_RESIDUAL and not complete and space.highest_order is None


def _add_rounding_notice(space: CertifiedSpace, error: LinkageError) -> CertifiedSpace:
    """Add the doubt, or the notice, about rounding that exact arithmetic refused."""
    doubt, mobility = "", space.linkage.mobility
    written = space.linkage.as_written
    if isinstance(error, InexactPlaneError) and (
        written or error.deviation > PARALLEL_AXES_ROUNDED
    ):
        doubt = f"its axes are parallel to within {error.deviation:.0e} rad only"
    if isinstance(error, InexactClosureError):
        if 0 < error.mobility != mobility:
            doubt = f"mobility: {mobility} up to rounding, and {error.mobility} as written"
        elif error.orders or written:
            explained = "" if written else "which rounding hardly leaves, "
            doubt = (
                f"mobility: in the decimals of the file the loops close at {error.orders} "
                f"orders, {explained}and open at the next"
            )
    if doubt:
        certainty = space.certainty
        doubts = (*certainty.doubts, doubt)
        return replace(space, certainty=certainty._replace(level="estimated", doubts=doubts))
    if not isinstance(error, InexactClosureError):
        return space
    text = (
        "loops close only to the rounding of the numbers in the file: the answer is that of "
        "the linkage that these stand for"
    )
    return replace(space, notices=(*space.notices, Notice("inexact_closure", text)))


def _certainty_of(
    space: DesignSpace, evidence: Evidence, residual: float, poses: int
) -> Certainty:
    """Decide the certainty of a space from exact arithmetic and fresh poses."""
    exact, serial = evidence.exact, len(evidence.independent)
    replaced = replaced_text(evidence)
    bounds = exact.rank, serial, residual, poses
    lines = list_differences(space, evidence)
    limited = space.highest_order is not None and not space.decision.conditions.complete
    if limited and not lines:
        reason = f"orders up to {space.highest_order} only: more conditions may follow"
        return Certainty("estimated", reason, *bounds)
    if lines or not space.settled:
        reason = "exact arithmetic finds " + "; ".join(lines) if lines else _UNSETTLED
        return Certainty("estimated", reason, *bounds, (reason,))
    complete = exact.rank + serial == exact.parameters
    idle = evidence.idle
    free = {j for j in idle if j in exact.chain.dependent or any(exact.chain.columns[j])}
    regular = exact.regular and (not free or loops_are_regular(exact.chain, idle))
    if complete and regular and not evidence.roots:
        proof = Proof(exact.chain, exact.witness, evidence.independent, tuple(sorted(idle)))
        reason = "exact lower bounds of rank and nullity add up to the number of parameters"
        ranks = tuple(order.rank for order in exact_orders(space, exact))
        return Certainty("proved", reason + replaced, *bounds, (), proof, ranks)
    order = max(evidence.order, len(exact.ranks) - 1)
    if doubt := _reason_unverified(space, evidence, residual, poses, order):
        return Certainty("estimated", doubt, *bounds, (doubt,))
    reason = "balanced at finite poses, and of the same rank by exact arithmetic"
    if complete:
        reason = (
            "exact lower bounds of rank and nullity add up to the number of parameters; loops "
            f"close exactly up to order {order}, and numerically at {poses} poses"
        )
    return Certainty("verified", reason + replaced, *bounds)


def _reason_unverified(
    space: DesignSpace, evidence: Evidence, residual: float, poses: int, order: int
) -> str:
    """State why a space with the exact integers is not verified; empty if it is.

    Args:
        evidence: the findings of exact arithmetic.
        residual: largest momentum left at fresh poses.
        poses: number of fresh poses.
        order: the order up to which loops must close exactly.
    """
    exact = evidence.exact
    closes = exact.regular or orders_closed(exact.chain, order) > order
    if not closes:
        return f"mobility: its loops do not close exactly up to order {order}"
    if evidence.in_doubt:
        joints = joints_as_subject(space, evidence.in_doubt)
        return f"idle joints: {joints} at rest up to order {order}, and may move at others"
    if not evidence.use_exact_transfers(space.serial_nullity) and space.doubts:
        return f"the serial part is that of floating point: {space.doubts[0]}"
    if not exact.settled:
        return f"exact arithmetic finds conditions up to order {exact.kmax}: more may follow"
    if not poses:
        return "no finite pose was found to check it at"
    if residual > MOMENTUM_RESIDUAL and not (
        residual <= MOMENTUM_RESIDUAL_ILL_CONDITIONED and _adds_no_condition(space, exact)
    ):
        return _momenta_left(residual)
    return ""


def _momenta_left(residual: float) -> str:
    return f"momenta of {size_text(residual)} of the conditions are left at finite poses"


def _adds_no_condition(space: DesignSpace, exact: ExactRanks) -> bool:
    """Whether exact arithmetic finds no condition at many further orders."""
    last = PLATEAU_WITHOUT_BOUND + 3 * exact.kmax
    further = ranks_of(space.linkage.source, exact.chain, exact.notices, last)
    return further.rank == exact.rank


def _certify_rounded(
    space: DesignSpace, reason: str, evidence: Evidence | None, doubtful: bool = False
) -> CertifiedSpace:
    """Certify a space where floating point alone decides, or is in doubt.

    Args:
        reason: why exact arithmetic does not decide.
        evidence: the findings of exact arithmetic, if there are any.
        doubtful: whether the reason is a doubt as well.
    """
    settled, (residual, poses) = space, _measure_residual(space)
    if residual > MOMENTUM_RESIDUAL and space.highest_order is None:
        settled = with_more_poses(space)
        if settled is not space:
            residual, poses = _measure_residual(settled)
    bounds: tuple[int | None, int | None] = (None, None)
    if evidence is not None:
        bounds = evidence.exact.rank, len(evidence.independent)
    same = bounds == (settled.rank, settled.serial_nullity)
    doubts = _list_doubts(settled, residual)
    # The file has another pose, so rounding cannot be separated from the contents of the file.
    moved = evidence is not None and "left_singular_pose" in notice_codes(space) and not same
    if moved or doubtful:
        doubts += (reason,)
    if not same and settled.highest_order is None:
        doubts += _list_below_round_off(settled)
    sure = not doubts and settled.settled and settled.highest_order is None and poses > 0
    level = "verified" if sure and same else "estimated"
    seen = (
        f"momenta are {size_text(residual, '.0e')} of the conditions; "
        if level == "verified"
        else ""
    )
    certainty = Certainty(level, seen + reason, *bounds, residual, poses, doubts)
    return add_correction_notice(space, with_certainty(settled, certainty))


def _list_below_round_off(space: DesignSpace) -> tuple[str, ...]:
    """List what floating point alone cannot tell: conditions, or motions, below round-off."""
    unseen = []
    if parallel := space.nullity - space.serial_nullity:
        unseen.append(
            f"rank: the parallel part of {parallel} rests on floating point alone, which does "
            "not see conditions below round-off"
        )
    if idle := np.flatnonzero([j.name in space.idle for j in space.linkage.joints]).tolist():
        unseen.append(
            f"idle joints: {joints_as_subject(space, idle)} at rest by floating point alone, "
            "which does not see motions below round-off"
        )
    return tuple(unseen)


def _list_doubts(space: DesignSpace, residual: float) -> tuple[str, ...]:
    """List reasons why decisions of floating point may be wrong."""
    doubts = list(space.doubts)
    if not space.settled and space.highest_order is None:
        doubts.append(_UNSETTLED)
    elif residual > MOMENTUM_RESIDUAL and space.highest_order is None:
        doubts.append(_momenta_left(residual))
    return tuple(doubts)


def _measure_residual(space: DesignSpace) -> tuple[float, int]:
    """Measure the largest momentum left at fresh poses; see `momentum_left`."""
    return momentum_left(space.chain, space.decision.basis, space.balance == "force")
