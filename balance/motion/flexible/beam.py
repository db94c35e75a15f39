"""Beams as data, and finite elements of them: stiffness, mass, shapes at points.

An element has the nodal coordinates v, ψ (lateral displacement and rotation of the section) at
both ends, and a (axial displacement) if the beam can stretch. Its shapes satisfy the static
equations of a Timoshenko beam; without shear they are the cubic polynomials of Hermite
(J. S. Przemieniecki, Theory of Matrix Structural Analysis, 1968). Masses and stiffness are
integrated exactly by Gauss quadrature.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from kinematics.errors import LinkageError
from kinematics.numerics.array_types import Array, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array


# Four points integrate the mass of cubic shapes exactly.
GAUSS_POINTS: Array = 0.5 + 0.5 * np.polynomial.legendre.leggauss(4)[0]
GAUSS_WEIGHTS: Array = 0.5 * np.polynomial.legendre.leggauss(4)[1]


@dataclass(frozen=True)
class Beam:
    """A uniform beam that bends in the plane.

    Attributes:
        length: in metres.
        bending: EI, in N m².
        line_mass: ρA, in kg/m.
        axial: EA, in N; infinity if the beam does not stretch.
        shear: κGA, in N; infinity without shear deformation.
        rotary: ρI, rotary inertia of the section, in kg m.

    Raises:
        LinkageError: a number is not positive (``rotary``: is negative), or not finite where
            it must be.
    """

    length: float
    bending: float
    line_mass: float
    axial: float = math.inf
    shear: float = math.inf
    rotary: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers."""
        for name in ("length", "bending"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise LinkageError(f"beam: {name} {getattr(self, name):g} is not positive")
        for name in ("axial", "shear"):
            if not getattr(self, name) > 0.0:
                raise LinkageError(f"beam: {name} {getattr(self, name):g} is not positive")
        for name in ("line_mass", "rotary"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise LinkageError(f"beam: {name} {getattr(self, name):g} is negative")

    def __repr__(self) -> str:
        """Length, stiffness and mass, and what else is finite."""
        words = f"{self.length:.6g} m, EI {self.bending:.6g} N m², {self.line_mass:.6g} kg/m"
        more = {"EA": self.axial, "κGA": self.shear}
        stiffnesses = [f"{name} {x:.6g} N" for name, x in more.items() if math.isfinite(x)]
        return ", ".join([f"Beam: {words}", *stiffnesses])

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return self.line_mass * self.length


def rectangular_beam(
    length: float,
    thickness: float,
    width: float,
    modulus: float,
    density: float,
    poisson: float = 0.3,
    shear_factor: float = 5.0 / 6.0,
    classical: bool = False,
) -> Beam:
    """Build a beam of rectangular section.

    Args:
        length: in metres.
        thickness: in the plane of bending, in metres.
        width: across that plane, in metres.
        modulus: Young's modulus, in N/m².
        density: in kg/m³.
        poisson: Poisson's ratio, for the shear modulus.
        shear_factor: shear area over the area of the section.
        classical: leave out stretch, shear and rotary inertia (Euler-Bernoulli).

    Raises:
        LinkageError: a number is not positive.
    """
    given = {
        "thickness": thickness,
        "width": width,
        "modulus": modulus,
        "density": density,
        "shear factor": shear_factor,
        "1 + Poisson's ratio": 1.0 + poisson,
    }
    for name, value in given.items():
        if not 0.0 < value < math.inf:
            raise LinkageError(f"beam: {name} {value:g} is not positive")
    area, second = thickness * width, width * thickness**3 / 12.0
    if classical:
        return Beam(length, modulus * second, density * area)
    shear = shear_factor * modulus / (2.0 * (1.0 + poisson)) * area
    return Beam(
        length, modulus * second, density * area, modulus * area, shear, density * second
    )


@dataclass(frozen=True, eq=False)
class Mesh:
    """Elements of a beam.

    Attributes:
        beam: the beam.
        nodes: positions s of the nodes from 0 to the length, ascending; shape (n + 1,).
    """

    beam: Beam
    nodes: Array

    @property
    def size(self) -> int:
        """Number of bending coordinates: v and ψ of each node."""
        return 2 * len(self.nodes)


def uniform_mesh(beam: Beam, elements: int, through: Array | None = None) -> Mesh:
    """Divide a beam into nearly equal elements, with nodes at given points.

    Args:
        elements: number of elements, at least; points inside may add some.
        through: positions s that become nodes.
    """
    points = np.array(
        [0.0, beam.length] if through is None else [0.0, *np.sort(through), beam.length]
    )
    points = points[np.concatenate([[True], np.diff(points) > 1e-9 * beam.length])]
    points[-1] = beam.length
    spans = np.diff(points)
    counts = np.maximum(1, np.rint(elements * spans / beam.length).astype(int))
    parts = [
        np.linspace(a, b, count, endpoint=False)
        for a, b, count in zip(points, points[1:], counts, strict=False)
    ]
    return Mesh(beam, np.append(np.concatenate(parts), beam.length))


def section_shapes(x: float, h: float, phi: float) -> tuple[Array, Array, Array]:
    """Evaluate the shapes of an element at x = 0 … 1.

    Args:
        x: position over the length of the element.
        h: length of the element, in metres.
        phi: shear parameter 12 EI / (κGA h²); 0 without shear.

    Returns:
        Rows (4,) for the coordinates v0, ψ0, v1, ψ1: displacement, slope dv/ds, rotation of
        the section.
    """
    a = 1.0 / (1.0 + phi)
    value = a * np.array(
        [
            1.0 - 3.0 * x**2 + 2.0 * x**3 + phi * (1.0 - x),
            h * (x - 2.0 * x**2 + x**3 + 0.5 * phi * (x - x**2)),
            3.0 * x**2 - 2.0 * x**3 + phi * x,
            h * (x**3 - x**2 - 0.5 * phi * (x - x**2)),
        ]
    )
    slope = (
        a
        / h
        * np.array(
            [
                6.0 * (x**2 - x) - phi,
                h * (1.0 - 4.0 * x + 3.0 * x**2 + 0.5 * phi * (1.0 - 2.0 * x)),
                6.0 * (x - x**2) + phi,
                h * (3.0 * x**2 - 2.0 * x - 0.5 * phi * (1.0 - 2.0 * x)),
            ]
        )
    )
    turn = (
        a
        / h
        * np.array(
            [
                6.0 * (x**2 - x),
                h * (1.0 - 4.0 * x + 3.0 * x**2 + phi * (1.0 - x)),
                6.0 * (x - x**2),
                h * (3.0 * x**2 - 2.0 * x + phi * x),
            ]
        )
    )
    return value, slope, turn


def shear_parameter(beam: Beam, h: float) -> float:
    """Compute 12 EI / (κGA h²) of an element of length h."""
    return 12.0 * beam.bending / (beam.shear * h**2)


def element_rows(mesh: Mesh, s: float) -> tuple[Array, Array, Array]:
    """Evaluate displacement, slope and rotation at a point of a mesh.

    Args:
        s: position along the beam, from 0 to its length, in metres.

    Returns:
        Three rows over all bending coordinates (size,).
    """
    e = int(np.clip(np.searchsorted(mesh.nodes, s, side="right") - 1, 0, len(mesh.nodes) - 2))
    h = float(mesh.nodes[e + 1] - mesh.nodes[e])
    x = (s - float(mesh.nodes[e])) / h
    rows = np.zeros((3, mesh.size))
    rows[:, 2 * e : 2 * e + 4] = section_shapes(x, h, shear_parameter(mesh.beam, h))
    return rows[0], rows[1], rows[2]


def strain_rows(mesh: Mesh) -> csr_array:
    """Assemble the strains of the elements in bending, sparse (2 elements, size).

    An element of length h with the shear parameter φ has the energy

        EI / 2h (ψ1 - ψ0)² + 6 EI / (h (1 + φ)) ((ψ0 + ψ1) / 2 - (v1 - v0) / h)²,

    and a row for each square: the stiffness matrix is ``RᵀR``. The lowest frequencies lose half
    as many digits by the rows as by their products.

    Returns:
        Rows R over the coordinates v, ψ of the nodes, in √(N m).

    Source:
        J. S. Przemieniecki, Theory of Matrix Structural Analysis (1968), section 5.6, for the
        stiffness.
    """
    rows = [_strains(mesh.beam, h) for h in np.diff(mesh.nodes).tolist()]
    at = np.arange(2 * len(rows)).reshape(-1, 2)
    return _assembled(mesh, rows, at)


def bending_mass(mesh: Mesh) -> csr_array:
    """Assemble the mass matrix of bending, sparse (size, size), for v, ψ of the nodes."""
    masses = [_element_mass(mesh.beam, h) for h in np.diff(mesh.nodes).tolist()]
    return _assembled(mesh, masses, _columns(mesh))


def _columns(mesh: Mesh) -> IntArray:
    """Coordinates v0, ψ0, v1, ψ1 of each element; shape (elements, 4)."""
    return 2 * np.arange(len(mesh.nodes) - 1)[:, None] + np.arange(4)


def _assembled(mesh: Mesh, blocks: Sequence[Array], at: IntArray) -> csr_array:
    """Add blocks of elements up in a sparse matrix, at given rows of each (elements, n)."""
    from scipy.sparse import coo_array

    columns = _columns(mesh)
    rows = np.broadcast_to(at[:, :, None], (*at.shape, 4)).ravel()
    places = np.broadcast_to(columns[:, None, :], (*at.shape, 4)).ravel()
    shape = (int(at.max()) + 1, mesh.size)
    return coo_array((np.array(blocks).ravel(), (rows, places)), shape=shape).tocsr()


def _strains(beam: Beam, h: float) -> Array:
    """Compute the strains (2, 4) of one element; see `strain_rows`."""
    phi = shear_parameter(beam, h)
    return np.sqrt(beam.bending / h) * np.array(
        [
            np.array([0.0, -1.0, 0.0, 1.0]),
            np.sqrt(12.0 / (1.0 + phi)) * np.array([1.0 / h, 0.5, -1.0 / h, 0.5]),
        ]
    )


def _element_mass(beam: Beam, h: float) -> Array:
    """Compute the mass matrix (4, 4) of one element."""
    phi = shear_parameter(beam, h)
    m = np.zeros((4, 4))
    for x, w in zip(GAUSS_POINTS.tolist(), GAUSS_WEIGHTS.tolist(), strict=True):
        value, _, turn = section_shapes(x, h, phi)
        m += (
            w
            * h
            * (beam.line_mass * np.outer(value, value) + beam.rotary * np.outer(turn, turn))
        )
    return m
