"""Gauss-Newton and Levenberg-Marquardt methods: one loop, a step rule and stopping rules.

For equations b(x) = 0 with the Jacobian A = ∂b/∂x, the method takes

    x ← x - δ,    δ = A⁺ b    (Gauss-Newton: the step of least norm)

until a rule decides that x is a solution, or that none is nearby. The step rule decides
how A is inverted where it is nearly singular, and whether a step is taken at all:

    LeastNorm             A⁺ without the singular values below a part of the largest
    FixedRank             A⁺ with a given number of singular values, the largest ones
    LevenbergMarquardt    δ = (Aᵀ A + μ² 1)⁻¹ Aᵀ b, only if the equations come closer to 0

The Newton method of `kinematics.closure.newton` is a kernel of its own: it solves for the
dependent joints alone, whose matrix is square and sparse, and runs within compiled loops.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple, Protocol

import numpy as np

from kinematics.numerics.array_types import Array

Equations = Callable[[Any], tuple[Array, Array]]


class StepRule(Protocol):
    """A rule that computes a step, and decides whether the point reached is accepted."""

    def step(self, residual: Array, jacobian: Array) -> Array:
        """Compute the step δ (n,) to subtract from the unknowns.

        Args:
            residual: b (rows,).
            jacobian: A (rows, n).
        """
        ...

    def accepts(self, before: Array, after: Array) -> bool:
        """Decide whether a step is taken.

        Args:
            before: residual at the point before the step (rows,).
            after: residual at the point after it (rows,).
        """
        ...


class Iterate:
    """A point of the iteration.

    Attributes:
        x: the unknowns.
        residual: b there (rows,).
        step: the step δ (n,) of the rule from there; computed at its first use.
        next: the unknowns after that step.
    """

    def __init__(
        self, x: Any, equations: tuple[Array, Array], rule: StepRule, move: Callable
    ) -> None:
        """Keep residual and Jacobian at a point, before the step is computed."""
        self.x, self.residual = x, equations[0]
        self._jacobian, self._rule, self._move = equations[1], rule, move

    @cached_property
    def step(self) -> Array:
        """The step δ (n,)."""
        return self._rule.step(self.residual, self._jacobian)

    @cached_property
    def next(self) -> Any:
        """The unknowns after the step."""
        return self._move(self.x, self.step)

    @property
    def error(self) -> float:
        """Largest entry of the residual; 0 if there are no equations."""
        return float(np.abs(self.residual).max(initial=0.0))

    @property
    def size(self) -> float:
        """Largest entry of the step."""
        return float(np.abs(self.step).max())

    def again(self) -> Iterate:
        """Return the same point, with a step that the rule has yet to compute."""
        return Iterate(self.x, (self.residual, self._jacobian), self._rule, self._move)


StoppingRule = Callable[[Sequence[Iterate]], bool]


class Solution(NamedTuple):
    """The point at which the method stopped.

    Attributes:
        last: the last point whose step was accepted.
        solved: whether the stopping rule accepts it as a solution.
    """

    last: Iterate
    solved: bool


def gauss_newton(
    equations: Equations,
    start: Any,
    rule: StepRule,
    solved: StoppingRule,
    failed: StoppingRule,
    evaluations: int,
    move: Callable[[Any, Array], Any] = np.subtract,
) -> Solution:
    """Solve b(x) = 0 by steps ``x ← x - δ``.

    Args:
        equations: residual b (rows,) and Jacobian A (rows, n) at a point x.
        start: the point from which to start, usually (n,).
        rule: chooses δ, and whether the step is taken; see `LeastNorm`.
        solved: decides from all points so far, the present one last, whether it is a solution.
        failed: decides likewise whether to give up; called after ``solved``.
        evaluations: how often to evaluate the equations at most.
        move: the point that a step δ (n,) leads to, if the unknowns are no vector.

    Returns:
        The last point accepted. It is not a solution if the evaluations were used up, or if
        a step cannot be computed because numbers overflow.
    """
    x = start
    path: list[Iterate] = []
    for _ in range(evaluations):
        there = Iterate(x, equations(x), rule, move)
        if not path or rule.accepts(path[-1].residual, there.residual):
            path.append(there)
        else:
            path[-1] = path[-1].again()
        try:
            if solved(path):
                return Solution(path[-1], True)
            if failed(path):
                break
            x = path[-1].next
        except np.linalg.LinAlgError:
            break
    return Solution(path[-1], False)


def never_stop(path: Sequence[Iterate]) -> bool:
    """Go on until the evaluations are used up: a stopping rule."""
    return False


def step_grows(largest: float, negligible: float = 0.0) -> StoppingRule:
    """Make the stopping rule that gives up at a step larger than the one before.

    Args:
        largest: size of the first step, in the units of x, that is too large.
        negligible: size of steps that are round-off: a step up to it may follow any.
    """

    def rule(path: Sequence[Iterate]) -> bool:
        limit = max(path[-2].size, negligible) if len(path) > 1 else largest
        return path[-1].size > limit

    return rule


class LeastNorm:
    """Steps of least norm, ``δ = A⁺ b``; every one is taken.

    Attributes:
        rcond: singular values of A below this part of the largest count as zero.
        longest: largest entry of a step; longer steps are shortened.
    """

    def __init__(self, rcond: float, longest: float = np.inf) -> None:
        """Make steps without the singular values below ``rcond`` times the largest."""
        self.rcond, self.longest = rcond, longest

    def step(self, residual: Array, jacobian: Array) -> Array:
        """Compute ``δ = A⁺ b`` (n,), shortened if it is too long.

        Args:
            residual: b (rows,).
            jacobian: A (rows, n).
        """
        step = np.linalg.lstsq(jacobian, residual, rcond=self.rcond)[0]
        if self.longest < np.inf:
            step = step * min(1.0, self.longest / max(float(np.abs(step).max()), 1e-300))
        return np.asarray(step, np.float64)

    def accepts(self, before: Array, after: Array) -> bool:
        """Accept every step.

        Args:
            before: not used.
            after: not used.
        """
        return True


class FixedRank:
    """Steps ``δ = A⁺ b`` with a given rank of A; every one is taken.

    Attributes:
        rank: number of the largest singular values of A that count.
    """

    def __init__(self, rank: int) -> None:
        """Make steps with this number of singular values."""
        self.rank = rank

    def step(self, residual: Array, jacobian: Array) -> Array:
        """Compute ``δ = A⁺ b`` (n,) from the largest singular values.

        Args:
            residual: b (rows,).
            jacobian: A (rows, n).
        """
        U, values, Vt = np.linalg.svd(jacobian)
        inverse = (Vt[: self.rank].T / values[: self.rank]) @ U[:, : self.rank].T
        return np.asarray(inverse @ residual)

    def accepts(self, before: Array, after: Array) -> bool:
        """Accept every step.

        Args:
            before: not used.
            after: not used.
        """
        return True


class LevenbergMarquardt:
    """Damped steps, ``min |A δ - b|² + μ² |δ|²`` with ``μ = damping min(|b|, 1)``.

    A step that does not bring the equations closer to 0 is not taken, and the next one is
    damped more. (N. Yamashita and M. Fukushima, "On the rate of convergence of the
    Levenberg-Marquardt method", 2001: damping by the size of the residual keeps it quadratic.)

    Attributes:
        damping: the present factor; it grows by 8 at a step not taken, shrinks by 4 else.
    """

    # Factor of the damping after a step that is not taken.
    GROWTH = 8.0
    # Factor of the damping after a step that is taken.
    SHRINK = 0.25
    # Smallest damping.
    MIN_DAMPING = 1e-3

    def __init__(self, damping: float) -> None:
        """Make steps that begin with this factor."""
        self.damping = damping

    def step(self, residual: Array, jacobian: Array) -> Array:
        """Compute the damped step δ (n,).

        Args:
            residual: b (rows,).
            jacobian: A (rows, n).
        """
        count = jacobian.shape[1]
        size = min(float(np.linalg.norm(residual)), 1.0)
        upper = np.concatenate([jacobian, self.damping * size * np.eye(count)])
        right = np.concatenate([residual, np.zeros(count)])
        return np.asarray(np.linalg.lstsq(upper, right, rcond=None)[0], np.float64)

    def accepts(self, before: Array, after: Array) -> bool:
        """Accept a step that makes the residual smaller; change the damping for the next one.

        Args:
            before: residual at the point before the step (rows,).
            after: residual at the point after it (rows,).
        """
        if not float(np.linalg.norm(after)) < float(np.linalg.norm(before)):
            self.damping *= self.GROWTH
            return False
        self.damping = max(self.SHRINK * self.damping, self.MIN_DAMPING)
        return True
