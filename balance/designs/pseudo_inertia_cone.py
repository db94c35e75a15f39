"""The cone of buildable bodies, seen from the coordinates of a design space.

A body can be built if its pseudo-inertia ``P = ∫ [x; 1][x; 1]ᵀ dm`` is positive definite. In
a plane, and for force balance, only some of P is conditioned: ``m``, ``mc`` and at most the
trace J of the second moments. There is a definite P with these exactly if ``m > 0`` and
``m J > |mc|²``, a cone of Lorentz that needs no matrix.

Everything here is in the coordinates of the chain: lengths in characteristic lengths from the
middle of the mechanism, and in a plane the axes of that plane; masses in kilograms.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.designs.clarabel_adapter import TRIANGLES, ConstraintBlock
from balance.inertial_parameters.conversions import pseudo_inertia
from balance.spaces.design_space_result import DesignSpace
from kinematics.model.arrays import Frame
from kinematics.spatial.inertia import from_pseudo_inertia

__all__ = [
    "Cone",
    "cone_of",
    "parameters_by_body",
    "from_si",
    "given_parameters",
    "matrices_of",
    "to_si",
]

Array = NDArray[np.float64]

# Second moment along the normal of a planar body, over that along an axis of the plane, both
# about the centre of mass: that of a disc about a quarter as thick as wide.
THICKNESS = 0.1


def _lorentz(k: int) -> Array:
    """Weights (k², k + 1) of ``J + m``, ``J - m`` and ``2 mc`` in matrices (k, k)."""
    W, d = np.zeros((k, k, k + 1)), range(k - 1)
    W[range(k), range(k), 0] = W[d, d, 1] = 1.0
    W[-1, -1, 1] = -1.0
    W[d, -1, range(2, k + 1)] = W[-1, d, range(2, k + 1)] = 1.0
    return W.reshape(k * k, -1)


LORENTZ = {k: _lorentz(k) for k in (3, 4)}


class Cone(NamedTuple):
    """Pseudo-inertias of all bodies as linear functions ``P_b = Σ_i x_i blocks[b, i]``.

    Attributes:
        blocks: symmetric matrices (bodies, n, k, k): k is 4 in space and 3 in the plane.
        nullity: how many coordinates, the first ones, are those of the design space; the
            others are second moments that no condition sees.
        lorentz: whether only the traces of the second moments are coordinates: then they
            stand for all matrices with these traces.
    """

    blocks: Array
    nullity: int
    lorentz: bool

    @property
    def size(self) -> int:
        """Rows of each matrix."""
        return self.blocks.shape[-1]

    @property
    def part(self) -> ConstraintBlock:
        """The cone of one body for the solver."""
        return (
            ConstraintBlock("lorentz", self.size + 1)
            if self.lorentz
            else ConstraintBlock("matrix", self.size)
        )

    @property
    def weights(self) -> Array:
        """Matrix (k², rows) that takes matrices to the coordinates of the solver's cone."""
        return (LORENTZ if self.lorentz else TRIANGLES)[self.size]

    def rows(self, blocks: Array) -> Array:
        """Matrices (..., k, k) in the coordinates of the solver's cone (..., rows)."""
        *outer, k, _ = blocks.shape
        return np.asarray(blocks.reshape(*outer, k * k) @ self.weights)

    def stacked(self, blocks: Array) -> Array:
        """Rows of the solver's cones of all bodies, one after the other (rows, n).

        Args:
            blocks: matrices (bodies, n, k, k).
        """
        rows = self.rows(blocks)
        return rows.transpose(0, 2, 1).reshape(rows.shape[0] * rows.shape[2], rows.shape[1])

    def duals(self, vectors: Array) -> Array:
        """Matrices Z (..., k, k) that multiply as the solver's dual vectors do."""
        k = self.size
        return np.asarray(vectors @ self.weights.T).reshape(*vectors.shape[:-1], k, k)

    def sums_at(self, x: Array) -> Array:
        """``P_b = Σ_i x_i blocks[b, i]`` (bodies, k, k); with traces alone, one of many."""
        return np.asarray(np.einsum("bnij,n->bij", self.blocks, x))

    def at(self, x: Array) -> Array:
        """Pseudo-inertias (bodies, k, k).

        With traces alone, second moments about the centre of mass are equal in all
        directions; bodies without a positive mass, which have no such centre, are left as
        they are.
        """
        P = self.sums_at(x)
        if self.lorentz:
            d, heavy = self.size - 1, P[:, -1, -1] > 0.0
            m, mc = P[heavy, -1, -1], P[heavy, :-1, -1]
            spread = mc[:, :, None] * mc[:, None, :] / m[:, None, None]
            central = np.einsum("bii->b", P[heavy]) - m - np.einsum("bii->b", spread)
            P[heavy, :d, :d] = spread + central[:, None, None] * np.eye(d) / d
        return P

    def least(self, P: Array) -> Array:
        """The largest t of each body with ``P_b ⪰ t``, for the best of its matrices."""
        if not self.lorentz:
            return np.asarray(np.linalg.eigvalsh(P)[:, 0])
        # (J - d t)(m - t) = |mc|²
        d, m, mc = self.size - 1, P[:, -1, -1], P[:, :-1, -1]
        J = np.einsum("bii->b", P) - m
        root = np.sqrt((J - d * m) ** 2 + 4.0 * d * np.einsum("bi,bi->b", mc, mc))
        return np.asarray((J + d * m - root) / (2.0 * d))

    def sums(self, Z: Array) -> Array:
        """``Σ_b <Z_b, P_b>`` as a function, one value for each coordinate.

        With traces alone, also for the parts of the second moments that have no trace.
        """
        own = np.einsum("bnij,bij->n", self.blocks, Z)
        if not self.lorentz:
            return own
        S = Z[:, :-1, :-1]
        equal = np.einsum("bii->b", S)[:, None, None] * np.eye(self.size - 1)
        return np.concatenate([own, (S - equal / (self.size - 1)).reshape(-1)])

    def lifted(self) -> Cone:
        """The same with all second moments as coordinates of their own."""
        if not self.lorentz:
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
    """The cone of a design space."""
    count, nullity = len(space.bodies), space.nullity
    z = space.scaled_basis.reshape(count, len(space.labels), nullity).transpose(0, 2, 1)
    if "Exx" in space.labels:
        return Cone(pseudo_inertia(z), nullity, False)
    d = 2 if space.planar else 3
    force = space.balance == "force"
    blocks = np.zeros((count, nullity + force * count, d + 1, d + 1))
    own = blocks[:, :nullity]
    own[..., d, d] = z[..., 0]
    own[..., :d, d] = own[..., d, :d] = z[..., 1 : d + 1]
    for i in range(d):
        if force:
            blocks[range(count), nullity + np.arange(count), i, i] = 1.0 / d
        else:
            own[..., i, i] = z[..., 3] / d
    return Cone(blocks, nullity, True)


def to_si(P: Array, frame: Frame, height: float = 0.0, along: Array | None = None) -> Array:
    """Parameters (bodies, 10) about the inertial origin, SI units.

    Args:
        P: pseudo-inertias (bodies, 4, 4); or (bodies, 3, 3) of a plane, which are completed
            to bodies with that plane as a plane of symmetry.
        frame: coordinates of the chain.
        height: of that plane above the origin of the chain, in characteristic lengths.
        along: second moments along the normal (bodies,), about the centre of mass; a tenth
            of those in the plane where not positive, the default.
    """
    H = np.eye(4)
    H[:3, :3], H[:3, 3] = frame.length * frame.R.T, frame.origin
    if P.shape[-1] == 3:
        m, mc = P[:, 2, 2], P[:, :2, 2]
        central = P[:, 0, 0] + P[:, 1, 1] - np.einsum("bi,bi->b", mc, mc) / np.where(m, m, 1.0)
        thin = 0.5 * THICKNESS * central
        flat, P = P, np.zeros((len(P), 4, 4))
        P[:, :2, :2], P[:, :2, 3], P[:, 3, :2], P[:, 3, 3] = flat[:, :2, :2], mc, mc, m
        P[:, 2, 2] = thin if along is None else np.where(along > 0.0, along, thin)
        H[:3, 3] += height * H[:3, 2]
    return from_pseudo_inertia(H @ P @ H.T)


def from_si(z: Array, frame: Frame) -> Array:
    """Pseudo-inertias (bodies, 4, 4) in the coordinates of a chain, the inverse of `to_si`."""
    H = np.eye(4)
    H[:3, :3] = frame.R / frame.length
    H[:3, 3] = -H[:3, :3] @ frame.origin
    return np.asarray(H @ pseudo_inertia(z) @ H.T)


def given_parameters(space: DesignSpace) -> Array:
    """Parameters of the bodies in the file (bodies, 10) about the inertial origin, SI units."""
    return np.array([body.inertia for body in space.linkage.bodies]).reshape(-1, 10)


def matrices_of(space: DesignSpace, z: Array) -> Array:
    """Pseudo-inertias (bodies, k, k) of parameters (bodies, 10), in the chain's coordinates.

    In a plane only what is in it: k is 3.
    """
    P = from_si(z, space.chain.frame)
    return P[:, [[0], [1], [3]], [0, 1, 3]] if space.planar else P


def parameters_by_body(space: DesignSpace) -> list[int]:
    """Which of the ten parameters, in the coordinates of the chain, the space counts."""
    own = [0, 1, 2, 6] if space.planar else list(range(10))
    return own[: len(space.labels)]
