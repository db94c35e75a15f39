"""The equations of a path that leaves the base at rest, ``A(q) u̇ = 0``, and their derivatives.

Column w of ``M_B = [ξ; p]`` is the momentum for a unit rate of input w. The rows A are a part
of it; see `Demand`. Relations of the inputs ``u = basis y`` leave the coordinates y, scaled so
that the columns of the basis are orthonormal in radians and characteristic lengths. Derivatives
are those of the momentum series (`balance.space.momentum.regressor`) along each coordinate:

    ∂_i A_w = [ξ; p]_1,        ∂_i (ξ - c × p) = ξ_1 - c × p_1 - (p_i / m) × p_w

with the centre of mass c, which moves with ``p_i / m``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.motion.paths.demand import Demand
from balance.motion.pose.momentum_of_masses import MassedChain
from balance.motion.verification.trajectory import loop_pivot, order_inputs
from balance.space.momentum.regressor import RegressorSeries
from kinematics.closure.newton import Pose, expand_at, forward_kinematics, solve_positions
from kinematics.closure.series import expand_from
from kinematics.errors import LinkageError, PoseError
from kinematics.model.linkage import Linkage
from kinematics.model.motion import Motion
from kinematics.model.spatial.screws import skew
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.pivoted_qr import round_off
from kinematics.numerics.tolerances import FOLLOWED_POSE_RESIDUAL


class RowsAtPose(NamedTuple):
    """The equations at a closed pose, in the units of the chain.

    Attributes:
        q: positions of all joints (n,).
        rates: rates of all joints per unit rate of the coordinates (n, w).
        rows: A (rows, w).
        scale: size of the momenta of the bodies that add up to A.
        conditioning: smallest pivot of the loop matrix over the one at the reference pose.
    """

    q: Array
    rates: Array
    rows: Array
    scale: float
    conditioning: float


class RestEquations:
    """The equations of a linkage, at any pose."""

    def __init__(self, linkage: Linkage, demand: Demand, motion: Motion | None = None) -> None:
        """Prepare a linkage.

        Raises:
            UsageError: the demand contradicts itself.
            LinkageError: nothing has a mass, or nothing moves.
            MotionError: the motion has other inputs.
        """
        demand.check()
        self.linkage, self.demand = linkage, demand
        self.model = MassedChain.of(linkage)
        self.chain = self.model.chain
        if not self.model.z.any():
            raise LinkageError(
                f"{linkage.source}: no moving link has a mass; give the links that move an "
                "<inertial>"
            )
        units = self.chain.units[linkage.positions_of(linkage.inputs)]
        basis = np.eye(units.size) if motion is None else order_inputs(motion, linkage)
        self.basis: Array = np.linalg.qr(basis / units[:, None])[0]
        self.units: Array = units
        self.centre = self._moment_centre()
        self._pivot = loop_pivot(self.chain, self.chain.screws)
        self.round_off = round_off(self.chain.frame.origin, self.chain.frame.length)

    @property
    def width(self) -> int:
        """Number of coordinates."""
        return self.basis.shape[1]

    def _moment_centre(self) -> Array:
        """Return the point of the moment, or the base's centre of mass, in chain units."""
        frame, base = self.chain.frame, self.demand.base
        point = np.array(base.com if base is not None else self.demand.about or np.zeros(3))
        return np.asarray((point - frame.origin) / frame.length)

    def close(self, q: Array) -> Array:
        """Close the loops from joint positions nearby; the inputs stay.

        Args:
            q: positions of all joints (n,), chain units.

        Raises:
            PoseError: the loops do not close there.
        """
        if self.chain.dependent.size == 0:
            return q
        positions, error = solve_positions(self.chain, q)
        if not error <= FOLLOWED_POSE_RESIDUAL:
            raise PoseError(f"{self.linkage.source}: the loops cannot be closed")
        return positions

    def move(self, start: RowsAtPose, step: Array) -> Array:
        """Close the loops a short displacement of the coordinates away; see `close`.

        Args:
            step: displacement of the coordinates (w,).
        """
        inputs = self.linkage.positions_of(self.linkage.inputs)
        q = start.q + start.rates @ step
        q[inputs] = start.q[inputs] + self.basis @ step
        return self.close(q)

    def at(self, q: Array) -> RowsAtPose:
        """Compute the equations at a closed pose.

        Args:
            q: positions of all joints (n,), chain units.
        """
        M, magnitudes = (matrices[0] for matrices in self.model.momenta(q[None]))
        pose = forward_kinematics(self.chain, q)
        C = expand_at(self.chain, pose).C[0, 0]
        pivot = loop_pivot(self.chain, pose.screws) / self._pivot
        centre = self._centre_at(pose)
        sizes = self._select_sizes(magnitudes @ np.abs(self.basis), centre)
        return RowsAtPose(
            q,
            C @ self.basis,
            self._select(M @ self.basis, centre),
            float(np.linalg.norm(sizes)),
            pivot,
        )

    def along(self, q: Array, rates: Array) -> tuple[Array, Array]:
        """Compute the equations at many closed poses, and the sizes of momenta at rates there.

        Args:
            q: positions of all joints (N, n), chain units.
            rates: rates of the inputs (N, mobility), chain units.

        Returns:
            A (N, rows, w); and the sum of the sizes of the momenta of the bodies (N,).
        """
        bodies = self.model.body_momenta(q)
        M = bodies.sum(axis=3) @ self.basis
        if self.demand.kept == "attitude":
            centres = [self._centre_at(forward_kinematics(self.chain, pose)) for pose in q]
            rows = [self._select(h, c) for h, c in zip(M, centres, strict=True)]
        else:
            rows = [self._select(h, self.centre) for h in M]
        magnitudes = np.linalg.norm(np.einsum("kw,krwb->krb", rates, bodies), axis=1)
        return np.array(rows), magnitudes.sum(axis=1)

    def share(self, here: RowsAtPose, rates: Array) -> float:
        """Compute the momentum at rates of the coordinates (w,) over those of the bodies."""
        rows, sizes = self.along(here.q[None], (self.basis @ rates)[None])
        return float(np.linalg.norm(rows[0] @ rates) / (sizes[0] or 1.0))

    def derivative(self, q: Array) -> Array:
        """Compute the derivatives ∂_i A_w along all coordinates at a closed pose.

        Args:
            q: positions of all joints (n,), chain units.

        Returns:
            Shape (rows, w, w): row, direction i, column w.
        """
        momenta, pose = self._series(q, np.ascontiguousarray(self.basis.T), 1)
        # orders, directions, coordinates, components
        h = np.einsum("kiurb,uw->kiwr", momenta, self.basis)
        if self.demand.kept != "attitude":
            return self._select(np.moveaxis(h[1], 2, 0), self.centre)
        p, mass = h[0, 0, :, 3:], self._total_mass()
        turned = self._select(np.moveaxis(h[1], 2, 0), self._centre_at(pose))
        return turned - np.moveaxis(np.cross(p[:, None] / mass, p[None]), 2, 0)

    def _series(self, q: Array, rays: Array, order: int) -> tuple[Array, Pose]:
        """Compute the momenta of bodies (orders, rays, inputs, 6, bodies), and the pose."""
        pose = forward_kinematics(self.chain, q)
        series = expand_from(self.chain, pose.screws, rays, order)
        X = RegressorSeries(self.chain, series, pose=pose).rows(order)
        X = X.reshape(*X.shape[:4], len(self.model.z), 10)
        return np.einsum("kiurbp,bp->kiurb", X, self.model.z), pose

    def _select(self, h: Array, centre: Array) -> Array:
        """Select the rows of momenta ``[ξ; p]`` (6, ...), the moment about a centre."""
        if self.demand.kept == "all":
            return h
        if self.demand.kept == "turned":
            return h[:0]
        if self.demand.kept == "force":
            return h[3:]
        return np.asarray(h[:3] - np.tensordot(skew(centre), h[3:], axes=1))

    def _select_sizes(self, magnitudes: Array, centre: Array) -> Array:
        """Select rows of sums of sizes (6, w), which add up about another centre too."""
        if self.demand.kept in ("all", "force", "turned"):
            return self._select(magnitudes, centre)
        return np.asarray(magnitudes[:3] + np.abs(skew(centre)) @ magnitudes[3:])

    def _total_mass(self) -> float:
        """Compute the mass of the linkage and its base."""
        base = self.demand.base
        return float(self.model.z[:, 0].sum() + (0.0 if base is None else base.mass))

    def _centre_at(self, pose: Pose) -> Array:
        """Compute the point of the moment: for the attitude, the centre of all masses."""
        if self.demand.kept != "attitude":
            return self.centre
        z, H = self.model.z, pose.H
        base = self.demand.base
        total = np.zeros(3) if base is None else base.mass * self.centre
        for link, body in zip(self.chain.links, z, strict=True):
            R, d = (np.eye(3), np.zeros(3)) if link < 0 else (H[link, :3, :3], H[link, :3, 3])
            total = total + R @ body[1:4] + body[0] * d
        return np.asarray(total / self._total_mass())
