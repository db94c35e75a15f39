"""Matter added to a link inside a region, as convex variables.

Added matter is a measure inside the region. Linkages feel its pseudo-inertia
``ΔP = ∫ [x; 1][x; 1]ᵀ dm`` alone. The pseudo-inertias of all measures inside are a convex
cone, described here exactly, in the unit coordinates of the region:

- ball and ellipsoid: ``ΔP ⪰ 0`` and ``tr(G ΔP) ≥ 0`` with ``G = diag(-1, -1, -1, 1)``. Such a
  ΔP is a sum of at most four ``p_i p_iᵀ`` with ``p_iᵀ G p_i ≥ 0`` (J. F. Sturm, S. Zhang,
  Mathematics of Operations Research 28(2), 2003).
- box and hull: a partition into tetrahedra with corners ``V_t = [v; 1]`` gives
  ``ΔP = Σ_t V_t Y_t V_tᵀ`` with Y_t positive semidefinite and without negative entries. A
  point of a tetrahedron is ``V_t w`` with ``w ≥ 0``, and matrices (4, 4) of that kind are
  sums of ``w wᵀ`` (P. H. Diananda, 1962).
- cylinder: no such description is known. Point masses at chosen points, ``ΔP = Σ μ_i p_i p_iᵀ``
  with ``μ_i ≥ 0``, are the cone from inside, and `quadratic_minimum.minimise_in_region` finds
  the points that are missing.

Where second moments do not count, mass and first moments have a small exact description for
every shape; see `first_moment_cone`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.masses.counterweights.regions import Region
from balance.space.inertial_parameters.conversions import to_chain
from balance.space.spaces.design_space import DesignSpace
from balance.support.clarabel_adapter import TRIANGLES, ConstraintBlock
from balance.support.tolerances import TETRAHEDRON_FLAT
from kinematics.model.spatial.inertia import from_pseudo_inertia
from kinematics.numerics.array_types import Array


class MomentCone(NamedTuple):
    """Pseudo-inertias ``ΔP = Σ_i v_i matrices[i]`` of measures in a region, unit coordinates.

    Attributes:
        matrices: symmetric matrices (n, 4, 4), in the unit coordinates of the region.
        rows: rows of the constraints on v (rows, n): ``rows @ v`` lies in the cones.
        parts: the cones, for `balance.support.clarabel_adapter.solve_conic`.
        exact: whether every measure in the region is described; False for point masses.
        offset: constants of the rows (rows,); None for a cone, where they are zero.
    """

    matrices: Array
    rows: Array
    parts: tuple[ConstraintBlock, ...]
    exact: bool
    offset: Array | None = None

    @property
    def constants(self) -> Array:
        """Constants of the rows (rows,)."""
        return np.zeros(len(self.rows)) if self.offset is None else self.offset


def moment_cone(region: Region) -> MomentCone:
    """Describe the pseudo-inertias of all measures in a region, in its unit coordinates.

    Raises:
        ValueError: the region is a cylinder, which has no such description.
    """
    if region.kind == "cylinder":
        raise ValueError("a cylinder has no exact cone: give points")
    return _ball_cone() if region.ellipsoidal else _tetrahedra_cone(region)


@cache
def _ball_cone() -> MomentCone:
    """Describe the pseudo-inertias of measures in the unit ball."""
    S = symmetric_basis()
    G = np.diag([-1.0, -1.0, -1.0, 1.0])
    rows = np.vstack([np.eye(10), np.einsum("nij,ij->n", S, G)])
    parts = (ConstraintBlock("psd_triangle", 4), ConstraintBlock("nonnegative", 1))
    return MomentCone(S, rows, parts, True)


def first_moment_cone(region: Region) -> MomentCone:
    """Describe mass and first moments of all measures in a region, in its unit coordinates.

    They are exact for every shape: matter of mass m whose centre of mass is in the region. The
    second moments of these matrices stay zero; use them only where those do not count.
    """
    if region.offsets.size:
        matrices = _without_second_moments(homogeneous(region.vertices))
        return lump_cone(region.vertices)._replace(matrices=matrices, exact=True)
    matrices = _without_second_moments(np.column_stack([np.eye(4)[:, :3], [0, 0, 0, 1.0]]))
    order = np.eye(4)[[3, 0, 1, 2]]
    if region.ellipsoidal:
        return MomentCone(matrices, order, (ConstraintBlock("second_order", 4),), True)
    ends = np.array([[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, -1.0, 1.0]])
    parts = (ConstraintBlock("second_order", 3), ConstraintBlock("nonnegative", 2))
    return MomentCone(matrices, np.vstack([order[:3], ends]), parts, True)


def _without_second_moments(p: Array) -> Array:
    """Build matrices (n, 4, 4) of mass and first moments (n, 4), mass last."""
    matrices = np.zeros((len(p), 4, 4))
    matrices[:, :, 3] = matrices[:, 3, :] = p
    return matrices


def lump_cone(points: ArrayLike) -> MomentCone:
    """Describe point masses at points (n, 3) in unit coordinates."""
    p = homogeneous(points)
    count = len(p)
    matrices = p[:, :, None] * p[:, None, :]
    return MomentCone(matrices, np.eye(count), (ConstraintBlock("nonnegative", count),), False)


def mixture_cone(parts: Array, most: float) -> MomentCone:
    """Describe mixtures of parts of a region by their moments (n, 4, 4).

    Shares are not negative, and add up to at most 1. Of parts heavier than ``most`` the
    variables are the shares of so much of them: shares of the whole would be below the accuracy
    of a solver.
    """
    count = len(parts)
    scale = np.minimum(1.0, most / np.maximum(parts[:, 3, 3], most))
    rows = np.vstack([np.eye(count), -scale])
    nonnegative = (ConstraintBlock("nonnegative", count + 1),)
    constants = np.append(np.zeros(count), 1.0)
    return MomentCone(scale[:, None, None] * parts, rows, nonnegative, False, constants)


def parameters_per_moment(space: DesignSpace, regions: Mapping[int, Region]) -> Array:
    """Compute counted parameters of bodies from the coordinates `triangles` of their ΔP.

    Args:
        regions: region by position of the body, in whose unit coordinates ΔP is.

    Returns:
        Matrices (regions, count, 10) in the units of the chain; count is 4 in a plane and 10
        in space, for force balance 3 and 4. Their rows are in the order of the conditions.
    """
    places = np.array([region.place for region in regions.values()]).reshape(-1, 1, 4, 4)
    H = space.frames[list(regions), None] @ places
    z = from_pseudo_inertia(H @ symmetric_basis() @ H.mT).reshape(-1, 10)
    chain_z = to_chain(z, space.chain.frame, space.planar, space.balance == "force")
    return np.asarray(chain_z.reshape(len(regions), 10, -1).mT)


def homogeneous(points: ArrayLike) -> Array:
    """Append 1 to points (n, 3).

    Args:
        points: points in any coordinates.
    """
    u = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    p = np.ones((len(u), 4))
    p[:, :3] = u
    return p


def _tetrahedra_cone(region: Region) -> MomentCone:
    """Describe the pseudo-inertias of measures in a box or hull."""
    S, corners = symmetric_basis(), homogeneous(region.vertices)
    tetrahedra = [corners[tetrahedron].T for tetrahedron in partition(region)]
    matrices = np.concatenate([V @ S @ V.T for V in tetrahedra])
    entries = np.array([S[:, i, j] for i in range(4) for j in range(i + 1, 4)])
    count = len(tetrahedra)
    block = np.vstack([np.eye(10), entries])
    rows = np.kron(np.eye(count), block)
    parts = (ConstraintBlock("psd_triangle", 4), ConstraintBlock("nonnegative", 6)) * count
    return MomentCone(matrices, rows, parts, True)


def partition(region: Region) -> list[list[int]]:
    """Partition a box or hull into tetrahedra, as positions of their four corners.

    Each has the first corner and a facet that does not contain it.
    """
    v = region.vertices
    tetrahedra = [[0, *map(int, facet)] for facet in region.triangles]
    volumes = [
        abs(float(np.linalg.det(v[tetrahedron[1:]] - v[0]))) for tetrahedron in tetrahedra
    ]
    return [
        tetrahedron
        for tetrahedron, volume in zip(tetrahedra, volumes, strict=True)
        if volume > TETRAHEDRON_FLAT
    ]


def symmetric_basis() -> Array:
    """Return the ten symmetric matrices (10, 4, 4) of the coordinates `triangles`."""
    return np.asarray(TRIANGLES[4].T.reshape(10, 4, 4))
