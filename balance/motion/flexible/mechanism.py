"""Planar mechanisms of rigid and flexible parts: constraints, equations of motion, shaking.

With coordinates p of all parts, constraints g(p, t) = 0 and G = ∂g/∂p, the accelerations and
multipliers solve

    [M  Gᵀ] [a]   [Q - h]
    [G  0 ] [λ] = [  γ  ],      γ = -Ġ ṗ + ∂²g/∂t²

The shaking force and moment are the reverse of the rate of change of the momentum.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from balance.motion.flexible.beam_part import MovingPart
from balance.motion.flexible.mechanism_types import (
    ConstraintRows,
    Dynamics,
    GearRelation,
    JointDrive,
    MechanismJoint,
    On,
    Row,
    Shaking,
)
from kinematics.errors import LinkageError
from kinematics.numerics.array_types import Array

MOST_NEWTON_STEPS = 30
ASSEMBLED = 1e-12
"""Largest residual of constraints, over the size of the mechanism, after assembly."""
INDEPENDENT = 1e-11
"""Least singular value, over the largest, of constraints that count as independent."""


@dataclass(frozen=True, eq=False)
class PlanarMechanism:
    """A planar mechanism.

    Attributes:
        parts: the moving parts.
        joints: the joints.
        start: coordinates at the start (n,): x, y, θ, q of each part in turn.
        relations: gears.
        drives: inputs.
        size: a characteristic length, in metres.
        slices: where the coordinates of each part are.
    """

    parts: tuple[MovingPart, ...]
    joints: tuple[MechanismJoint, ...]
    start: Array
    relations: tuple[GearRelation, ...] = ()
    drives: tuple[JointDrive, ...] = ()
    size: float = 1.0
    slices: tuple[slice, ...] = field(init=False)
    _rigid: Array = field(init=False, repr=False)
    _elastic: tuple[tuple[MovingPart, slice], ...] = field(init=False, repr=False)
    _needed: frozenset[int] = field(init=False, repr=False)
    _moved: tuple[JointDrive, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Place the coordinates of the parts."""
        ends = [0, *np.cumsum([3 + part.size for part in self.parts]).tolist()]
        slices = tuple(slice(a, b) for a, b in zip(ends, ends[1:], strict=False))
        object.__setattr__(self, "slices", slices)
        rigid = np.zeros((ends[-1], ends[-1]))
        pairs = list(zip(self.parts, slices, strict=True))
        for part, at in pairs:
            if not part.size:
                rigid[at, at] = part.inertia(np.zeros(3), np.zeros(3)).mass
        elastic = tuple((part, at) for part, at in pairs if part.size)
        object.__setattr__(self, "_rigid", rigid)
        object.__setattr__(self, "_elastic", elastic)
        geared = [(relation.joint, relation.source) for relation in self.relations]
        needed = frozenset(drive.joint for drive in self.drives).union(*geared)
        object.__setattr__(self, "_needed", needed)
        moved = tuple(drive for drive in self.drives if not drive.moment)
        object.__setattr__(self, "_moved", moved)

    def inertia(self, p: Array, v: Array) -> tuple[Array, Array]:
        """Assemble the mass matrix (n, n) and the bias (n,).

        Args:
            p: coordinates (n,).
            v: their rates (n,).
        """
        mass, bias = self._rigid.copy(), np.zeros(len(p))
        for part, at in self._elastic:
            mass[at, at], bias[at] = part.inertia(p[at], v[at])
        return mass, bias

    def constraints(self, t: float, p: Array, v: Array) -> ConstraintRows:
        """Evaluate the constraints, and the positions of driven and geared joints.

        Args:
            t: time, in seconds.
            p: coordinates (n,).
            v: their rates (n,).
        """
        fixed = sum(3 if joint.kind == "fixed" else 2 for joint in self.joints)
        m = fixed + len(self.relations) + len(self._moved)
        constraints = ConstraintRows(
            np.zeros(m), np.zeros((m, len(p))), np.zeros(m), np.zeros(m), {}
        )
        k, at = 0, self.slices
        for j, joint in enumerate(self.joints):
            a, b = (
                _evaluate_point(joint.first, at, p, v),
                _evaluate_point(joint.second, at, p, v),
            )
            k = _add_joint(constraints, k, joint, a, b, v)
            if j in self._needed:
                constraints.positions[j] = _position_row(joint, a, b, v)
        for k, relation in enumerate(self.relations, fixed):
            x, y = constraints.positions[relation.joint], constraints.positions[relation.source]
            constraints.g[k] = x.value - relation.ratio * y.value
            constraints.rows[k] = x.row - relation.ratio * y.row
            constraints.gamma[k] = relation.ratio * y.bias - x.bias
        for k, drive in enumerate(self._moved, fixed + len(self.relations)):
            u, rate, acceleration = drive.profile(t)
            value, row, bias = constraints.positions[drive.joint]
            constraints.g[k], constraints.rows[k], constraints.rates[k] = value - u, row, -rate
            constraints.gamma[k] = acceleration - bias
        return constraints

    def accelerate(self, t: float, p: Array, v: Array) -> Dynamics:
        """Compute accelerations, multipliers, and the power of the drives.

        Args:
            t: time, in seconds.
            p: coordinates (n,).
            v: their rates (n,).
        """
        mass, bias = self.inertia(p, v)
        constraints = self.constraints(t, p, v)
        n, m = len(p), len(constraints.g)
        right = np.empty(n + m)
        right[:n], right[n:] = -bias, constraints.gamma
        power = 0.0
        for drive in self.drives:
            if drive.moment:
                moment, row = drive.profile(t)[0], constraints.positions[drive.joint].row
                right[:n] += moment * row
                power += moment * float(row @ v)
        solution = solve_bordered(mass, constraints.rows, right)
        power += float(solution[n:] @ constraints.rates)
        return Dynamics(solution[:n], solution[n:], power, mass, bias)

    def shake(self, t: float, p: Array, v: Array) -> Shaking:
        """Compute the shaking force and moment on the mount, and the energy.

        Args:
            t: time, in seconds.
            p: coordinates (n,).
            v: their rates (n,).
        """
        dynamics = self.accelerate(t, p, v)
        inertia = dynamics.mass @ dynamics.acceleration + dynamics.bias
        force, about, elastic = np.zeros(2), 0.0, 0.0
        for part, at in zip(self.parts, self.slices, strict=True):
            x, y = p[at][:2]
            fx, fy, moment = inertia[at][:3]
            force -= (fx, fy)
            about -= float(moment + x * fy - y * fx)
            q = p[at][3:]
            elastic += 0.5 * float(q @ part.stiffness @ q)
        energy = 0.5 * float(v @ dynamics.mass @ v) + elastic
        return Shaking(force, about, energy)

    def dissipation(self, v: Array) -> float:
        """Compute the power lost in damping, in W, at rates (n,)."""
        rates = ((part, v[at.start + 3 : at.stop]) for part, at in self._elastic)
        return sum(float(rate @ part.damping @ rate) for part, rate in rates)

    def locate(self, on: On, p: Array) -> Array:
        """Compute the position (2,) of a point in the plane.

        Args:
            p: coordinates (n,).
        """
        point = _evaluate_point(on, self.slices, p, np.zeros(len(p)))
        return np.array([point.x, point.y])

    def assemble(self, t: float, p: Array, v: Array) -> tuple[Array, Array]:
        """Move coordinates and rates onto the constraints, by the least change of momentum.

        Args:
            t: time, in seconds.
            p: coordinates near the constraints (n,).
            v: rates (n,).

        Raises:
            LinkageError: the constraints do not close.
        """
        limit = ASSEMBLED * max(self.size, 1e-6)
        for _ in range(MOST_NEWTON_STEPS):
            constraints = self.constraints(t, p, v)
            if np.abs(constraints.g).max(initial=0.0) < limit:
                break
            p = p - self._correction(p, v, constraints.rows, constraints.g)
        else:
            raise LinkageError("the flexible mechanism does not close; give other start values")
        return p, v - self._correction(
            p, v, constraints.rows, constraints.rows @ v + constraints.rates
        )

    def _correction(self, p: Array, v: Array, rows: Array, residual: Array) -> Array:
        """Solve G Δ = residual for the Δ of least mass-weighted size."""
        right = np.concatenate([np.zeros(len(p)), residual])
        return solve_bordered(self.inertia(p, v)[0], rows, right)[: len(p)]

    def check(self) -> None:
        """Refuse dependent constraints.

        Raises:
            LinkageError: the constraints at the start are dependent.
        """
        rows = self.constraints(0.0, self.start, np.zeros(len(self.start))).rows
        if not len(rows):
            return
        scaled = rows / np.maximum(np.linalg.norm(rows, axis=1), 1e-300)[:, None]
        values = np.linalg.svd(scaled, compute_uv=False)
        if len(rows) > rows.shape[1] or values[-1] < INDEPENDENT * values[0]:
            raise LinkageError(
                "constraints of the flexible mechanism depend on each other (an "
                "overconstrained linkage, or an input that others determine): leave out a "
                "joint or an input"
            )


def solve_bordered(mass: Array, rows: Array, right_side: Array) -> Array:
    """Solve [[M, Gᵀ], [G, 0]] x = right_side.

    Args:
        mass: M (n, n).
        rows: G (m, n).
        right_side: right side (n + m,).

    Raises:
        LinkageError: the matrix is singular: constraints depend on one another at this pose.
    """
    n, m = len(mass), len(rows)
    full = np.zeros((n + m, n + m))
    full[:n, :n], full[:n, n:], full[n:, :n] = mass, rows.T, rows
    try:
        return np.asarray(np.linalg.solve(full, right_side), np.float64)
    except np.linalg.LinAlgError:
        raise LinkageError(
            "the flexible mechanism reaches a singular pose, where its constraints depend on "
            "one another; give a shorter duration or another motion"
        ) from None


class _PointState(NamedTuple):
    """A point at a state; rows are over the coordinates of its part alone.

    Attributes:
        at: where these coordinates are.
        x, y: position in the plane.
        rows: derivatives of x and y; shape (2, 3 + n).
        ax, ay: acceleration without that of the coordinates.
        angle: direction of the marker.
        turn: its derivatives; shape (3 + n,).
    """

    at: slice
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


def _evaluate_point(on: On, slices: Sequence[slice], p: Array, v: Array) -> _PointState:
    """Evaluate a point at a state.

    Args:
        slices: where the coordinates of each part are.
        p: coordinates (n,).
        v: their rates (n,).
    """
    marker = on.marker
    if on.part < 0:
        x, y = marker.at.tolist()
        return _PointState(_NOWHERE, x, y, _NO_ROWS, 0.0, 0.0, 0.0, _NO_TURN)
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
        return _PointState(
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
    return _PointState(
        columns, x + rx, y + ry, rows, c * ax - s * ay, s * ax + c * ay, angle, turn
    )


def _add_joint(
    constraints: ConstraintRows,
    k: int,
    joint: MechanismJoint,
    a: _PointState,
    b: _PointState,
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
        constraints.rows[k : k + 2, b.at] += b.rows
        constraints.rows[k : k + 2, a.at] -= a.rows
        constraints.gamma[k], constraints.gamma[k + 1] = a.ax - b.ax, a.ay - b.ay
        k += 2
    if joint.kind != "revolute":
        constraints.g[k] = b.angle - a.angle - joint.angle
        constraints.rows[k, b.at] += b.turn
        constraints.rows[k, a.at] -= a.turn
        k += 1
    return k


def _position_row(joint: MechanismJoint, a: _PointState, b: _PointState, v: Array) -> Row:
    """Compute the position of a joint: an angle, or a distance along its axis.

    Args:
        a: its point on the first part.
        b: its point on the second part.
        v: rates of the coordinates (n,).
    """
    if joint.kind == "prismatic":
        return _slide(joint, a, b, v, across=False)
    row = np.zeros(len(v))
    row[b.at] += b.turn
    row[a.at] -= a.turn
    return Row(b.angle - a.angle - joint.angle, row, 0.0)


def _slide(
    joint: MechanismJoint, a: _PointState, b: _PointState, v: Array, across: bool
) -> Row:
    """Project the difference of two points on the axis of a slider, or across it."""
    c, s = math.cos(a.angle), math.sin(a.angle)
    ex, ey = joint.axis
    ex, ey = (-ey, ex) if across else (ex, ey)
    e = np.array([c * ex - s * ey, s * ex + c * ey])
    normal = np.array([-e[1], e[0]])
    apart = np.array([b.x - a.x, b.y - a.y])
    row = np.zeros(len(v))
    row[b.at] += e @ b.rows
    row[a.at] -= e @ a.rows
    row[a.at] += float(normal @ apart) * a.turn
    speed = b.rows @ v[b.at] - a.rows @ v[a.at]
    spin, value = float(a.turn @ v[a.at]), float(e @ apart)
    bias = e[0] * (b.ax - a.ax) + e[1] * (b.ay - a.ay)
    bias += 2.0 * spin * float(normal @ speed) - spin**2 * value
    return Row(value, row, float(bias))
