"""Certification of design spaces: exact arithmetic, and poses that were not used."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import islice

import numpy as np

from balance.exact.chain import exact_chain, regular
from balance.exact.conditions import joints_at_rest
from balance.exact.modular import PRIMES
from balance.exact.proof import Proof, independent
from balance.exact.ranks import GIVEN_UP, Exact, ranks_of
from balance.exact.serial import branches, exact_transfers
from balance.momentum import rows_at
from balance.spaces.certainty import LEVELS, Certainty
from balance.spaces.correction import (
    Evidence,
    correct,
    exact_orders,
    with_idle_joints,
    with_more_poses,
)
from balance.spaces.replaced import with_changed_numbers
from balance.spaces.space import DesignSpace
from kinematics.errors import InexactClosureError, InexactPlaneError, LinkageError
from kinematics.linkage import Notice
from kinematics.reader.geometry import exact_geometry
from kinematics.walk import walk

__all__ = ["certify"]

# Momentum of a distribution of size 1 that counts as none, relative to the conditions.
BALANCED = 1e-11
# What counts as round-off of small loops on long arms, if exact arithmetic finds no condition
# at many orders further on.
SMALL = 1e-6
# Sizes below which that, and a singular value, are round-off beyond doubt.
ROUND_OFF = 1e-14
# Rays along which poses are tried, steps each way, and the longest of them.
RAYS, STEPS, STEP = 2, 8, 0.237
# Times that poses are added while momenta are left at fresh ones.
ROUNDS = 3
# Orders to which the loops of an overconstrained linkage are closed exactly, at least, and at
# which joints must be at rest to count as idle: twice as many as a gear of three yokes and a
# dead centre, which moves a joint with the 14th power of the input, can hide.
CLOSURE_ORDERS = 30
# Axes that are further from parallel were not rounded to double precision (radians).
PARALLEL = 1e-15
_UNSETTLED = "poses further on need more conditions than were found"


def certify(space: DesignSpace) -> DesignSpace:
    """The design space with its integers confirmed or corrected, and how sure they are.

    Exact arithmetic, from the decimals of the file, bounds the rank from below at every
    order, and inertia transfers in rational numbers bound the nullity from below. Where
    floating point found other integers, the space is computed again with the exact ones,
    and a notice says so. Where momenta are left at fresh poses, poses are added.

    Args:
        space: what `design_space` found.

    Returns:
        The space; its ``certainty`` holds for all of its integers.

    Example:
        >>> import balance, kinematics
        >>> space = balance.design_space(kinematics.load("robot.urdf"))
        >>> balance.certify(space).certainty.level
        'proved'
    """
    try:
        found = _evidence(space)
    except LinkageError as error:
        rounded = _by_rounding(space, f"not by exact arithmetic: {error}", None)
        return _told_of_rounding(rounded, error)
    # Numbers within 2^-64 of what is meant lose a special geometry, which floating point sees
    # with a wide gap; where the gap is doubtful, more conditions without these numbers tell.
    if (count := found.replaced) and (lines := _differences(space, found)):
        changed = with_changed_numbers(space)
        if not space.doubts or _moved(space):
            rests = changed is None or bool(_changes(space, changed))
        else:
            rests = changed is not None and changed.rank > space.rank
        if rests:
            text = f"exact arithmetic, with {count} numbers of the file replaced: "
            # What neither these numbers nor rounding explain is special in two ways.
            mixed = changed is not None and bool(_differences(changed, found))
            return _by_rounding(space, text + "; ".join(lines), found, mixed)
    moving = set(range(len(space.linkage.joints))) - set(found.idle)
    rested = space
    if moving != set(space.chain.joints.tolist()):
        rested = with_idle_joints(space, found.idle)
    corrected = correct(rested, found)
    residual, poses = _residual(corrected)
    for _ in range(ROUNDS):
        if not _unsettled(corrected, found, residual):
            break
        corrected = with_more_poses(corrected)
        found = _evidence(corrected)
        corrected = correct(corrected, found)
        residual, poses = _residual(corrected)
    certainty = _judged(corrected, found, residual, poses)
    return _told(space, replace(corrected, certainty=certainty))


def _codes(space: DesignSpace) -> set[str]:
    """Codes of the notices of the linkage."""
    return {notice.code for notice in space.linkage.notices}


def _moved(space: DesignSpace) -> bool:
    """Whether the reference pose is not that of the file."""
    return bool(_codes(space) & {"assembled", "left_singular_pose"})


def _evidence(space: DesignSpace) -> Evidence:
    """What exact arithmetic finds.

    Raises:
        LinkageError: exact arithmetic cannot be done.
    """
    linkage = space.linkage
    geometry = exact_geometry(linkage)
    chain = exact_chain(
        linkage, geometry, space.motion, space.balance == "force", not space.planar
    )
    idle, _ = joints_at_rest(chain, CLOSURE_ORDERS)
    transfers = tuple(exact_transfers(chain, idle))
    size = len(chain.links) * len(chain.parameters)
    most = size - len(independent(chain, transfers, PRIMES[0]))
    exact = ranks_of(
        linkage.source, chain, geometry.notices, space.highest_order, space.rank, most
    )
    found = independent(chain, transfers, exact.witness.prime)
    return Evidence(exact, transfers, found, not branches(chain, idle), tuple(idle))


def _unsettled(space: DesignSpace, found: Evidence, residual: float) -> bool:
    """Whether momenta are left that poses further on may condition."""
    complete = found.exact.rank + len(found.independent) == found.exact.parameters
    return residual > BALANCED and not complete and space.highest_order is None


def _differences(space: DesignSpace, found: Evidence) -> list[str]:
    """Where the integers of a space differ from the exact ones, a line each."""
    exact, lines = found.exact, []
    ranks = [order.rank for order in space.orders]
    known = exact.ranks + exact.ranks[-1:] * (len(ranks) - len(exact.ranks))
    apart = [k for k, pair in enumerate(zip(ranks, known, strict=False)) if len({*pair}) > 1]
    if apart:
        here, there = ([row[k] for k in apart] for row in (ranks, known))
        lines.append(f"{_counted('order', apart)}: rank {_list(there)}, not {_list(here)}")
    if space.rank != exact.rank:
        lines.append(f"rank {exact.rank}, not {space.rank}")
    serial = len(found.independent)
    if serial != space.serial_nullity and found.all_transfers(space.serial_nullity):
        lines.append(f"serial part {serial}, not {space.serial_nullity}")
    return lines


def _counted(noun: str, numbers: Sequence[int]) -> str:
    return f"{noun}{'s' if len(numbers) > 1 else ''} {_list(numbers)}"


def _list(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))


def _changes(space: DesignSpace, certified: DesignSpace) -> list[str]:
    """Where two answers on one linkage have other integers, a line each."""
    pairs = [
        ("rank", space.rank, certified.rank),
        ("serial part", space.serial_nullity, certified.serial_nullity),
    ]
    lines = [f"{name} {there}, not {here}" for name, here, there in pairs if here != there]
    ranks = {order.order: order.rank for order in certified.orders}
    for order in space.orders:
        known = ranks.get(order.order, certified.rank)
        if known != order.rank:
            lines.append(f"order {order.order}: rank {known}, not {order.rank}")
    return lines


def _told(space: DesignSpace, certified: DesignSpace) -> DesignSpace:
    """The certified space with a notice of what floating point found instead."""
    if not (changes := _changes(space, certified)):
        return certified
    text = f"floating point alone finds other integers; here it is {'; '.join(changes)}"
    codes = ("not_settled",) if certified.settled else ()
    kept = tuple(notice for notice in certified.notices if notice.code not in codes)
    return replace(certified, notices=(*kept, Notice("corrected", text)))


def _told_of_rounding(space: DesignSpace, error: LinkageError) -> DesignSpace:
    """The space with what the file's rounding, which exact arithmetic refused, means for it."""
    if isinstance(error, InexactPlaneError) and error.deviation > PARALLEL:
        doubt = f"its axes are parallel to within {error.deviation:.0e} rad only: {error}"
        doubts = (*space.certainty.doubts, doubt)
        certainty = space.certainty._replace(level=LEVELS[0], doubts=doubts)
        return replace(space, certainty=certainty)
    code = "closes_to_rounding"
    known = any(notice.code == code for notice in space.notices)
    if known or not isinstance(error, InexactClosureError):
        return space
    text = (
        "loops close only to the rounding of the numbers in the file: the answer is that of "
        "the linkage that these stand for"
    )
    return replace(space, notices=(*space.notices, Notice(code, text)))


def _judged(space: DesignSpace, found: Evidence, residual: float, poses: int) -> Certainty:
    """The certainty of a space from exact arithmetic and fresh poses."""
    exact, serial = found.exact, len(found.independent)
    count = found.replaced
    replaced = f", with {count} numbers of the file replaced (see --exact)" if count else ""
    bounds = exact.rank, serial, residual, poses
    lines = _differences(space, found)
    limited = space.highest_order is not None and not space.decision.conditions.complete
    if limited and not lines:
        reason = f"orders up to {space.highest_order} only: more conditions may follow"
        return Certainty("estimated", reason, *bounds)
    if lines or not space.settled:
        reason = "exact arithmetic finds " + "; ".join(lines) if lines else _UNSETTLED
        return Certainty("estimated", reason, *bounds, (reason,))
    complete = exact.rank + serial == exact.parameters
    idle = found.idle
    free = {j for j in idle if j in exact.chain.dependent or any(exact.chain.columns[j])}
    if complete and exact.regular and (not free or regular(exact.chain, idle)):
        proof = Proof(exact.chain, exact.witness, found.independent, tuple(sorted(idle)))
        reason = "exact lower bounds of rank and nullity add up to the number of parameters"
        ranks = tuple(order.rank for order in exact_orders(space, exact))
        return Certainty("proved", reason + replaced, *bounds, (), proof, ranks)
    order = max(CLOSURE_ORDERS, len(exact.ranks) - 1)
    if doubt := _unverified(space, found, residual, poses, order):
        return Certainty("estimated", doubt, *bounds, (doubt,))
    reason = "balanced at finite poses, and of the same rank by exact arithmetic"
    if complete:
        reason = (
            "exact lower bounds of rank and nullity add up to the number of parameters; loops "
            f"close exactly up to order {order}, and numerically at {poses} poses"
        )
    return Certainty("verified", reason + replaced, *bounds)


def _unverified(
    space: DesignSpace, found: Evidence, residual: float, poses: int, order: int
) -> str:
    """Why a space of the exact integers is not verified; empty if it is.

    Args:
        space: the space.
        found: what exact arithmetic finds.
        residual: largest momentum left at fresh poses.
        poses: how many of them there are.
        order: the order up to which loops must close exactly.
    """
    exact = found.exact
    resting, closing = joints_at_rest(exact.chain, order)
    if closing <= order or not set(found.idle) <= set(resting):
        return f"its loops do not close exactly, or idle joints move, up to order {order}"
    if not exact.settled:
        return f"exact arithmetic finds conditions up to order {exact.kmax}: more may follow"
    if not poses:
        return "no finite pose was found to check it at"
    if residual > BALANCED and not (residual <= SMALL and _stays(space, exact)):
        return _left(residual)
    return ""


def _left(residual: float) -> str:
    return f"momenta of {residual:.1e} of the conditions are left at finite poses"


def _stays(space: DesignSpace, exact: Exact) -> bool:
    """Whether many orders further on add no condition, by exact arithmetic."""
    last = GIVEN_UP + 3 * exact.kmax
    further = ranks_of(space.linkage.source, exact.chain, exact.notices, last)
    return further.rank == exact.rank


def _by_rounding(
    space: DesignSpace, reason: str, found: Evidence | None, doubtful: bool = False
) -> DesignSpace:
    """The certainty of a space where floating point alone decides; or is in doubt."""
    settled, (residual, poses) = space, _residual(space)
    for _ in range(ROUNDS):
        if residual <= BALANCED or space.highest_order is not None:
            break
        settled = with_more_poses(settled)
        residual, poses = _residual(settled)
    bounds: tuple[int | None, int | None] = (None, None)
    if found is not None:
        bounds = found.exact.rank, len(found.independent)
    same = bounds == (settled.rank, settled.serial_nullity)
    doubts = _doubts(settled, residual)
    left = found is not None and "left_singular_pose" in _codes(space) and not same
    if left or doubtful:
        # The file is of another pose, so nothing tells rounding from what the file says.
        doubts += (reason,)
    sure = not doubts and settled.settled and settled.highest_order is None and poses > 0
    # Without exact arithmetic a condition near round-off is not told from none; nor is it
    # known that axes that are parallel to within rounding are meant to be.
    tiny = max(settled.dropped, residual) <= ROUND_OFF
    parallel = settled.nullity > settled.serial_nullity
    level = LEVELS[bool(sure and ((tiny and parallel) or same))]
    seen = f"momenta vanish to {residual:.0e}; " if level == "verified" else ""
    certainty = Certainty(level, seen + reason, *bounds, residual, poses, doubts)
    return _told(space, replace(settled, certainty=certainty))


def _doubts(space: DesignSpace, residual: float) -> tuple[str, ...]:
    """Why the decisions of floating point may be wrong."""
    found = list(space.doubts)
    if not space.settled and space.highest_order is None:
        found.append(_UNSETTLED)
    elif residual > BALANCED and space.highest_order is None:
        found.append(_left(residual))
    return tuple(found)


def _residual(space: DesignSpace) -> tuple[float, int]:
    """Largest momentum left at fresh poses, relative to the conditions; how many poses.

    Both ways along generic rays; steps are shorter than those to the poses that decided.
    """
    chain, force, basis = space.chain, space.balance == "force", space.decision.basis
    rng = np.random.default_rng(106)
    worst, poses = 0.0, 0
    for _ in range(1 if chain.width == 1 else RAYS):
        ray = rng.standard_normal(chain.width)
        for sign in (1.0, -1.0):
            way = walk(chain, sign * ray / np.sqrt(ray @ ray), reach=STEP)
            for pose in islice(way, STEPS):
                X = rows_at(chain, pose, force)
                left = np.sqrt(np.sum((X @ basis) ** 2, axis=0)).max(initial=0.0)
                worst = max(worst, float(left / (np.linalg.norm(X) or 1.0)))
                poses += 1
    return worst, poses
