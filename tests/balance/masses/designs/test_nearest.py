"""The nearest design: no unit and no frame changes it, and no other design is nearer."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from balance import design_space
from balance.masses.designs.nearest import file_distance, minimise_distance
from tests.support.designs import design_of_any_density
from tests.support.laws import altered, placed, resized, words

CASES = [
    ("four_bar_antiparallelogram", None, "dynamic"),
    ("slider_crank", None, "dynamic"),
    ("three_rsr", "u2=u3", "dynamic"),
    ("four_bar_general", None, "force"),
]


def nearest(path, motion, balance, within=1.5):
    """The nearest design, by default within the balls about the links."""
    return design_of_any_density(design_space(path, motion, balance), "change", within=within)


def heavier(factor):
    """All masses in another unit."""

    def change(robot):
        for element in [*robot.iter("mass"), *robot.iter("inertia")]:
            for name, value in element.attrib.items():
                element.set(name, repr(float(value) * factor))

    return change


def turned_links(seed, slide):
    """Another frame for each link: turned, and moved along the axis of its joint."""
    rng = np.random.default_rng(seed)

    def change(robot):
        frames = {}
        for joint in robot.iter("joint"):
            H, axis = np.eye(4), joint.find("axis")
            n = np.array([float(x) for x in axis.get("xyz").split()])
            H[:3, :3] = Rotation.random(random_state=rng).as_matrix()
            H[:3, 3] = slide * rng.standard_normal() * n
            frames[joint.find("child").get("link")] = H
            axis.set("xyz", words(H[:3, :3].T @ n))
        for joint in robot.iter("joint"):
            move(
                joint,
                frames.get(joint.find("parent").get("link")),
                frames[joint.find("child").get("link")],
            )
        for link in robot.iter("link"):
            if link.find("inertial") is not None:
                move(link.find("inertial"), frames.get(link.get("name")))
        for loop in robot.iter("loop"):
            for side in ("predecessor", "successor"):
                move(loop.find(side), frames.get(loop.find(side).get("link")))

    return change


def move(element, before, after=None):
    """Write the origin of an element for another frame before it, and one behind it."""
    origin = element.find("origin")
    if origin is None:
        origin = element.makeelement("origin", {})
        element.insert(0, origin)
    H = np.eye(4)
    H[:3, 3] = [float(x) for x in origin.get("xyz", "0 0 0").split()]
    angles = [float(x) for x in origin.get("rpy", "0 0 0").split()]
    H[:3, :3] = Rotation.from_euler("xyz", angles).as_matrix()
    H = np.linalg.inv(before if before is not None else np.eye(4)) @ H
    H = H @ (after if after is not None else np.eye(4))
    origin.set("xyz", words(H[:3, 3]))
    origin.set("rpy", words(Rotation.from_matrix(H[:3, :3]).as_euler("xyz")))


def same(one, other, length=1.0, mass=1.0):
    """Whether designs are equal to 1e-8 after a change of units."""
    scale = mass * np.array([1.0, *[length] * 3, *[length**2] * 6])
    assert one.verdict == other.verdict == "feasible"
    assert other.value == pytest.approx(one.value, rel=1e-8)
    for z, expected in zip(other.z, one.z * scale, strict=True):
        size = np.array([1.0, *[length] * 3, *[length**2] * 6])
        assert np.abs((z - expected) / size).max() <= 1e-8 * np.abs(expected / size).max()


@pytest.mark.table(2)
@pytest.mark.parametrize(("model", "motion", "balance"), CASES)
def test_no_unit_changes_the_optimum(model, motion, balance, tmp_path):
    base = nearest(model, motion, balance)
    for length, mass in ((1000.0, 1.0), (0.01, 1.0), (1.0, 1000.0), (1.0, 1e-3)):
        path = altered(model, tmp_path, heavier(mass) if length == 1.0 else resized(length))
        same(base, nearest(path, motion, balance), length, mass)


@pytest.mark.table(1)
@pytest.mark.parametrize(("model", "motion", "balance"), CASES)
def test_no_link_frame_changes_the_optimum(model, motion, balance, tmp_path):
    """The balls are about the origins of joints, which only turned frames leave in place."""
    for within, slide in ((1.5, 0.0), (None, 0.3)):
        base = nearest(model, motion, balance, within)
        for seed in range(2):
            path = altered(model, tmp_path, turned_links(seed, slide))
            same(base, nearest(path, motion, balance, within))


@pytest.mark.parametrize(("model", "motion", "balance"), CASES)
def test_no_place_changes_the_distance(model, motion, balance, tmp_path):
    base = nearest(model, motion, balance)
    H = np.eye(4)
    H[:3, :3] = Rotation.from_rotvec([0.4, -1.1, 0.3]).as_matrix()
    H[:3, 3] = 2.0, -1.0, 0.5
    found = nearest(altered(model, tmp_path, placed(H)), motion, balance)
    assert found.value == pytest.approx(base.value, rel=1e-8)


def problem(rng, inequalities):
    """A random linear space of two bodies with a physical point, and inequalities there."""
    factors = rng.standard_normal((4, 4, 6))
    file, inside = np.split(factors @ factors.swapaxes(1, 2), 2)
    directions = rng.standard_normal((2, 5, 4, 4))
    lines = rng.standard_normal((inequalities, 5))
    offset = np.abs(rng.standard_normal(inequalities)) * 0.2
    return directions + directions.swapaxes(2, 3), inside, file, lines, offset


@pytest.mark.table
@pytest.mark.parametrize("inequalities", [0, 4])
@pytest.mark.parametrize("seed", range(10))
def test_a_general_solver_finds_the_same_minimum(seed, inequalities):
    cp = pytest.importorskip("cvxpy")
    blocks, inside, file, lines, offset = problem(np.random.default_rng(seed), inequalities)
    v = minimise_distance(blocks, inside, file, lines, offset, np.zeros(5))
    P = inside + np.einsum("bnij,n->bij", blocks, v)
    assert np.all(lines @ v + offset >= -1e-9)
    x = cp.Variable(5)
    sums = [inside[b] + sum(x[i] * blocks[b, i] for i in range(5)) for b in range(len(inside))]
    goal = 2.0 * sum(
        cp.trace(np.linalg.inv(file[b]) @ M) - cp.log_det(M) + np.linalg.slogdet(file[b])[1] - 4
        for b, M in enumerate(sums)
    )
    limits = [lines @ x + offset >= 0] if inequalities else []
    least = cp.Problem(cp.Minimize(goal), limits).solve(solver=cp.CLARABEL)
    assert file_distance(P, file) == pytest.approx(least, rel=1e-6)


@pytest.mark.parametrize("seed", range(5))
def test_the_gradient_vanishes_at_the_minimum(seed):
    """Against differences of the distance itself; every other point is further away."""
    rng = np.random.default_rng(seed)
    blocks, inside, file, *_ = problem(rng, 0)
    v = minimise_distance(blocks, inside, file, np.empty((0, 5)), np.empty(0), np.zeros(5))

    def value(at):
        return file_distance(inside + np.einsum("bnij,n->bij", blocks, at), file)

    for direction in np.linalg.qr(rng.standard_normal((5, 5)))[0]:
        step = 1e-3 * direction
        assert abs(value(v + step) - value(v - step)) < 1e-6 * value(v)
        assert min(value(v + step), value(v - step)) > value(v)


def test_the_distance_is_that_of_its_formula():
    """Twice x - 1 - log x for a body that is x times as heavy, in four dimensions."""
    file = np.eye(4)[None]
    assert file_distance(3.0 * file, file) == pytest.approx(8.0 * (2.0 - np.log(3.0)))
    assert file_distance(file * (1.0 + 1e-9), file) == pytest.approx(4e-18, rel=1e-6)
    assert file_distance(file, file) == 0.0
