"""Momentum wrenches as lines: their screws, where balanced ones meet, and their pictures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinematics
from balance import design_space
from balance.momentum import momentum_regressor
from balance.space.momentum.momentum_figure import screw_figure
from balance.space.momentum.momentum_lines import (
    ScrewLine,
    common_normal,
    meeting,
    momentum_lines,
    momentum_wrenches,
)
from kinematics.closure.joint_positions import joint_positions, si_chain
from kinematics.closure.newton import forward_kinematics
from kinematics.errors import MotionError
from tests.support.laws import MODELS, coordinates, displacement, relative, sums

# Balanced linkages of three moving bodies.
FOUR_BARS = ["four_bar_kite_balanced", "four_bar_antiparallelogram_balanced"]


def pose(linkage, seed=5, reach=0.25):
    """Random displacements of the inputs."""
    return np.random.default_rng(seed).uniform(-reach, reach, linkage.mobility)


def weighed(name, seed):
    """The linkage with random bodies of its design space; they need not be physical."""
    linkage = kinematics.load(name)
    found = design_space(linkage, spatial=True)
    z = (found.basis @ coordinates(found, seed)).reshape(len(linkage.bodies), 10)
    bodies = (replace(b, inertia=x) for b, x in zip(linkage.bodies, z, strict=True))
    return replace(linkage, bodies=tuple(bodies))


def wrench(line):
    """The wrench back from its line: force, moment of the line and moment of the pitch."""
    if np.isinf(line.pitch):
        return np.append(line.magnitude * line.direction, np.zeros(3))
    p = line.magnitude * line.direction
    return np.append(np.cross(line.point, p) + line.pitch * p, p)


def distance(line, point):
    return np.linalg.norm(np.cross(line.direction, point - line.point))


@pytest.mark.table
@pytest.mark.parametrize("name", MODELS)
def test_lines_add_up_to_the_momentum_of_the_regressor(name):
    linkage = kinematics.load(name)
    q = pose(linkage, reach=0.1)
    z = np.concatenate([body.inertia for body in linkage.bodies])
    h = momentum_regressor(linkage, q, spatial=True) @ z
    wrenches = momentum_wrenches(linkage, q)
    assert wrenches.shape == (linkage.mobility, len(linkage.bodies), 6)
    columns = momentum_lines(linkage, q)
    again = np.array([[wrench(line) for line in lines] for lines in columns])
    assert relative(again, wrenches) < 1e-11
    assert np.abs(wrenches.sum(axis=1) - h).max() < 1e-12 * np.abs(wrenches).max()
    assert [line.body for line in columns[0]] == [body.name for body in linkage.bodies]


@pytest.mark.parametrize("name", ["four_bar_general", "bennett", "hprs"])
def test_momentum_is_mass_times_the_velocity_of_the_centre(name):
    """The rate of ``m c`` of each body, by central differences of finite poses."""
    linkage = kinematics.load(name)
    u, step = pose(linkage), 1e-5
    chain = si_chain(linkage, True)

    def mass_moments(v):
        H = forward_kinematics(chain, joint_positions(linkage, v)).H
        return np.array([H[b.link][:3] @ b.inertia[[1, 2, 3, 0]] for b in linkage.bodies])

    for w, wrenches in enumerate(momentum_wrenches(linkage, u)):
        e = step * np.eye(linkage.mobility)[w]
        p = (mass_moments(u + e) - mass_moments(u - e)) / (2 * step)
        # The error of the differences is of the order of step**2, times a third derivative.
        assert relative(wrenches[:, 3:], p) < 1e-8


@pytest.mark.parametrize("name", FOUR_BARS)
def test_the_lines_of_a_balanced_four_bar_meet_in_one_moving_point(name):
    linkage = kinematics.load(name)
    met = []
    for u in (-0.3, 0.1, 0.4):
        ((*lines,),) = momentum_lines(linkage, [u])
        found = meeting(lines)
        assert all(line.pitch == 0.0 for line in lines)
        assert found.miss < 1e-10 and abs(found.point[2]) < 1e-12
        assert max(distance(line, found.point) for line in lines) == pytest.approx(
            found.miss, abs=1e-14
        )
        met.append(found.point)
    assert min(np.linalg.norm(met[0] - met[1]), np.linalg.norm(met[1] - met[2])) > 1e-2


@pytest.mark.parametrize("name", FOUR_BARS)
def test_they_do_not_meet_without_balance(name):
    """A point mass of 1 % on the coupler, one metre away, parts the lines."""
    linkage = kinematics.load(name)
    crank, coupler, rocker = linkage.bodies
    extra = sums([0.01 * coupler.inertia[0]], [[1.0, 1.0, 0.0]])
    bodies = (crank, replace(coupler, inertia=coupler.inertia + extra), rocker)
    (lines,) = momentum_lines(replace(linkage, bodies=bodies), [0.2])
    assert meeting(lines).miss > 1e-4
    (lines,) = momentum_lines(kinematics.load("four_bar_general"), [0.2])
    assert meeting(lines).miss > 1e-2


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", ["bennett", "rusr", "four_bar_spherical"])
def test_three_balanced_bodies_in_space_have_lines_on_a_cylindroid(name, seed):
    """``h1 + h2 + h3 = 0``: all three axes meet one line at right angles.

    They have pitches, of different sizes, and meet in no point.
    """
    linkage = weighed(name, seed)
    (lines,) = momentum_lines(linkage, pose(linkage))
    total = momentum_wrenches(linkage, pose(linkage)).sum(axis=1)
    assert np.abs(total).max() < 1e-11 * max(line.magnitude for line in lines)
    normal = common_normal(lines)
    for line in lines:
        assert abs(normal.direction @ line.direction) < 1e-9
        gap = np.cross(normal.direction, line.direction) @ (line.point - normal.point)
        assert abs(gap) < 1e-8 * (1.0 + np.linalg.norm(line.point))
    assert np.ptp([line.pitch for line in lines]) > 1e-3
    assert meeting(lines).miss > 1e-4


def test_lines_of_equal_pitch_meet_in_one_point():
    """Pitches alike: the wrenches less ``pitch p`` are three forces in equilibrium."""
    rng = np.random.default_rng(6)
    point, pitch = rng.standard_normal(3), 0.3
    two = rng.standard_normal((2, 3))
    forces = np.vstack([two, -two.sum(axis=0)])
    lines = [
        ScrewLine(
            "",
            point - (point @ f) * f / (f @ f),
            f / np.linalg.norm(f),
            pitch,
            float(np.linalg.norm(f)),
        )
        for f in forces
    ]
    assert sum(wrench(line) for line in lines) == pytest.approx(np.zeros(6), abs=1e-12)
    found = meeting(lines)
    assert found.miss < 1e-12
    normal = common_normal(lines)
    assert distance(normal, found.point) < 1e-12


@pytest.mark.parametrize("name", FOUR_BARS)
def test_the_meeting_point_moves_with_the_frame(name):
    linkage = kinematics.load(name)
    (lines,) = momentum_lines(linkage, [0.2])
    H = displacement(np.random.default_rng(7))
    carried = [
        line._replace(
            point=(H @ np.append(line.point, 1.0))[:3], direction=H[:3, :3] @ line.direction
        )
        for line in lines
    ]
    expected = (H @ np.append(meeting(lines).point, 1.0))[:3]
    # In space the point of the plane is the only one on all three lines.
    assert relative(meeting(carried).point, expected) < 1e-9


def test_couples_bodies_at_rest_and_parallel_lines():
    """The cranks of a parallelogram, with its coupler at rest in angle."""
    x, y = np.eye(3)[:2]
    line = ScrewLine("one", np.zeros(3), x, 0.0, 1.0)
    other = ScrewLine("two", y, -x, 0.0, 1.0)
    couple = ScrewLine("couple", np.zeros(3), y, np.inf, 1.0)
    rest = ScrewLine("rest", np.zeros(3), np.zeros(3), 0.0, 0.0)
    assert meeting([]) is None and meeting([line, couple, rest]) is None
    assert meeting([line, other, couple]) is None and common_normal([line, other]) is None
    crossing = ScrewLine("three", 2.0 * x, y, 0.0, 1.0)
    assert meeting([line, crossing, couple, rest]).point == pytest.approx(2.0 * x)
    pivots = kinematics.load("four_bar_general")
    crank = replace(pivots.bodies[0], inertia=sums([1.0, 1.0], [[1.0, 0, 0], [-1.0, 0, 0]]))
    start = next(j.point for j in pivots.joints if j.parent < 0)
    assert start == pytest.approx(np.zeros(3))
    (lines,) = momentum_lines(replace(pivots, bodies=(crank, *pivots.bodies[1:])), [0.1])
    assert np.isinf(lines[0].pitch) and lines[0].direction == pytest.approx(np.eye(3)[2])


def test_a_motion_combines_the_inputs():
    linkage = kinematics.load("five_bar")
    q = pose(linkage)
    one, other = momentum_wrenches(linkage, q)
    (both,) = momentum_wrenches(linkage, q, "u1=-u2")
    expected = one - other
    assert min(relative(both, expected), relative(-both, expected)) < 1e-12
    with pytest.raises(MotionError):
        momentum_wrenches(linkage, q, "u1=nothing")


@pytest.mark.slow
@pytest.mark.table(1)
@pytest.mark.parametrize("name", ["four_bar_kite_balanced", "bennett", "three_rsr"])
def test_the_picture_shows_every_moving_body(name, tmp_path):
    pytest.importorskip("matplotlib")
    linkage = kinematics.load(name)
    figure = screw_figure(linkage, pose(linkage))
    (axes,) = figure.axes
    labels = [line.get_label() for line in axes.get_lines()]
    (lines,) = momentum_lines(linkage, pose(linkage))[:1]
    for line in lines:
        shown = any(label.startswith(line.body) for label in labels)
        assert shown == (line.magnitude > 0.0 and np.isfinite(line.pitch))
    assert ("meeting point" in labels) == name.endswith("balanced")
    assert (axes.name == "3d") == (not linkage.planar)
    path = tmp_path / "lines.svg"
    figure.savefig(path)
    assert path.stat().st_size > 5000
    with pytest.raises(IndexError):
        screw_figure(linkage, pose(linkage), column=linkage.mobility)
