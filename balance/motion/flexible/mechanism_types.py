"""Joints, inputs and results of planar mechanisms, as data."""

from __future__ import annotations

from typing import NamedTuple

from balance.motion.flexible.beam_part import Marker
from balance.motion.flexible.drives import Profile
from kinematics.numerics.array_types import Array


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


class GearRelation(NamedTuple):
    """A gear: the position of one joint is ``ratio`` times that of another.

    Attributes:
        joint: index of the joint that follows.
        source: index of the joint that it follows.
        ratio: of their positions.
    """

    joint: int
    source: int
    ratio: float


class JointDrive(NamedTuple):
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


class ConstraintRows(NamedTuple):
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
