"""The least root mean square of loads over matter in regions, by one conic program.

With the triangular factor R of all weighted samples (QR, never the Gram matrix, which would
lose half of the digits), the root mean square of the shaking is ``|R [s; 1]|`` at the
coordinates s of the added matter (`balance.masses.partial_balance.motion_loads`). The program

    minimise t    |R [s; 1]| ≤ t,  s in the cones of the regions,  mass(s) ≤ budget,
                  |A_k [s; 1]| ≤ cap_k at every sample

is convex, so its minimum is a global one. A unit vector u and prices λ ≥ 0 of mass, and w_k of
the caps, prove a bound without the solver:

    t ≥ u·r - λ budget - Σ (cap_k |w_k| + w_k·a_k) + budget · min(0, least of M_b)

where r and a_k are the last columns, and ``M_b = Rᵀ u + λ mass - Σ A_kᵀ w_k`` is, for each
link, a quadratic polynomial of the position of a unit of mass. Its least value over the region
is found globally (`balance.masses.counterweights.quadratic_minimum`).

The largest load of all samples has one second-order cone for each sample in place of that of
R, with multipliers u_i whose sizes add up to at most 1; ``u·r`` is then the sum over samples.

Caps hold at all samples, as the largest load does; only those that a design exceeds enter the
program.

Matter of limited density is a mixture of parts of the regions
(`balance.masses.counterweights.volume.cut_regions`), which grow in number: of each solution,
the parts where ``M_b`` is negative. Its bound has ``-Σ_b h_b(-M_b)`` instead of the last term,
with the support functions h_b. Newton's method ends the search where the budget is used up and
there are no caps (`balance.masses.partial_balance.fill_budget`). Given matter that may be moved
is one more generator of a cone; see `balance.masses.counterweights.moved_matter`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import (
    MomentCone,
    homogeneous,
    lump_cone,
    mixture_cone,
    moment_cone,
)
from balance.masses.counterweights.counterweight import Counterweight
from balance.masses.counterweights.cylinder_points import first_points
from balance.masses.counterweights.moved_matter import PRICE_OF_MOVING, shifted
from balance.masses.counterweights.quadratic_minimum import minimise_in_region
from balance.masses.counterweights.volume.cut_regions import (
    fill,
    support_function,
    whole_and_halves,
)
from balance.masses.partial_balance.fill_budget import fill_budget, fill_without_load
from balance.masses.partial_balance.shaking_program import ShakingProgram
from balance.support.clarabel_adapter import (
    TRIANGLES,
    ConstraintBlock,
    block_diagonal,
    solve_conic,
    triangles,
)
from balance.support.tolerances import (
    CAP_EXCEEDED,
    FIXED_RANK_RELATIVE,
    LEAST_SHAKING_GAP,
    LEAST_SHAKING_GAP_FILLED,
    PRICE_ZERO,
    SHAKING_GAP_PROVED,
    SOLVER_RESIDUAL,
)
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array

# Most solutions of one question: each adds samples at which a cap is exceeded, or points; and
# those for matter of limited density, whose programs are smaller.
MAX_ROUNDS, MAX_PART_ROUNDS = 60, 150
# Samples of one cap that enter the program at once.
SAMPLES_AT_ONCE = 8
# Gap, and least price of the budget, over the load of the file, from which on Newton's method
# finds the least load of matter of limited density.
NEWTON_STARTS = 1e-2
# The multiplier of t is 1 at a minimum, and 0 in a certificate that there is none.
MULTIPLIER_HALF = 0.5

NO_FORMS = freeze(np.empty((0, 4, 4)))


class LeastShaking(NamedTuple):
    """A minimiser.

    Attributes:
        s: coordinates of the added matter (count,).
        value: ``|R [s; 1]|``.
        bound: no matter within the budget has less; proved without the solver.
        rounds: number of conic programs solved.
        shares: share of the given mass that is taken from each link (links,).
        forms: for matter of limited density, matrices (links, 4, 4) in unit coordinates that
            are positive about where it is; empty otherwise.
        weights: counterweights of a shape; empty for matter of any shape.
        any_shape: value of the minimiser of any shape; None if that is it.
    """

    s: Array
    value: float
    bound: float
    rounds: int
    shares: Array
    forms: Array = NO_FORMS
    weights: tuple[Counterweight, ...] = ()
    any_shape: float | None = None


class CapsConflict(NamedTuple):
    """No matter was found that keeps all caps.

    Attributes:
        proved: whether multipliers prove without the solver that there is none.
        names: joints whose caps are part of the proof.
    """

    proved: bool
    names: tuple[str, ...]


def least_shaking(program: ShakingProgram, budget: float) -> LeastShaking | CapsConflict:
    """Minimise the load over matter within a budget; among minimisers, the lightest.

    Args:
        program: the regions, the factor and the caps.
        budget: most mass to add, kilograms; above 0, unless some may be moved.

    Returns:
        The minimiser, and a bound that is proved without the solver; or a proof that no matter
        within the budget keeps the caps.
    """
    work = _Work(program, budget)
    minimiser = work.solve_by_newton()
    if minimiser is None:
        minimiser = work.solve(None)
    if minimiser is None:
        return work.conflict()
    bound, forms, shares = work.bound(), work.forms, work.shares
    # Where nothing is left to shake, the price of mass is round-off.
    least = program.value(minimiser)
    nothing_left = least <= SHAKING_GAP_PROVED * work.scale
    if nothing_left or work.price * work.room <= PRICE_ZERO * work.scale:
        lighter = work.minimise_mass(least)
        if lighter is not None:
            minimiser, forms, shares = lighter, work.forms, work.shares
            if nothing_left:
                minimiser, forms = work.polish(lighter)
    # The solver keeps the budget to its accuracy only; less of the same matter is in the cones.
    shares = program.taken.rounded(shares)
    removed = removed_by(program, shares)
    placed, most = minimiser + removed, budget + float(shares @ program.taken.masses)
    mass = float(program.matter.masses @ placed)
    minimiser = (placed * min(1.0, most / mass) if mass > 0.0 else placed) - removed
    value = program.value(minimiser)
    return LeastShaking(minimiser, value, max(0.0, bound), work.rounds, shares, forms)


def removed_by(program: ShakingProgram, shares: Array) -> Array:
    """Compute the coordinates (count,) of what shares (links,) take from the given masses."""
    return triangles(shares[:, None, None] * program.taken.matter).reshape(-1)


class _LoadRows(NamedTuple):
    """Rows of the loads in the variables of the cones, relative to ``scale``.

    Attributes:
        rows: rows (n, variables).
        constants: their constants (n,).
        parts: their cones.
        heads: rows to which the bound of a load is added.
        back: matrix (loads, n) from multipliers of the rows to those of the loads.
    """

    rows: Array
    constants: Array
    parts: list[ConstraintBlock]
    heads: Array
    back: Array


class _Work:
    """Conic programs of one question, which grow by samples of caps and by points.

    Loads are relative to ``scale``, masses of variables to ``unit``; ``room`` is the most mass
    that may be placed.
    """

    def __init__(self, program: ShakingProgram, budget: float) -> None:
        """Start with no samples of caps, and with few points in cylinders."""
        matter, self.program, self.budget = program.matter, program, budget
        self.taken, self.room = program.taken, budget + program.taken.heaviest
        self.shares = np.zeros(len(matter.regions))
        self.regions = list(matter.regions.values())
        self.points = {
            k: first_points()
            for k, region in enumerate(self.regions)
            if region.kind == "cylinder"
        }
        self.parts = [whole_and_halves(stock) for stock in program.stocks]
        self.forms = NO_FORMS
        self.active: list[list[int]] = [[] for _ in program.caps]
        self.samples = program.largest_samples(np.zeros(matter.count), SAMPLES_AT_ONCE)
        self.blocks = program.blocks(self.samples)
        self.scale = program.scale
        self.unit = min(self.room, float(matter.given[:, 0].sum()) or self.room)
        self.rounds, self.price, self.gap = 0, 0.0, LEAST_SHAKING_GAP_FILLED
        # The multipliers: of the load, and of the samples of each cap.
        self.u, self.w = np.empty(0), [np.empty((0, 0)) for _ in program.caps]

    def solve(self, limit: float | None) -> Array | None:
        """Minimise the load; or, with a limit on it, the mass.

        Returns:
            Coordinates s (count,); None if there are none, or the solver fails.
        """
        for _ in range(MAX_PART_ROUNDS if self.parts else MAX_ROUNDS):
            self.rounds += 1
            s = self._solve_once(limit)
            if s is None:
                return None
            # Points first: the multipliers belong to the samples of the last program.
            if self.parts:
                grown = self._add_parts(s, limit is not None)
            else:
                grown = limit is None and self._add_points()
            grown |= self._add_samples(s)
            if not grown:
                return s
        return s if self.parts else None

    @property
    def _is_plain_filling(self) -> bool:
        """Whether matter of limited density is all that there is: no caps, peaks or moves."""
        others = self.program.caps or self.program.samples.size or self.taken.links
        return bool(self.parts) and not others

    def solve_by_newton(self) -> Array | None:
        """Minimise the load over matter of limited density that uses the budget up.

        Returns:
            Coordinates s (count,); None for other programs, and where the budget has no price.
        """
        if not self._is_plain_filling:
            return None
        program, self.gap = self.program, NEWTON_STARTS
        s = self.solve(None)
        self.gap = LEAST_SHAKING_GAP_FILLED
        if s is None or self.price * self.room <= NEWTON_STARTS * self.scale:
            return None
        filled = fill_budget(program, self.budget, program.load(s), self.price)
        if filled is None:
            return None
        value = program.value(filled.s)
        self.u = program.load(filled.s) / value
        self.price, self.forms = filled.price, filled.forms
        # Less than what its multipliers prove is an error of integrals over rays.
        return filled.s if value >= self.bound() - LEAST_SHAKING_GAP * self.scale else None

    def minimise_mass(self, least: float) -> Array | None:
        """Minimise the mass at the least load; a solver that has too little room gets more."""
        slack, none = 0.5 * SHAKING_GAP_PROVED * self.scale, np.zeros(self.program.matter.count)
        if self.program.value(none) <= least + slack and not self.program.exceeded_caps(none):
            self.forms, self.shares = NO_FORMS, 0.0 * self.shares
            return none
        for limit in (least, least + 0.5 * slack):
            s = self.solve(limit)
            if s is not None and (self.parts or self.program.value(s) <= least + slack):
                return s
        return None

    def polish(self, s: Array) -> tuple[Array, Array]:
        """Find the lightest matter that leaves nothing to shake, from matter nearly as light.

        Returns:
            Coordinates s (count,), and forms; those given where Newton's method does not serve.
        """
        filled, mass = None, float(self.program.matter.masses @ s)
        if self._is_plain_filling and mass > 0.0:
            filled = fill_without_load(self.program, mass, self.u, self.price)
        return filled or (s, self.forms)

    def bound(self) -> float:
        """Compute the bound that the multipliers prove; see the head of this module."""
        fixed = self.u @ np.concatenate(self.blocks)[:, -1] - self.price * self.budget
        for cap, chosen, w in zip(self.program.caps, self.active, self.w, strict=True):
            last = cap.columns[chosen, :, -1]
            fixed -= cap.most * np.linalg.norm(w, axis=1).sum() + float(np.sum(w * last))
        if self.parts:
            forms = -self._polynomials()
            shifts = self.taken.shifts(self.program.stocks, forms)
            fixed -= self.taken.gains(forms, shifts).sum()
            pairs = zip(self.program.stocks, shifted(forms, shifts), strict=True)
            return float(fixed) - sum(
                sum(support_function(s.with_rays_inside(Q), Q)) for s, Q in pairs
            )
        least = np.array([value for value, _ in self._polynomial_minima()])
        fixed -= self.taken.gains(-self._polynomials(), least).sum()
        return float(fixed + self.budget * min(0.0, float(least.min())))

    def conflict(self) -> CapsConflict:
        """Return the proof that no matter keeps the caps, if the multipliers are one."""
        sizes = [
            cap.most * float(np.linalg.norm(w, axis=1).sum())
            for cap, w in zip(self.program.caps, self.w, strict=True)
        ]
        whole = sum(sizes)
        names = tuple(
            cap.name
            for cap, size in zip(self.program.caps, sizes, strict=True)
            if size > LEAST_SHAKING_GAP * whole
        )
        return CapsConflict(
            not self.u.any() and self.bound() > LEAST_SHAKING_GAP * whole, names
        )

    def _polynomials(self) -> Array:
        """Compute each link's polynomial M_b (links, 4, 4)."""
        matter = self.program.matter
        loads = self.u @ np.concatenate(self.blocks)[:, :-1]
        coefficients = loads + self.price * matter.masses
        for cap, chosen, w in zip(self.program.caps, self.active, self.w, strict=True):
            coefficients = coefficients - np.einsum("nk,nki->i", w, cap.columns[chosen, :, :-1])
        return np.asarray((matter.parts(coefficients) @ TRIANGLES[4].T).reshape(-1, 4, 4))

    def _polynomial_minima(self) -> list[tuple[float, Array]]:
        """Compute the least value of each link's polynomial M_b, and where it is."""
        return [
            minimise_in_region(region, form)
            for region, form in zip(self.regions, self._polynomials(), strict=True)
        ]

    def _add_parts(self, s: Array, lighter: bool) -> bool:
        """Add the parts of regions where matter helps; whether they help by more than a gap.

        Args:
            s: the last solution.
            lighter: whether the mass is minimised, and not the load.
        """
        forms = -self._polynomials()
        price = PRICE_OF_MOVING / self.unit if lighter else 0.0
        shifts = self.taken.shifts(self.program.stocks, forms, price)
        self.forms = shifted(forms, shifts)
        size = float(self.program.matter.masses @ s) if lighter else self.scale
        gap = LEAST_SHAKING_GAP_FILLED / self.unit if lighter else self.gap
        gain = float(self.taken.gains(forms, shifts, price).sum())
        gain += price * float(self.shares @ self.taken.masses)
        gain -= float(triangles(forms).reshape(-1) @ s)
        for stock, form, parts in zip(self.program.stocks, self.forms, self.parts, strict=True):
            part = fill(stock.with_rays_inside(form), form)
            gain += float(np.sum(form * part))
            parts.append(part)
        return gain > gap * size

    def _add_points(self) -> bool:
        """Add points of cylinders where mass lowers the load; whether there are any."""
        grown = False
        forms = self._polynomials()
        for k, (value, at) in enumerate(self._polynomial_minima()):
            if k in self.points and self.taken.most[k]:
                # Matter that is moved goes to the best of the points.
                p = homogeneous(self.points[k])
                known = np.einsum("ni,ij,nj->n", p, forms[k], p)
                value -= max(0.0, float(known.min()))
            if k in self.points and value * self.room < -LEAST_SHAKING_GAP * self.scale:
                self.points[k] = np.vstack([self.points[k], at])
                grown = True
        return grown

    def _add_samples(self, s: Array) -> bool:
        """Add samples at which caps or the largest load are exceeded most; whether any are."""
        load = max(float(np.linalg.norm(A @ np.append(s, 1.0))) for A in self.blocks)
        most = load * (1.0 + CAP_EXCEEDED) + SOLVER_RESIDUAL * self.scale
        grown = self.program.value(s) > most
        if grown:
            largest = self.program.largest_samples(s, SAMPLES_AT_ONCE)
            self.samples += [k for k in largest if k not in self.samples]
        for cap, chosen in zip(self.program.caps, self.active, strict=True):
            sizes = cap.sizes(s)
            sizes[chosen] = 0.0
            worst = np.argsort(-sizes)[:SAMPLES_AT_ONCE]
            new = worst[sizes[worst] > cap.most * (1.0 + CAP_EXCEEDED)]
            chosen.extend(new.tolist())
            grown |= bool(new.size)
        return grown

    def _solve_once(self, limit: float | None) -> Array | None:
        """Solve one conic program in the variables of the cones, and t."""
        taken = self.taken.over(self.unit)
        cones = [taken.cone(k, self._cone(k)) for k in range(len(self.regions))]
        # Coordinates s as a function of the variables.
        T = self.unit * block_diagonal([triangles(cone.matrices).T for cone in cones])
        cone_rows = block_diagonal([cone.rows for cone in cones])
        self.blocks = self.program.blocks(self.samples)
        none_left = limit is not None and limit <= SHAKING_GAP_PROVED * self.scale
        loads = self._none_left(T) if none_left else self._bounded_loads(T)
        rows, offset, parts = self._limit_rows(T, loads)
        rows = np.vstack([cone_rows, rows])
        offset = np.concatenate([*(cone.constants for cone in cones), offset])
        parts = [*(part for cone in cones for part in cone.parts), *parts]
        last = np.cumsum([len(cone.matrices) for cone in cones])[taken.links] - 1
        size, at = T.shape[1], len(cone_rows) + 1 + loads.heads
        if limit is None:
            q, t = np.append(np.zeros(size), 1.0), np.zeros((len(rows), 1))
            t[at] = 1.0
            rows = np.hstack([rows, t])
        else:
            q = self.program.matter.masses @ T / self.unit
            q[last] += PRICE_OF_MOVING * taken.masses[taken.links]
            offset[at] = loosened_limit(limit / self.scale)
        solution = solve_conic(q, rows, offset, parts)
        if limit is None or self.parts:
            dual = solution.dual[len(cone_rows) :]
            self._read_multipliers(loads, dual, limit is not None)
        if solution.infeasible or not np.isfinite(solution.x).all():
            return None
        self.shares[taken.links] = solution.x[last]
        return np.asarray(T @ solution.x[:size])

    def _cone(self, k: int) -> MomentCone:
        """Describe the matter of a link."""
        if self.parts:
            return mixture_cone(np.array(self.parts[k]) / self.unit, self.room / self.unit)
        if k in self.points:
            return lump_cone(self.points[k])
        return moment_cone(self.regions[k])

    def _bounded_loads(self, T: Array) -> _LoadRows:
        """Build rows of loads whose size has a bound, which is added to the first of each."""
        pairs = [bounded_rows(A / self.scale, 0.0, T) for A in self.blocks]
        rows, constants = (np.concatenate(part) for part in zip(*pairs, strict=True))
        heights = [len(A) + 1 for A in self.blocks]
        heads = np.cumsum([0, *heights[:-1]])
        parts = [ConstraintBlock("second_order", height) for height in heights]
        back = np.delete(np.eye(len(rows)), heads, axis=0)
        return _LoadRows(rows, constants, parts, heads, back)

    def _none_left(self, T: Array) -> _LoadRows:
        """Build equations of no load, of full rank: cones of no size have no interior."""
        A = np.concatenate(self.blocks) / self.scale
        U, values, V = np.linalg.svd(A[:, :-1] @ T, full_matrices=False)
        kept = values > FIXED_RANK_RELATIVE * values[0]
        rows, back = values[kept, None] * V[kept], U[:, kept]
        parts = [ConstraintBlock("zero", len(rows))]
        return _LoadRows(rows, back.T @ A[:, -1], parts, np.empty(0, dtype=int), back)

    def _limit_rows(
        self, T: Array, loads: _LoadRows
    ) -> tuple[Array, Array, list[ConstraintBlock]]:
        """Build rows and constants of the budget, the loads and the caps, and their cones."""
        mass = self.program.matter.masses @ T
        blocks = [(-mass[None] / self.room, np.array([self.budget / self.room]))]
        blocks.append((loads.rows, loads.constants))
        parts = [ConstraintBlock("nonnegative", 1), *loads.parts]
        for cap, chosen in zip(self.program.caps, self.active, strict=True):
            for columns in cap.columns[chosen] / cap.most:
                blocks.append(bounded_rows(columns, 1.0, T))
                parts.append(ConstraintBlock("second_order", len(columns) + 1))
        rows, offset = (np.concatenate(part) for part in zip(*blocks, strict=True))
        return rows, offset, parts

    def _read_multipliers(self, loads: _LoadRows, dual: Array, lighter: bool) -> None:
        """Keep the multipliers of budget, load and caps.

        They are in SI units where the load is minimised; where the mass is, that has the price
        of one over its unit.
        """
        scale = 1.0 if lighter else self.scale
        self.price = max(0.0, float(dual[0])) * scale / self.room
        at = 1 + len(loads.rows)
        u = -loads.back @ dual[1:at]
        # The multiplier of t is 1; in a certificate that there is nothing, it is 0.
        of_t = float(dual[1 + loads.heads].sum())
        self.u = np.zeros(len(u))
        if lighter:
            self.price, self.u = self.price + 1.0 / self.unit, u / self.scale
        elif of_t > MULTIPLIER_HALF:
            pieces = np.split(u, np.cumsum([len(A) for A in self.blocks])[:-1])
            self.u = u / max(1.0, sum(float(np.linalg.norm(piece)) for piece in pieces))
        for k, (cap, chosen) in enumerate(zip(self.program.caps, self.active, strict=True)):
            width = cap.columns.shape[1] + 1
            multipliers = dual[at : at + width * len(chosen)].reshape(len(chosen), width)
            self.w[k] = multipliers[:, 1:] * scale / cap.most
            at += multipliers.size


def bounded_rows(columns: Array, most: float, T: Array) -> tuple[Array, Array]:
    """Build rows and constants of ``|columns [s; 1]| ≤ most`` with ``s = T v``."""
    rows = np.vstack([np.zeros(T.shape[1]), columns[:, :-1] @ T])
    return rows, np.append(most, columns[:, -1])


def loosened_limit(limit: float) -> float:
    """Loosen a limit on a relative load by what the solver leaves open."""
    return limit * (1.0 + LEAST_SHAKING_GAP) + 2.0 * SOLVER_RESIDUAL
