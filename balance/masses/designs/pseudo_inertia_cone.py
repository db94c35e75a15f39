"""The cone of positive definite pseudo-inertias in the coordinates of a design space.

A body is realisable if its pseudo-inertia ``P = ∫ [x; 1][x; 1]ᵀ dm`` is positive definite. In
a plane, and for force balance, the conditions depend on a part of P only: ``m``, ``mc`` and at
most the trace J of the second moments. A definite P with these values exists if and only if
``m > 0`` and ``m J > |mc|²``, a second-order cone.

All arrays are in the coordinates of the chain: lengths in characteristic lengths from the
middle of the mechanism, in a plane along its axes; masses in kilograms.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.space.inertial_parameters.body_inertia import BodyInertia, bodies_of_parameters
from balance.space.inertial_parameters.conversions import pseudo_inertia
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import TRIANGLES, ConstraintBlock
from kinematics.model.arrays import Frame
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array

# Second moment along the normal of a planar body, over that along an axis of the plane, both
# about the centre of mass: that of a disc about a quarter as thick as wide.
THICKNESS = 0.1


def _second_order_weights(k: int) -> Array:
    """Compute weights (k², k + 1) of ``J + m``, ``J - m`` and ``2 mc`` in matrices (k, k)."""
    W, d = np.zeros((k, k, k + 1)), range(k - 1)
    W[range(k), range(k), 0] = W[d, d, 1] = 1.0
    W[-1, -1, 1] = -1.0
    W[d, -1, range(2, k + 1)] = W[-1, d, range(2, k + 1)] = 1.0
    return W.reshape(k * k, -1)


SECOND_ORDER_WEIGHTS = {k: _second_order_weights(k) for k in (3, 4)}


class Cone(NamedTuple):
    """Pseudo-inertias of all bodies as linear functions ``P_b = Σ_i x_i blocks[b, i]``.

    Attributes:
        blocks: symmetric matrices (bodies, n, k, k): k is 4 in space and 3 in the plane.
        nullity: number of coordinates of the design space, which come first; the others are
            second moments on which no condition depends.
        second_order: whether only the traces of the second moments are coordinates. Each
            point then stands for all matrices with these traces.
    """

    blocks: Array
    nullity: int
    second_order: bool

    @property
    def size(self) -> int:
        """Rows of each matrix."""
        return self.blocks.shape[-1]

    @property
    def part(self) -> ConstraintBlock:
        """Cone of one body for the solver."""
        return (
            ConstraintBlock("second_order", self.size + 1)
            if self.second_order
            else ConstraintBlock("psd_triangle", self.size)
        )

    @property
    def weights(self) -> Array:
        """Matrix (k², rows) from matrices to the coordinates of the solver's cone."""
        return (SECOND_ORDER_WEIGHTS if self.second_order else TRIANGLES)[self.size]

    def rows(self, blocks: Array) -> Array:
        """Convert matrices (..., k, k) to the coordinates of the solver's cone (..., rows)."""
        *outer, k, _ = blocks.shape
        return np.asarray(blocks.reshape(*outer, k * k) @ self.weights)

    def stack_rows(self, blocks: Array) -> Array:
        """Stack the rows of the solver's cones of all bodies (rows, n).

        Args:
            blocks: matrices (bodies, n, k, k).
        """
        rows = self.rows(blocks)
        return rows.transpose(0, 2, 1).reshape(rows.shape[0] * rows.shape[2], rows.shape[1])

    def duals(self, vectors: Array) -> Array:
        """Convert dual vectors of the solver (..., rows) to dual matrices Z (..., k, k)."""
        k = self.size
        return np.asarray(vectors @ self.weights.T).reshape(*vectors.shape[:-1], k, k)

    def linear_at(self, x: Array) -> Array:
        """Compute ``P_b = Σ_i x_i blocks[b, i]`` (bodies, k, k).

        With traces alone, this is one of many matrices with these traces.
        """
        return np.asarray(np.einsum("bnij,n->bij", self.blocks, x))

    def at(self, x: Array) -> Array:
        """Compute the pseudo-inertias (bodies, k, k) at coordinates x (n,).

        With traces alone, second moments about the centre of mass are equal in all
        directions. Bodies without a positive mass have no such centre and are not changed.
        """
        P = self.linear_at(x)
        if self.second_order:
            d, has_mass = self.size - 1, P[:, -1, -1] > 0.0
            m, mc = P[has_mass, -1, -1], P[has_mass, :-1, -1]
            spread = mc[:, :, None] * mc[:, None, :] / m[:, None, None]
            central = np.einsum("bii->b", P[has_mass]) - m - np.einsum("bii->b", spread)
            P[has_mass, :d, :d] = spread + central[:, None, None] * np.eye(d) / d
        return P

    def least(self, P: Array) -> Array:
        """Compute the largest t of each body with ``P_b ⪰ t`` (bodies,).

        With traces alone, this is the largest one over the matrices with these traces.
        """
        if not self.second_order:
            return np.asarray(np.linalg.eigvalsh(P)[:, 0])
        # (J - d t)(m - t) = |mc|²
        d, m, mc = self.size - 1, P[:, -1, -1], P[:, :-1, -1]
        J = np.einsum("bii->b", P) - m
        root = np.sqrt((J - d * m) ** 2 + 4.0 * d * np.einsum("bi,bi->b", mc, mc))
        return np.asarray((J + d * m - root) / (2.0 * d))

    def sums(self, Z: Array) -> Array:
        """Compute ``Σ_b <Z_b, blocks[b, i]>`` for every coordinate i.

        With traces alone, the entries for the trace-free second moments are appended.
        """
        sums = np.einsum("bnij,bij->n", self.blocks, Z)
        if not self.second_order:
            return sums
        S = Z[:, :-1, :-1]
        equal = np.einsum("bii->b", S)[:, None, None] * np.eye(self.size - 1)
        return np.concatenate([sums, (S - equal / (self.size - 1)).reshape(-1)])

    def with_all_moments(self) -> Cone:
        """Return the cone with all second moments as coordinates."""
        if not self.second_order:
            return self
        count, n, k = self.blocks.shape[:3]
        pairs = [(i, j) for i in range(k - 1) for j in range(i, k - 1) if i + j > 0]
        free = np.zeros((len(pairs), k, k))
        for B, (i, j) in zip(free, pairs, strict=True):
            B[i, j] = B[j, i] = 1.0
            B[0, 0] -= float(i == j)
        more = np.zeros((count, count, len(pairs), k, k))
        more[range(count), range(count)] = free
        blocks = np.concatenate([self.blocks, more.reshape(count, -1, k, k)], axis=1)
        return Cone(blocks, self.nullity, False)


def cone_of(space: DesignSpace) -> Cone:
    """Build the cone of a design space."""
    return cone_of_columns(space, space.scaled_basis)


def cone_of_columns(space: DesignSpace, columns: Array) -> Cone:
    """Build the cone of the mass distributions that some columns span.

    Args:
        space: a design space; its bodies and labels are those of the columns.
        columns: counted parameters of all bodies, in the units of a chain (parameters, n).
    """
    count, nullity = len(space.bodies), columns.shape[1]
    z = columns.reshape(count, len(space.labels), nullity).transpose(0, 2, 1)
    if "Exx" in space.labels:
        return Cone(pseudo_inertia(z), nullity, False)
    d = 2 if space.planar else 3
    force = space.balance == "force"
    blocks = np.zeros((count, nullity + force * count, d + 1, d + 1))
    column_blocks = blocks[:, :nullity]
    column_blocks[..., d, d] = z[..., 0]
    column_blocks[..., :d, d] = column_blocks[..., d, :d] = z[..., 1 : d + 1]
    for i in range(d):
        if force:
            blocks[range(count), nullity + np.arange(count), i, i] = 1.0 / d
        else:
            column_blocks[..., i, i] = z[..., 3] / d
    return Cone(blocks, nullity, True)


def to_si(P: Array, frame: Frame, height: float = 0.0, along: Array | None = None) -> Array:
    """Convert pseudo-inertias of a chain to parameters about the inertial origin, SI units.

    Args:
        P: pseudo-inertias (bodies, 4, 4); or (bodies, 3, 3) of a plane, which becomes a plane
            of symmetry of the bodies.
        frame: frame of the chain.
        height: height of that plane above the origin of the chain, in characteristic lengths.
        along: second moments along the normal about the centre of mass (bodies,). Where not
            positive, and by default, a tenth of those in the plane.

    Returns:
        Parameters (bodies, 10).
    """
    H = np.eye(4)
    H[:3, :3], H[:3, 3] = frame.length * frame.R.T, frame.origin
    if P.shape[-1] == 3:
        m, mc = P[:, 2, 2], P[:, :2, 2]
        central = P[:, 0, 0] + P[:, 1, 1] - np.einsum("bi,bi->b", mc, mc) / np.where(m, m, 1.0)
        default = 0.5 * THICKNESS * central
        flat, P = P, np.zeros((len(P), 4, 4))
        P[:, :2, :2], P[:, :2, 3], P[:, 3, :2], P[:, 3, 3] = flat[:, :2, :2], mc, mc, m
        P[:, 2, 2] = default if along is None else np.where(along > 0.0, along, default)
        H[:3, 3] += height * H[:3, 2]
    return from_pseudo_inertia(H @ P @ H.T)


def from_si(z: Array, frame: Frame) -> Array:
    """Convert parameters to pseudo-inertias in the coordinates of a chain; see `to_si`.

    Args:
        z: parameters (bodies, 10) about the inertial origin, SI units.
        frame: frame of the chain.

    Returns:
        Pseudo-inertias (bodies, 4, 4).
    """
    H = np.eye(4)
    H[:3, :3] = frame.R / frame.length
    H[:3, 3] = -H[:3, :3] @ frame.origin
    return np.asarray(H @ pseudo_inertia(z) @ H.T)


def given_parameters(space: DesignSpace) -> Array:
    """Return the parameters of the linkage's bodies (bodies, 10), inertial origin, SI units."""
    return np.array([body.inertia for body in space.linkage.bodies]).reshape(-1, 10)


def bodies_with(space: DesignSpace, z: Array) -> tuple[BodyInertia, ...]:
    """Describe bodies of a space with parameters z (bodies, 10), inertial origin, SI units."""
    return bodies_of_parameters(
        space.bodies, z, space.frames, space.axes, space.length, space.source
    )


def matrices_of(space: DesignSpace, z: Array) -> Array:
    """Convert parameters to pseudo-inertias in the coordinates of a space's chain.

    Args:
        z: parameters (bodies, 10) about the inertial origin, SI units.

    Returns:
        Pseudo-inertias (bodies, k, k); k is 4 in space, and 3 in a plane without its normal.
    """
    P = from_si(z, space.chain.frame)
    return P[:, [[0], [1], [3]], [0, 1, 3]] if space.planar else P


def parameters_by_body(space: DesignSpace) -> list[int]:
    """Return which of the ten parameters the space contains, in the chain's coordinates."""
    indices = [0, 1, 2, 6] if space.planar else list(range(10))
    return indices[: len(space.labels)]
