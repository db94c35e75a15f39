"""Springs with a free length, and catalogues of them, against Pinocchio, MuJoCo and cvxpy."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

import balance
from balance.masses.springs.rational_solution import rational
from balance.masses.springs.spring_catalogue import CatalogueSpring, read_catalogue
from balance.masses.springs.spring_text import read_spring
from kinematics.errors import UsageError
from tests.support.spring_energies import (
    G,
    balancer,
    lamp,
    mujoco_model,
    random_arm,
    torques_at,
    torques_with_springs,
)

WAY = "base@0,0,0.4 arm@0.25,0,0"


def reach(u):
    """Distance of (0, 0, 0.4) from the point 0.25 along the arm, and its rate, by hand."""
    d = np.sqrt(0.4**2 + 0.25**2 + 2 * 0.4 * 0.25 * np.sin(u))
    return d, 0.4 * 0.25 * np.cos(u) / d


def torque(u, springs):
    """Torque that holds the arm of `balancer` with springs ``(k, L)`` along `WAY`."""
    d, rate = reach(u)
    return -2 * G * 0.3 * np.cos(u) + sum(k * (d - length) * rate for k, length in springs)


def test_a_preloaded_pair_acts_as_one_without_free_length():
    """Σ k L = 0 and Σ k r a = m g l: one spring pulls where its ends meet, one pushes."""
    answer = balance.springs(balancer(), [f"{WAY} L0=0.1", f"{WAY} L0=-0.05"])
    first, second = (spring.stiffness for spring in answer.springs)
    assert answer.verdict == "feasible" and answer.sets == ((0, 1),)
    assert 0.1 * first == pytest.approx(0.05 * second, rel=1e-12)
    assert (first + second) * 0.25 * 0.4 == pytest.approx(2 * G * 0.3, rel=1e-9)
    left, gravity = torques_with_springs(balancer(), answer, 20)
    assert np.abs(left).max() < 1e-10 * np.abs(gravity).max()
    assert answer.certainty.level == "proved"
    lengths = [rational(spring.free_length) for spring in answer.springs]
    pairs = zip(answer.proof.stiffnesses, lengths, strict=True)
    assert sum(k * length for k, length in pairs) == 0


def test_points_of_a_pair_are_those_of_a_spring_without_free_length():
    """Points are found without a free length; a pair of real springs there is proved."""
    one = balance.springs(balancer(), "base@0,0,0:0.6 arm@0.25,0,0 k=58.86").springs[0]
    place = ",".join(repr(x) for x in one.ends[0].point)
    ends = f"base@{place} arm@0.25,0,0"
    pair = balance.springs(balancer(), [f"{ends} L0=0.1", f"{ends} L0=-0.05"])
    assert sum(spring.stiffness for spring in pair.springs) == pytest.approx(58.86, rel=1e-9)
    assert pair.verdict == "feasible"
    left, gravity = torques_with_springs(balancer(), pair, 20)
    assert np.abs(left).max() < 1e-10 * np.abs(gravity).max()


def test_a_given_stiffness_decides_the_other_of_a_pair():
    answer = balance.springs(balancer(), [f"{WAY} L0=0.1 k=19.62", f"{WAY} L0=-0.05"])
    assert answer.springs[1].stiffness == pytest.approx(39.24, rel=1e-9)
    assert answer.certainty.level == "proved"


def test_the_free_length_that_balances_is_none():
    """Of a range of free lengths the spring balancer takes 0."""
    answer = balance.springs(balancer(), f"{WAY} L0=-0.1:0.2")
    (spring,) = answer.springs
    assert (answer.verdict, spring.free_length) == ("feasible", 0.0)
    assert spring.stiffness == pytest.approx(2 * G * 0.3 / (0.25 * 0.4), rel=1e-9)


def test_a_free_length_is_no_balance():
    """Alone it leaves torque, by least squares over the workspace by hand."""
    answer = balance.springs(balancer(), f"{WAY} L0=0.1")
    u = answer.inputs[:, 0]
    gravity, unit = torque(u, []), torque(u, [(1.0, 0.1)]) - torque(u, [])
    k = -(unit @ gravity) / (unit @ unit)
    (spring,) = answer.springs
    assert answer.verdict == "infeasible"
    assert spring.stiffness == pytest.approx(k, rel=1e-6)
    assert np.abs(answer.after[:, 0]) == pytest.approx(
        np.abs(torque(u, [(spring.stiffness, 0.1)])), abs=1e-9 * np.abs(gravity).max()
    )
    d, _ = reach(u)
    assert spring.force == pytest.approx(spring.stiffness * np.abs(d - 0.1).max(), rel=1e-9)


def with_free_lengths(seed):
    """A random arm, in a plane or in space, and springs of free lengths, 5 N/m at least."""
    linkage, between = random_arm(seed)
    rng = np.random.default_rng(seed)
    texts = []
    for text in between:
        near, far = text.split()
        point = ",".join(f"{x:.6g}" for x in rng.uniform(-0.6, 0.6, 3))
        length = rng.uniform(0.05, 0.2)
        end = f"{near.partition('@')[0]}@{point}"
        texts.append(f"{end} {far} L0={length:.6g} k=5:60")
    return linkage, texts


@pytest.mark.parametrize(
    "seed", [3, *(pytest.param(k, marks=pytest.mark.slow) for k in (0, 1, 2, 4, 5))]
)
def test_torques_left_are_those_of_pinocchio_and_of_tendons(seed):
    linkage, between = with_free_lengths(seed)
    answer = balance.springs(linkage, between)
    left, gravity = torques_at(linkage, answer, answer.inputs)
    size = np.abs(gravity).max()
    assert answer.after == pytest.approx(left, abs=1e-10 * size)
    assert answer.before == pytest.approx(gravity, abs=1e-10 * size)
    mujoco = pytest.importorskip("mujoco")
    model = mujoco_model(mujoco, linkage, answer)
    data = mujoco.MjData(model)
    for q, expected in zip(answer.inputs, answer.after, strict=True):
        data.qpos[:] = q
        mujoco.mj_forward(model, data)
        assert data.qfrc_bias - data.qfrc_spring == pytest.approx(expected, abs=1e-9 * size)


@pytest.mark.slow
def test_the_least_torque_with_a_free_length_is_that_of_cvxpy():
    """Unknowns k and k L, by another solver, in closed form."""
    cvxpy = pytest.importorskip("cvxpy")
    answer = balance.springs(balancer(), f"{WAY} L0=0.05:0.2 k=20:55")
    u = answer.inputs[:, 0]
    d, rate = reach(u)
    k, part = cvxpy.Variable(), cvxpy.Variable()
    left = torque(u, []) + k * (d * rate) - part * rate
    limits = [k >= 20, k <= 55, part >= 0.05 * k, part <= 0.2 * k]
    problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.sum_squares(left)), limits)
    least = np.sqrt(problem.solve(solver="CLARABEL"))
    assert np.linalg.norm(answer.after) == pytest.approx(least, rel=1e-5)
    (spring,) = answer.springs
    assert spring.free_length == pytest.approx(part.value / k.value, rel=1e-3)


def test_a_catalogue_is_enumerated():
    """The pair of springs that leaves least, among all, by the torques by hand."""
    listed = [(k, length) for k in (20.0, 35.0, 70.0) for length in (0.02, 0.06, 0.11)]
    answer = balance.springs(balancer(), [WAY, WAY], catalogue=listed)
    u = answer.inputs[:, 0]
    choices = product([None, *listed], repeat=2)
    sizes = {
        choice: np.linalg.norm(torque(u, [entry for entry in choice if entry]))
        for choice in choices
    }
    least = min(sizes.values())
    taken = [(spring.stiffness, spring.free_length) for spring in answer.springs]
    taken = tuple(entry if entry[0] else None for entry in taken)
    assert answer.verdict == "infeasible"
    assert sizes[taken] == pytest.approx(least, rel=1e-12)
    assert np.linalg.norm(answer.after) == pytest.approx(least, rel=1e-9)


def test_a_catalogue_may_hold_the_spring_that_balances():
    listed = [(50.0, 0.01), (58.86, 0.0), (58.86, 0.03)]
    answer = balance.springs(balancer(), WAY, catalogue=listed)
    assert answer.verdict == "feasible"
    assert (answer.springs[0].stiffness, answer.springs[0].free_length) == (58.86, 0.0)
    # A free length that is asked for leaves the others of the catalogue out.
    answer = balance.springs(balancer(), f"{WAY} L0=0.03", catalogue=listed)
    assert (answer.springs[0].stiffness, answer.springs[0].free_length) == (58.86, 0.03)


def test_springs_shorter_than_their_free_length_are_named():
    answer = balance.springs(balancer(), f"{WAY} L0=0.3")
    assert answer.springs[0].pushes and [note.code for note in answer.notices] == [
        "spring_pushes"
    ]
    assert not balance.springs(balancer(), f"{WAY} L0=0.1").notices


def test_text_of_catalogues():
    assert read_catalogue("400,0.2N/mm@50mm") == [(200.0, 0.05), (400.0, 0.0)]
    steps = read_catalogue("100:300:100@0.1:0.3:0.1")
    assert steps == [
        CatalogueSpring(k, length) for k in (100.0, 200.0, 300.0) for length in (0.1, 0.2, 0.3)
    ]
    spring = read_spring("base@0,0,1 arm@1,0,0 L0=2cm:50mm k=100")
    assert (spring.length, spring.stiffness) == ((0.02, 0.05), (100.0, 100.0))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("400@", "is not a number"),
        ("5:40", "is no steps"),
        ("40:5:1", "is no steps"),
        ("5:40:0", "is no steps"),
        ("1:1000:1@0:1:0.1", "more than 1000 springs"),
        ("0", "stiffnesses above 0"),
        ("10@2kg", "unit of mass"),
    ],
)
def test_catalogues_that_cannot_be(text, told):
    with pytest.raises(UsageError) as raised:
        read_catalogue(text)
    assert told in str(raised.value) and "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("between", "more", "told"),
    [
        ("base,arm L0=0.1", {}, "has no known form"),
        ("base@0,0,0:1 arm@0.2,0,0 L0=0.1", {}, "has one point at each end"),
        ("base,arm", {"catalogue": [(50.0, 0.1)]}, "has one point at each end"),
        (f"{WAY} L0=0.2:0.1", {}, "is not a number or a range"),
        (f"{WAY} L0=1e9", {}, "free length is beyond"),
        (f"{WAY} L0=0:0.1", {"payload": "arm=0:1"}, "give one free length"),
        (WAY, {"catalogue": [(50.0, np.nan)]}, "free lengths up to"),
    ],
)
def test_free_lengths_that_cannot_be(between, more, told):
    with pytest.raises(UsageError) as raised:
        balance.springs(balancer(), between, **more)
    assert told in str(raised.value) and "\n" not in str(raised.value)


def test_a_range_of_loads_with_a_free_length():
    """Springs of one free length that stay: what they leave for both ends, by Pinocchio."""
    answer = balance.springs(balancer(), f"{WAY} L0=0.05", payload="arm@0.5,0,0=0:1")
    u, k = answer.inputs[:, 0], answer.springs[0].stiffness
    for mass, share in zip((0.0, 1.0), answer.loads.torque_shares, strict=True):
        load = -mass * G * 0.5 * np.cos(u)
        left = torque(u, [(k, 0.05)]) + load
        alone = torque(u, []) + load
        assert share == pytest.approx(np.linalg.norm(left) / np.linalg.norm(alone), rel=1e-9)


@pytest.mark.slow
def test_energies_of_the_lamp_with_a_pair_are_constant():
    """Three springs of the lamp, one of them a pair: still a constant sum."""
    between = [
        "base@0,0,0.2 upper@0.4,0,0",
        "lower@0,0,0.7 upper@0.4,0,0",
        "base@0,0,0.2 lower@0,0,0.1 L0=0.04",
        "base@0,0,0.2 lower@0,0,0.1 L0=-0.02",
    ]
    answer = balance.springs(lamp(), between)
    assert answer.verdict == "feasible" and answer.certainty.level == "proved"
    left, gravity = torques_with_springs(lamp(), answer, 30)
    assert np.abs(left).max() < 1e-10 * np.abs(gravity).max()
