"""Balanced pantographs: masses of the source, motions by numerical integration.

[B] G. Becht, MSc thesis, TU Delft, 2020, chapter 3.
"""

from __future__ import annotations

import cmath
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from balance.studies.synthesis.pantograph import (
    PantographMasses,
    default_masses,
    reduced_inertias,
)
from balance.studies.synthesis.positions import Position

# [B] table 1, with I2 + I4 + I5 = 5e-3 kg m² and R = 0.326 of the issue: chosen, not printed.
TABLE = PantographMasses(
    l2=0.05,
    l3=0.05,
    m1=0.11873,
    m2=0.30377,
    m3=0.14989,
    m4=0.02422,
    m5=0.06722,
    m6=0.78468,
    s3=0.09694,
    s4=0.02448,
    s5=0.25,
    inertia_1=0.326 * 5e-3,
    inertia_2=5e-3,
)
S2 = 0.10054


def integrated(inertias, opening, beta):
    """Turn of the tool for a turn of the first link, by a Runge-Kutta method of order 8."""
    J1, J2, C = map(float, inertias)

    def rate(turn, tool):
        c = C * np.cos(opening + turn - tool)
        return -(J1 + c) / (J2 + c)

    found = solve_ivp(rate, (0.0, beta), [0.0], "DOP853", rtol=1e-13, atol=1e-14)
    return float(found.y[0, -1])


def random_triple(seed):
    """Positions that a random pantograph passes, by integration; its masses and pivots."""
    rng = np.random.default_rng(seed)
    while True:
        fixed = complex(*rng.uniform(-1.0, 1.0, 2))
        angle, l1, reach = rng.uniform(-3.0, 3.0), rng.uniform(0.4, 1.0), rng.uniform(0.3, 1.0)
        masses = replace(
            default_masses(1.0, 0.5),
            m6=rng.uniform(0.5, 3.0),
            s4=rng.uniform(0.0, 0.3),
            s3=rng.uniform(0.0, 0.3),
            inertia_1=rng.uniform(0.1, 2.0),
            inertia_2=rng.uniform(0.1, 2.0),
        )
        inertias = reduced_inertias(masses, l1, reach)
        if float(inertias.second) < 1.2 * abs(float(inertias.coupling)):
            continue
        side = rng.choice([-1.0, 1.0])
        opening = side * rng.uniform(0.3, 1.2)
        places = []
        for beta in (0.0, side * rng.uniform(0.3, 0.5), side * rng.uniform(0.6, 0.9)):
            turn = integrated(inertias, opening, beta) if beta else 0.0
            own = angle - opening + turn
            point = fixed + l1 * cmath.exp(1j * (angle + beta)) + reach * cmath.exp(1j * own)
            places.append(Position(point.real, point.imag, own))
        return places, masses, fixed, fixed + l1 * cmath.exp(1j * angle)
