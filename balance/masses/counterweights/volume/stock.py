"""Stock: matter whose density is nowhere above a limit, in a region.

The moments ``∫ [u; 1][u; 1]ᵀ dm`` of such matter are a convex set. Its support function is

    h(Q) = ρ ∫_K max(q, 0) dV,    q(u) = [u; 1]ᵀ Q [u; 1],

for where q is positive, full density gives most, and elsewhere none does. The part of K where q
is positive has the moments that attain it, ``∇h(Q)``.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from balance.masses.counterweights.added_matter import symmetric_basis
from balance.masses.counterweights.quadratic_minimum import minimise_in_region
from balance.masses.counterweights.regions import Region
from balance.masses.counterweights.volume.fans import Fan
from balance.masses.counterweights.volume.plane_cuts import cut_moments
from balance.masses.counterweights.volume.prism_parts import prism_part
from balance.masses.counterweights.volume.rays import (
    integrate_positive_part,
    rays_of,
    surface_products,
)
from balance.support.clarabel_adapter import triangles
from balance.support.tolerances import CURVATURE_ZERO
from kinematics.numerics.array_types import Array

# Rays of a region while a design is sought, for its final moments, for bounds, and for the
# estimate of their errors.
COARSE, FINE, SURE, ESTIMATE = 4_000, 24_000, 160_000, 40_000
# Where rays start: at no place that a form is likely to vanish at by symmetry, and otherwise
# this far from the centre towards the point where the form is largest.
CENTRE, ORIGIN_INSIDE = (0.11, 0.17, 0.23), 0.9
# Change of a form over its size, for differences of exact moments.
DIFFERENCE = 1e-5


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

        What a plane cuts off needs no rays.
        """
        Q = self.effective_form(form)
        if not Q[:3, :3].any():
            return self
        least, at = minimise_in_region(self.region, -Q)
        x, y, z = (ORIGIN_INSIDE * at if least < 0.0 else np.array(CENTRE)).tolist()
        return self._replace(origin=(x, y, z))

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
    elif (part := prism_part(stock.region, Q, rays, stock.origin)) is not None:
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
    if not Q[:3, :3].any():
        return _differences(stock, Q, basis)
    if stock.mirror is not None:
        basis = 0.5 * (basis + stock.mirror.T @ basis @ stock.mirror)
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
