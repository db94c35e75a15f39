"""Integration of ``dy/dt = f(t, y)`` by an integrator of SciPy, one step after another."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from kinematics.numerics.array_types import Array


class StalledError(Exception):
    """No step, however short, meets the tolerances of an integrator."""


class Integration:
    """An integration whose caller takes each step, and looks at the state after it.

    The integrator is the explicit Runge-Kutta method of order 8 DOP853, or for stiff equations
    the implicit one of order 5 Radau.

    Attributes:
        solver: the integrator, with ``t``, ``y`` and ``dense_output()``; it goes on from the
            state ``y`` and its rate ``f`` that are assigned to it.
        proposed: length that was proposed for the last step; the end may have cut it short.

    Source:
        E. Hairer, S. P. Nørsett, G. Wanner, Solving Ordinary Differential Equations I and II.
    """

    def __init__(
        self,
        f: Callable[[float, Array], Array],
        t: float,
        y: Array,
        end: float,
        *,
        jacobian: Callable[[float, Array], Array] | None = None,
        **options: Any,
    ) -> None:
        """Start at a state.

        Args:
            f: the right side.
            t: at the start.
            y: state at the start (n,).
            end: t at the end.
            jacobian: derivative of f by y (n, n), for Radau.
            options: tolerances and steps; see `scipy.integrate.DOP853`.
        """
        from scipy.integrate import DOP853, Radau

        self.solver = (
            DOP853(f, t, y, end, **options)
            if jacobian is None
            else Radau(f, t, y, end, jac=jacobian, **options)
        )
        self.proposed = 0.0

    @property
    def running(self) -> bool:
        """Whether the end is still ahead."""
        return bool(self.solver.status == "running")

    def step(self) -> None:
        """Take a step.

        Raises:
            StalledError: none is short enough.
        """
        self.proposed = float(self.solver.h_abs)
        self.solver.step()
        if self.solver.status == "failed":
            raise StalledError
