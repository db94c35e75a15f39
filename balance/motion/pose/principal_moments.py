"""Bodies with given principal moments of inertia that have a given angular momentum.

``ξ_c = G ω`` about the centre of mass, with ``G = Rᵀ diag(g) R``. Over all orientations R, ξ_c
fills the ball on the diameter from g3 ω to g1 ω without those on the diameters from g2 ω to
g1 ω and from g3 ω to g2 ω, for g1 ≥ g2 ≥ g3 (J. J. de Jong, PhD thesis, University of Twente,
Fig. 3.2). The right sides of Eqs. 3.29 to 3.31 are printed for ``|ω| = 1``.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import MOMENTS_EQUAL
from kinematics.errors import UsageError
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least


def momentum_margins(g: ArrayLike, omega: ArrayLike, xi: ArrayLike) -> Array:
    """Compute how far inside its bounds an angular momentum is, for principal moments g.

    With sorted moments and ``D_ab = |ξ - ½ (g_a + g_b) ω|``, half differences times |ω|:
    ``½ (g1 - g3) |ω| - D_13``, ``D_12 - ½ (g1 - g2) |ω|``, ``D_23 - ½ (g2 - g3) |ω|``; then
    ``g3`` and ``g2 + g3 - g1``, which are not negative for bodies that can exist.

    Args:
        g: principal moments (3,) in any order, kg m².
        omega: angular velocity (3,), rad/s.
        xi: angular momentum about the centre of mass (3,), N m s.

    Returns:
        Five margins: three in N m s, two in kg m². A body with these moments and this momentum
        exists if and only if none is negative.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eqs. 3.9, 3.10, 3.29 to 3.31.

    Example:
        >>> from balance.motion.pose.principal_moments import momentum_margins
        >>> momentum_margins([3, 2, 1.5], [0, 0, 1], [0.6, 0, 2.2]).round(2).tolist()
        [0.15, 0.17, 0.5, 1.5, 0.5]
    """
    moments, w, x = _sorted(g), *(np.asarray(v, dtype=np.float64) for v in (omega, xi))
    g1, g2, g3 = moments
    rate = float(np.linalg.norm(w))

    def margin(a: float, b: float) -> float:
        """Radius of the ball on the diameter from b ω to a ω, less the distance to it."""
        return 0.5 * (a - b) * rate - float(np.linalg.norm(x - 0.5 * (a + b) * w))

    return np.array([margin(g1, g3), -margin(g1, g2), -margin(g2, g3), g3, g2 + g3 - g1])


def critical_moment(other: float, omega: ArrayLike, xi: ArrayLike) -> float:
    """Compute the principal moment that, with another, puts ξ on the surface of their ball.

    ``ξ·(g ω - ξ) / ω·(g ω - ξ)`` for the other moment g. It bounds g3 from above for ``g = g1``
    and g2 from above for ``g = g3``. For ``g = g2`` it bounds g1 from above if ``ω·ξ`` is above
    ``g2 |ω|²``, and from below if it is under it (printed: from above). A body with two equal
    moments needs this value for them, g being the third (Eq. 3.46).

    Args:
        other: the moment g, kg m².
        omega: angular velocity (3,), rad/s.
        xi: angular momentum about the centre of mass (3,), N m s.

    Returns:
        The moment, kg m²; infinite if ``g |ω|² = ω·ξ``.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eqs. 3.32 to 3.34 and 3.46.

    Example:
        >>> from balance.motion.pose.principal_moments import critical_moment
        >>> critical_moment(3.0, [0, 0, 1], [1, 0, 2])
        1.0
    """
    w, x = (np.asarray(v, dtype=np.float64) for v in (omega, xi))
    off = other * w - x
    below = float(w @ off)
    return float(x @ off) / below if below else np.inf


def inertia_from_moments(g: ArrayLike, omega: ArrayLike, xi: ArrayLike) -> Array:
    """Find a tensor with principal moments g and ``G ω = ξ``.

    In principal axes ``(ω_i²) = [1, g, g²]⁻ᵀ [|ω|², ω·ξ, |ξ|²]``; the rotation between the axes
    takes ``[ω, ξ, ω × ξ]`` to ``[ω_p, g ω_p, ω_p × g ω_p]``. Of the eight choices of signs,
    which make four tensors, all are positive. Where two moments g_e are equal and g_u is not,
    ``G = g_e 1 + (g_u - g_e) a aᵀ`` with a along ``ξ - g_e ω``; where ξ is along ω, one moment
    is that about ω and the others lie across it.

    Args:
        g: principal moments (3,) in any order, kg m².
        omega: angular velocity (3,), rad/s.
        xi: angular momentum about the centre of mass (3,), N m s.

    Returns:
        Symmetric tensor (3, 3), kg m².

    Raises:
        UsageError: no orientation gives this momentum; see `momentum_margins`.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eqs. 3.41 to 3.47.

    Example:
        >>> from balance.motion.pose.principal_moments import inertia_from_moments
        >>> G = inertia_from_moments([3, 2, 1.5], [0, 0, 1], [0.6, 0, 2.2])
        >>> ((G @ [0, 0, 1]).round(12) + 0.0).tolist()
        [0.6, 0.0, 2.2]
    """
    moments, w, x = _sorted(g), *(np.asarray(v, dtype=np.float64) for v in (omega, xi))
    size = float(np.linalg.norm(w)) * moments[0]
    if (
        not size > 0.0
        or momentum_margins(moments, w, x)[:3].min() < -np.sqrt(MOMENTS_EQUAL) * size
    ):
        raise UsageError("no orientation of these principal moments gives the momentum")
    if np.linalg.norm(np.cross(w, x)) <= MOMENTS_EQUAL * size * np.linalg.norm(w):
        return _aligned(moments, w, x)
    for e, u in ((moments[1], moments[2]), (moments[1], moments[0])):
        third = moments[0] if u == moments[2] else moments[2]
        if abs(e - third) <= MOMENTS_EQUAL * moments[0]:
            a = x - e * w
            return np.asarray(e * np.eye(3) + (u - e) * np.outer(a, a) / (a @ a))
    powers = np.vander(moments, 3, increasing=True)
    square = np.linalg.solve(powers.T, [w @ w, w @ x, x @ x])
    local = np.sqrt(np.maximum(square, 0.0))
    here = np.column_stack([w, x, np.cross(w, x)])
    there = np.column_stack([local, moments * local, np.cross(local, moments * local)])
    R = there @ np.linalg.inv(here)
    return np.asarray(R.T @ np.diag(moments) @ R)


def _aligned(moments: Array, w: Array, x: Array) -> Array:
    """Compute a tensor of which ω is a principal axis."""
    rate = float(np.linalg.norm(w))
    n = w / rate
    k = first_least(np.abs(moments - float(n @ x) / rate), float(moments[0]))
    a = np.cross(n, np.eye(3)[first_least(np.abs(n), 1.0)])
    a /= np.linalg.norm(a)
    axes, others = (a, np.cross(n, a)), np.delete(moments, k)
    G = moments[k] * np.outer(n, n)
    for axis, moment in zip(axes, others, strict=True):
        G = G + moment * np.outer(axis, axis)
    return np.asarray(G)


def _sorted(g: ArrayLike) -> Array:
    """Sort principal moments, the largest first."""
    return np.sort(np.asarray(g, dtype=np.float64).reshape(3))[::-1]
