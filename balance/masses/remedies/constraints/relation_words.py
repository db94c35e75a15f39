"""What a relation between inputs asks of the moments of inertia, and how fast bodies turn.

The moment of inertia of a body about the normal of the plane enters the momentum with its
angular velocity alone. Conditions on a planar linkage that hold moments of inertia at all are
therefore few under a relation: one if all bodies turn in fixed ratios, such as J_1 = J_3.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from balance.space.inertial_parameters.conversions import to_chain
from balance.space.interpretation.freedoms import reduced_echelon
from balance.space.momentum.regressor import momentum_regressor
from balance.space.spaces.design_space import DesignSpace
from balance.support.tolerances import (
    AS_GIVEN_RESIDUAL,
    BODY_AT_REST,
    ECHELON_PIVOT,
    FRACTION_IN_TEXT,
    TERMS_RANK,
)
from kinematics.wording import number_text

Array = NDArray[np.float64]

# Parameters of a body in the plane: m, mcx, mcy, E.
PLANAR = 4
# Displacement at which angular velocities are compared with those at the reference pose.
STEP = 0.05


class InertiaNeed(NamedTuple):
    """A condition ``Σ factor J = constant`` on moments of inertia.

    Attributes:
        factors: of the moment of inertia of each body about its own centre of mass.
        constant: kg m², for the masses and centres of mass in the file; None if these do not
            fulfil the conditions without moments of inertia.
    """

    factors: dict[str, float]
    constant: float | None

    def __str__(self) -> str:
        """Write it with positive terms on both sides, such as ``J(a) = 2 J(b)``."""
        sides = [[_term(sign * x, name) for name, x in self.factors.items() if sign * x > 0.0]
                 for sign in (1.0, -1.0)]  # fmt: skip
        if self.constant is None:
            sides[1].append("terms of the masses")
        elif self.constant:
            sides[self.constant < 0.0].append(f"{number_text(abs(self.constant), '.6g')} kg m²")
            sides.reverse()
        left, right = (" + ".join(side) or "0" for side in sides)
        return f"{left} = {right}"


def inertia_needs(space: DesignSpace) -> tuple[InertiaNeed, ...]:
    """Find the conditions on moments of inertia that balance leaves in a planar linkage.

    Returns:
        Independent conditions; none for spatial linkages and for force balance.
    """
    if not space.planar or space.balance == "force":
        return ()
    rows = np.linalg.svd(space.scaled_basis)[0][:, space.nullity :].T
    spins = rows[:, PLANAR - 1 :: PLANAR]
    U, sizes, _ = np.linalg.svd(spins)
    rank = int((sizes > TERMS_RANK).sum())
    # Combinations of the conditions with moments of inertia, and those without.
    with_spin, without = U[:, :rank].T @ rows, U[:, rank:].T @ rows
    factors = np.empty((0, spins.shape[1]))
    if rank:
        factors = reduced_echelon(with_spin[:, PLANAR - 1 :: PLANAR])
    mix = factors @ np.linalg.pinv(with_spin[:, PLANAR - 1 :: PLANAR])
    constants = _constants(space, mix @ with_spin, without)
    return tuple(
        InertiaNeed(_named(space.bodies, row), constant)
        for row, constant in zip(factors, constants, strict=True)
    )


def turning_ratios(space: DesignSpace) -> dict[str, float] | None:
    """Compute the angular velocities of all bodies of a planar linkage with one freedom.

    Args:
        space: a design space whose motion has one freedom.

    Returns:
        Angular velocity of each body over that of the freedom; None if they change with the
        pose, or the linkage is spatial or has more freedoms.
    """
    motion = space.motion
    if not space.planar or motion is None or motion.basis.shape[1] != 1:
        return None
    rates = []
    for size in (0.0, STEP):
        X = momentum_regressor(space.linkage, size * motion.basis[:, 0], spatial=False)
        rates.append(motion.basis[:, 0] @ X[:, 0, PLANAR - 1 :: PLANAR])
    if np.abs(rates[0] - rates[1]).max() > FRACTION_IN_TEXT * np.abs(rates[0]).max():
        return None
    return {
        name: round(x, 9) + 0.0 if abs(x) > BODY_AT_REST else 0.0
        for name, x in zip(space.bodies, rates[0].tolist(), strict=True)
    }


def _constants(space: DesignSpace, rows: Array, without: Array) -> list[float | None]:
    """Compute the right sides for the masses and centres of mass in the file, kg m²."""
    given = np.array([body.inertia for body in space.linkage.bodies])
    z = to_chain(given, space.chain.frame, True, False)
    moments = np.einsum("bi,bi->b", z[:, 1:3], z[:, 1:3])
    about_origin = np.divide(moments, z[:, 0], where=z[:, 0] > 0.0, out=np.zeros(len(z)))
    about_centre = z[:, 3] - about_origin
    z[:, 3] = about_origin
    size = float(np.abs(z).sum())
    if size == 0.0 or np.abs(without @ z.ravel()).max(initial=0.0) > AS_GIVEN_RESIDUAL * size:
        return [None] * len(rows)
    sides = -(rows @ z.ravel())
    sides[np.abs(sides) <= AS_GIVEN_RESIDUAL * (size + np.abs(about_centre).sum())] = 0.0
    return (sides * space.chain.frame.length**2).tolist()


def _named(bodies: Sequence[str], row: Array) -> dict[str, float]:
    """Factors by body, in the smallest whole numbers if they are simple fractions."""
    nonzero = row[np.abs(row) > ECHELON_PIVOT]
    fractions = [Fraction(x).limit_denominator(12) for x in nonzero.tolist()]
    near = np.abs(np.array([float(x) for x in fractions]) - nonzero)
    whole = 1
    if near.max(initial=0.0) <= FRACTION_IN_TEXT:
        whole = int(np.lcm.reduce([x.denominator for x in fractions]))
    factors = [float(x) * whole for x in fractions] if whole > 1 else nonzero.tolist()
    names = [name for name, x in zip(bodies, row, strict=True) if abs(x) > ECHELON_PIVOT]
    return dict(zip(names, factors, strict=True))


def _term(factor: float, name: str) -> str:
    return (
        f"J({name})"
        if abs(factor - 1.0) <= FRACTION_IN_TEXT
        else f"{number_text(factor, '.6g')} J({name})"
    )
