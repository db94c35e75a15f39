"""Springs that balance gravity, against published conditions, Pinocchio and MuJoCo."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import balance
import kinematics
from balance.app.cli.exit_codes import verdict_code
from balance.masses.springs import spring_problem
from balance.masses.springs.spring_text import read_spring
from kinematics import ScrewJoint, from_screws
from kinematics.errors import BodyError, LinkageError, PoseError, UsageError
from tests.support.spring_energies import (
    G,
    Y,
    balancer,
    energies_with_springs,
    lamp,
    mujoco_model,
    random_arm,
    torques_with_springs,
)


def parallelogram_lamp():
    """The same with a parallelogram of a crank and a rod without mass: the crank turns as the
    upper link."""
    joints = [
        ScrewJoint("u1", "base", "lower", axis=Y),
        ScrewJoint("u2", "lower", "upper", axis=Y, point=(0, 0, 0.4)),
        ScrewJoint("u3", "base", "crank", axis=Y),
        ScrewJoint("u4", "crank", "rod", axis=Y, point=(-0.1, 0, 0)),
    ]
    loop = ScrewJoint("u5", "rod", "upper", axis=Y, point=(-0.1, 0, 0.4))
    bodies = {
        "lower": (0.3, (0, 0, 0.2), 0.01 * np.eye(3)),
        "upper": (0.6, (0.3, 0, 0.4), 0.01 * np.eye(3)),
    }
    return from_screws(joints, [loop], bodies=bodies, inputs=["u1", "u3"], name="parallelogram")


def test_the_basic_spring_balancer():
    """J. L. Herder, PhD thesis, TU Delft, 2001: k r a = m g l."""
    answer = balance.springs(balancer(), "base@0,0,0.4 arm@0.25,0,0")
    (spring,) = answer.springs
    assert answer.verdict == "feasible" and answer.certainty.residual < 1e-12
    assert spring.stiffness * 0.25 * 0.4 == pytest.approx(2.0 * G * 0.3, rel=1e-9)
    answer = balance.springs(balancer(), "base@0,0,0:1 arm@0.25,0,0 k=100")
    assert answer.springs[0].ends[0].point == pytest.approx((0, 0, 2 * G * 0.3 / 25), rel=1e-9)
    assert np.abs(answer.after).max() < 1e-12


def test_two_links_without_a_parallelogram():
    """Agrawal and Fattah 2004, with the centres on the links; by hand:

    a spring k1 from a above the hinge to b on the upper link, k2 from c beyond the elbow to the
    same point, k3 from a to d on the lower link: k1 a b = m2 g s2, k1 l1 = k2 (c - l1),
    k1 a l1 + k3 a d = (m1 s1 + m2 l1) g.
    """
    a, b, c, d, l1 = 0.2, 0.4, 0.7, 0.1, 0.4
    answer = balance.springs(
        lamp(),
        [
            f"base@0,0,{a} upper@{b},0,0",
            f"lower@0,0,{c} upper@{b},0,0",
            f"base@0,0,{a} lower@0,0,{d}",
        ],
    )
    k1 = 0.6 * G * 0.3 / (a * b)
    k3 = ((0.3 * 0.2 + 0.6 * l1) * G - k1 * a * l1) / (a * d)
    found = [spring.stiffness for spring in answer.springs]
    assert found == pytest.approx([k1, k1 * l1 / (c - l1), k3], rel=1e-9)
    assert answer.sets == ((0, 1, 2),) and answer.rank == 3


@pytest.mark.slow
def test_two_links_with_a_parallelogram():
    """Two springs at the hinge: k1 a r1 = (m1 s1 + m2 l1) g and k2 a r2 = m2 g s2."""
    answer = balance.springs(
        parallelogram_lamp(),
        [
            "base@0,0,0.2 lower@0,0,0.1",
            "base@0,0,0.2 crank@0.15,0,0",
        ],
    )
    expected = (0.3 * 0.2 + 0.6 * 0.4) * G / 0.02, 0.6 * G * 0.3 / 0.03
    found = [spring.stiffness for spring in answer.springs]
    assert found == pytest.approx(expected, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize(
    "model",
    [
        "four_bar_general",
        "four_bar_parallelogram",
        "slider_crank",
        "four_bar_kite",
    ],
)
def test_four_bars_without_auxiliary_links(model):
    """Deepak and Ananthasuresh 2012: springs from the ground alone; the energy by Pinocchio."""
    linkage = kinematics.load(model)
    ground = next(iter(linkage.places))
    between = [f"{ground},{body.name}" for body in linkage.bodies]
    answer = balance.springs(linkage, between, gravity=(0, -G, 0))
    assert answer.verdict == "feasible"
    energies, gravity = energies_with_springs(linkage, answer, 40)
    assert np.ptp(energies) < 1e-11 * np.ptp(gravity)
    assert np.abs(answer.after).max() < 1e-9 * np.abs(answer.before).max()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_arms_hold_nothing_by_pinocchio(seed):
    """Planar and spatial arms: torque at 100 poses up to 1e-10 of that of gravity."""
    linkage, between = random_arm(seed)
    answer = balance.springs(linkage, between)
    assert answer.verdict == "feasible" and answer.certainty.residual < 1e-9
    left, gravity = torques_with_springs(linkage, answer, 100)
    assert np.abs(left).max() < 1e-10 * np.abs(gravity).max()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_arms_hold_nothing_by_tendons_of_mujoco(seed):
    """The same arms, another dynamics: springs as tendons of no free length."""
    mujoco = pytest.importorskip("mujoco")
    linkage, between = random_arm(seed)
    answer = balance.springs(linkage, between)
    model = mujoco_model(mujoco, linkage, answer)
    data, rng = mujoco.MjData(model), np.random.default_rng(seed)
    left, gravity = 0.0, 0.0
    for q in rng.uniform(-3, 3, (100, model.nq)):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        left = max(left, np.abs(data.qfrc_spring - data.qfrc_bias).max())
        gravity = max(gravity, np.abs(data.qfrc_bias).max())
    assert left < 1e-10 * gravity


def test_a_random_arm_holds_nothing_by_pinocchio():
    linkage, between = random_arm(3)
    answer = balance.springs(linkage, between)
    left, gravity = torques_with_springs(linkage, answer, 20)
    assert np.abs(left).max() < 1e-10 * np.abs(gravity).max()


def test_tendons_of_mujoco_balance():
    """The lamp with its springs as tendons stays where it is put."""
    mujoco = pytest.importorskip("mujoco")
    answer = balance.springs(
        lamp(),
        [
            "base@0,0,0.2 upper@0.4,0,0",
            "lower@0,0,0.7 upper@0.4,0,0",
            "base@0,0,0.2 lower@0,0,0.1",
        ],
    )
    sites = {"base": "", "lower": "", "upper": ""}
    tendons = ""
    for k, spring in enumerate(answer.springs):
        names = []
        for end in spring.ends:
            names.append(f"{end.link}{k}")
            place = " ".join(map(str, end.point))
            sites[end.link] += f'<site name="{names[-1]}" pos="{place}"/>'
        tendons += (
            f'<spatial stiffness="{spring.stiffness}" springlength="0 0">'
            f'<site site="{names[0]}"/><site site="{names[1]}"/></spatial>'
        )
    model = mujoco.MjModel.from_xml_string(f"""<mujoco><worldbody>{sites["base"]}
      <body><joint axis="0 1 0"/><inertial pos="0 0 0.2" mass="0.3" diaginertia="1 1 1"/>
      {sites["lower"]}<body pos="0 0 0.4"><joint axis="0 1 0"/>
      <inertial pos="0.3 0 0" mass="0.6" diaginertia="1 1 1"/>{sites["upper"]}</body></body>
      </worldbody><tendon>{tendons}</tendon></mujoco>""")
    data, rng = mujoco.MjData(model), np.random.default_rng(5)
    for q in rng.uniform(-2, 2, (30, 2)):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        assert np.abs(data.qfrc_spring - data.qfrc_bias).max() < 1e-8
        assert np.abs(data.qfrc_bias).max() > 0.05


@pytest.mark.slow
def test_the_least_torque_is_that_of_cvxpy():
    """The program of least squares over the same poses, by another solver, in closed form."""
    cvxpy = pytest.importorskip("cvxpy")
    answer = balance.springs(
        balancer(), ["base@0.1,0,0.4 arm@0.25,0,0", "base@0.1:0.2,0,0.3 arm@0.2,0,0.05"]
    )
    assert answer.verdict == "infeasible"
    u = answer.inputs[:, 0]

    def turned(x, z):
        return np.cos(u) * x + np.sin(u) * z, np.cos(u) * z - np.sin(u) * x

    def torque(ground, point):
        """Derivative of half the squared distance to a point (x, z) of the ground."""
        (x, z), (dx, dz) = turned(*point), turned(point[1], -point[0])
        return (x - ground[0]) * dx + (z - ground[1]) * dz

    k, t = cvxpy.Variable(2), cvxpy.Variable()
    middle = torque((0.15, 0.3), (0.2, 0.05))
    left = (
        k[0] * torque((0.1, 0.4), (0.25, 0.0))
        + k[1] * middle
        + t * (torque((0.2, 0.3), (0.2, 0.05)) - middle)
        + answer.before[:, 0]
    )
    limits = [k >= 0, cvxpy.abs(t) <= k[1]]
    problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.sum_squares(left)), limits)
    least = np.sqrt(problem.solve(solver="CLARABEL"))
    assert np.linalg.norm(answer.after) == pytest.approx(least, rel=1e-5)
    assert 0.0 < answer.share_left < 0.5


@pytest.mark.slow
def test_the_fewest_springs_and_a_catalogue():
    asked = [
        "base@0,0,0.4 arm@0.1,0,0",
        "base@0,0,0.4 arm@0,0,0.1",
        "base@0,0,0.1:0.4 arm@0.3,0,0",
    ]
    answer = balance.springs(balancer(), asked)
    assert answer.sets == ((0,), (2,)) and answer.every_set
    # m g l / (0.3 k) is in 0.1 … 0.4 for k = 60, and for no other.
    answer = balance.springs(balancer(), asked[2], catalogue=[10, 40, 60, 900])
    assert answer.verdict == "feasible" and answer.springs[0].stiffness == pytest.approx(60)
    answer = balance.springs(balancer(), "base@0,0,0.4 arm@0.3,0,0", catalogue=[30, 60])
    left = abs(60 * 0.4 * 0.3 - 2 * G * 0.3) / (2 * G * 0.3)
    assert answer.verdict == "infeasible" and answer.springs[0].stiffness == pytest.approx(60)
    assert answer.share_left == pytest.approx(left, rel=1e-9)


def test_a_spring_that_pulls_the_wrong_way_is_not_taken():
    answer = balance.springs(balancer(), "base@0,0,-0.4 arm@0.25,0,0")
    assert answer.verdict == "infeasible" and answer.in_span and answer.share_left == 1.0
    assert answer.springs[0].stiffness == 0.0 and "would be negative" in answer.words


@pytest.mark.parametrize(
    ("error", "between", "told"),
    [
        (UsageError, "base", "has no known form"),
        (UsageError, "base,arm,arm", "has no known form"),
        (UsageError, "base@0,0 arm", "is no point of a link"),
        (UsageError, "base@0,0,1:0 arm", "'1:0' is not a number or a range"),
        (UsageError, "base@0,0,30deg arm", "is a unit of angle"),
        (UsageError, "base arm k=-3", "a stiffness is not negative"),
        (UsageError, "base arm k=0", "give a stiffness above 0"),
        (LinkageError, "arm@0,0,1 arm@0.1,0,0", "both ends are on one rigid body"),
        (UsageError, [], "0 springs"),
        (BodyError, "base,leg", "there is no such link; the links are base, arm"),
        (BodyError, "arm,base", "has no mass"),
    ],
)
def test_springs_that_cannot_be(error, between, told):
    with pytest.raises(error) as raised:
        balance.springs(balancer(), between)
    assert told in str(raised.value) and "\n" not in str(raised.value)


def test_springs_that_fresh_poses_refute_are_undecided(monkeypatch):
    """Conditions of a single pose, which one spring can meet there and nowhere else."""
    monkeypatch.setattr(spring_problem, "FIRST_BATCH", 1)
    monkeypatch.setattr(spring_problem, "BATCHES", 1)
    answer = balance.springs("four_bar_general", "base,crank", gravity=(0, -9.81, 0))
    assert answer.balanced and answer.certainty.doubts
    assert (answer.verdict, verdict_code(answer.verdict)) == ("undecided", 4)
    assert answer.words.startswith("undecided: 1 spring balances gravity in the poses computed")


def test_no_gravity_and_no_workspace_are_refused():
    with pytest.raises(LinkageError, match="gravity does no work"):
        balance.springs(balancer(), "base,arm", gravity=(0, -G, 0))
    with pytest.raises(UsageError, match="not all 0"):
        balance.springs(balancer(), "base,arm", gravity=(0, 0, 0))
    with pytest.raises(PoseError, match="u7 is not an input"):
        balance.springs(balancer(), "base,arm", ranges={"u7": (0, 1)})
    with pytest.raises(UsageError, match="is empty"):
        balance.springs(balancer(), "base,arm", ranges={"u1": (1, 0)})


def test_units_of_springs():
    spring = read_spring("base@0,0,120mm arm@1cm,0,0 k=0.2N/mm:0.5N/mm")
    assert spring.ends[0].box[2] == (0.12, 0.12) and spring.stiffness == (200.0, 500.0)


def test_the_model_of_pinocchio_is_the_linkage():
    """What the other tests rest on: a weight on a hinge."""
    left, gravity = torques_with_springs(
        balancer(), balance.springs(balancer(), "base@0,0,-1 arm@0.1,0,0"), 5
    )
    assert np.array_equal(left, gravity) and pin.__version__
