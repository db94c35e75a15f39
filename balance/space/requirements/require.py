"""Several requirements in one design space: their intersection, and how sure it is.

Each requirement is an exact chain of its own, with its own motion, components and highest
order, on parameters that all of them share. The rank of their stacked conditions modulo a prime
is a lower bound of the true one, as in `balance.space.exact.modular_ranks`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import islice
from math import comb

import numpy as np

from balance.space.conditions.fresh_momenta import momentum_left
from balance.space.exact.chain import ExactChain, exact_chain
from balance.space.exact.conditions import directions_of
from balance.space.exact.modular import Echelon
from balance.space.exact.modular_series import (
    Momenta,
    Remainders,
    chain_modulo,
    first_order_mobility,
)
from balance.space.exact.radicals import primes_with_roots
from balance.space.momentum.regressor import parameters_per_body
from balance.space.requirements.components import exact_rows
from balance.space.requirements.region_conditions import (
    CommonData,
    RegionConditions,
    collect_region,
)
from balance.space.requirements.required_space import (
    RequiredSpace,
    space_of,
    with_requirements,
)
from balance.space.requirements.requirement import read_requirements
from balance.space.spaces.certainty import Certainty
from balance.space.spaces.design_space import DesignSpace
from balance.support.options import GRAVITY
from balance.support.tolerances import MOMENTUM_RESIDUAL, MOMENTUM_RESIDUAL_ILL_CONDITIONED
from kinematics.errors import InexactClosureError, LinkageError, UsageError
from kinematics.files.urdf.rational_screws import Geometry, of_lowest_rank
from kinematics.loading.model_gallery import LinkageLike, as_linkage
from kinematics.model.linkage import Notice
from kinematics.wording import size_text

# Orders that must add nothing before the rank counts as final, and the last order computed.
PLATEAU, LAST_ORDER = 3, 33


def require(
    linkage: LinkageLike,
    requirements: str | Sequence[str],
    *,
    spatial: bool = False,
    gravity: Sequence[float] = GRAVITY,
) -> RequiredSpace:
    """Compute the mass distributions that satisfy several requirements at once.

    Each requirement has a quantity and a region in which it vanishes, and is a list of linear
    conditions on the same parameters; the conditions of all are stacked in one frame and scale,
    and one rank decision gives their common null space. Text of a requirement:
    ``QUANTITY [AXES] [about POINT] [REGION]``, such as ``"force"``, ``"dynamic at u1=0.3"``,
    ``"moment about 0,0,0.2 along u2=u3"``, ``"dynamic up to order 2 about u1=0.3"``,
    ``"force x,y along u2=u1**2"``, ``"gravity"``, ``"decoupled"``; see docs/requirements.md.

    Args:
        linkage: an assembled linkage, or what `kinematics.load` accepts.
        requirements: one or several texts; each may hold several requirements, with ``;``
            between. Their order does not matter.
        spatial: count all ten parameters per body, even if the linkage is planar.
        gravity: direction of gravity (3,), in the inertial frame.

    Returns:
        The space, with the rank of each requirement alone and what it adds to the others.
        Where all conditions are rational in the numbers of the file, exact arithmetic confirms
        the rank (``"verified"``); otherwise floating point decides (``"estimated"``).

    Raises:
        UsageError: a requirement cannot be read.
        LinkageError: the linkage cannot take a pose, or follow a motion, of a requirement.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, section 3.3, for force balance with
        dynamic balance in a pose.

    Example:
        >>> import balance
        >>> space = balance.require("robot.urdf", "force; dynamic at u1=0")
        >>> space.nullity, [item.rank for item in space.requirements]
        (7, [3, 4])
    """
    linkage = as_linkage(linkage)
    listed = read_requirements(requirements)
    g = np.asarray(gravity, dtype=np.float64)
    if g.shape != (3,) or not np.isfinite(g).all() or not g.any():
        raise UsageError(f"gravity has three coordinates that are not all 0, not {gravity!r}")
    x, y, z = (Fraction(str(component)) for component in g.tolist())
    masses = all(item.masses_alone for item in listed)
    common = CommonData(linkage, linkage.planar and not spatial, masses, (x, y, z))
    regions = tuple(collect_region(common, item) for item in listed)
    return _intersect(common, regions)


def _intersect(common: CommonData, regions: Sequence[RegionConditions]) -> RequiredSpace:
    """Intersect the spaces of requirements, and state how sure the integers are.

    Args:
        common: what the requirements share.
        regions: the conditions of each, in canonical order.
    """
    notices = _notices(regions)
    space = space_of(common, regions, notices)
    bound, reason = _exact_bound(common, regions, space.rank)
    if bound is not None and bound < space.rank:
        space = space_of(common, regions, notices, bound)
    certainty = _certainty(common, regions, space, bound, reason)
    return with_requirements(space, certainty, common, regions)


def _exact_bound(
    common: CommonData, regions: Sequence[RegionConditions], expected: int
) -> tuple[int | None, str]:
    """Compute the exact rank, None where it cannot be done, and the reason of the level."""
    rounded = [item.requirement.text for item in regions if not _has_exact_rank(item)]
    if rounded:
        return None, f"floating point decides where '{rounded[0]}' is asked for"
    try:
        bound = exact_rank(common, regions, expected)
    except LinkageError as error:
        return None, f"not by exact arithmetic: {error}"
    return bound, "balanced at finite poses, and of the same rank by exact arithmetic"


def _notices(regions: Sequence[RegionConditions]) -> list[Notice]:
    """List the requirements of which conditions may be missing."""
    return [
        Notice(
            "not_settled",
            f"requirement '{region.requirement.text}': poses further on need more conditions "
            "than were found: the rank may be too low",
        )
        for region in regions
        if not region.settled
    ]


def _certainty(
    common: CommonData,
    regions: Sequence[RegionConditions],
    space: DesignSpace,
    bound: int | None,
    reason: str,
) -> Certainty:
    """State how sure the integers of an intersection are.

    Args:
        common: what the requirements share.
        regions: the conditions of each.
        space: the intersection.
        bound: its rank by exact arithmetic, if that can be done.
        reason: why the level is what it is, but for doubts.
    """
    residual, poses = _residual_of(common, regions, space)
    doubts = list(space.doubts)
    # Round-off turns the basis by its size over the smallest singular value kept.
    if residual > min(MOMENTUM_RESIDUAL / space.kept, MOMENTUM_RESIDUAL_ILL_CONDITIONED):
        doubts.append(f"momenta of {size_text(residual)} of the conditions are left")
    if bound is not None and bound != space.rank:
        doubts.append(f"exact arithmetic finds rank {bound} instead of {space.rank}")
    verified = bound == space.rank and not doubts and space.settled
    if doubts:
        reason = doubts[0]
    return Certainty(
        "verified" if verified else "estimated",
        reason,
        bound,
        None,
        residual,
        poses,
        tuple(doubts),
    )


def _residual_of(
    common: CommonData, regions: Sequence[RegionConditions], space: DesignSpace
) -> tuple[float, int]:
    """Measure the largest momentum left at poses that were not used, and count these."""
    worst, poses, basis = 0.0, 0, space.decision.basis
    for region in regions:
        if region.chain is not None:
            requirement = region.requirement
            columns = basis
            if requirement.masses_alone and not common.masses:
                size, few = (parameters_per_body(common.planar, x) for x in (False, True))
                columns = basis.reshape(-1, size, basis.shape[1])[:, :few]
                columns = columns.reshape(-1, basis.shape[1])
            momentum, count = momentum_left(
                region.chain, columns, requirement.masses_alone, region.select
            )
            worst, poses = max(worst, momentum), poses + count
    return worst, poses


def _has_exact_rank(region: RegionConditions) -> bool:
    """Whether the conditions of a region are rational in the numbers of the file."""
    requirement = region.requirement
    at_reference = requirement.order is not None and not any(
        value for _, value in requirement.pose or ()
    )
    return at_reference or (region.chain is not None and requirement.quantity != "decoupled")


def exact_rank(common: CommonData, regions: Sequence[RegionConditions], expected: int) -> int:
    """Compute the rank of the conditions of several regions together, without a tolerance.

    Args:
        common: what the requirements share.
        regions: those that `_has_exact_rank` accepts.
        expected: the rank by floating point.

    Returns:
        A lower bound of the rank; that of the geometry that the file means.

    Raises:
        LinkageError: exact arithmetic cannot be done.
    """
    return of_lowest_rank(
        common.linkage,
        lambda geometry: _rank_of(common, regions, geometry, expected),
        lambda rank: (rank,),
        lambda rank: rank == expected,
    )


def _rank_of(
    common: CommonData, regions: Sequence[RegionConditions], geometry: Geometry, expected: int
) -> int:
    """Compute the rank in the rational numbers of one geometry; see `exact_rank`."""
    written = [(region, _chain_of(common, region, geometry)) for region in regions]
    # In a plane, a moment about an axis of the plane has no rows.
    regions = [region for region, chain in written if chain.rows]
    chains = [chain for _, chain in written if chain.rows]
    if not chains:
        return 0
    roots = sorted({b for chain in chains for numbers in chain.radicands for b in numbers})
    primes = primes_with_roots(roots, chains[0].conductor)
    runs = (_stack(chains, prime) for prime in primes)
    best = 0
    for chains_modulo in islice(filter(None, runs), 2):
        best = max(best, _rank_modulo(common, regions, chains, chains_modulo, expected))
    return best


def _chain_of(common: CommonData, region: RegionConditions, geometry: Geometry) -> ExactChain:
    """Write a region in rational numbers, on the parameters that all regions share."""
    spatial = not common.planar
    free = exact_chain(common.linkage, geometry, None, False, spatial)
    chain = exact_chain(common.linkage, geometry, region.motion, False, spatial)
    normal = free.rows[0][:3] if common.planar else None
    rows = tuple(
        tuple(map(Fraction, row))
        for row in exact_rows(region.requirement, common.gravity, normal)
    )
    count = (3 if common.planar else 4) if common.masses else len(free.parameters)
    return chain._replace(rows=rows, parameters=free.parameters[:count])


def _stack(chains: Sequence[ExactChain], prime: int) -> list[Remainders] | None:
    """Reduce all chains modulo a prime; None if it divides a denominator or a pivot."""
    reduced = [chain_modulo(chain, prime) for chain in chains]
    return [chain for chain in reduced if chain] if all(reduced) else None


def _rank_modulo(
    common: CommonData,
    regions: Sequence[RegionConditions],
    exact: Sequence[ExactChain],
    chains: Sequence[Remainders],
    expected: int,
) -> int:
    """Compute the rank modulo a prime, order by order, along as many rays as add to it.

    Raises:
        InexactClosureError: loops do not close at an order.
    """
    echelon, still = Echelon(common.parameters, chains[0].prime), 0
    momenta: list[list[Momenta]] = [[] for _ in chains]
    for order in range(LAST_ORDER + 1):
        before = echelon.rank
        for region, chain, whole, along in zip(regions, chains, exact, momenta, strict=True):
            last = region.requirement.order
            if last is not None and order > last:
                continue
            width = chain.rates.shape[1]
            for k, ray in enumerate(
                islice(directions_of(width), comb(width + order - 1, order))
            ):
                if k == len(along):
                    along.append(Momenta(chain, ray))
                added = echelon.absorb(along[k].rows(order))
                twists = along[k].twists
                if twists.closed < twists.orders:
                    source, mobility = common.linkage.source, first_order_mobility(whole)
                    raise InexactClosureError(source, twists.closed, mobility)
                if not added or echelon.rank == common.parameters:
                    break
        still = still + 1 if echelon.rank == before else 0
        if echelon.rank == common.parameters or (echelon.rank >= expected and still >= PLATEAU):
            return echelon.rank
    return echelon.rank
