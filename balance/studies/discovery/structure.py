"""The structure of a linkage as arrays: what all geometries of one topology share.

In the plane a twist is ``[ω; v_x; v_y]`` and a displacement a 3×3 matrix; in space they are
those of `kinematics.model.spatial.screws`. Functions broadcast over leading dimensions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from balance.space.momentum.product_tensors import Tensors, product_tensors
from kinematics.model.spatial.screws import Ad, ad, exp, vee
from kinematics.numerics.array_types import Array, Flags, IntArray


class LaneGeometry(NamedTuple):
    """Joints of many linkages (lanes) at their reference poses, where all loops are closed.

    Attributes:
        points: a point of each joint (lanes, joints, 3).
        axes: unit vectors along the joints (lanes, joints, 3).
    """

    points: Array
    axes: Array

    def take(self, lanes: IntArray | Flags | slice) -> LaneGeometry:
        """Select lanes by indices or flags."""
        return LaneGeometry(self.points[lanes], self.axes[lanes])

    def put(self, lanes: IntArray, other: LaneGeometry) -> None:
        """Replace lanes, in place."""
        self.points[lanes], self.axes[lanes] = other


class MomentumRows(NamedTuple):
    """Components of the momentum ``[ξ; p]``: ``S = fixed + by_origin A + by_line d``.

    A is the origin of the frame of the ground, and d runs along its x; see
    `balance.studies.discovery.lane_regions`.

    Attributes:
        fixed: the part that is the same for all geometries (rows, dim).
        by_origin: the factors of A (rows, dim, 2).
        by_line: the factors of d (rows, dim, 2).
    """

    fixed: Array
    by_origin: Array
    by_line: Array


class LaneRegion(NamedTuple):
    """Where some components of the momentum are to vanish.

    Attributes:
        components: the components.
        relations: rows that vanish on the joint positions of its motion (rows, joints).
        places: displacements of the inputs at each of its poses (poses, inputs); none where all
            poses of its motion count.
        tangents: rates of the inputs for each of its freedoms there (poses, inputs, freedoms).
    """

    components: MomentumRows
    relations: Array
    places: Array
    tangents: Array


@dataclass(frozen=True, eq=False)
class TopologyArrays:
    """Joints, loops, bodies and permitted changes of a topology.

    A joint and the link after it have one number. The link after a joint that closes a loop is
    welded to another link.

    Attributes:
        planar: whether all motion is in the plane xy.
        spherical: whether all axes pass through the origin.
        sliding: whether each joint slides (joints,).
        parent: link that carries each joint; -1 is the ground (joints,).
        ends: the two links that close each loop (loops, 2).
        relations: rows that vanish on the joint positions, as of gears (rows, joints).
        bodies: link of each body (bodies,).
        shifts: translation of joints by each permitted change (changes, 3).
        turns: rotation of joints about their points by each permitted change (changes, 3).
        moved: joints that each change moves together (changes, joints).
        origin: joint of the graph that each joint belongs to (joints,).
        force: whether linear momentum alone is to vanish.
        regions: what is to vanish where, if it is not the momentum in all poses.
        inputs: joints that requirements name; their displacements give poses (inputs,).
        frame: joints at the origin and along x of the frame of the ground; empty where no
            requirement has directions or points.
    """

    planar: bool
    spherical: bool
    sliding: Flags
    parent: IntArray
    ends: IntArray
    relations: Array
    bodies: IntArray
    shifts: Array
    turns: Array
    moved: Array
    origin: IntArray
    force: bool = False
    regions: tuple[LaneRegion, ...] = ()
    inputs: tuple[int, ...] = ()
    frame: tuple[int, ...] = ()

    @property
    def algebra(self) -> _Algebra:
        """The algebra of its twists."""
        return PLANE if self.planar else SPACE

    @cached_property
    def free_axes(self) -> Flags:
        """Joints whose directions are no property of the linkage, as in a spherical joint."""
        counts = np.bincount(self.origin)
        return np.asarray(counts[self.origin] == 3)

    @property
    def closure(self) -> int:
        """Number of components of each loop that can be open: the first ones."""
        return 3 if self.planar or self.spherical else 6

    @property
    def width(self) -> int:
        """Mobility of a generic geometry."""
        return len(self.parent) - self.closure * len(self.ends) - len(self.relations)

    @property
    def unknowns(self) -> int:
        """Number of inertial parameters."""
        return len(self.bodies) * self.algebra.parameters

    @cached_property
    def of_regions(self) -> tuple[TopologyArrays, ...]:
        """The topology with the motion of each region, and the whole momentum."""
        return tuple(
            replace(
                self,
                relations=np.concatenate([self.relations, region.relations]),
                force=False,
                regions=(),
            )
            for region in self.regions
        )

    @property
    def pinned(self) -> bool:
        """Whether requirements tell the reference pose from others of the same motion."""
        return any(len(region.places) or len(region.relations) for region in self.regions)

    @property
    def components(self) -> slice:
        """Components of the momentum ``[ξ; p]`` that are to vanish."""
        return slice(self.algebra.dim - (2 if self.planar else 3) if self.force else 0, None)

    @property
    def uncounted(self) -> int:
        """Number of inertial parameters without linear momentum: second moments."""
        moments = self.algebra.parameters - (3 if self.planar else 4)
        return len(self.bodies) * moments if self.force else 0

    @cached_property
    def paths(self) -> Array:
        """Ones where a joint lies on the path from the ground to a link (links, joints)."""
        n = len(self.parent)
        out = np.zeros((n + 1, n))
        for j, parent in enumerate(self.parent):
            out[j] = out[parent]
            out[j, j] = 1.0
        return out[:-1]

    @cached_property
    def cycles(self) -> Array:
        """Signs of the joints around each loop (loops, joints)."""
        paths = np.concatenate([self.paths, np.zeros((1, len(self.parent)))])
        return np.asarray(paths[self.ends[:, 0]] - paths[self.ends[:, 1]])

    def screws(self, geometry: LaneGeometry) -> Array:
        """Compute the joint screws ``[n; r × n]`` or ``[0; n]`` (lanes, joints, dim)."""
        n, r = geometry.axes, geometry.points
        slides = self.sliding[:, None]
        w, v = np.where(slides, 0.0, n), np.where(slides, n, np.cross(r, n))
        return _split_twists(np.concatenate([w, v], axis=-1), self.planar)

    def twists(self, geometry: LaneGeometry) -> Array:
        """Compute the twist of each joint in each change (lanes, changes, joints, dim)."""
        w = self.turns[None, :, None, :] * self.moved[..., None]
        v = self.shifts[None, :, None, :] * self.moved[..., None]
        w = np.broadcast_to(w, (len(geometry.points), *w.shape[1:]))
        v = v + np.cross(geometry.points[:, None], w)
        return _split_twists(np.concatenate([w, v], axis=-1), self.planar)

    def change(self, geometry: LaneGeometry, steps: Array) -> LaneGeometry:
        """Move the joints by steps, and normalise position and size.

        Args:
            steps: size of each permitted change (lanes, changes).
        """
        return self.normalise(self.move(geometry, steps))

    def move(self, geometry: LaneGeometry, steps: Array) -> LaneGeometry:
        """Move the joints by steps.

        Args:
            steps: size of each permitted change (lanes, changes).
        """
        shift = np.einsum("lc,ci,cj->lji", steps, self.shifts, self.moved)
        turn = np.einsum("lc,ci,cj->lji", steps, self.turns, self.moved)
        axes = geometry.axes + np.cross(turn, geometry.axes)
        axes = axes / np.sqrt(np.sum(axes**2, axis=-1, keepdims=True))
        return LaneGeometry(geometry.points + shift, axes)

    def normalise(self, geometry: LaneGeometry) -> LaneGeometry:
        """Bring the mean of the points to 0 and their root mean square to 1."""
        points, axes = geometry
        axes = axes / np.sqrt(np.sum(axes**2, axis=-1, keepdims=True))
        if self.spherical:
            return LaneGeometry(np.zeros_like(points), axes)
        turning = points[:, ~self.sliding]
        points = points - turning.mean(axis=1, keepdims=True)
        size = np.mean(np.sum(points[:, ~self.sliding] ** 2, axis=-1), axis=1)
        points = np.where(self.sliding[:, None], 0.0, points)
        return LaneGeometry(points / np.sqrt(size)[:, None, None], axes)


class _Algebra(NamedTuple):
    """Functions of displacements and twists with ``dim`` components.

    Attributes:
        dim: number of components of a twist, 3 or 6.
        parameters: number of inertial parameters of a body, 4 or 10.
        exp: displacement of a joint, from unit screws (…, dim) and positions (…).
        adjoint: matrix (…, dim, dim) that carries twists along with a displacement.
        bracket: matrix (…, dim, dim) of the Lie bracket with a twist (…, dim).
        gap: twist (…, dim) that vanishes, near the identity, only for the identity.
        tensors: products of twists and masses.
    """

    dim: int
    parameters: int
    exp: Callable[[Array, Array], Array]
    adjoint: Callable[[Array], Array]
    bracket: Callable[[Array], Array]
    gap: Callable[[Array], Array]
    tensors: Tensors

    def inverse(self, H: Array) -> Array:
        """Invert displacements ``[R, d; 0, 1]``: ``[Rᵀ, -Rᵀ d; 0, 1]``."""
        out = np.zeros_like(H)
        R = np.swapaxes(H[..., :-1, :-1], -1, -2)
        out[..., :-1, :-1] = R
        out[..., :-1, -1:] = -R @ H[..., :-1, -1:]
        out[..., -1, -1] = 1.0
        return out


def _split_twists(twists: Array, planar: bool) -> Array:
    """Keep the components of spatial twists (…, 6) that the algebra has.

    Args:
        twists: ``[ω; v]``, of motion in the plane if ``planar``.
        planar: whether the algebra is that of the plane xy.
    """
    return twists[..., 2:5] if planar else twists


def _plane_exp(screws: Array, q: Array) -> Array:
    """Compute ``exp(q ŝ)`` for ``[1; v]`` and ``[0; v]``; shape (…, 3, 3)."""
    w, x, y = screws[..., 0], screws[..., 1], screws[..., 2]
    angle = w * q
    cosine, sine = np.cos(angle), np.sin(angle)
    along = np.where(w != 0.0, sine, q)
    across = 2.0 * np.sin(0.5 * angle) ** 2
    H = np.zeros((*angle.shape, 3, 3))
    H[..., 0, 0] = H[..., 1, 1] = cosine
    H[..., 0, 1], H[..., 1, 0] = -sine, sine
    H[..., 0, 2], H[..., 1, 2] = along * x - across * y, along * y + across * x
    H[..., 2, 2] = 1.0
    return H


def _plane_adjoint(H: Array) -> Array:
    """Compute ``Ad(H)`` with ``Ad(H) [ω; v] = [ω; R v + ω (d_y; -d_x)]``."""
    matrix = np.zeros_like(H)
    matrix[..., 0, 0] = 1.0
    matrix[..., 1:, 1:] = H[..., :2, :2]
    matrix[..., 1, 0], matrix[..., 2, 0] = H[..., 1, 2], -H[..., 0, 2]
    return matrix


def _plane_bracket(t: Array) -> Array:
    """Compute ``ad(t)``: the derivative of ``Ad`` along the twist ``[ω; v]``."""
    matrix = np.zeros((*t.shape[:-1], 3, 3))
    matrix[..., 1, 0], matrix[..., 2, 0] = t[..., 2], -t[..., 1]
    matrix[..., 1, 2], matrix[..., 2, 1] = -t[..., 0], t[..., 0]
    return matrix


def _plane_gap(H: Array) -> Array:
    """Read off ``[sin φ; d]``."""
    return np.stack([H[..., 1, 0], H[..., 0, 2], H[..., 1, 2]], axis=-1)


PLANE = _Algebra(
    3, 4, _plane_exp, _plane_adjoint, _plane_bracket, _plane_gap, product_tensors(True, False)
)


SPACE = _Algebra(6, 10, exp, Ad, ad, vee, product_tensors(False, False))
