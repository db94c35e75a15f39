"""Unbalanced shafts that cancel harmonics of the shaking of a crank at constant speed.

Write the plane as complex numbers. At the unit rate of the crank angle u, the force and the
moment of the base on a planar linkage are

    f(u) = Σ_k c_k e^{iku},   k = …, -1, 0, 1, …        M(u) = Σ_k M_k e^{iku}.

The part of ``c_k`` and ``c_{-k}`` is a force whose tip runs on an ellipse. A shaft that turns k
times as fast as the crank, with the unbalance ``s = m r`` at u = 0, takes the force
``-k² s e^{iku}`` from the base, so that ``s_k = c_k / k²`` for k and -k cancel it: two shafts
for each harmonic, which turn against each other. (Lanchester's pair is the case of a force on a
line, ``|c_k| = |c_{-k}|``.) Where they stand is free, and decides about the moment: that of the
base on a shaft at p is ``Im(p̄ (-c_k e^{iku}))``, and the harmonic k of the moment vanishes if

    -p̄_k c_k + p_{-k} c̄_{-k} = -2i M_k.

Both shafts stand as near to a place q as this equation lets them, by the least sum of squares.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from kinematics.numerics.array_types import Array, IntArray


class Harmonics(NamedTuple):
    """Shaking of a planar linkage over one turn of its crank at its unit rate.

    Attributes:
        orders: k of each part: 1, 2 … (h,).
        forward: ``c_k`` (h,), complex, N s².
        backward: ``c_{-k}`` (h,), likewise.
        moment: ``M_k`` (h,), complex, about the origin, N m s².
    """

    orders: Array
    forward: Array
    backward: Array
    moment: Array

    @property
    def forces(self) -> Array:
        """Largest force of each order (h,): the long half axis of its ellipse, N s²."""
        return np.asarray(np.abs(self.forward) + np.abs(self.backward))

    @property
    def moments(self) -> Array:
        """Amplitude of the moment of each order (h,), N m s²."""
        return 2.0 * np.abs(self.moment)


class Shaft(NamedTuple):
    """An unbalanced shaft.

    Attributes:
        ratio: its turns for one turn of the crank, k or -k.
        unbalance: s, mass times eccentricity at ``u = 0``, complex, kg m.
        place: p of its axis, complex, metres.
    """

    ratio: int
    unbalance: complex
    place: complex


def harmonics_of(u: Array, force: Array, moment: Array, orders: IntArray) -> Harmonics:
    """Compute harmonics of a periodic shaking.

    Args:
        u: angles of the crank over one turn (N,), evenly spaced, without the repeated end.
        force: of the base on the linkage (N,), complex.
        moment: about the origin (N,).
        orders: k ≥ 1 (h,).
    """
    waves = np.exp(-1j * np.outer(orders, u)) / u.size
    return Harmonics(
        orders.astype(np.float64), waves @ force, waves.conj() @ force, waves @ moment
    )


def shafts_against(harmonics: Harmonics, near: complex, furthest: float) -> list[Shaft]:
    """Find the shafts that cancel all orders of some harmonics.

    Args:
        harmonics: orders with a force.
        near: q, near which the shafts stand, metres.
        furthest: largest distance from there. Where the moment asks for more, both shafts of
            its order stand at q, and the moment stays as they leave it.

    Returns:
        Two shafts for each order, one if its force only turns; ``|s| > 0``.
    """
    shafts = []
    for k, c, d, M in zip(*(part.tolist() for part in harmonics), strict=True):
        wanted = -2j * M + near.conjugate() * c - near * d.conjugate()
        square = abs(c) ** 2 + abs(d) ** 2
        steps = [(-c.conjugate() * wanted / square).conjugate(), d * wanted / square]
        if max(map(abs, steps)) > furthest:
            steps = [0j, 0j]
        for ratio, force, step in zip((k, -k), (c, d), steps, strict=True):
            if abs(force) > 1e-9 * np.sqrt(square):
                shafts.append(Shaft(int(ratio), force / k**2, near + step))
    return shafts
