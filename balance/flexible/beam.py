"""Beams as data, and finite elements of them: stiffness, mass, shapes at points.

An element has the nodal coordinates v, ψ (lateral displacement and rotation of the section) at
both ends, and a (axial displacement) if the beam can stretch. Its shapes satisfy the static
equations of a Timoshenko beam; without shear they are the cubic polynomials of Hermite
(J. S. Przemieniecki, Theory of Matrix Structural Analysis, 1968). Masses and stiffness are
integrated exactly by Gauss quadrature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kinematics.errors import LinkageError

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = [
    "Beam", "GAUSS_POINTS", "GAUSS_WEIGHTS", "Mesh", "bending_matrices", "element_rows",
    "rectangular_beam", "section_shapes", "uniform_mesh",
]  # fmt: skip

Array = NDArray[np.float64]

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
        found = [f"{name} {x:.6g} N" for name, x in more.items() if math.isfinite(x)]
        return ", ".join([f"Beam: {words}", *found])

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return self.line_mass * self.length


def rectangular_beam(
    length: float, thickness: float, width: float, modulus: float, density: float,
    poisson: float = 0.3, shear_factor: float = 5.0 / 6.0, classical: bool = False,
) -> Beam:  # fmt: skip
    """Build a beam of rectangular section.

    Args:
        length: in metres.
        thickness: in the plane of bending, in metres.
        width: across that plane, in metres.
        modulus: Young's modulus, in N/m².
        density: in kg/m³.
        poisson: Poisson's ratio, for the shear modulus.
        shear_factor: κ.
        classical: leave out stretch, shear and rotary inertia (Euler-Bernoulli).

    Raises:
        LinkageError: a number is not positive.
    """
    given = {
        "thickness": thickness, "width": width, "modulus": modulus, "density": density,
        "shear factor": shear_factor, "1 + Poisson's ratio": 1.0 + poisson,
    }  # fmt: skip
    for name, value in given.items():
        if not 0.0 < value < math.inf:
            raise LinkageError(f"beam: {name} {value:g} is not positive")
    area, second = thickness * width, width * thickness**3 / 12.0
    if classical:
        return Beam(length, modulus * second, density * area)
    shear = shear_factor * modulus / (2.0 * (1.0 + poisson)) * area
    return Beam(length, modulus * second, density * area, modulus * area, shear,
                density * second)  # fmt: skip


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
        beam: the beam.
        elements: number of elements, at least; points inside may add some.
        through: positions s that become nodes.
    """
    points = np.array([0.0, beam.length] if through is None else
                      [0.0, *np.sort(through), beam.length])  # fmt: skip
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
    value = a * np.array([
        1.0 - 3.0 * x**2 + 2.0 * x**3 + phi * (1.0 - x),
        h * (x - 2.0 * x**2 + x**3 + 0.5 * phi * (x - x**2)),
        3.0 * x**2 - 2.0 * x**3 + phi * x,
        h * (x**3 - x**2 - 0.5 * phi * (x - x**2)),
    ])  # fmt: skip
    slope = a / h * np.array([
        6.0 * (x**2 - x) - phi,
        h * (1.0 - 4.0 * x + 3.0 * x**2 + 0.5 * phi * (1.0 - 2.0 * x)),
        6.0 * (x - x**2) + phi,
        h * (3.0 * x**2 - 2.0 * x - 0.5 * phi * (1.0 - 2.0 * x)),
    ])  # fmt: skip
    turn = a / h * np.array([
        6.0 * (x**2 - x),
        h * (1.0 - 4.0 * x + 3.0 * x**2 + phi * (1.0 - x)),
        6.0 * (x - x**2),
        h * (3.0 * x**2 - 2.0 * x + phi * x),
    ])  # fmt: skip
    return value, slope, turn


def shear_parameter(beam: Beam, h: float) -> float:
    """Compute 12 EI / (κGA h²) of an element of length h."""
    return 12.0 * beam.bending / (beam.shear * h**2)


def element_rows(mesh: Mesh, s: float) -> tuple[Array, Array, Array]:
    """Evaluate displacement, slope and rotation at a point of a mesh.

    Args:
        mesh: the elements.
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


def bending_matrices(mesh: Mesh) -> tuple[csr_array, csr_array]:
    """Assemble the stiffness and mass matrices of bending, sparse (size, size).

    Args:
        mesh: the elements.

    Returns:
        Stiffness and mass for the coordinates v, ψ of the nodes.
    """
    from scipy.sparse import coo_array

    beam, rows, columns = mesh.beam, [], []
    stiffness, mass = [], []
    for e, h in enumerate(np.diff(mesh.nodes).tolist()):
        k, m = _element_matrices(beam, h)
        at = np.arange(2 * e, 2 * e + 4)
        rows.append(np.repeat(at, 4))
        columns.append(np.tile(at, 4))
        stiffness.append(k.ravel())
        mass.append(m.ravel())
    where = (np.concatenate(rows), np.concatenate(columns))
    shape = (mesh.size, mesh.size)
    return (coo_array((np.concatenate(stiffness), where), shape=shape).tocsr(),
            coo_array((np.concatenate(mass), where), shape=shape).tocsr())  # fmt: skip


def _element_matrices(beam: Beam, h: float) -> tuple[Array, Array]:
    """Compute stiffness and mass (4, 4) of one element."""
    phi = shear_parameter(beam, h)
    c = beam.bending / (h**3 * (1.0 + phi))
    k = c * np.array([
        [12.0, 6.0 * h, -12.0, 6.0 * h],
        [6.0 * h, (4.0 + phi) * h**2, -6.0 * h, (2.0 - phi) * h**2],
        [-12.0, -6.0 * h, 12.0, -6.0 * h],
        [6.0 * h, (2.0 - phi) * h**2, -6.0 * h, (4.0 + phi) * h**2],
    ])  # fmt: skip
    m = np.zeros((4, 4))
    for x, w in zip(GAUSS_POINTS.tolist(), GAUSS_WEIGHTS.tolist(), strict=True):
        value, _, turn = section_shapes(x, h, phi)
        m += w * h * (beam.line_mass * np.outer(value, value)
                      + beam.rotary * np.outer(turn, turn))  # fmt: skip
    return k, m
