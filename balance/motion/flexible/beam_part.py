"""Moving parts of a planar mechanism: rigid ones, and beams in a floating frame.

A part has the coordinates x, y, θ of its frame in the plane, and elastic coordinates q. A point
of a beam at s lies, in the frame of the part, at

    l = [s + A(s) q - ½ qᵀ H(s) q,  N(s) q],    H(s) = ∫ N'ᵀ N' ds from the origin of the frame

so that a bent beam keeps its length to second order. Inertia forces follow from the points
of a Gauss quadrature by Lagrange's equations with this kinematics; centrifugal stiffening and
the stiffness due to axial forces need no further terms.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from kinematics.numerics.array_types import Array


class PartInertia(NamedTuple):
    """Inertia of a part at a state.

    Attributes:
        mass: mass matrix for x, y, θ, q; shape (3 + n, 3 + n).
        bias: inertia forces without acceleration, plus elastic and damping forces; (3 + n,).
    """

    mass: Array
    bias: Array


@dataclass(frozen=True, eq=False)
class Marker:
    """A point of a part, with a direction.

    Attributes:
        at: position (x, y) in the frame of the part without deformation; shape (2,).
        along: A, displacement along x per elastic coordinate; shape (n,).
        across: N, displacement along y; shape (n,).
        turn: rotation of the section; shape (n,).
        shortening: H, for the displacement -½ qᵀ H q along x; shape (n, n).
    """

    at: Array
    along: Array = field(default_factory=lambda: np.zeros(0))
    across: Array = field(default_factory=lambda: np.zeros(0))
    turn: Array = field(default_factory=lambda: np.zeros(0))
    shortening: Array = field(default_factory=lambda: np.zeros((0, 0)))


def mean_marker(markers: Sequence[Marker], weights: Sequence[float]) -> Marker:
    """Combine points of one part by a whippletree: a weighted mean of their positions.

    Args:
        weights: their weights; they are scaled to sum 1.
    """
    w = np.asarray(weights, dtype=float) / np.sum(weights)

    def mean(name: str) -> Array:
        return np.tensordot(w, np.array([getattr(marker, name) for marker in markers]), 1)

    return Marker(*(mean(name) for name in ("at", "along", "across", "turn", "shortening")))


class MovingPart(Protocol):
    """What a mechanism needs of a part."""

    @property
    def name(self) -> str:
        """Name of the part, for tables."""

    @property
    def size(self) -> int:
        """Number of elastic coordinates."""

    @property
    def stiffness(self) -> Array:
        """Stiffness matrix of the elastic coordinates (n, n)."""

    @property
    def damping(self) -> Array:
        """Damping matrix of the elastic coordinates (n, n)."""

    def inertia(self, position: Array, velocity: Array) -> PartInertia:
        """Compute mass matrix and bias.

        Args:
            position: coordinates (3 + n,).
            velocity: their rates (3 + n,).
        """


@dataclass(frozen=True, eq=False)
class RigidPart:
    """A rigid part; the origin of its frame is its centre of mass.

    Attributes:
        name: for tables.
        mass: in kg; 0 is allowed where constraints hold the part.
        moment: moment of inertia about the centre of mass, in kg m².
    """

    name: str
    mass: float
    moment: float

    @property
    def size(self) -> int:
        """Number of elastic coordinates: none."""
        return 0

    @property
    def stiffness(self) -> Array:
        """Stiffness matrix (0, 0)."""
        return np.zeros((0, 0))

    @property
    def damping(self) -> Array:
        """Damping matrix (0, 0)."""
        return np.zeros((0, 0))

    def inertia(self, position: Array, velocity: Array) -> PartInertia:
        """Compute mass matrix (3, 3) and bias (3,), which is zero.

        Args:
            position: coordinates (3,).
            velocity: their rates (3,).
        """
        mass = np.zeros((3, 3))
        mass[0, 0] = mass[1, 1] = self.mass
        mass[2, 2] = self.moment
        return PartInertia(mass, np.zeros(3))


@dataclass(frozen=True, eq=False)
class BeamPart:
    """A beam, with bodies fixed to it, as points with mass.

    Attributes:
        name: for tables.
        points: the points; all with n elastic coordinates.
        masses: of the points, in kg; shape (p,).
        moments: rotary inertia of the points, in kg m²; shape (p,).
        stiffness: of the elastic coordinates; shape (n, n).
        damping: shape (n, n).
        outline: points for drawing, from end to end.
        length: of the beam, in metres.
    """

    name: str
    points: tuple[Marker, ...]
    masses: Array
    moments: Array
    stiffness: Array
    damping: Array
    outline: tuple[Marker, ...] = ()
    length: float = 0.0

    def __post_init__(self) -> None:
        """Collect the constant arrays of the quadrature."""
        along = np.array([point.along for point in self.points])
        across = np.array([point.across for point in self.points])
        turn = np.array([point.turn for point in self.points])
        shortening = np.array([point.shortening for point in self.points])
        m, j = self.masses, self.moments
        constant = {
            "_at": np.array([point.at[0] for point in self.points]),
            "_along": along,
            "_across": across,
            "_total": float(m.sum()),
            "_shortening": shortening.reshape(-1, self.size),
            "_qq": across.T @ (m[:, None] * across) + turn.T @ (j[:, None] * turn),
            "_yq": m @ across,
            "_spin": j @ turn,
            "_moment": float(j.sum()),
            "_curved": bool(np.any(shortening)),
        }
        for name, value in constant.items():
            object.__setattr__(self, name, value)

    @property
    def size(self) -> int:
        """Number of elastic coordinates."""
        return len(self.stiffness)

    def inertia(self, position: Array, velocity: Array) -> PartInertia:
        """Compute mass matrix and bias.

        Args:
            position: coordinates (3 + n,).
            velocity: their rates (3 + n,).
        """
        q, rate, spin = position[3:], velocity[3:], velocity[2]
        m, n = self.masses, self.size
        along, x, squared = self._deform(q, rate)
        y = self._across @ q
        x_rate, y_rate = along @ rate, self._across @ rate
        ax = -(spin**2) * x - 2.0 * spin * y_rate - squared
        ay = -(spin**2) * y + 2.0 * spin * x_rate
        mx, my = m * x, m * y
        mass = np.empty((3 + n, 3 + n))
        c, s = math.cos(position[2]), math.sin(position[2])
        mass[:2, :2] = ((self._total, 0.0), (0.0, self._total))
        x0, y0, xq = mx.sum(), my.sum(), m @ along
        mass[0, 2], mass[1, 2] = -c * y0 - s * x0, c * x0 - s * y0
        mass[0, 3:], mass[1, 3:] = c * xq - s * self._yq, s * xq + c * self._yq
        mass[2, 2] = mx @ x + my @ y + self._moment
        mass[2, 3:] = mx @ self._across - my @ along + self._spin
        mass[3:, 3:] = along.T @ (m[:, None] * along) + self._qq
        mass[2:, :2] = mass[:2, 2:].T
        mass[3:, 2] = mass[2, 3:]
        bias = np.empty(3 + n)
        fx, fy = m @ ax, m @ ay
        bias[0], bias[1] = c * fx - s * fy, s * fx + c * fy
        bias[2] = mx @ ay - my @ ax
        bias[3:] = (m * ax) @ along + (m * ay) @ self._across + self.stiffness @ q
        bias[3:] += self.damping @ rate
        return PartInertia(mass, bias)

    def _deform(self, q: Array, rate: Array) -> tuple[Array, Array, Array]:
        """Compute A - qᵀ H (p, n), x (p,) and q̇ᵀ H q̇ (p,) of the points."""
        if not self._curved:
            x = self._at + self._along @ q
            return self._along, x, np.zeros(len(x))
        both = (self._shortening @ np.column_stack([q, rate])).reshape(-1, self.size, 2)
        bent = both[:, :, 0]
        x = self._at + self._along @ q - 0.5 * (bent @ q)
        return self._along - bent, x, both[:, :, 1] @ rate

    _at: Array = field(init=False, repr=False)
    _along: Array = field(init=False, repr=False)
    _across: Array = field(init=False, repr=False)
    _total: float = field(init=False, repr=False)
    _shortening: Array = field(init=False, repr=False)
    _qq: Array = field(init=False, repr=False)
    _yq: Array = field(init=False, repr=False)
    _spin: Array = field(init=False, repr=False)
    _moment: float = field(init=False, repr=False)
    _curved: bool = field(init=False, repr=False)
