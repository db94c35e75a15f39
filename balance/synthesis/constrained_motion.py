"""The motion of a balanced pantograph through its positions, and what is wrong with it.

The angle δ between the links starts from rest, ``δ_1 + (δ_n - δ_1) (1 - cos(π t / 2))``; the
first link follows from the integral of the momentum (`link_turn`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.synthesis.balanced_pantograph import ELBOW, SHOULDER, BalancedPantograph
from balance.synthesis.momentum_integral import link_reverses, link_turn, link_turn_rate
from balance.tolerances import SYNTHESIS_LINK_FLAT

__all__ = [
    "Defect", "MotionTable", "constrained_motion", "list_defects", "motion_csv",
    "tabulated_motion",
]  # fmt: skip

Array = NDArray[np.float64]

# Samples of a motion, and numbers of samples of a table that are compared: more amplify
# rounding in the second derivative of the spline through them, fewer its truncation.
SAMPLES, COMPARED = 257, range(201, 561, 4)
# Degree of the spline that ``balance verify --csv`` puts through a table.
DEGREE = 5


class MotionTable(NamedTuple):
    """A motion of the inputs ``shoulder`` and ``elbow`` over one second.

    Attributes:
        time: seconds (N,).
        u: displacements from the pose of the file (N, 2), radians.
        ud: velocities.
        udd: accelerations.
    """

    time: Array
    u: Array
    ud: Array
    udd: Array


class Defect(NamedTuple):
    """A reason why a mechanism may not go from position to position as it should.

    Attributes:
        kind: ``"branch"``: the linkage passes a change point, where it may fold into another
            branch; ``"circuit"``: positions lie on different circuits; ``"order"``: it passes
            them in another order; ``"reversal"``: the first link reverses on the way.
        words: where, in words.
    """

    kind: str
    words: str


def constrained_motion(pantograph: BalancedPantograph, samples: int = SAMPLES) -> MotionTable:
    """Compute the motion without momentum through all positions of a pantograph.

    Args:
        pantograph: the pantograph.
        samples: number of samples.
    """
    deltas = pantograph.deltas
    forward = deltas[-1] >= deltas[0]
    ends = (min(deltas), max(deltas)) if forward else (max(deltas), min(deltas))
    time, span = np.linspace(0.0, 1.0, samples), ends[1] - ends[0]
    quarter = 0.5 * np.pi
    # Rounded once: the derivatives of a spline amplify rounding.
    exact = ends[0] + np.longdouble(span) * (1.0 - np.cos(quarter * time.astype(np.longdouble)))
    inertias = pantograph.inertias
    turns = link_turn(exact, inertias) - link_turn(np.longdouble(deltas[0]), inertias)
    first, elbow = turns.astype(np.float64), (deltas[0] - exact).astype(np.float64)
    rate = quarter * span * np.sin(quarter * time)
    acceleration = quarter**2 * span * np.cos(quarter * time)
    slope, bend = link_turn_rate(exact.astype(np.float64), inertias)
    link, tool = pantograph.pose
    return MotionTable(
        time,
        np.column_stack([first - link, elbow - (tool - link)]),
        np.column_stack([slope * rate, -rate]),
        np.column_stack([bend * rate**2 + slope * acceleration, -acceleration]),
    )


def tabulated_motion(pantograph: BalancedPantograph) -> MotionTable:
    """Compute the motion of a pantograph with the number of samples that suits a table best.

    It is the one for which the spline of degree five through the table has the smallest error
    in the second derivative.

    Args:
        pantograph: the pantograph.
    """
    from scipy.interpolate import make_interp_spline

    def error(motion: MotionTable) -> float:
        spline = make_interp_spline(motion.time, motion.u, k=DEGREE)
        return float(np.abs(spline(motion.time, 2) - motion.udd).max())

    return min((constrained_motion(pantograph, count) for count in COMPARED), key=error)


def motion_csv(table: MotionTable) -> bytes:
    """Write a motion as a table for ``balance verify --csv``."""
    rows = np.column_stack([table.time, table.u]).tolist()
    lines = [f"time,{SHOULDER},{ELBOW}", *(",".join(map(repr, row)) for row in rows)]
    return ("\n".join(lines) + "\n").encode()


def list_defects(pantograph: BalancedPantograph) -> tuple[Defect, ...]:
    """List branch, order and reversal defects of the motion through all positions.

    The parallelogram is flat, and may fold into an antiparallelogram, where δ is a multiple of
    π. Between two such values the assembly, the sign of sin δ, cannot change, so all positions
    are on one circuit.

    Args:
        pantograph: the pantograph.
    """
    found = []
    deltas, turns = pantograph.deltas, pantograph.chain.link_turns
    low = min(deltas) - SYNTHESIS_LINK_FLAT
    flat = math.pi * math.ceil(low / math.pi)
    if flat <= max(deltas) + SYNTHESIS_LINK_FLAT:
        at = math.degrees(flat - deltas[0])
        found.append(Defect("branch", f"the parallelogram is flat {at:+.1f}° of δ on"))
    steps = np.diff(turns)
    if steps.size > 1 and not (np.all(steps > 0.0) or np.all(steps < 0.0)):
        found.append(Defect("order", "position 2 is not between positions 1 and 3"))
    inertias = pantograph.inertias
    if inertias.coupling and link_reverses(min(deltas), max(deltas), inertias).any():
        found.append(Defect("reversal", "the first link reverses, where J2 + C cos δ = 0"))
    return tuple(found)
