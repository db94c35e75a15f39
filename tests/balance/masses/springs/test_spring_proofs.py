"""Proofs of springs in rational numbers, and springs of which both ends are free.

The second route writes rotations by Cayley's formula and evaluates the sum of the energies at
other rational poses, exactly.
"""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest

import balance
import kinematics
from balance.app.cli.main import main
from balance.masses.springs.energy_identity import FreeEnd, prove_constant
from balance.masses.springs.rational_solution import inconsistency, rational, solve_rational
from kinematics.errors import UsageError
from tests.support.spring_energies import (
    G,
    balancer,
    lamp,
    random_arm,
    torques_with_springs,
)

LAMP_SPRINGS = (
    "base@0,0,0.2 upper@0.4,0,0",
    "lower@0,0,0.7 upper@0.4,0,0",
    "base@0,0,0.2 lower@0,0,0.1",
)


def cayley(n, t):
    """Rotation ``1 + 2 t/(1 + t² n·n) ([n] + t [n]²)`` in rational numbers."""
    x, y, z = n
    N = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]], dtype=object)
    factor = 2 * t / (1 + t * t * (x * x + y * y + z * z))
    return np.eye(3, dtype=int).astype(object) + factor * (N + t * N.dot(N))


def exact_energy(linkage, proof, ends, t):
    """Energy of springs and gravity of an arm whose hinges have Cayley parameters t."""
    frames = []
    for joint, value in zip(linkage.joints, t, strict=True):
        n, p = (
            np.array([rational(x) for x in v], dtype=object)
            for v in (joint.direction, joint.point)
        )
        R = cayley(n, value)
        r = p - R.dot(p)
        if joint.parent >= 0:
            before, origin = frames[joint.parent]
            R, r = before.dot(R), before.dot(r) + origin
        frames.append((R, r))
    frames.append((np.eye(3, dtype=int).astype(object), np.zeros(3, dtype=int).astype(object)))
    g, total = np.array(proof.gravity, dtype=object), Fraction(0)
    for link, mass, moment in proof.masses:
        R, r = frames[link]
        total -= g.dot(mass * r + R.dot(np.array(moment, dtype=object)))
    for k, links, points in zip(proof.stiffnesses, ends, proof.points, strict=True):
        a, b = (
            frames[link][0].dot(np.array(p, dtype=object)) + frames[link][1]
            for link, p in zip(links, points, strict=True)
        )
        total += k * (a - b).dot(a - b) / 2
    return total


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(k, marks=pytest.mark.slow) for k in (0, 2, 3, 4, 5))]
)
def test_the_sum_is_the_same_fraction_at_other_poses(seed):
    linkage, between = random_arm(seed)
    answer = balance.springs(linkage, between)
    assert answer.certainty.level == "proved"
    ends = [
        tuple(linkage.places[end.link].link for end in spring.ends)
        for spring in answer.springs
        if spring.stiffness
    ]
    draw = random.Random(seed)
    sums = set()
    for _ in range(4):
        t = [Fraction(draw.randint(-90, 90), draw.randint(1, 40)) for _ in linkage.joints]
        sums.add(exact_energy(linkage, answer.proof, ends, t))
    assert len(sums) == 1
    needed = [spring.stiffness for spring in answer.springs if spring.stiffness]
    assert [float(k) for k in answer.proof.stiffnesses] == pytest.approx(needed, rel=1e-8)


def test_other_stiffnesses_are_not_proved():
    linkage = lamp()
    answer = balance.springs(linkage, LAMP_SPRINGS)
    assert answer.certainty.level == "proved"
    fixed = [FreeEnd(0, (), False)] * 3
    # A thousandth off, which no stiffness may make good.
    wrong = answer.springs[0]._replace(stiffness=1.001 * answer.springs[0].stiffness)
    told = prove_constant(linkage, [wrong, *answer.springs[1:]], fixed, answer.gravity, [1, 2])
    assert isinstance(told, str)
    free = [FreeEnd(0, (), True)] * 3
    assert not isinstance(
        prove_constant(linkage, answer.springs, free, answer.gravity, [1, 2]), str
    )


def test_a_parallelogram_is_proved_on_its_mode_alone():
    """The antiparallelogram closes the same loop: without equal angles there is no identity."""
    linkage = kinematics.load("four_bar_parallelogram")
    ground = next(iter(linkage.places))
    between = [f"{ground},{body.name}" for body in linkage.bodies]
    answer = balance.springs(linkage, between, gravity=(0, -G, 0))
    assert (answer.certainty.level, answer.proof.poses) == ("proved", 3)
    free = [FreeEnd(0, (0, 1), True)] * len(between)
    apart = list(range(1, len(linkage.joints) + 1))
    told = prove_constant(linkage, answer.springs, free, answer.gravity, apart)
    assert isinstance(told, str)


def test_that_no_stiffnesses_balance_is_proved():
    answer = balance.springs(lamp(), "base@0,0,0:0.2 lower@0,0,0.1")
    assert (answer.verdict, answer.certainty.level) == ("infeasible", "proved")
    # One that pulls the wrong way would balance with a negative stiffness: not excluded so.
    answer = balance.springs(balancer(), "base@0,0,-0.4 arm@0.25,0,0")
    assert (answer.verdict, answer.certainty.level) == ("infeasible", "estimated")


def test_rational_systems():
    third = Fraction(1, 3)
    rows = [[third, 1, 0], [2, 0, 1], [2 + third, 1, 1]]
    rows = [[Fraction(x) for x in row] for row in rows]
    right = [Fraction(1), Fraction(2), Fraction(3)]
    start = [Fraction(0), Fraction(0), Fraction(5, 7)]
    x = solve_rational(rows, right, start, 3)
    assert [sum(a * b for a, b in zip(row, x, strict=True)) for row in rows] == right
    assert not inconsistency(rows, right)
    right[2] += Fraction(1, 10**30)
    assert solve_rational(rows, right, start, 3) is None and inconsistency(rows, right)


def test_both_ends_of_a_spring_may_be_free():
    """k r a = m g l with k given: any r and a of that product; and with all three free."""
    answer = balance.springs(balancer(), "base@0,0,-1:1 arm@0.1:0.5,0,0 k=100")
    (spring,) = answer.springs
    (a, b) = spring.ends
    assert answer.verdict == "feasible" and spring.stiffness == pytest.approx(100)
    assert 100 * a.point[2] * b.point[0] == pytest.approx(2 * G * 0.3, rel=1e-9)
    left, gravity = torques_with_springs(balancer(), answer, 10)
    assert np.abs(left).max() < 1e-10 * np.abs(gravity).max()


@pytest.mark.slow
def test_two_links_with_all_ends_free_and_given_stiffnesses():
    linkage = lamp()
    answer = balance.springs(
        linkage,
        [
            "base@0,0,0:0.5 upper@0:0.5,0,0 k=30",
            "lower@0,0,0:0.9 upper@0:0.5,0,0 k=60",
            "base@0,0,0:0.5 lower@0,0,0:0.5 k=50",
        ],
    )
    assert answer.verdict == "feasible" and answer.certainty.level == "proved"
    for spring, k in zip(answer.springs, (30, 60, 50), strict=True):
        assert spring.stiffness == 0.0 or spring.stiffness == pytest.approx(k, rel=1e-12)
    left, gravity = torques_with_springs(linkage, answer, 20)
    assert np.abs(left).max() < 1e-10 * np.abs(gravity).max()


def test_a_relaxation_excludes_what_points_cannot_do():
    answer = balance.springs(balancer(), "base@0,0,-1:-0.1 arm@0.1:0.5,0,0")
    assert (answer.verdict, answer.excluded) == ("infeasible", True)


def test_what_is_neither_found_nor_excluded_is_undecided(capsys, tmp_path):
    """One spring on two links: its energy in the angle between them never vanishes."""
    answer = balance.springs(lamp(), "base@0,0,-0.5:0.5 upper@-0.5:0.5,0,0")
    assert (answer.verdict, answer.excluded) == ("undecided", False)
    assert "no points of both ends were found" in answer.words
    path = tmp_path / "lamp.urdf"
    path.write_text(lamp().to_urdf(), encoding="utf-8")
    words = ["springs", str(path), "--between", "base@0,0,-0.5:0.5 upper@-0.5:0.5,0,0"]
    assert main(words) == 4


def test_both_ends_free_do_not_go_with_a_range_of_loads():
    with pytest.raises(UsageError, match="one end may be free, not both"):
        balance.springs(balancer(), "base@0,0,0:1 arm@0:1,0,0", payload="arm=0:1")
