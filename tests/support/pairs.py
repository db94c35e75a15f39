"""Pairs of bodies on the ground, one driven by the other, for each case of table 3.1.

Body a, on an input joint, must cancel the momentum of body b, whose joint follows it. Ten pairs
in one linkage do not interact. J. J. de Jong, PhD thesis, University of Twente, chapter 3.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.linalg import expm

from balance.bodies import mass_properties
from kinematics import ScrewJoint, from_screws
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from tests.support.laws import point_masses, sums, unit_vector

PITCHES = ("zero", "finite", "infinite")
# Pitch of the twist, pitch of the momentum; in the others no body has the momentum.
POSSIBLE = [
    ("finite", "finite"),
    ("finite", "zero"),
    ("zero", "finite"),
    ("zero", "zero"),
    ("zero", "infinite"),
    ("infinite", "zero"),
]
IMPOSSIBLE = [(t, h) for t in PITCHES for h in PITCHES if (t, h) not in POSSIBLE]


@dataclass(frozen=True)
class Pair:
    """Screws (6,) of both joints, ratio of their rates, parameters (10,) of body b."""

    a: np.ndarray
    b: np.ndarray
    ratio: float
    z: np.ndarray

    @cached_property
    def wanted(self):
        """Momentum (6,) that body a must have for unit rate: ``-h_b``, by differences."""
        return -momentum(self.ratio * self.b, self.z)


def cross(a, b):
    """``a × b`` of two vectors, in a tenth of the time that NumPy takes."""
    (u, v, w), (x, y, z) = a, b
    return np.array([v * z - w * y, w * x - u * z, u * y - v * x])


def screw(rng, pitch):
    """A random joint: revolute, helical or prismatic; shape (6,)."""
    n, r = unit_vector(rng), rng.standard_normal(3)
    if pitch == "infinite":
        return np.concatenate([np.zeros(3), n])
    lift = rng.uniform(0.2, 1.0) if pitch == "finite" else 0.0
    return np.concatenate([n, cross(r, n) + lift * n])


def hat(t):
    """The matrix (4, 4) of a twist."""
    (a, b, c), v = t[:3], t[3:]
    out = np.zeros((4, 4))
    out[:3, :3] = [[0, -c, b], [c, 0, -a], [-b, a, 0]]
    out[:3, 3] = v
    return out


def momentum_of_motion(linkage, u, rates, step=1e-3):
    """Total momentum ``[ξ; p]`` for rates of the inputs, by differences of closed poses."""
    chain = si_chain(linkage, spatial=True)
    there = [
        forward_kinematics(chain, joint_positions(linkage, np.add(u, k * step * rates))).H
        for k in (-2, -1, 0, 1, 2)
    ]
    N = (there[0] - 8 * there[1] + 8 * there[3] - there[4]) / (12 * step)
    total = np.zeros(6)
    for body, link in zip(linkage.bodies, chain.links, strict=True):
        total += of_points(N[link], there[2][link], body.inertia)
    return total


def of_points(N, H, z):
    """Momentum of a body with the displacement H, whose rate is N: sums over its points."""
    W = N @ second_moments(z) @ H.T  # ∫ ρ̇ [ρ; 1]ᵀ dm
    return np.array([W[2, 1] - W[1, 2], W[0, 2] - W[2, 0], W[1, 0] - W[0, 1], *W[:3, 3]])


def second_moments(z):
    """``∫ [x; 1][x; 1]ᵀ dm`` (4, 4), entry by entry."""
    m, x, y, w, xx, yy, ww, xy, xw, yw = z
    half = 0.5 * (xx + yy + ww)
    return np.array(
        [
            [half - xx, -xy, -xw, x],
            [-xy, half - yy, -yw, y],
            [-xw, -yw, half - ww, w],
            [x, y, w, m],
        ]
    )


def momentum(t, z, step=1e-3):
    """Momentum ``[ξ; p]`` of a body by finite differences of its displacement ``exp(u t)``.

    ``∫ ρ × ρ̇ dm`` and ``∫ ρ̇ dm`` over its points, with differences of fourth order.
    """
    there = expm(np.multiply.outer([-2 * step, -step, step, 2 * step], hat(t)))
    N = (there[0] - 8 * there[1] + 8 * there[2] - there[3]) / (12 * step)
    return of_points(N, np.eye(4), z)


def driven(rng, a, pitch):
    """A body b whose momentum has the pitch and, if possible, what the table asks for."""
    masses, points = point_masses(rng)
    centre, axis = masses @ points / masses.sum(), a[:3] if a[:3].any() else a[3:]
    n = unit_vector(rng)
    if pitch == "infinite":  # turns about its centre of mass
        b = np.concatenate([n, cross(centre, n)])
    elif pitch == "zero":  # slides: along the axis of a translation, across one of rotation
        if not a[:3].any():
            n = axis
        elif not a[:3] @ a[3:] > 1e-9:
            n = cross(axis, n)
        b = np.concatenate([np.zeros(3), n / np.linalg.norm(n)])
    else:  # turns so that p is perpendicular to the axis
        d = cross(n, axis)
        r = centre - cross(d, n) / np.linalg.norm(d) * rng.uniform(0.3, 2.0)
        b = np.concatenate([n, cross(r, n)])
        if a[:3] @ a[3:] > 1e-9:
            b = screw(rng, "zero")
    return b, sums(masses, points)


def pair(rng, twist, wrench):
    """A random pair of a case; of a possible one, such that some body a can exist.

    For a body that turns this asks for ``m > 0`` and ``n·G n > 0``, here computed from the
    momentum about the axis of a.
    """
    while True:
        a = screw(rng, twist)
        b, z = driven(rng, a, wrench)
        found = Pair(a, b, rng.choice([-1.0, 1.0]) * rng.uniform(0.5, 2.0), z)
        for one in (found, replace(found, ratio=-found.ratio)):
            if (twist, wrench) in IMPOSSIBLE or exists(one):
                return one


def exists(found):
    """Whether a body a can exist: ``m > 0`` and ``n·ξ > |p_⊥|² / m`` about its axis."""
    wanted = found.wanted
    n, xi, p = found.a[:3], wanted[:3], wanted[3:]
    if not n.any():
        return found.a[3:] @ p > 0.0
    lift = n @ found.a[3:]
    r = cross(n, found.a[3:])
    spin, across = n @ (xi - cross(r, p)), cross(n, p)
    if lift > 1e-9:
        return n @ p > 0.0 and spin * (n @ p) > 1.05 * lift * (across @ across)
    return spin > 0.0


def linkage_of(pairs):
    """One linkage of pairs; bodies a have a mass of 1 kg and are otherwise anything."""
    joints, bodies = [], {}
    for k, one in enumerate(pairs):
        joints += [
            ScrewJoint(f"u{k}", "base", f"a{k}", screw=one.a),
            ScrewJoint(f"q{k}", "base", f"b{k}", screw=one.b, mimic=(f"u{k}", one.ratio)),
        ]
        bodies[f"a{k}"] = (1.0, np.zeros(3), np.eye(3))
        bodies[f"b{k}"] = tuple(mass_properties(one.z))
    return from_screws(joints, bodies=bodies, inputs=[f"u{k}" for k in range(len(pairs))])
