"""Bodies that have a given momentum for a given twist, in closed form.

In one pose, the body that an input joint carries must cancel the momentum of all that lies
further out (J. J. de Jong, PhD thesis, University of Twente, Eq. 3.17). With the axis of its
twist through r along n, ``[ω; v] = |ω| [n; r × n + λ n]``, and d from r to the centre of mass,

    p         = m λ ω + ω × m d
    ξ - r × p = E_r ω + λ m d × ω

where E_r is the tensor about r. Solved for the parameters, with p_⊥ the part of p across n:

    m = n·p / (λ |ω|)     m d_⊥ = -n × p / |ω|     E_r n = (ξ - r × p + λ p_⊥) / |ω|

Free are the three entries of E_r across n and m d·n; without pitch m too, and then p must be
perpendicular to n. A translation has ``p = m v, ξ = m c × v``: p must be along v and ξ across
it, ``m = v·p / |v|², m c_⊥ = v × ξ / |v|²``, and m c·v and all of E are free.

A body that can exist has ``m > 0`` and, about its centre of mass, ``n·G n > 0`` (Eq. 3.35);
everything else can then be chosen so that it exists. (Eqs. 3.36, 3.48 to 3.50 and table 3.1.
The first is printed with ``-[ω×]``: it must be plus.)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from balance.motion.motion_tolerances import MOMENTUM_NULL
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.model.spatial.inertia import (
    displace_parameters,
    inertia_tensor,
    parameters,
    stack_parameters,
)
from kinematics.model.spatial.screws import twist_axis, wrench_axis
from kinematics.numerics.array_types import Array
from kinematics.numerics.linalg.ties import first_least
from kinematics.numerics.linalg.vectors import project_out
from kinematics.wording import number_text, repr_lines

Pitch = Literal["zero", "finite", "infinite"]


@dataclass(frozen=True, eq=False)
class BalancingFamily:
    """The inertial parameters of a body with a given momentum: ``z + basis y``.

    Attributes:
        twist: ``[ω; v]`` of the body (6,), inertial frame, SI units.
        momentum: ``[ξ; p]`` that it must have (6,), about the inertial origin, SI units.
        twist_pitch: column of table 3.1: ``"zero"``, ``"finite"`` or ``"infinite"``.
        momentum_pitch: row of table 3.1.
        z: parameters (10,) about the inertial origin; no body, but one member of the family.
        basis: changes that leave the momentum (10, 4, 5 or 7 columns).
        axis: unit vector n of the twist, or of the translation (3,).
        point: point of the axis nearest to the origin (3,), metres.
        mass: kg, where the momentum fixes it; None if it is free.
        least_mass: a free mass must be above this, kg; ``inf`` if no mass will do.
        unmet: relations between twist and momentum that do not hold: ``"ω ⊥ p"``,
            ``"v ∥ p"``, ``"v ⊥ ξ"``; the family is then empty.
        moment: ``n·ξ / |ω|`` about r, kg m²: moment of inertia about the axis; 0 if none turns.
    """

    twist: Array
    momentum: Array
    twist_pitch: Pitch
    momentum_pitch: Pitch
    z: Array
    basis: Array
    axis: Array
    point: Array
    mass: float | None
    least_mass: float
    unmet: tuple[str, ...]
    moment: float

    @property
    def possible(self) -> bool:
        """Whether some body that can exist has the momentum."""
        return not self.reason

    @property
    def reason(self) -> str:
        """Why no body has the momentum; empty if there is one."""
        if self.unmet:
            verb = "does" if len(self.unmet) == 1 else "do"
            return f"{' and '.join(self.unmet)} {verb} not hold"
        if self.mass is not None and not self.mass > 0.0:
            return f"the mass would be {number_text(self.mass, '.3g')} kg"
        if not np.isfinite(self.least_mass):
            return "the moment of inertia about the axis would not be above 0"
        if self.mass is not None and not self.mass > self.least_mass:
            return (
                f"the mass is {number_text(self.mass, '.3g')} kg and must be above "
                f"{number_text(self.least_mass, '.3g')} kg"
            )
        return ""

    def __repr__(self) -> str:
        """Two lines: pitches and freedom, and the mass."""
        freedom = "empty" if self.unmet else f"{self.basis.shape[1]} free parameters"
        mass = (
            f"mass {number_text(self.mass)} kg"
            if self.mass is not None
            else (f"mass above {number_text(self.least_mass)} kg")
        )
        return repr_lines(
            f"BalancingFamily: twist of {self.twist_pitch} pitch, momentum of "
            f"{self.momentum_pitch} pitch, {freedom}",
            self.reason or mass,
        )

    def body(
        self,
        mass: float | None = None,
        along: float | None = None,
        inertia: ArrayLike | None = None,
    ) -> Array:
        """Choose one body of the family that can exist.

        Its tensor about the centre of mass is that of a body which is as wide in all directions
        across the axis; a body that only moves without turning may have any.

        Args:
            mass: kg, where it is free; by default twice the least.
            along: position of the centre of mass along the axis from its point, metres; by
                default the one with the smallest products of inertia, in a translation 0.
            inertia: tensor about the centre of mass (3, 3), kg m², for a translation.

        Returns:
            Parameters (10,) about the inertial origin, SI units.

        Raises:
            UsageError: no such body exists, or the tensor is missing or determined.
        """
        m = self._checked_mass(mass)
        n, about = self.axis, displace_parameters(self.z, _shift(-self.point))
        d = project_out(about[1:4], n) / m
        if self.twist_pitch == "infinite":
            if inertia is None:
                raise UsageError("a body that does not turn has any inertia: give one")
            return parameters(m, d + (along or 0.0) * n, inertia)
        if inertia is not None:
            raise UsageError("the inertia of a body that turns follows from its momentum")
        e, square = inertia_tensor(about) @ n, float(d @ d)
        if along is None:
            along = -float(e @ d) / (m * square) if square > 0.0 else 0.0
        c = d + along * n
        g = e - m * (float(c @ c) * n - along * c)  # G n
        return parameters(m, self.point + c, _round_tensor(n, g))

    def _checked_mass(self, mass: float | None) -> float:
        """Return the mass of a body, the one that is given if it is free."""
        if self.reason:
            raise UsageError(f"no body has this momentum: {self.reason}")
        if self.mass is not None:
            if mass is not None and abs(mass - self.mass) > MOMENTUM_NULL * self.mass:
                raise UsageError(f"the mass is {self.mass:.6g} kg, and not free")
            return self.mass
        if mass is None:
            if self.least_mass == 0.0:
                raise UsageError("every mass above 0 will do: give one")
            return 2.0 * self.least_mass
        if not mass > self.least_mass:
            raise UsageError(f"the mass must be above {self.least_mass:.6g} kg")
        return float(mass)


def balancing_family(twist: ArrayLike, momentum: ArrayLike) -> BalancingFamily:
    """Find all inertial parameters of a body that has a given momentum for a given twist.

    ``X(t) z = h``, solved in closed form; see `balance.motion.pose.body_family`. For balance
    in one pose, the momentum is the opposite of that of all bodies further out, for a unit rate
    of the input joint that carries the body.

    Args:
        twist: ``[ω; v]`` (6,), v at the inertial origin; rad/s and m/s.
        momentum: ``[ξ; p]`` (6,) about the inertial origin; N m s and N s.

    Returns:
        The family ``z + basis y``, what must hold for it, and the masses of bodies that exist.

    Raises:
        UsageError: the twist is zero, or a number is not finite.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eqs. 3.35, 3.36, 3.48 and table 3.1.

    Example:
        >>> import balance
        >>> balance.pose.balancing_family([0, 0, 1, 0, 0, 0], [0, 0, 2, 0, 1, 0])
        BalancingFamily: twist of zero pitch, momentum of zero pitch, 5 free parameters
          mass above 0.5 kg
    """
    t, h = (np.asarray(x, dtype=np.float64).reshape(6) for x in (twist, momentum))
    if not (np.isfinite(t).all() and np.isfinite(h).all() and t.any()):
        raise UsageError("twist and momentum must be finite, and the twist not zero")
    axis, line = twist_axis(t, MOMENTUM_NULL), wrench_axis(h, MOMENTUM_NULL)
    # A linear momentum that is round-off of the angular one is none.
    h = np.concatenate([h[:3], np.zeros(3)]) if np.isinf(line.pitch) else h
    family = _translating(t, h) if np.isinf(axis.pitch) else _turning(t, h)
    kinds = _kind(axis.pitch), _kind(line.pitch)
    return BalancingFamily(freeze(t), freeze(h), *kinds, *family)  # type: ignore[arg-type]


def _turning(t: Array, h: Array) -> tuple[object, ...]:
    """Solve for a body that turns; the fields of the family after the pitches."""
    axis = twist_axis(t, MOMENTUM_NULL)
    n, r, pitch, rate = axis.direction, axis.point, axis.pitch, axis.magnitude
    p, size = h[3:], float(np.linalg.norm(h))
    about = h[:3] - np.cross(r, p)
    along, across = float(n @ p), p - (n @ p) * n
    e = (about + pitch * across) / rate
    mass = along / (pitch * rate) if pitch else None
    unmet = () if pitch or abs(along) <= MOMENTUM_NULL * size else ("ω ⊥ p",)
    moment = float(n @ about) / rate
    square = across @ across / rate**2
    least = square / moment if moment > 0.0 else np.inf
    E = np.outer(n, e) + np.outer(e, n) - (n @ e) * np.outer(n, n)
    z = stack_parameters(mass or 0.0, -np.cross(n, p) / rate, E)
    a, b = _directions_across(n)
    changes = [stack_parameters(0.0, n, np.zeros((3, 3)))]
    changes += [
        stack_parameters(0.0, np.zeros(3), 0.5 * (np.outer(x, y) + np.outer(y, x)))
        for x, y in ((a, a), (b, b), (a, b))
    ]
    if not pitch:
        changes.insert(0, stack_parameters(1.0, np.zeros(3), np.zeros((3, 3))))
    there = displace_parameters(np.array([z, *changes]), _shift(r))
    return (
        freeze(there[0]),
        freeze(there[1:].T),
        freeze(n),
        freeze(r),
        mass,
        least,
        unmet,
        moment,
    )


def _translating(t: Array, h: Array) -> tuple[object, ...]:
    """Solve for a body that does not turn; the fields of the family after the pitches."""
    v, p, moment = t[3:], h[3:], h[:3]
    square = float(v @ v)
    n = v / np.sqrt(square)
    mass = float(v @ p) / square
    off, size = np.linalg.norm(p - mass * v), np.linalg.norm(h)
    unmet = ("v ∥ p",) * bool(off > MOMENTUM_NULL * size)
    unmet += ("v ⊥ ξ",) * bool(abs(n @ moment) > MOMENTUM_NULL * size)
    first = np.cross(v, moment) / square
    changes = [stack_parameters(0.0, n, np.zeros((3, 3)))]
    for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)):
        E = np.zeros((3, 3))
        E[i, j] = E[j, i] = 1.0
        changes.append(stack_parameters(0.0, np.zeros(3), E))
    z = stack_parameters(mass, first, np.zeros((3, 3)))
    return (
        freeze(z),
        freeze(np.array(changes).T),
        freeze(n),
        freeze(np.zeros(3)),
        mass,
        0.0,
        unmet,
        0.0,
    )


def planar_balancing_body(
    point: ArrayLike, rate: float, momentum: ArrayLike, mass: float
) -> tuple[Array, float]:
    """Find the body that has a given momentum when it turns about a point of the plane.

    ``c = r - n × p / (m ω)`` and ``g = (ξ - n·(r × p)) / ω - |p|² / (m ω²)``, with the normal n
    of the plane: the moment of inertia g is above 0 for ``m > |p|² / (ω (ξ - n·(r × p)))``.

    Args:
        point: r, of the joint (2,), metres.
        rate: ω of the body, rad/s.
        momentum: ``[ξ, px, py]`` (3,) about the origin, N m s and N s.
        mass: m, kg.

    Returns:
        Centre of mass (2,), metres, and moment of inertia about it, kg m².

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eqs. 3.49 and 3.50.

    Example:
        >>> from balance.motion.pose.body_family import planar_balancing_body
        >>> planar_balancing_body([0, 0], 1.0, [2.0, 0.0, 1.0], 1.0)
        (array([1., 0.]), 1.0)
    """
    (x, y), (moment, px, py) = np.asarray(point, float), np.asarray(momentum, float)
    centre = np.array([x + py / (mass * rate), y - px / (mass * rate)])
    about = moment - (x * py - y * px)
    return centre, float(about / rate - (px * px + py * py) / (mass * rate**2))


def _kind(pitch: float) -> Pitch:
    """Name a pitch."""
    return "zero" if pitch == 0.0 else "infinite" if np.isinf(pitch) else "finite"


def _round_tensor(n: Array, g: Array) -> Array:
    """Compute the tensor G with ``G n = g`` of a body that is equally wide across n (3, 3).

    Its second moments are a/2 across n, ``-s`` between, and along n as much as it needs to
    exist, with ``g = a n + s``; its trace less them is G.
    """
    a = float(n @ g)
    s = g - a * n
    second = 0.5 * a * np.eye(3) - np.outer(n, s) - np.outer(s, n)
    second += 2.0 * float(s @ s) / a * np.outer(n, n)
    return np.asarray(np.trace(second) * np.eye(3) - second)


def _directions_across(n: Array) -> tuple[Array, Array]:
    """Compute two unit vectors perpendicular to n and to each other."""
    a = np.cross(n, np.eye(3)[first_least(np.abs(n), 1.0)])
    a /= np.linalg.norm(a)
    return a, np.cross(n, a)


def _shift(r: Array) -> Array:
    """Displacement by r (4, 4)."""
    H = np.eye(4)
    H[:3, 3] = r
    return H
