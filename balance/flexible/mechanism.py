"""Planar mechanisms of rigid and flexible parts: constraints, equations of motion, shaking.

With coordinates p of all parts, constraints g(p, t) = 0 and G = ∂g/∂p, the accelerations and
multipliers solve

    [M  Gᵀ] [a]   [Q - h]
    [G  0 ] [λ] = [  γ  ],      γ = -Ġ ṗ + ∂²g/∂t²

The shaking force and moment are the reverse of the rate of change of the momentum.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.flexible.beam_part import Marker, MovingPart
from balance.flexible.drives import Profile
from kinematics.errors import LinkageError

__all__ = [
    "Constraints", "Drive", "Dynamics", "MechanismJoint", "On", "PlanarMechanism", "Relation",
    "Row", "Shaking",
]  # fmt: skip

Array = NDArray[np.float64]

MOST_NEWTON_STEPS = 30
ASSEMBLED = 1e-12
"""Largest residual of constraints, over the size of the mechanism, after assembly."""
INDEPENDENT = 1e-11
"""Least singular value, over the largest, of constraints that count as independent."""


class On(NamedTuple):
    """A point on a part.

    Attributes:
        part: index of the part; -1 is the ground.
        marker: the point, in the frame of the part; on the ground, in the plane.
    """

    part: int
    marker: Marker


class MechanismJoint(NamedTuple):
    """A joint between two points.

    Attributes:
        name: for tables.
        kind: ``"revolute"``, ``"prismatic"`` or ``"fixed"``.
        first: point on the part before it.
        second: point on the part after it.
        axis: direction of sliding, a unit vector in the frame of the first part.
        angle: of the second part relative to the first at the start, in radians.
    """

    name: str
    kind: str
    first: On
    second: On
    axis: tuple[float, float] = (1.0, 0.0)
    angle: float = 0.0


class Relation(NamedTuple):
    """A gear: the position of one joint is ``ratio`` times that of another.

    Attributes:
        joint: index of the joint that follows.
        source: index of the joint that it follows.
        ratio: of their positions.
    """

    joint: int
    source: int
    ratio: float


class Drive(NamedTuple):
    """An input.

    Attributes:
        joint: index of the driven joint.
        profile: its motion, or the moment (force, if prismatic) on it, over time.
        moment: whether the profile is a moment.
    """

    joint: int
    profile: Profile
    moment: bool = False


class Row(NamedTuple):
    """A function of the coordinates.

    Attributes:
        value: in rad or m.
        row: derivatives by the coordinates; shape (n,).
        bias: its acceleration without that of the coordinates.
    """

    value: float
    row: Array
    bias: float


class Constraints(NamedTuple):
    """Constraints at a state.

    Attributes:
        g: residuals; shape (m,).
        rows: derivatives G by the coordinates; shape (m, n).
        rates: ∂g/∂t; shape (m,).
        gamma: what G a must be; shape (m,).
        positions: of the joints that are driven or geared, by index.
    """

    g: Array
    rows: Array
    rates: Array
    gamma: Array
    positions: dict[int, Row]


class Dynamics(NamedTuple):
    """Accelerations at a state.

    Attributes:
        acceleration: of the coordinates; shape (n,).
        multipliers: of the constraints; shape (m,).
        power: of the drives, in W.
        mass: mass matrix; shape (n, n).
        bias: inertia forces without acceleration, and elastic forces; shape (n,).
    """

    acceleration: Array
    multipliers: Array
    power: float
    mass: Array
    bias: Array


class Shaking(NamedTuple):
    """Shaking at a state.

    Attributes:
        force: on the mount, in N; shape (2,).
        moment: on the mount about the origin, in N m.
        energy: kinetic and elastic, in J.
    """

    force: Array
    moment: float
    energy: float


class _Point(NamedTuple):
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
    relations: tuple[Relation, ...] = ()
    drives: tuple[Drive, ...] = ()
    size: float = 1.0
    slices: tuple[slice, ...] = field(init=False)
    _rigid: Array = field(init=False, repr=False)
    _elastic: tuple[tuple[MovingPart, slice], ...] = field(init=False, repr=False)
    _needed: frozenset[int] = field(init=False, repr=False)
    _moved: tuple[Drive, ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Place the coordinates of the parts."""
        ends = [0, *np.cumsum([3 + part.size for part in self.parts]).tolist()]
        found = tuple(slice(a, b) for a, b in zip(ends, ends[1:], strict=False))
        object.__setattr__(self, "slices", found)
        rigid = np.zeros((ends[-1], ends[-1]))
        pairs = list(zip(self.parts, found, strict=True))
        for part, at in pairs:
            if not part.size:
                rigid[at, at] = part.inertia(np.zeros(3), np.zeros(3)).mass
        elastic = tuple((part, at) for part, at in pairs if part.size)
        object.__setattr__(self, "_rigid", rigid)
        object.__setattr__(self, "_elastic", elastic)
        geared = [(one.joint, one.source) for one in self.relations]
        needed = frozenset(one.joint for one in self.drives).union(*geared)
        object.__setattr__(self, "_needed", needed)
        moved = tuple(one for one in self.drives if not one.moment)
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

    def constraints(self, t: float, p: Array, v: Array) -> Constraints:
        """Evaluate the constraints, and the positions of driven and geared joints.

        Args:
            t: time, in seconds.
            p: coordinates (n,).
            v: their rates (n,).
        """
        fixed = sum(3 if one.kind == "fixed" else 2 for one in self.joints)
        m = fixed + len(self.relations) + len(self._moved)
        found = Constraints(np.zeros(m), np.zeros((m, len(p))), np.zeros(m), np.zeros(m), {})
        k = 0
        for j, joint in enumerate(self.joints):
            a, b = self._point(joint.first, p, v), self._point(joint.second, p, v)
            k = _add_joint(found, k, joint, a, b, v)
            if j in self._needed:
                found.positions[j] = _position(joint, a, b, v)
        for k, one in enumerate(self.relations, fixed):
            x, y = found.positions[one.joint], found.positions[one.source]
            found.g[k] = x.value - one.ratio * y.value
            found.rows[k] = x.row - one.ratio * y.row
            found.gamma[k] = one.ratio * y.bias - x.bias
        for k, drive in enumerate(self._moved, fixed + len(self.relations)):
            u, rate, acceleration = drive.profile(t)
            value, row, bias = found.positions[drive.joint]
            found.g[k], found.rows[k], found.rates[k] = value - u, row, -rate
            found.gamma[k] = acceleration - bias
        return found

    def accelerate(self, t: float, p: Array, v: Array) -> Dynamics:
        """Compute accelerations, multipliers, and the power of the drives.

        Args:
            t: time, in seconds.
            p: coordinates (n,).
            v: their rates (n,).
        """
        mass, bias = self.inertia(p, v)
        found = self.constraints(t, p, v)
        n, m = len(p), len(found.g)
        right = np.empty(n + m)
        right[:n], right[n:] = -bias, found.gamma
        power = 0.0
        for drive in self.drives:
            if drive.moment:
                moment, row = drive.profile(t)[0], found.positions[drive.joint].row
                right[:n] += moment * row
                power += moment * float(row @ v)
        solution = np.linalg.solve(_bordered(mass, found.rows), right)
        power += float(solution[n:] @ found.rates)
        return Dynamics(solution[:n], solution[n:], power, mass, bias)

    def shake(self, t: float, p: Array, v: Array) -> Shaking:
        """Compute the shaking force and moment on the mount, and the energy.

        Args:
            t: time, in seconds.
            p: coordinates (n,).
            v: their rates (n,).
        """
        found = self.accelerate(t, p, v)
        inertia = found.mass @ found.acceleration + found.bias
        force, about, elastic = np.zeros(2), 0.0, 0.0
        for part, at in zip(self.parts, self.slices, strict=True):
            x, y = p[at][:2]
            fx, fy, moment = inertia[at][:3]
            force -= (fx, fy)
            about -= float(moment + x * fy - y * fx)
            q = p[at][3:]
            elastic += 0.5 * float(q @ part.stiffness @ q)
        energy = 0.5 * float(v @ found.mass @ v) + elastic
        return Shaking(force, about, energy)

    def dissipation(self, v: Array) -> float:
        """Compute the power lost in damping, in W, at rates (n,)."""
        rates = ((part, v[at.start + 3 : at.stop]) for part, at in self._elastic)
        return sum(float(rate @ part.damping @ rate) for part, rate in rates)

    def locate(self, on: On, p: Array) -> Array:
        """Compute the position (2,) of a point in the plane.

        Args:
            on: the point.
            p: coordinates (n,).
        """
        found = self._point(on, p, np.zeros(len(p)))
        return np.array([found.x, found.y])

    def joint_position(self, joint: int, p: Array) -> float:
        """Compute the position of a joint, in rad or m, from the start.

        Args:
            joint: index of the joint.
            p: coordinates (n,).
        """
        one, rest = self.joints[joint], np.zeros(len(p))
        a, b = self._point(one.first, p, rest), self._point(one.second, p, rest)
        return _position(one, a, b, rest).value

    def _point(self, on: On, p: Array, v: Array) -> _Point:
        """Evaluate a point at a state."""
        marker = on.marker
        if on.part < 0:
            x, y = marker.at.tolist()
            return _Point(_NOWHERE, x, y, _NO_ROWS, 0.0, 0.0, 0.0, _NO_TURN)
        own = self.slices[on.part]
        k = own.start
        x, y, angle = p[k : k + 3].tolist()
        spin = v[k + 2].item()
        c, s = math.cos(angle), math.sin(angle)
        lx, ly = marker.at.tolist()
        if own.stop == k + 3:
            rx, ry = c * lx - s * ly, s * lx + c * ly
            rows = np.array([[1.0, 0.0, -ry], [0.0, 1.0, rx]])
            two = spin * spin
            return _Point(own, x + rx, y + ry, rows, -two * rx, -two * ry, angle, _RIGID_TURN)
        q, dq = p[k + 3 : own.stop], v[k + 3 : own.stop]
        bent = marker.shortening @ q
        along = marker.along - bent
        lx += (marker.along @ q - 0.5 * (bent @ q)).item()
        ly += (marker.across @ q).item()
        ax = -(spin**2) * lx - 2.0 * spin * (marker.across @ dq).item()
        ax -= (dq @ (marker.shortening @ dq)).item()
        ay = -(spin**2) * ly + 2.0 * spin * (along @ dq).item()
        rx, ry = c * lx - s * ly, s * lx + c * ly
        rows = np.empty((2, own.stop - k))
        rows[:, :3] = ((1.0, 0.0, -ry), (0.0, 1.0, rx))
        rows[0, 3:] = c * along - s * marker.across
        rows[1, 3:] = s * along + c * marker.across
        turn = np.concatenate([_RIGID_TURN, marker.turn])
        angle += (marker.turn @ q).item()
        return _Point(own, x + rx, y + ry, rows, c * ax - s * ay, s * ax + c * ay, angle, turn)

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
            found = self.constraints(t, p, v)
            if np.abs(found.g).max(initial=0.0) < limit:
                break
            p = p - self._correction(p, v, found.rows, found.g)
        else:
            raise LinkageError("the flexible mechanism does not close; give other start values")
        return p, v - self._correction(p, v, found.rows, found.rows @ v + found.rates)

    def _correction(self, p: Array, v: Array, rows: Array, residual: Array) -> Array:
        """Solve G Δ = residual for the Δ of least mass-weighted size."""
        full = _bordered(self.inertia(p, v)[0], rows)
        right = np.concatenate([np.zeros(len(p)), residual])
        return np.asarray(np.linalg.solve(full, right)[: len(p)])

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


def _bordered(mass: Array, rows: Array) -> Array:
    """Compose the matrix [[M, Gᵀ], [G, 0]]."""
    n, m = len(mass), len(rows)
    full = np.zeros((n + m, n + m))
    full[:n, :n], full[:n, n:], full[n:, :n] = mass, rows.T, rows
    return full


def _add_joint(
    found: Constraints, k: int, joint: MechanismJoint, a: _Point, b: _Point, v: Array
) -> int:
    """Write the constraints of a joint from row k on; return the next row."""
    if joint.kind == "prismatic":
        value, row, bias = _slide(joint, a, b, v, across=True)
        found.g[k], found.rows[k], found.gamma[k] = value, row, -bias
        k += 1
    else:
        found.g[k], found.g[k + 1] = b.x - a.x, b.y - a.y
        found.rows[k : k + 2, b.own] += b.rows
        found.rows[k : k + 2, a.own] -= a.rows
        found.gamma[k], found.gamma[k + 1] = a.ax - b.ax, a.ay - b.ay
        k += 2
    if joint.kind != "revolute":
        found.g[k] = b.angle - a.angle - joint.angle
        found.rows[k, b.own] += b.turn
        found.rows[k, a.own] -= a.turn
        k += 1
    return k


def _position(joint: MechanismJoint, a: _Point, b: _Point, v: Array) -> Row:
    """Compute the position of a joint: an angle, or a distance along its axis."""
    if joint.kind == "prismatic":
        return _slide(joint, a, b, v, across=False)
    row = np.zeros(len(v))
    row[b.own] += b.turn
    row[a.own] -= a.turn
    return Row(b.angle - a.angle - joint.angle, row, 0.0)


def _slide(joint: MechanismJoint, a: _Point, b: _Point, v: Array, across: bool) -> Row:
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
