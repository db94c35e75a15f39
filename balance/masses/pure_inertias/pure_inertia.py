"""The equivalent of a planar linkage that has moments of inertia and no mass.

A point mass on the axis of a revolute joint belongs to either link, as both move it alike.
Point masses are moved until mass and first moment of every link vanish, where that is possible:
the linkage then has the momentum ``Σ g_b ω_b`` alone, a couple, with the *pure inertia* g_b of
each link, which may be negative. It is balanced if and only if this vanishes: a linear relation
of angular velocities. (J. J. de Jong, PhD thesis, University of Twente, chapter 6.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from balance.space.conditions.collect import relative_tolerance
from balance.space.conditions.rank import Conditions
from balance.space.inertial_parameters.conversions import from_chain, to_chain
from balance.space.inertial_parameters.multipole import rod
from balance.space.interpretation.freedoms import reduced_echelon
from balance.space.interpretation.terms import round_to_fraction
from balance.space.spaces.compute_space import as_space
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    MASS_LEFT_RELATIVE,
    PURE_INERTIA_CONDITION,
)
from kinematics.errors import UsageError
from kinematics.loading.model_gallery import LinkageLike
from kinematics.model.arrays import freeze
from kinematics.numerics.array_types import Array
from kinematics.wording import number_text, repr_lines


@dataclass(frozen=True, eq=False)
class PureInertia:
    """Pure inertias that are equivalent to the masses of a planar linkage.

    Attributes:
        space: the design space of the linkage.
        inertias: pure inertia of each body (bodies,), kg m²; of a body whose mass stays, its
            moment of inertia about the inertial origin.
        moved: point masses that bodies gain on the way to the pure inertias, by joint.
        immovable: masses that cannot be moved.
        relations: relations of angular velocities (count, bodies): ``Σ_b r_b ω_b = 0`` in
            every motion.
        conditions: conditions on pure inertias (count, bodies): ``Σ_b c_b g_b = 0``.
        parameters: masses of the equivalent linkage (bodies, 4): ``[m, mcx, mcy, Ezz]`` about
            the inertial origin in the axes of the plane, SI units.
    """

    space: DesignSpace = field(repr=False)
    inertias: Array
    moved: tuple[_MovedMass, ...]
    immovable: tuple[_LeftMass, ...]
    relations: Array
    conditions: Array
    parameters: Array

    def __repr__(self) -> str:
        """Up to six lines: the inertias, what stays, the relations and the conditions."""
        return repr_lines(
            f"PureInertia of {self.space.linkage.name}",
            *filter(None, [self.words]),
            *(item.words for item in self.immovable),
            *self.relation_words,
            *self.condition_words,
        )

    @property
    def complete(self) -> bool:
        """Whether no mass is left."""
        return not self.immovable

    @cached_property
    def balanced(self) -> bool:
        """Whether no mass is left and the pure inertias fulfil all conditions."""
        residual = np.abs(self.conditions @ self.inertias).max(initial=0.0)
        size = np.abs(self.inertias).max(initial=0.0)
        return self.complete and bool(residual <= PURE_INERTIA_CONDITION * size)

    @property
    def spatial_parameters(self) -> Array:
        """Parameters (bodies, 10) that move in the plane as ``parameters`` do."""
        x, y, _ = self.space.axes
        m, mc, E = self.parameters[:, :1], self.parameters[:, 1:3], self.parameters[:, 3:]
        heavy = np.concatenate([m, mc @ np.array([x, y]), np.zeros((len(m), 6))], axis=1)
        return np.asarray(heavy + 0.5 * E * (rod(x) + rod(y)))

    @property
    def words(self) -> str:
        """The pure inertias in one line."""
        stay = {item.body for item in self.immovable}
        return ", ".join(
            f"{name} {number_text(value, '.6g')} kg m²"
            for name, value in zip(self.space.bodies, self.inertias, strict=True)
            if name not in stay
        )

    @property
    def relation_words(self) -> tuple[str, ...]:
        """The relations of angular velocities, a line each."""
        return tuple(_equation(row, "ω", self.space.bodies) for row in self.relations)

    @property
    def condition_words(self) -> tuple[str, ...]:
        """The conditions on pure inertias, a line each."""
        return tuple(_equation(row, "g", self.space.bodies) for row in self.conditions)

    def to_dict(self) -> dict[str, object]:
        """Convert to the entry ``pure_inertia`` of the report, ready for JSON."""
        return {
            "complete": self.complete,
            "balanced": self.balanced,
            "inertias": dict(zip(self.space.bodies, self.inertias.tolist(), strict=True)),
            "parameters": self.parameters.tolist(),
            "moved": [item.to_dict() for item in self.moved],
            "left": [item.to_dict() for item in self.immovable],
            "relations": _equations(self.relations, self.relation_words),
            "conditions": _equations(self.conditions, self.condition_words),
        }


def pure_inertia(space: DesignSpace | LinkageLike) -> PureInertia:
    """Move all point masses of a planar linkage across its joints, until it has none.

    Momentum stays the same in every motion: ``Σ_b [ξ; p]_b`` of the result is that of the
    file. Where all masses can be moved, it is the couple ``Σ_b g_b ω_b``.

    Args:
        space: a design space of a planar linkage for dynamic balance, with its masses, or the
            linkage, its path or its name.

    Returns:
        The pure inertias, the masses moved and those that stay; the relations of angular
        velocities, and the conditions on pure inertias that follow.

    Raises:
        UsageError: the linkage is not planar, counts spatial parameters or is one for force
            balance.

    Source:
        J. J. de Jong, PhD thesis, University of Twente, Eqs. 6.1 and 6.4.

    Example:
        >>> import balance
        >>> reduced = balance.masses.pure_inertia(balance.design_space("robot.urdf"))
        >>> reduced.complete, reduced.condition_words
        (False, ('g(crank) = 0', 'g(coupler) = 0', 'g(rocker) = 0'))
    """
    space = as_space(space)
    relations, conditions = inertia_conditions(space)
    added, remaining_masses = _empty_bodies(space)
    total = _given_in_plane(space) + added
    SI = total @ from_chain(space.chain.frame, True, False).T
    moved = _masses_by_joint(space, added)
    inertias = freeze(SI[:, 3])
    return PureInertia(
        space, inertias, moved, tuple(remaining_masses), relations, conditions, freeze(SI)
    )


def inertia_conditions(space: DesignSpace) -> tuple[Array, Array]:
    """Find the relations of angular velocities, and the conditions on pure inertias.

    A vector g of pure inertias is balanced if and only if ``Σ_b g_b ω_b = 0`` in every motion:
    relations and balanced inertias are one space, and its orthogonal complement holds the
    conditions.

    Args:
        space: a design space of a planar linkage for dynamic balance.

    Returns:
        Both (count, bodies), conditions in reduced row echelon form, and relations in that of
        the bodies in reverse order.

    Raises:
        UsageError: the space is another.
    """
    if not space.planar or space.balance != "dynamic":
        raise UsageError(
            "pure inertias are for planar linkages, planar parameters and dynamic balance"
        )
    rows = space.decision.conditions.rows[:, 3::4]
    conditions = Conditions.given(np.empty((0, rows.shape[1])), relative_tolerance(space.chain))
    conditions = conditions.append(rows)
    basis = conditions.decide().basis
    # Relations give the later bodies in terms of the first ones, and are in that order.
    return freeze(_reduced(basis.T[:, ::-1])[::-1, ::-1]), _reduced(conditions.rows)


def _reduced(rows: Array) -> Array:
    """Compute the reduced row echelon form of independent rows; simple fractions are exact."""
    if not len(rows):
        return freeze(rows)
    A = reduced_echelon(np.linalg.qr(rows.T)[0].T)
    return freeze([[round_to_fraction(x) for x in row] for row in A.tolist()])


def _equations(rows: Array, words: Sequence[str]) -> list[dict[str, object]]:
    pairs = zip(rows.tolist(), words, strict=True)
    return [{"coefficients": row, "words": text} for row, text in pairs]


def _equation(row: Array, symbol: str, bodies: Sequence[str]) -> str:
    """Write a linear equation: terms of positive coefficients left, the others right."""
    sides: list[list[str]] = [[], []]
    for c, name in zip(row.tolist(), bodies, strict=True):
        if c:
            factor = "" if abs(c) == 1.0 else f"{number_text(abs(c), '.6g')} "
            sides[c < 0].append(f"{factor}{symbol}({name})")
    left, right = (" + ".join(side) or "0" for side in sides)
    return f"{left} = {right}"


class _MovedMass(NamedTuple):
    """A point mass that bodies exchange across a revolute joint.

    Attributes:
        joints: names of the joint, or of several where links without parameters lie between.
        point: where it is, in the plane (2,), metres.
        gains: mass that each body gains, kg, by name; the rest comes from the ground.
    """

    joints: tuple[str, ...]
    point: Array
    gains: dict[str, float]

    @property
    def gains_text(self) -> str:
        """The masses in one line."""
        return ", ".join(
            f"{name} {number_text(mass, '+.6g')} kg" for name, mass in self.gains.items()
        )

    @property
    def words(self) -> str:
        """The joint and the masses in one line."""
        return f"{', '.join(self.joints)}: {self.gains_text}"

    def to_dict(self) -> dict[str, object]:
        """Convert to plain data, ready for JSON."""
        return {
            "joints": list(self.joints),
            "point": self.point.tolist(),
            "gains": self.gains,
            "words": self.words,
        }


class _LeftMass(NamedTuple):
    """Mass that cannot be moved off a body.

    Attributes:
        body: name of the body.
        mass: kg.
        moment: mass times the place of its centre, in the plane (2,), kg m.
        reason: why it stays, in one line.
    """

    body: str
    mass: float
    moment: Array
    reason: str

    @property
    def words(self) -> str:
        """The mass and the reason in one line."""
        return f"{self.body}: {number_text(self.mass, '.6g')} kg stays: {self.reason}"

    def to_dict(self) -> dict[str, object]:
        """Convert to plain data, ready for JSON."""
        return self._asdict() | {"moment": self.moment.tolist(), "words": self.words}


def _given_in_plane(space: DesignSpace) -> Array:
    """Return the parameters (bodies, 4) of the masses of the file, in units of the chain."""
    given = np.array([body.inertia for body in space.linkage.bodies]).reshape(-1, 10)
    return to_chain(given, space.chain.frame, True, False)


def _empty_bodies(space: DesignSpace) -> tuple[Array, list[_LeftMass]]:
    """Move the masses of the file off as many bodies as inertia transfers allow.

    Bodies give up their mass one after the other, the last of the tree first; a body keeps it
    if it cannot be emptied together with those before. Of all ways the one with the least
    transfers is taken.

    Args:
        space: a planar design space for dynamic balance.

    Returns:
        What is added to the parameters (bodies, 4), in the units of the chain; and the masses
        that stay.
    """
    z, T = _given_in_plane(space), _transfer_columns(space)
    size = float(np.abs(z[:, :3]).max(initial=0.0))
    y: Array = np.zeros(T.shape[2])
    empty: list[int] = []
    for body in reversed(range(len(z))):
        wanted = [*empty, body]
        A, b = T[wanted, :3].reshape(3 * len(wanted), -1), -z[wanted, :3].ravel()
        solution = np.asarray(np.linalg.lstsq(A, b)[0], np.float64)
        if np.abs(A @ solution - b).max() <= MASS_LEFT_RELATIVE * size:
            y, empty = solution, wanted
    added = T @ y
    massive = [body for body in range(len(z)) if body not in empty]
    remaining_masses = [_left_mass(space, T, z, z + added, body) for body in massive]
    added[empty, :3] = -z[empty, :3]
    return added, remaining_masses


def _masses_by_joint(space: DesignSpace, added: Array) -> tuple[_MovedMass, ...]:
    """Write a sum of inertia transfers as point masses, joint by joint.

    Args:
        space: a planar design space.
        added: the sum (bodies, 4), in the units of the chain.

    Returns:
        The masses at revolute joints; what passes a prismatic joint has none.
    """
    masses = []
    T = _transfer_columns(space)
    y = np.linalg.lstsq(T.reshape(-1, T.shape[2]), added.ravel())[0]
    size, at = float(np.abs(added[:, 0]).max(initial=0.0)), 0
    for item in space.transfers:
        part = T[:, :, at : at + item.dimension] @ y[at : at + item.dimension]
        at += item.dimension
        heavy = np.flatnonzero(np.abs(part[:, 0]) > MASS_LEFT_RELATIVE * size)
        if item.joints and heavy.size:
            first = part[heavy[0]]
            gains = {space.bodies[b]: float(part[b, 0]) for b in heavy.tolist()}
            point = _in_metres(space, first[1:3] / first[0])
            masses.append(_MovedMass(item.joints, freeze(point), gains))
    return tuple(masses)


def _transfer_columns(space: DesignSpace) -> Array:
    """Stack the inertia transfers of all joints (bodies, 4, count), in units of the chain."""
    count = len(space.bodies)
    columns = [item.scaled.reshape(count, 4, -1) for item in space.transfers]
    return np.concatenate([np.empty((count, 4, 0)), *columns], axis=2)


def _in_metres(space: DesignSpace, point: Array) -> Array:
    """Convert a point of the plane from units of the chain, about the inertial origin."""
    frame = space.chain.frame
    return np.asarray(frame.length * point + (frame.R @ frame.origin)[:2])


def _left_mass(
    space: DesignSpace, T: Array, given: Array, after: Array, body: int
) -> _LeftMass:
    """Describe the mass that stays on a body, and say why."""
    mass, length = float(after[body, 0]), space.chain.frame.length
    middle = (space.chain.frame.R @ space.chain.frame.origin)[:2]
    moment = length * after[body, 1:3] + mass * middle
    reason = _reason(space, T[body], given[body])
    return _LeftMass(space.bodies[body], mass, freeze(moment), reason)


def _reason(space: DesignSpace, T: Array, z: Array) -> str:
    """Say why the mass of a body cannot be moved off it.

    Args:
        T: what transfers add to the body (4, count).
        z: its parameters (4,).
    """
    heavy = np.abs(T[0]) > MASS_LEFT_RELATIVE * np.abs(T).max(initial=1e-300)
    points = (T[1:3, heavy] / T[0, heavy]).T
    slides = "; a prismatic joint lets no point mass pass" if _crosses_slide(T) else ""
    if not len(points):
        return f"no revolute joint leads to a body that could take it{slides}"
    fitted = np.linalg.lstsq(T[:3], z[:3])[0]
    if np.abs(T[:3] @ fitted - z[:3]).max() <= MASS_LEFT_RELATIVE * np.abs(z[:3]).max():
        return "the bodies around it cannot pass it on to the ground" + slides
    if not z[0]:
        return f"its first moment has no mass{slides}"
    centre = z[1:3] / z[0]
    off, apart, slid = centre - points[0], points - points[0], T[1:3, ~heavy].T
    along = np.concatenate([apart, slid])
    foot = np.linalg.lstsq(along.T, off)[0] @ along
    distance = space.chain.frame.length * float(np.linalg.norm(off - foot))
    if np.abs(apart).max() > MASS_LEFT_RELATIVE:
        where = "beside the line through its revolute joints"
    else:
        where = "from its revolute joint"
    if np.abs(slid).max(initial=0.0) > MASS_LEFT_RELATIVE:
        where += ", across the slide"
    return f"its centre of mass is {number_text(distance)} m {where}{slides}"


def _crosses_slide(T: Array) -> bool:
    """Whether a transfer without mass reaches the body: one across a prismatic joint."""
    light = np.abs(T[0]) <= MASS_LEFT_RELATIVE * np.abs(T).max(initial=1e-300)
    return bool(np.abs(T[:, light]).max(initial=0.0) > 0.0)
