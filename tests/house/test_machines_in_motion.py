"""Studies of machines that move their base: their figures by a second route.

Files are in docs/machines/, beside the pages that show them.
"""

from __future__ import annotations

import numpy as np
import pytest

import balance
import kinematics
from tests.support.source_files import ROOT

MACHINES = ROOT / "docs" / "machines"


def quintic(samples):
    """The quintic law from 0 to 1, its first and second derivative by the path parameter."""
    s = np.linspace(0.0, 1.0, samples)
    return s, s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2


def turned(angle, axis):
    """Rotation matrix about a coordinate axis."""
    c, s = np.cos(angle), np.sin(angle)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    R = np.eye(3)
    R[[i, j], [i, j]] = c
    R[i, j], R[j, i] = -s, s
    return R


# --- ETS-VII -------------------------------------------------------------------------------

RIGHT = np.pi / 2
# The source's own chain: vectors from the centre of mass of the link before to the joint, and
# from the joint to that of the link; turns about new x, y, z; mass; moments of inertia.
ETS7 = (
    ((-0.785, -0.295, 1), (0, 0, 0.175), (0, 0, 0), 35.01, (1.218, 0.5132, 1.692)),
    ((0, 0.275, 0.175), (0.435, 0, 0), (-RIGHT, 0, -RIGHT), 22.45, (0.102, 3.378, 3.752)),
    ((0.435, 0, 0), (0.315, 0, 0.275), (0, 0, RIGHT), 21.89, (0.4327, 2.266, 2.528)),
    ((0.315, 0, 0), (0, 0, -0.1335), (0, 0, -RIGHT), 16.54, (0.3878, 0.3963, 0.07271)),
    ((0, 0, -0.1335), (0, 0, 0.1385), (RIGHT, RIGHT, 0), 26.0, (0.5727, 0.5987, 0.129)),
    ((0, 0, 0.1385), (0, 0, 0.266), (np.pi, RIGHT, 0), 18.49, (0.165, 0.241, 0.259)),
)
SATELLITE = 2552.0, np.diag([6206.0, 3541.0, 7087.0])
PRODUCTS = np.array([[0.0, 48.16, 78.52], [48.16, 0.0, -29.22], [78.52, -29.22, 0.0]])
SWING = np.deg2rad([40.0, 50.0, -60.0, 0.0, 0.0, 0.0])


def test_the_file_of_ets7_is_the_chain_of_its_source():
    linkage = kinematics.load(MACHINES / "ets7.urdf")
    R, centre = np.eye(3), np.zeros(3)
    for body, (to_joint, from_joint, turns, mass, moments) in zip(
        linkage.bodies, ETS7, strict=True
    ):
        joint = centre + R @ to_joint
        for axis, angle in enumerate(turns):
            R = R @ turned(angle, axis)
        centre = joint + R @ from_joint
        known = balance.bodies.mass_properties(body.inertia)
        assert known.mass == mass
        assert known.com == pytest.approx(centre, abs=1e-12)
        assert np.diag(R.T @ known.inertia @ R) == pytest.approx(moments, abs=1e-12)
    assert sum(row[3] for row in ETS7) == pytest.approx(140.4, abs=0.03)


class Floating:
    """An arm on a satellite in Pinocchio, without any momentum."""

    def __init__(self, path, mass, inertia):
        self.pin = pytest.importorskip("pinocchio")
        self.model = self.pin.buildModelFromUrdf(str(path), self.pin.JointModelFreeFlyer())
        self.model.inertias[1] = self.pin.Inertia(mass, np.zeros(3), inertia)
        self.data = self.model.createData()

    def velocity(self, q, rates):
        """Rates of satellite and arm, from those of the arm (6 + n,)."""
        pin, n = self.pin, self.model.nv - 6
        A = pin.computeCentroidalMap(self.model, self.data, q)
        base = -np.linalg.solve(A[:, :6], A[:, 6:] @ rates)
        assert n == len(rates)
        return np.concatenate([base, rates])

    def most_turned(self, rates, step):
        """Largest angle of the satellite, rad, by explicit midpoint steps.

        Rates of the arm are at every half step (2 N + 1, n).
        """
        pin, q, angles = self.pin, self.neutral(), [0.0]
        for k in range(0, len(rates) - 1, 2):
            half = pin.integrate(self.model, q, 0.5 * step * self.velocity(q, rates[k]))
            q = pin.integrate(self.model, q, step * self.velocity(half, rates[k + 1]))
            angles.append(2.0 * np.arcsin(np.linalg.norm(q[3:6])))
        return max(angles)

    def neutral(self):
        return self.pin.neutral(self.model)


def ets7_rates(samples, duration):
    """Rates of the swing (samples, 6); joints without limits are circles for Pinocchio."""
    _, _, slope = quintic(samples)
    return slope[:, None] * SWING / duration


def test_the_swing_of_ets7_turns_its_satellite():
    """0.0223 rad by Pinocchio; the products of inertia of the satellite hardly count."""
    mass, inertia = SATELLITE
    steps, duration = 200, 60.0
    rates = ets7_rates(2 * steps + 1, duration)
    plain = Floating(MACHINES / "ets7.urdf", mass, inertia).most_turned(rates, duration / steps)
    assert plain == pytest.approx(0.0223, abs=5e-5)
    full = Floating(MACHINES / "ets7.urdf", mass, inertia + PRODUCTS)
    assert full.most_turned(rates, duration / steps) == pytest.approx(plain, rel=0.02)


@pytest.mark.slow
def test_the_quiet_motion_of_ets7_by_pinocchio():
    """The satellite turns a tenth as far, and the wheels need 7 % of the moment."""
    linkage = kinematics.load(MACHINES / "ets7.urdf")
    end = dict(zip(linkage.inputs[:3], SWING[:3].tolist(), strict=True))
    plan = balance.quiet_motion(
        linkage, {}, end, 60.0, minimise="moment", about=(0, 0, 0), measure="peak", velocity=0.1
    )
    steps = 400
    path = plan.trajectory(2 * steps + 1)
    assert path.u[-1] == pytest.approx(SWING, abs=1e-9)
    satellite = Floating(MACHINES / "ets7.urdf", *SATELLITE)
    assert satellite.most_turned(path.ud, 60.0 / steps) < 0.12 * 0.0223
    assert plan.after.value < 0.08 * plan.quintic.value
