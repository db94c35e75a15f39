"""Motion without angular momentum of a force-balanced pantograph, in closed form.

Vanishing of ``(J1 + C cos δ) θ̇1 + (J2 + C cos δ) θ̇2`` with δ = θ1 - θ2 separates:

    dθ1/dδ = (J2 + C cos δ) / (S + 2 C cos δ)        S = J1 + J2

    θ1(δ) = δ/2 + (J2 - J1)/D · atan( √((S - 2C)/(S + 2C)) tan(δ/2) )        D = √(S² - 4C²)

with the arctangent continued over whole turns. ``J1 J2 > C²`` for masses that exist, so the
denominators are positive and the motion is regular in δ. Where ``J2 + C cos δ`` vanishes the
first link reverses, and the rate ``θ̇2/θ̇1`` of the source has a pole.

Source: the equation is Eq. 17 of G. Becht, MSc thesis, TU Delft, 2020, chapter 3, there solved
by numerical integration; the integral is ours.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from balance.studies.synthesis.pantograph import ReducedInertias
from kinematics.numerics.array_types import Array, Flags

# Steps of bisection that locate δ, and of Newton's method after it.
BISECTIONS = 24
NEWTON_STEPS = 5
TURN = 2.0 * np.pi


def link_turn(opening: ArrayLike, inertias: ReducedInertias) -> Array:
    """Compute θ1(δ), radians, with θ1(0) = 0; see the head of this module.

    Args:
        opening: δ, radians; any shape.
        inertias: J1, J2 and C of that shape, or numbers.
    """
    J1, J2, C = inertias
    d = np.asarray(opening, dtype=np.float64)
    S = J1 + J2
    turns = np.round(d / TURN)
    half = np.tan(0.5 * (d - TURN * turns))
    angle = np.arctan(np.sqrt((S - 2.0 * C) / (S + 2.0 * C)) * half) + np.pi * turns
    return np.asarray(0.5 * d + (J2 - J1) / np.sqrt(S * S - 4.0 * C * C) * angle)


def link_turn_rate(opening: ArrayLike, inertias: ReducedInertias) -> tuple[Array, Array]:
    """Compute the first two derivatives of θ1(δ).

    Args:
        opening: δ, radians; any shape.
        inertias: J1, J2 and C of that shape, or numbers.
    """
    J1, J2, C = inertias
    S, c, s = J1 + J2, C * np.cos(opening), C * np.sin(opening)
    below = S + 2.0 * c
    return np.asarray((J2 + c) / below), np.asarray((J2 - J1) * s / below**2)


def delta_at_link_turn(start: ArrayLike, turn: ArrayLike, inertias: ReducedInertias) -> Array:
    """Solve ``θ1(δ) - θ1(δ_start) = turn`` for δ on the way on which the first link goes on.

    Args:
        start: δ at the first position, radians; any shape.
        turn: of the first link from there, radians; the same shape.
        inertias: J1, J2 and C of that shape, or numbers.

    Returns:
        δ, radians; NaN where the first link reverses before it has turned so far.
    """
    J1, J2, C = (np.asarray(x, dtype=np.float64) for x in inertias)
    start, turn = np.asarray(start, dtype=np.float64), np.asarray(turn, dtype=np.float64)
    base = link_turn(start, inertias) + turn
    rising = (J2 + C * np.cos(start)) / np.where(turn < 0.0, -1.0, 1.0) > 0.0
    near, far = (
        start,
        start + np.where(rising, 1.0, -1.0) * _way(start, turn, rising, J1, J2, C),
    )
    below = link_turn(far, inertias) - base
    reached = below * (link_turn(near, inertias) - base) <= 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (near + far)
        beyond = (link_turn(middle, inertias) - base) * below > 0.0
        near, far = np.where(beyond, near, middle), np.where(beyond, middle, far)
    opening = 0.5 * (near + far)
    for _ in range(NEWTON_STEPS):
        rate = link_turn_rate(opening, inertias)[0]
        step = (link_turn(opening, inertias) - base) / np.where(rate == 0.0, np.inf, rate)
        opening = np.clip(opening - step, np.minimum(near, far), np.maximum(near, far))
    return np.where(reached, opening, np.nan)


def link_reverses(start: ArrayLike, end: ArrayLike, inertias: ReducedInertias) -> Flags:
    """Whether ``J2 + C cos δ`` vanishes between two values of δ.

    Args:
        start: δ at the beginning, radians; any shape.
        end: δ at the end.
        inertias: J1, J2 and C of that shape, or numbers.
    """
    _, J2, C = (np.asarray(x, dtype=np.float64) for x in inertias)
    low, high = np.minimum(start, end), np.maximum(start, end)
    with np.errstate(divide="ignore", invalid="ignore"):
        pole = np.arccos(-J2 / C)
    reverses = np.zeros(np.broadcast(low, pole).shape, dtype=np.bool_)
    for angle in (pole, -pole):
        # The first such value from ``low`` upwards.
        above = angle + TURN * np.ceil((low - angle) / TURN)
        reverses |= above <= high
    return reverses


def _way(start: Array, turn: Array, rising: Flags, J1: Array, J2: Array, C: Array) -> Array:
    """Bound how far δ goes: to where the first link reverses, or by its least rate."""
    S = J1 + J2
    least = np.minimum((J2 - C) / (S - 2.0 * C), (J2 + C) / (S + 2.0 * C))
    with np.errstate(divide="ignore", invalid="ignore"):
        free = 1.01 * np.abs(turn) / least + 1e-9
        pole = np.arccos(-J2 / C)
        ahead = np.where(rising, 1.0, -1.0)
        to_poles = [np.mod(ahead * (angle - start), TURN) for angle in (pole, -pole)]
    return np.asarray(np.where(np.abs(C) < J2, free, np.fmin(*to_poles)))
