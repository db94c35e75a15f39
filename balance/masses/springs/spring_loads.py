"""Springs for every load of a range: what stiffnesses that stay leave, and how points move.

The energy of gravity is linear in the load, those of springs in k and k s: springs of the same
stiffness that balance the least and the greatest load balance every load between, if the free
coordinates move by equal steps for equal steps of the load. That is one convex program, on k
and on k s for both loads.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from balance.masses.payload import Payload
from balance.masses.springs.spring_cone import SpringCone, balanced_unknowns
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, repr_lines, vector_text


class MovedSpring(NamedTuple):
    """A spring of which a point moves with the load.

    Attributes:
        number: its number from 1.
        stiffness: N/m.
        start: both points for the least load (2, 3), in the frames of their links, metres.
        end: both points for the greatest load, likewise.
    """

    number: int
    stiffness: float
    start: Array
    end: Array

    def __repr__(self) -> str:
        """Give one line: stiffness and moves."""
        return f"MovedSpring {self.number}: {self.words}"

    @property
    def words(self) -> str:
        """Stiffness, and the points that move, in words."""
        moves = [
            f"{vector_text(a)} m to {vector_text(b)} m"
            for a, b in zip(self.start, self.end, strict=True)
            if np.abs(a - b).max() > 0.0
        ]
        where = f", a point from {' and '.join(moves)}" if moves else ", which stays"
        return f"{number_text(self.stiffness)} N/m{where}"


class SpringLoads(NamedTuple):
    """What springs do for a range of loads.

    Attributes:
        payload: the range.
        torque_shares: root mean square of the torques that the springs for the mean load leave
            for the least and the greatest load, over that of gravity there.
        springs: the springs whose points move; empty if none balance every load.
    """

    payload: Payload
    torque_shares: tuple[float, float]
    springs: tuple[MovedSpring, ...]

    def __repr__(self) -> str:
        """Up to six lines: the answer, and the springs."""
        return repr_lines("SpringLoads", self.words, *(repr(s) for s in self.springs))

    @property
    def words(self) -> str:
        """The answer in words."""
        low, high = (number_text(100.0 * x, ".3g") for x in self.torque_shares)
        ends = f"{number_text(self.payload.low)} and {number_text(self.payload.high)} kg"
        text = f"springs that stay leave {low} and {high} % of the torque for {ends}"
        if not self.springs:
            return f"{text}; no points of these springs that move balance every load"
        return f"{text}; with points that move with the load, none"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON."""
        return {
            **self.payload.to_dict(),
            "left": list(self.torque_shares),
            "words": self.words,
            "moved": [
                {
                    "spring": spring.number,
                    "stiffness": spring.stiffness,
                    "start": spring.start.tolist(),
                    "end": spring.end.tolist(),
                }
                for spring in self.springs
            ],
        }


def moved_unknowns(
    rows: Sequence[Array], cone: SpringCone, gravity: Sequence[float]
) -> tuple[Array, Array] | None:
    """Find unknowns for two loads that differ in coordinates alone.

    Args:
        rows: conditions for both loads, each with gravity last, in units of its own.
        cone: the limits of the unknowns for one load.
        gravity: how many units of the cone are one unit of gravity in each of the conditions.

    Returns:
        The unknowns for the least and the greatest load; None if there are none.
    """
    starts, count = cone.starts, cone.starts[-1]
    stiffnesses = set(starts[:-1])
    coordinates = [c for c in range(count) if c not in stiffnesses]
    width = count + len(coordinates)
    T = np.zeros((2, count, width))
    T[0, :, :count] = np.eye(count)
    for start in stiffnesses:
        T[1, start, start] = 1.0
    for k, c in enumerate(coordinates):
        T[1, c, count + k] = 1.0
    conditions = np.concatenate(
        [
            np.column_stack([part[:, :-1] @ t, factor * part[:, -1]])
            for part, t, factor in zip(rows, T, gravity, strict=True)
        ]
    )
    both = SpringCone(
        np.concatenate([cone.rows @ t for t in T]),
        np.tile(cone.offset, 2),
        (*starts[:-1], width),
    )
    x = balanced_unknowns(conditions, both)
    return None if x is None else (T[0] @ x, T[1] @ x)
