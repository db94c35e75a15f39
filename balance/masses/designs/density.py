"""Density: which bodies a material allows, and the solid that has the inertia of a body.

Among bodies of mass m whose density is nowhere above ρ, the homogeneous ellipsoid has the least
determinant of the second moments C about the centre of mass: a map of determinant 1 makes C
isotropic, and among bodies of one volume the ball has the least trace. With
``C = (m/5) diag(a², b², c²)`` and ``m = ρ (4/3) π a b c``

    det(C)^{1/3} ≥ κ m^{5/3},    κ = (1/5) (3 / (4πρ))^{2/3}                        in space,
    det(C)^{1/2} ≥ κ m²,         κ = 1 / (4πρt)             for flat bodies of thickness t,

where C of a flat body holds the second moments in the plane, and the elliptic plate takes the
place of the ellipsoid. An ellipsoid or a plate of lower density has every C above the limit.
Both are ``det(C)^{1/d} ≥ κ m^{1 + 2/d}``. With the pseudo-inertia P, ``det P = m det C``, so
that

    det(P)^{1/(d + 3)} ≥ κ^{d/(d + 3)} m,

whose left side is concave, and homogeneous if the unit of mass is a coordinate τ:
``det(P)^{1/(d + 3)} τ^{2/(d + 3)}``.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import Literal, NamedTuple

import numpy as np

from balance.space.inertial_parameters.conversions import MassProperties
from balance.support.materials import MATERIALS
from balance.support.tolerances import SECOND_MOMENT_NEGATIVE_RELATIVE
from balance.support.vector_digits import plain_number
from kinematics.numerics.array_types import Array

# Densities of steel and of air, kg/m³.
STEEL, AIR = MATERIALS["steel"], 1.2
# Digits of the sizes of solids.
SIZE_DIGITS = 3


class DensityLimit(NamedTuple):
    """The density that a body nowhere exceeds.

    Attributes:
        density: kg/m³.
        thickness: that of a flat body, m; None for bodies in space.
    """

    density: float
    thickness: float | None = None

    @property
    def dimensions(self) -> int:
        """d: 2 for flat bodies, 3 in space."""
        return 3 if self.thickness is None else 2

    @property
    def least_moment(self) -> float:
        """κ of ``det(C)^{1/d} ≥ κ m^{1 + 2/d}``, SI units."""
        if self.thickness is None:
            return float(0.2 * (0.75 / (np.pi * self.density)) ** (2.0 / 3.0))
        return float(0.25 / (np.pi * self.density * self.thickness))


class Solid(NamedTuple):
    """The homogeneous solid that has the inertia of a body.

    Attributes:
        shape: ``"ellipsoid"``, or ``"plate"``: a cylinder on an ellipse, whose axis is the last
            row of ``axes``.
        mass: kg.
        centre: its middle (3,), m.
        axes: rows are the semi-axes (3, 3), m; that along a plate is half of its thickness.
    """

    shape: Literal["ellipsoid", "plate"]
    mass: float
    centre: Array
    axes: Array

    @property
    def sizes(self) -> Array:
        """Full lengths along the axes (3,), m."""
        return 2.0 * np.linalg.norm(self.axes, axis=1)

    @property
    def name(self) -> str:
        """Its shape in words."""
        return "elliptic plate" if self.shape == "plate" else "ellipsoid"

    @property
    def size_text(self) -> str:
        """Its full lengths in mm, as text."""
        return " × ".join(plain_number(1e3 * size, SIZE_DIGITS) for size in self.sizes)

    @property
    def density_text(self) -> str:
        """Its density, kg/m³, as text."""
        return plain_number(self.density, SIZE_DIGITS) if self.density < np.inf else "no volume"

    @property
    def density(self) -> float:
        """Mass over volume, kg/m³; infinite for a solid without volume."""
        part = np.pi / 6.0 if self.shape == "ellipsoid" else np.pi / 4.0
        volume = part * float(np.prod(self.sizes))
        return self.mass / volume if volume > 0.0 else np.inf


def solid_of(body: MassProperties, normal: Array | None = None) -> Solid | None:
    """Compute the homogeneous solid that has the mass properties of a body.

    With the eigenvalues σ of the second moments about the centre of mass, the semi-axes of the
    ellipsoid are ``√(5 σ / m)``; those of an elliptic plate are ``√(4 σ / m)``, and half of its
    thickness is ``√(3 σ / m)``.

    Args:
        body: its mass, centre of mass and inertia about that centre, SI units.
        normal: normal of a flat body (3,), a principal axis; None for an ellipsoid.

    Returns:
        The solid, in the same frame; None if no body has these mass properties.
    """
    mass, centre, inertia = body
    if not mass > 0.0:
        return None
    C = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    if normal is None:
        sigma, directions = np.linalg.eigh(C)
        parts = np.full(3, 5.0)
    else:
        across = np.linalg.svd(normal[None])[2][1:]
        in_plane, turn = np.linalg.eigh(across @ C @ across.T)
        sigma = np.append(in_plane, normal @ C @ normal)
        directions = np.column_stack([across.T @ turn, normal])
        parts = np.array([4.0, 4.0, 3.0])
    if sigma.min() < -SECOND_MOMENT_NEGATIVE_RELATIVE * sigma.max():
        return None
    axes = np.sqrt(parts * np.clip(sigma, 0.0, None) / mass)[:, None] * directions.T
    return Solid("ellipsoid" if normal is None else "plate", mass, centre, axes)


def density_over_limit(P: Array, kappa: float) -> float:
    """Compute the least density of a body, that of its solid, over the limit of its density.

    ``κ^{d/2} m^{(d + 3)/2} / √det P``, for κ falls with the density to the power of 2/d.

    Args:
        P: pseudo-inertia (d + 1, d + 1), about any origin.
        kappa: κ of the limit, in the same units.

    Returns:
        The quotient; infinite if P is not positive definite.
    """
    try:
        root = float(np.prod(np.diagonal(np.linalg.cholesky(P))))
    except np.linalg.LinAlgError:
        return np.inf
    d = len(P) - 1
    return float((kappa**0.5) ** d * float(P[-1, -1]) ** (0.5 * (d + 3)) / root)


def mass_where_least(per_mass: float, area: float, d: int) -> float:
    """Compute the mass m at which ``per_mass m + area m^{1 + 2/d}`` is least, kg.

    Args:
        per_mass: factor of the mass; the least is at 0 unless it is negative.
        area: factor of the power of the mass, not negative; at 0 the sum has no least.
        d: 2 or 3.
    """
    if per_mass >= 0.0:
        return 0.0
    if area <= 0.0:
        return np.inf
    return float((-per_mass / (area * (1.0 + 2.0 / d))) ** (0.5 * d))


def solid_texts(names: Sequence[str], solids: Sequence[Solid | None]) -> dict[str, str]:
    """Return shape, size, mm, and density, kg/m³, of the solids of bodies by name.

    Bodies without a solid have none.
    """
    return {
        name: f"{solid.name} {solid.size_text}, {solid.density_text}"
        for name, solid in zip(names, solids, strict=False)
        if solid
    }


def solid_data(solid: Solid) -> dict[str, object]:
    """Return a solid as plain data for JSON, in mm and g."""
    return {
        "shape": solid.shape,
        "mass_g": 1e3 * solid.mass,
        "sizes_mm": (1e3 * solid.sizes).tolist(),
        "centre_mm": (1e3 * solid.centre).tolist(),
        "directions": _directions(solid).tolist(),
        "density": solid.density if solid.density < inf else None,
    }


def _directions(solid: Solid) -> Array:
    """Compute unit vectors along the axes (3, 3); zeros along an axis without length."""
    sizes = 0.5 * solid.sizes[:, None]
    return np.asarray(solid.axes / np.where(sizes > 0.0, sizes, 1.0))
