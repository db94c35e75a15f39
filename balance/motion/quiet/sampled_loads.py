"""Shaking wrench and drive torques at many samples of a motion at once, with derivatives.

At each sample the screws ``s_j`` are carried to the pose, and the loops give the joint rates
``q̇ = C u̇``. With the inertia matrix ``I_j`` of what link j carries, its twist ``V_j`` and its
acceleration ``A_j``, in inertial axes about the inertial origin (R. Featherstone, Rigid Body
Dynamics Algorithms, 2008, chapter 5):

    V_j = V_parent + s_j q̇_j        A_j = A_parent + s_j q̈_j + ad(V_parent) s_j q̇_j
    f_j = I_j A_j - ad(V_j)ᵀ I_j V_j
    shaking = Σ_j f_j        τ_w = Σ_j T_jw·(f_j - weight_j)

with the twist ``T_jw`` of link j for a unit rate of input w. All samples are arrays of NumPy:
a plan needs thousands of them at once, and none of the kernels. Derivatives with respect to
velocities and accelerations are exact, since loads are polynomials of degree two in them; those
with respect to positions are central differences.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from balance.motion.motion_tolerances import DISPLACEMENT_STEP, SAMPLED_LOOPS_CLOSED
from balance.motion.verification.shaking_wrench import mass_parameters
from kinematics.closure.joint_positions import si_chain
from kinematics.model.arrays import Chain
from kinematics.model.chain import loop_signs
from kinematics.model.linkage import Linkage
from kinematics.model.spatial.inertia import spatial_inertias
from kinematics.model.spatial.screws import exp, skew
from kinematics.numerics.array_types import Array

# Most steps of Newton's method from a close pose.
NEWTON_STEPS = 8
# Largest step of a joint from a close pose, rad and m over the characteristic length: a longer
# one may have left the branch.
LONGEST_STEP = 1.0


class SampledPoses(NamedTuple):
    """Closed poses (P), inertial axes, SI units.

    Attributes:
        q: positions of all joints (P, n).
        screws: joint screws (P, n, 6).
        C: joint rates for unit rates of the inputs (P, n, w).
        twists: link twists for unit rates (P, n, 6, w).
        inertias: inertia matrices of the links (P, n, 6, 6).
        loop_inverse: takes the closure residual to dependent joints (P, dependent, rows).
    """

    q: Array
    screws: Array
    C: Array
    twists: Array
    inertias: Array
    loop_inverse: Array


class SampledLoads(NamedTuple):
    """Loads at samples, and their derivatives.

    Attributes:
        wrench: ``[moment; force]`` about the inertial origin (N, 6).
        torque: of the inputs (N, w).
        by_u: derivatives of ``[wrench; torque]`` by the inputs (N, 6 + w, w).
        by_ud: by their velocities.
        by_udd: by their accelerations.
    """

    wrench: Array
    torque: Array
    by_u: Array
    by_ud: Array
    by_udd: Array


@dataclass(frozen=True, eq=False)
class SampledLinkage:
    """A linkage with its masses, prepared for loads at many samples.

    Attributes:
        linkage: the linkage.
        chain: all joints, spatial, in SI units about the inertial origin.
        inertias: inertia matrices of the links at the reference pose (n, 6, 6).
        gravity: acceleration (3,), m/s².
        signs: of the joints on the paths to the welds (loops, n).
    """

    linkage: Linkage
    chain: Chain
    inertias: Array
    gravity: Array
    signs: Array

    @classmethod
    def of(cls, linkage: Linkage, gravity: Array) -> SampledLinkage:
        """Prepare a linkage with the masses of its file.

        Args:
            gravity: acceleration (3,), m/s², for torques alone.
        """
        chain = si_chain(linkage, spatial=True)
        inertias = np.zeros((chain.parent.size, 6, 6))
        matrices = spatial_inertias(mass_parameters(linkage))
        for link, M in zip(chain.links, matrices, strict=True):
            if link >= 0:
                inertias[link] += M
        return cls(linkage, chain, inertias, gravity, loop_signs(chain.parent, chain.ends))

    def __repr__(self) -> str:
        """One line: the linkage."""
        return f"SampledLinkage of {self.linkage.name}"

    @property
    def mass(self) -> float:
        """Moving mass, kilograms."""
        return float(self.inertias[:, 5, 5].sum())

    def near(self, poses: SampledPoses, u: Array) -> SampledPoses | None:
        """Compute closed poses near others.

        Args:
            poses: closed poses (P).
            u: displacements of the inputs (P, w), near those of the poses.

        Returns:
            The poses; None if the loops of one cannot be closed there.
        """
        chain = self.chain
        inputs = self.linkage.positions_of(self.linkage.inputs)
        q = poses.q + np.einsum("pnw,pw->pn", poses.C, u - poses.q[:, inputs])
        if chain.dependent.size == 0:
            return self.at(chain.columns @ u[..., None])
        return self.close(q)

    def close(self, q: Array) -> SampledPoses | None:
        """Close the loops by Newton's method on the dependent joints, from near positions.

        Args:
            q: positions of all joints (P, n).
        """
        dependent, start, q = self.chain.dependent, q, q.copy()
        for _ in range(NEWTON_STEPS):
            H, screws = self._place(q)
            b = self._closure_residual(H, q)
            if np.abs(b).max(initial=0.0) <= SAMPLED_LOOPS_CLOSED:
                break
            q[:, dependent] -= np.einsum("pdr,pr->pd", self._loop_inverse(screws), b)
            length = self.linkage.spatial_chain.frame.length
            if not np.abs(q - start).max() <= LONGEST_STEP * max(1.0, length):
                return None
        else:
            return None
        return self.at(q)

    def at(self, q: Array) -> SampledPoses:
        """Compute screws, rates and inertias at closed poses.

        Args:
            q: positions of all joints (P, n), or (P, n, 1).
        """
        chain = self.chain
        q = q.reshape(len(q), -1)
        H, screws = self._place(q)
        inverse = self._loop_inverse(screws)
        C = np.broadcast_to(chain.columns, (len(q), *chain.columns.shape)).copy()
        if chain.dependent.size:
            rows = self._loop_rows(screws)
            C[:, chain.dependent] = -inverse @ (rows @ C)
        twists = screws[..., None] * C[:, :, None]
        for j, parent in enumerate(chain.parent.tolist()):
            if parent >= 0:
                twists[:, j] += twists[:, parent]
        X = _inverse_adjoints(H)
        inertias = X.swapaxes(-1, -2) @ (self.inertias @ X)
        return SampledPoses(q, screws, C, twists, inertias, inverse)

    def momenta(self, poses: SampledPoses) -> Array:
        """Compute ``[ξ; p]`` for unit rates of the inputs (P, 6, w)."""
        return np.asarray((poses.inertias @ poses.twists).sum(axis=1))

    def displacements(self, q: Array) -> Array:
        """Compute the displacements of the links from the reference pose (P, n, 4, 4).

        Args:
            q: positions of all joints (P, n).
        """
        return self._place(q)[0]

    def com(self, poses: SampledPoses) -> Array:
        """Compute the centre of mass (P, 3), metres; the origin if nothing has mass."""
        # The upper right block of an inertia matrix is [mc]×.
        block = poses.inertias[:, :, :3, 3:].sum(axis=1)
        first = np.stack([block[:, 2, 1], block[:, 0, 2], block[:, 1, 0]], axis=1)
        return first / (self.mass or 1.0)

    def loads(self, poses: SampledPoses, ud: Array, udd: Array) -> Array:
        """Compute ``[wrench; torque]`` (P, 6 + w, R) for R rates in each pose.

        Args:
            ud: velocities of the inputs (P, w, R).
            udd: their accelerations (P, w, R).
        """
        chain, screws = self.chain, poses.screws
        samples, n, count = len(screws), chain.parent.size, ud.shape[2]
        qd, qdd = poses.C @ ud, poses.C @ udd
        V, bias = np.zeros((2, samples, n, 6, count))
        for j, parent in enumerate(chain.parent.tolist()):
            step = screws[:, j, :, None] * qd[:, j, None]
            if parent >= 0:
                bias[:, j] = bias[:, parent] + _bracket(V[:, parent], step)
                step = step + V[:, parent]
            V[:, j] = step
        if chain.dependent.size:
            # The loops stay closed: their bias accelerations are made up by joints.
            residual = np.zeros((samples, poses.loop_inverse.shape[2], count))
            for k, ends in enumerate(chain.ends.tolist()):
                for side, link in zip((1.0, -1.0), ends, strict=True):
                    if link >= 0:
                        residual[:, 6 * k : 6 * k + 6] += side * bias[:, link]
            qdd[:, chain.dependent] -= poses.loop_inverse @ residual
        A = screws[..., None] * qdd[:, :, None]
        for j, parent in enumerate(chain.parent.tolist()):
            if parent >= 0:
                A[:, j] += A[:, parent]
        A += bias
        f = poses.inertias @ A + _co_bracket(V, poses.inertias @ V)
        weight = poses.inertias @ np.append(np.zeros(3), self.gravity)
        driven = f - weight[..., None]
        torque = np.einsum("pniw,pnir->pwr", poses.twists, driven)
        return np.concatenate([f.sum(axis=1), torque], axis=1)

    def sample(
        self, poses: SampledPoses, u: Array, ud: Array, udd: Array
    ) -> SampledLoads | None:
        """Compute loads along a motion, and their derivatives.

        Args:
            poses: the closed poses of the samples (N).
            u: displacements of the inputs (N, w).
            ud: their velocities (N, w).
            udd: their accelerations (N, w).

        Returns:
            The loads; None if a pose beside a sample cannot be closed.
        """
        width, samples = u.shape[1], len(u)
        units = np.abs(ud).max(axis=0) + 1.0
        steps = np.concatenate([np.zeros((width, 1)), np.diag(units), -np.diag(units)], axis=1)
        rates = np.concatenate(
            [ud[:, :, None] + steps, np.zeros((samples, width, width))], axis=2
        )
        changes = np.broadcast_to(udd[:, :, None], (samples, width, 2 * width + 1))
        unit = np.broadcast_to(np.eye(width), (samples, width, width))
        values = self.loads(poses, rates, np.concatenate([changes, unit], axis=2))
        now, up, down = values[..., 0], values[..., 1 : width + 1], values[..., width + 1 :]
        by_ud = (up - down[..., :width]) / (2.0 * units)
        loads_at_rest = self.loads(
            poses, np.zeros((samples, width, 1)), np.zeros((samples, width, 1))
        )
        by_udd = down[..., width:] - loads_at_rest
        by_u = self._by_positions(poses, u, ud, udd)
        if by_u is None:
            return None
        return SampledLoads(now[:, :6], now[:, 6:], by_u, by_ud, by_udd)

    def _by_positions(
        self, poses: SampledPoses, u: Array, ud: Array, udd: Array
    ) -> Array | None:
        """Compute the derivatives of ``[wrench; torque]`` by the inputs (N, 6 + w, w)."""
        samples, width = u.shape
        steps = DISPLACEMENT_STEP * np.concatenate([np.eye(width), -np.eye(width)])
        around = (u[None] + steps[:, None]).reshape(-1, width)
        several = SampledPoses(*(np.tile(x, (2 * width, *[1] * (x.ndim - 1))) for x in poses))
        beside = self.near(several, around)
        if beside is None:
            return None
        rates = (np.tile(x, (2 * width, 1))[..., None] for x in (ud, udd))
        up, down = self.loads(beside, *rates)[..., 0].reshape(2, width, samples, -1)
        return np.asarray(((up - down) / (2.0 * DISPLACEMENT_STEP)).transpose(1, 2, 0))

    def _place(self, q: Array) -> tuple[Array, Array]:
        """Compute displacements of links (P, n, 4, 4) and screws (P, n, 6) at positions."""
        chain = self.chain
        H, screws = np.empty((*q.shape, 4, 4)), np.empty((*q.shape, 6))
        for j, parent in enumerate(chain.parent.tolist()):
            E = exp(chain.screws[j], q[:, j])
            if parent < 0:
                H[:, j], screws[:, j] = E, chain.screws[j]
                continue
            before = H[:, parent]
            H[:, j] = before @ E
            w, v = (before[:, :3, :3] @ part for part in np.split(chain.screws[j], 2))
            screws[:, j] = np.concatenate([w, v + _cross(before[:, :3, 3], w)], axis=1)
        return H, screws

    def _closure_residual(self, H: Array, q: Array) -> Array:
        """Compute the twists by which the loops are open, then relations (P, rows)."""
        chain = self.chain
        b = np.empty((len(q), 6 * len(chain.ends) + len(chain.mimics)))
        for k, (end, successor) in enumerate(chain.ends.tolist()):
            A, B = (
                H[:, link] if link >= 0 else np.broadcast_to(np.eye(4), (len(q), 4, 4))
                for link in (end, successor)
            )
            D = A[:, :3, :3] @ B[:, :3, :3].swapaxes(1, 2)
            skew = 0.5 * (D - D.swapaxes(1, 2))
            b[:, 6 * k : 6 * k + 3] = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], 1)
            moved = np.einsum("pij,pj->pi", D, B[:, :3, 3])
            b[:, 6 * k + 3 : 6 * k + 6] = A[:, :3, 3] - moved
        b[:, 6 * len(chain.ends) :] = q @ chain.mimics.T
        return b

    def _loop_rows(self, screws: Array) -> Array:
        """Compute the loop matrix of all joints, with relations below (P, rows, n)."""
        samples, n = screws.shape[:2]
        rows = np.einsum("lj,pji->plij", self.signs, screws).reshape(samples, -1, n)
        mimics = np.broadcast_to(self.chain.mimics, (samples, *self.chain.mimics.shape))
        return np.concatenate([rows, mimics], axis=1)

    def _loop_inverse(self, screws: Array) -> Array:
        """Compute the least-squares inverse for the dependent joints (P, dependent, rows)."""
        dependent = self.chain.dependent
        rows = 6 * len(self.chain.ends) + len(self.chain.mimics)
        if dependent.size == 0:
            return np.zeros((len(screws), 0, rows))
        Q, R = np.linalg.qr(self._loop_rows(screws)[:, :, dependent])
        return np.asarray(np.linalg.solve(R, Q.swapaxes(1, 2)))


def _cross(a: Array, b: Array) -> Array:
    """Compute ``a × b`` along the axis 1 of arrays (P, 3, …)."""
    return np.stack(
        [
            a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1],
            a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2],
            a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0],
        ],
        axis=1,
    )


def _bracket(V: Array, s: Array) -> Array:
    """Compute ``ad(V) s`` of twists (P, 6, R)."""
    return np.concatenate(
        [_cross(V[:, :3], s[:, :3]), _cross(V[:, :3], s[:, 3:]) + _cross(V[:, 3:], s[:, :3])],
        axis=1,
    )


def _co_bracket(V: Array, h: Array) -> Array:
    """Compute ``-ad(V)ᵀ h`` of twists and momenta (P, n, 6, R)."""
    shape = V.shape
    V, h = (x.reshape(-1, 6, shape[3]) for x in (V, h))
    moment = _cross(V[:, :3], h[:, :3]) + _cross(V[:, 3:], h[:, 3:])
    return np.concatenate([moment, _cross(V[:, :3], h[:, 3:])], axis=1).reshape(shape)


def _inverse_adjoints(H: Array) -> Array:
    """Compute ``Ad(H)⁻¹`` of displacements (P, n, 4, 4): (P, n, 6, 6)."""
    Rt, d = H[..., :3, :3].swapaxes(-1, -2), H[..., :3, 3]
    X = np.zeros((*H.shape[:-2], 6, 6))
    X[..., :3, :3] = X[..., 3:, 3:] = Rt
    X[..., 3:, :3] = -Rt @ skew(d)
    return X
