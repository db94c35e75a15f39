"""Build a beam part: a mesh, a frame that follows the beam, modes, and the points with mass."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from balance.motion.flexible.beam import (
    GAUSS_POINTS,
    GAUSS_WEIGHTS,
    Beam,
    Mesh,
    element_rows,
    section_shapes,
    shear_parameter,
    strain_rows,
    uniform_mesh,
)
from balance.motion.flexible.beam_part import BeamPart, Marker
from balance.motion.flexible.supported_beam_modes import (
    Clamp,
    EndBody,
    Support,
    component_modes,
    condition_rows,
)
from kinematics.errors import LinkageError
from kinematics.numerics.array_types import Array

# Three points integrate the square of the slope of a cubic shape exactly.
SLOPE_POINTS, SLOPE_WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class BeamOptions:
    """How a beam is modelled.

    Attributes:
        elements: number of elements, at least.
        modes: number of bending modes that are kept; None for all of the mesh.
        axial_modes: number of modes of stretch, if the beam stretches.
        geometric: whether a bent beam keeps its length; False leaves out centrifugal and
            axial geometric stiffness.
        damping: coefficient β of the damping β K, in seconds.
    """

    elements: int = 16
    modes: int | None = 8
    axial_modes: int = 2
    geometric: bool = True
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            LinkageError: one is out of range.
        """
        if not 1 <= self.elements <= 400:
            raise LinkageError(f"{self.elements} beam elements: give 1 to 400")
        if self.modes is not None and self.modes < 1:
            raise LinkageError(f"{self.modes} beam modes: give at least 1")
        if not 0.0 <= self.damping < np.inf:
            raise LinkageError(f"damping {self.damping:g} s is negative")


@dataclass(frozen=True, eq=False)
class BeamModel:
    """A beam part, and where its points are.

    Attributes:
        part: the part; its frame has its x axis along the undeformed beam.
        mesh: the elements.
        basis: bending coordinates of the nodes per elastic coordinate; shape (size, n).
        stretch: axial displacement of the nodes per elastic coordinate; shape (nodes, n).
        origin: position s of the origin of the frame, in metres.
        slopes: integrals of N'ᵀ N' from s = 0 to each node; shape (nodes, n, n).
        geometric: whether shortening is included.
    """

    part: BeamPart = field(init=False)
    mesh: Mesh
    basis: Array
    stretch: Array
    origin: float
    slopes: Array
    geometric: bool

    def marker(self, s: float, offset: float = 0.0) -> Marker:
        """Locate a point at s along the beam, or ``offset`` beyond it along the section.

        Args:
            s: position along the beam, in metres.
            offset: distance along the rotated axis of the section, in metres.
        """
        value, _, turn = (row @ self.basis for row in element_rows(self.mesh, s))
        along = np.array([np.interp(s, self.mesh.nodes, column) for column in self.stretch.T])
        shortening = np.zeros((len(turn), len(turn)))
        if self.geometric:
            shortening = self._slopes_to(s) - self._slopes_to(self.origin)
            shortening = shortening + offset * np.outer(turn, turn)
        at = np.array([s - self.origin + offset, 0.0])
        return Marker(at, along, value + offset * turn, turn, shortening)

    def _slopes_to(self, s: float) -> Array:
        """Integrate N'ᵀ N' from 0 to s."""
        nodes = self.mesh.nodes
        e = int(np.clip(np.searchsorted(nodes, s, side="right") - 1, 0, len(nodes) - 2))
        local = self.basis[2 * e : 2 * e + 4]
        inside = _slope_integral(self.mesh, e, (s - nodes[e]) / (nodes[e + 1] - nodes[e]))
        return np.asarray(self.slopes[e] + local.T @ inside @ local)


def model_beam(
    name: str,
    beam: Beam,
    frame: Sequence[Support | Clamp],
    options: BeamOptions,
    end_body: EndBody | None = None,
    loading: EndBody | None = None,
    held: Sequence[Support | Clamp] | None = None,
    through: Sequence[float] = (),
) -> BeamModel:
    """Model a beam as a moving part.

    Args:
        name: name of the part.
        frame: what the frame of the part follows: two pins or whippletrees, or one clamp. In
            the frame, these conditions hold; its origin is the first point.
        end_body: a rigid body fixed to the end s = length.
        loading: a body at that end for the choice of the modes alone, as heavy as what is
            joined there, so that few modes represent the forces from it.
        held: supports of the beam whose modes are kept, if not those of the frame: a beam
            that is clamped at one end bends least relative to the chord between its ends.
        through: further positions that become nodes.

    Returns:
        The model.

    Raises:
        LinkageError: the frame does not follow the beam, or a number is out of range.
    """
    inside = [
        s
        for support in frame
        for s in (support.points if isinstance(support, Support) else (support.point,))
    ]
    mesh = uniform_mesh(beam, options.elements, np.array([*inside, *through]))
    conditions = condition_rows(mesh, frame)
    if len(conditions) != 2:
        raise LinkageError(f"beam {name}: the frame needs two pins or one clamp")
    supports = condition_rows(mesh, frame if held is None else held)
    _, bending = component_modes(mesh, supports, loading or end_body, options.modes)
    rigid = np.zeros((mesh.size, 2))
    rigid[0::2, 0], rigid[0::2, 1], rigid[1::2, 1] = 1.0, mesh.nodes, 1.0
    bending = bending - rigid @ np.linalg.solve(conditions @ rigid, conditions @ bending)
    origin = inside[0]
    body = loading or end_body
    axial = _axial_modes(mesh, origin, body.mass if body else 0.0, options.axial_modes)
    n = bending.shape[1]
    basis = np.hstack([bending, np.zeros((mesh.size, axial.shape[1]))])
    stretch = np.hstack([np.zeros((len(mesh.nodes), n)), axial])
    slopes = _node_integrals(mesh, basis)
    model = BeamModel(mesh, basis, stretch, origin, slopes, options.geometric)
    object.__setattr__(model, "part", _beam_part(name, model, options, end_body))
    return model


def _beam_part(
    name: str, model: BeamModel, options: BeamOptions, end_body: EndBody | None
) -> BeamPart:
    """Gather the points with mass of a model."""
    mesh, beam = model.mesh, model.mesh.beam
    points, masses, moments = [], [], []
    for a, b in zip(mesh.nodes, mesh.nodes[1:], strict=False):
        for x, w in zip(GAUSS_POINTS, GAUSS_WEIGHTS, strict=True):
            points.append(model.marker(float(a + x * (b - a))))
            masses.append(w * (b - a) * beam.line_mass)
            moments.append(w * (b - a) * beam.rotary)
    if end_body is not None:
        points.append(model.marker(beam.length, end_body.offset))
        masses.append(end_body.mass)
        moments.append(end_body.inertia)
    strains = strain_rows(mesh) @ model.basis
    stiffness = strains.T @ strains
    if np.isfinite(beam.axial):
        stiffness += model.stretch.T @ _axial_matrices(mesh)[0] @ model.stretch
    stiffness = 0.5 * (stiffness + stiffness.T)
    return BeamPart(
        name,
        tuple(points),
        np.array(masses),
        np.array(moments),
        stiffness,
        options.damping * stiffness,
        tuple(model.marker(float(s)) for s in np.linspace(0.0, beam.length, 33)),
        beam.length,
    )


def _slope_integral(mesh: Mesh, e: int, part: float) -> Array:
    """Integrate N'ᵀ N' over the first ``part`` of element e; shape (4, 4)."""
    h = float(mesh.nodes[e + 1] - mesh.nodes[e])
    phi = shear_parameter(mesh.beam, h)
    total = np.zeros((4, 4))
    for x, w in zip(SLOPE_POINTS, SLOPE_WEIGHTS, strict=True):
        slope = section_shapes(0.5 * part * (1.0 + x), h, phi)[1]
        total += 0.5 * w * part * h * np.outer(slope, slope)
    return total


def _node_integrals(mesh: Mesh, basis: Array) -> Array:
    """Integrate N'ᵀ N' of the elastic coordinates from 0 to each node."""
    integrals = np.zeros((len(mesh.nodes), basis.shape[1], basis.shape[1]))
    for e in range(len(mesh.nodes) - 1):
        local = basis[2 * e : 2 * e + 4]
        integrals[e + 1] = integrals[e] + local.T @ _slope_integral(mesh, e, 1.0) @ local
    return integrals


def _axial_matrices(mesh: Mesh) -> tuple[Array, Array]:
    """Assemble stiffness and mass of stretch with linear elements; shape (nodes, nodes)."""
    n = len(mesh.nodes)
    stiffness, mass = np.zeros((n, n)), np.zeros((n, n))
    for e, h in enumerate(np.diff(mesh.nodes)):
        two = slice(e, e + 2)
        stiffness[two, two] += mesh.beam.axial / h * np.array([[1.0, -1.0], [-1.0, 1.0]])
        mass[two, two] += mesh.beam.line_mass * h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
    return stiffness, mass


def _axial_modes(mesh: Mesh, origin: float, tip: float, count: int) -> Array:
    """Compute modes of stretch that vanish at the origin of the frame; (nodes, count)."""
    n = len(mesh.nodes)
    if not np.isfinite(mesh.beam.axial) or count == 0:
        return np.zeros((n, 0))
    from scipy.linalg import eigh

    stiffness, mass = _axial_matrices(mesh)
    mass[-1, -1] += tip
    free = np.abs(mesh.nodes - origin) > 1e-9 * mesh.beam.length
    both = np.ix_(free, free)
    last = min(count, int(free.sum())) - 1
    modes = np.zeros((n, last + 1))
    modes[free] = eigh(stiffness[both], mass[both], subset_by_index=[0, last])[1]
    return modes
