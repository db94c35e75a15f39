"""The exact rank of several requirements together, modulo primes.

Each is a chain of its own, with its own motion, components and highest order, on parameters
that all of them share. The rank of their stacked conditions modulo a prime is a lower bound
of the true one, as in `balance.space.exact.modular_ranks`.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import islice
from math import comb

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
from balance.space.requirements.components import exact_rows
from balance.space.requirements.region_conditions import CommonData, RegionConditions
from kinematics.errors import InexactClosureError
from kinematics.files.urdf.rational_screws import Geometry, of_lowest_rank

# Orders that must add nothing before the rank counts as final, and the last order computed.
PLATEAU, LAST_ORDER = 3, 33


def has_exact_rank(region: RegionConditions) -> bool:
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
        regions: those that `has_exact_rank` accepts.
        expected: the rank by floating point.

    Returns:
        A lower bound of the rank; that of the geometry that the file means.

    Raises:
        LinkageError: exact arithmetic cannot be done.
    """
    return of_lowest_rank(
        common.linkage, lambda geometry: _rank_of(common, regions, geometry, expected),
        lambda rank: (rank,), lambda rank: rank == expected,
    )  # fmt: skip


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
    common: CommonData, regions: Sequence[RegionConditions], exact: Sequence[ExactChain],
    chains: Sequence[Remainders], expected: int,
) -> int:  # fmt: skip
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
