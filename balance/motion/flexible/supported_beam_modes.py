"""Modes of a beam on supports: pinned, weighted, clamped, and with bodies at its ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from balance.motion.flexible.beam import (
    Beam,
    Mesh,
    bending_mass,
    element_rows,
    strain_rows,
    uniform_mesh,
)
from balance.motion.flexible.free_beam_modes import FLEX_SCHEMA
from balance.motion.motion_tolerances import MODE_PEAKS_EQUAL, RIGID_MOTION_HELD
from balance.support.result_files import WithPicture
from kinematics.errors import LinkageError
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_largest
from kinematics.wording import count_noun, first_names, number_text


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
class SupportedModes(WithPicture):
    """Modes of a beam on supports.

    Attributes:
        frequencies: circular frequencies ω in rad/s, ascending, 0 if rigid; shape (n,).
        errors: estimates of their relative errors, from half as many elements and from
            round-off, 0 for rigid motions; shape (n,).
        positions: positions s of the nodes of the elements, in metres; shape (m,).
        shapes: displacement of the nodes in each mode, largest entry 1; shape (n, m).
    """

    picture_maker = "flexible_pictures:supported_modes_picture"

    frequencies: Array
    errors: Array
    positions: Array
    shapes: Array

    def __repr__(self) -> str:
        """Number of modes, and the first frequencies."""
        hertz = [number_text(omega / (2.0 * np.pi)) for omega in self.frequencies.tolist()]
        return f"SupportedModes: {count_noun(len(hertz), 'mode')}, {first_names(hertz)} Hz"

    def to_dict(self) -> dict[str, object]:
        """Return plain data for JSON; frequencies in Hz; see ``schemas/flex.schema.json``."""
        return {
            "schema": FLEX_SCHEMA,
            "result": "supported_modes",
            "frequencies": (self.frequencies / (2.0 * np.pi)).tolist(),
            "errors": self.errors.tolist(),
            "positions": self.positions.tolist(),
            "shapes": self.shapes.tolist(),
        }


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
        >>> from balance.motion.flexible.beam import Beam
        >>> from balance.motion.flexible.supported_beam_modes import Support, supported_modes
        >>> pinned = supported_modes(Beam(1, 1, 1), [Support((0.0,)), Support((1.0,))], 1)
        >>> round(float(pinned.frequencies[0]), 4)
        9.8696
    """
    points = [
        s
        for support in supports
        for s in (support.points if isinstance(support, Support) else (support.point,))
    ]
    if not all(0.0 <= s <= beam.length for s in points):
        raise LinkageError(f"a support is not on the beam: give 0 to {beam.length:g} m")
    mesh, coarse = (uniform_mesh(beam, n, np.array(points)) for n in (elements, elements // 2))
    squares, modes = component_modes(mesh, condition_rows(mesh, supports), end_body, count)
    rigid = _rigid_motions(mesh, supports, end_body)[:, :count]
    modes[:, : rigid.shape[1]] = rigid
    frequencies = np.sqrt(np.maximum(squares, 0.0))
    frequencies[: rigid.shape[1]] = 0.0
    squares_of_coarse, _ = component_modes(
        coarse, condition_rows(coarse, supports), end_body, count
    )
    errors = _relative_errors(mesh, frequencies, squares_of_coarse)
    shapes = modes[0::2].T
    scale = np.abs(shapes).max(axis=1)
    peak = np.array(
        [shape[first_largest(np.abs(shape), relative=MODE_PEAKS_EQUAL)] for shape in shapes]
    )
    return SupportedModes(
        frequencies,
        errors,
        mesh.nodes,
        shapes / (np.sign(peak) * np.where(scale > 0.0, scale, 1.0))[:, None],
    )


def _rigid_motions(
    mesh: Mesh, supports: Sequence[Support | Clamp], end_body: EndBody | None
) -> Array:
    """Find the rigid motions that supports allow, as columns (size, 0 to 2).

    A free beam has two, translation and rotation about its centre of mass; one whose supports
    hold one rigid motion turns about the point, or slides, that they leave.
    """
    beam, body = mesh.beam, end_body or EndBody(0.0)
    moment = 0.5 * beam.mass * beam.length + body.mass * (beam.length + body.offset)
    mass = beam.mass + body.mass
    centre = moment / mass if mass > 0.0 else 0.0
    nodes = np.column_stack([mesh.nodes - centre, np.ones(len(mesh.nodes))])
    motions = np.column_stack([np.tile([1.0, 0.0], len(nodes)), nodes.ravel() / beam.length])
    held = condition_rows(mesh, supports) @ motions
    if not len(held):
        return motions
    _, sizes, directions = np.linalg.svd(np.vstack([held, np.zeros((2, 2))]))
    return motions @ directions[sizes <= RIGID_MOTION_HELD].T


def _relative_errors(mesh: Mesh, frequencies: Array, squares_of_coarse: Array) -> Array:
    """Estimate the relative errors (n,) of frequencies.

    With elements twice as long the error is 16 times as large (fourth order), at most.
    Frequencies are exact to the last bits of the largest one, which is below that of the
    stiffest node.
    """
    errors = np.ones(len(frequencies))
    count = min(len(frequencies), len(squares_of_coarse))
    coarse = np.sqrt(np.maximum(squares_of_coarse[:count], 0.0))
    stiffness = (strain_rows(mesh).power(2)).sum(axis=0)
    mass = bending_mass(mesh).diagonal()
    heavy = mass > 0.0
    largest = float((stiffness[heavy] / mass[heavy]).max(initial=0.0))
    bends = frequencies[:count] > 0.0
    exact = np.where(bends, frequencies[:count], 1.0)
    round_off = np.finfo(float).eps * largest**0.5 / exact
    errors[:count] = np.where(bends, np.abs(coarse / exact - 1.0) / 15.0 + round_off, 0.0)
    return errors


def condition_rows(mesh: Mesh, supports: Sequence[Support | Clamp]) -> Array:
    """Write supports as linear conditions on the bending coordinates of a mesh.

    Args:
        supports: pins, whippletrees and clamps.

    Returns:
        Rows (conditions, size) that vanish.
    """
    rows: list[Array] = []
    for support in supports:
        if isinstance(support, Clamp):
            value, _, turn = element_rows(mesh, support.point)
            rows += [value, turn]
        else:
            pairs = zip(support.points, support.weights, strict=True)
            rows.append(np.sum([w * element_rows(mesh, s)[0] for s, w in pairs], axis=0))
    return np.array(rows).reshape(-1, mesh.size)


def component_modes(
    mesh: Mesh, conditions: Array, end_body: EndBody | None = None, count: int | None = None
) -> tuple[Array, Array]:
    """Compute the bending modes of a mesh that satisfy linear conditions.

    Args:
        conditions: rows that vanish (conditions, size).
        end_body: a rigid body at the far end.
        count: number of modes; all of them by default.

    Returns:
        Squares of the circular frequencies (n,), and the modes as columns (size, n), of unit
        generalised mass.

    Raises:
        LinkageError: conditions are dependent, or a mode has no mass.
    """
    from scipy.linalg import LinAlgError, cholesky, null_space, solve_triangular, svd

    mass = bending_mass(mesh).toarray()
    if end_body is not None:
        value, _, turn = element_rows(mesh, mesh.beam.length)
        centre = value + end_body.offset * turn
        mass = mass + end_body.mass * np.outer(centre, centre)
        mass = mass + end_body.inertia * np.outer(turn, turn)
    scale = np.tile([1.0, 1.0 / mesh.beam.length], len(mesh.nodes))
    allowed = (
        scale[:, None] * null_space(conditions * scale) if len(conditions) else (np.diag(scale))
    )
    if allowed.shape[1] != mesh.size - len(conditions):
        raise LinkageError("two supports of a beam are the same: leave one out")
    strains, m = strain_rows(mesh) @ allowed, allowed.T @ mass @ allowed
    try:
        # Reversed roles allow end bodies on beams without mass.
        if mesh.beam.line_mass == 0.0:
            return _massless_modes(strains.T @ strains, m, allowed, count)
        half = cholesky(m)
    except LinAlgError:
        raise LinkageError("a beam without mass needs a body at its end, and a clamp") from None
    # Frequencies are the singular values of R H⁻¹ with M = Hᵀ H, in descending order.
    _, frequencies, directions = svd(solve_triangular(half, strains.T, trans=1).T)
    squares = np.zeros(len(m))
    squares[len(m) - len(frequencies) :] = frequencies[::-1] ** 2
    modes = solve_triangular(half, directions[::-1][:count].T)
    return squares[:count], allowed @ modes


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
