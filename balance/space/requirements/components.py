"""Components of the momentum that a requirement is about, as rows on ``[ξ; p]``.

The moment about c is ``ξ - c × p``. The potential energy is ``-g·Σ mc``, and p is the rate of
``Σ mc``: it is constant where ``g·p`` vanishes in every motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from balance.space.requirements.requirement import Requirement
from kinematics.model.arrays import Frame
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.rational import Vector, cross

_ZERO = (Fraction(0),) * 3
_AXES = {axis: tuple(Fraction(int(i == j)) for j in range(3)) for i, axis in enumerate("xyz")}


def exact_rows(
    requirement: Requirement, gravity: Sequence[Fraction], normal: Vector | None = None
) -> tuple[Vector, ...]:
    """Give the rows on ``[ξ; p]`` about the inertial origin, in inertial axes and SI units.

    Args:
        requirement: any but ``decoupled``.
        gravity: g (3,), m/s².
        normal: normal of the plane, of any length, where the linkage is planar: of a moment,
            the component along it is all there is.
    """
    quantity = requirement.quantity
    if quantity == "gravity":
        return (_ZERO + tuple(gravity),)
    axes = [_AXES[axis] for axis in requirement.axes or "xyz"]
    forces = tuple(_ZERO + axis for axis in axes)
    if quantity == "force":
        return forces
    if normal is not None:
        along = [sum(a * n for a, n in zip(axis, normal, strict=True)) for axis in axes]
        axes = [normal] if requirement.axes == "" or any(along) else []
    about = requirement.about
    point = about if isinstance(about, tuple) else _ZERO
    moments = tuple(axis + tuple(-x for x in cross(axis, point)) for axis in axes)
    return moments + forces if quantity == "dynamic" else moments


def chain_rows(rows: Sequence[Vector], frame: Frame, planar: bool, masses: bool) -> Array:
    """Express rows on ``[ξ; p]`` in the coordinates of a chain.

    With ``x = L x' + o``, the momenta are ``p = L p'`` and ``ξ = L² ξ' + o × p``. Rows are
    divided by L, and by the largest entry.

    Args:
        rows: as from `exact_rows`.
        frame: coordinates of the chain.
        planar: whether the momentum is ``[ξn, p1, p2]`` in the axes of the plane.
        masses: whether only linear momentum counts.

    Returns:
        Rows on the momentum of the chain (count, 6, 3 or 2); those that vanish are left out.
    """
    A = np.array([[float(x) for x in row] for row in rows]).reshape(-1, 6)
    xi, p = A[:, :3], A[:, 3:] + np.cross(A[:, :3], frame.origin)
    if planar:
        xi, p = xi @ frame.R[2:].T, p @ frame.R[:2].T
    selected = p if masses else np.concatenate([frame.length * xi, p], axis=1)
    size = np.abs(selected).max(axis=1, initial=0.0)
    return np.asarray((selected / np.where(size, size, 1.0)[:, None])[size > 0.0])
