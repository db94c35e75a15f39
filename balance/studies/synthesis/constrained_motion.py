"""The motion of a balanced pantograph through its positions, and what is wrong with it.

The angle δ between the links starts from rest, ``δ_1 + (δ_n - δ_1) (1 - cos(π t / 2))``; the
first link follows from the integral of the momentum (`link_turn`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import SYNTHESIS_LINK_FLAT
from balance.studies.synthesis.balanced_pantograph import ELBOW, SHOULDER, BalancedPantograph
from balance.studies.synthesis.momentum_integral import link_reverses, link_turn, link_turn_rate
from balance.support.csv_text import csv_table
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text

SAMPLES = 241


class MotionTable(NamedTuple):
    """A motion of the inputs of a mechanism.

    Attributes:
        time: seconds (N,).
        u: displacements from the pose of the file (N, inputs), radians.
        ud: velocities.
        udd: accelerations.
        inputs: their names.
    """

    time: Array
    u: Array
    ud: Array
    udd: Array
    inputs: tuple[str, ...] = (SHOULDER, ELBOW)


class Defect(NamedTuple):
    """A reason why a mechanism may not go from position to position as it should.

    Attributes:
        kind: ``"branch"``: the linkage passes a change point, where it may fold into another
            branch; ``"circuit"``: it must do so, as positions lie on both sides of one;
            ``"order"``: it passes them in another order; ``"reversal"``: the first link
            reverses on the way.
        words: where, in words.
    """

    kind: str
    words: str


def constrained_motion(pantograph: BalancedPantograph) -> MotionTable:
    """Compute the motion without momentum through all positions of a pantograph."""
    deltas = pantograph.deltas
    forward = deltas[-1] >= deltas[0]
    ends = (min(deltas), max(deltas)) if forward else (max(deltas), min(deltas))
    time, span = np.linspace(0.0, 1.0, SAMPLES), ends[1] - ends[0]
    quarter = 0.5 * np.pi
    opening = ends[0] + span * (1.0 - np.cos(quarter * time))
    inertias = pantograph.inertias
    first = link_turn(opening, inertias) - link_turn(deltas[0], inertias)
    elbow = deltas[0] - opening
    rate = quarter * span * np.sin(quarter * time)
    acceleration = quarter**2 * span * np.cos(quarter * time)
    slope, bend = link_turn_rate(opening, inertias)
    link, tool = pantograph.pose
    return MotionTable(
        time,
        np.column_stack([first - link, elbow - (tool - link)]),
        np.column_stack([slope * rate, -rate]),
        np.column_stack([bend * rate**2 + slope * acceleration, -acceleration]),
    )


def motion_csv(table: MotionTable) -> bytes:
    """Write a motion as a table for ``balance verify --csv``, with its derivatives."""
    kinds = ("", "velocity ", "acceleration ")
    names = [f"{kind}{joint}" for kind in kinds for joint in table.inputs]
    return csv_table(["time", *names], [table.time, table.u, table.ud, table.udd])


def list_defects(pantograph: BalancedPantograph) -> tuple[Defect, ...]:
    """List branch, order and reversal defects of the motion through all positions.

    The parallelogram is flat, and may fold into an antiparallelogram, where δ is a multiple of
    π. Between two such values the assembly, the sign of sin δ, cannot change.
    """
    defects = []
    deltas, turns = pantograph.deltas, pantograph.chain.link_turns
    if (flat := _first_flat(deltas)) is not None:
        at = math.degrees(flat - deltas[0])
        defects.append(
            Defect("branch", f"the parallelogram is flat {number_text(at, '+.1f')}° of δ on")
        )
        if len({math.sin(each) > 0.0 for each in deltas}) > 1:
            defects.append(
                Defect("circuit", "the elbow is on the other side at another position")
            )
    steps = np.diff(turns)
    if steps.size > 1 and not (np.all(steps > 0.0) or np.all(steps < 0.0)):
        defects.append(Defect("order", "position 2 is not between positions 1 and 3"))
    inertias = pantograph.inertias
    if inertias.coupling and link_reverses(min(deltas), max(deltas), inertias).any():
        defects.append(Defect("reversal", "the first link reverses, where J2 + C cos δ = 0"))
    return tuple(defects)


def _first_flat(deltas: tuple[float, ...]) -> float | None:
    """Find the flat parallelogram that the motion from the first position meets first.

    Args:
        deltas: δ at each position.

    Returns:
        δ there, a multiple of π; None if there is none on the way.
    """
    low, high = min(deltas) - SYNTHESIS_LINK_FLAT, max(deltas) + SYNTHESIS_LINK_FLAT
    start, next_one = deltas[0], deltas[1]
    ahead = 1.0 if next_one >= start else -1.0
    turns = range(math.ceil(low / math.pi), math.floor(high / math.pi) + 1)
    # First those towards the second position, then those on the way to a third one behind.
    flats = sorted(
        (math.pi * turn for turn in turns),
        key=lambda flat: (ahead * (flat - start) < -SYNTHESIS_LINK_FLAT, abs(flat - start)),
    )
    return flats[0] if flats else None
