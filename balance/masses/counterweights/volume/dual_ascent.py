"""Newton's method for the least matter of limited density: it maximises the dual.

The dual ``y·r - Σ_b h_b(y·A_b - C_b)`` of `fill_program` is smooth and concave: its gradient is
what the parts leave of the conditions, and minus its second derivative H is an integral over
their inner surfaces. A step maximises ``g·s - ½ s·H s`` within a radius, which follows from how
well this predicted the gains of the steps before. Where a part is nearly empty, H is nearly
singular and grows along a step; the mean of H at both ends of a rejected step predicts the
next one better.

Source: trust regions, J. J. Moré, D. C. Sorensen, SIAM J. Sci. Stat. Comput. 4(3), 1983.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from balance.masses.counterweights.volume.cut_regions import (
    COARSE,
    FINE,
    Stock,
    fill,
    second_derivatives,
)
from balance.support.clarabel_adapter import TRIANGLES, triangles
from balance.support.tolerances import (
    COUNTERWEIGHT_RESIDUAL,
    FILL_RESIDUAL,
    FILL_ROUND_OFF,
    FILL_SETTLED,
    FILL_STEP_SOLVED,
    FILL_VALUE_SURE,
)
from kinematics.numerics.array_types import Array

# First radius over the size of y; factors of it after bad and good steps.
RADIUS, SHRINK, GROW = 0.05, 0.4, 2.5
# Part of the predicted gain that a step needs to be taken, below which the radius shrinks, and
# above which it grows.
TAKEN, BAD, GOOD = 1e-2, 0.25, 0.75
# How many of the ten coordinates `triangles` of a form are of second order: the first.
SECOND_ORDER = 6
# Most steps with few and with many rays, and most of Newton's method for the length of one.
MOST_COARSE, MOST_FINE, MOST_LENGTHS = 20, 25, 50


class Conditions(Protocol):
    """Conditions on what fills regions; see `AddedProgram`."""

    @property
    def rows(self) -> Array:
        """Conditions A_b (links, ρ, 10)."""

    @property
    def target(self) -> Array:
        """Their right-hand side r (ρ,)."""

    @property
    def unit(self) -> float:
        """Kilograms per unit of mass."""


def forms_of(program: Conditions, y: Array, cost: Array) -> Array:
    """Compute the forms ``y·A_b - C_b`` (links, 4, 4)."""
    flat = np.einsum("r,lrj->lj", y, program.rows) - cost
    return np.asarray((flat @ TRIANGLES[4].T).reshape(-1, 4, 4))


def fill_all(
    program: Conditions, stocks: Sequence[Stock], forms: Array, rays: int = FINE
) -> Array:
    """Compute the moments (links, 4, 4) of the parts where forms are positive."""
    moments = [fill(stock, form, rays) for stock, form in zip(stocks, forms, strict=True)]
    return np.array(moments) / program.unit


def conditions_of(program: Conditions, moments: Array) -> Array:
    """Compute ``Σ_b A_b ΔP_b`` (ρ,) of moments (links, 4, 4)."""
    return np.asarray(np.einsum("lrj,lj->r", program.rows, triangles(moments)))


def maximise_dual(
    program: Conditions,
    stocks: Sequence[Stock],
    cost: Array,
    start: Array,
    ceiling: float = np.inf,
    quadratic: Array | None = None,
) -> tuple[Array, list[Stock]]:
    """Maximise the dual by Newton's method, with few rays and then with many.

    Few rays start anew inside the parts after each step; many stay, so that the dual is one
    function. Forms without second-order terms cut parts off by planes, which need no rays.

    Args:
        program: the conditions.
        stocks: region and density of each link.
        cost: the polynomials C_b (links, 10).
        start: multipliers (ρ,) to start at.
        ceiling: a value that the dual does not exceed if any matter balances.
        quadratic: factors d (ρ,) of ``-½ Σ d_i y_i²``, a part of the dual; 0 by default.

    Returns:
        The maximiser, and the stocks whose rays start inside the parts that it fills.
    """
    quadratic = np.zeros_like(start) if quadratic is None else quadratic
    ascent = _Ascent(program, stocks, cost, start, ceiling, quadratic)
    if not (program.rows[..., :SECOND_ORDER].any() or cost[..., :SECOND_ORDER].any()):
        ascent.climb(FINE, MOST_COARSE + MOST_FINE)
        return ascent.y, ascent.seen
    ascent.climb(COARSE, MOST_COARSE)
    if ascent.value > ceiling:
        return ascent.y, ascent.seen
    in_space = any(stock.mirror is None for stock in stocks)
    if not ascent.climb(FINE, MOST_FINE) or not in_space:
        # From inside the parts of the end rays see more, and the same whatever led there.
        ascent.climb(FINE, MOST_FINE)
    return ascent.y, ascent.seen


class Filling(NamedTuple):
    """What Newton's method ends at.

    Attributes:
        y: multipliers (ρ,).
        stocks: those whose rays start inside the parts that it fills.
        forms: matrices (links, 4, 4), positive where matter is.
        moments: of the matter (links, 4, 4), in units of mass.
        balances: whether they meet the conditions.
    """

    y: Array
    stocks: list[Stock]
    forms: Array
    moments: Array
    balances: bool


def fill_by_newton(
    program: Conditions,
    stocks: Sequence[Stock],
    cost: Array,
    start: Array,
    ceiling: float = np.inf,
    quadratic: Array | None = None,
) -> Filling:
    """Fill the parts of the maximiser of the dual; see `maximise_dual` for the arguments."""
    y, seen = maximise_dual(program, stocks, cost, start, ceiling, quadratic)
    forms = forms_of(program, y, cost)
    moments = fill_all(program, seen, forms)
    residual = program.target - conditions_of(program, moments)
    if quadratic is not None:
        residual -= quadratic * y
    balances = float(np.linalg.norm(residual)) <= COUNTERWEIGHT_RESIDUAL
    return Filling(y, seen, forms, moments, balances)


class _Step(NamedTuple):
    """A step within the radius.

    Attributes:
        change: s (ρ,).
        predicted: gain of the dual if H was constant.
        bounded: whether the radius bounds it.
    """

    change: Array
    predicted: float
    bounded: bool


class _Ascent:
    """Multipliers on their way to the maximum, and the radius in which H is trusted."""

    def __init__(
        self,
        program: Conditions,
        stocks: Sequence[Stock],
        cost: Array,
        start: Array,
        ceiling: float,
        quadratic: Array,
    ) -> None:
        """Start at multipliers."""
        self.program, self.stocks, self.cost, self._ceiling = program, stocks, cost, ceiling
        self.y, self.seen, self._radius = start, list(stocks), 0.0
        self.value, self._quadratic = -np.inf, quadratic

    def climb(self, rays: int, most: int) -> bool:
        """Take steps until few rays gain no more, or the parts balance; return whether so."""
        self._look_inside()
        # The last steps of a climb are of round-off, and no measure for those of the next.
        self._radius = RADIUS * (float(np.linalg.norm(self.y)) or 1.0)
        self.value, gradient = self._dual(self.y, rays)
        H = self._curvature(self.y, rays)
        settled = FILL_SETTLED if rays == COARSE else 0.0
        for _ in range(most):
            residual = float(np.linalg.norm(gradient))
            step = _best_step(H, gradient, self._radius)
            enough = not step.bounded and step.predicted <= settled * abs(self.value)
            if residual <= FILL_RESIDUAL or enough:
                break
            at = self.y + step.change
            new_value, new_gradient = self._dual(at, rays)
            # Values have round-off; near the maximum what is left of the conditions decides.
            if step.predicted <= FILL_VALUE_SURE * abs(self.value):
                taken = float(np.linalg.norm(new_gradient)) < residual
                share = 1.0 if taken else 0.0
            else:
                share = (new_value - self.value) / step.predicted
                taken = share > TAKEN
            self._adapt(step, share)
            if not taken:
                if residual <= COUNTERWEIGHT_RESIDUAL and share == 0.0:
                    # What is left is round-off.
                    break
                if not step.change.any() or self._radius <= FILL_ROUND_OFF * float(
                    np.linalg.norm(self.y)
                ):
                    break
                H = 0.5 * (H + self._curvature(at, rays))
                continue
            before = self.value
            self.y, self.value, gradient = at, new_value, new_gradient
            if rays == COARSE:
                self._look_inside()
                self.value, gradient = self._dual(at, rays)
                if self.value <= before:
                    # Errors of the integrals are as large as what steps gain.
                    break
            if self.value > self._ceiling:
                break
            H = self._curvature(at, rays)
        return float(np.linalg.norm(gradient)) <= COUNTERWEIGHT_RESIDUAL

    def _adapt(self, step: _Step, share: float) -> None:
        """Adapt the radius to the part of its predicted gain that a step had."""
        length = float(np.linalg.norm(step.change))
        if share < BAD:
            self._radius = SHRINK * length
        elif share > GOOD and step.bounded:
            self._radius = max(self._radius, GROW * length)

    def _look_inside(self) -> None:
        """Let rays start inside the parts."""
        forms = forms_of(self.program, self.y, self.cost)
        pairs = zip(self.stocks, forms, strict=True)
        self.seen = [stock.with_rays_inside(form) for stock, form in pairs]

    def _dual(self, y: Array, rays: int) -> tuple[float, Array]:
        """Compute the dual and its gradient."""
        forms = forms_of(self.program, y, self.cost)
        moments = fill_all(self.program, self.seen, forms, rays)
        value = float(y @ self.program.target) - float(np.sum(forms * moments))
        value -= 0.5 * float(self._quadratic @ (y * y))
        gradient = self.program.target - conditions_of(self.program, moments)
        return value, gradient - self._quadratic * y

    def _curvature(self, y: Array, rays: int) -> Array:
        """Compute minus the second derivative of the dual (ρ, ρ)."""
        forms, rows = forms_of(self.program, y, self.cost), self.program.rows
        pairs = zip(self.seen, forms, strict=True)
        S = np.array([second_derivatives(stock, form, rays) for stock, form in pairs])
        H = np.einsum("lri,lij,lsj->rs", rows, S, rows) / self.program.unit
        return np.asarray(H + np.diag(self._quadratic))


def _best_step(H: Array, gradient: Array, radius: float) -> _Step:
    """Maximise ``g·s - ½ s·H s`` in a ball: ``(H + λ) s = g`` with the least λ that does.

    Newton's method for ``1/|s| = 1/radius`` finds it from below.
    """
    values, V = np.linalg.eigh(H)
    values, g = np.maximum(values, 0.0), V.T @ gradient
    damping = least = FILL_ROUND_OFF * (1.0 + float(values.sum()))
    for _ in range(MOST_LENGTHS):
        s = g / (values + damping)
        length = float(np.linalg.norm(s))
        if length <= (1.0 + FILL_STEP_SOLVED) * radius:
            break
        slope = float((s * s / (values + damping)).sum()) / length
        damping += (length / radius - 1.0) * length / slope
    predicted = float(g @ s) - 0.5 * float(values @ (s * s))
    return _Step(V @ s, predicted, damping > least)
