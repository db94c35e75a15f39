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

import numpy as np
from numpy.typing import NDArray

from balance.masses.pure_inertias.moved_masses import (
    LeftMass,
    MovedMass,
    empty_bodies,
    given_in_plane,
    masses_by_joint,
)
from balance.space.conditions.collect import relative_tolerance
from balance.space.conditions.rank import Conditions
from balance.space.inertial_parameters.conversions import from_chain
from balance.space.inertial_parameters.multipole import rod
from balance.space.interpretation.freedoms import reduced_echelon
from balance.space.interpretation.terms import round_to_fraction
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import FRACTION_ROUND_OFF, PURE_INERTIA_CONDITION
from kinematics.errors import UsageError
from kinematics.model.arrays import freeze
from kinematics.wording import number_text, repr_lines

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PureInertia:
    """Pure inertias that are equivalent to the masses of a planar linkage.

    Attributes:
        space: the design space of the linkage.
        inertias: pure inertia of each body (bodies,), kg m²; of a body whose mass stays, its
            moment of inertia about the inertial origin.
        moved: point masses that bodies gain on the way to the pure inertias, by joint.
        left: masses that cannot be moved.
        relations: relations of angular velocities (count, bodies): ``Σ_b r_b ω_b = 0`` in
            every motion.
        conditions: conditions on pure inertias (count, bodies): ``Σ_b c_b g_b = 0``.
        parameters: masses of the equivalent linkage (bodies, 4): ``[m, mcx, mcy, Ezz]`` about
            the inertial origin in the axes of the plane, SI units.
    """

    space: DesignSpace = field(repr=False)
    inertias: Array
    moved: tuple[MovedMass, ...]
    left: tuple[LeftMass, ...]
    relations: Array
    conditions: Array
    parameters: Array

    def __repr__(self) -> str:
        """Up to six lines: the inertias, what stays, the relations and the conditions."""
        return repr_lines(
            f"PureInertia of {self.space.linkage.name}", *filter(None, [self.words]),
            *(item.words for item in self.left), *self.relation_words, *self.condition_words,
        )  # fmt: skip

    @property
    def complete(self) -> bool:
        """Whether no mass is left."""
        return not self.left

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
        stay = {item.body for item in self.left}
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
            "left": [item.to_dict() for item in self.left],
            "relations": _equations(self.relations, self.relation_words),
            "conditions": _equations(self.conditions, self.condition_words),
        }


def pure_inertia(space: DesignSpace) -> PureInertia:
    """Move all point masses of a planar linkage across its joints, until it has none.

    Momentum stays the same in every motion: ``Σ_b [ξ; p]_b`` of the result is that of the
    file. Where all masses can be moved, it is the couple ``Σ_b g_b ω_b``.

    Args:
        space: a design space of a planar linkage for dynamic balance, with its masses.

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
        >>> found = balance.masses.pure_inertia(balance.design_space("robot.urdf"))
        >>> found.complete, found.condition_words
        (False, ('g(crank) = 0', 'g(coupler) = 0', 'g(rocker) = 0'))
    """
    relations, conditions = inertia_conditions(space)
    added, remaining_masses = empty_bodies(space)
    total = given_in_plane(space) + added
    SI = total @ from_chain(space.chain.frame, True, False).T
    moved = masses_by_joint(space, added)
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
    return freeze(
        [[round_to_fraction(x, FRACTION_ROUND_OFF) for x in row] for row in A.tolist()]
    )


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
