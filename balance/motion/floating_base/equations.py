"""Equations of motion of a linkage on a base that floats, for a solver of initial values.

The state holds the pose of the base, the rates β of its freedoms, the coordinates y of the
inputs and their rates (if they are free), the impulse of the springs and the work of the
drives. Impulse and work are integrated beside the motion, for the check that

    momentum - impulse        kinetic energy + energy in the springs - work

are constant.

The coordinates x are an angle and a displacement in the axes of the plane (3,), or a quaternion
and a displacement (7,). With the twist ``S β = [ω; v]`` of the base in its own coordinates

    Ṙ = R ω̂        ṗ = R v.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from balance.motion.floating_base.base import BaseInChain
from balance.motion.floating_base.dynamics import CarriedBodies, MovingBodies, cross_products
from balance.motion.floating_base.pose_follower import PoseFollower
from balance.motion.verification.input_paths import InputPath
from kinematics.numerics.array_types import Array


@dataclass(frozen=True, eq=False)
class Drive:
    """How the inputs move; in units of the chain.

    Attributes:
        basis: inputs for unit values of the coordinates (mobility, w).
        units: SI units per unit of each input (mobility,).
        path: prescribed motion of the inputs, SI units; None if they are free.
        torques: constant torques on free coordinates (w,).
    """

    basis: Array
    units: Array
    path: InputPath | None
    torques: Array

    @property
    def free(self) -> int:
        """Number of coordinates whose motion is not prescribed."""
        return 0 if self.path is not None else self.basis.shape[1]

    def prescribed(self, time: float) -> tuple[Array, Array, Array]:
        """Compute prescribed inputs (mobility,) and two derivatives, chain units."""
        assert self.path is not None
        u, ud, udd = (x[0] / self.units for x in self.path.at(np.array([time])))
        return u, ud, udd


class BaseState(NamedTuple):
    """Everything at one time.

    Attributes:
        placement: pose of the base.
        b: twist of the base in its own coordinates (6,).
        u: inputs (mobility,), chain units.
        rates: rates of the coordinates (w,).
        accelerations: their prescribed accelerations (w,); 0 if they are free.
        bodies: the bodies of the linkage.
        impulse: of the springs on the freedoms of the base (3 or 6,).
        work: of the drives.
    """

    placement: _Placement
    b: Array
    u: Array
    rates: Array
    accelerations: Array
    bodies: MovingBodies
    impulse: Array
    work: float


class BaseEquations:
    """The equations of motion as a function of time and state."""

    def __init__(
        self, base: BaseInChain, bodies: CarriedBodies, follower: PoseFollower, drive: Drive
    ) -> None:
        """Lay out the state.

        Args:
            bodies: the bodies of the linkage.
            drive: how the inputs move.
        """
        self.base, self.drive, self.evaluations = base, drive, 0
        self._bodies, self.follower = bodies, follower
        freedoms = base.freedoms.shape[1]
        sizes = [_pose_size(base), freedoms, drive.free, drive.free, freedoms, 1]
        ends = np.cumsum([0, *sizes]).tolist()
        self._parts = list(pairwise(ends))
        # Twist of the base and rates of the coordinates, from those that are unknown.
        self._unknown = np.zeros((6 + drive.basis.shape[1], freedoms + drive.free))
        self._unknown[:6, :freedoms] = base.freedoms
        self._unknown[6:, freedoms:] = np.eye(drive.basis.shape[1], drive.free)

    @property
    def mass(self) -> float:
        """Mass of the linkage without its base, kg."""
        return self._bodies.mass

    def start(self, beta: Array, rates: Array) -> Array:
        """Return the state at the start.

        Args:
            beta: rates of the freedoms of the base (3 or 6,).
            rates: rates of free coordinates (w,); none if they are prescribed.
        """
        y, integrals = np.zeros(self.drive.free), np.zeros(beta.size + 1)
        return np.concatenate([_start_pose(self.base), beta, y, rates, integrals])

    def tolerances(self, relative: float, speed: float, share: float) -> Array:
        """Return absolute tolerances of the state, for a typical speed in chain units.

        Args:
            speed: typical speed of the bodies.
            share: mass of the linkage over that of linkage and base: a heavy base moves less.
        """
        mass, free = self.mass, self.drive.free
        freedoms = self.base.freedoms.shape[1]
        sizes = (
            [1.0] * _pose_size(self.base)
            + [share * speed] * freedoms
            + [1.0] * free
            + [speed] * free
            + [mass * speed] * freedoms
            + [mass * speed**2]
        )
        return relative * np.array(sizes)

    def _split(self, state: Array) -> list[Array]:
        """Split a state into its parts."""
        return [state[first:last] for first, last in self._parts]

    def rates_of_base(self, states: Array) -> Array:
        """Extract the rates of the freedoms of the base (N, 3 or 6) from states (N, size)."""
        first, last = self._parts[1]
        return states[:, first:last]

    def read(self, time: float, state: Array) -> BaseState:
        """Compute poses and twists of a state.

        Args:
            time: seconds.
            state: as of `start`.

        Raises:
            PoseError: the loops cannot be closed.
        """
        x, beta, y, rates, impulse, work = self._split(state)
        if self.drive.path is None:
            u, change = self.drive.basis @ y, np.zeros(y.size)
        else:
            u, rates, change = self.drive.prescribed(time)
        bodies = self._bodies.at(self.follower.at(u), rates)
        placement, b = _place_base(self.base, x), self.base.freedoms @ beta
        return BaseState(placement, b, u, rates, change, bodies, impulse, float(work[0]))

    def __call__(self, time: float, state: Array) -> Array:
        """Compute the rate of the state."""
        self.evaluations += 1
        now = self.read(time, state)
        base, drive, G = self.base, self.drive, self._unknown
        wrench = now.placement.spring_wrench(base)
        M, bias = now.bodies.mass_matrix(base), now.bodies.bias(base, now.b)
        bias += M[:, 6:] @ now.accelerations
        load = -bias
        load[:6] += wrench
        load[6:] += drive.torques
        change = np.linalg.solve(G.T @ M @ G, G.T @ load)
        freedoms = base.freedoms.shape[1]
        # The drives carry what is left of the inertia forces of the coordinates.
        torques = bias[6:] + M[6:] @ (G @ change)
        x, beta, *_ = self._split(state)
        impulse = base.freedoms.T @ now.placement.wrench_to_inertial(wrench)
        own_rates = now.rates if drive.free else now.rates[:0]
        return np.concatenate(
            [
                _pose_rate(base, x, now.placement.R, beta),
                change[:freedoms],
                own_rates,
                change[freedoms:],
                impulse,
                [torques @ now.rates],
            ]
        )


class _Placement(NamedTuple):
    """The base at a time; displacements in units of the chain.

    Attributes:
        R: rotation from its axes to inertial axes (3, 3).
        p: displacement of the origin of the chain (3,), in inertial axes.
        rotation: rotation vector (3,), radians; the angle counts full turns in a plane.
    """

    R: Array
    p: Array
    rotation: Array

    def wrench_to_inertial(self, wrench: Array) -> Array:
        """Convert ``[moment; force]`` (6,) of the base to inertial axes and origin."""
        force = self.R @ wrench[3:]
        return np.concatenate([self.R @ wrench[:3] + cross_products(self.p, force), force])

    def moved(self, point: Array) -> Array:
        """Compute the displacement (3,) of a point of the base, inertial axes."""
        return self.R @ point + self.p - point

    def spring_wrench(self, base: BaseInChain) -> Array:
        """Compute the wrench of the springs on the base (6,), in its coordinates."""
        if not (base.stiffness or base.turning_stiffness):
            return np.zeros(6)
        force = -base.stiffness * self.R.T @ self.moved(base.com)
        # The rotation vector has the same components in both axes.
        moment = cross_products(base.com, force) - base.turning_stiffness * self.rotation
        return np.concatenate([moment, force])

    def spring_energy(self, base: BaseInChain) -> float:
        """Compute the energy in the springs."""
        moved, turned = self.moved(base.com), self.rotation
        return 0.5 * float(
            base.stiffness * moved @ moved + base.turning_stiffness * turned @ turned
        )


def _pose_size(base: BaseInChain) -> int:
    """Count the coordinates of a pose: 3 in a plane, 7 in space."""
    return 3 if base.planar else 7


def _start_pose(base: BaseInChain) -> Array:
    """Return the coordinates of the pose at the start (3 or 7,)."""
    x = np.zeros(_pose_size(base))
    if not base.planar:
        x[0] = 1.0
    return x


def _place_base(base: BaseInChain, x: Array) -> _Placement:
    """Compute the pose at coordinates.

    Args:
        x: coordinates (3 or 7,).
    """
    if base.planar:
        n, plane = base.freedoms[:3, 0], base.freedoms[3:, 1:]
        c, sine = np.cos(x[0]), np.sin(x[0])
        R = np.outer(n, n) + plane @ np.array([[c, -sine], [sine, c]]) @ plane.T
        return _Placement(R, plane @ x[1:], x[0] * n)
    a, *v = (x[:4] / np.sqrt(x[:4] @ x[:4])).tolist()
    i, j, k = v
    R = np.array(
        [
            [1.0 - 2.0 * (j * j + k * k), 2.0 * (i * j - a * k), 2.0 * (i * k + a * j)],
            [2.0 * (i * j + a * k), 1.0 - 2.0 * (i * i + k * k), 2.0 * (j * k - a * i)],
            [2.0 * (i * k - a * j), 2.0 * (j * k + a * i), 1.0 - 2.0 * (i * i + j * j)],
        ]
    )
    return _Placement(R, x[4:], _rotation_vector(a, np.array(v)))


def _rotation_vector(a: float, v: Array) -> Array:
    """Compute the rotation vector, of at most half a turn, of a unit quaternion [a; v]."""
    if a < 0.0:
        a, v = -a, -v
    sine = float(np.sqrt(v @ v))
    # sin x / x is 1 to round-off below this size.
    return 2.0 * v if sine < 1e-9 else (2.0 * np.arctan2(sine, a) / sine) * v


def _pose_rate(base: BaseInChain, x: Array, R: Array, beta: Array) -> Array:
    """Compute the rates of the coordinates of a pose.

    Args:
        x: coordinates (3 or 7,).
        R: rotation there (3, 3).
        beta: rates of the freedoms of the base (3 or 6,).
    """
    b = base.freedoms @ beta
    moved = R @ b[3:]
    if base.planar:
        return np.concatenate([beta[:1], moved @ base.freedoms[3:, 1:]])
    a, v, omega = x[0], x[1:4], b[:3]
    turned = 0.5 * (a * omega + cross_products(v, omega))
    return np.concatenate([[-0.5 * (v @ omega)], turned, moved])
