"""Studies of machines that move their base: their figures by a second route.

Files are in docs/machines/, beside the pages that show them.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

import balance
import kinematics
from tests.support.source_files import ROOT

MACHINES = ROOT / "docs" / "machines"


def read(name):
    """Text of the file of a machine."""
    return (MACHINES / f"{name}.urdf").read_text(encoding="utf-8")


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
SATELLITE = (
    2552.0,
    np.array([[6206.0, 48.16, 78.52], [48.16, 3541.0, -29.22], [78.52, -29.22, 7087.0]]),
)
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

    def __init__(self, text, mass, inertia, com=(0.0, 0.0, 0.0)):
        self.pin = pytest.importorskip("pinocchio")
        self.model = self.pin.buildModelFromXML(text, self.pin.JointModelFreeFlyer())
        self.model.inertias[1] = self.pin.Inertia(mass, np.array(com), inertia)
        self.data = self.model.createData()

    def velocity(self, q, rates):
        """Rates of satellite and arm, from those of the arm (6 + n,)."""
        A = self.pin.computeCentroidalMap(self.model, self.data, q)
        base = -np.linalg.solve(A[:, :6], A[:, 6:] @ rates)
        return np.concatenate([base, rates])

    def most_turned(self, rates, step):
        """Largest angle of the satellite, rad, by explicit midpoint steps.

        Rates of the arm are at every half step (2 N + 1, n).
        """
        pin, q, angles = self.pin, self.pin.neutral(self.model), [0.0]
        for k in range(0, len(rates) - 1, 2):
            half = pin.integrate(self.model, q, 0.5 * step * self.velocity(q, rates[k]))
            q = pin.integrate(self.model, q, step * self.velocity(half, rates[k + 1]))
            angles.append(2.0 * np.arcsin(np.linalg.norm(q[3:6])))
        return max(angles)


def ets7_rates(samples, duration):
    """Rates of the swing (samples, 6); joints without limits are circles for Pinocchio."""
    _, _, slope = quintic(samples)
    return slope[:, None] * SWING / duration


def test_the_swing_of_ets7_turns_its_satellite():
    """0.0224 rad by Pinocchio, and by the simulation of the page, with products of inertia."""
    steps, duration = 200, 60.0
    rates = ets7_rates(2 * steps + 1, duration)
    turn = Floating(read("ets7"), *SATELLITE).most_turned(rates, duration / steps)
    assert turn == pytest.approx(0.0224, abs=5e-5)


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
    satellite = Floating(read("ets7"), *SATELLITE)
    assert satellite.most_turned(path.ud, 60.0 / steps) < 0.12 * 0.0224
    assert plan.after.value < 0.08 * plan.quintic.value


# --- Cassie's leg --------------------------------------------------------------------------

# Pelvis and the other leg, which is held: mass, inertia about the centre of mass, and this.
ROBOT = (
    21.635,
    np.array(
        [[1.137, -0.1028, -0.4226], [-0.1028, 1.211, -0.1718], [-0.4226, -0.1718, 0.4664]]
    ),
    (-0.0222, -0.0787, -0.0918),
)
STEP = 0.4  # duration of the swing, s
# Joints by hip pitch, knee and crank: tarsus parallel to the thigh, foot to the crank.
LEG = {
    "hip_pitch": (1, 0, 0),
    "knee": (0, 1, 0),
    "ankle": (0, -1, 0),
    "achilles": (0, 1, 0),
    "crank": (0, 0, 1),
    "crank_rod": (0, 0, -1),
    "foot": (0, 0, 1),
}
# Points of the loops, and where the public file has them.
PUBLIC_POINTS = (
    ('"0.03266 -0.00508 0.11451"', '"0.03266 -0.00508 0.11452"'),
    ('"-0.30266 0.0345 -0.398"', '"-0.30266 0.0345 -0.39799"'),
    ('"0.0528 0 -0.40654"', '"0.0528 0 -0.4065361"'),
    ('"0.01237 -0.008 -0.05359"', '"0.01237 -0.008 -0.0535939"'),
)
WEIGHED = {"thigh": (0, 0, 0.15), "knee": (0.12, 0, 0.16), "crank": (0, 0, 0)}


def opened_leg(text):
    """The leg without its loops; the rod turns about the axis of the hip alone."""
    robot = ElementTree.fromstring(text)
    for loop in robot.findall("loop"):
        robot.remove(loop)
    (rod,) = (j for j in robot.findall("joint") if j.get("name") == "achilles")
    rod.set("type", "revolute")
    ElementTree.SubElement(rod, "axis", xyz="0 -1 0")
    ElementTree.SubElement(rod, "limit", lower="-4", upper="4", effort="1", velocity="1")
    return ElementTree.tostring(robot, "unicode")


def leg_rates(model, samples):
    """Rates of all joints of the opened leg along the swing (samples, n)."""
    s, _, slope = quintic(samples)
    bent = -0.6 * 64.0 * 3.0 * s**2 * (1 - s) ** 2 * (1 - 2 * s)
    driven = np.column_stack([0.8 * slope, bent, 0.0 * s]) / STEP
    rates = np.zeros((samples, model.nv - 6))
    for name, factors in LEG.items():
        joint = model.joints[model.getJointId(name)]
        rates[:, joint.idx_v - 6] = driven @ factors
    return rates


def largest_force(text, steps=400):
    """Largest rate of the linear momentum of a leg on a pelvis that is held, N."""
    leg = Floating(opened_leg(text), 1.0, np.eye(3))
    pin, model, data = leg.pin, leg.model, leg.data
    q, momenta = pin.neutral(model), []
    rates = leg_rates(model, 2 * steps + 1)
    for k in range(0, 2 * steps, 2):
        now, middle = (np.concatenate([np.zeros(6), v]) for v in rates[k : k + 2])
        momenta.append(pin.computeCentroidalMomentum(model, data, q, now).linear.copy())
        q = pin.integrate(model, q, STEP / steps * middle)
    return np.linalg.norm(np.gradient(momenta, STEP / steps, axis=0), axis=1).max()


def test_a_swing_of_the_leg_pulls_and_turns():
    """98.6 N on a pelvis that is held, and 0.364 rad in the air."""
    text = read("cassie_leg")
    assert largest_force(text) == pytest.approx(98.6, rel=2e-3)
    robot = Floating(opened_leg(text), *ROBOT)
    turn = robot.most_turned(leg_rates(robot.model, 801), STEP / 400)
    assert turn == pytest.approx(0.364, abs=1e-3)


@pytest.mark.slow
def test_three_weights_balance_the_leg(tmp_path):
    """7.87 kg take the force; no two of the three places do without the third."""
    linkage = kinematics.load(MACHINES / "cassie_leg.urdf")
    space = balance.design_space(linkage, ["hip_roll=0", "hip_yaw=0"], "force")

    def answer(*links):
        regions = {
            link: f"ball({x},{y},{z},0.1)"
            for link, (x, y, z) in WEIGHED.items()
            if link in links
        }
        return balance.counterweights(space, list(links), regions, density=None)

    three = answer(*WEIGHED)
    assert three.added_mass == pytest.approx(7.873, abs=1e-3)
    assert largest_force(three.to_urdf().decode()) < 1e-5 * 98.6
    for left_out in WEIGHED:
        links = [link for link in WEIGHED if link != left_out]
        assert answer(*links).verdict == "infeasible"


def test_digits_of_the_leg_hide_its_parallelograms(tmp_path):
    """10 conditions on the force; 14 with the points of the public file, 10 µm away."""
    assert balance.design_space(MACHINES / "cassie_leg.urdf", None, "force").rank == 10
    text = read("cassie_leg")
    path = tmp_path / "rounded.urdf"
    for point, public in PUBLIC_POINTS:
        assert text.count(point) == 1
        text = text.replace(point, public)
    path.write_text(text, encoding="utf-8")
    assert balance.design_space(path, None, "force").rank == 14
