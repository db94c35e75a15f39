"""Inertial parameters as a point mass, its displacements, and pure-inertia rods.

The parameters ``z = [m, mcx, mcy, mcz, Exx, Eyy, Ezz, Exy, Exz, Eyz]`` of a body are those
of a mass m at any chosen point, of a displacement of mass from there, and of six rods that
have inertia but no mass; in a plane ``[m, mcx, mcy, Ezz]`` has one rod. (J. J. de Jong, PhD
thesis, University of Twente, section 5.2.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.support.tolerances import ROD_DYADS_SINGULAR
from kinematics.model.arrays import freeze
from kinematics.model.spatial.inertia import pseudo_inertia
from kinematics.numerics.array_types import Array
from kinematics.wording import count_noun, number_text, vector_text

# Nouns for primitives, and units of their values.
NOUNS = {"mass": "point mass", "displacement": "displacement", "rod": "rod"}
UNITS = {"mass": "kg", "displacement": "kg m", "rod": "kg m²"}
# Six directions whose dyads span all symmetric tensors: along the axes and between them.
RODS = freeze(
    [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
        [0, 0.5**0.5, 0.5**0.5],
        [0.5**0.5, 0, 0.5**0.5],
        [0.5**0.5, 0.5**0.5, 0],
    ]
)


def _stack_parameters(m: Array, mc: Array, S: Array) -> Array:
    """Stack parameters (..., 10): mass, first moment, and second moment ``S = ∫ x xᵀ dm``."""
    xx, yy, zz = S[..., 0, 0], S[..., 1, 1], S[..., 2, 2]
    moments = [yy + zz, xx + zz, xx + yy, -S[..., 0, 1], -S[..., 0, 2], -S[..., 1, 2]]
    return np.stack([m, mc[..., 0], mc[..., 1], mc[..., 2], *moments], axis=-1)


def _dyad(a: Array, b: Array) -> Array:
    """Compute the tensor a bᵀ of vectors (..., 3); shape (..., 3, 3)."""
    return a[..., :, None] * b[..., None, :]


def point_mass(point: ArrayLike) -> Array:
    """Compute the parameters ``(1, r, -[r]²)`` of 1 kg at r (..., 3), metres; (..., 10)."""
    r = np.asarray(point, dtype=np.float64)
    return _stack_parameters(np.ones(r.shape[:-1]), r, _dyad(r, r))


def displacement_dipole(direction: ArrayLike, point: ArrayLike) -> Array:
    """Compute the parameters of a displacement of 1 kg m in direction a at r; (..., 10).

    ``(0, a, -[a][r] - [r][a])``: the derivative of `point_mass` at r along a.

    Args:
        direction: a (..., 3).
        point: r (..., 3), metres.
    """
    a, r = np.broadcast_arrays(
        np.asarray(direction, dtype=np.float64), np.asarray(point, dtype=np.float64)
    )
    return _stack_parameters(np.zeros(a.shape[:-1]), a, _dyad(a, r) + _dyad(r, a))


def rod(direction: ArrayLike) -> Array:
    """Compute the parameters ``(0, 0, -[b]²)`` of a pure-inertia rod of 1 kg m²; (..., 10).

    The rod lies anywhere along the unit vector b (..., 3), has no mass, and its moment of
    inertia about every axis perpendicular to b is 1 kg m².
    """
    b = np.asarray(direction, dtype=np.float64)
    return _stack_parameters(np.zeros(b.shape[:-1]), np.zeros_like(b), _dyad(b, b))


class Primitive(NamedTuple):
    """One element of a mass distribution, in the inertial frame at the reference pose.

    Attributes:
        kind: ``"mass"``, ``"displacement"`` or ``"rod"``.
        body: name of the body that it belongs to.
        value: kg, kg m or kg m²; may be negative.
        point: where it is (3,), metres; None for a rod, which has no place.
        direction: unit vector (3,); None for a mass.
    """

    kind: str
    body: str
    value: float
    point: Array | None = None
    direction: Array | None = None

    def __repr__(self) -> str:
        """One line: value, kind, body, place."""
        where = "" if self.point is None else f" at {vector_text(self.point)} m"
        along = "" if self.direction is None else f" along {vector_text(self.direction)}"
        value = f"{number_text(self.value, '+.4g')} {UNITS[self.kind]}"
        return f"Primitive: {value} {NOUNS[self.kind]} on {self.body}{where}{along}"

    def parameters(self) -> Array:
        """Compute the ten parameters (10,) about the inertial origin, SI units."""
        if self.direction is None:
            return self.value * point_mass(np.asarray(self.point))
        if self.point is None:
            return self.value * rod(self.direction)
        return self.value * displacement_dipole(self.direction, self.point)

    def to_dict(self) -> dict[str, object]:
        """Convert to plain data, ready for JSON."""
        return {
            "kind": self.kind,
            "body": self.body,
            "value": float(self.value),
            "point": None if self.point is None else [float(x) for x in self.point],
            "direction": None if self.direction is None else [float(x) for x in self.direction],
        }


class Multipole(NamedTuple):
    """Parameters of a body as 1 mass, 3 displacements and 6 rods; in a plane 1 + 2 + 1.

    Attributes:
        mass: kg.
        displacement: along the axes (3,) or (2,), kg m.
        rods: values of the rods (6,) or (1,), kg m².
        point: place of the mass and the displacement (3,) or (2,), metres.
        directions: unit vectors along the rods (6, 3); those of a plane have none (0, 2).
    """

    mass: float
    displacement: Array
    rods: Array
    point: Array
    directions: Array

    def __repr__(self) -> str:
        """One line: the place, mass, displacement, number of rods."""
        place, moved = vector_text(self.point), vector_text(self.displacement)
        rods = count_noun(len(self.rods), "rod")
        return f"Multipole at {place} m: {self.mass:.4g} kg, displacement {moved} kg m, {rods}"

    def parameters(self) -> Array:
        """Compute the parameters (10,) or (4,) that were decomposed, SI units."""
        z = _mass_and_displacement(self.mass, self.displacement, self.point)
        if self.point.size == 2:
            z[3] += self.rods[0]
            return z
        return z + self.rods @ rod(self.directions)

    def primitives(self, body: str) -> tuple[Primitive, ...]:
        """List the spatial elements that are not zero, as primitives of a body.

        Raises:
            ValueError: the parameters are planar, which lack the axes of the plane.
        """
        if self.point.size == 2:
            raise ValueError("planar parameters have no primitives in space; give all ten")
        size = float(np.linalg.norm(self.displacement))
        primitives = []
        if self.mass != 0.0:
            primitives.append(Primitive("mass", body, self.mass, self.point))
        if size > 0.0:
            along = self.displacement / size
            primitives.append(Primitive("displacement", body, size, self.point, along))
        rods = zip(self.rods.tolist(), self.directions, strict=True)
        return (*primitives, *(Primitive("rod", body, x, None, b) for x, b in rods if x != 0.0))


def multipole_of(z: ArrayLike, point: ArrayLike, directions: ArrayLike = RODS) -> Multipole:
    """Decompose parameters into a mass and displacements at a point, and rods.

    Args:
        z: parameters (10,), or planar ones ``[m, mcx, mcy, Ezz]`` (4,); any numbers.
        point: (3,), or (2,) in the axes of the plane; metres.
        directions: of the six rods (6, 3), of any length; without effect in a plane.

    Raises:
        ValueError: not every tensor is a sum of rods in these directions, or shapes differ.

    Example:
        >>> import numpy as np
        >>> from balance.bodies import parameters
        >>> from balance.space.inertial_parameters.multipole import multipole_of
        >>> multipole_of(parameters(2.0, [0.1, 0, 0], 0.01 * np.eye(3)), [0, 0, 0])
        Multipole at (0, 0, 0) m: 2 kg, displacement (0.2, 0, 0) kg m, 6 rods
    """
    z, r = np.asarray(z, dtype=np.float64), np.asarray(point, dtype=np.float64)
    if (z.shape, r.shape) not in (((10,), (3,)), ((4,), (2,))):
        raise ValueError(
            f"parameters and point must have shapes (10,) and (3,), or (4,) and (2,), "
            f"not {z.shape} and {r.shape}"
        )
    mass = float(z[0])
    moved = z[1 : 1 + r.size] - mass * r
    remainder = z - _mass_and_displacement(mass, moved, r)
    if r.size == 2:
        return Multipole(mass, moved, remainder[3:], r, np.empty((0, 2)))
    b = _check_directions(directions)
    second = pseudo_inertia(remainder)[:3, :3][_UPPER]
    rods: Array = np.linalg.solve(_dyads(b).T, second).astype(np.float64)
    return Multipole(mass, moved, rods, r, b)


_UPPER = np.triu_indices(3)


def _mass_and_displacement(mass: float, moved: Array, r: Array) -> Array:
    """Compute the parameters of a mass at r and a displacement there."""
    if r.size == 2:
        return np.array([mass, *(mass * r + moved), r @ (mass * r + 2.0 * moved)])
    return mass * point_mass(r) + displacement_dipole(moved, r)


def _dyads(b: Array) -> Array:
    """List the upper entries of b bᵀ for each direction (n, 3); shape (n, 6)."""
    return _dyad(b, b)[:, *_UPPER]


def _check_directions(directions: ArrayLike) -> Array:
    """Normalise six directions.

    Raises:
        ValueError: their dyads are not independent, or the shape is another.
    """
    b = np.asarray(directions, dtype=np.float64)
    if b.shape != (6, 3):
        raise ValueError(f"six directions are needed, of shape (6, 3), not {b.shape}")
    sizes = np.linalg.norm(b, axis=1)
    if sizes.all() and np.isfinite(sizes).all():
        b = b / sizes[:, None]
        if np.linalg.svd(_dyads(b), compute_uv=False)[-1] > ROD_DYADS_SINGULAR:
            return b
    raise ValueError(
        "six rods in these directions do not make up every inertia: take directions that do "
        "not lie on one cone or in two planes, such as the default ones"
    )
