"""Three routes to the shaking wrench agree; balanced designs pass and others fail."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.motion import shaking
from balance.motion.verification import verify_motions
from balance.motion.verification.given_motions import rest_to_rest
from balance.motion.verification.shaking_wrench import (
    inertia_loads,
    inertia_sizes,
    mass_parameters,
)
from balance.motion.verification.trajectory import drive, random_motions
from balance.motion.verification.verify_motions import (
    PinocchioModel,
    measure_shaking,
    verify,
    verify_second,
)
from kinematics.closure.joint_positions import input_chain
from kinematics.errors import LinkageError, MotionError, PoseError
from kinematics.model.spatial.screws import Ad
from tests.support.covering import spread
from tests.support.figures import FIGURES
from tests.support.laws import altered, coordinates, displacement, off_axis, placed, space, sums
from tests.support.limited_process import run_limited
from tests.support.motions import around, bodies, slope, states

TWENTY = (
    "bennett delta eight_bar five_bar four_bar_antiparallelogram four_bar_chain "
    "four_bar_general four_bar_kite four_bar_parallelogram four_bar_spherical four_rrr "
    "goldberg_five_bar hprs pantograph rusr sarrus six_bar_watt slider_crank stewart_6ups "
    "three_rsr"
).split()
BALANCED = (
    ("four_bar_kite_balanced", None),
    ("four_bar_antiparallelogram_balanced", None),
    ("three_rsr", "u2=u3"),
)
STEP = 1e-3


def sizes(linkage, way, z):
    """Sum of the sizes of the bodies' own wrenches (N,): moments about the middle, over L."""
    chain = input_chain(linkage)
    scale = chain.units[linkage.positions_of(linkage.inputs)]
    loads = inertia_loads(chain, z, way.q / chain.units, way.ud / scale, way.udd / scale)
    return chain.frame.length * np.linalg.norm(loads.rate, axis=2).sum(axis=1)


@pytest.mark.table(1)
@pytest.mark.parametrize("model", spread(TWENTY, 2))
def test_three_routes_agree(model):
    """Our series, Newton-Euler in Pinocchio, differences of the momentum in Pinocchio."""
    linkage = kinematics.load(model)
    z = bodies(linkage)
    way = states(linkage, 20, seed=7)
    model = PinocchioModel(linkage, z)
    ours = shaking(linkage, way.q, way.ud, way.udd, z)
    theirs = model.reactions(way)
    by_slope = np.array(
        [slope(model.momenta(around(linkage, way, k, STEP)), STEP) for k in range(20)]
    )
    # Moments about the inertial origin: forces count with their arms.
    frame = linkage.spatial_chain.frame
    arm = frame.length + np.linalg.norm(frame.origin)
    unit = sizes(linkage, way, z)[:, None] * np.array([arm] * 3 + [1.0] * 3)
    assert np.abs(ours / unit).max() > 1e-3
    assert (np.abs(ours - theirs) <= 1e-9 * unit).all()
    assert (np.abs(ours - by_slope) <= 1e-9 * unit).all()


# Pinocchio takes 64 bytes for each cube of the joints of a model: 4 GB for 384.
LEGS = """
import sys
from pathlib import Path
import numpy as np
from kinematics import load
from balance.motion.verification.trajectory import Trajectory
from balance.motion.verification.verify_motions import PinocchioModel
from balance.motion.verification.shaking_wrench import mass_parameters

rows = []
for leg in range(24):
    below = "base"
    for k in range(16):
        name = f"L{leg}_{k}"
        rows.append(
            f'<link name="{name}"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" '
            f'ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="j{name}" '
            f'type="continuous"><parent link="{below}"/><child link="{name}"/>'
            f'<origin xyz="0.1 0 0"/><axis xyz="0 0 1"/></joint>'
        )
        below = name
Path(sys.argv[1]).write_text(f'<robot name="r"><link name="base"/>{"".join(rows)}</robot>')
linkage = load(sys.argv[1])
motion = [np.random.default_rng(0).normal(size=(1, 384)) for _ in range(3)]
way = Trajectory(np.zeros(1), *motion, *motion, 0.0, 1.0)
model = PinocchioModel(linkage, mass_parameters(linkage))
print(*model.reactions(way)[0])
"""


@pytest.mark.slow
def test_many_legs_take_little_memory(tmp_path):
    """A walker of 24 legs with 16 joints each needs less than a gigabyte."""
    run_limited(LEGS, str(tmp_path / "legs.urdf"))


def test_a_branch_of_too_many_joints_is_refused(monkeypatch):
    linkage = kinematics.load("five_bar")
    monkeypatch.setattr(verify_motions, "MOST_JOINTS", 2)
    with pytest.raises(LinkageError, match="3 joints stand on one another.*GB"):
        PinocchioModel(linkage, bodies(linkage))


def test_branches_apart_have_the_reactions_of_the_whole(monkeypatch):
    import pinocchio as pin

    linkage = kinematics.load("three_rsr")
    z = bodies(linkage)
    (way,) = random_motions(linkage, 1, 5)
    monkeypatch.setattr(verify_motions, "PART_JOINTS", 1)
    robot = PinocchioModel(linkage, z)
    assert len(robot._parts) == 3
    whole, data = robot.model, robot.model.createData()
    origin, sums = input_chain(linkage).frame.origin, []
    for q, qd, qdd in zip(way.q, way.qd, way.qdd, strict=True):
        # The rate of the momentum about the centre of mass, moved to the origin.
        pin.computeCentroidalMomentumTimeVariation(whole, data, q, qd, qdd)
        rate = data.dhg.copy()
        arm = data.com[0] + origin
        sums.append([*(rate.angular + np.cross(arm, rate.linear)), *rate.linear])
    size = sizes(linkage, way, z).max()
    assert np.abs(robot.reactions(way) - sums).max() <= 1e-9 * size


@pytest.mark.parametrize("model", ["slider_crank", "three_rsr"])
def test_sizes_of_own_wrenches_are_those_of_pinocchio(model):
    """The sum over the bodies of the norms of ``M a + v × M v``, and the shaking over it."""
    import pinocchio as pin

    linkage = kinematics.load(model)
    z, chain = bodies(linkage), input_chain(linkage)
    (way,) = random_motions(linkage, 1, 5)
    robot, L = PinocchioModel(linkage, z), chain.frame.length
    data, sums = robot.model.createData(), []
    for q, qd, qdd in zip(way.q, way.qd, way.qdd, strict=True):
        pin.forwardKinematics(robot.model, data, q, qd, qdd)
        parts = []
        for joint in (body.link + 1 for body in linkage.bodies):
            inertia, v = robot.model.inertias[joint], data.v[joint]
            wrench = data.oMi[joint].act(inertia * data.a[joint] + v.cross(inertia * v))
            parts.append(np.linalg.norm([*wrench.linear, *wrench.angular / L]))
        sums.append(np.sum(parts))
    joints = (x / chain.units for x in (way.q, way.qd, way.qdd))
    assert L * inertia_sizes(chain, z, *joints) == pytest.approx(sums, rel=1e-10)
    checked = verify(linkage, motions=[way])
    expected = checked.force_residual, checked.moment_residual
    assert measure_shaking(linkage, [way]) == pytest.approx(expected, rel=1e-10, abs=1e-14)


@pytest.mark.parametrize("model", ["three_rsr", "bennett", "slider_crank", "delta"])
def test_loops_are_closed_in_pinocchio(model):
    """The far end of each loop's joint stands where its weld wants it, and moves along."""
    import pinocchio as pin

    linkage = kinematics.load(model)
    model = PinocchioModel(linkage, bodies(linkage))
    data = model.model.createData()
    (way,) = random_motions(linkage, 1, 20)

    def poses(q, qd):
        pin.forwardKinematics(model.model, data, q, qd)
        return [(M.copy(), M.act(v)) for M, v in zip(data.oMi, data.v, strict=True)]

    rest = poses(way.q[0], way.qd[0])
    for k in (5, 13):
        here = poses(way.q[k], way.qd[k])
        for loop in linkage.loops:
            (end, v), (other, w) = here[loop.end + 1], here[loop.successor + 1]
            before = rest[loop.successor + 1][0].inverse() * rest[loop.end + 1][0]
            now = other.inverse() * end
            assert np.abs(now.homogeneous - before.homogeneous).max() < 1e-11
            assert (v - w).vector == pytest.approx(0.0, abs=1e-11 * np.abs(way.qd[k]).max())


def test_a_pendulum_by_hand(tmp_path):
    """One body on one hinge: ``m r α`` across, ``m r ω²`` inwards, ``I + m r²`` about it."""
    path = tmp_path / "pendulum.urdf"
    path.write_text(
        '<robot name="p"><link name="base"/><link name="bob"><inertial>'
        '<origin xyz="0.5 0 0"/><mass value="2"/><inertia ixx="0.3" iyy="0.2" izz="0.1" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link><joint name="j" type="continuous">'
        '<origin xyz="1 0 0"/><parent link="base"/><child link="bob"/><axis xyz="0 0 1"/>'
        "</joint></robot>",
        encoding="utf-8",
    )
    linkage = kinematics.load(path)
    omega, alpha = 3.0, -2.0
    expected = [0.0, 0.0, 0.6 * alpha + 1.0 * alpha, -(omega**2), alpha, 0.0]
    assert np.allclose(shaking(linkage, [0.0], [omega], [alpha]), expected, rtol=1e-14)
    way = rest_to_rest(linkage, [[0.0], [1.0]], samples=50)
    found = verify(linkage, motions=[way])
    (run,) = found.runs
    force = 2.0 * 0.5 * np.hypot(way.udd[:, 0], way.ud[:, 0] ** 2)
    assert np.allclose(np.linalg.norm(run.shaking[:, 3:], axis=1), force, atol=1e-12)
    assert np.allclose(run.bearing[:, 0], force, atol=1e-12)
    assert found.force_ratio == pytest.approx(1.0, rel=1e-12)
    assert found.bearing == pytest.approx(force.max(), rel=1e-12)
    assert not found.balanced and found.agreed


# In the space of the HPRS a first moment goes without mass, which Pinocchio cannot be told.
@pytest.mark.table
@pytest.mark.parametrize(
    "figure", [f for f in FIGURES if f.model in TWENTY and f.model != "hprs"], ids=str
)
def test_points_of_the_design_space_are_balanced(figure):
    found = space(figure)
    z = found.basis @ coordinates(found)
    linkage = found.linkage
    result = verify(
        linkage, z, motion=found.motion, balance=found.balance, trajectories=2, samples=25
    )
    assert result.scale > 0.0
    assert result.agreed and result.balanced, repr(result)
    if found.balance == "force":
        dynamic = verify(linkage, z, motion=found.motion, trajectories=1, samples=25)
        assert not dynamic.balanced


@pytest.mark.parametrize(("model", "motion"), BALANCED)
def test_one_per_cent_on_any_link_is_noticed(model, motion):
    linkage = kinematics.load(model)
    rng = np.random.default_rng(2)
    given = mass_parameters(linkage)
    assert verify(linkage, motion=motion, trajectories=2, samples=40).balanced
    for b, body in enumerate(linkage.bodies):
        z = given.copy()
        z[b] += sums([0.01 * z[b, 0]], [off_axis(linkage, body, rng)])
        found = verify(linkage, z, motion=motion, trajectories=1, samples=40)
        assert found.agreed and not found.balanced, body.name
        assert max(found.force_residual, found.moment_residual) > 1e-5


def test_shaking_takes_inputs_or_all_joints():
    linkage = kinematics.load("five_bar")
    way = states(linkage, 3, seed=1)
    all_joints = shaking(linkage, way.q, way.qd, way.qdd)
    assert all_joints.shape == (3, 6)
    assert np.allclose(all_joints, shaking(linkage, way.u, way.ud, way.udd), rtol=1e-9)
    for k in range(3):
        q = dict(zip(linkage.inputs, way.u[k], strict=True))
        one = shaking(linkage, q, way.ud[k], way.udd[k])
        assert one.shape == (6,) and np.allclose(one, all_joints[k], rtol=1e-9)
    z = mass_parameters(linkage)
    assert np.allclose(shaking(linkage, way.q, way.ud, way.udd, 3.0 * z), 3.0 * all_joints)
    with pytest.raises(PoseError, match="velocities open the loops"):
        shaking(linkage, way.q, way.qd + 1.0, way.qdd)
    with pytest.raises(PoseError, match="give 2 .the inputs. or 5"):
        shaking(linkage, way.q, way.qd[:, :3], way.qdd)
    with pytest.raises(LinkageError, match="inertial parameters for 4 bodies"):
        shaking(linkage, way.q, way.ud, way.udd, np.ones(7))
    with pytest.raises(LinkageError, match="must be finite"):
        shaking(linkage, way.q, way.ud, way.udd, np.full(40, np.nan))


def test_shaking_moves_with_the_linkage(tmp_path):
    """A linkage placed elsewhere shakes with the same wrench, carried along."""
    H = displacement(np.random.default_rng(4), 3.0)
    here = kinematics.load("four_bar_general")
    there = kinematics.load(altered("four_bar_general", tmp_path, placed(H)))
    way = states(here, 4, seed=2)
    carried = np.linalg.inv(Ad(H)).T @ shaking(here, way.u, way.ud, way.udd).T
    found = shaking(there, way.u, way.ud, way.udd)
    sign = np.sign(there.joints[0].screw[:3] @ H[:3, :3] @ here.joints[0].screw[:3])
    assert sign == 1.0
    # Screws of the placed file carry the rounding of its angles.
    assert np.allclose(found, carried.T, rtol=0, atol=1e-10 * np.abs(found).max())


def test_planar_parameters_are_thin_bodies():
    """In the axes of the plane; nothing shakes out of it."""
    found = design_space(kinematics.load("four_bar_kite"))
    linkage, z = found.linkage, found.basis @ coordinates(found)
    full = mass_parameters(linkage, z)
    n = linkage.chain.frame.R[2]
    assert np.allclose(full[:, 1:4] @ n, 0.0)
    assert np.allclose(full[:, 1:4] @ linkage.chain.frame.R[:2].T, z.reshape(3, 4)[:, 1:3])
    way = states(linkage, 5, seed=0)
    off = full.copy()
    off[:, 0] += 1.0
    wrench = shaking(linkage, way.q, way.ud, way.udd, off)
    assert np.abs(wrench[:, :3] - np.outer(wrench[:, :3] @ n, n)).max() < 1e-12
    assert np.abs(wrench[:, 3:] @ n).max() < 1e-12


def test_the_verdict_is_relative_to_the_inertia_of_the_bodies():
    linkage = kinematics.load("four_bar_general")
    options = {"trajectories": 1, "samples": 30}
    found = verify(linkage, **options)
    worst = max(found.force_residual, found.moment_residual)
    assert 0.1 < worst <= 1.0
    # Moments about the middle, over the length that makes them comparable with forces.
    run, frame = found.runs[0], linkage.spatial_chain.frame
    about = run.shaking[:, :3] - np.cross(frame.origin, run.shaking[:, 3:])
    moment = np.linalg.norm(about, axis=1).max()
    scale = sizes(linkage, run.trajectory, mass_parameters(linkage)).max()
    assert found.moment == pytest.approx(moment, rel=1e-12)
    assert found.moment_residual == pytest.approx(moment / (frame.length * scale), rel=1e-12)
    assert found.moment_ratio == pytest.approx(moment / (frame.length * found.bearing))
    heavier = verify(linkage, 50.0 * mass_parameters(linkage), **options)
    assert heavier.force_residual == pytest.approx(found.force_residual, rel=1e-12)
    assert heavier.force == pytest.approx(50.0 * found.force, rel=1e-12)
    assert verify(linkage, tolerance=1.01 * worst, **options).balanced
    assert not verify(linkage, tolerance=0.99 * worst, **options).balanced
    nothing = verify(linkage, np.zeros((3, 10)), **options)
    assert nothing.balanced and "nothing with mass moves" in nothing.remarks
    with pytest.raises(ValueError, match="balance must be"):
        verify(linkage, balance="static")
    with pytest.raises(MotionError, match="'nonsense'"):
        verify(linkage, motion="nonsense")


def test_near_a_singularity_a_remark_says_so():
    linkage = kinematics.load("four_bar_kite_balanced")
    way = next(iter(random_motions(linkage, 1, 60)))
    assert verify(linkage, motions=[way]).balanced
    u = np.linspace(0.0, -1.2, 300)[:, None]
    near = drive(linkage, np.linspace(0, 1, 300), u, np.full_like(u, -1.2), np.zeros_like(u))
    found = verify(linkage, motions=[near])
    assert near.conditioning < 0.02
    assert any("singularity" in remark for remark in found.remarks)


def test_a_second_linkage_moves_alike_if_it_can():
    first = verify(kinematics.load("four_bar_general"), trajectories=1, samples=30)
    same = verify_second(first, kinematics.load("four_bar_antiparallelogram_balanced"))
    assert same.seed is None and same.balanced
    assert np.array_equal(same.runs[0].trajectory.u, first.runs[0].trajectory.u)
    options = {"trajectories": 1, "samples": 30}
    wide = verify(kinematics.load("four_bar_general"), trajectories=10, samples=30)
    own = verify_second(wide, kinematics.load("four_bar_kite_balanced"), **options)
    assert own.seed == 0 and own.balanced
    other = verify_second(first, kinematics.load("five_bar"), **options)
    assert other.seed == 0 and other.runs[0].trajectory.u.shape == (30, 2)


def test_without_pinocchio_a_line_says_what_to_install(monkeypatch):
    linkage = kinematics.load("four_bar_kite")
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(LinkageError, match="pip install pin"):
        verify(linkage)
    # A test runner of that name is no Pinocchio either.
    monkeypatch.setitem(sys.modules, "pinocchio", type(sys)("pinocchio"))
    with pytest.raises(LinkageError, match="pip install pin"):
        verify(linkage)
    assert np.isfinite(shaking(linkage, [0.1], [1.0], [0.0])).all()


def test_a_centre_of_mass_without_mass_is_refused():
    found = space(next(figure for figure in FIGURES if figure.model == "hprs"))
    linkage, z = found.linkage, found.basis @ coordinates(found)
    with pytest.raises(LinkageError, match="next to no mass"):
        verify(linkage, z)
    way = states(linkage, 20, seed=5)
    left = np.abs(shaking(linkage, way.q, way.ud, way.udd, z)).max()
    assert left <= 1e-12 * sizes(linkage, way, mass_parameters(linkage, z)).max()
    linkage = kinematics.load("four_bar_kite")
    z = mass_parameters(linkage)
    z[1, 0] = 0.0
    with pytest.raises(LinkageError, match="next to no mass"):
        verify(linkage, z)
    z[1] = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]
    assert verify(linkage, z, trajectories=1, samples=20).agreed
