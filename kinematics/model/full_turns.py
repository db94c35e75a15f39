"""Full turns of revolute joints: positions within one turn, and their text with a unit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from kinematics.model.linkage import Joint
from kinematics.numerics.array_types import Array, Flags, IntArray
from kinematics.numerics.tolerances import HALF_TURN_ROUND_OFF


def wrap_turns(joints: Sequence[Joint], q: ArrayLike) -> tuple[Array, IntArray]:
    """Split joint positions into positions within one turn and counts of full turns.

        q = within + 2π turns,    -π < within ≤ π    (revolute joints)

    Half a turn, up to round-off, is one forwards. A prismatic joint does not turn, and a
    helical one is elsewhere after a turn: they count none, and keep their positions.

    Args:
        q: their positions (..., n), radians, and lengths in any unit.

    Returns:
        Positions within one turn (..., n), in the same units, and the counts (..., n).
    """
    positions = np.asarray(q, dtype=np.float64)
    revolute = np.array([joint.kind == "revolute" for joint in joints], dtype=np.bool_)
    turns = np.ceil(positions / (2.0 * np.pi) - 0.5 - HALF_TURN_ROUND_OFF)
    turns = np.where(revolute, turns + 0.0, 0.0)
    return positions - 2.0 * np.pi * turns, turns.astype(np.int64)


def within_turn(q: Array, turning: Flags) -> Array:
    """Reduce joint positions, or their differences, (..., n) to half a turn at most.

    Args:
        turning: joints that are in the same place after a full turn (n,).
    """
    turns = np.where(turning, np.rint(q / (2.0 * np.pi)), 0.0)
    return np.asarray(q - 2.0 * np.pi * turns)


def unit_of_joint(joint: Joint) -> str:
    """Return the unit of the position of a joint, ``"rad"`` or ``"m"``."""
    return "m" if joint.kind == "prismatic" else "rad"


def position_text(joint: Joint, q: float, digits: int = 3) -> str:
    """Format the position of a joint within one turn, with its unit: ``0.5 rad``.

    Args:
        q: its position, radians or metres.
        digits: how many significant digits.
    """
    within, _ = wrap_turns([joint], [q])
    return f"{within[0]:.{digits}g} {unit_of_joint(joint)}"
