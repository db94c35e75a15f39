"""Displacements and screws of many linkages at once, in the plane or in space.

In the plane a twist is ``[ω; v_x; v_y]`` and a displacement a 3×3 matrix; in space they are
those of `kinematics.model.spatial.screws`. Functions broadcast over leading dimensions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.space.momentum.product_tensors import Tensors, product_tensors
from kinematics.model.spatial.screws import Ad, ad, exp, vee

Array = NDArray[np.float64]


class Algebra(NamedTuple):
    """Functions of displacements and twists with ``dim`` components.

    Attributes:
        dim: number of components of a twist, 3 or 6.
        parameters: number of inertial parameters of a body, 4 or 10.
        exp: displacement of a joint, from unit screws (…, dim) and positions (…).
        adjoint: matrix (…, dim, dim) that carries twists along with a displacement.
        bracket: matrix (…, dim, dim) of the Lie bracket with a twist (…, dim).
        gap: twist (…, dim) that vanishes, near the identity, only for the identity.
        tensors: products of twists and masses.
    """

    dim: int
    parameters: int
    exp: Callable[[Array, Array], Array]
    adjoint: Callable[[Array], Array]
    bracket: Callable[[Array], Array]
    gap: Callable[[Array], Array]
    tensors: Tensors

    def inverse(self, H: Array) -> Array:
        """Invert displacements ``[R, d; 0, 1]``: ``[Rᵀ, -Rᵀ d; 0, 1]``."""
        out = np.zeros_like(H)
        R = np.swapaxes(H[..., :-1, :-1], -1, -2)
        out[..., :-1, :-1] = R
        out[..., :-1, -1:] = -R @ H[..., :-1, -1:]
        out[..., -1, -1] = 1.0
        return out


def split_twists(twists: Array, planar: bool) -> Array:
    """Keep the components of spatial twists (…, 6) that the algebra has.

    Args:
        twists: ``[ω; v]``, of motion in the plane if ``planar``.
        planar: whether the algebra is that of the plane xy.
    """
    return twists[..., 2:5] if planar else twists


def _plane_exp(screws: Array, q: Array) -> Array:
    """Compute ``exp(q ŝ)`` for ``[1; v]`` and ``[0; v]``; shape (…, 3, 3)."""
    w, x, y = screws[..., 0], screws[..., 1], screws[..., 2]
    angle = w * q
    cosine, sine = np.cos(angle), np.sin(angle)
    along = np.where(w != 0.0, sine, q)
    across = 2.0 * np.sin(0.5 * angle) ** 2
    H = np.zeros((*angle.shape, 3, 3))
    H[..., 0, 0] = H[..., 1, 1] = cosine
    H[..., 0, 1], H[..., 1, 0] = -sine, sine
    H[..., 0, 2], H[..., 1, 2] = along * x - across * y, along * y + across * x
    H[..., 2, 2] = 1.0
    return H


def _plane_adjoint(H: Array) -> Array:
    """Compute ``Ad(H)`` with ``Ad(H) [ω; v] = [ω; R v + ω (d_y; -d_x)]``."""
    matrix = np.zeros_like(H)
    matrix[..., 0, 0] = 1.0
    matrix[..., 1:, 1:] = H[..., :2, :2]
    matrix[..., 1, 0], matrix[..., 2, 0] = H[..., 1, 2], -H[..., 0, 2]
    return matrix


def _plane_bracket(t: Array) -> Array:
    """Compute ``ad(t)``: the derivative of ``Ad`` along the twist ``[ω; v]``."""
    matrix = np.zeros((*t.shape[:-1], 3, 3))
    matrix[..., 1, 0], matrix[..., 2, 0] = t[..., 2], -t[..., 1]
    matrix[..., 1, 2], matrix[..., 2, 1] = -t[..., 0], t[..., 0]
    return matrix


def _plane_gap(H: Array) -> Array:
    """Read off ``[sin φ; d]``."""
    return np.stack([H[..., 1, 0], H[..., 0, 2], H[..., 1, 2]], axis=-1)


PLANE = Algebra(
    3, 4, _plane_exp, _plane_adjoint, _plane_bracket, _plane_gap, product_tensors(True, False)
)
SPACE = Algebra(6, 10, exp, Ad, ad, vee, product_tensors(False, False))
