"""Mass, centre of mass and inertia of each body of a mass distribution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from balance.space.inertial_parameters.conversions import (
    LABELS,
    parameters,
    violations,
)
from balance.support.tolerances import MASS_ROUND_OFF, MOMENT_ROUND_OFF
from kinematics.errors import BodyError
from kinematics.model.arrays import freeze
from kinematics.model.plane import plane_axes
from kinematics.model.spatial.inertia import displace_parameters, inertia_tensor
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, vector_text, without_round_off

# Largest coordinate whose square does not overflow; that of its inverse does not underflow.
LARGEST_COORDINATE = 1e120


@dataclass(frozen=True, eq=False)
class BodyInertia:
    """Inertial parameters of a body, and what follows from them.

    Vectors and tensors are at the reference pose, in SI units. In the link frame of the
    file they keep their values when the linkage moves. Links that fixed joints join are one
    body: its inertia is all of theirs, in the frame of the topmost one.

    Attributes:
        name: name of its link in the file.
        z: parameters about the inertial origin, those that count: (10,), planar (4,);
            without inertia, for force balance, (4,) or planar (3,).
        mass: kg; exactly 0 where it is round-off.
        com: centre of mass (3,) in the inertial frame; None if there is no mass. In planar
            linkages it is put in the plane of the link frame's origin.
        inertia: tensor (3, 3) about the centre of mass, inertial axes; None for planar
            parameters and for force balance. Without mass it is the same about every point,
            or None if there are first moments nevertheless.
        moment: the same for planar parameters: moment of inertia about the normal.
        link_com: centre of mass (3,) in the link frame of the file.
        link_inertia: ``inertia`` in the axes of that frame.
        element: the element ``<inertial>`` of the link, for a planar body that of a thin
            disc in the plane, whether or not a body can have it; None where ``inertia`` and
            ``moment`` are.
        violated: the inequalities that a body satisfies, and this one does not.
        source: file of the linkage.
    """

    name: str
    z: Array
    mass: float
    com: Array | None = None
    inertia: Array | None = None
    moment: float | None = None
    link_com: Array | None = None
    link_inertia: Array | None = None
    element: str | None = None
    violated: tuple[str, ...] = ()
    source: str = ""

    @property
    def urdf(self) -> str | None:
        """The element ``<inertial>`` of a physical body; see ``element``.

        Raises:
            BodyError: no mass distribution has these parameters.
        """
        if self.violated:
            text = f"no body has these masses: {', '.join(self.violated)}"
            remedy = "take other coordinates, or 'element' for the text without this check"
            raise BodyError(self.source, self.name, f"{text}; {remedy}")
        return self.element

    def __repr__(self) -> str:
        """One line: mass, centre of mass and inertia in the link frame."""
        if self.mass == 0.0:
            return f"BodyInertia of {self.name}: no mass"
        com = vector_text(self.link_com) if self.link_com is not None else "none"
        return (
            f"BodyInertia of {self.name}: {number_text(self.mass)} kg at {com} m in "
            "its link frame"
        )


def body_inertias(
    names: Sequence[str],
    basis: Array,
    y: ArrayLike,
    frames: Array,
    axes: Array,
    labels: Sequence[str],
    length: float,
    source: str,
) -> tuple[BodyInertia, ...]:
    """Compute mass, centre of mass and inertia of every body of ``basis @ y``.

    Args:
        basis: of a design space (parameters, nullity); its columns are of size 1.
        y: coordinates (nullity,).
        frames: poses of the link frames (bodies, 4, 4).
        axes: rows are the axes of planar parameters (3, 3).
        labels: names of the parameters of one body.
        length: the length in units of which the columns are of size 1, metres.
        source: file of the linkage.

    Raises:
        ValueError: y has another shape, is not real and finite, or is too large or too small
            for double precision.
    """
    y = _check_coordinates(y, basis.shape[1])
    parts, size = freeze(basis @ y).reshape(len(names), len(labels)), float(np.linalg.norm(y))
    return tuple(
        replace(_body_inertia(name, part, frame, axes, labels, size, length), source=source)
        for name, part, frame in zip(names, parts, frames, strict=True)
    )


def bodies_of_parameters(
    names: Sequence[str], z: Array, frames: Array, axes: Array, length: float, source: str
) -> tuple[BodyInertia, ...]:
    """Compute mass, centre of mass and inertia of every body of ten parameters each.

    Args:
        z: parameters (10 bodies,), SI units, inertial frame.
        frames: as for `body_inertias`.
        axes: likewise.
        length: likewise.
        source: likewise.
    """
    # The column is about of size 1; a power of two scales without rounding.
    scale = 2.0 ** np.round(np.log2(np.linalg.norm(z)))
    column = z.reshape(-1, 1) / scale
    return body_inertias(names, column, [scale], frames, axes, LABELS, length, source)


def _check_coordinates(y: ArrayLike, count: int) -> Array:
    """Convert coordinates (count,) to real numbers.

    Raises:
        ValueError: y is no such array; see `body_inertias`.
    """
    given = np.asarray(y)
    wanted = f"give {count} finite numbers, one per dimension of the design space"
    if given.dtype.kind not in "biufO":
        raise ValueError(f"coordinates y of type {given.dtype}: {wanted}")
    try:
        numbers = given.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"coordinates y of type {given.dtype}: {wanted}") from None
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise ValueError(f"coordinates y of shape {numbers.shape}: {wanted}")
    largest = float(np.abs(numbers).max(initial=0.0))
    if largest and not 1.0 / LARGEST_COORDINATE < largest < LARGEST_COORDINATE:
        limits = f"{1.0 / LARGEST_COORDINATE:.0e} to {LARGEST_COORDINATE:.0e}"
        raise ValueError(
            f"coordinates y of size {largest:.1e}: give numbers whose largest is from {limits}"
        )
    return numbers


def in_link_frames(basis: Array, frames: Array, axes: Array, labels: Sequence[str]) -> Array:
    """Express a basis in the link frames: about their origins and in their axes.

    A planar body gets the axes that `kinematics.model.plane.plane_axes` finds for the normal
    in its link frame.

    Args:
        basis: of a design space (parameters, nullity), SI units.
        frames: poses of the link frames (bodies, 4, 4).
        axes: rows are the axes of planar parameters (3, 3).
        labels: names of the parameters of one body.

    Returns:
        The basis (parameters, nullity) in the link frames.
    """
    changes = np.array([_change_of_frame(frame, axes, labels) for frame in frames])
    parts = basis.reshape(*changes.shape[:2], basis.shape[1])
    return freeze((changes @ parts).reshape(basis.shape))


def _body_inertia(
    name: str,
    z: Array,
    frame: Array,
    axes: Array,
    labels: Sequence[str],
    size: float,
    length: float,
) -> BodyInertia:
    planar, n = "mcz" not in labels, axes[2]
    moments = z[1:3] if planar else z[1:4]
    R, origin = frame[:3, :3], frame[:3, 3]
    mass, c, com, link_com = 0.0, np.zeros(moments.size), None, None
    if abs(z[0]) > MASS_ROUND_OFF * size:
        mass = float(z[0])
        c = moments / mass
        com = freeze(c @ axes[:2] + (n @ origin) * n if planar else c)
        link_com = freeze(R.T @ (com - origin))
    elif np.abs(moments).max() > MASS_ROUND_OFF * size * length:
        return BodyInertia(name, z, mass)
    at = np.zeros(3) if link_com is None else link_com
    if "Ezz" not in labels:
        return BodyInertia(name, z, mass, com, link_com=link_com)
    moment = inertia = local = None
    if planar:
        moment, m = float(z[3] - mass * (c @ c)), R.T @ n
        whole = 0.5 * moment * (np.eye(3) + np.outer(m, m))
    else:
        inertia = freeze(inertia_tensor(z) - mass * (c @ c * np.eye(3) - np.outer(c, c)))
        whole = local = freeze(R.T @ inertia @ R)
    element = inertial_element(mass, at, whole, length)
    about = MOMENT_ROUND_OFF * float(np.abs(z[3:] if planar else z[4:]).max())
    unreal = violations(
        parameters(mass, np.zeros(3), whole),
        floor=max(about, MASS_ROUND_OFF * size * length**2),
    )
    return BodyInertia(
        name, z, mass, com, inertia, moment, link_com, local, element, tuple(unreal)
    )


def written_inertia(inertia: Array) -> Array:
    """Return a tensor (3, 3) with zeros in place of products of inertia that are round-off."""
    products = without_round_off(inertia, float(np.abs(inertia).max()))
    return np.where(np.eye(3) > 0.0, inertia, products)


def inertial_element(mass: float, com: Array, inertia: Array, length: float) -> str:
    """Write the element ``<inertial>``: tensor about the centre of mass, axes of the link.

    Args:
        mass: kg.
        com: centre of mass in the link frame (3,), metres.
        inertia: tensor (3, 3), kg m².
        length: a length of the linkage, metres; coordinates below `WRITTEN_AS_ZERO` of it, and
            products of inertia below that part of the tensor, are written as 0.
    """
    com, inertia = without_round_off(com, length), written_inertia(inertia)
    xyz = " ".join(repr(float(value)) for value in com)
    i, j = np.triu_indices(3)
    names = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    moments = " ".join(
        f'{name}="{float(value)!r}"' for name, value in zip(names, inertia[i, j], strict=True)
    )
    return (
        "<inertial>\n"
        f'  <origin xyz="{xyz}" rpy="0 0 0"/>\n'
        f'  <mass value="{mass!r}"/>\n'
        f"  <inertia {moments}/>\n"
        "</inertial>"
    )


def _change_of_frame(frame: Array, axes: Array, labels: Sequence[str]) -> Array:
    """Compute the matrix from parameters in the inertial frame to those in the link frame."""
    count, R, origin = len(labels), frame[:3, :3], frame[:3, 3]
    if "mcz" in labels:
        back = np.eye(4)
        back[:3, :3], back[:3, 3] = R.T, -R.T @ origin
        return displace_parameters(np.eye(len(LABELS)), back).T[:count, :count]
    turn = plane_axes(R.T @ axes[2])[:2] @ R.T @ axes[:2].T
    x, y = axes[:2] @ origin
    G = np.eye(4)
    G[1:3, 1:3] = turn
    G[1:3, 0] = -turn @ (x, y)
    G[3, :3] = x * x + y * y, -2.0 * x, -2.0 * y
    return G[:count, :count]
