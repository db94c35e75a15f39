"""Ranges of motion against the laws of four-bars and sliders."""

import numpy as np
import pytest

from balance.studies.discovery.job import random_starts
from balance.studies.discovery.motion_range import motion_range
from balance.studies.discovery.structure import LaneGeometry
from balance.studies.discovery.topologies import topology

pytestmark = pytest.mark.lanes


def four_bar(base, crank, coupler, rocker, angle):
    """The range of the four-bar A B C D whose crank AB is at an angle to the base AD."""
    B = crank * np.exp(1j * angle)
    along = (base - B) / abs(base - B)
    x = (coupler**2 - rocker**2 + abs(base - B) ** 2) / (2 * abs(base - B))
    C = B + along * (x + 1j * np.sqrt(coupler**2 - x**2))
    corners = np.array([0, B, C, base])
    graph = topology("four-bar")
    structure = graph.structure()
    points = np.zeros((1, 4, 3))
    points[0, :, 0], points[0, :, 1] = corners.real, corners.imag
    geometry = LaneGeometry(points[:, structure.origin], np.tile(np.eye(3)[2], (1, 4, 1)))
    return motion_range(graph, structure, structure.normalise(geometry))


@pytest.mark.slow
def test_a_joint_turns_fully_if_grashof_says_so():
    """Shortest + longest < the others, and the shortest link is at the ground, or is it."""
    rng, seen = np.random.default_rng(1), set()
    while len(seen) < 2 or seen != {True, False}:
        for _ in range(12):
            base, crank, coupler, rocker = lengths = rng.uniform(0.5, 2.0, 4)
            short, *_, long = np.sort(lengths)
            free = lengths.sum() - 2 * (short + long)
            reach = abs(base - crank * np.exp(1j))
            closes = abs(coupler - rocker) < reach < coupler + rocker
            if not closes or abs(free) < 0.05:
                continue
            found = four_bar(*lengths, 1.0)
            assert found.full == (free > 0 and short != coupler)
            seen.add(found.full)


def test_a_rocker_stops_where_coupler_and_rocker_are_in_line():
    """Dead points: BD = BC + CD for the crank, AC = AB + BC for the other ground joint."""
    base, crank, coupler, rocker = lengths = 2.0, 1.6, 1.1, 1.2
    found = four_bar(*lengths, 1.0)

    def corner(beside, opposite):
        return np.degrees(np.arccos((base**2 + beside**2 - opposite**2) / (2 * base * beside)))

    ends = {
        "A": corner(crank, coupler + rocker) - np.degrees(1.0),
        "D": corner(rocker, coupler + crank),
    }
    assert not found.full and found.ends == ("dead point", "dead point")
    if found.joint == "A":
        assert found.high == pytest.approx(ends["A"], abs=0.05)
    else:
        assert found.high - found.low == pytest.approx(2 * ends["D"], abs=0.1)


@pytest.mark.table(1)
@pytest.mark.parametrize("angle", [0.6, 1.0, 2.0])
def test_a_kite_meets_its_folded_motion(angle):
    """AD = AB: where B is at D, C may turn about both; the crank is back there after a turn."""
    found = four_bar(1.0, 1.0, 1.7, 1.7, angle)
    assert found.joint == "A" and not found.full
    assert found.ends == ("meeting of motions", "meeting of motions")
    expected = (-np.degrees(angle), 360.0 - np.degrees(angle))
    assert (found.low, found.high) == pytest.approx(expected, abs=0.05)


def test_several_degrees_of_freedom_have_no_range():
    graph = topology("3-rsr")
    structure = graph.structure()
    assert motion_range(graph, structure, random_starts(structure, 1, range(1))) is None


@pytest.mark.slow
def test_a_crank_longer_than_its_coupler_stops():
    """A crank a in line turns fully if a < b; else the sine of its angle ends at b / a."""
    graph = topology("slider-crank")
    structure = graph.structure()
    for crank, coupler in ((1.0, 1.5), (1.5, 1.0)):
        angle = 0.4
        B = crank * np.exp(1j * angle)
        C = B.real + np.sqrt(coupler**2 - B.imag**2)
        points = np.zeros((1, 4, 3))
        points[0, 1, :2], points[0, 2, 0] = (B.real, B.imag), C
        axes = np.tile(np.eye(3)[2], (1, 4, 1))
        axes[:, 3] = np.eye(3)[0]
        found = motion_range(graph, structure, LaneGeometry(points, axes))
        assert found.joint == "A" and found.full == (crank < coupler)
        if not found.full:
            end = np.degrees(np.arcsin(coupler / crank))
            expected = (-end - np.degrees(angle), end - np.degrees(angle))
            assert (found.low, found.high) == pytest.approx(expected, abs=0.05)
