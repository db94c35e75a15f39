"""What partial balance minimises along motions."""

from __future__ import annotations

from typing import Literal

import numpy as np

from balance.masses.partial_balance.elastic_frame import ElasticFrame
from balance.motion.verification.crank_revolution import crank_of
from balance.motion.verification.trajectory import Trajectory
from kinematics.errors import UsageError
from kinematics.model.linkage import Linkage
from kinematics.numerics.array_types import Array

MINIMISED = {
    "rms": "shaking",
    "peak": "peak of the shaking",
    "torque": "largest torque",
    "bearing": "largest bearing force",
}
PartialObjective = Literal["rms", "peak", "torque", "bearing"] | tuple[int, ...]
"""What is least: root mean square or peak of the shaking; the largest drive torque of all
inputs; the largest force in all joints; or, for orders such as ``(1, 2)``, the root mean square
of these harmonics of the shaking over a turn of a crank at constant speed."""

# Largest order of a harmonic; a turn has seven times as many samples.
MOST_ORDER = 100


def objective_in_words(minimise: PartialObjective) -> str:
    """Name what is minimised."""
    if isinstance(minimise, str):
        return MINIMISED[minimise]
    *others, last = map(str, minimise)
    orders = " and ".join(filter(None, [", ".join(others), last]))
    return f"shaking of order {orders}"


def check_objective(minimise: PartialObjective, frame: ElasticFrame | None) -> None:
    """Raise UsageError for an objective that there is not, and one beside an elastic frame."""
    if isinstance(minimise, str):
        if minimise not in MINIMISED:
            raise UsageError(
                f"minimise '{minimise}': take {', '.join(MINIMISED)}, or orders of harmonics"
            )
    elif not minimise or len(set(minimise)) < len(minimise):
        raise UsageError("orders of harmonics are different numbers, such as 1,2")
    elif not all(1 <= order <= MOST_ORDER for order in minimise):
        raise UsageError(f"orders of harmonics are from 1 to {MOST_ORDER}")
    if frame is not None:
        frame.check()
        if minimise != "rms":
            raise UsageError(
                "of an elastic frame the root mean square is least: leave out minimise"
            )


def harmonic_rows(
    linkage: Linkage, turn: Trajectory, loads: Array, orders: tuple[int, ...]
) -> Array:
    """Compute rows whose sum of squares is the mean square of harmonics of loads.

    The part of order n of N samples ``W_k`` over a turn has the complex amplitude
    ``A_n = 2/N Σ_k W_k exp(-2πi n k/N)`` and the mean square ``|A_n|²/2``.

    Args:
        turn: the motion, both ends of the turn included.
        loads: what counts of them, as affine functions (N + 1, 6, columns).
        orders: n.

    Returns:
        Real and imaginary parts (12 n, columns).

    Raises:
        UsageError: the motion is no turn of a crank after which all joints are back.
    """
    crank = crank_of(linkage, turn)
    if crank is None or not crank.periodic:
        raise UsageError(
            "harmonics are those of one turn of a crank that brings all joints back: give its "
            "speed"
        )
    count = len(loads) - 1
    waves = np.exp(-2j * np.pi / count * np.outer(orders, np.arange(count)))
    parts = np.sqrt(2.0) / count * np.tensordot(waves, loads[:-1], 1)
    return np.concatenate([parts.real, parts.imag]).reshape(-1, loads.shape[-1])
