"""Simulate a planar mechanism with flexible parts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from balance.motion.flexible.mechanism import PlanarMechanism
from kinematics.errors import LinkageError
from kinematics.numerics.array_types import Array
from kinematics.numerics.integration import Integration, StalledError

DRIFT = 1e-9
"""Residual of constraints, over the size of the mechanism, that is corrected after a step."""
STIFF = 3e4
"""Highest frequency times duration, in radians, from which the implicit method is used."""
MOST_EVALUATIONS = 200_000
"""Solutions of the equations of motion after which a simulation is given up: some minutes."""


@dataclass(frozen=True, eq=False)
class FlexibleMotion:
    """A simulated motion.

    Attributes:
        mechanism: what was simulated.
        times: in seconds; shape (t,).
        positions: coordinates of all parts; shape (t, n).
        velocities: their rates; shape (t, n).
        force: shaking force on the mount, in N; shape (t, 2).
        moment: shaking moment on the mount about the origin, in N m; shape (t,).
        energy: kinetic and elastic, in J; shape (t,).
        energy_drift: largest difference of energy, work of the drives and losses, over the
            largest energy.
        method: integrator.
        steps: number of its steps.
        evaluations: number of solutions of the equations of motion.
    """

    mechanism: PlanarMechanism
    times: Array
    positions: Array
    velocities: Array
    force: Array
    moment: Array
    energy: Array
    energy_drift: float
    method: str
    steps: int
    evaluations: int

    @property
    def peak_force(self) -> float:
        """Largest magnitude of the shaking force, in N."""
        return float(np.hypot(*self.force.T).max())

    @property
    def peak_moment(self) -> float:
        """Largest magnitude of the shaking moment, in N m."""
        return float(np.abs(self.moment).max())


def simulate(
    mechanism: PlanarMechanism,
    duration: float,
    samples: int = 1001,
    *,
    rtol: float = 1e-8,
    method: str | None = None,
    start: Array | None = None,
    velocities: Array | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> FlexibleMotion:
    """Simulate a mechanism from its start.

    Constraints hold by projection onto them after steps. Explicit Runge-Kutta (DOP853) serves
    unless the fastest mode takes too many steps; then an implicit method (Radau) does.

    Args:
        mechanism: the mechanism; coordinates at the start are projected onto its constraints.
        duration: in seconds.
        samples: number of instants of the result, equally spaced.
        rtol: relative tolerance of the integrator; the absolute tolerance follows from the
            size of the motion.
        method: ``"DOP853"`` or ``"Radau"``; chosen by default.
        start: coordinates at the start (n,); those of the mechanism by default.
        velocities: rates at the start (n,); at rest by default.
        progress: is called with the steps done and of all samples.

    Returns:
        The motion, with the shaking force and moment on the mount.

    Raises:
        LinkageError: the duration is not positive, the mechanism cannot be assembled, or the
            integration fails.
    """
    if not 0.0 < duration < np.inf:
        raise LinkageError(f"duration {duration:g} s is not positive")
    mechanism.check()
    run = _Run(mechanism)
    rates = np.zeros(len(mechanism.start)) if velocities is None else velocities
    p, v = mechanism.assemble(0.0, mechanism.start if start is None else start, rates)
    name = method or _choose_method(mechanism, p, duration)
    y = np.concatenate([p, v, [0.0]])
    times = np.linspace(0.0, duration, max(samples, 2))
    states, steps = _integrate(run, name, y, times, rtol, progress)
    n = len(p)
    loads = [mechanism.shake(t, y[:n], y[n:-1]) for t, y in zip(times, states, strict=True)]
    energy = np.array([load.energy for load in loads])
    drift = np.abs(energy - energy[0] - states[:, -1]).max() / max(energy.max(), 1e-300)
    return FlexibleMotion(
        mechanism,
        times,
        states[:, :n],
        states[:, n:-1],
        np.array([load.force for load in loads]),
        np.array([load.moment for load in loads]),
        energy,
        float(drift),
        name,
        steps,
        run.evaluations,
    )


class _Run:
    """The equations of motion as a first-order system, with the work of the drives."""

    def __init__(self, mechanism: PlanarMechanism) -> None:
        """Count evaluations from zero."""
        self.mechanism = mechanism
        self.evaluations = 0

    def slope(self, t: float, y: Array) -> Array:
        """Compute the rates of the state [p, v, work]."""
        self.evaluations += 1
        n = (len(y) - 1) // 2
        dynamics = self.mechanism.accelerate(t, y[:n], y[n:-1])
        slope = np.empty_like(y)
        slope[:n], slope[n:-1] = y[n:-1], dynamics.acceleration
        slope[-1] = dynamics.power - self.mechanism.dissipation(y[n:-1])
        return slope

    def jacobian(self, t: float, y: Array) -> Array:
        """Approximate the derivative of `slope`: elastic and damping forces alone."""
        n = (len(y) - 1) // 2
        elastic, damping = _elastic_accelerations(self.mechanism, t, y[:n], y[n:-1])
        matrix = np.zeros((2 * n + 1, 2 * n + 1))
        matrix[:n, n : 2 * n] = np.eye(n)
        matrix[n : 2 * n, :n] = -elastic
        matrix[n : 2 * n, n : 2 * n] = -damping
        return matrix


def _elastic_accelerations(
    mechanism: PlanarMechanism, t: float, p: Array, v: Array
) -> tuple[Array, Array]:
    """Compute the accelerations per displacement and per rate of the elastic forces."""
    n = len(p)
    mass, _ = mechanism.inertia(p, v)
    rows = mechanism.constraints(t, p, v).rows
    stiffness, damping = np.zeros((n, n)), np.zeros((n, n))
    for part, at in zip(mechanism.parts, mechanism.slices, strict=True):
        elastic = slice(at.start + 3, at.stop)
        stiffness[elastic, elastic], damping[elastic, elastic] = part.stiffness, part.damping
    m = len(rows)
    full = np.zeros((n + m, n + m))
    full[:n, :n], full[:n, n:], full[n:, :n] = mass, rows.T, rows
    right = np.zeros((n + m, 2 * n))
    right[:n, :n], right[:n, n:] = stiffness, damping
    accelerations = np.asarray(np.linalg.solve(full, right)[:n], np.float64)
    return accelerations[:, :n], accelerations[:, n:]


def _choose_method(mechanism: PlanarMechanism, p: Array, duration: float) -> str:
    """Choose the explicit method unless fast modes or damping would take too many steps."""
    elastic, damping = _elastic_accelerations(mechanism, 0.0, p, np.zeros(len(p)))
    fastest = np.sqrt(np.abs(np.linalg.eigvals(elastic)).max(initial=0.0))
    fastest = max(fastest, np.abs(np.linalg.eigvals(damping)).max(initial=0.0))
    return "Radau" if fastest * duration > STIFF else "DOP853"


def _integrate(
    run: _Run,
    name: str,
    y: Array,
    times: Array,
    rtol: float,
    progress: Callable[[int, int], None] | None,
) -> tuple[Array, int]:
    """Integrate from time to time; correct the constraints after steps that left them.

    Raises:
        LinkageError: the integrator fails.
    """
    mechanism, n = run.mechanism, (len(y) - 1) // 2
    states, steps, k = np.empty((len(times), len(y))), 0, 1
    states[0] = y
    scale = rtol * _absolute_scale(mechanism, y[:n], times[-1])
    jacobian = run.jacobian if name == "Radau" else None
    integration = Integration(
        run.slope, 0.0, y, times[-1], jacobian=jacobian, rtol=rtol, atol=scale
    )
    solver = integration.solver
    while integration.running and run.evaluations < MOST_EVALUATIONS:
        try:
            integration.step()
        except StalledError:
            raise LinkageError(
                f"the integration stops at {solver.t:g} s: the mechanism reaches a singular "
                "pose, or bends too far; lower the speed"
            ) from None
        steps += 1
        if k < len(times) and times[k] <= solver.t:
            dense = solver.dense_output()
            while k < len(times) and times[k] <= solver.t:
                states[k] = dense(times[k]) if times[k] < solver.t else solver.y
                states[k] = _correct(mechanism, times[k], states[k])
                k += 1
            if progress is not None:
                progress(k, len(times))
        corrected = _correct(mechanism, solver.t, solver.y)
        if corrected is not solver.y:
            solver.y, solver.f = corrected, run.slope(solver.t, corrected)
    if integration.running:
        raise LinkageError(
            f"the integration is slow at {solver.t:g} s: the mechanism is near a singular "
            "pose, or vibrates fast; give a shorter duration, a lower speed or fewer modes"
        )
    return states, steps


def _correct(mechanism: PlanarMechanism, t: float, y: Array) -> Array:
    """Move a state [p, v, work] onto the constraints if it has left them."""
    n = (len(y) - 1) // 2
    g = mechanism.constraints(t, y[:n], y[n:-1]).g
    if np.abs(g).max(initial=0.0) <= DRIFT * mechanism.size:
        return y
    return np.concatenate([*mechanism.assemble(t, y[:n], y[n:-1]), y[-1:]])


def _absolute_scale(mechanism: PlanarMechanism, p: Array, duration: float) -> Array:
    """Sizes below which coordinates and rates need no relative accuracy; shape (2n + 1,).

    Rates are as large as coordinates times the frequency at which these vibrate.
    """
    scale = np.full(len(mechanism.start), 1e-2)
    for at in mechanism.slices:
        scale[at.start : at.start + 2] = 1e-2 * mechanism.size
        scale[at.start + 3 : at.stop] = 1e-3 * mechanism.size
    elastic, _ = _elastic_accelerations(mechanism, 0.0, p, np.zeros(len(p)))
    pace = np.maximum(np.sqrt(np.abs(np.diag(elastic))), 1.0 / duration)
    return np.concatenate([scale, pace * scale, [1e-3]])
