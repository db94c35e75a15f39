"""Modes of a beam on supports: pinned, weighted, clamped, and with bodies at its ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.flexible.beam import Beam, Mesh, bending_matrices, element_rows, uniform_mesh
from balance.motion_tolerances import MODE_PEAKS_EQUAL
from kinematics.errors import LinkageError
from kinematics.linalg.ties import first_largest
from kinematics.wording import count_noun, first_names

__all__ = [
    "Clamp", "EndBody", "Support", "SupportedModes", "component_modes", "condition_rows",
    "supported_modes",
]  # fmt: skip

Array = NDArray[np.float64]


class Support(NamedTuple):
    """A pin, or a whippletree: the weighted sum Σ W v(s) of deflections vanishes.

    Attributes:
        points: positions s along the beam, in metres.
        weights: as many, of sum 1.
    """

    points: tuple[float, ...]
    weights: tuple[float, ...] = (1.0,)


class Clamp(NamedTuple):
    """A clamp: neither displacement nor rotation of the section at s, in metres."""

    point: float


class EndBody(NamedTuple):
    """A rigid body fixed to the far end of a beam.

    Attributes:
        mass: in kg.
        offset: distance of its centre of mass beyond the end, in metres.
        inertia: about its centre of mass, in kg m².
    """

    mass: float
    offset: float = 0.0
    inertia: float = 0.0


@dataclass(frozen=True, eq=False)
class SupportedModes:
    """Modes of a beam on supports.

    Attributes:
        frequencies: circular frequencies ω in rad/s, ascending; shape (n,).
        positions: positions s of the nodes of the elements, in metres; shape (m,).
        shapes: displacement of the nodes in each mode, largest entry 1; shape (n, m).
    """

    frequencies: Array
    positions: Array
    shapes: Array

    def __repr__(self) -> str:
        """Number of modes, and the first frequencies."""
        hertz = [f"{omega / (2.0 * np.pi):.4g}" for omega in self.frequencies.tolist()]
        return f"SupportedModes: {count_noun(len(hertz), 'mode')}, {first_names(hertz)} Hz"


def supported_modes(
    beam: Beam,
    supports: Sequence[Support | Clamp],
    count: int = 6,
    elements: int = 96,
    end_body: EndBody | None = None,
) -> SupportedModes:
    """Compute the modes of a beam on supports by finite elements.

    Args:
        beam: the beam; its line mass must be positive unless there is an end body.
        supports: pins, whippletrees and clamps; none of them for a free beam.
        count: number of modes, rigid motions included.
        elements: number of elements, at least; supports inside an element divide it.
        end_body: a rigid body at the end s = length.

    Returns:
        The modes; frequencies converge with the fourth power of the element length.

    Raises:
        LinkageError: a support is not on the beam, supports are dependent, or nothing has mass.

    Example:
        >>> from balance.flexible.beam import Beam
        >>> from balance.flexible.supported_modes import Support, supported_modes
        >>> pinned = supported_modes(Beam(1, 1, 1), [Support((0.0,)), Support((1.0,))], 1)
        >>> round(float(pinned.frequencies[0]), 4)
        9.8696
    """
    inside = [s for one in supports for s in (one.points if isinstance(one, Support)
              else (one.point,))]  # fmt: skip
    if not all(0.0 <= s <= beam.length for s in inside):
        raise LinkageError(f"a support is not on the beam: give 0 to {beam.length:g} m")
    mesh = uniform_mesh(beam, elements, np.array(inside))
    squares, basis = component_modes(mesh, condition_rows(mesh, supports), end_body, count)
    shapes = basis[0::2].T
    scale = np.abs(shapes).max(axis=1)
    peak = np.array(
        [shape[first_largest(np.abs(shape), relative=MODE_PEAKS_EQUAL)] for shape in shapes]
    )
    return SupportedModes(
        np.sqrt(np.maximum(squares, 0.0)), mesh.nodes,
        shapes / (np.sign(peak) * np.where(scale > 0.0, scale, 1.0))[:, None],
    )  # fmt: skip


def condition_rows(mesh: Mesh, supports: Sequence[Support | Clamp]) -> Array:
    """Write supports as linear conditions on the bending coordinates of a mesh.

    Args:
        mesh: the elements.
        supports: pins, whippletrees and clamps.

    Returns:
        Rows (conditions, size) that vanish.
    """
    rows: list[Array] = []
    for one in supports:
        if isinstance(one, Clamp):
            value, _, turn = element_rows(mesh, one.point)
            rows += [value, turn]
        else:
            pairs = zip(one.points, one.weights, strict=True)
            rows.append(np.sum([w * element_rows(mesh, s)[0] for s, w in pairs], axis=0))
    return np.array(rows).reshape(-1, mesh.size)


def component_modes(
    mesh: Mesh, conditions: Array, end_body: EndBody | None = None, count: int | None = None
) -> tuple[Array, Array]:
    """Compute the bending modes of a mesh that satisfy linear conditions.

    Args:
        mesh: the elements.
        conditions: rows that vanish (conditions, size).
        end_body: a rigid body at the far end.
        count: number of modes; all of them by default.

    Returns:
        Squares of the circular frequencies (n,), and the modes as columns (size, n), of unit
        generalised mass.

    Raises:
        LinkageError: conditions are dependent, or a mode has no mass.
    """
    from scipy.linalg import LinAlgError, eigh, null_space

    stiffness, mass = (matrix.toarray() for matrix in bending_matrices(mesh))
    if end_body is not None:
        value, _, turn = element_rows(mesh, mesh.beam.length)
        centre = value + end_body.offset * turn
        mass = mass + end_body.mass * np.outer(centre, centre)
        mass = mass + end_body.inertia * np.outer(turn, turn)
    scale = np.tile([1.0, 1.0 / mesh.beam.length], len(mesh.nodes))
    allowed = scale[:, None] * null_space(conditions * scale) if len(conditions) else (
        np.diag(scale)
    )  # fmt: skip
    if allowed.shape[1] != mesh.size - len(conditions):
        raise LinkageError("two supports of a beam are the same: leave one out")
    k, m = allowed.T @ stiffness @ allowed, allowed.T @ mass @ allowed
    last = None if count is None else [0, min(count, len(k)) - 1]
    try:
        # Reversed roles allow end bodies on beams without mass.
        if mesh.beam.line_mass == 0.0:
            return _massless_modes(k, m, allowed, count)
        squares, modes = eigh(k, m, subset_by_index=last)
    except LinAlgError:
        raise LinkageError("a beam without mass needs a body at its end, and a clamp") from None
    return squares, allowed @ modes


def _massless_modes(
    k: Array, m: Array, allowed: Array, count: int | None
) -> tuple[Array, Array]:
    """Compute the modes of a beam without mass: those of its end body alone.

    Raises:
        LinAlgError: the beam is not held.
    """
    from scipy.linalg import eigh

    compliances, modes = eigh(m, k)
    held = compliances > 1e-12 * compliances[-1]
    order = np.flatnonzero(held)[::-1][:count]
    scale = 1.0 / np.sqrt(compliances[order])
    return 1.0 / compliances[order], allowed @ (modes[:, order] * scale)
