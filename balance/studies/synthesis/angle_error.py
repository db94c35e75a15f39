"""Angle error of nonlinear pantographs: turn of the tool without momentum minus the wanted one.

A chain with pivots G and W_1 brings W_1 to W_2 if the first link turns by β. Without momentum
the tool then turns by φ', from `delta_at_link_turn`; the error is ``ε = φ' - φ``. The wanted
turn fixes δ at both ends, so the *residual*

    r = (θ1(δ_2) - θ1(δ_1) - β) (J1 + J2) / J2        δ_2 = δ_1 + β - φ

has the same zeros and needs no solution. The factor makes it a turn of the tool: without it r
would vanish as the first link grows long. All functions take arrays of pivots.

Source: G. Becht, MSc thesis, TU Delft, 2020, section 4.2 of chapter 3; Eq. 24 prints an
arctangent for the arcsine of β, and Eq. 25 the wrong sign in W_2.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from balance.studies.synthesis.momentum_integral import delta_at_link_turn, link_turn
from balance.studies.synthesis.pantograph import (
    PantographMasses,
    ReducedInertias,
    reduced_inertias,
)
from balance.studies.synthesis.positions import Displacement, Position
from kinematics.numerics.array_types import Array


class ChainAngles(NamedTuple):
    """Angles and inertias of many chains; arrays of one shape.

    Attributes:
        link_turns: β of the first link from each position to the next (steps, …), in ±π,
            radians.
        opening: δ at the first position, in ±π, radians.
        inertias: J1, J2 and C, kg m².
    """

    link_turns: Array
    opening: Array
    inertias: ReducedInertias


def chain_angles(
    first: Position,
    steps: tuple[Displacement, ...],
    fixed: ArrayLike,
    moving: ArrayLike,
    masses: PantographMasses,
    inertia_1: ArrayLike | None = None,
    s2: float | None = None,
) -> ChainAngles:
    """Compute the angles of chains at the first position, and how far their first links turn.

    Args:
        first: first position of the tool.
        steps: displacements from there to each other position.
        fixed: fixed pivots, complex, any shape.
        moving: moving pivots at the first position, of that shape.
        masses: of the pantographs, whose link 2 points to the tool.
        inertia_1: I1 + I3 instead of that of ``masses``, any shape that fits.
        s2: centre of link 2 instead of that of force balance.
    """
    G, W = np.asarray(fixed), np.asarray(moving)
    arm, reach = W - G, first.point - W
    along = np.where(np.abs(reach) > 0.0, np.angle(reach), first.angle)
    payload = np.abs(reach) if masses.s5 is None else np.full(W.shape, masses.s5)
    with np.errstate(invalid="ignore", divide="ignore"):
        arms = [arm, *(step.move(W) - G for step in steps)]
        turns = [
            np.angle(after / before) for before, after in zip(arms, arms[1:], strict=False)
        ]
    opening = np.angle(np.exp(1j * (np.angle(arm) - along)))
    inertias = reduced_inertias(masses, np.abs(arm), payload, s2, inertia_1)
    return ChainAngles(np.array(turns), opening, inertias)


def angle_residual(angles: ChainAngles, steps: tuple[Displacement, ...]) -> Array:
    """Compute the residual r of each position after the first (steps, …), radians.

    Args:
        steps: displacements from the first position.
    """
    beta = np.cumsum(angles.link_turns, axis=0)
    start = link_turn(angles.opening, angles.inertias)
    J1, J2, _ = angles.inertias
    residuals = [
        (link_turn(angles.opening + turn - step.turn, angles.inertias) - start - turn)
        * ((J1 + J2) / J2)
        for turn, step in zip(beta, steps, strict=True)
    ]
    return np.array(residuals)


def angle_error(angles: ChainAngles, steps: tuple[Displacement, ...]) -> Array:
    """Compute the angle error ε of each position after the first (steps, …), radians.

    NaN where the first link reverses before it has turned by β.

    Args:
        steps: displacements from the first position.
    """
    beta = np.cumsum(angles.link_turns, axis=0)
    errors = []
    for turn, step in zip(beta, steps, strict=True):
        end = delta_at_link_turn(angles.opening, turn, angles.inertias)
        errors.append(turn - (end - angles.opening) - step.turn)
    return np.array(errors)
