"""Studies of machines: their figures by a second route, and those in print.

Files are in docs/machines/, beside the pages that show them; docs/reproduction.md lists what is
in print.
"""

from __future__ import annotations

from importlib import import_module
from xml.etree import ElementTree

import numpy as np
import pytest

import balance
import kinematics
from tests.support.pictures import curves_agree
from tests.support.source_files import ROOT

DOCS = ROOT / "docs"
MACHINES = DOCS / "machines"
PICTURES = sorted(path.stem for path in MACHINES.glob("*.svg"))

# --- the engine ----------------------------------------------------------------------------

# Khurmi and Gupta, example 22.1; the length of the rod is ours.
CRANK, ROD, SPEED = 0.15, 0.606, 240.0 * 2.0 * np.pi / 60.0
REVOLVING, PISTON, RADIUS = 37.0, 50.0, 0.4
START = np.arctan2(0.12, 0.09)
OTHERS = ((23.25, ROD), (26.375, 60.0))


def engine_force(angle, weight, rod=ROD):
    """Force of the frame on the engine (N, 2), closed form, angles from the dead centre."""
    s, c = np.sin(angle), np.cos(angle)
    root = np.sqrt(rod**2 - CRANK**2 * s**2)
    slope = -(CRANK**2 * np.cos(2.0 * angle)) / root - (CRANK**2 * s * c) ** 2 / root**3
    piston = PISTON * SPEED**2 * (CRANK * c - slope)
    turning = (REVOLVING * CRANK - weight * RADIUS) * SPEED**2
    return -np.column_stack([piston + turning * c, turning * s])


def engine(weight, rod, folder):
    """The engine of the file with another weight and rod."""
    text = (MACHINES / "engine_book.urdf").read_text(encoding="utf-8")
    across = np.sqrt(rod**2 - 0.12**2)
    for old, new in (
        ('"26.375"', f'"{weight!r}"'),
        ('"0.594 -0.12 0"', f'"{across:.12f} -0.12 0"'),
        ('"0.684 0 0"', f'"{across + 0.09:.12f} 0 0"'),
    ):
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = folder / "engine.urdf"
    path.write_text(text, encoding="utf-8")
    return kinematics.load(path)


def test_the_rows_of_the_engine():
    """Peak and root mean square of the page, by the closed form."""
    angle = np.linspace(0.0, 2.0 * np.pi, 7200, endpoint=False)
    for weight, peak, rms in (
        (0.0, 9420.0, 6390.0),
        (13.875, 5910.0, 3450.0),
        (23.25, 3540.0, 2514.0),
        (24.93, 3119.0, 2550.0),
        (26.375, 3419.0, 2635.0),
    ):
        size = np.linalg.norm(engine_force(angle, weight), axis=1)
        assert size.max() == pytest.approx(peak, rel=2e-3)
        assert np.sqrt(np.mean(size**2)) == pytest.approx(rms, rel=2e-3)


@pytest.mark.parametrize(
    ("weight", "rod"),
    [(0.0, ROD), *(pytest.param(w, r, marks=pytest.mark.slow) for w, r in OTHERS)],
)
def test_the_engine_shakes_as_its_closed_form_says(weight, rod, tmp_path):
    """The shaking force at every sample, by Pinocchio."""
    run = balance.verify(engine(weight, rod, tmp_path), speed="240rpm").runs[0]
    by_hand = engine_force(START + run.trajectory.u[:, 0], weight, rod)
    assert run.shaking[:, 3:5] == pytest.approx(by_hand, abs=1e-6 * 9420.0)
    assert run.rms("force") == pytest.approx(np.sqrt(np.mean((by_hand**2).sum(1))), rel=1e-3)


def test_the_engine_has_the_figures_of_the_book():
    """Balance mass 26.38 kg, residual force 2849 N at 60° for a rod without end.

    The book rounds the speed to 25.14 rad/s, which is 0.06 % of the force.
    """
    weight = (REVOLVING + PISTON * 2.0 / 3.0) * CRANK / RADIUS
    assert weight == pytest.approx(26.38, abs=0.006)
    for rod, residual, rounding in ((1e4, 2849.0, 1e-3), (ROD, 2743.0, 2e-4)):
        (force,) = engine_force(np.deg2rad([60.0]), weight, rod)
        assert np.hypot(*force) == pytest.approx(residual, rel=rounding)


def test_the_best_weights_of_the_engine():
    """Half of the piston has the least root mean square, 0.589 of it the least peak."""
    angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    weights = np.linspace(20.0, 30.0, 2001)
    sizes = [np.linalg.norm(engine_force(angle, weight), axis=1) for weight in weights]
    rms = [np.sqrt(np.mean(size**2)) for size in sizes]
    assert weights[np.argmin(rms)] == pytest.approx(23.25, abs=0.006)
    assert weights[np.argmin(np.max(sizes, axis=1))] == pytest.approx(24.93, abs=0.02)
    linkage = kinematics.load(MACHINES / "engine.urdf")
    answer = balance.partial(
        balance.design_space(linkage, None, "force"),
        ["crank"],
        30.0,
        regions={"crank": "ball(-0.24,-0.32,0,0.01)"},
        density=None,
        motions=balance.motion.one_turn(linkage, SPEED),
    )
    assert answer.verdict == "optimal"
    moment = np.linalg.norm(answer.z[0, 1:3])  # half of the piston is balanced, half is left
    assert moment == pytest.approx(PISTON * CRANK / 2.0, rel=1e-3)


# --- the double pendulum -------------------------------------------------------------------

# Mass, centre of mass and moment of inertia about the joint of both links, by the drawings
# (model 1.0 of the builders), and masses and centres that they identified (model 2.0).
DRAWN = ((0.608, 0.275, 0.05472), (0.630, 0.166, 0.02522))
BUILDERS = ((0.55938, 0.3), (0.60435, 0.183777))
ELBOW = 0.3
# Weights of the page: those for the drawings, and those for the arm as it was measured.
FOR_DRAWINGS = ((3.3197, (-0.18, 0.0, 0.0)), (0.80446, (-0.13, 0.0, 0.0)))
FOR_MEASURED = (
    (3.51223, (-0.1799958, 0.0005041, 0.0)),
    (0.930231, (-0.1277217, -0.0114677, 0.0)),
)


def first_moments(links):
    """Of the upper link with the lower one at its end, and of the lower one, kg m."""
    (m1, r1, *_), (m2, r2, *_) = links
    return np.array([m1 * r1 + m2 * ELBOW, m2 * r2])


def test_the_double_pendulum_has_the_figures_in_print():
    """The file of the drawings, and first moments within 1.5 and 7 % of the builders'."""
    linkage = kinematics.load(MACHINES / "double_pendulum.urdf")
    for body, (mass, distance, inertia) in zip(linkage.bodies, DRAWN, strict=True):
        known = balance.bodies.mass_properties(body.inertia)
        out = known.com - body.frame[:3, 3]
        assert (known.mass, np.linalg.norm(out)) == pytest.approx((mass, distance), rel=1e-12)
        about_joint = known.inertia[0, 0] + mass * distance**2
        assert about_joint == pytest.approx(inertia, abs=5e-7)
    measured = kinematics.load(MACHINES / "double_pendulum_measured.urdf")
    links = []
    for body in measured.bodies:
        known = balance.bodies.mass_properties(body.inertia)
        links.append((known.mass, body.frame[:3, 3][2] - known.com[2]))
    moments = first_moments(links)
    assert moments == pytest.approx([0.3535, 0.1188], abs=5e-4)  # a fifth of sigma
    assert first_moments(BUILDERS) == pytest.approx([0.3491, 0.1111], abs=6e-5)
    assert abs(moments / first_moments(BUILDERS) - 1.0).max() < 0.07
    assert 1.0 - first_moments(DRAWN)[1] / moments[1] == pytest.approx(0.12, abs=0.005)


def test_weights_of_the_double_pendulum():
    """Gravity torques of Pinocchio: those for the drawings leave 15 % at the elbow."""
    pin = pytest.importorskip("pinocchio")
    largest = {}
    for name, weights in (
        ("bare", ()),
        ("drawings", FOR_DRAWINGS),
        ("measured", FOR_MEASURED),
    ):
        model = pin.buildModelFromUrdf(str(MACHINES / "double_pendulum_measured.urdf"))
        for k, (mass, place) in enumerate(weights, 1):
            model.inertias[k] += pin.Inertia(mass, np.array(place), np.zeros((3, 3)))
        data = model.createData()
        angles = np.linspace(-np.pi, np.pi, 73)
        torques = []
        for a in angles[::6]:
            for b in angles:
                q = pin.neutral(model)
                q[:] = (np.cos(a), np.sin(a), np.cos(b), np.sin(b))
                torques.append(pin.computeGeneralizedGravity(model, data, q).copy())
        largest[name] = abs(np.array(torques)).max(axis=0)
    assert largest["drawings"][1] / largest["bare"][1] == pytest.approx(0.15, abs=0.005)
    assert np.all(largest["measured"] < 1e-5 * largest["bare"])


# --- Forbal --------------------------------------------------------------------------------

RINGED = ["link11", "link21", "link22"]
ANGLES = np.linspace(-0.8, 0.35, 8)


class Opened:
    """Forbal in Pinocchio, without its loop: the passive joints are those of a rhombus."""

    def __init__(self, path):
        self.pin = pytest.importorskip("pinocchio")
        robot = ElementTree.parse(path).getroot()
        for loop in robot.findall("loop"):
            robot.remove(loop)
        self.model = self.pin.buildModelFromXML(ElementTree.tostring(robot, "unicode"))
        self.data = self.model.createData()
        self.mass = sum(inertia.mass for inertia in self.model.inertias)

    def joints(self, values):
        """Vector of all joints from values of the inputs, or of their rates."""
        values = dict(values)
        values["joint12"] = values["joint22"] = values["joint11"] + values["joint21"]
        q = np.zeros(self.model.nq)
        for name, value in values.items():
            q[self.index(name)] = value
        return q

    def index(self, name):
        return self.model.joints[self.model.getJointId(name)].idx_q

    def gravity_torques(self, a, b):
        """Torques of the motors that hold the arm (2,)."""
        q = self.joints({"joint11": a, "joint21": b})
        g = self.pin.computeGeneralizedGravity(self.model, self.data, q)
        passive = g[self.index("joint12")] + g[self.index("joint22")]
        return np.array([g[self.index(name)] + passive for name in ("joint11", "joint21")])

    def largest_torques(self):
        found = [self.gravity_torques(a, b) for a in ANGLES for b in ANGLES]
        return abs(np.array(found)).max(axis=0)

    def momentum(self, values, rates):
        """Linear momentum (3,), kg m/s."""
        q, v = self.joints(values), self.joints(rates)
        self.pin.centerOfMass(self.model, self.data, q, v)
        return self.mass * self.data.vcom[0]


@pytest.fixture(scope="module")
def least(tmp_path_factory):
    """Forbal-2 with the two weights of the page."""
    answer = balance.counterweights(
        balance.design_space(MACHINES / "forbal2_bare.urdf", None, "force"),
        RINGED,
        dict.fromkeys(RINGED, "ball(-0.2,0,0,0.02)"),
        density=None,
    )
    path = tmp_path_factory.mktemp("least") / "forbal2_least.urdf"
    path.write_bytes(answer.to_urdf())
    return path


@pytest.mark.parametrize(
    ("name", "torques"),
    [
        ("forbal2_bare", (0.2248, 0.4519)),
        ("forbal2", (0.0093, 0.0070)),
        ("forbal5_bare", (0.4240, 0.6172)),
        ("forbal5", (0.0119, 0.0070)),
    ],
)
def test_gravity_torques_of_forbal(name, torques):
    """Those of the page: 98 % less with the authors' rings, who measured up to 79 and 84 %."""
    found = Opened(MACHINES / f"{name}.urdf").largest_torques()
    assert found == pytest.approx(torques, abs=6e-5)


def test_two_weights_balance_forbal(least):
    """0.324 kg where 0.443 kg are fitted: no gravity torque is left."""
    bare, fitted, two = (
        Opened(path)
        for path in (MACHINES / "forbal2_bare.urdf", MACHINES / "forbal2.urdf", least)
    )
    assert fitted.mass - bare.mass == pytest.approx(0.44256, abs=1e-5)
    assert two.mass - bare.mass == pytest.approx(0.32444, abs=1e-5)
    assert two.largest_torques().max() < 1e-8 * bare.largest_torques().max()


@pytest.mark.parametrize(
    ("name", "share"),
    [("forbal2_bare", 1.0), pytest.param("forbal2", 0.024, marks=pytest.mark.slow)],
)
def test_the_force_of_forbal_is_that_of_its_centre_of_mass(name, share):
    """Momentum along the motion of the verification; with the rings 2.4 % of the force."""
    run = balance.verify(
        MACHINES / f"{name}.urdf", trajectories=1, seed=0, balance="force"
    ).runs[0]
    opened = Opened(MACHINES / f"{name}.urdf")
    inputs = ("joint11", "joint21")
    path = run.trajectory
    by_hand = [
        opened.momentum(dict(zip(inputs, u, strict=True)), dict(zip(inputs, ud, strict=True)))
        for u, ud in zip(path.u, path.ud, strict=True)
    ]
    largest = 0.2  # kg m/s
    assert run.momentum[:, 3:] == pytest.approx(np.array(by_hand), abs=1e-9 * largest)
    assert run.peak("force") == pytest.approx(4.58 * share, rel=0.02)


def test_the_hand_of_forbal_5_cannot_be_balanced_on_other_links():
    """A moving hand shifts the centre of mass by what no other link can: Pinocchio says so."""
    opened = Opened(MACHINES / "forbal5.urdf")
    still = {"joint11": 0.0, "joint21": 0.0}
    only_hand = opened.momentum(still, still | {"joint3": 1.0})
    assert np.linalg.norm(only_hand) > 1e-3
    answer = balance.counterweights(
        balance.design_space(MACHINES / "forbal5_bare.urdf", None, "force"), RINGED, relax=False
    )
    assert answer.verdict == "infeasible" and "ee_motor" in answer.words


# --- the UR5e ------------------------------------------------------------------------------

# The table of the maker: a, d, alpha; mass and centre of mass in the frame after the link.
UR5E = (
    (0.0, 0.1625, np.pi / 2, 3.761, (0.0, -0.02561, 0.00193)),
    (-0.425, 0.0, 0.0, 8.058, (0.2125, 0.0, 0.11336)),
    (-0.3922, 0.0, 0.0, 2.846, (0.15, 0.0, 0.0265)),
    (0.0, 0.1333, np.pi / 2, 1.37, (0.0, -0.0018, 0.01634)),
    (0.0, 0.0997, -np.pi / 2, 1.3, (0.0, 0.0018, 0.01634)),
    (0.0, 0.0996, 0.0, 0.365, (0.0, 0.0, -0.001159)),
)
UPRIGHT = np.deg2rad([0.0, -90.0, 90.0, -90.0, -90.0, 0.0])
SWING = np.deg2rad([90.0, -30.0, 40.0, -10.0, 0.0, 0.0])
DURATION = 0.9


def ur5e_masses(q):
    """Masses (6,) and centres of mass of the links (6, 3), by products of the table."""
    T, masses, centres = np.eye(4), [], []
    for angle, (a, d, alpha, mass, com) in zip(q, UR5E, strict=True):
        c, s, ca, sa = np.cos(angle), np.sin(angle), np.cos(alpha), np.sin(alpha)
        T = T @ [
            [c, -s * ca, s * sa, a * c],
            [s, c * ca, -c * sa, a * s],
            [0.0, sa, ca, d],
            [0.0, 0.0, 0.0, 1.0],
        ]
        masses.append(mass)
        centres.append((T @ [*com, 1.0])[:3])
    return np.array(masses), np.array(centres)


def ur5e_moment(q):
    """Mass times the position of the common centre of mass (3,)."""
    masses, centres = ur5e_masses(q)
    return masses @ centres


def ur5e():
    names = ("shoulder_lift", "elbow", "wrist_1_turn", "wrist_2_turn")
    at = dict(zip(names, UPRIGHT[1:5].tolist(), strict=True))
    return kinematics.load(MACHINES / "ur5e.urdf", at=at)


def test_the_file_of_the_ur5e_is_the_table_of_its_maker():
    linkage = ur5e()
    masses, centres = ur5e_masses(UPRIGHT)
    known = [balance.bodies.mass_properties(body.inertia) for body in linkage.bodies]
    assert [body.mass for body in known] == pytest.approx(masses, rel=1e-14)
    assert np.array([body.com for body in known]) == pytest.approx(centres, abs=1e-12)
    assert masses.sum() == pytest.approx(17.7, abs=0.001)


def test_the_ur5e_shakes_as_its_table_says():
    """Quintic law by differences of positions, and the bound 4 m d / T²."""
    s = np.linspace(0.0, 1.0, 2001)
    law = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    path = np.array([ur5e_moment(UPRIGHT + x * SWING) for x in law])
    step = DURATION / 2000.0
    force = np.linalg.norm(np.diff(path, 2, axis=0), axis=1) / step**2
    assert force.max() == pytest.approx(45.63, rel=1e-3)
    bound = 4.0 * np.linalg.norm(path[-1] - path[0]) / DURATION**2
    assert bound == pytest.approx(19.09, rel=1e-3)


@pytest.mark.slow
def test_the_best_timing_of_the_ur5e_by_mujoco():
    """28.5 N, optimal by the program; its momentum by MuJoCo, differentiated in time."""
    mujoco = pytest.importorskip("mujoco")
    linkage = ur5e()
    plan = balance.quiet_timing(
        linkage, [0.0 * SWING, SWING], DURATION, measure="peak", acceleration=30.0
    )
    assert plan.verdict == "optimal"
    text = (MACHINES / "ur5e.urdf").read_text(encoding="utf-8")
    extra = '<mujoco><compiler boundinertia="1e-6"/></mujoco></robot>'  # no effect on forces
    model = mujoco.MjModel.from_xml_string(text.replace("</robot>", extra))
    data = mujoco.MjData(model)
    path, momenta = plan.trajectory(901), []
    for u, ud in zip(path.u, path.ud, strict=True):
        data.qpos[:], data.qvel[:] = UPRIGHT + u, ud
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_subtreeVel(model, data)
        momenta.append(model.body_subtreemass[0] * data.subtree_linvel[0])
    rates = np.gradient(np.array(momenta), path.time, axis=0, edge_order=2)
    force = np.linalg.norm(rates, axis=1)[2:-2]
    assert force.max() == pytest.approx(28.5, rel=0.02)
    assert force.max() < 0.64 * 45.63


# --- the pictures --------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", PICTURES)
def test_pictures_of_machines_are_current(name, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.syspath_prepend(str(DOCS))
    drawer = import_module("draw_studies")
    assert set(drawer.MACHINES) == set(PICTURES)
    drawn = drawer.picture(name).decode()
    assert curves_agree(drawn, (MACHINES / f"{name}.svg").read_text(encoding="utf-8"))
