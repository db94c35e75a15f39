"""Exact ranks without a tolerance: the conditions of balance over prime fields.

The joint screws come as rational numbers from the decimals of the file. The conditions of
each order are rational functions of them, so that they can be computed modulo a prime: a
rank modulo a prime is a lower bound of the true one, whatever the prime, and falls short of
it only where the prime divides a minor, at which another prime would differ. Axes are not
normalised, so a relation between inputs is rescaled by the lengths of their axes; where these
have no rational ratio, modulo primes in which their square roots exist.

The loops must close at every order. They do if their screws span all relative motions of the
links on them (implicit function theorem). An overconstrained linkage is tested order by order,
and one in rounded decimals is refused, not treated as rigid.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from math import inf
from typing import NamedTuple

from balance.space.exact.chain import ExactChain, loops_are_regular
from balance.space.exact.conditions import ExactConditions
from balance.space.exact.modular_series import chain_modulo, first_order_mobility, primes_of
from kinematics.errors import ExactError, InexactClosureError
from kinematics.model.linkage import Notice
from kinematics.wording import count_noun, repr_lines

# Fewest orders that must add nothing before the rank counts as final.
MIN_PLATEAU = 3
# The same, at least, where the rank stays below the bound that inertia transfers give.
PLATEAU_WITHOUT_BOUND = 12
# Orders at which the search may stop, for one degree of freedom.
STOPPING_ORDERS = (6, 14, 30, 62, 126)
# The same for more degrees of freedom.
STOPPING_ORDERS_OF_MANY = (5, 9, 17, 33)


class Pivot(NamedTuple):
    """A condition that the ones before it do not imply.

    Attributes:
        order: order of the derivative.
        ray: index of the ray along which it is taken.
        column: column of the motion, w.
        row: which of ``ExactChain.rows``.
        body: index of the body of the pivot's parameter.
        parameter: which of ``ExactChain.parameters`` of that body.
    """

    order: int
    ray: int
    column: int
    row: int
    body: int
    parameter: int


class Witness(NamedTuple):
    """Proof of a lower bound of a rank: a minor that does not vanish modulo a prime.

    Attributes:
        prime: the prime.
        rays: directions in the columns of the chain.
        pivots: rows and columns of the minor.
    """

    prime: int
    rays: tuple[tuple[int, ...], ...]
    pivots: tuple[Pivot, ...]

    def __repr__(self) -> str:
        """One line: `Proof.to_dict` has all of it."""
        return f"Witness: {count_noun(len(self.pivots), 'pivot')} modulo {self.prime}"


class ExactRanks(NamedTuple):
    """Ranks by exact arithmetic.

    Attributes:
        ranks: rank of the conditions up to order 0, 1, 2 …; without a highest order
            requested, three orders that add nothing are the last.
        parameters: number of inertial parameters.
        primes: the primes used.
        agreed: whether all of them give the same ranks; the larger ones are returned.
        settled: whether the last orders add nothing, and the rank expected was reached.
        regular: whether the loops close at all orders by the rank of their screws, and not
            only at those computed.
        notices: numbers that were replaced by rational ones.
        chain: the linkage in rational numbers.
        witness: proof that the rank is not less.
    """

    ranks: tuple[int, ...]
    parameters: int
    primes: tuple[int, ...]
    agreed: bool
    settled: bool
    regular: bool
    notices: tuple[Notice, ...]
    chain: ExactChain
    witness: Witness

    def __repr__(self) -> str:
        """Two lines: ranks by order, and how they were found."""
        ranks = " ".join(map(str, self.ranks))
        primes = "both primes agree" if self.agreed else "primes disagree"
        state = "settled" if self.settled else "not settled"
        head = (
            f"ExactRanks: rank {self.rank} of {self.parameters} parameters, {state}, {primes}"
        )
        return repr_lines(head, f"by order {ranks}")

    @property
    def rank(self) -> int:
        """Number of independent conditions."""
        return self.ranks[-1]

    @property
    def nullity(self) -> int:
        """Dimension of the design space, if the orders computed are all that matter."""
        return self.parameters - self.rank

    @property
    def kmax(self) -> int:
        """The last order that adds a condition."""
        return self.ranks.index(self.rank)

    def to_dict(self) -> dict[str, object]:
        """Convert to the entry ``exact`` of the report."""
        return {
            "orders": [
                {"order": k, "rank": rank, "nullity": self.parameters - rank}
                for k, rank in enumerate(self.ranks)
            ],
            "primes": list(self.primes),
            "agreed": self.agreed,
            "settled": self.settled,
            "regular": self.regular,
            "replaced": [notice.message for notice in self.notices],
        }


def ranks_of(
    source: str,
    chain: ExactChain,
    notices: tuple[Notice, ...],
    max_order: int | None = None,
    expected: int = 0,
    upper_bound: int | None = None,
    least: int = 0,
) -> ExactRanks:
    """Compute the rank of the conditions on a chain by order, without a tolerance.

    Args:
        source: file of the linkage, for messages.
        chain: the linkage in rational numbers.
        notices: numbers of the file that were replaced.
        max_order: compute exactly the orders 0 … max_order, instead of as many as needed.
        expected: a rank that is known or believed to be reached.
        upper_bound: a rank that is known not to be exceeded: the order that reaches it is
            the last one.
        least: the lowest order at which the rank may count as final, but for that bound.

    Raises:
        ExactError: the loops do not close exactly, or the inputs do not determine the other
            joints.
    """
    runs, closes = _start_runs(source, chain, upper_bound), loops_are_regular(chain)
    stops = STOPPING_ORDERS if chain.width == 1 else STOPPING_ORDERS_OF_MANY
    for order in range((stops[-1] if max_order is None else max_order) + 1):
        best = _extend_runs(source, chain, runs)
        kmax = best.index(best[-1])
        # If the rank of the screws shows that loops close, no further order is needed.
        complete = best[-1] == upper_bound and (closes or order >= stops[0])
        if max_order is None and not complete and order not in stops:
            continue
        plateau = _required_plateau(kmax, best[-1] >= expected, upper_bound is not None)
        settled = complete or max(kmax + plateau, least) <= order
        if settled and max_order is None:
            best = best[: kmax + 1 + (0 if complete else MIN_PLATEAU)]
            break
    better = max(runs, key=lambda run: run.ranks[-1])
    return ExactRanks(
        ranks=best,
        parameters=len(chain.links) * len(chain.parameters),
        primes=(runs[0].prime, runs[1].prime),
        agreed=runs[0].ranks == runs[1].ranks,
        settled=settled,
        regular=closes,
        notices=notices,
        chain=chain,
        witness=_witness(chain, better),
    )


def _required_plateau(kmax: int, reached: bool, careful: bool) -> int | float:
    """Compute how many orders must add nothing before the rank counts as final.

    This is no proof. A body that is driven through dead centres moves with a power m of the
    input: conditions on it come at the orders ``m - 1``, ``2 m - 1``, …, those on its drive
    long before. In all linkages tried, a false plateau is no longer than that.

    Args:
        kmax: the last order that added a condition.
        reached: whether the rank expected is reached.
        careful: whether a plateau must be longer than the orders before it, since floating
            point misses small conditions of high order. Only then may the search end below
            the rank expected.
    """
    if not careful:
        return MIN_PLATEAU if reached else inf
    return max(PLATEAU_WITHOUT_BOUND, kmax + 1 if reached else 2 * kmax)


def _start_runs(
    source: str, chain: ExactChain, upper_bound: int | None
) -> list[ExactConditions]:
    """Prepare the conditions modulo the first two usable primes."""
    chains = filter(None, (chain_modulo(chain, prime) for prime in primes_of(chain)))
    runs = [ExactConditions(remainders, upper_bound) for remainders in islice(chains, 2)]
    if len(runs) < 2:
        raise ExactError(
            f"{source}: its inputs do not determine the other joints, to first "
            "order and exactly; choose other inputs"
        )
    return runs


def _extend_runs(
    source: str, chain: ExactChain, runs: Sequence[ExactConditions]
) -> tuple[int, ...]:
    """Compute the next order modulo each prime; the ranks by order, the larger ones."""
    first, *others = runs
    first.extend()
    for run in others:
        run.extend(first.pivots)
    ranks = tuple(map(max, *(run.ranks for run in runs)))
    closed = min(run.closed for run in runs)
    if closed < len(ranks):
        raise InexactClosureError(source, closed, first_order_mobility(chain))
    return ranks


def _witness(chain: ExactChain, run: ExactConditions) -> Witness:
    """Describe the minor that a run found, its rows and columns by name, not by position."""
    rows, size = len(chain.rows), len(chain.parameters)
    pivots = (
        Pivot(order, ray, row // rows, row % rows, column // size, column % size)
        for order, ray, row, column in run.pivots
    )
    rays = tuple(tuple(ray.tolist()) for ray in run.rays)
    return Witness(run.prime, rays, tuple(pivots))
