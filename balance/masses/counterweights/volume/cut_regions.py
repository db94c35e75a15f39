"""Parts that planes and quadrics cut off regions, and the moments of matter that fills them.

The density of the matter is nowhere above a limit. The moments ``∫ [u; 1][u; 1]ᵀ dm`` of such
matter are a convex set. Its support function is

    h(Q) = ρ ∫_K max(q, 0) dV,    q(u) = [u; 1]ᵀ Q [u; 1],

for where q is positive, full density gives most, and elsewhere none does. The part of K where q
is positive has the moments that attain it, ``∇h(Q)``.

Moments of the part on one side of a plane have a closed form:

- box and hull: tetrahedra from the centre to the facets are cut into tetrahedra; that with
  corners ``v_i = [x_i; 1]`` and volume V has the moments ``V/20 (Σ v_i v_iᵀ + s sᵀ)`` with
  ``s = Σ v_i``.
- ball and ellipsoid: a cap, by powers of its depth.
- cylinder: slices across the plane have a width ``2 cos θ``, and between the places where the
  plane leaves an end their moments are trigonometric polynomials of θ, for which the formula of
  Gauss is exact to round-off.

Parts of prisms and cylinders where a quadratic is positive that is constant along their axis
are a section of one thickness: of the integrals over rays in space, only those over rays
in the plane of the section are left, whose errors are far smaller for as many rays. Parts of
balls in equal halves are such a section of another thickness (`ball_sections`). Rays of round
sections end where the parts do (`disc_rays`).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import homogeneous, symmetric_basis
from balance.masses.counterweights.quadratic_minimum import minimise_in_region
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.volume.ball_sections import (
    disc_products,
    section_moments,
    section_products,
)
from balance.masses.counterweights.volume.disc_rays import rays_to_rim
from balance.masses.counterweights.volume.fans import Fan
from balance.masses.counterweights.volume.rays import (
    Rays,
    integrate_positive_part,
    rays_of,
    surface_products,
    unit_gauss,
)
from balance.support.clarabel_adapter import triangles
from balance.support.tolerances import CURVATURE_ZERO, PART_ROUND_OFF
from kinematics.numerics.array_types import Array

# Rays of a region while a design is sought, for its final moments, for bounds, and for the
# estimate of their errors.
COARSE, FINE, SURE, ESTIMATE = 4_000, 24_000, 160_000, 40_000
# Where rays start: at no place that a form is likely to vanish at by symmetry, and otherwise
# this part of the way from the point where the form is largest to the centre, or less.
CENTRE, INWARDS = (0.11, 0.17, 0.23), 0.1
# Change of a form over its size, for differences of exact moments.
DIFFERENCE = 1e-5
# Slices of a cylinder between two places: the degree in θ is at most 5.
SLICES = 24
# Powers of τ in mass, first and second moments, with the factor τ of the area.
AREA_POWERS = (2, 3, 4)
# Rays to each piece of an edge.
GAUSS = 4


class Stock(NamedTuple):
    """Matter that a region may hold.

    Attributes:
        region: the region.
        density: most kilograms in a cubic metre.
        mirror: reflection (4, 4) in unit coordinates about which matter is in equal halves;
            None if it need not be.
        origin: point (3,) in unit coordinates from which rays start.
        fan: directions of a cylinder, each of which is full from the axis to the rim or empty,
            across its whole thickness; None if matter may be anywhere. Forms then are linear.
    """

    region: Region
    density: float
    mirror: Array | None = None
    origin: tuple[float, float, float] = CENTRE
    fan: Fan | None = None

    def with_rays_inside(self, form: Array) -> Stock:
        """Let rays start far inside the part where a form (4, 4) is positive.

        What a plane cuts off needs no rays, and those of sections of balls start in the middle.
        """
        Q = self.effective_form(form)
        if not Q[:3, :3].any() or self.section_axis(Q) is not None:
            return self
        least, at = minimise_in_region(self.region, -Q)
        if least >= 0.0:
            return self._replace(origin=CENTRE)
        x, y, z = ((1.0 - INWARDS) * at).tolist()
        return self._replace(origin=(x, y, z))

    def section_axis(self, Q: Array) -> Array | None:
        """Return the normal of the mirror if a form is constant along it on a ball, or None.

        Other matter has rays in space for all forms, whose errors then differ little.
        """
        if self.mirror is None or not self.region.ellipsoidal:
            return None
        across = np.eye(3) - self.mirror[:3, :3]
        normal = across[:, int(np.argmax(np.diag(across)))]
        normal = normal / np.sqrt(normal @ normal)
        constant = np.abs(Q[:, :3] @ normal).max() <= CURVATURE_ZERO * np.abs(Q).max()
        return np.asarray(normal) if constant else None

    @property
    def per_volume(self) -> float:
        """Kilograms in a unit of volume in unit coordinates."""
        return self.density * abs(float(np.linalg.det(self.region.place[:3, :3])))

    @property
    def whole(self) -> float:
        """Kilograms that fill the region."""
        return float(fill(self, np.diag([0.0, 0.0, 0.0, 1.0]))[3, 3])

    def effective_form(self, form: Array) -> Array:
        """Return the part of a form (4, 4) that counts.

        Matter in equal halves feels the even part. Second-order parts of round-off are none.
        """
        Q = np.array(form)
        if self.mirror is not None:
            Q = 0.5 * (Q + self.mirror.T @ Q @ self.mirror)
        if float(np.abs(Q[:3, :3]).max()) <= CURVATURE_ZERO * float(np.abs(Q).max()):
            Q[:3, :3] = 0.0
        return Q


def fill(stock: Stock, form: Array, rays: int = FINE) -> Array:
    """Compute the moments (4, 4), kg, of the part of the region where a form is positive.

    They are exact where the form is linear: where a plane cuts the region.

    Args:
        stock: region and density.
        form: symmetric matrix Q (4, 4) in unit coordinates.
        rays: how many rays sum up the part that a quadric cuts off.
    """
    Q = stock.effective_form(form)
    if stock.fan is not None:
        moments = stock.fan.moments(stock.fan.arcs(Q))
    elif not Q[:3, :3].any():
        moments = cut_moments(stock.region, 2.0 * Q[:3, 3], float(Q[3, 3]))
    elif (axis := stock.section_axis(Q)) is not None:
        moments = section_moments(Q, axis, rays)
    elif (part := _prism_part(stock.region, Q, rays, stock.origin)) is not None:
        moments = part
    else:
        moments = integrate_positive_part(rays_of(stock.region, rays, stock.origin), Q)
    if stock.mirror is not None:
        # Rays are not mirrored, and halves that differ by their error leave moments.
        moments = 0.5 * (moments + stock.mirror @ moments @ stock.mirror.T)
    return stock.per_volume * moments


def whole_and_halves(stock: Stock) -> list[Array]:
    """Compute the moments (4, 4), kg, of the whole region and of its halves along each axis."""
    parts = [fill(stock, np.diag([0.0, 0.0, 0.0, 1.0]))]
    for axis in range(3):
        half = np.zeros((4, 4))
        half[axis, 3] = half[3, axis] = 1.0
        parts += [fill(stock, half), fill(stock, -half)]
    return parts


def support_function(stock: Stock, form: Array) -> tuple[float, float]:
    """Compute the support function h(Q) and an estimate of its error, kg.

    The error is the difference to the sum over a quarter of the rays, whose own error is four
    times as large or more; 0 where a plane cuts.

    Args:
        stock: region and density.
        form: symmetric matrix Q (4, 4) in unit coordinates.
    """
    Q = stock.effective_form(form)
    value = float(np.sum(Q * fill(stock, Q, SURE)))
    if not Q[:3, :3].any():
        return value, 0.0
    return value, abs(value - float(np.sum(Q * fill(stock, Q, ESTIMATE))))


def second_derivatives(stock: Stock, form: Array, rays: int) -> Array:
    """Compute the second derivatives (10, 10) of h in the coordinates `symmetric_basis`, kg.

    Args:
        stock: region and density.
        form: symmetric matrix Q (4, 4) in unit coordinates.
        rays: how many rays sum up the surface of a quadric.
    """
    Q, basis = stock.effective_form(form), symmetric_basis()
    plane = not Q[:3, :3].any()
    if plane and not (stock.region.ellipsoidal and stock.fan is None):
        return _differences(stock, Q, basis)
    if stock.mirror is not None:
        basis = 0.5 * (basis + stock.mirror.T @ basis @ stock.mirror)
    if plane:
        return stock.per_volume * disc_products(2.0 * Q[:3, 3], float(Q[3, 3]), basis)
    if (axis := stock.section_axis(Q)) is not None:
        return stock.per_volume * section_products(Q, axis, rays, basis)
    return stock.per_volume * surface_products(
        rays_of(stock.region, rays, stock.origin), Q, basis
    )


def _differences(stock: Stock, Q: Array, basis: Array) -> Array:
    """Compute the same for a plane, by differences; zero but for mass and first moments."""
    size, total = DIFFERENCE * float(np.abs(Q).max()), np.zeros((10, 10))
    for k, B in enumerate(basis):
        if size > 0.0 and not B[:3, :3].any():
            change = fill(stock, Q + size * B) - fill(stock, Q - size * B)
            total[k] = triangles(change) / (2.0 * size)
    return total


def cut_moments(region: Region, normal: Array, constant: float) -> Array:
    """Integrate ``[u; 1][u; 1]ᵀ`` over the part of a region where ``normal·u + constant > 0``.

    Args:
        region: the region.
        normal: any vector (3,) in unit coordinates.
        constant: constant part.

    Returns:
        The moments (4, 4) in unit coordinates.
    """
    if region.offsets.size:
        return _polytope_part(region, normal, constant)
    if region.kind == "cylinder":
        return _cylinder_part(normal, constant)
    return _cap(normal, constant)


def _polytope_part(region: Region, normal: Array, constant: float) -> Array:
    """Cut the tetrahedra of a box or hull."""
    corners = homogeneous(region.vertices)[region.triangles]
    tetrahedra = np.concatenate([np.tile(np.eye(4)[3], (len(corners), 1, 1)), corners], axis=1)
    heights = tetrahedra @ np.append(normal, constant)
    order = np.argsort(-heights, axis=1, kind="stable")
    v, f = np.take_along_axis(tetrahedra, order[..., None], 1), np.sort(-heights, axis=1)
    above = (f < 0.0).sum(axis=1)
    pieces, signs = [v[above >= 3]], [np.ones(int((above >= 3).sum()))]
    for k, tip, sign in ((1, 0, 1.0), (3, 3, -1.0)):
        piece, g = v[above == k].copy(), f[above == k]
        others = [j for j in range(4) if j != tip]
        for j in others:
            piece[:, j] = _crossing(v[above == k], g, tip, j)
        pieces.append(piece)
        signs.append(np.full(len(piece), sign))
    w, g = v[above == 2], f[above == 2]
    a, b, c = w[:, 0], _crossing(w, g, 0, 2), _crossing(w, g, 0, 3)
    d, e, h = w[:, 1], _crossing(w, g, 1, 2), _crossing(w, g, 1, 3)
    for piece_corners in ((a, b, c, d), (b, c, d, e), (c, d, e, h)):
        pieces.append(np.stack(piece_corners, axis=1))
        signs.append(np.ones(len(w)))
    every = np.concatenate(pieces)
    volumes = np.concatenate(signs) * np.abs(np.linalg.det(every)) / 6.0
    sums = every.sum(axis=1)
    squares = every.mT @ every + sums[:, :, None] * sums[:, None, :]
    return np.asarray(np.einsum("n,nij->ij", volumes, squares) / 20.0)


def _crossing(v: Array, f: Array, i: int, j: int) -> Array:
    """Compute where edges from corner i to corner j cross the plane (n, 4)."""
    t = f[:, i] / (f[:, i] - f[:, j])
    return np.asarray(v[:, i] + t[:, None] * (v[:, j] - v[:, i]))


def _cap(normal: Array, constant: float) -> Array:
    """Compute the moments of a cap of the unit ball."""
    size = float(np.linalg.norm(normal))
    if size == 0.0 or abs(constant) >= size:
        whole = constant > 0.0
        return np.diag([0.2, 0.2, 0.2, 1.0]) * (4.0 / 3.0 * np.pi * whole)
    n, h = normal / size, -constant / size
    linear, cubic, quintic = 1.0 - h, (1.0 - h**3) / 3.0, (1.0 - h**5) / 5.0
    along = np.pi * (cubic - quintic)
    across = 0.25 * np.pi * (linear - 2.0 * cubic + quintic)
    moments = np.zeros((4, 4))
    moments[:3, :3] = across * np.eye(3) + (along - across) * np.outer(n, n)
    moments[:3, 3] = moments[3, :3] = 0.25 * np.pi * (1.0 - h * h) ** 2 * n
    moments[3, 3] = np.pi * (linear - cubic)
    return moments


def _cylinder_part(normal: Array, constant: float) -> Array:
    """Compute the moments of the unit cylinder on one side of a plane."""
    alpha, beta = float(np.hypot(normal[0], normal[1])), float(normal[2])
    e = np.append(normal[:2] / alpha, 0.0) if alpha > 0.0 else np.eye(3)[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        places = np.array([(-beta - constant), (beta - constant)]) / alpha
    kinks = np.arcsin(np.clip(places[np.isfinite(places)], -1.0, 1.0))
    ends = np.sort(np.concatenate([[-0.5 * np.pi, 0.5 * np.pi], kinks]))
    nodes, weights = np.polynomial.legendre.leggauss(SLICES)
    middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
    theta = (middle[:, None] + half[:, None] * nodes).reshape(-1)
    w = (half[:, None] * weights).reshape(-1)
    x, width = np.sin(theta), np.cos(theta)
    low, high = _heights(alpha * x + constant, beta)
    w = 2.0 * w * width**2
    height, z = high - low, 0.5 * (high**2 - low**2)
    axes = np.column_stack([e, np.cross(np.eye(3)[2], e), np.eye(3)[2], np.zeros(3)])
    frame = np.vstack([axes, np.eye(4)[3]])
    xx, xz, x1 = w @ (x * x * height), w @ (x * z), w @ (x * height)
    yy, zz = w @ (width**2 * height) / 3.0, w @ (high**3 - low**3) / 3.0
    local = np.array(
        [
            [xx, 0.0, xz, x1],
            [0.0, yy, 0.0, 0.0],
            [xz, 0.0, zz, w @ z],
            [x1, 0.0, w @ z, w @ height],
        ]
    )
    return np.asarray(frame @ local @ frame.T)


def _heights(values: Array, beta: float) -> tuple[Array, Array]:
    """Compute the interval of z in -1 to 1 where ``values + beta z > 0``; may be empty."""
    low, high = np.full(values.shape, -1.0), np.ones(values.shape)
    if beta == 0.0:
        return low, np.where(values > 0.0, high, low)
    crossing = np.clip(-values / beta, -1.0, 1.0)
    return (crossing, high) if beta > 0.0 else (low, crossing)


class _Prism(NamedTuple):
    """A region of one thickness, in its unit coordinates.

    Attributes:
        axis: unit vector (3,) along its thickness.
        middle: height of its middle along it.
        half: half its thickness.
        corners: corners (n, 3) of its section at the middle, in order; none of a round one.
    """

    axis: Array
    middle: float
    half: float
    corners: Array


def _prism_part(
    region: Region, form: Array, count: int, origin: tuple[float, float, float]
) -> Array | None:
    """Integrate ``[u; 1][u; 1]ᵀ`` over the part of a prism where a quadratic is positive.

    Args:
        region: the region.
        form: symmetric matrix (4, 4) of the quadratic, in unit coordinates.
        count: about how many rays sum up the section.
        origin: point of the region over which they start.

    Returns:
        The moments (4, 4) in unit coordinates; None if it is no prism along whose axis the
        quadratic is constant.
    """
    for prism in _prisms(region):
        along = np.abs(form[:, :3] @ prism.axis).max()
        if along <= CURVATURE_ZERO * np.abs(form).max():
            if len(prism.corners):
                o = np.array(origin)
                o = o + (prism.middle - float(prism.axis @ o)) * prism.axis
                rays = _polygon_rays(prism, count, o)
            else:
                rays = rays_to_rim(form, prism.axis, count)
            moments = 2.0 * prism.half * integrate_positive_part(rays, form, AREA_POWERS)
            across = np.outer(prism.axis, prism.axis)
            moments[:3, :3] += moments[3, 3] * prism.half**2 / 3.0 * across
            return np.asarray(moments)
    return None


@lru_cache(maxsize=32)
def _prisms(region: Region) -> list[_Prism]:
    """List the axes along which a region has one thickness."""
    if region.kind == "cylinder":
        return [_Prism(np.eye(3)[2], 0.0, 1.0, np.empty((0, 3)))]
    prisms: list[_Prism] = []
    for axis in region.normals:
        heights = region.vertices @ axis
        low, high = float(heights.min()), float(heights.max())
        top = heights >= high - PART_ROUND_OFF
        first = next(x for x in axis if abs(x) > PART_ROUND_OFF)
        twice = any(abs(axis @ prism.axis) >= 1.0 - PART_ROUND_OFF for prism in prisms)
        if first < 0.0 or twice or not (top | (heights <= low + PART_ROUND_OFF)).all():
            continue
        corners = region.vertices[top] - 0.5 * (high - low) * axis
        if _turned_round(corners, axis, region.vertices[~top]):
            prisms.append(
                _Prism(axis, 0.5 * (low + high), 0.5 * (high - low), _ordered(corners, axis))
            )
    return prisms


def _turned_round(corners: Array, axis: Array, bottom: Array) -> bool:
    """Whether the corners of the bottom are below those of the middle section."""
    if len(bottom) != len(corners):
        return False
    across = (bottom[:, None] - corners) - ((bottom[:, None] - corners) @ axis)[
        ..., None
    ] * axis
    return bool(np.linalg.norm(across, axis=2).min(axis=1).max() <= PART_ROUND_OFF)


def _ordered(corners: Array, axis: Array) -> Array:
    """Order the corners of a convex polygon, counter-clockwise about an axis."""
    away = corners - corners.mean(axis=0)
    e1 = away[0] / np.linalg.norm(away[0])
    turn = np.arctan2(away @ np.cross(axis, e1), away @ e1)
    return np.asarray(corners[np.argsort(turn)])


def _polygon_rays(prism: _Prism, count: int, origin: Array) -> Rays:
    """Choose rays from a point of the section of a prism to its edges."""
    pieces = max(1, count // (GAUSS * len(prism.corners)))
    nodes, share = unit_gauss(GAUSS)
    x = ((np.arange(pieces)[:, None] + nodes) / pieces).reshape(-1)
    w = np.tile(share / pieces, pieces)
    sides = np.roll(prism.corners, -1, axis=0) - prism.corners
    ends = (prism.corners[:, None] + x[:, None] * sides[:, None]).reshape(-1, 3)
    outward = np.cross(sides, prism.axis)
    heights = ((prism.corners - origin) * outward).sum(axis=1)
    return Rays(origin, (ends - origin).T, np.outer(heights, w).reshape(-1))
