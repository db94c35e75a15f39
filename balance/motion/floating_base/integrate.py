"""Integration of the equations of motion, with every accepted step kept."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from balance.motion.floating_base.equations import BaseEquations
from balance.motion.motion_tolerances import BASE_STEP_RELATIVE
from kinematics.errors import PoseError
from kinematics.numerics.integration import Integration, StalledError

Array = NDArray[np.float64]

# Fewest steps, for smooth pictures.
FEWEST_STEPS = 100
# Most evaluations of the equations.
MAX_EVALUATIONS = 300_000
# The least that one vibration takes.
EVALUATIONS_PER_VIBRATION = 150.0
# Shortest step, as a part of the duration.
SHORTEST_STEP = 1e-9


def check_frequencies(frequencies: tuple[float, ...], duration: float) -> None:
    """Refuse vibrations that would take too many steps.

    Args:
        frequencies: natural frequencies of the base, hertz.
        duration: seconds.

    Raises:
        PoseError: there are too many vibrations.
    """
    count = duration * max(frequencies, default=0.0)
    if not count * EVALUATIONS_PER_VIBRATION < MAX_EVALUATIONS:
        raise PoseError(
            f"the base vibrates {count:.0f} times on its springs in {duration:g} s: give a "
            "shorter duration, a heavier base or softer springs"
        )


def integrate_steps(
    equations: BaseEquations, state: Array, tolerances: Array, span: tuple[float, float],
    progress: Callable[[int, int], None] | None = None,
) -> tuple[Array, Array]:  # fmt: skip
    """Integrate the equations by DOP853, from one corner of the path to the next.

    Args:
        state: state at the start.
        tolerances: absolute ones of the state.
        span: times of start and end, seconds.
        progress: called with the hundredths done, and 100.

    Returns:
        Times (N,) and states (N, size) of all steps.

    Raises:
        PoseError: the loops cannot be closed, or the steps become too many or too small.
    """
    start, end = span
    corners = () if equations.drive.path is None else equations.drive.path.corners
    stops = [*(time for time in corners if start < time < end), end]
    times, states, step = [start], [state], None
    for stop in stops:
        while times[-1] < stop:
            # Numbers that overflow end the integration below.
            with np.errstate(over="ignore", invalid="ignore"):
                step = _advance(equations, times, states, stop, tolerances, step, end - start)
            if progress is not None:
                progress(int(100.0 * (times[-1] - start) / (end - start)), 100)
    return np.array(times), np.array(states)


def _advance(
    equations: BaseEquations, times: list[float], states: list[Array], stop: float,
    tolerances: Array, step: float | None, duration: float,
) -> float:  # fmt: skip
    """Integrate up to a stop, append all steps, and return the length of the next one.

    The last step may be cut short to end at the stop: what the solver proposes after it is then
    no measure of the motion, and the longest of the proposals before and after it counts.
    """
    now = times[-1]
    first = None if step is None else min(step, stop - now)
    integration = Integration(
        equations, now, states[-1], stop, rtol=BASE_STEP_RELATIVE, atol=tolerances,
        max_step=duration / FEWEST_STEPS, first_step=first,
    )  # fmt: skip
    solver, stalled = integration.solver, False
    while integration.running:
        try:
            integration.step()
        except PoseError as error:
            raise PoseError(f"{error} beyond {solver.t:.6g} s of the motion") from None
        except StalledError:
            stalled = True
        short = solver.t < stop and not solver.step_size > SHORTEST_STEP * duration
        if stalled or short or equations.evaluations > MAX_EVALUATIONS:
            raise PoseError(
                f"the motion needs too many steps beyond {solver.t:.6g} s: it is near a "
                "singular pose, or a spring is stiff; give a shorter duration, smaller "
                "displacements or a softer spring"
            )
        times.append(float(solver.t))
        states.append(solver.y.copy())
    return max(integration.proposed, float(solver.h_abs))


def integrate_at(
    equations: BaseEquations, state: Array, tolerances: Array, times: Array
) -> Array:
    """Integrate smooth equations and return the states at given times (N, size).

    Args:
        equations: the equations, whose path has no corners.
        state: state at the first time.
        tolerances: absolute ones of the state.
        times: times (N,), seconds.
    """
    from scipy.integrate import solve_ivp

    solution = solve_ivp(
        equations, (times[0], times[-1]), state, method="DOP853", t_eval=times,
        rtol=BASE_STEP_RELATIVE, atol=tolerances,
    )  # fmt: skip
    return np.asarray(solution.y.T)
