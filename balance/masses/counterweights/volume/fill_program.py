"""The least matter of limited density that balances: Newton's method, or cutting planes first.

With the moments ``ΔP_b`` of the matter on link b in the convex set of
`balance.masses.counterweights.volume.cut_regions`, whose support function is h_b,

    minimise Σ_b <C_b, ΔP_b>    so that    Σ_b A_b ΔP_b = r

has the dual

    maximise y·r - Σ_b h_b(y·A_b - C_b).

From the multipliers of point masses Newton's method (`dual_ascent`) ends where the parts
balance or, where no matter of the density does, at a dual larger than any objective.

Otherwise mixtures of parts of the regions, of which each master program takes the best, are
feasible from inside; its multipliers y name the next part, ``{y·A_b > C_b}``, and prove a bound
from outside. Where both nearly meet, Newton's method takes over, at whose end the parts
balance. Every y proves a lower bound, whatever led to it.

The least factor t of the density for which matter balances at all is likewise

    t = max_y  y·r / Σ_b h_b(y·A_b),

so that any y for which the quotient is above 1 proves that none does.

The largest moment of inertia as the objective has matrices ``W_b ⪰ 0`` beside y, with
``Σ_b tr W_b = 1``: C_b then includes what W_b makes of the moments of inertia, and the dual has
the constant ``Σ_b <W_b, I_b>`` of the given masses. The masters find W_b, and Newton's method
keeps them. Likewise they find which shares of the given masses are moved
(`balance.masses.counterweights.moved_matter`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_program import (
    AddedProgram,
    added_objective,
    after_taking,
)
from balance.masses.counterweights.moved_matter import shifted
from balance.masses.counterweights.volume.cut_regions import (
    COARSE,
    Stock,
    support_function,
)
from balance.masses.counterweights.volume.dual_ascent import (
    conditions_of,
    fill_all,
    fill_by_newton,
    forms_of,
    maximise_dual,
)
from balance.masses.counterweights.volume.equal_moments import equalise_moments
from balance.masses.counterweights.volume.settled_shares import NO_LINKS, settled, with_shares
from balance.support.clarabel_adapter import (
    ConstraintBlock,
    solve_conic,
    triangles,
)
from balance.support.tolerances import (
    COUNTERWEIGHT_RESIDUAL,
    DENSITY_GAP,
    DENSITY_GAP_FORCE,
    FILL_GAPS,
    FILLING_GAP_PROVED,
    MASS_GAP,
)
from kinematics.numerics.array_types import Array

# Most master programs of one question.
MOST_ROUNDS = 120
# Share of the best multipliers in those that name the next parts: masters alone swing.
INERTIA = 0.7
# Parts from which a master forgets those that its mixture has none of, and the share of none.
MOST_IDLE, SHARE_ZERO = 30, 1e-6
# Factor of the density up to which matter is clearly enough, and that from which it is clearly
# too little: integrals have errors below.
CLEARLY_ENOUGH, CLEARLY_TOO_LITTLE = 0.95, 1.05


class DensityNeeded(NamedTuple):
    """The least factor of the density for which matter in the regions balances.

    Attributes:
        factor: a factor for which matter was found.
        bound: no smaller factor does; proved by the functional. 0 if matter of clearly less
            than the density does: how little is not asked then.
        dual: y (ρ,).
        parts: moments of the parts that the answer came from, each (links, 4, 4).
    """

    factor: float
    bound: float
    dual: Array
    parts: list[Array]


class FilledParts(NamedTuple):
    """The parts of the regions that are filled.

    Attributes:
        forms: matrices (links, 4, 4) in unit coordinates; matter is where they are positive.
        moments: moments of the parts (links, 4, 4), in units of mass.
        shares: share of the given mass that is taken from each link (links,).
        bound: no matter of this density has a smaller objective, in units of the objective.
        dual: y (ρ,).
    """

    forms: Array
    moments: Array
    shares: Array
    bound: float
    dual: Array


def density_needed(
    program: AddedProgram, stocks: Sequence[Stock], how_much: bool = True
) -> DensityNeeded:
    """Compute the least factor of the density for which matter in the regions balances.

    The factor is infinite if matter of any density was not found to.

    Args:
        program: the conditions.
        stocks: region and density of each link.
        how_much: whether the factor is asked for where it is clearly above 1; else the search
            ends with a bound that is.
    """
    columns = _Columns(program, stocks, np.zeros_like(program.cost), None)
    hopeless = np.inf if how_much else CLEARLY_TOO_LITTLE
    value, dual = columns.generate(density_gap(program), CLEARLY_ENOUGH, hopeless)
    if value <= CLEARLY_ENOUGH:
        return DensityNeeded(value, 0.0, dual[: program.target.size], columns.parts)
    forms = columns.forms(dual)
    seen = shifted(forms, columns.shifts(forms, value))
    dual = dual[: program.target.size]
    against = float(dual @ program.target) - columns.gains(forms, seen)
    bound = _density_bound(program, stocks, seen, against)
    return DensityNeeded(value, bound, dual, columns.parts)


def density_gap(program: AddedProgram) -> float:
    """Return the relative gap of the density needed: integrals are exact for forces."""
    return DENSITY_GAP_FORCE if program.space.balance == "force" else DENSITY_GAP


def least_mass(
    program: AddedProgram, stocks: Sequence[Stock], needed: DensityNeeded, factor: float = 1.0
) -> float:
    """Compute about the least mass that balances, in units of mass.

    Args:
        program: the program of the least mass.
        stocks: region and density of each link.
        needed: the density that it needs.
        factor: factor of the density of all stocks, one that is enough.
    """
    denser = [stock._replace(density=factor * stock.density) for stock in stocks]
    columns = _Columns(program, denser, program.cost, [factor * part for part in needed.parts])
    value = columns.generate(max(MASS_GAP, density_gap(program)))[0]
    return value - program.price_of_moving * float(columns.shares @ program.taken.masses)


def fill_least(
    program: AddedProgram,
    stocks: Sequence[Stock],
    needed: DensityNeeded,
    prove: bool = True,
) -> FilledParts:
    """Compute the parts of regions whose matter balances with the least objective.

    Args:
        program: a program that matter of this density fulfils.
        stocks: region and density of each link.
        needed: the density that it needs.
        prove: whether the bound is one by sums over many rays; else by those of the parts.
    """
    columns = _Columns(program, stocks, program.cost, needed.parts)
    rank = program.target.size
    # Masters alone find the matrices of moments of inertia.
    for gap in FILL_GAPS[1:] if columns.heavy else FILL_GAPS:
        dual = columns.generate(gap)[1]
        prices = columns.prices(dual)
        forms = columns.forms(dual)
        fixed = settled(
            program,
            prices,
            dual[:rank],
            columns.shares,
            columns.placed,
            columns.shifts(forms),
            gap == FILL_GAPS[-1],
        )
        eta, seen = maximise_dual(fixed.program, stocks, fixed.prices, fixed.start)
        forms = forms_of(fixed.program, eta, fixed.prices)
        moments = fill_all(program, seen, forms)
        multipliers, matrices = fixed.multipliers(eta)[:rank], dual[rank:]
        if columns.heavy and not program.taken.links:
            equal = equalise_moments(program, stocks, dual)
            if equal is not None:
                multipliers, matrices = np.split(equal.dual, [rank])
                seen, forms, moments = equal.stocks, equal.forms, equal.moments
        shares = fixed.shares_of(program, moments)
        residual = after_taking(program, shares, NO_LINKS, shares).target
        residual = residual - conditions_of(program, moments)
        dual = np.append(multipliers, matrices)
        bound = columns.fixed(dual)
        held, bare = forms * moments, columns.forms(dual)
        if program.taken.links:
            # A link from which nothing is taken may have a better shift than none.
            best = shifted(bare, columns.shifts(bare))
            bound -= columns.gains(bare, best)
            held = _support_functions(program, stocks, best)
        elif prove:
            held = _support_functions(program, seen, forms)
        bound -= float(np.sum(held))
        value = added_objective(program, list(moments), shares)[1]
        # Newton's method does not improve which shares are the largest, nor, without equal
        # moments, the matrices of moments of inertia.
        exact = not columns.heavy and not program.taken.links
        close = exact or value - bound <= FILLING_GAP_PROVED * value
        if close and float(np.linalg.norm(residual)) <= COUNTERWEIGHT_RESIDUAL:
            break
        columns.parts.append(moments)
    return FilledParts(forms, moments, shares, bound, dual[:rank])


def fill_from_points(
    program: AddedProgram, stocks: Sequence[Stock], functional: Array, prove: bool = True
) -> FilledParts | DensityNeeded:
    """Find the least matter, as `fill_least` does, from the multipliers of point masses.

    Args:
        program: a program without moments of inertia, and without matter that may be moved.
        stocks: region and density of each link.
        functional: that of the multipliers of point masses (parameters,).
        prove: as for `fill_least`.

    Returns:
        The parts; or, where they do not balance, what bounds the density needed, if anything.
    """
    # No matter costs more than Σ h_b(C_b). A dual above that proves that none of this density
    # balances: h_b(y·A_b) is at most h_b(y·A_b - C_b) + h_b(C_b).
    costs = forms_of(program, np.zeros_like(program.target), -program.cost)
    ceiling = float(np.sum(costs * fill_all(program, stocks, costs, COARSE)))
    start = np.asarray(np.linalg.lstsq(program.lift, functional, rcond=None)[0], np.float64)
    y, seen, forms, moments, balances = fill_by_newton(
        program, stocks, program.cost, start, ceiling
    )
    if not balances:
        bare = forms_of(program, y, np.zeros_like(program.cost))
        bound = _density_bound(program, stocks, bare, float(y @ program.target))
        return DensityNeeded(np.inf, bound, y, [])
    held = _support_functions(program, seen, forms) if prove else forms * moments
    bound = float(y @ program.target) - float(np.sum(held))
    return FilledParts(forms, moments, np.zeros(len(stocks)), bound, y)


class _Columns:
    """Parts of the regions, and the master program that mixes them.

    It seeks the least objective, or the least factor of the density where it starts without
    parts.
    """

    def __init__(
        self,
        program: AddedProgram,
        stocks: Sequence[Stock],
        cost: Array,
        parts: Sequence[Array] | None,
    ) -> None:
        """Start with given parts, or with regions and their halves for each condition alone."""
        self.program, self.stocks, self.cost = program, stocks, cost
        self.scaled, self.parts = parts is None, list(parts or ())
        self.shares, self.placed = np.zeros(len(stocks)), np.zeros(len(stocks))
        if not self.parts:
            whole = np.tile(np.diag([0.0, 0.0, 0.0, 1.0]), (len(stocks), 1, 1))
            self.parts = [self._fill(whole)]
            for y in np.eye(program.target.size):
                self.parts += [self._fill(self.forms(side)) for side in (y, -y)]

    @property
    def heavy(self) -> bool:
        """Whether the largest moment of inertia is part of the objective."""
        return self.program.inertia[0].size > 0 and not self.scaled

    def prices(self, dual: Array) -> Array:
        """Compute the polynomials C_b (links, 10), with those of the moments of inertia."""
        W = dual[self.program.target.size :]
        if not W.size:
            return self.cost
        return self.cost + np.einsum("li,lij->lj", W.reshape(-1, 6), self.program.inertia[0])

    def fixed(self, dual: Array) -> float:
        """Compute the part of the dual that no added matter has."""
        y, W = np.split(dual, [self.program.target.size])
        given = float(W @ self.program.inertia[1].reshape(-1)) if W.size else 0.0
        return float(y @ self.program.target) + given

    def forms(self, dual: Array) -> Array:
        """Compute the forms of multipliers."""
        y = dual[: self.program.target.size]
        return forms_of(self.program, y, self.prices(dual))

    @property
    def price_of_moving(self) -> float:
        """Price of a unit of mass that is moved."""
        return 0.0 if self.scaled else self.program.price_of_moving

    def shifts(self, forms: Array, factor: float = 1.0) -> Array:
        """Compute the shifts (links,) of the least bound for forms, and a factor of density."""
        if not self.program.taken.links:
            return np.zeros(len(forms))
        factor = (factor if np.isfinite(factor) else 1.0) / self.program.unit
        return self.program.taken.shifts(
            self.stocks, forms, self.price_of_moving, factor, COARSE
        )

    def gains(self, forms: Array, seen: Array) -> float:
        """Compute what moving adds to the support functions of shifted forms."""
        shifts = (seen - forms)[:, 3, 3]
        return float(self.program.taken.gains(forms, shifts, self.price_of_moving).sum())

    def generate(
        self, gap: float, enough: float = -np.inf, hopeless: float = np.inf
    ) -> tuple[float, Array]:
        """Add parts until the bounds from inside and outside meet.

        Args:
            gap: relative difference of the bounds.
            enough: a value from inside of which none smaller is sought.
            hopeless: a bound from outside of which none larger is sought.

        Returns:
            The value from inside, and the multipliers of the best bound.
        """
        lower, best = -np.inf, None
        value, y = np.inf, np.zeros_like(self.program.target)
        for _ in range(MOST_ROUNDS):
            value, y, shares = self._master()
            self._forget(shares)
            if value <= enough:
                break
            steady = y if best is None else INERTIA * best + (1.0 - INERTIA) * y
            for z in (steady, y):
                forms = self.forms(z)
                seen = shifted(forms, self.shifts(forms, value if self.scaled else 1.0))
                moments = self._fill(seen)
                size = float(np.sum(seen * moments))
                against = self.fixed(z) - self.gains(forms, seen)
                bound = against / size if self.scaled and size > 0.0 else against - size
                if bound > lower and np.isfinite(value):
                    lower, best = bound, z
                self.parts.append(moments)
            met = np.isfinite(value) and value - lower <= gap * abs(value)
            if met or lower >= hopeless:
                break
        return value, y if best is None else best

    def _fill(self, forms: Array) -> Array:
        """Compute the moments of parts with few rays, each from inside its part."""
        seen = [s.with_rays_inside(form) for s, form in zip(self.stocks, forms, strict=True)]
        return fill_all(self.program, seen, forms, COARSE)

    def _forget(self, shares: Array) -> None:
        """Forget the parts that the best mixture has none of, if there are many."""
        used = shares.max(axis=1) > SHARE_ZERO
        # A solver that failed says nothing.
        if len(self.parts) > MOST_IDLE and used.any():
            self.parts = [part for part, use in zip(self.parts, used, strict=True) if use]

    def _master(self) -> tuple[float, Array, Array]:
        """Mix the parts.

        Returns:
            The value, infinite if no mixture balances; multipliers; and the shares of the
            parts (parts, links).
        """
        program, parts = self.program, np.array(self.parts)
        vectors = triangles(parts)
        count, links = parts.shape[:2]
        A = np.einsum("lrj,plj->rpl", program.rows, vectors).reshape(-1, count * links)
        prices = np.einsum("lj,plj->pl", self.cost, vectors).reshape(-1)
        shares = -np.tile(np.eye(links), count)
        n, rank = count * links, len(A)
        end = rank + n + links
        rows = np.zeros((end, n + (self.scaled or self.heavy)))
        rows[:rank, :n], rows[rank : rank + n, :n], rows[rank + n :, :n] = A, np.eye(n), shares
        offset = np.zeros(end)
        offset[:rank] = -program.target
        q = prices
        blocks = [ConstraintBlock("zero", rank), ConstraintBlock("nonnegative", n + links)]
        if self.scaled:
            rows[rank + n :, n], q = 1.0, np.append(np.zeros(n), 1.0)
        else:
            offset[rank + n :] = 1.0
        if self.heavy:
            q = np.append(prices, 1.0)
            rows = np.vstack([rows, self._inertia_rows(vectors)])
            offset = np.append(offset, -program.inertia[1].reshape(-1))
            blocks += [ConstraintBlock("psd_triangle", 3)] * links
            end += 6 * links
        if program.taken.links:
            q, rows, offset = with_shares(
                program, self.cost, self.price_of_moving, (q, rows, offset), parts[:, :, 3, 3]
            )
            blocks.append(ConstraintBlock("nonnegative", len(rows) - end))
        # Shares of parts far heavier than what balances are tiny: masses have the size of it.
        sizes = np.maximum(np.abs(A).max(axis=0), 1.0)
        q = np.append(q[:n] / sizes, q[n:])
        rows[:, :n] /= sizes
        rows[rank : rank + n, :n] = np.eye(n)
        solution = solve_conic(q, rows, offset, blocks)
        dual = np.append(solution.dual[:rank], solution.dual[rank + n + links : end])
        if solution.infeasible:
            return np.inf, dual, np.ones((count, links))
        taken, mixture = program.taken.links, (solution.x[:n] / sizes).reshape(count, links)
        self.placed = (mixture * parts[:, :, 3, 3]).sum(axis=0)
        self.shares[taken] = solution.x[len(q) - len(taken) :]
        return float(q @ solution.x), dual, mixture

    def _inertia_rows(self, vectors: Array) -> Array:
        """Build the rows of ``t - I_b``: shares of parts (count, links, 10), and t."""
        count, links = vectors.shape[:2]
        per_part = np.einsum("lij,plj->lpi", self.program.inertia[0], vectors)
        rows = np.zeros((links, 6, count, links))
        for k in range(links):
            rows[k, :, :, k] = -per_part[k].T
        largest = np.tile(triangles(np.eye(3)), links)[:, None]
        return np.hstack([rows.reshape(6 * links, count * links), largest])


def _density_bound(
    program: AddedProgram, stocks: Sequence[Stock], forms: Array, against: float
) -> float:
    """Compute a factor of the density below which no matter reaches a value."""
    sums = _support_functions(program, stocks, forms)
    return against / float(np.sum(sums)) if against > 0.0 else 0.0


def _support_functions(program: AddedProgram, stocks: Sequence[Stock], forms: Array) -> Array:
    """Compute the support functions and estimates of their errors (links, 2)."""
    pairs = [
        support_function(stock.with_rays_inside(form), form)
        for stock, form in zip(stocks, forms, strict=True)
    ]
    return np.array(pairs) / program.unit
