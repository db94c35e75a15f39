"""Formulas of spatial linkages in other geometries, by frames and poses of their own."""

from __future__ import annotations

import random

import numpy as np
import pytest

import balance
from balance.space.formulas.derive import fresh_geometries
from balance.space.formulas.polynomials import Quotient
from balance.space.formulas.problem import problem_of
from balance.space.formulas.spatial_pose import place_parts
from balance.space.formulas.spatial_samples import displaced_pose
from kinematics import ScrewJoint, from_screws
from kinematics.errors import ExactError, UsageError
from kinematics.numerics.linalg.prime_field import PRIMES_OF_61_BITS
from tests.support.formula_rows import matrix
from tests.support.spatial_frames import (
    frames_along,
    masses_in,
    normal_of,
    size_of_violation,
)


def lines_at_random(seed, count):
    rng = np.random.default_rng(seed)
    lines = []
    for _ in range(count):
        direction = rng.normal(size=3)
        lines.append((rng.normal(size=3), direction / np.linalg.norm(direction)))
    return lines


def linkage_of(lines, loop=False):
    """An arm, or a loop with the ground, with revolute joints along lines."""
    links = ["base", *(f"link{k}" for k in range(1, len(lines) + 1))]
    joints = [
        ScrewJoint(f"q{k}", links[k], links[k + 1], axis=axis, point=point)
        for k, (point, axis) in enumerate(lines)
    ]
    if not loop:
        return from_screws(joints)
    return from_screws(joints[:-1], [joints[-1]._replace(child="base")])


def values_of(formulas, values):
    """Values by the names of the arguments, with offsets by the names of joints."""
    joints = [joint.name for joint in formulas.parts.joints]
    return values | {f"h_{name}": values.get(f"h_{k}", 0.0) for k, name in enumerate(joints)}


def holds_in(formulas, lines, kind, loop=False, change=1.0):
    """Violation of formulas in another geometry of the same topology."""
    names = [f"link{k}" for k in range(1, len(lines) + (not loop))]
    frames, values = frames_along(lines, names)
    values = values_of(formulas, values)
    name = formulas.free.argument_names()[0]
    values[name] *= change
    space = balance.design_space(linkage_of(lines, loop), balance=kind)
    assert space.rank == formulas.rank
    return size_of_violation(matrix(formulas, values), masses_in(frames, space))


def test_an_arm_of_two_links_as_on_paper():
    """On the second axis the outer link has its centre of mass; the inner one carries it."""
    formulas = balance.formulas(linkage_of(lines_at_random(2, 2)), "force")
    assert formulas.confirmed
    assert formulas.text().splitlines() == [
        "sx_link1 + l_link1 m_link2 = 0",
        "sx_link2 = 0",
        "sy_link1 - s_link1 sz_link2 = 0",
        "sy_link2 = 0",
    ]


CASES = [
    (3, "force", False),
    pytest.param(2, "dynamic", False, marks=pytest.mark.slow),
    pytest.param(3, "dynamic", False, marks=pytest.mark.slow),
    pytest.param(7, "force", True, marks=pytest.mark.slow),
]


@pytest.mark.parametrize(("count", "kind", "loop"), CASES)
def test_formulas_hold_in_other_geometries(count, kind, loop):
    formulas = balance.formulas(linkage_of(lines_at_random(1, count), loop), kind)
    assert formulas.confirmed and formulas.geometries == 20
    for seed in (5, 6):
        lines = lines_at_random(seed, count)
        assert holds_in(formulas, lines, kind, loop) < 1e-9
        assert holds_in(formulas, lines, kind, loop, change=1.01) > 1e-5


def loop_of_four(first, second, sides, turns):
    """Lines of a loop of four joints, from twists, lengths and two joint angles."""
    frame, lines = np.eye(4), []

    def screw(angle, length, axis):
        c, s = np.cos(angle), np.sin(angle)
        out = np.eye(4)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        out[i, i], out[i, j], out[j, i], out[j, j] = c, -s, s, c
        out[axis, 3] = length
        return out

    twists = (first, second, sides[2])
    lines.append((frame[:3, 3], frame[:3, 2]))
    for twist, length, turn in zip(twists, sides[0], (*turns, 0.0), strict=True):
        frame = frame @ screw(twist, length, 0)
        lines.append((frame[:3, 3], frame[:3, 2]))
        frame = frame @ screw(turn, 0.0, 2)
    return lines


@pytest.mark.parametrize(("first", "second", "turn"), [(0.7, 1.9, 0.9)])
def test_bennett_linkages_of_other_twists(first, second, turn):
    """G. T. Bennett, 1903: lengths are to each other as sines of twists."""
    formulas = balance.formulas("bennett", "force")
    other = 2 * np.arctan(
        np.sin((first + second) / 2) / np.sin((first - second) / 2) / np.tan(turn / 2)
    )
    a = 0.8
    b = a * np.sin(second) / np.sin(first)
    lines = loop_of_four(first, second, ((a, b, a), None, first), (turn, other))
    linkage = linkage_of(lines, loop=True)
    assert linkage.mobility == 1
    frames, values = frames_along(lines, ["crank", "coupler", "rocker"])
    space = balance.design_space(linkage, balance="force")
    assert space.rank == formulas.rank == 4 and formulas.confirmed
    assert formulas.relations[-1] == "l_coupler = l_crank s_coupler/s_crank"
    z = masses_in(frames, space)
    assert size_of_violation(matrix(formulas, values), z) < 1e-9
    assert size_of_violation(matrix(formulas, values | {"l_crank": 1.01 * a}), z) > 1e-4


def test_a_spherical_four_bar_has_no_lengths():
    formulas = balance.formulas("four_bar_spherical", "force")
    assert formulas.confirmed and len(formulas.conditions) == 5
    assert {each.kind for each in formulas.parts.dimensions} == {"angle"}
    assert "sx_coupler = 0" in formulas.text()


def test_spherical_joints_are_points():
    """A link between two points carries its mass on their line."""
    joints = [
        ScrewJoint("a", "base", "crank"),
        ScrewJoint("b", "crank", "coupler", point=(1, 0.2, 0.1), kind="spherical"),
        ScrewJoint("d", "base", "rocker", axis=(0.3, -0.2, 0.9), point=(0.3, 2, 0.4)),
    ]
    loop = ScrewJoint("c", "coupler", "rocker", point=(1.2, 1.4, 0.7), kind="spherical")
    linkage = from_screws(joints, [loop])
    formulas = balance.formulas(linkage, "force")
    assert formulas.confirmed
    assert {each.name for each in formulas.parts.dimensions} == {
        "l_crank",
        "l_coupler",
        "l_rocker",
    }
    ends = [np.array(joints[1].point), np.array(loop.point)]
    space = balance.design_space(linkage, balance="force")
    z = space.basis.reshape(3, 4, -1)[1]
    off_line = np.cross(ends[1] - ends[0], (z[1:] - np.outer(ends[0], z[0])).T)
    assert abs(off_line).max() < 1e-12
    assert {"sy_coupler = 0", "sz_coupler = 0"} <= set(formulas.text().splitlines())


def with_twice_a_term(formulas):
    first, *rest = (c for c in formulas.conditions if c.terms)
    term = first.terms[0]
    content, monomial, factors = term.coefficient
    wrong = term._replace(coefficient=Quotient(2 * content, monomial, factors))
    changed = first._replace(terms=(wrong, *first.terms[1:]))
    return tuple(changed if c is first else c for c in formulas.conditions)


@pytest.mark.parametrize(
    "model", ["four_bar_spherical", pytest.param("rusr", marks=pytest.mark.slow)]
)
def test_finite_poses_notice_a_wrong_coefficient(model):
    formulas = balance.formulas(model, "force")
    problem = problem_of(balance.design_space(model, balance="force"), force=True)
    samples = problem.samples(problem.given_relations(), None)
    samples.solved = [formulas.parameters.index(c.solved) for c in formulas.conditions]
    assert fresh_geometries(samples, formulas.parameters, formulas.conditions) == 20
    assert fresh_geometries(samples, formulas.parameters, with_twice_a_term(formulas)) == 0
    assert fresh_geometries(samples, formulas.parameters, formulas.conditions[1:]) == 0


def test_a_displaced_loop_closes_elsewhere():
    """Poses modulo p⁶: the last joint is back on its line, angles differ by multiples of p."""
    p = PRIMES_OF_61_BITS[2]
    problem = problem_of(balance.design_space("bennett", balance="force"), force=True)
    samples = problem.samples(problem.given_relations(), None)
    point = samples.free.draw(p, random.Random(1))
    values = samples.free.pairs(point, p**6)
    joints = samples.draw_joints(point, p**6)
    start = place_parts(problem.parts, values, joints, p**6)
    pose = displaced_pose(problem.parts, values, joints, p, p**6, random.Random(2))
    assert pose.last == start.last
    for part in (1, 2, 3):
        change = [a - b for a, b in zip(pose.parts[part].x, start.parts[part].x, strict=True)]
        assert any(change) and not any(x % p for x in change)


def test_relations_of_inputs():
    """Of two parallel shafts the second one turns back twice: its moment counts against."""
    joints = [
        ScrewJoint("u1", "base", "arm"),
        ScrewJoint("u2", "arm", "wheel", point=(1.0, 0.3, 0.0)),
    ]
    formulas = balance.formulas(from_screws(joints), motion="u2=-2*u1")
    assert formulas.confirmed and formulas.rank == 5
    assert "J_arm - J_wheel + l_arm^2 m_wheel = 0" in formulas.text()


@pytest.mark.slow
def test_platform_that_only_translates():
    """Four conditions of a platform that turns are gone; the formulas do not know the pose."""
    linkage = balance.load("four_rrr", inputs=["a1", "b1", "c1"])
    formulas = balance.formulas(linkage, "force", "c1=-a1-b1")
    assert formulas.confirmed and len(formulas.conditions) == 5
    assert "s_platform" not in formulas.text()


def slider_and_arm():
    return from_screws(
        [
            ScrewJoint("p", "base", "slide", axis=(1, 0, 0), kind="prismatic"),
            ScrewJoint("u", "slide", "arm", axis=(0, 1, 1), point=(0, 1, 0)),
        ]
    )


@pytest.mark.parametrize(
    ("model", "options", "problem"),
    [
        ("goldberg_five_bar", {}, "special dimensions alone"),
        ("delta", {}, "single loops"),
        ("hprs", {}, "no screws"),
        ("five_bar", {"motion": "u1=u2"}, "depend on the pose"),
        ("bennett", {"where": "l_crank=l_coupler"}, "does not hold"),
        ("bennett", {"where": "l_crank=x"}, "no dimension 'x'"),
        ("bennett", {"where": "c_crank=l_rocker"}, "an angle can only equal another angle"),
        (slider_and_arm, {"motion": "u=2*p"}, "between angles and displacements"),
    ],
)
def test_what_is_refused(model, options, problem):
    with pytest.raises(ExactError, match=problem):
        balance.formulas(model() if callable(model) else model, "force", **options)


def test_relations_in_space_are_written_with_an_equals_sign():
    with pytest.raises(UsageError, match="write AB=CD"):
        balance.formulas("bennett", "force", where="AB")


def test_equal_links_are_used_where_they_are_given():
    lines = lines_at_random(4, 2)
    _, end, _, length, _, (_, v) = normal_of(*lines)
    side = np.cross(v, [0.0, 0.6, 0.8])
    third = end + length * side / np.linalg.norm(side)
    y = np.cross(v, third - end) / length
    line = third, np.cos(1.0) * v + np.sin(1.0) * y
    arm = linkage_of([*lines, line])
    formulas = balance.formulas(arm, "force", where="AB=BC")
    assert formulas.relations == ("AB=BC",) and formulas.confirmed
    assert "l_link2" not in formulas.text()
