"""The flexible slider-crank of the test set for IVP solvers.

B. Simeon, Math. Modelling of Systems 2, 1-18, 1996; F. Mazzia, C. Magherini, Test Set for IVP
Solvers, release 2.4, 2008, problem "Slider Crank": data, initial values and solution at 0.1 s.
Its axial mass matrix is 15 times that of quadratic elements, and its π has eight digits; both
belong to the problem.
"""

import numpy as np
import pytest

from balance.motion.flexible.beam_part import Marker, RigidPart
from balance.motion.flexible.drives import constant_speed
from balance.motion.flexible.mechanism import PlanarMechanism
from balance.motion.flexible.mechanism_types import JointDrive, MechanismJoint, On
from balance.motion.flexible.simulate import simulate
from tests.support.shape_integrals import ShapeIntegralPart

PI = 3.1415927
CRANK, ROD = 0.15, 0.30
CRANK_MASS, ROD_MASS, SLIDER_MASS = 0.36, 0.151104, 0.075552
CRANK_MOMENT, ROD_MOMENT = 0.002727, 0.0045339259
MODULUS, SIDE, DENSITY, SPEED = 2e11, 0.008, 7870.0, 150.0
START = {
    "phi2": 0.0,
    "x3": 0.450016933,
    "q": [0.0, 0.0, 0.103339863e-4, 0.169327969e-4],
    "phi2_rate": -74.9957670,
    "x3_rate": -0.268938672e-5,
    "q_rate": [0.444896105, 0.463434311e-2, -0.178591076e-5, -0.268938672e-5],
}
# φ2, x3, q1, q2 at 0.1 s.
SOLUTION = [-0.3311734987910881, 0.1697373326718410, 1.893192460247178e-4, 2.375751865617931e-5]


def rod():
    """Two sine modes across, one quadratic element along."""
    mass = DENSITY * SIDE**2 * ROD
    M = mass * np.array([[0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 8, 1], [0, 0, 1, 2]])
    bend = PI**4 / 24.0 * (SIDE / ROD) ** 2
    K = (
        MODULUS
        * SIDE**2
        / ROD
        * np.array(
            [
                [bend, 0, 0, 0],
                [0, 16.0 * bend, 0, 0],
                [0, 0, 16 / 3, -8 / 3],
                [0, 0, -8 / 3, 7 / 3],
            ]
        )
    )
    B = np.zeros((4, 4))
    B[0, 2], B[0, 3], B[1, 3] = -16.0 / PI**3, 8.0 / PI**3 - 1.0 / PI, 0.5 / PI
    return ShapeIntegralPart(
        "rod",
        ROD_MASS,
        0.5 * ROD_MASS * ROD,
        ROD_MOMENT,
        M,
        mass * (B - B.T),
        mass * np.array([[0, 0, 2 / 3, 1 / 6], [2 / PI, 0, 0, 0]]),
        mass * ROD * np.array([[0, 0, 1 / 3, 1 / 6], [1 / PI, -0.5 / PI, 0, 0]]),
        K,
        np.zeros((4, 4)),
    )


def slider_crank():
    """Crank, rod and slider; x of the slider counts from the pivot of the crank."""
    none = np.zeros(2)
    crank = RigidPart("crank", CRANK_MASS, CRANK_MOMENT - CRANK_MASS * CRANK**2 / 4)
    empty = dict(across=np.zeros(4), turn=np.zeros(4), shortening=np.zeros((4, 4)))
    root = Marker(none, along=np.zeros(4), **empty)
    tip = Marker(np.array([ROD, 0.0]), along=np.array([0.0, 0.0, 0.0, 1.0]), **empty)
    joints = (
        MechanismJoint(
            "pivot",
            "revolute",
            On(-1, Marker(none)),
            On(0, Marker(np.array([-CRANK / 2, 0.0]))),
        ),
        MechanismJoint(
            "pin", "revolute", On(0, Marker(np.array([CRANK / 2, 0.0]))), On(1, root)
        ),
        MechanismJoint("wrist", "revolute", On(1, tip), On(2, Marker(none))),
        MechanismJoint("guide", "prismatic", On(-1, Marker(none)), On(2, Marker(none))),
    )
    start = np.array([CRANK / 2, 0, 0, CRANK, 0, START["phi2"], *START["q"], START["x3"], 0, 0])
    rates = np.array(
        [
            0,
            SPEED * CRANK / 2,
            SPEED,
            0,
            SPEED * CRANK,
            START["phi2_rate"],
            *START["q_rate"],
            START["x3_rate"],
            0,
            0,
        ]
    )
    mechanism = PlanarMechanism(
        (crank, rod(), RigidPart("slider", SLIDER_MASS, 1.0)),
        joints,
        start,
        (),
        (JointDrive(0, constant_speed(SPEED)),),
        CRANK,
    )
    return mechanism, rates


def test_the_slider_crank_of_the_test_set_for_ivp_solvers():
    mechanism, rates = slider_crank()
    found = simulate(mechanism, 0.1, 2, rtol=1e-6, velocities=rates)
    p = found.positions[-1]
    assert [p[5], p[10], p[6], p[7]] == pytest.approx(SOLUTION, abs=1e-8)
    assert [p[6], p[7]] == pytest.approx(SOLUTION[2:], rel=1e-4)
    assert found.energy_drift < 1e-9
