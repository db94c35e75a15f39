"""The study of a Gough-Stewart platform: its figures by its legs' geometry and by Pinocchio.

Its file and page are in docs/machines/. Legs in Pinocchio have the universal joints of the
file, whose angles follow from the direction of a leg by hand.
"""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

import balance
import kinematics
from tests.support.source_files import ROOT

FILE = ROOT / "docs" / "machines" / "stewart.urdf"
# L.-W. Tsai, 2000: points of the base, those of the platform from its centre, and masses.
BASE = np.array(
    [
        (-2.12, 1.374, 0.0),
        (-2.38, 1.224, 0.0),
        (-2.38, -1.224, 0.0),
        (-2.12, -1.374, 0.0),
        (0.0, -0.15, 0.0),
        (0.0, 0.15, 0.0),
    ]
)
POINTS = np.array(
    [
        (0.17, 0.595, -0.4),
        (-0.6, 0.15, -0.4),
        (-0.6, -0.15, -0.4),
        (0.17, -0.595, -0.4),
        (0.43, -0.445, -0.4),
        (0.43, 0.445, -0.4),
    ]
)
CENTRE = np.array([-1.5, 0.0, 1.0])
PLATFORM, PART, ALONG = 1.5, 0.1, 0.5
WEIGHT = "platform", "ball(-0.17,-0.595,0.7,0.05)"
LEGS = POINTS + CENTRE - BASE
# The middle of the mechanism, about which its moments are printed.
ABOUT = np.array([-1.5, 0.0, 0.4])


def turned(axis, angle):
    """Rotation matrix about an axis."""
    x, y, z = axis / np.linalg.norm(axis)
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def universal(home, leg):
    """Angles of the two universal axes that turn a leg from its home direction, rotation."""
    home, leg = (v / np.linalg.norm(v) for v in (home, leg))
    first = np.array([-home[1], home[0], 0.0]) / np.hypot(home[0], home[1])
    second = np.cross(home, first)
    angles = np.arctan2(-leg @ second, leg @ home), np.arcsin(leg @ first)
    return angles, turned(first, angles[0]) @ turned(second, angles[1])


class Opened:
    """The platform in Pinocchio: a tree of legs, with the platform on the first of them."""

    def __init__(self, text):
        self.pin = pytest.importorskip("pinocchio")
        robot = ElementTree.fromstring(text)
        for loop in robot.findall("loop"):
            robot.remove(loop)
        self.model = self.pin.buildModelFromXML(ElementTree.tostring(robot, "unicode"))
        self.data = self.model.createData()

    def pose(self, shift, rotation):
        """Positions of all joints, with the centre shifted and the platform turned."""
        q = self.pin.neutral(self.model)

        def put(name, value):
            joint = self.model.joints[self.model.getJointId(name)]
            circle = [np.cos(value), np.sin(value)]
            q[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else circle

        ends = CENTRE + shift + POINTS @ rotation.T
        for i, (home, leg) in enumerate(zip(LEGS, ends - BASE, strict=True), 1):
            angles, R = universal(home, leg)
            put(f"u{i}_1", angles[0])
            put(f"u{i}_2", angles[1])
            put(f"leg{i}", np.linalg.norm(leg) - np.linalg.norm(home))
            if i == 1:
                ball = R.T @ rotation
        put("ball1_x", np.arctan2(-ball[1, 2], ball[2, 2]))
        put("ball1_y", np.arcsin(ball[0, 2]))
        put("ball1_z", np.arctan2(-ball[0, 1], ball[0, 0]))
        return q

    def loads(self, time, shifts, rotations):
        """Shaking force and moment over time, N and N m, by momenta of finite steps."""
        poses = [self.pose(*pose) for pose in zip(shifts, rotations, strict=True)]
        rows = []
        for q, r in zip(poses, poses[1:], strict=False):
            step = self.pin.difference(self.model, q, r) / (time[1] - time[0])
            middle = self.pin.interpolate(self.model, q, r, 0.5)
            h = self.pin.computeCentroidalMomentum(self.model, self.data, middle, step)
            com = self.data.com[0]
            rows.append([*(h.angular + np.cross(com - ABOUT, h.linear)), *h.linear])
        rates = np.diff(rows, axis=0) / (time[1] - time[0])
        return np.linalg.norm(rates[:, 3:], axis=1), np.linalg.norm(rates[:, :3], axis=1)


def waves(shift, axis, angle, samples=1201):
    """Times, shifts and rotations of a wave sin 3t of the platform over one period."""
    time = np.linspace(0.0, 2.0 * np.pi / 3.0, samples)
    wave = np.sin(3.0 * time)
    return time, np.outer(wave, shift), [turned(np.array(axis), angle * w) for w in wave]


DIAGONAL = waves((0.2, 0.2, 0.2), (0.0, 0.0, 1.0), 0.0)
TURN = waves((0.0, 0.0, 0.0), (0.0, 0.0, 1.0), np.pi / 6.0)
ROLL = waves((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), np.pi / 12.0)


@pytest.fixture(scope="module")
def opened():
    return Opened(FILE.read_text(encoding="utf-8"))


def test_the_file_of_the_platform_is_the_example(opened):
    """Masses, inertias and centres; the tree of the file reaches the points of the example."""
    linkage = kinematics.load(FILE)
    known = {body.name: balance.bodies.mass_properties(body.inertia) for body in linkage.bodies}
    along = ALONG * LEGS / np.linalg.norm(LEGS, axis=1)[:, None]
    for i in range(6):
        lower, upper = known[f"lower{i + 1}"], known[f"upper{i + 1}"]
        assert (lower.mass, upper.mass) == (PART, PART)
        assert lower.com == pytest.approx(BASE[i] + along[i], abs=1e-11)
        assert upper.com == pytest.approx(CENTRE + POINTS[i] - along[i], abs=1e-11)
        for part in (lower, upper):
            assert part.inertia == pytest.approx(0.00625 * np.eye(3), abs=1e-14)
    assert known["platform"].mass == PLATFORM
    assert known["platform"].com == pytest.approx(CENTRE, abs=1e-11)
    assert known["platform"].inertia == pytest.approx(0.08 * np.eye(3), abs=1e-14)
    shift, rotation = np.array([0.1, 0.05, 0.03]), turned(np.array([1.0, 2.0, 3.0]), 0.3)
    pin, model, data = opened.pin, opened.model, opened.data
    pin.framesForwardKinematics(model, data, opened.pose(shift, rotation))
    for i, point in enumerate(POINTS, 1):
        end = data.oMf[model.getFrameId(f"upper{i}")].translation
        assert end == pytest.approx(CENTRE + shift + rotation @ point, abs=1e-12)
    platform = data.oMf[model.getFrameId("platform")]
    assert platform.rotation == pytest.approx(rotation, abs=1e-12)
    assert platform.act(-POINTS[0]) == pytest.approx(CENTRE + shift, abs=1e-12)


def test_the_platform_shakes_like_one_body(opened):
    """One of 2.1 kg, 114 mm below the centre; moments of the page."""
    mass = PLATFORM + 6 * PART
    low = PART * POINTS.sum(axis=0) / mass
    assert low == pytest.approx([0.0, 0.0, -0.24 / 2.1], abs=1e-12)
    for (time, shifts, turns), peak, moment in (
        (DIAGONAL, 2.1 * 0.2 * 9.0 * np.sqrt(3.0), 2.240),
        (TURN, 0.0, 1.721),
        (ROLL, 0.24 * 9.0 * np.pi / 12.0, 0.5717),
    ):
        force, turning = opened.loads(time, shifts, turns)
        centre = np.array([s + R @ low for s, R in zip(shifts, turns, strict=True)])
        body = np.linalg.norm(np.diff(centre, 2, axis=0), axis=1) * mass / time[1] ** 2
        assert force == pytest.approx(body[: len(force)], abs=3e-5)
        assert force.max() == pytest.approx(peak, abs=1e-3)
        assert turning.max() == pytest.approx(moment, rel=5e-4)


def test_no_weights_balance_the_platform():
    """Masses that a shift moves with the platform cannot cancel: they are all positive."""
    linkage = kinematics.load(FILE)
    links = [body.name for body in linkage.bodies]
    space = balance.design_space(linkage, None, "force")
    answer = balance.counterweights(space, links, density=None)
    assert answer.verdict == "infeasible"
    still = kinematics.tool(linkage, "platform", "x,y,z,rx,ry,rz", -POINTS[0], frame="link")
    held = [f"platform.{direction}=0" for direction in "xyz"]
    space = balance.design_space(still, held, "force")
    answer = balance.counterweights(space, WEIGHT[:1], dict([WEIGHT]), density=None)
    assert answer.added_mass == pytest.approx(0.24 / 0.35, abs=1e-6)


@pytest.mark.slow
def test_a_weight_takes_the_force_of_a_rolling_platform(tmp_path):
    """The weight of the page, with Pinocchio; 0.24 kg m above the centre by hand."""
    linkage = kinematics.load(FILE)
    table = tmp_path / "roll.csv"
    time = np.linspace(0.0, 2.0 * np.pi / 3.0, 121)
    rows = np.column_stack([time, np.pi / 12.0 * np.sin(3.0 * time)])
    np.savetxt(table, rows, "%.12f", ",", header="time,rx", comments="")
    motion = balance.motion.from_tool_csv(linkage, table, "platform", -POINTS[0])
    answer = balance.partial(
        balance.design_space(linkage, None, "force"),
        WEIGHT[:1],
        0.7,
        regions=dict([WEIGHT]),
        motions=motion,
        density=None,
    )
    force, _ = Opened(answer.to_urdf().decode()).loads(*ROLL)
    assert force.max() < 1e-4
