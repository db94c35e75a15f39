"""Certification of design spaces: exact arithmetic, and poses that were not used."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

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
    decimals_have_rank,
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
from balance.space.exact.modular_ranks import PLATEAU_WITHOUT_BOUND, Exact, ranks_of
from balance.space.exact.modular_series import primes_of
from balance.space.exact.proof import Proof, independent_transfers
from balance.space.exact.serial import exact_transfers, has_branching_links
from balance.space.spaces.certainty import Certainty
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.space.spaces.distance_to_rank_drop import distance_to_rank_drop
from balance.support.tolerances import (
    CONDITION_OF_TILTS,
    CONDITION_PER_CHANGE,
    DIGITS_CONDITION,
    DIGITS_OF_CONDITION,
    DOUBLE_ROUNDING,
    LARGEST_DIGITS_CONDITION,
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
from kinematics.loading.meant.digits import (
    DOUBLE_DIGITS,
    file_digits,
    half_unit_of_file,
)
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.chain import extent
from kinematics.model.linkage import Notice
from kinematics.numerics.array_types import IntArray
from kinematics.wording import count_noun, size_text

# Most rounds of added poses, as long as fresh poses leave momentum.
MAX_ROUNDS = 3
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
_UNSETTLED = "poses further on need more conditions than were found"


def certify(space: DesignSpace | LinkageLike) -> CertifiedSpace:
    """Confirm or correct the integers of a design space, and state how sure they are.

    Exact arithmetic, from the decimals of the file, bounds the rank from below at every
    order. Inertia transfers in rational numbers bound the nullity from below. If both bounds
    add up to the number of parameters, they prove rank and nullity. Where floating point found
    other integers, the space is computed again with the exact ones, and the notice
    ``corrected`` names both. Poses are added while fresh poses leave momentum. Where exact
    arithmetic is impossible, fresh poses alone decide the certainty. See docs/theory/exact.md.

    Args:
        space: a design space from `design_space`, or an argument of it.

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
    if isinstance(space, CertifiedSpace):
        return space
    return add_meant_notice(add_mending_doubt(_certify(as_space(space))))


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
            reason = (
                f"exact arithmetic, with {numbers} of the file replaced, finds "
                f"{'; '.join(lines)}; {_BELIEVE_FLOATING_POINT}"
            )
            return _certify_rounded(space, reason, evidence, mixed)
    moving = set(range(len(space.linkage.joints))) - set(evidence.idle)
    rested = space
    if moving != set(space.chain.joints.tolist()):
        rested = with_idle_joints(space, evidence.idle)
    corrected = correct_integers(rested, evidence)
    residual, poses = _measure_residual(corrected)
    for _ in range(MAX_ROUNDS):
        if not _needs_poses(corrected, evidence, residual):
            break
        corrected = with_more_poses(corrected)
        evidence = _gather_evidence(corrected)
        corrected = correct_integers(corrected, evidence)
        residual, poses = _measure_residual(corrected)
    certainty = _certainty_of(corrected, evidence, residual, poses)
    if doubt := _reason_below_digits(space, corrected, evidence):
        certainty = certainty.with_doubt(doubt)
    certified = add_correction_notice(space, with_certainty(corrected, certainty))
    certified = add_roots_notice(certified, evidence)
    certified.check_proved()
    return certified


def _gather_evidence(space: DesignSpace) -> Evidence:
    """Compute ranks, transfers and idle joints of a space by exact arithmetic.

    Raises:
        LinkageError: exact arithmetic cannot be done.
    """
    return of_lowest_rank(
        space.linkage,
        lambda geometry: _gather_evidence_of(space, geometry),
        lambda evidence: (evidence.exact.rank, *evidence.exact.ranks),
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


def _needs_poses(space: DesignSpace, evidence: Evidence, residual: float) -> bool:
    """Whether fresh poses leave momentum, so that more poses may add conditions."""
    complete = evidence.exact.rank + len(evidence.independent) == evidence.exact.parameters
    return residual > MOMENTUM_RESIDUAL and not complete and space.highest_order is None


def _add_rounding_notice(space: CertifiedSpace, error: LinkageError) -> CertifiedSpace:
    """Add the doubt, or the notice, about rounding that exact arithmetic refused."""
    doubt, mobility = "", space.linkage.mobility
    if isinstance(error, InexactPlaneError) and error.deviation > PARALLEL_AXES_ROUNDED:
        doubt = f"its axes are parallel to within {error.deviation:.0e} rad only"
    if isinstance(error, InexactClosureError):
        if 0 < error.mobility != mobility:
            doubt = f"mobility: {mobility} up to rounding, and {error.mobility} as written"
        elif error.orders:
            doubt = (
                f"mobility: in the decimals of the file the loops close at {error.orders} "
                "orders, which rounding hardly leaves, and open at the next"
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
        joints = _names(space, evidence.in_doubt)
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


def _reason_below_digits(space: DesignSpace, corrected: DesignSpace, evidence: Evidence) -> str:
    """State why conditions of a geometry inside the digits may not be meant; empty if not.

    A geometry that has the relations found is at another place inside the digits than the
    linkage, so that it may break relations that were not looked for. Nor are those looked for
    that rounded numbers break in loops that are neither planar nor spherical.

    Args:
        space: the space by floating point.
        corrected: the space with the integers of that geometry.
    """
    meant, limit = space.linkage.meant, 0.0
    adds = corrected.rank > space.rank
    if evidence.inside_digits and meant is not None:
        if adds or (meant.relations and meant.apart):
            limit = 10.0 ** (DIGITS_OF_CONDITION - (meant.digits or DOUBLE_DIGITS))
        if meant.apart and space.linkage.mended and meant.near is None:
            limit = max(limit, _condition_of_rounding(_rounding_of(space)))
        if adds:
            # As written, axes were moved by round-off alone; their lever enlarges it.
            tilted = space.linkage.as_written
            limit = max(limit, CONDITION_OF_TILTS if tilted else DIGITS_CONDITION)
    elif meant is None and adds and not space.linkage.as_written:
        if rounding := _rounding_of(space):
            limit = 10.0 ** (DIGITS_OF_CONDITION - DOUBLE_DIGITS - 1)
        if rounding > DOUBLE_ROUNDING:
            limit = max(limit, _condition_of_rounding(rounding))
    if not corrected.rank:
        return ""
    least = float(corrected.singular_values[-1])
    if least >= limit:
        inexact = meant is None and evidence.replaced > 0
        return _reason_within_rounding(space, corrected, least) if inexact else ""
    if decimals_have_rank(space, corrected.rank):
        return ""
    return (
        f"rank: the least condition is {size_text(least, '.0e')} of the largest, and may come "
        "from digits that the file does not have"
    )


def _reason_within_rounding(space: DesignSpace, corrected: DesignSpace, least: float) -> str:
    """State that a change of the geometry within the digits of the file lowers the rank.

    For linkages whose loops do not close in the decimals of the file. Relations of loops that
    are neither planar nor spherical are not looked for by name.

    Args:
        space: the space by floating point.
        corrected: the space with the exact integers.
        least: its least condition over the largest.

    Returns:
        The doubt; empty without one.
    """
    rounding = _rounding_of(space)
    if space.linkage.as_written or not space.linkage.loops or not rounding:
        return ""
    if least > CONDITION_PER_CHANGE * rounding:
        return ""
    if distance_to_rank_drop(corrected) > rounding:
        return ""
    return (
        f"rank: a change of the geometry by less than {size_text(rounding, '.0e')} of the "
        "size, below the digits of the file, lowers it"
    )


def _condition_of_rounding(rounding: float) -> float:
    """Compute the largest condition, over the largest of all, that rounding may add."""
    return min(CONDITION_PER_CHANGE * rounding, LARGEST_DIGITS_CONDITION)


def _rounding_of(space: DesignSpace) -> float:
    """Compute the largest half unit of the numbers of a file, in parts of the size, or 0."""
    tree = space.linkage.tree
    digits = None if tree is None else file_digits(tree)
    if tree is None or digits is None:
        return 0.0
    return half_unit_of_file(tree, digits, max(extent(space.linkage).length, 1e-300))


def _adds_no_condition(space: DesignSpace, exact: Exact) -> bool:
    """Whether exact arithmetic finds no condition at many further orders."""
    last = PLATEAU_WITHOUT_BOUND + 3 * exact.kmax
    further = ranks_of(space.linkage.source, exact.chain, exact.notices, last)
    return further.rank == exact.rank


def _names(space: DesignSpace, joints: Iterable[int]) -> str:
    """Name joints as the subject of a sentence in the present tense."""
    names = [f"'{space.linkage.joints[j].name}'" for j in joints]
    return f"joint {names[0]} is" if len(names) == 1 else f"joints {', '.join(names)} are"


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
    for _ in range(MAX_ROUNDS):
        if residual <= MOMENTUM_RESIDUAL or space.highest_order is not None:
            break
        settled = with_more_poses(settled)
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
        doubts += _list_unseen(settled)
    sure = not doubts and settled.settled and settled.highest_order is None and poses > 0
    level = "verified" if sure and same else "estimated"
    seen = (
        f"momenta are {size_text(residual, '.0e')} of the conditions; "
        if level == "verified"
        else ""
    )
    certainty = Certainty(level, seen + reason, *bounds, residual, poses, doubts)
    return add_correction_notice(space, with_certainty(settled, certainty))


def _list_unseen(space: DesignSpace) -> tuple[str, ...]:
    """List what floating point alone cannot tell: conditions, or motions, below round-off."""
    unseen = []
    if parallel := space.nullity - space.serial_nullity:
        unseen.append(
            f"rank: the parallel part of {parallel} rests on floating point alone, which does "
            "not see conditions below round-off"
        )
    if idle := np.flatnonzero([j.name in space.idle for j in space.linkage.joints]).tolist():
        unseen.append(
            f"idle joints: {_names(space, idle)} at rest by floating point alone, which does "
            "not see motions below round-off"
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
