"""Motions in time: loops stay closed, rates are derivatives, the branch is kept."""

from __future__ import annotations

from itertools import islice

import numpy as np
import pytest
from scipy.linalg import expm

import kinematics
from balance.motion.verification.given_motions import (
    from_csv,
    rate_columns,
    rates_off,
    rest_to_rest,
)
from balance.motion.verification.trajectory import drive, random_motions
from kinematics.closure.joint_positions import joint_positions
from kinematics.errors import FileError, MotionError, PoseError
from kinematics.model.motion import Motion
from kinematics.model.spatial.screws import hat
from tests.support.covering import spread
from tests.support.laws import MODELS, altered, words
from tests.support.motions import around, slope

FEW = ("four_bar_kite", "slider_crank", "three_rsr", "hprs", "sarrus", "stewart_6ups")
HARD = ("four_bar_antiparallelogram", "scissor_three_stage", "delta")


def gap(linkage, q) -> float:
    """Largest mismatch of the welds at joint positions q, as products of exponentials."""
    H = {-1: np.eye(4)}
    for j, (joint, value) in enumerate(zip(linkage.joints, q, strict=True)):
        H[j] = H[joint.parent] @ expm(hat(joint.screw) * value)
    return max((np.abs(H[x.end] - H[x.successor]).max() for x in linkage.loops), default=0.0)


@pytest.mark.parametrize("model", ["four_bar_general", "stewart_6ups"])
def test_inputs_that_rest_up_to_rounding_are_followed(model):
    """Ways between samples of one bit; no input is lost by many of them."""
    linkage = kinematics.load(model)
    for start in 1e-4 * (1.0 + np.arange(20) / 7.0):
        inputs = [0.0, start, np.nextafter(start, 1.0), start + 3.0 * np.spacing(start)]
        inputs += [*(start + 1e-14 * np.arange(40)), 2e-3]
        u = np.outer(inputs, np.ones(linkage.mobility))
        way = drive(linkage, np.arange(len(u)), u, 0.0 * u, 0.0 * u)
        driven = way.q[:, linkage.positions_of(linkage.inputs)]
        assert np.abs(driven - u).max() <= 3e-13
        assert way.q[-1] == pytest.approx(joint_positions(linkage, u[-1]), abs=1e-12)


@pytest.mark.table
@pytest.mark.parametrize("model", spread(MODELS, 3))
def test_loops_stay_closed_and_motions_return(model):
    linkage = kinematics.load(model)
    (way,) = random_motions(linkage, 1, 60, seed=4)
    assert way.closure <= 1e-12
    frame = linkage.spatial_chain.frame
    for k in (0, 23, 41, 59):
        assert gap(linkage, way.q[k]) <= 1e-12 * (
            1.0 + frame.length + np.abs(frame.origin).max()
        )
    assert np.abs(way.q[-1] - way.q[0]).max() < 1e-11
    assert np.array_equal(way.u[0], np.zeros(linkage.mobility))
    assert np.abs(way.u).max() > 0.02


@pytest.mark.parametrize("model", FEW + HARD)
def test_rates_are_derivatives(model):
    """Of all joints, by differences along a motion of the inputs that touches the sample."""
    linkage = kinematics.load(model)
    (way,) = random_motions(linkage, 1, 50, seed=1)
    step = 2e-4
    for k in (7, 31):
        near = around(linkage, way, k, step)
        assert np.abs(near.q[4] - way.q[k]).max() < 1e-10
        for values, rate in ((near.q, way.qd[k]), (near.qd, way.qdd[k])):
            # Differences lose the digits that the step takes.
            assert np.abs(slope(values, step) - rate).max() <= 1e-8 * np.abs(rate).max()


def test_inputs_move_as_they_are_told():
    linkage = kinematics.load("three_rsr")
    inputs = linkage.positions_of(linkage.inputs)
    (way,) = random_motions(linkage, 1, 200)
    step = way.time[1]
    for k in (20, 110):
        window = slice(k - 4, k + 5)
        assert slope(way.u[window], step) == pytest.approx(way.ud[k], rel=1e-8)
        assert slope(way.ud[window], step) == pytest.approx(way.udd[k], rel=1e-8)
    for joint, told in ((way.q, way.u), (way.qd, way.ud), (way.qdd, way.udd)):
        assert np.allclose(joint[:, inputs], told, rtol=1e-12, atol=1e-12)


def test_seeds_make_motions():
    linkage = kinematics.load("five_bar")
    first, again, other = (list(random_motions(linkage, 2, 20, s)) for s in (3, 3, 5))
    more = list(islice(random_motions(linkage, 9, 20, 3), 2))
    for k in range(2):
        assert np.array_equal(first[k].u, again[k].u)
        assert np.array_equal(first[k].u, more[k].u)
        assert not np.allclose(first[k].u, other[k].u)
    assert not np.allclose(first[0].u, first[1].u)


def test_no_motion_comes_near_a_singularity():
    """The kite folds flat within reach of its crank, where a second branch begins."""
    linkage = kinematics.load("four_bar_kite")
    for way in random_motions(linkage, 10):
        assert way.conditioning >= 0.25
    far = drive(linkage, *straight(linkage, -0.8))
    assert far.conditioning < 0.1


def straight(linkage, goal):
    """Time and inputs of a straight line from the reference pose, with constant speed."""
    time = np.linspace(0.0, 1.0, 40)
    u = np.outer(time, np.full(linkage.mobility, goal))
    return time, u, np.full_like(u, goal), np.zeros_like(u)


def test_the_last_step_ends_at_the_goal(tmp_path):
    """Of a way whose steps add up to it only but for rounding, nothing is left over."""

    def moved(robot):
        A, B, C, D = np.array([[0.8, 0.4, 0], [0.4, 0.6, 0], [-0.5, -0.3, 0], [-0.6, -0.9, 0]])
        for path, place in (
            ("joint[@name='u1']", A),
            ("joint[@name='q2']", B - A),
            ("joint[@name='q4']", D),
            ("loop/predecessor", C - B),
            ("loop/successor", C - D),
        ):
            robot.find(f"{path}/origin").set("xyz", words(place))

    linkage = kinematics.load(altered("four_bar_general", tmp_path, moved))
    for goal in np.linspace(0.2, 0.26, 61):
        q = joint_positions(linkage, [goal])
        assert q[linkage.positions_of(["u1"])] == pytest.approx([goal], rel=1e-15)
        assert gap(linkage, q) < 1e-12


def test_a_motion_that_cannot_be_followed_is_refused():
    linkage = kinematics.load("four_bar_general", inputs=["q4"])
    with pytest.raises(PoseError, match=r"cannot be closed beyond 0\.\d+ s"):
        drive(linkage, *straight(linkage, 4.0))
    time, u, ud, udd = straight(linkage, 0.1)
    with pytest.raises(PoseError, match="one row of 1 inputs"):
        drive(linkage, time, np.hstack([u, u]), ud, udd)
    with pytest.raises(PoseError, match="finite"):
        drive(linkage, time, u * np.nan, ud, udd)


def test_a_motion_restricts_the_inputs():
    linkage = kinematics.load("three_rsr")
    motion = Motion.parse("u2=u3", linkage.inputs)
    for way in random_motions(linkage, 2, 30, motion=motion):
        assert np.abs(way.u[:, 1] - way.u[:, 2]).max() < 1e-12
        assert np.abs(way.u).max(axis=0).min() > 0.01
    with pytest.raises(MotionError, match="made for the inputs"):
        next(random_motions(linkage, 1, motion=Motion.free(["a"])))


def test_rest_to_rest_begins_and_ends_at_rest():
    linkage = kinematics.load("five_bar")
    stops = np.array([[0.0, 0.0], [0.2, -0.1], [0.1, 0.2]])
    way = rest_to_rest(linkage, stops, duration=0.5, samples=201)
    for k, stop in zip((0, 100, 200), stops, strict=True):
        assert np.allclose(way.u[k], stop, atol=1e-14)
        assert np.abs(way.qd[k]).max() < 1e-13 and np.abs(way.qdd[k]).max() < 1e-12
    assert way.time[-1] == 1.0
    step = way.time[1]
    for k in (50, 140):
        window = slice(k - 4, k + 5)
        assert np.allclose(slope(way.q[window], step), way.qd[k], rtol=1e-8, atol=1e-8)
        assert np.allclose(slope(way.qd[window], step), way.qdd[k], rtol=1e-6, atol=1e-6)
    with pytest.raises(PoseError, match="two or more poses"):
        rest_to_rest(linkage, [[0.0, 0.0]])


def table(path, linkage, u, time, names=None):
    lines = [",".join(names or ["time", *linkage.inputs])]
    lines += [",".join(map(repr, row)) for row in np.column_stack([time, u]).tolist()]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_a_table_is_a_motion(tmp_path):
    """A polynomial of degree five is its own spline, so that its derivatives are exact."""
    linkage = kinematics.load("five_bar")
    time = np.sort(np.random.default_rng(0).uniform(0.0, 1.0, 30))
    powers = np.array([[0.0, 0.2, -0.3, 0.1, 0.2, -0.1], [0.1, -0.2, 0.1, 0.1, -0.2, 0.1]])
    polynomials = [np.polynomial.Polynomial(row) for row in powers]
    u, ud, udd = (
        np.column_stack([p.deriv(k)(time) if k else p(time) for p in polynomials])
        for k in range(3)
    )
    way = from_csv(linkage, table(tmp_path / "a.csv", linkage, u, time))
    assert np.allclose(way.u, u, rtol=0, atol=1e-15)
    assert np.allclose(way.ud, ud, atol=1e-9) and np.allclose(way.udd, udd, atol=1e-7)
    swapped = table(tmp_path / "b.csv", linkage, u[:, ::-1], time, ["time", "u2", "u1"])
    assert np.array_equal(from_csv(linkage, swapped).u, way.u)
    motion = Motion.parse("u1=u2", linkage.inputs)
    with pytest.raises(FileError, match="not on u1=u2"):
        from_csv(linkage, tmp_path / "a.csv", motion)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", "columns must be time, u1"),
        ("time,u1\n", "holds 0 samples"),
        ("time,u2\n" + "0,0\n" * 8, "columns must be time, u1"),
        ("time,u1\n" + "".join(f"{k},0\n" for k in range(5)), "holds 5 samples"),
        ("time,u1\n" + "0,0\n" * 8, "times do not increase"),
        ("time,u1\n" + "".join(f"{k},x\n" for k in range(8)), "sample 1: cannot be read"),
        ("time,u1\n" + "".join(f"{k}\n" for k in range(8)), "sample 1: cannot be read"),
        ("time,u1\n" + "".join(f"{k},nan\n" for k in range(8)), "not finite"),
    ],
)
def test_bad_tables_are_refused(text, problem, tmp_path):
    linkage = kinematics.load("four_bar_kite")
    path = tmp_path / "a.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileError, match=problem):
        from_csv(linkage, path)
    path.write_bytes(b"\xff\xfe\x00time")
    with pytest.raises(FileError, match="cannot be read"):
        from_csv(linkage, path)
    with pytest.raises(FileError, match="No such file"):
        from_csv(linkage, tmp_path / "missing.csv")


def test_a_table_may_have_velocities_and_accelerations(tmp_path):
    """They are taken as they are; those that a spline does not confirm are refused."""
    linkage = kinematics.load("five_bar")
    time = np.linspace(0.0, 1.0, 401)
    size = np.array([0.3, -0.2])
    u, ud, udd = (
        np.multiply.outer(wave, size * 3.0**k)
        for k, wave in enumerate((np.sin(3.0 * time), np.cos(3.0 * time), -np.sin(3.0 * time)))
    )
    columns = ["time", *linkage.inputs, *rate_columns(linkage)]
    rows = np.column_stack([time, u, ud, udd])

    def written(rows):
        path = tmp_path / "motion.csv"
        lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows.tolist())]
        path.write_text("\n".join(lines), encoding="utf-8")
        return path

    way = from_csv(linkage, written(rows))
    assert np.array_equal(way.ud, ud) and np.array_equal(way.udd, udd)
    assert 1e-14 < rates_off(time, u, ud, udd) < 1e-7
    for column in (3, 6):
        wrong = rows.copy()
        wrong[:, column] *= 1.0 + 1e-5
        with pytest.raises(FileError, match="not those of its displacements"):
            from_csv(linkage, written(wrong))
