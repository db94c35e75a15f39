"""Paths on a base that floats, of parts of the momentum, and loops that do not return a wheel.

Dimensions: D. N. Nenchev, Reaction null space of a multibody system with applications in
robotics, Mechanical Sciences 4, 2013. Wheel and floating pantograph: J. J. de Jong, PhD thesis,
University of Twente, chapter 2. The momentum of free-floating arms is from Pinocchio, on models
built here.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

import balance
from balance.motion.floating_base.base import FloatingBase
from balance.motion.paths.branches import null_basis
from balance.motion.paths.demand import Demand
from balance.motion.paths.rest_equations import RestEquations
from kinematics import ScrewJoint, from_screws
from kinematics.loading.model_gallery import robots

PLACE = (0.1, -0.05, 0.0)
BASE = FloatingBase(6.0, com=PLACE)


def planar_arm(count):
    """Links of 0.5 m in a bent line, with centres of mass off their lines."""
    points = [np.zeros(3)]
    for k in range(count):
        angle = 0.5 * k + 0.3
        points.append(points[-1] + 0.5 * np.array([np.cos(angle), np.sin(angle), 0.0]))
    joints, bodies = [], {}
    for k in range(count):
        link = f"link{k + 1}"
        joints.append(
            ScrewJoint(f"q{k + 1}", "base" if k == 0 else f"link{k}", link, point=points[k])
        )
        centre = 0.6 * points[k] + 0.4 * points[k + 1] + [0.02 * k, 0.03, 0.0]
        bodies[link] = (1.0 + 0.3 * k, centre, np.diag([0.01, 0.02, 0.03 + 0.005 * k]))
    return from_screws(joints, (), bodies, name=f"arm{count}")


def spatial_arm(count):
    """Axes in random directions."""
    rng = np.random.default_rng(3)
    joints, bodies, point = [], {}, np.zeros(3)
    for k in range(count):
        link = f"link{k + 1}"
        joints.append(
            ScrewJoint(
                f"q{k + 1}",
                "base" if k == 0 else f"link{k}",
                link,
                axis=rng.standard_normal(3),
                point=point,
            )
        )
        point = point + rng.uniform(-0.3, 0.5, 3)
        bodies[link] = (1.0 + rng.random(), point - 0.1, np.diag(0.02 + 0.005 * rng.random(3)))
    return from_screws(joints, (), bodies, name=f"spatial{count}")


def dimension(linkage, kept, base=BASE, away=0.2):
    """Of the null space in a pose off the reference pose."""
    equations = RestEquations(linkage, Demand(kept, base))
    q = away * np.random.default_rng(5).standard_normal(len(linkage.joints))
    return null_basis(equations.at(q))[0].shape[1]


@pytest.mark.parametrize("count", [3, 4, 5])
def test_planar_arms_on_a_base_that_floats(count):
    """Whole base at rest: n - 3; attitude alone: n - 1."""
    arm = planar_arm(count)
    assert dimension(arm, "all") == count - 3
    assert dimension(arm, "attitude") == count - 1


def test_spatial_arms_on_a_base_that_floats():
    """Nenchev's count: n - 6 and n - 3, so 1 and 4 of seven joints, 0 and 3 of six."""
    for count in (6, 7):
        arm = spatial_arm(count)
        assert dimension(arm, "all") == count - 6
        assert dimension(arm, "attitude") == count - 3


def floating_arm(arm, base, inertia):
    """The same arm in Pinocchio, on a free-flyer with the base's mass."""
    model = pin.Model()
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    com = np.array(base.com)
    model.appendBodyToJoint(root, pin.Inertia(base.mass, com, inertia), pin.SE3.Identity())
    joints = [root]
    before = np.zeros(3)
    for joint, body in zip(arm.joints, arm.bodies, strict=True):
        place = pin.SE3(np.eye(3), joint.point - before)
        one = model.addJoint(joints[-1], pin.JointModelRZ(), place, joint.name)
        mass, centre, moment = balance.bodies.mass_properties(body.inertia)
        model.appendBodyToJoint(
            one, pin.Inertia(mass, centre - joint.point, moment), pin.SE3.Identity()
        )
        joints.append(one)
        before = joint.point
    return model


def base_motion(arm, path, base):
    """Turning and travel of the free base along a path, with momentum kept at zero."""
    model = floating_arm(arm, base, np.diag([0.4, 0.5, 0.6]))
    data = model.createData()
    spline = make_interp_spline(path.s, path.u, k=5)

    def rate(s, x):
        q = np.concatenate([x[:7], spline(s)])
        A = pin.computeCentroidalMap(model, data, q)
        v = np.linalg.solve(A[:, :6], -A[:, 6:] @ spline(s, 1))
        R = pin.XYZQUATToSE3(x[:7])
        turn = R.rotation @ v[3:]
        w, p = x[6], x[3:6]
        quaternion = 0.5 * np.append(w * turn + np.cross(turn, p), -turn @ p)
        return np.concatenate([R.rotation @ v[:3], quaternion])

    start = np.array([0, 0, 0, 0, 0, 0, 1.0])
    done = solve_ivp(rate, (path.s[0], path.s[-1]), start, rtol=1e-11, atol=1e-13)
    turned = 2.0 * np.abs(done.y[3:6]).max()
    centre = done.y[:3].T
    return turned, np.abs(centre).max()


def test_an_arm_of_four_joints_leaves_its_base_at_rest():
    """By Pinocchio's centroidal map on a free-flyer: ≤ 1e-10 rad, and 1e-10 of the reach."""
    arm = planar_arm(4)
    found = balance.find_paths(arm, [{"q2": 0.3}], base=BASE, length=0.6)
    assert found.dimension == 1
    (path,) = found.paths
    turned, moved = base_motion(arm, path, BASE)
    assert turned <= 1e-10 and moved <= 1e-10 * 2.0
    none = balance.find_paths(planar_arm(3), base=BASE, length=0.2)
    assert not none.paths and "full column rank" in none.reason


def test_an_arm_of_two_joints_keeps_the_attitude_and_moves_the_base():
    arm = planar_arm(2)
    found = balance.find_paths(arm, base=BASE, kept="attitude", length=0.6)
    assert found.dimension == 1 and len(found.paths) == 1
    turned, moved = base_motion(arm, found.paths[0], BASE)
    assert turned <= 1e-10 and moved > 1e-3


def test_six_joints_on_a_fixed_base_have_paths_of_parts_alone():
    """UR5: six joints, six momentum components; of the moment alone three remain."""
    if "ur5" not in robots():
        pytest.skip("needs example-robot-data")
    whole = balance.find_paths("ur5", [{"shoulder_lift_joint": 0.4, "elbow_joint": -0.7}])
    assert not whole.paths and whole.dimension == 0
    moment = RestEquations(whole.linkage, Demand("moment"))
    force = RestEquations(whole.linkage, Demand("force"))
    q = np.array([0.2, 0.4, -0.7, 0.3, 0.5, 0.1])
    assert [null_basis(one.at(q))[0].shape[1] for one in (moment, force)] == [3, 3]


def wheel_pantograph():
    """Two masses of 1 kg on opposite slides, 2 m from the pivot, and a wheel of 5 kg m²."""
    tiny = np.zeros((3, 3))
    joints = [
        ScrewJoint("q2", "base", "arm"),
        ScrewJoint("q1", "arm", "out", axis=(1, 0, 0), point=(2.0, 0, 0), kind="prismatic"),
        ScrewJoint(
            "back",
            "arm",
            "in",
            axis=(-1, 0, 0),
            point=(-2.0, 0, 0),
            kind="prismatic",
            mimic=("q1", 1.0),
        ),
        ScrewJoint("q3", "base", "wheel"),
    ]
    bodies = {
        "out": (1.0, (2.0, 0, 0), tiny),
        "in": (1.0, (-2.0, 0, 0), tiny),
        "wheel": (1.0, (0, 0, 0), np.diag([2.5, 2.5, 5.0])),
    }
    return from_screws(joints, (), bodies, inputs=["q1", "q2", "q3"], name="wheel_pantograph")


@pytest.mark.slow
def test_a_loop_of_the_pantograph_leaves_its_wheel_turned():
    """Eq. 2.52: Δq3 = -2 m / g_c (2 q1 + Δq1) Δq1 Δq2 = +6π/5, by integration to 1e-9."""
    linkage = wheel_pantograph()
    assert balance.find_paths(linkage, length=0.1).dimension == 2
    turned = 0.0
    for q1, sign in ((1.0, 1.0), (2.0, -1.0)):
        ratio = 2.0 * q1**2 / 5.0  # g_p / g_c, Eq. 2.51
        found = balance.find_paths(
            linkage, [{"q1": q1 - 2.0}], motion="q1=0", length=np.pi * np.hypot(1.0, ratio)
        )
        (path,) = found.paths
        end = path.u[-1] - path.u[int(np.argmin(np.abs(path.s)))]
        assert abs(end[1]) == pytest.approx(np.pi, abs=1e-9)
        turned += sign * end[2] * np.sign(end[1])
        assert path.residual < 1e-10
    formula = -2.0 / 5.0 * (2.0 * 2.0 - 1.0) * -1.0 * np.pi
    assert formula == pytest.approx(6.0 * np.pi / 5.0, abs=1e-14)
    assert turned == pytest.approx(formula, abs=1e-9)


def floating_pantograph():
    """Fig. 2.8: two masses of 1 kg on a base that turns, of 1 kg m² when it is collapsed."""
    joints = [
        ScrewJoint("turn", "ground", "base"),
        ScrewJoint("q", "base", "out", axis=(1, 0, 0), point=(2.0, 0, 0), kind="prismatic"),
        ScrewJoint(
            "back",
            "base",
            "in",
            axis=(-1, 0, 0),
            point=(-2.0, 0, 0),
            kind="prismatic",
            mimic=("q", 1.0),
        ),
    ]
    tiny = np.zeros((3, 3))
    bodies = {
        "base": (1.0, (0, 0, 0), np.diag([0.5, 0.5, 1.0])),
        "out": (1.0, (2.0, 0, 0), tiny),
        "in": (1.0, (-2.0, 0, 0), tiny),
    }
    return from_screws(joints, (), bodies, inputs=["turn", "q"], name="floating_pantograph")


def test_the_wrench_on_a_turning_base_has_three_parts():
    """Eq. 2.59: rigid body, change of inertia, internal momentum; here 9, 8 q̇ θ̇ and 0."""
    linkage = floating_pantograph()
    x = np.array([0.3, -0.25])
    turn, slide = np.array([1.7, 0.0]), np.array([0.0, -0.9])
    speed_up, pull = np.array([2.1, 0.0]), np.array([0.0, 0.6])
    whole = balance.motion.shaking(linkage, x, turn + slide, speed_up + pull)
    rigid = balance.motion.shaking(linkage, x, turn, speed_up)
    internal = balance.motion.shaking(linkage, x, slide, pull)
    change = whole - rigid - internal
    q = 2.0 + x[1]
    assert rigid[2] == pytest.approx((1.0 + 2.0 * q * q) * 2.1, rel=1e-12)
    assert np.abs(internal).max() < 1e-14  # balanced on a base at rest
    assert change[2] == pytest.approx(4.0 * q * -0.9 * 1.7, rel=1e-12)
    assert np.abs(whole[[0, 1, 3, 4, 5]]).max() < 1e-12


@pytest.mark.parametrize(("phase", "grows"), [(-1.0, True), (1.0, False)])
def test_a_balanced_pantograph_can_aggravate_vibrations(phase, grows):
    """Fig. 2.9, case 3: a spring of 1e4 N m/rad, θ̇ = 1 rad/s, extension of 0.3 m at 10.8 Hz.

    ``I θ̈ + I' q̇ θ̇ + k θ = 0`` with the moment of inertia that the shaking moment shows.
    Whether the extension aggravates or calms the vibration depends on its phase, which is not
    printed.
    """
    linkage = floating_pantograph()
    q = np.array([1.7, 2.0, 2.3])
    inertia = [balance.motion.shaking(linkage, [0, x - 2], [0, 0], [1, 0])[2] for x in q]
    fit = np.polynomial.Polynomial.fit(q, inertia, 2)
    assert fit.convert().coef == pytest.approx([1.0, 0.0, 2.0], abs=1e-12)
    assert np.sqrt(1e4 / fit(2.0)) / 2.0 / np.pi == pytest.approx(5.4, abs=0.1)
    speed = 2.0 * np.pi * 10.8

    def rate(t, x):
        at = 2.0 + phase * 0.3 * np.sin(speed * t)
        change = fit.deriv()(at) * phase * 0.3 * speed * np.cos(speed * t)
        return [x[1], -(change * x[1] + 1e4 * x[0]) / fit(at)]

    done = solve_ivp(rate, (0.0, 0.5), [0.0, 1.0], max_step=2e-3, rtol=1e-8, atol=1e-10)
    first, last = (
        np.abs(done.y[0][(done.t > a) & (done.t < a + 0.1)]).max() for a in (0.0, 0.4)
    )
    assert (last > 1.5 * first) == grows
