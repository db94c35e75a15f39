"""Points of moving parts at a state, and the constraints that joints between them are."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.motion.flexible.mechanism_types import ConstraintRows, MechanismJoint, On, Row

Array = NDArray[np.float64]


class PointState(NamedTuple):
    """A point at a state; rows are over the coordinates of its part alone.

    Attributes:
        own: where these coordinates are.
        x, y: position in the plane.
        rows: derivatives of x and y; shape (2, 3 + n).
        ax, ay: acceleration without that of the coordinates.
        angle: direction of the marker.
        turn: its derivatives; shape (3 + n,).
    """

    own: slice
    x: float
    y: float
    rows: Array
    ax: float
    ay: float
    angle: float
    turn: Array


_NOWHERE = slice(0, 0)
_NO_ROWS = np.zeros((2, 0))
_NO_TURN = np.zeros(0)
_RIGID_TURN = np.array([0.0, 0.0, 1.0])


def evaluate_point(on: On, slices: Sequence[slice], p: Array, v: Array) -> PointState:
    """Evaluate a point at a state.

    Args:
        slices: where the coordinates of each part are.
        p: coordinates (n,).
        v: their rates (n,).
    """
    marker = on.marker
    if on.part < 0:
        x, y = marker.at.tolist()
        return PointState(_NOWHERE, x, y, _NO_ROWS, 0.0, 0.0, 0.0, _NO_TURN)
    columns = slices[on.part]
    k = columns.start
    x, y, angle = p[k : k + 3].tolist()
    spin = v[k + 2].item()
    c, s = math.cos(angle), math.sin(angle)
    lx, ly = marker.at.tolist()
    if columns.stop == k + 3:
        rx, ry = c * lx - s * ly, s * lx + c * ly
        rows = np.array([[1.0, 0.0, -ry], [0.0, 1.0, rx]])
        two = spin * spin
        return PointState(
            columns, x + rx, y + ry, rows, -two * rx, -two * ry, angle, _RIGID_TURN
        )
    q, dq = p[k + 3 : columns.stop], v[k + 3 : columns.stop]
    bent = marker.shortening @ q
    along = marker.along - bent
    lx += (marker.along @ q - 0.5 * (bent @ q)).item()
    ly += (marker.across @ q).item()
    ax = -(spin**2) * lx - 2.0 * spin * (marker.across @ dq).item()
    ax -= (dq @ (marker.shortening @ dq)).item()
    ay = -(spin**2) * ly + 2.0 * spin * (along @ dq).item()
    rx, ry = c * lx - s * ly, s * lx + c * ly
    rows = np.empty((2, columns.stop - k))
    rows[:, :3] = ((1.0, 0.0, -ry), (0.0, 1.0, rx))
    rows[0, 3:] = c * along - s * marker.across
    rows[1, 3:] = s * along + c * marker.across
    turn = np.concatenate([_RIGID_TURN, marker.turn])
    angle += (marker.turn @ q).item()
    return PointState(
        columns, x + rx, y + ry, rows, c * ax - s * ay, s * ax + c * ay, angle, turn
    )


def add_joint(
    constraints: ConstraintRows,
    k: int,
    joint: MechanismJoint,
    a: PointState,
    b: PointState,
    v: Array,
) -> int:
    """Write the constraints of a joint.

    Args:
        constraints: out: the constraints.
        k: first row of the joint.
        a: its point on the first part.
        b: its point on the second part.
        v: rates of the coordinates (n,).

    Returns:
        The row after those of the joint.
    """
    if joint.kind == "prismatic":
        value, row, bias = _slide(joint, a, b, v, across=True)
        constraints.g[k], constraints.rows[k], constraints.gamma[k] = value, row, -bias
        k += 1
    else:
        constraints.g[k], constraints.g[k + 1] = b.x - a.x, b.y - a.y
        constraints.rows[k : k + 2, b.own] += b.rows
        constraints.rows[k : k + 2, a.own] -= a.rows
        constraints.gamma[k], constraints.gamma[k + 1] = a.ax - b.ax, a.ay - b.ay
        k += 2
    if joint.kind != "revolute":
        constraints.g[k] = b.angle - a.angle - joint.angle
        constraints.rows[k, b.own] += b.turn
        constraints.rows[k, a.own] -= a.turn
        k += 1
    return k


def position_row(joint: MechanismJoint, a: PointState, b: PointState, v: Array) -> Row:
    """Compute the position of a joint: an angle, or a distance along its axis.

    Args:
        a: its point on the first part.
        b: its point on the second part.
        v: rates of the coordinates (n,).
    """
    if joint.kind == "prismatic":
        return _slide(joint, a, b, v, across=False)
    row = np.zeros(len(v))
    row[b.own] += b.turn
    row[a.own] -= a.turn
    return Row(b.angle - a.angle - joint.angle, row, 0.0)


def _slide(joint: MechanismJoint, a: PointState, b: PointState, v: Array, across: bool) -> Row:
    """Project the difference of two points on the axis of a slider, or across it."""
    c, s = math.cos(a.angle), math.sin(a.angle)
    ex, ey = joint.axis
    ex, ey = (-ey, ex) if across else (ex, ey)
    e = np.array([c * ex - s * ey, s * ex + c * ey])
    normal = np.array([-e[1], e[0]])
    apart = np.array([b.x - a.x, b.y - a.y])
    row = np.zeros(len(v))
    row[b.own] += e @ b.rows
    row[a.own] -= e @ a.rows
    row[a.own] += float(normal @ apart) * a.turn
    speed = b.rows @ v[b.own] - a.rows @ v[a.own]
    spin, value = float(a.turn @ v[a.own]), float(e @ apart)
    bias = e[0] * (b.ax - a.ax) + e[1] * (b.ay - a.ay)
    bias += 2.0 * spin * float(normal @ speed) - spin**2 * value
    return Row(value, row, float(bias))
