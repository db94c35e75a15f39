"""The products of screws and of masses as tensors of whole numbers, for arrays of any kind.

With the unit twists ``e_a``, ``[ω; v]``, and the unit parameters ``e_b`` of a body,

    BRACKET[a] = ad(e_a),
    RATE[a]    = L(e_a):  the parameters of a body that moves with t have the rate L(t) z,
    MOMENTUM[a, :, b] = [ξ; p] of the parameters e_b at the twist e_a.

With the pseudo-inertia P of z (`kinematics.model.spatial.inertia`) these are

    P(L(t) z) = t̂ P + P t̂ᵀ    and    t̂ P - P t̂ᵀ = [[ξ̂, p], [-pᵀ, 0]].

(J. J. de Jong, PhD thesis, University of Twente, chapters 4 and 5.)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.model.spatial.inertia import from_pseudo_inertia, pseudo_inertia
from kinematics.model.spatial.screws import ad, hat
from kinematics.numerics.array_types import Array


def _rate_and_momentum() -> tuple[Array, Array]:
    """Compute `RATE` and `MOMENTUM` from the products of pseudo-inertias with twists."""
    moved = hat(np.eye(6))[:, None] @ pseudo_inertia(np.eye(10))
    turned = moved - moved.mT
    xi = np.stack([turned[..., 2, 1], turned[..., 0, 2], turned[..., 1, 0]], axis=1)
    p = np.moveaxis(turned[..., :3, 3], -1, 1)
    return from_pseudo_inertia(moved + moved.mT).mT, np.concatenate([xi, p], axis=1)


BRACKET = ad(np.eye(6))
RATE, MOMENTUM = _rate_and_momentum()


class Tensors(NamedTuple):
    """The tensors on those components that count.

    Attributes:
        bracket: ``ad(t) = Σ_a t_a bracket[a]``; (6 or 3, 6 or 3, 6 or 3).
        rate: rates of the parameters, ``Σ_a t_a rate[a] z``.
        momentum: rows of the momentum, ``Σ_a t_a momentum[a] z``.
    """

    bracket: Array
    rate: Array
    momentum: Array


def product_tensors(planar: bool, force: bool) -> Tensors:
    """Select the tensors in space, or for twists ``[ω; v_x; v_y]`` and ``[m, mcx, mcy, Ezz]``.

    Args:
        planar: whether only motion in the plane counts.
        force: whether only linear momentum counts, and with it m and mc.
    """
    twists = [2, 3, 4] if planar else list(range(6))
    z = [0, 1, 2, 6] if planar else list(range(10))
    rows = twists
    if force:
        rows, z = rows[len(rows) // 3 if planar else 3 :], z[: 3 if planar else 4]
    return Tensors(
        BRACKET[np.ix_(twists, twists, twists)],
        RATE[np.ix_(twists, z, z)],
        MOMENTUM[np.ix_(twists, rows, z)],
    )
